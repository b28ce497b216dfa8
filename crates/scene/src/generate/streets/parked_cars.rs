//! Parked cars: along the kerb where the map allows it, and in car parks; never on a pavement, a
//! path or in front of a door.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Point3;
use openbench_core::Pose2;
use openbench_geometry::{Polygon, Segment, segments};
use openbench_osm::{Road, Tags, draws};
use rand_pcg::Pcg64Mcg;

use super::car::{self, Car, HALF_LENGTH_M, HALF_WIDTH_M};
use super::car_shapes;
use super::profile::profile;
use super::stripes;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{
    BARRIER, BUILDING, DOOR, DRIVEWAY, Kinds, OBJECT, PATH, ROAD, START,
};
use crate::generate::layout::extent::GROUND_MARGIN_M;
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, chance, element_number, stream};
use crate::material::SemanticClass;
use crate::plates::{SignKind, TypefaceSet, Wear, draw_sign};

/// Length of a place along the kerb, metres.
const KERB_PLACE_M: f64 = 6.0;
/// Distance of a car from the kerb, metres.
const FROM_KERB_M: f64 = 0.13;
/// Narrowest carriageway with parked cars, metres.
const NARROWEST_M: f64 = 5.0;
/// No car this near to the end of a way, metres: there may be a junction.
const CORNER_M: f64 = 8.0;
/// No car this near to a bend, metres.
const BEND_M: f64 = 3.0;
/// Width of a place in a car park, metres.
const PLACE_WIDTH_M: f64 = 2.6;
/// Length of a place in a car park, metres.
const PLACE_LENGTH_M: f64 = 5.0;
/// Width of the aisle between rows, metres.
const AISLE_M: f64 = 6.0;
/// Depth of a car park at most, metres.
const DEEPEST_M: f64 = 500.0;
/// Stream of random numbers of number plates.
const NUMBER_PLATE_STREAM: u64 = 104;
/// Height of the middle of number plates, metres.
const NUMBER_PLATE_M: f64 = 0.45;
/// What no parked car may stand on or touch.
const IN_THE_WAY: Kinds = PATH | DOOR | OBJECT | START | BARRIER | BUILDING;

/// Builds the parked cars and the lines of car parks.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let mut parking = Parking {
        inputs,
        occupied,
        out,
    };
    for road in &inputs.map.roads {
        let mut rng = stream(inputs.seed, Purpose::Cars, road.way as u64);
        parking.along_kerbs(road, &mut rng);
    }
    for area in inputs.map.areas.iter().filter(|a| is_car_park(&a.tags)) {
        // The highest bit keeps car parks apart from roads, which are numbered by their ways.
        let element = element_number(area.element) | 1 << 63;
        let mut rng = stream(inputs.seed, Purpose::Cars, element);
        parking.car_park(&area.polygon, &mut rng);
    }
}

fn is_car_park(tags: &Tags) -> bool {
    tags.is("amenity", "parking") && !tags.is("parking", "underground")
}

struct Parking<'a, 'b> {
    inputs: &'a Inputs<'a>,
    occupied: &'a mut Occupied<'b>,
    out: &'a mut Output,
}

impl Parking<'_, '_> {
    fn along_kerbs(&mut self, road: &Road, rng: &mut Pcg64Mcg) {
        let profile = profile(&road.tags);
        let Some(profile) = profile.filter(|p| p.for_cars && p.width >= NARROWEST_M) else {
            return;
        };
        let shares = kerb_shares(&road.tags);
        let count = road.points.len();
        for (i, segment) in segments(&road.points).enumerate() {
            let length = segment.length();
            let first = if i == 0 { CORNER_M } else { BEND_M };
            let last = if i + 2 == count { CORNER_M } else { BEND_M };
            let places = ((length - first - last) / KERB_PLACE_M).clamp(0.0, 1_000.0) as usize;
            for (side, share) in [1.0, -1.0].into_iter().zip(shares) {
                let from_middle = profile.width / 2.0 - HALF_WIDTH_M - FROM_KERB_M;
                for place in 0..places {
                    // Drawn for every place, also where no car may stand.
                    let taken = chance(rng, share * self.share());
                    let run = first + (place as f64 + 0.5) * KERB_PLACE_M;
                    let pose = at_kerb(segment, run / length, side, from_middle);
                    // Not ROAD: the car stands on it.
                    self.car_if(taken, pose, IN_THE_WAY | DRIVEWAY, rng);
                }
            }
        }
    }

    /// Share of the places that are taken.
    fn share(&self) -> f64 {
        self.inputs.options.parked_cars.clamp(0.0, 1.0)
    }

    fn car_park(&mut self, polygon: &Polygon, rng: &mut Pcg64Mcg) {
        let sides = polygon.sides();
        let longest = sides.max_by(|s, t| s.length().total_cmp(&t.length()));
        let Some(longest) = longest else { return };
        let origin = longest.pose();
        // Rows run along the longest side; the depth is measured inwards from it.
        let depths = polygon.outer.iter().map(|p| origin.inverse_transform(*p).1);
        let depth = depths.fold(0.0, f64::max).min(DEEPEST_M);
        let columns = ((longest.length() - 0.4) / PLACE_WIDTH_M).min(200.0) as usize;
        let mut from = 0.1;
        let mut row = 0;
        while from + PLACE_LENGTH_M < depth {
            for column in 0..columns {
                let along = (column as f64 + 0.5) * PLACE_WIDTH_M + 0.2;
                let p = origin.transform(along, from + PLACE_LENGTH_M / 2.0);
                let turn = if chance(rng, 0.5) {
                    FRAC_PI_2
                } else {
                    -FRAC_PI_2
                };
                let pose = Pose2::new(p.x, p.y, origin.yaw + turn);
                let taken = chance(rng, self.share());
                let free = is_inside(polygon, pose)
                    && self.occupied.is_free_at(p, 1.2, ROAD | PATH | BUILDING);
                if free {
                    self.place_lines(pose);
                    // The aisles of a car park are often mapped as roads, and stay free.
                    self.car_if(taken, pose, IN_THE_WAY | ROAD, rng);
                }
            }
            // Row, aisle, row, row back to back, aisle, …
            from += PLACE_LENGTH_M + if row % 2 == 0 { AISLE_M } else { 0.1 };
            row += 1;
        }
    }

    fn place_lines(&mut self, pose: Pose2) {
        self.out
            .scene
            .begin_object("parking place", SemanticClass::Road);
        for side in [-1.0, 1.0] {
            let p = pose.transform(0.0, side * PLACE_WIDTH_M / 2.0);
            let line = Pose2::new(p.x, p.y, pose.yaw);
            stripes::paint(self.inputs, self.out, line, PLACE_LENGTH_M - 0.4, 0.1);
        }
    }

    /// Parks a car if the place is taken, and nothing of `kinds` is in the way.
    fn car_if(&mut self, taken: bool, pose: Pose2, kinds: Kinds, rng: &mut Pcg64Mcg) {
        let half = HALF_LENGTH_M - HALF_WIDTH_M;
        // A capsule as long and as wide as the car.
        let axis = Segment::new(pose.transform(half, 0.0), pose.transform(-half, 0.0));
        let near = self
            .inputs
            .extent
            .holds(pose.point(), GROUND_MARGIN_M / 2.0);
        let wanted = taken && near && !self.out.is_full();
        if wanted && self.occupied.is_free(axis, HALF_WIDTH_M + 0.02, kinds) {
            self.out.scene.begin_object("car", SemanticClass::Vehicle);
            let car = car::draw(&self.inputs.palette, rng);
            let (car, axis) = self.shaped(car, axis, kinds);
            car.build(&mut self.out.scene, pose);
            self.number_plates(&car, pose);
            self.occupied.add(axis, HALF_WIDTH_M);
        }
    }
}

impl Parking<'_, '_> {
    /// The car in another shape, where streets differ, with the ground that it then takes.
    fn shaped(&mut self, car: Car, axis: Segment, kinds: Kinds) -> (Car, Segment) {
        let Some(other) = car_shapes::at_place(self.inputs, axis.middle()) else {
            return (car, axis);
        };
        let middle = axis.middle();
        let longer = |half_length: f64| {
            let half = half_length - HALF_WIDTH_M;
            let yaw = axis.bearing();
            Segment::new(middle.offset(yaw, -half), middle.offset(yaw, half))
        };
        let has_room = |half_length: f64| {
            let axis = longer(half_length);
            // Not in car parks, whose places are for cars.
            kinds & ROAD == 0 && self.occupied.is_free(axis, HALF_WIDTH_M + 0.02, kinds)
        };
        let fitted = other.fitting(has_room);
        self.out.drawn_scenery.cars += 1;
        (car.shaped(fitted.shape), longer(fitted.half_length))
    }

    /// The number plates of a car, in worlds with plates as in streets.
    fn number_plates(&mut self, car: &Car, pose: Pose2) {
        let plates = &self.inputs.options.plates;
        if !plates.shares.real || plates.shares.signs <= 0.0 {
            return;
        }
        // By its place: other cars do not change it.
        let place = pose.x.to_bits() ^ pose.y.to_bits().rotate_left(32);
        let draws = &mut draws::stream(plates.seed, NUMBER_PLATE_STREAM, place);
        let language = self.inputs.neighbourhood.language();
        let set = TypefaceSet::of_seed(plates.seed);
        let sign = draw_sign(SignKind::Car, language, "", draws, set);
        let face = self.out.street_face(
            SemanticClass::Vehicle,
            &sign.design,
            &sign.lines,
            &[],
            Wear::default(),
        );
        let [back, front] = car.ends(NUMBER_PLATE_M);
        for (end, yaw) in [(front, pose.yaw), (back, pose.yaw + PI)] {
            let at = pose.transform(end, 0.0);
            let outward = Pose2::new(at.x, at.y, yaw);
            let middle = Point3::new(0.01, 0.0, NUMBER_PLATE_M);
            face.hang(&mut self.out.scene, outward, middle, 0.0);
            self.out.drawn_plates.signs += 1;
        }
    }
}

/// A car at the left kerb of a segment if `side` is 1, at the right one if it is -1. Traffic is on
/// the right: cars on the left of the way look back along it.
fn at_kerb(segment: Segment, share: f64, side: f64, from_middle: f64) -> Pose2 {
    let p = segment.at(share);
    let yaw = segment.bearing();
    let p = Pose2::new(p.x, p.y, yaw).transform(0.0, side * from_middle);
    Pose2::new(p.x, p.y, if side > 0.0 { yaw + PI } else { yaw })
}

/// Probability that a place on the left and on the right is for parking.
fn kerb_shares(tags: &Tags) -> [f64; 2] {
    let allowed = |side: &str| {
        let keys = [
            format!("parking:{side}"),
            "parking:both".into(),
            format!("parking:lane:{side}"),
            "parking:lane:both".into(),
        ];
        let value = keys.iter().find_map(|key| tags.get(key));
        value.map(|v| !v.starts_with("no") && v != "separate")
    };
    let is_quiet = ["residential", "living_street"]
        .iter()
        .any(|k| tags.is("highway", k));
    match ["left", "right"].map(allowed) {
        // Without tags cars stand on one side only, so that traffic can still pass.
        [None, None] => [0.0, if is_quiet { 0.2 } else { 0.0 }],
        tagged => tagged.map(|t| if t == Some(true) { 1.0 } else { 0.0 }),
    }
}

/// Whether a car would stand inside of a car park.
fn is_inside(polygon: &Polygon, pose: Pose2) -> bool {
    let (x, y) = (HALF_LENGTH_M + 0.1, HALF_WIDTH_M + 0.1);
    let corners = [[x, y], [x, -y], [-x, y], [-x, -y]];
    corners
        .iter()
        .all(|[x, y]| polygon.contains(pose.transform(*x, *y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_decides_where_cars_park() {
        let sides = Tags::from([("parking:left", "lane"), ("parking:right", "no")]);
        assert_eq!(kerb_shares(&sides), [1.0, 0.0]);
        assert_eq!(
            kerb_shares(&Tags::from([("parking:both", "no")])),
            [0.0, 0.0]
        );
        assert!(kerb_shares(&Tags::from([("highway", "residential")]))[1] > 0.0);
        assert_eq!(
            kerb_shares(&Tags::from([("highway", "primary")])),
            [0.0, 0.0]
        );
    }
}
