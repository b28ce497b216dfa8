//! Raised kerbs between carriageways and their pavements, with dropped kerbs at junctions,
//! crossings and driveways, before doors, and at least every twelve metres.
//!
//! A stretch is raised only where the pavement beside it is free, and where a robot can cross at
//! both of its ends. It then drives around the stretch instead of across it.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::Road;

use super::streams::{Purpose, stream};
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{
    BARRIER, BUILDING, DOOR, DRIVEWAY, Kinds, OBJECT, PATH, START, WATER,
};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{between, chance};
use crate::generate::shapes::{Block, cuboid};
use crate::generate::streets::profile::{KERB_WIDTH_M, Profile, profile};
use crate::material::SemanticClass;
use crate::scene::Layer;

/// Share of the streets with raised kerbs where there is most relief.
const SHARE: f64 = 1.0;
/// Distance between the places along a kerb that are looked at, metres.
const STEP_M: f64 = 0.5;
/// Longest stretch between two dropped kerbs, metres.
const LONGEST_M: f64 = 12.0;
/// Shortest stretch, metres.
const SHORTEST_M: f64 = 2.0;
/// Length of a dropped kerb, metres.
const DROPPED_M: f64 = 2.0;
/// A kerb is dropped this near to paths, driveways, doors and the start, metres.
const NEAR_M: f64 = 1.4;
/// A kerb is dropped this near to the pavement of another street, metres.
const MOUTH_M: f64 = 1.5;
/// Streets farther off are no junction, metres.
const JUNCTION_M: f64 = 25.0;
/// Free ground to each side that one needs along a kerb and across it, metres.
const ROOM_M: f64 = 0.45;
/// Heights of kerbs, metres. RASt 06 (FGSV 2006) has 12 cm.
const HEIGHTS_M: [f64; 2] = [0.10, 0.14];
/// What stops a robot.
const WALLS: Kinds = BUILDING | BARRIER | OBJECT | WATER;

/// Builds the raised kerbs.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let scenery = &inputs.options.scenery;
    let amount = scenery.amounts.relief;
    if amount <= 0.0 {
        return;
    }
    for (number, road) in inputs.map.roads.iter().enumerate() {
        let Some(profile) = profile(&road.tags).filter(|p| p.for_cars && p.pavement > 0.0) else {
            continue;
        };
        let mut rng = stream(scenery.seed, Purpose::Kerb, road.way as u64);
        let is_raised = chance(&mut rng, SHARE * amount);
        let height = between(&mut rng, HEIGHTS_M[0], HEIGHTS_M[1]);
        if !is_raised {
            continue;
        }
        let street = Street {
            inputs,
            number: number as u32,
            road,
            profile,
        };
        for stretch in street.stretches(occupied) {
            if out.is_full() {
                return;
            }
            let half = KERB_WIDTH_M / 2.0;
            let stones = Block {
                min: [0.0, -half, 0.0],
                max: [stretch.length(), half, height],
            };
            out.scene.begin_object("kerb", SemanticClass::Kerb);
            let surface = inputs.palette.kerbstone;
            cuboid(&mut out.scene, Layer::Both, surface, stretch.pose(), stones);
            occupied.add(stretch, half);
            out.drawn_scenery.kerbs += 1;
        }
    }
}

struct Street<'a> {
    inputs: &'a Inputs<'a>,
    number: u32,
    road: &'a Road,
    profile: Profile,
}

/// The line of a kerb along one segment of a street.
struct Line {
    /// Where the segment begins, along it.
    origin: Pose2,
    length: f64,
    /// Number of the segment in its street.
    number: usize,
    /// 1 on the left, -1 on the right.
    side: f64,
    /// Half the width of the carriageway, metres.
    half: f64,
    /// Width of the pavement, metres.
    pavement: f64,
}

impl Line {
    /// A point beside the segment, so far from the middle of the carriageway.
    fn beside(&self, run: f64, from_middle: f64) -> MapPoint {
        self.origin.transform(run, self.side * from_middle)
    }

    fn kerb(&self, run: f64) -> MapPoint {
        self.beside(run, self.half + KERB_WIDTH_M / 2.0)
    }

    /// The middle of the pavement.
    fn pavement(&self, run: f64) -> MapPoint {
        self.beside(
            run,
            self.half + KERB_WIDTH_M + (self.pavement - KERB_WIDTH_M) / 2.0,
        )
    }
}

impl Street<'_> {
    /// The stretches of both kerbs that are raised.
    fn stretches(&self, occupied: &Occupied) -> Vec<Segment> {
        let mut found = Vec::new();
        for (number, segment) in segments(&self.road.points).enumerate() {
            for (side, has_pavement) in [1.0, -1.0].into_iter().zip(self.profile.sides) {
                if !has_pavement || !self.inputs.is_on_ground(segment.middle()) {
                    continue;
                }
                let line = Line {
                    origin: segment.pose(),
                    length: segment.length(),
                    number,
                    side,
                    half: self.profile.width / 2.0,
                    pavement: self.profile.pavement,
                };
                found.extend(self.along(&line, occupied));
            }
        }
        found
    }

    fn along(&self, line: &Line, occupied: &Occupied) -> Vec<Segment> {
        let count = (line.length / STEP_M).min(10_000.0) as usize;
        let raised: Vec<bool> = (0..count)
            .map(|i| self.may_be_raised(line, (i as f64 + 0.5) * STEP_M, occupied))
            .collect();
        runs(&raised)
            .into_iter()
            .map(|[first, end]| [first as f64 * STEP_M, end as f64 * STEP_M])
            .filter(|run| crosses_at_ends(line, *run, occupied))
            .map(|[from, to]| Segment::new(line.kerb(from), line.kerb(to)))
            .collect()
    }

    /// Whether a kerb may be raised at a place: nothing leads over it, and the pavement is free.
    fn may_be_raised(&self, line: &Line, run: f64, occupied: &Occupied) -> bool {
        let kerb = line.kerb(run);
        let is_crossed = !occupied.is_free_at(kerb, NEAR_M, PATH | DRIVEWAY | DOOR | START);
        // Bends are left out: pieces of two segments would cross there.
        let is_at_end = run < MOUTH_M || run > line.length - MOUTH_M;
        let half = STEP_M / 2.0;
        let stone = Segment::new(line.kerb(run - half), line.kerb(run + half));
        let reach = line.half + KERB_WIDTH_M;
        !is_crossed
            && !is_at_end
            && !is_on_carriageway(stone, &self.road.points, line.number, reach)
            && !self.is_at_junction(kerb)
            && occupied.is_free_at(kerb, 0.1, WALLS)
            && occupied.is_free_at(line.pavement(run), ROOM_M, WALLS)
    }

    /// Whether another street or path is so near that its carriageway or pavement begins here.
    fn is_at_junction(&self, p: MapPoint) -> bool {
        let roads = &self.inputs.map.roads;
        let near = self.inputs.lanes.near(p, p, JUNCTION_M);
        near.into_iter()
            .filter(|lane| lane.road != self.number)
            .any(|lane| {
                let other = profile(&roads[lane.road as usize].tags);
                let reach = other.map_or(0.0, |o| o.width / 2.0 + o.pavement + MOUTH_M);
                lane.ends(roads).distance_to_point(p) < reach
            })
    }
}

/// Whether a stone of one segment's kerb lies on the carriageway of another segment of the same
/// street: on the inside of bends. The carriageway with its kerbs reaches `reach` metres aside.
fn is_on_carriageway(stone: Segment, road: &[MapPoint], own: usize, reach: f64) -> bool {
    let mut others = segments(road).enumerate().filter(|(i, _)| *i != own);
    others.any(|(_, other)| stone.distance_to(other) < reach)
}

/// Whether one can cross beyond both ends of a stretch.
fn crosses_at_ends(line: &Line, [from, to]: [f64; 2], occupied: &Occupied) -> bool {
    let half = DROPPED_M / 2.0;
    [[from, from - half], [to, to + half]]
        .into_iter()
        .all(|[end, beyond]| {
            let across = Segment::new(line.beside(beyond, 0.0), line.pavement(beyond));
            let along = Segment::new(line.pavement(end), line.pavement(beyond));
            occupied.is_free(across, ROOM_M, WALLS) && occupied.is_free(along, ROOM_M, WALLS)
        })
}

/// Runs of places that may be raised, first and one past the last, with dropped kerbs between them.
fn runs(raised: &[bool]) -> Vec<[usize; 2]> {
    let [longest, shortest, dropped] =
        [LONGEST_M, SHORTEST_M, DROPPED_M].map(|length| (length / STEP_M) as usize);
    let (mut found, mut at) = (Vec::new(), 0);
    while at < raised.len() {
        let length = raised[at..]
            .iter()
            .take(longest)
            .take_while(|r| **r)
            .count();
        if length >= shortest {
            found.push([at, at + length]);
            at += length + dropped;
        } else {
            at += length.max(1);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_kerb_is_raised_on_the_carriageway_behind_a_bend() {
        let road = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)].map(|(x, y)| MapPoint::new(x, y));
        let stone = |x: f64, y: f64| Segment::new(MapPoint::new(x, y), MapPoint::new(x + 0.5, y));
        let is_on = |x, y| is_on_carriageway(stone(x, y), &road, 0, 3.0 + KERB_WIDTH_M);
        assert!(is_on(17.5, 3.07), "inside of the bend");
        assert!(!is_on(10.0, 3.07), "before the bend");
        assert!(!is_on(17.5, -3.07), "outside of the bend");
    }

    #[test]
    fn long_kerbs_are_dropped_in_between() {
        let mut raised = vec![true; 80];
        raised[60] = false;
        // 12 m are 24 places, 2 m are 4.
        assert_eq!(runs(&raised), [[0, 24], [28, 52], [56, 60], [64, 80]]);
        assert_eq!(runs(&[true, true, false]), Vec::<[usize; 2]>::new());
    }
}
