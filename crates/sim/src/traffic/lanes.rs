//! The network that cars drive on: lanes along the streets and turns between them.
//!
//! A street between two junctions has a lane each way, moved aside where parked cars narrow it. A
//! street on which two cars cannot pass each other is one-way. Junctions so near to each other that
//! no car can wait between them are one. A turn is a cubic Bézier curve from the end of one lane to
//! the beginning of another.

use std::collections::BTreeMap;
use std::ops::Range;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::line::length;
use openbench_osm::OsmMap;

use super::ground::Ground;
use super::hull::CAR_HALF_WIDTH_M;
use super::mover::PERSON_RADIUS_M;
use super::piece::{Piece, SPACING_M};
use super::polyline::{offset_point, offset_points, resampled, trimmed};
use super::streets::{Street, StreetNetwork};

/// Least distance of a car from obstacles beside its lane, metres.
const BESIDE_M: f64 = 0.1;
/// Least distance between the middles of lanes that meet, metres.
const APART_M: f64 = 2.0 * CAR_HALF_WIDTH_M + 0.1;
/// Shortest lane, metres: a car waits on it while another passes behind.
const SHORTEST_LANE_M: f64 = 7.0;
/// Shortest lane that is free from end to end, metres.
const SHORTEST_FREE_LANE_M: f64 = 2.0;
/// Shortest and longest turn, metres.
const SHORTEST_TURN_M: f64 = 0.3;
const LONGEST_TURN_M: f64 = 45.0;
/// Largest change of direction in a turn, radians.
const SHARPEST_TURN_RAD: f64 = 2.5;
/// Distance between the lateral offsets that are tried, metres.
const OFFSET_STEP_M: f64 = 0.1;
/// Points before and behind a narrow place over which a lane is moved aside.
// Points are a metre apart, so a car has seven metres to move aside.
const EASE: usize = 7;

/// All lanes, then all turns.
#[derive(Debug, Clone, Default)]
pub(super) struct Lanes {
    pub pieces: Vec<Piece>,
    /// How many of the pieces are lanes.
    pub lanes: usize,
}

/// A lane before it is connected. An end with a junction is open there.
struct Lane {
    piece: Piece,
    from: Option<usize>,
    to: Option<usize>,
    street: usize,
}

/// A turn at a junction from one lane to another.
struct Turn {
    junction: usize,
    from: usize,
    to: usize,
    piece: Piece,
}

impl Turn {
    /// Whether cars cannot make both turns at the same time.
    fn conflicts_with(&self, other: &Self) -> bool {
        self.junction == other.junction
            && (self.from, self.to) != (other.from, other.to)
            && self.piece.meets(&other.piece, APART_M)
    }
}

impl Lanes {
    /// The lanes and turns of a map where no obstacle stands.
    pub fn new(map: &OsmMap, ground: &Ground) -> Self {
        let StreetNetwork {
            mut streets,
            junctions,
        } = StreetNetwork::new(map);
        let setbacks: Vec<f64> = junctions
            .iter()
            .map(|junction| junction.setback())
            .collect();
        // A street too short for a lane between its junctions goes, and they become one junction.
        let mut clusters = Clusters::new(junctions.len());
        streets.retain(|street| {
            let shortest = setbacks[street.from] + setbacks[street.to] + SHORTEST_LANE_M;
            let keeps = length(&street.points) >= shortest;
            if !keeps {
                clusters.merge(street.from, street.to);
            }
            keeps
        });
        let mut lanes = Vec::new();
        for (i, street) in streets.iter().enumerate() {
            // Lanes end before the junction; turns lead over it.
            let line = trimmed(&street.points, setbacks[street.from], setbacks[street.to]);
            // Only now are the clusters complete: a lane begins and ends at a cluster.
            for lane in lanes_of(street, &line, ground) {
                lanes.push(Lane {
                    street: i,
                    from: lane.from.map(|junction| clusters.of(junction)),
                    to: lane.to.map(|junction| clusters.of(junction)),
                    piece: lane.piece,
                });
            }
        }
        Self::connected(lanes, ground)
    }

    fn connected(lanes: Vec<Lane>, ground: &Ground) -> Self {
        let count = lanes.len();
        let turns = turns(&lanes, ground);
        let mut pieces: Vec<Piece> = lanes.into_iter().map(|lane| lane.piece).collect();
        // Until a turn leads to it, below.
        pieces.iter_mut().for_each(|p| p.is_entry = true);
        for (k, turn) in turns.iter().enumerate() {
            // Turns follow the lanes in `pieces`, hence the offset `count`.
            let conflicts = (0..turns.len()).filter(|&other| turn.conflicts_with(&turns[other]));
            let mut piece = turn.piece.clone();
            piece.next = vec![turn.to as u32];
            piece.conflicts = conflicts.map(|other| (count + other) as u32).collect();
            pieces[turn.from].next.push((count + k) as u32);
            pieces[turn.to].is_entry = false;
            pieces.push(piece);
        }
        Self {
            pieces,
            lanes: count,
        }
    }

    /// Whether a piece is a turn.
    pub fn is_turn(&self, piece: u32) -> bool {
        piece as usize >= self.lanes
    }
}

/// Junctions merged into clusters: a union-find forest whose roots are the lowest numbers.
struct Clusters {
    parents: Vec<usize>,
}

impl Clusters {
    fn new(junctions: usize) -> Self {
        Self {
            parents: (0..junctions).collect(),
        }
    }

    /// Number of the cluster of a junction.
    fn of(&self, mut junction: usize) -> usize {
        while self.parents[junction] != junction {
            junction = self.parents[junction];
        }
        junction
    }

    fn merge(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        // The lower root stays, so numbers of clusters do not depend on the order of merges.
        self.parents[a.max(b)] = a.min(b);
    }
}

/// The turns at all junctions, in the order of the lanes that they leave.
fn turns(lanes: &[Lane], ground: &Ground) -> Vec<Turn> {
    let mut leaving: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (i, lane) in lanes.iter().enumerate() {
        if let Some(junction) = lane.from {
            leaving.entry(junction).or_default().push(i);
        }
    }
    let mut turns = Vec::new();
    for (from, lane) in lanes.iter().enumerate() {
        let Some(junction) = lane.to else { continue };
        for &to in leaving.get(&junction).into_iter().flatten() {
            // No U-turns.
            if lanes[to].street == lane.street {
                continue;
            }
            if let Some(piece) = turn(&lane.piece, &lanes[to].piece, ground) {
                turns.push(Turn {
                    junction,
                    from,
                    to,
                    piece,
                });
            }
        }
    }
    turns
}

/// Offsets of a lane from the middle of its street, and its direction.
struct Course {
    /// To the left of the street's line at each of its points, metres.
    offsets: Vec<f64>,
    /// Whether cars drive in the direction of the street's points.
    forward: bool,
}

/// The lanes of a street whose line is `line`, open at the street's junctions.
fn lanes_of(street: &Street, line: &[MapPoint], ground: &Ground) -> Vec<Lane> {
    let way = &street.carriageway;
    let line = resampled(line, SPACING_M);
    // Offsets count to the left, so traffic that keeps to the right has a negative one.
    let side = if way.left_hand { 1.0 } else { -1.0 } * way.half_width / 2.0;
    let offsets = |nominal: f64| eased_offsets(&line, way.half_width, nominal, ground);
    let mut courses = Vec::new();
    if way.forward && way.backward {
        let forth = Course {
            offsets: offsets(side),
            forward: true,
        };
        let back = Course {
            offsets: offsets(-side),
            forward: false,
        };
        let mut pairs = forth.offsets.iter().zip(&back.offsets);
        // Eased around obstacles, both lanes may come too close, or even swap sides: then there is
        // one.
        if pairs.all(|(a, b)| (b - a) * -side.signum() >= APART_M) {
            courses = vec![forth, back];
        }
    }
    if courses.is_empty() {
        courses = vec![Course {
            offsets: offsets(0.0),
            forward: way.forward,
        }];
    }
    let mut lanes = Vec::new();
    for course in courses {
        let mut points = offset_points(&line, &course.offsets);
        let (mut from, mut to) = (street.from, street.to);
        if !course.forward {
            points.reverse();
            (from, to) = (to, from);
        }
        lanes.extend(clear_lanes(&points, way.limit, from, to, ground));
    }
    lanes
}

/// Lateral offset of a lane to the left of a line at each of its points: `nominal`, or as near to
/// it as obstacles allow.
fn eased_offsets(line: &[MapPoint], half_width: f64, nominal: f64, ground: &Ground) -> Vec<f64> {
    let candidates = candidate_offsets(half_width, nominal);
    let shifts: Vec<f64> = (0..line.len())
        .map(|i| {
            let mut clear = candidates
                .iter()
                .filter(|o| is_clear(offset_point(line, i, **o), ground));
            // Where no offset is clear the lane is cut later, see `clear_lanes`.
            clear.next().copied().unwrap_or(nominal)
        })
        .collect();
    // The largest shift around each point, then the mean of those: smooth, and nowhere less than
    // the obstacles need.
    let around = |i: usize| i.saturating_sub(EASE)..(i + EASE + 1).min(line.len());
    let largest: Vec<f64> = (0..line.len())
        .map(|i| farthest_from(nominal, &shifts[around(i)]))
        .collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    (0..line.len()).map(|i| mean(&largest[around(i)])).collect()
}

/// Offsets at which a car stays on its carriageway, the nearest to `nominal` first.
fn candidate_offsets(half_width: f64, nominal: f64) -> Vec<f64> {
    // Within this of the middle, the whole car is on the carriageway.
    let reach = (half_width - CAR_HALF_WIDTH_M).max(0.0);
    let tries = (2.0 * reach / OFFSET_STEP_M) as usize + 1;
    let mut candidates: Vec<f64> = (0..=tries)
        .map(|i| -reach + 2.0 * reach * i as f64 / tries as f64)
        .collect();
    candidates.push(nominal.clamp(-reach, reach));
    candidates.sort_by(|a, b| (a - nominal).abs().total_cmp(&(b - nominal).abs()));
    candidates
}

/// The last of the values that are farthest from `nominal`; `nominal` if there are none.
fn farthest_from(nominal: f64, values: &[f64]) -> f64 {
    let away = |value: &f64| (value - nominal).abs();
    values
        .iter()
        .copied()
        .max_by(|a, b| away(a).total_cmp(&away(b)))
        .unwrap_or(nominal)
}

/// Whether a car's width fits at a point of its lane.
fn is_clear(point: MapPoint, ground: &Ground) -> bool {
    // Clearances count to where a person no longer fits, which is a person's radius before an
    // obstacle.
    ground.clearance(point).distance >= CAR_HALF_WIDTH_M + BESIDE_M - PERSON_RADIUS_M
}

/// The parts of a lane between the junctions `from` and `to` without obstacles. Each part hangs
/// together with one of the lane's ends.
fn clear_lanes(
    points: &[MapPoint],
    limit: f64,
    from: usize,
    to: usize,
    ground: &Ground,
) -> Vec<Lane> {
    let lane = |range: Range<usize>, from, to, shortest: f64| {
        let part = &points[range];
        let long = part.len() > 1 && length(part) >= shortest;
        long.then(|| Lane {
            piece: Piece::new(part, limit),
            from,
            to,
            // The caller knows the street and sets it.
            street: 0,
        })
    };
    let is_blocked = |p: &MapPoint| !is_clear(*p, ground);
    let Some(first) = points.iter().position(is_blocked) else {
        let whole = lane(0..points.len(), Some(from), Some(to), SHORTEST_FREE_LANE_M);
        return whole.into_iter().collect();
    };
    let last = points.iter().rposition(is_blocked).unwrap_or(first);
    // Cars drive up to the obstacle, or come in behind it; between two obstacles no car would ever
    // be.
    let begin = lane(0..first, Some(from), None, SHORTEST_LANE_M);
    let end = lane(last + 1..points.len(), None, Some(to), SHORTEST_LANE_M);
    begin.into_iter().chain(end).collect()
}

/// The turn from the end of `a` to the beginning of `b`, if a car can drive it.
fn turn(a: &Piece, b: &Piece, ground: &Ground) -> Option<Piece> {
    let (from, to) = (a.pose(a.length), b.pose(0.0));
    let away = from.point().distance(to.point());
    let fits = (SHORTEST_TURN_M..=LONGEST_TURN_M).contains(&away);
    if wrap_angle(to.yaw - from.yaw).abs() > SHARPEST_TURN_RAD || !fits {
        return None;
    }
    let line = bezier(from, to, away);
    // The curve's own limit is lower where it bends: `Piece::new` sees to it.
    let limit = a.speed(a.length).max(b.speed(0.0));
    line.iter()
        .all(|p| is_clear(*p, ground))
        .then(|| Piece::new(&line, limit))
}

/// A cubic Bézier curve between two poses that are `away` metres apart.
fn bezier(from: Pose2, to: Pose2, away: f64) -> Vec<MapPoint> {
    // At right angles this is nearly a circular arc, whose handles are 0.39 of the chord.
    let reach = 0.4 * away;
    let (c, d) = (from.transform(reach, 0.0), to.transform(-reach, 0.0));
    let steps = (2.0 * away).ceil().max(4.0) as usize;
    let at = |i: usize| {
        let t = i as f64 / steps as f64;
        let u = 1.0 - t;
        let w = [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t];
        let mix = |p: [f64; 4]| (0..4).map(|k| w[k] * p[k]).sum();
        MapPoint::new(mix([from.x, c.x, d.x, to.x]), mix([from.y, c.y, d.y, to.y]))
    };
    (0..=steps).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_have_the_lowest_number() {
        let mut clusters = Clusters::new(5);
        clusters.merge(4, 2);
        clusters.merge(3, 4);
        assert_eq!([0, 1, 2, 3, 4].map(|k| clusters.of(k)), [0, 1, 2, 2, 2]);
    }

    #[test]
    fn offsets_are_tried_from_the_nominal_one_outwards() {
        let candidates = candidate_offsets(CAR_HALF_WIDTH_M + 0.2, 0.1);
        assert_eq!(candidates[0], 0.1);
        assert!(
            candidates
                .windows(2)
                .all(|w| (w[0] - 0.1).abs() <= (w[1] - 0.1).abs())
        );
        assert!(candidates.iter().all(|o| o.abs() < 0.2 + 1e-9));
    }

    #[test]
    fn a_turn_begins_and_ends_in_the_directions_of_its_lanes() {
        let (from, to) = (Pose2::new(0.0, 0.0, 0.0), Pose2::new(10.0, 10.0, 1.57));
        let line = bezier(from, to, from.point().distance(to.point()));
        assert!(line[0].bearing_to(line[1]).abs() < 0.15);
        assert!((line[line.len() - 2].bearing_to(line[line.len() - 1]) - 1.57).abs() < 0.15);
    }
}
