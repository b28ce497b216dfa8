//! Where things stand in the way: beside doors, at walls, on pavements. Never on carriageways,
//! paths and driveways, in gates, or where they would shut a way.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::Road;
use rand_pcg::Pcg64Mcg;

use super::kinds::{AT_WALLS, BESIDE_DOORS, Footprint, Kind, ON_PAVEMENTS, Thing};
use super::passage::stays_open;
use super::site::{DOOR_LANE_M, gates, keeps_off_gates, leaves_door};
use super::streams::{Purpose, place_number, stream};
use super::things::{Piece, build as build_thing};
use crate::generate::buildings::house::is_open_below;
use crate::generate::buildings::walls::walls;
use crate::generate::doors::doorway::Doorway;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{
    BARRIER, BUILDING, DOOR, DRIVEWAY, Kinds, OBJECT, PATH, PAVED, ROAD, START, WATER,
};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{between, chance, element_number, pick};
use crate::generate::streets::profile::profile;

/// Share of the doors with a thing beside them where there is most clutter.
const BESIDE_DOOR: f64 = 0.8;
/// Share of the places at walls with a thing where there is most clutter.
const AT_WALL: f64 = 0.35;
/// Share of the places on pavements with a thing where there is most clutter.
const ON_PAVEMENT: f64 = 0.4;
/// Distance between places at walls, metres.
const WALL_SPACING_M: f64 = 4.0;
/// Distance between places on pavements, metres.
const PAVEMENT_SPACING_M: f64 = 9.0;
/// Places along one wall or stretch of pavement at most.
const MOST_PLACES: usize = 200;
/// Distance of a thing from its wall or kerb, metres.
const FROM_WALL_M: f64 = 0.08;
/// Free ground around a thing, metres.
const AROUND_M: f64 = 0.05;
/// A plate nearer than this to the door's middle has no room for a plant before it, metres.
const LEAST_OFFSET_M: f64 = 0.8;
/// What no thing stands on or touches.
const IN_THE_WAY: Kinds = BUILDING | BARRIER | ROAD | PATH | DRIVEWAY | START | OBJECT | WATER;

/// Builds the things in the way.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let amount = inputs.options.scenery.amounts.clutter;
    if amount <= 0.0 {
        return;
    }
    let mut street = Street {
        inputs,
        occupied,
        out,
        amount,
        gates: gates(inputs.map),
    };
    for door in &inputs.doorways {
        street.beside_door(door);
    }
    for building in &inputs.map.buildings {
        // There are no walls at the ground, and robots drive through.
        if is_open_below(&building.tags) {
            continue;
        }
        let element = element_number(building.element);
        for (number, wall) in (0_u64..).zip(walls(building)) {
            // No building has as many walls as the second factor.
            street.at_wall(wall, element.wrapping_mul(4096).wrapping_add(number));
        }
    }
    for road in &inputs.map.roads {
        street.on_pavements(road);
    }
}

struct Street<'a, 'b> {
    inputs: &'a Inputs<'a>,
    occupied: &'a mut Occupied<'b>,
    out: &'a mut Output,
    amount: f64,
    gates: Vec<MapPoint>,
}

impl Street<'_, '_> {
    fn stream(&self, purpose: Purpose, element: u64) -> Pcg64Mcg {
        stream(self.inputs.options.scenery.seed, purpose, element)
    }

    fn beside_door(&mut self, door: &Doorway) {
        let mut rng = self.stream(Purpose::BesideDoor, place_number(door.position));
        let is_wanted = chance(&mut rng, BESIDE_DOOR * self.amount);
        let thing = pick(&mut rng, &BESIDE_DOORS).draw(&mut rng);
        let side = pick(&mut rng, &[-1.0, 1.0]);
        let gap = between(&mut rng, 0.05, 0.5);
        if !is_wanted {
            return;
        }
        let hides_plate = thing.kind == Kind::TallPlant && door.plate_offset.abs() > LEAST_OFFSET_M;
        let left = if hides_plate {
            door.plate_offset
        } else {
            side * (DOOR_LANE_M + thing.reach_along() + gap)
        };
        let is_built = self.place(&thing, at_foot(door.pose(), left, &thing), 0, &mut rng);
        if is_built {
            self.out.drawn_scenery.beside_doors += 1;
            self.out.drawn_scenery.before_plates += usize::from(hides_plate);
        }
    }

    fn at_wall(&mut self, wall: Segment, number: u64) {
        let mut rng = self.stream(Purpose::AtWall, number);
        let length = wall.length();
        let places = ((length / WALL_SPACING_M) as usize).min(MOST_PLACES);
        for i in 0..places {
            let share = (i as f64 + between(&mut rng, 0.2, 0.8)) / places as f64;
            let is_wanted = chance(&mut rng, AT_WALL * self.amount);
            let thing = pick(&mut rng, &AT_WALLS).draw(&mut rng);
            // Longer than its wall, it would stand out around the corner.
            if is_wanted && thing.half.along * 2.0 < length {
                let pose = at_foot(wall.facing_out(share), 0.0, &thing);
                self.place(&thing, pose, DOOR, &mut rng);
            }
        }
    }

    fn on_pavements(&mut self, road: &Road) {
        let Some(profile) = profile(&road.tags).filter(|p| p.for_cars && p.pavement > 0.0) else {
            return;
        };
        let mut rng = self.stream(Purpose::OnPavement, road.way as u64);
        for segment in segments(&road.points) {
            let places = ((segment.length() / PAVEMENT_SPACING_M) as usize).min(MOST_PLACES);
            for i in 0..places {
                for (side, has_pavement) in [1.0, -1.0].into_iter().zip(profile.sides) {
                    let share = (i as f64 + between(&mut rng, 0.1, 0.9)) / places as f64;
                    let is_wanted = chance(&mut rng, ON_PAVEMENT * self.amount);
                    let thing = pick(&mut rng, &ON_PAVEMENTS).draw(&mut rng);
                    if !is_wanted || !has_pavement {
                        continue;
                    }
                    // Its back to the carriageway.
                    let along = segment.at(share);
                    let left_of_road = Pose2::new(along.x, along.y, segment.bearing());
                    // The ground that it takes is rounder than the thing itself.
                    let rounding = thing.reach_out() - thing.half.out;
                    let from_middle = profile.width / 2.0 + 0.15 + rounding;
                    let kerb = left_of_road.transform(0.0, side * from_middle);
                    let out = segment.bearing() + side * std::f64::consts::FRAC_PI_2;
                    let pose = at_foot(Pose2::new(kerb.x, kerb.y, out), 0.0, &thing);
                    self.place(&thing, pose, DOOR, &mut rng);
                }
            }
        }
    }

    /// Builds a thing where nothing is in its way, of `more` kinds either, and it is in nobody's.
    fn place(&mut self, thing: &Thing, pose: Pose2, more: Kinds, rng: &mut Pcg64Mcg) -> bool {
        let ground = thing.footprint(pose);
        let near = self.inputs.is_on_ground(pose.point());
        if !near
            || self.out.is_full()
            || !self.is_free(ground, IN_THE_WAY | more)
            || !self.is_beside_walls(thing, pose)
        {
            return false;
        }
        if !stays_open(self.occupied, ground.axis, ground.radius) {
            return false;
        }
        let mut piece = Piece {
            scene: &mut self.out.scene,
            palette: &self.inputs.palette,
            pose,
            rng,
        };
        build_thing(&mut piece, thing);
        self.occupied.add(ground.axis, ground.radius);
        self.out.drawn_scenery.count_clutter(thing.kind.name());
        true
    }

    fn is_free(&self, Footprint { axis, radius }: Footprint, kinds: Kinds) -> bool {
        let p = axis.middle();
        self.occupied.is_free(axis, radius + AROUND_M, kinds & !BUILDING)
            // Car parks are full of cars that come and go.
            && self.inputs.clearance.areas_at(p, PAVED) == 0
            && keeps_off_gates(&self.gates, axis, radius)
            && self.leaves_doors(axis, radius)
    }

    /// Whether no corner or side of a thing is in a building; things may lean on walls.
    fn is_beside_walls(&self, thing: &Thing, pose: Pose2) -> bool {
        let mut sides = thing.outline(pose).into_iter();
        sides.all(|side| self.occupied.is_free(side, FROM_WALL_M / 2.0, BUILDING))
    }

    /// Whether a robot can stand before every door.
    fn leaves_doors(&self, axis: Segment, radius: f64) -> bool {
        let mut doors = self.inputs.doorways.iter();
        doors.all(|door| leaves_door(door, axis, radius))
    }
}

/// The middle of a thing that stands at a wall, so far to the left of a pose that faces out of it.
fn at_foot(wall: Pose2, left: f64, thing: &Thing) -> Pose2 {
    let p = wall.transform(thing.half.out + FROM_WALL_M, left);
    Pose2::new(p.x, p.y, wall.yaw)
}
