//! One to three steps, or a ramp, before some doors. They begin at the door, so the ground before
//! them stays free, and a robot delivers at their foot.

use openbench_geometry::Segment;

use super::kinds::Footprint;
use super::passage::stays_open;
use super::relief::{Entry, Form, HALF_WIDTH_M, PLATFORM_M, RAMP_M, RISE_M, TREAD_M};
use super::site::{Site, keeps_off_gates, leaves_door, shifted};
use super::streams::{Purpose, place_number, stream};
use crate::generate::doors::doorway::Doorway;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BARRIER, BUILDING, DRIVEWAY, ROAD, START, WATER};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{chance, pick};
use crate::generate::shapes::{Block, Surface, at, cuboid, facet};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// Share of the doors with steps or a ramp where there is most relief.
const SHARE: f64 = 0.6;
/// Doors nearer to each other than this have no steps, metres.
const APART_M: f64 = 2.4;
/// Free ground before the lowest step, metres.
const BEFORE_M: f64 = 1.3;
/// Steps as frequent as they are here; a ramp has the height of one.
const FORMS: [Form; 8] = [
    Form::Steps(1),
    Form::Steps(2),
    Form::Ramp,
    Form::Steps(1),
    Form::Steps(3),
    Form::Steps(1),
    Form::Ramp,
    Form::Steps(2),
];

/// Draws which doors have steps.
pub(super) fn plan(site: &Site, occupied: &mut Occupied) -> Vec<Entry> {
    let mut entries = Vec::new();
    for door in site.doorways {
        let mut rng = stream(
            site.options.seed,
            Purpose::Steps,
            place_number(door.position),
        );
        let is_wanted = chance(&mut rng, SHARE * site.options.amounts.relief);
        let entry = Entry::new(door.pose(), pick(&mut rng, &FORMS));
        if is_wanted && has_room(site, door, &entry) {
            let ground = entry.footprint();
            if stays_open(occupied, ground.axis, ground.radius) {
                occupied.add(ground.axis, ground.radius);
                entries.push(entry);
            }
        }
    }
    entries
}

fn has_room(site: &Site, door: &Doorway, entry: &Entry) -> bool {
    let alone = site.doorways.iter().all(|other| {
        let apart = other.position.distance(door.position);
        apart > APART_M || other.position == door.position
    });
    // From a little before the wall on, which is a building itself.
    let before = Segment::new(
        entry.door.transform(HALF_WIDTH_M + 0.1, 0.0),
        entry
            .door
            .transform(entry.depth + BEFORE_M - HALF_WIDTH_M, 0.0),
    );
    let steps = Segment::new(
        entry.door.transform(HALF_WIDTH_M + 0.1, 0.0),
        entry
            .door
            .transform(entry.depth.max(HALF_WIDTH_M + 0.1), 0.0),
    );
    let in_the_way = ROAD | DRIVEWAY | START;
    let Footprint { axis, radius } = entry.footprint();
    let mut others = site
        .doorways
        .iter()
        .filter(|other| other.position != door.position);
    alone
        && keeps_off_gates(site.gates, axis, radius)
        && others.all(|other| leaves_door(other, axis, radius))
        && site
            .clearance
            .is_free(before, HALF_WIDTH_M, BUILDING | BARRIER | WATER)
        && site.clearance.is_free(steps, 0.3, in_the_way)
}

/// Builds the steps and ramps.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    for entry in &inputs.relief.entries {
        // Of a full world too: its doors are lifted all the same.
        out.scene.begin_object("steps", SemanticClass::Pavement);
        let stone = inputs.palette.doorstep;
        match entry.form {
            Form::Steps(count) => {
                flight(&mut out.scene, stone, entry, count);
                out.drawn_scenery.steps += 1;
            }
            Form::Ramp => {
                ramp(&mut out.scene, stone, entry);
                out.drawn_scenery.ramps += 1;
            }
        }
    }
}

fn flight(scene: &mut SceneBuilder, stone: Surface, entry: &Entry, count: u8) {
    for step in 0..count {
        // From the lowest on; each is a block that reaches back to the wall.
        let reach = entry.depth - TREAD_M * f64::from(step);
        let from = if step + 1 < count {
            reach - TREAD_M
        } else {
            0.0
        };
        let block = Block {
            min: [from, -HALF_WIDTH_M, 0.0],
            max: [reach, HALF_WIDTH_M, RISE_M * f64::from(step + 1)],
        };
        cuboid(scene, Layer::Both, stone, entry.door, block);
    }
}

fn ramp(scene: &mut SceneBuilder, stone: Surface, entry: &Entry) {
    let platform = Block {
        min: [0.0, -HALF_WIDTH_M, 0.0],
        max: [PLATFORM_M, HALF_WIDTH_M, entry.lift],
    };
    cuboid(scene, Layer::Both, stone, entry.door, platform);
    let top = shifted(entry.door, PLATFORM_M, 0.0);
    let point = |forward: f64, left: f64, up: f64| at(top.transform(forward, left), up);
    let (half, lift) = (HALF_WIDTH_M, entry.lift);
    let slope = [
        point(0.0, -half, lift),
        point(RAMP_M, -half, 0.0),
        point(RAMP_M, half, 0.0),
        point(0.0, half, lift),
    ];
    facet(scene, Layer::Both, stone, &slope);
    for side in [-1.0, 1.0] {
        let cheek = [
            point(0.0, side * half, 0.0),
            point(RAMP_M, side * half, 0.0),
            point(0.0, side * half, lift),
        ];
        let [a, b, c] = cheek;
        let seen = if side < 0.0 { [a, b, c] } else { [a, c, b] };
        facet(scene, Layer::Both, stone, &seen);
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::Pose2;

    use super::*;

    #[test]
    fn footprints_hold_the_corners() {
        for form in FORMS {
            let entry = Entry::new(Pose2::new(3.0, 1.0, 0.7), form);
            let Footprint { axis, radius } = entry.footprint();
            for forward in [0.0, entry.depth] {
                for left in [-HALF_WIDTH_M, HALF_WIDTH_M] {
                    let corner = entry.door.transform(forward, left);
                    assert!(axis.distance_to_point(corner) <= radius, "{form:?}");
                }
            }
        }
    }

    #[test]
    fn three_steps_lift_a_door_by_three_rises() {
        let entry = Entry::new(Pose2::default(), Form::Steps(3));
        assert!((entry.lift - 0.45).abs() < 1e-12);
        assert!((entry.depth - 1.6).abs() < 1e-12);
        let ramp = Entry::new(Pose2::default(), Form::Ramp);
        assert!((ramp.lift - RISE_M).abs() < 1e-12 && ramp.depth > 1.9);
    }
}
