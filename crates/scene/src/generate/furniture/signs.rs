//! Other text on walls and poles: shop signs, posters, graffiti, notices, street names, parking.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::Point3;
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::line::length;
use openbench_geometry::{Segment, segments};
use openbench_osm::{Building, Road, draws};
use rand_pcg::Pcg64Mcg;

use crate::generate::buildings::house::is_open_below;
use crate::generate::buildings::walls::walls;
use crate::generate::doors::doorway::Doorway;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{
    BARRIER, BUILDING, DOOR, DRIVEWAY, Kinds, OBJECT, ROAD, START, WATER,
};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{between, chance, element_number, pick};
use crate::generate::shapes::{Frustum, frustum};
use crate::generate::streets::profile::profile;
use crate::material::SemanticClass;
use crate::plates::{SignKind, TypefaceSet, Wear, draw_sign};
use crate::scene::Layer;

/// Stream of random numbers.
const SIGN_STREAM: u64 = 103;
/// Shortest wall with anything on it, metres.
const SHORTEST_WALL_M: f64 = 3.5;
/// Distance of a pole from the edge of the road, metres.
const FROM_KERB_M: f64 = 0.4;
/// Length of street with one parking sign, metres.
const BETWEEN_PARKING_M: f64 = 45.0;
/// Height of the middle of a sign on a pole, metres.
const ON_POLE_M: f64 = 2.35;
/// Height of a pole, metres.
const POLE_M: f64 = 2.6;
/// Radius of a pole, metres.
const POLE_RADIUS_M: f64 = 0.03;
/// What no pole may stand on. Pavements may have poles near the kerb.
const IN_THE_WAY: Kinds = BUILDING | BARRIER | ROAD | DOOR | OBJECT | START | DRIVEWAY | WATER;

/// Builds the signs of a world with plates as in streets.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let plates = &inputs.options.plates;
    if !plates.shares.real || plates.shares.signs <= 0.0 {
        return;
    }
    let mut doors: BTreeMap<usize, Vec<&Doorway>> = BTreeMap::new();
    for door in &inputs.doorways {
        doors.entry(door.building).or_default().push(door);
    }
    for (index, building) in inputs.map.buildings.iter().enumerate() {
        // Sheds, garages and roofs have no doors, and some of them no walls.
        if let Some(own) = doors.get(&index).filter(|_| !is_open_below(&building.tags)) {
            on_walls(inputs, out, building, own);
        }
    }
    for road in &inputs.map.roads {
        on_poles(inputs, occupied, out, road);
    }
}

/// A sign at a place of a wall or pole, with `room` metres on either side of its middle.
#[expect(
    clippy::too_many_arguments,
    reason = "what, where, and the stream that draws it"
)]
fn hang(
    inputs: &Inputs,
    out: &mut Output,
    kind: SignKind,
    street: &str,
    place: Pose2,
    back: Point3<f64>,
    room: f64,
    draws: &mut Pcg64Mcg,
) {
    let set = TypefaceSet::of_seed(inputs.options.plates.seed);
    let language = inputs.neighbourhood.language();
    let sign = draw_sign(kind, language, street, draws, set);
    let dirt = pick(draws, &[0.0, 0.125, 0.25]);
    let tilt = match kind {
        SignKind::Graffiti => between(draws, -0.25, 0.25),
        SignKind::Poster => between(draws, -0.04, 0.04),
        _ => 0.0,
    };
    if !sign.lines.iter().all(|line| sign.design.has(&line.text)) {
        return;
    }
    let class = SemanticClass::Furniture;
    let wear = Wear { dirt, glare: None };
    let face = out.street_face(class, &sign.design, &sign.lines, &[], wear);
    // Nothing sticks out beyond the corner of a wall.
    if face.size.width_m / 2.0 > room {
        return;
    }
    face.hang(&mut out.scene, place, back, tilt);
    out.drawn_plates.signs += 1;
}

fn on_walls(inputs: &Inputs, out: &mut Output, building: &Building, doors: &[&Doorway]) {
    let plates = &inputs.options.plates;
    let element = element_number(building.element);
    let draws = &mut draws::stream(plates.seed, SIGN_STREAM, element);
    for wall in walls(building) {
        // Drawn for every wall, also where nothing fits.
        let wanted = chance(draws, 0.5 * plates.shares.signs);
        let kind = pick(
            draws,
            &[
                SignKind::Poster,
                SignKind::Poster,
                SignKind::Graffiti,
                SignKind::Shop,
            ],
        );
        let share = between(draws, 0.2, 0.8);
        let up = match kind {
            SignKind::Shop => 2.75,
            SignKind::Graffiti => between(draws, 0.7, 1.3),
            _ => between(draws, 1.1, 1.5),
        };
        let along = share * wall.length();
        let span = along - 1.5..along + 1.5;
        let free = |taken: Range<f64>| taken.end < span.start || taken.start > span.end;
        let is_clear = doors.iter().filter_map(|door| door.span_on(wall)).all(free);
        let before = wall.facing_out(share);
        let is_seen = inputs.clearance.is_free(
            Segment::new(before.transform(0.5, 0.0), before.transform(1.5, 0.0)),
            0.3,
            BUILDING,
        );
        let is_high = kind != SignKind::Shop || has_upper_floor(building);
        let is_clear = is_clear && is_seen && is_high;
        let fits = wall.length() > SHORTEST_WALL_M && is_clear && !out.is_full();
        if wanted && fits {
            out.scene.begin_object("sign", SemanticClass::Furniture);
            hang(
                inputs,
                out,
                kind,
                "",
                before,
                Point3::new(0.05, 0.0, up),
                along.min(wall.length() - along) - 0.1,
                draws,
            );
        }
    }
    for door in doors {
        let wanted = chance(draws, 0.3 * plates.shares.signs);
        if wanted && !out.is_full() {
            // On the leaf, at the height of a letter box.
            out.scene.begin_object("sign", SemanticClass::Furniture);
            let back = Point3::new(0.06, 0.0, 1.05);
            hang(
                inputs,
                out,
                SignKind::Notice,
                "",
                door.pose(),
                back,
                f64::INFINITY,
                draws,
            );
        }
    }
}

/// Whether a shop's sign fits above its ground floor, unless the map says that there is no more.
fn has_upper_floor(building: &Building) -> bool {
    let number = |key: &str| {
        building
            .tags
            .get(key)
            .and_then(|text| text.parse::<f64>().ok())
    };
    let is_lower = |key: &str, least: f64| number(key).is_some_and(|value| value < least);
    !is_lower("building:levels", 2.0) && !is_lower("height", 4.0)
}

fn on_poles(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output, road: &Road) {
    let Some(profile) = profile(&road.tags).filter(|profile| profile.for_cars) else {
        return;
    };
    let plates = &inputs.options.plates;
    let draws = &mut draws::stream(plates.seed, SIGN_STREAM, road.way as u64 | 1 << 63);
    let aside = profile.width / 2.0 + FROM_KERB_M;
    let name = road.tags.get("name").unwrap_or_default();
    let whole = length(&road.points);
    // A few metres from the junctions at both ends.
    for run in [6.0, whole - 6.0] {
        let wanted = chance(draws, plates.shares.signs.sqrt());
        if wanted && !name.is_empty() && whole > 12.0 {
            // Along the street, so that those who cross it read it.
            if let Some(place) = beside(&road.points, run, aside) {
                pole(inputs, occupied, out, SignKind::Street, name, place, draws);
            }
        }
    }
    let count = (whole / BETWEEN_PARKING_M).min(100.0) as usize;
    for i in 0..count {
        let wanted = chance(draws, 0.6 * plates.shares.signs);
        let run = (i as f64 + 0.5) * BETWEEN_PARKING_M;
        if let Some(place) = beside(&road.points, run, aside).filter(|_| wanted) {
            pole(inputs, occupied, out, SignKind::Parking, "", place, draws);
        }
    }
}

/// The place `run` metres along a line and `aside` metres to its right, facing along it; `None`
/// beyond its end.
fn beside(points: &[MapPoint], run: f64, aside: f64) -> Option<Pose2> {
    let mut before = 0.0;
    for segment in segments(points) {
        let after = before + segment.length();
        if run <= after && after > before {
            let foot = segment.pose().transform(run - before, -aside);
            return Some(Pose2::new(foot.x, foot.y, segment.bearing()));
        }
        before = after;
    }
    None
}

/// A pole with a sign, if there is room for it.
fn pole(
    inputs: &Inputs,
    occupied: &mut Occupied,
    out: &mut Output,
    kind: SignKind,
    street: &str,
    place: Pose2,
    draws: &mut Pcg64Mcg,
) {
    let foot = place.point();
    let is_free = occupied.is_free_at(foot, 0.05, IN_THE_WAY);
    if !is_free || !inputs.is_on_ground(foot) || out.is_full() {
        return;
    }
    out.scene.begin_object("sign", SemanticClass::Furniture);
    let column = Frustum {
        center: foot,
        sides: 6,
        z: 0.0..POLE_M,
        radii: [POLE_RADIUS_M, POLE_RADIUS_M],
    };
    frustum(&mut out.scene, Layer::Both, inputs.palette.metal, column);
    let back = Point3::new(POLE_RADIUS_M, 0.0, ON_POLE_M);
    // Both sides say the same.
    let other = Pose2::new(place.x, place.y, place.yaw + std::f64::consts::PI);
    let mut again = draws.clone();
    let room = f64::INFINITY;
    hang(inputs, out, kind, street, other, back, room, &mut again);
    hang(inputs, out, kind, street, place, back, room, draws);
    occupied.add_disc(foot, 0.2);
}
