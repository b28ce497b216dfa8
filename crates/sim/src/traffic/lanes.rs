//! The network that cars drive on: lanes along the streets and turns between them.
//!
//! A street between two junctions has a lane each way, moved aside where parked cars narrow it; where two cars do not fit
//! beside each other it is one-way. Junctions that are too near to each other for a car to wait between them are one.
//! A turn is a cubic Bézier curve from the end of one lane to the beginning of another.

use std::collections::BTreeMap;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_osm::OsmMap;

use super::footways::shifted;
use super::ground::Ground;
use super::mover::PERSON_RADIUS;
use super::ways::{Carriageway, carriageway};

/// Half length and half width of a car, metres.
pub(super) const HALF: [f64; 2] = [2.22, 0.89];
/// A car keeps this far from what stands beside its lane, metres.
const BESIDE: f64 = 0.1;
/// Middles of lanes that meet are at least this far apart, metres.
const APART: f64 = 2.0 * HALF[1] + 0.1;
/// Distance between the points of a lane, about, metres.
const SPACING: f64 = 1.0;
/// Shortest lane: a car waits on it and another passes behind, metres.
const SHORTEST: f64 = 7.0;
/// Longest turn, metres.
const LONGEST_TURN: f64 = 45.0;
/// Largest change of direction in a turn, radians.
const SHARPEST: f64 = 2.5;
/// Acceleration in bends, m/s²: what drivers find comfortable.
const SIDEWAYS: f64 = 2.0;
/// Deceleration before bends, m/s².
const BEFORE_BENDS: f64 = 1.5;
/// How far before and behind a narrow place a lane is moved aside, in points.
const EASE: usize = 7;

/// A lane or a turn.
#[derive(Debug, Clone, Default)]
pub(super) struct Piece {
    points: Vec<MapPoint>,
    /// Speed limit at each point, bends and what lies behind them considered, m/s.
    speeds: Vec<f64>,
    spacing: f64,
    pub length: f64,
    /// From a lane: turns; from a turn: the one lane.
    pub next: Vec<u32>,
    /// Turns that must not be driven at the same time.
    pub conflicts: Vec<u32>,
    /// Whether nothing leads here: cars come from outside.
    pub is_entry: bool,
}

impl Piece {
    fn new(line: &[MapPoint], limit: f64) -> Self {
        let points = even(line, SPACING);
        let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let spacing = length / (points.len() - 1) as f64;
        let mut speeds = vec![limit; points.len()];
        for i in 2..points.len().saturating_sub(2) {
            let turn = points[i].bearing_to(points[i + 2]) - points[i - 2].bearing_to(points[i]);
            let curvature = wrap_angle(turn).abs() / (2.0 * spacing);
            speeds[i] = limit.min((SIDEWAYS / curvature.max(1e-3)).sqrt()).max(1.5);
        }
        for i in (1..speeds.len()).rev() {
            speeds[i - 1] = speeds[i - 1].min(slowing(speeds[i], spacing));
        }
        Self {
            points,
            speeds,
            spacing,
            length,
            ..Self::default()
        }
    }

    /// Where a car is that has driven `s` metres on this piece.
    pub fn pose(&self, s: f64) -> Pose2 {
        let at = (s / self.spacing).clamp(0.0, (self.points.len() - 1) as f64 - 1e-9);
        let (i, share) = (at as usize, at.fract());
        let (a, b) = (self.points[i], self.points[i + 1]);
        let here = a.bearing_to(b);
        // Turned gradually from the middle of one stretch to the middle of the next.
        let (j, part) = if share < 0.5 {
            (i.max(1) - 1, 0.5 - share)
        } else {
            (i + 1, share - 0.5)
        };
        let beside = match self.points.get(j..j + 2) {
            Some(w) if j != i => w[0].bearing_to(w[1]),
            _ => here,
        };
        let yaw = wrap_angle(here + part * wrap_angle(beside - here));
        Pose2::new(a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share, yaw)
    }

    /// Speed limit after `s` metres, m/s.
    pub fn speed(&self, s: f64) -> f64 {
        let i = (s / self.spacing).max(0.0) as usize;
        self.speeds[i.min(self.speeds.len() - 1)]
    }
}

/// The speed from which one slows down to `speed` within `distance` metres.
pub(super) fn slowing(speed: f64, distance: f64) -> f64 {
    (speed * speed + 2.0 * BEFORE_BENDS * distance.max(0.0)).sqrt()
}

/// All lanes, then all turns.
#[derive(Debug, Clone, Default)]
pub(super) struct Lanes {
    pub pieces: Vec<Piece>,
    /// How many of the pieces are lanes.
    pub lanes: usize,
}

/// A street between two junctions.
struct Street {
    points: Vec<MapPoint>,
    way: Carriageway,
    ends: [usize; 2],
}

/// A lane that begins at junction `from` and ends at `to`, if it is open there.
struct Lane {
    piece: Piece,
    from: Option<usize>,
    to: Option<usize>,
    street: usize,
}

impl Lanes {
    pub fn new(map: &OsmMap, ground: &Ground) -> Self {
        let (mut streets, arms) = streets(map);
        let setbacks: Vec<f64> = arms.iter().map(|a| setback(a)).collect();
        let mut cluster: Vec<usize> = (0..arms.len()).collect();
        streets.retain(|street| {
            let [a, b] = street.ends;
            let keeps = length(&street.points) >= setbacks[a] + setbacks[b] + SHORTEST;
            if !keeps {
                let (a, b) = (root(&cluster, a), root(&cluster, b));
                cluster[a.max(b)] = a.min(b);
            }
            keeps
        });
        let mut lanes = Vec::new();
        for (i, street) in streets.iter().enumerate() {
            let [a, b] = street.ends;
            let line = trimmed(&street.points, setbacks[a], setbacks[b]);
            let ends = [root(&cluster, a), root(&cluster, b)];
            lanes.extend(lanes_of(street, &line, ground).into_iter().map(|mut lane| {
                (lane.from, lane.to) = (lane.from.map(|k| ends[k]), lane.to.map(|k| ends[k]));
                Lane { street: i, ..lane }
            }));
        }
        Self::connected(lanes, ground)
    }

    fn connected(lanes: Vec<Lane>, ground: &Ground) -> Self {
        let count = lanes.len();
        let mut leaving: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, lane) in lanes.iter().enumerate() {
            lane.from
                .into_iter()
                .for_each(|junction| leaving.entry(junction).or_default().push(i));
        }
        let mut turns: Vec<(usize, usize, usize, Piece)> = Vec::new();
        for (i, lane) in lanes.iter().enumerate() {
            let Some(junction) = lane.to else { continue };
            for &j in leaving.get(&junction).into_iter().flatten() {
                if lanes[j].street != lane.street {
                    let piece = turn(&lane.piece, &lanes[j].piece, ground);
                    turns.extend(piece.map(|p| (junction, i, j, p)));
                }
            }
        }
        let mut pieces: Vec<Piece> = lanes.into_iter().map(|lane| lane.piece).collect();
        pieces.iter_mut().for_each(|p| p.is_entry = true);
        for k in 0..turns.len() {
            let (junction, from, to, ref piece) = turns[k];
            let meets = |other: &(usize, usize, usize, Piece)| {
                other.0 == junction && (other.1, other.2) != (from, to) && meet(piece, &other.3)
            };
            let conflicts = (0..turns.len())
                .filter(|&o| meets(&turns[o]))
                .map(|o| (count + o) as u32);
            let piece = Piece {
                next: vec![to as u32],
                conflicts: conflicts.collect(),
                ..piece.clone()
            };
            pieces[from].next.push((count + k) as u32);
            pieces[to].is_entry = false;
            pieces.push(piece);
        }
        Self {
            pieces,
            lanes: count,
        }
    }
}

/// Streets between junctions, and the half widths of the arms of each junction.
fn streets(map: &OsmMap) -> (Vec<Street>, Vec<Vec<f64>>) {
    let finite = |p: &MapPoint| p.x.is_finite() && p.y.is_finite();
    let roads = || {
        map.roads
            .iter()
            .filter(|road| road.points.iter().all(finite))
    };
    let ways = || roads().filter_map(|road| Some((road, carriageway(&road.tags)?)));
    let mut arms: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for (road, way) in ways() {
        for (i, node) in road.nodes.iter().enumerate() {
            let inner = i > 0 && i + 1 < road.nodes.len();
            let list = arms.entry(*node).or_default();
            list.extend(std::iter::repeat_n(
                way.half_width,
                if inner { 2 } else { 1 },
            ));
        }
    }
    let mut numbers: BTreeMap<i64, usize> = BTreeMap::new();
    let mut kept = Vec::new();
    let mut streets = Vec::new();
    for (road, way) in ways() {
        let mut begin = 0;
        for i in 1..road.nodes.len() {
            if i + 1 < road.nodes.len() && arms[&road.nodes[i]].len() == 2 {
                continue;
            }
            let ends = [begin, i].map(|k| {
                *numbers.entry(road.nodes[k]).or_insert_with(|| {
                    kept.push(arms[&road.nodes[k]].clone());
                    kept.len() - 1
                })
            });
            streets.push(Street {
                points: road.points[begin..=i].to_vec(),
                way,
                ends,
            });
            begin = i;
        }
    }
    (streets, kept)
}

/// How far before the middle of a junction its streets end, metres.
fn setback(arms: &[f64]) -> f64 {
    let widest = arms.iter().copied().fold(0.0, f64::max);
    match arms.len() {
        0 | 1 => 0.0,
        2 => 1.5,
        _ => widest + 2.5,
    }
}

/// The lanes of a street; `from` and `to` number its ends.
fn lanes_of(street: &Street, line: &[MapPoint], ground: &Ground) -> Vec<Lane> {
    let line = even(line, SPACING);
    let side = if street.way.left_hand { 1.0 } else { -1.0 } * street.way.half_width / 2.0;
    let [forth, back] = street.way.directions;
    let both = forth && back;
    let offsets = |nominal: f64| eased(&line, street.way.half_width, nominal, ground);
    let mut kept = if both {
        vec![(offsets(side), true), (offsets(-side), false)]
    } else {
        Vec::new()
    };
    let fit = both
        && kept[0]
            .0
            .iter()
            .zip(&kept[1].0)
            .all(|(a, b)| (b - a) * -side.signum() >= APART);
    if !fit {
        kept = vec![(offsets(0.0), forth)];
    }
    let mut lanes = Vec::new();
    for (offsets, forward) in kept {
        let mut points: Vec<MapPoint> = moved(&line, &offsets);
        let mut ends = [0, 1];
        if !forward {
            points.reverse();
            ends.reverse();
        }
        lanes.extend(clear_runs(&points, street.way.limit, ends, ground));
    }
    lanes
}

/// How far to the left of the line a car drives at each of its points: `nominal`, or as near to it as obstacles allow.
fn eased(line: &[MapPoint], half_width: f64, nominal: f64, ground: &Ground) -> Vec<f64> {
    let reach = (half_width - HALF[1]).max(0.0);
    let tries = (2.0 * reach / 0.1) as usize + 1;
    let mut candidates: Vec<f64> = (0..=tries)
        .map(|i| -reach + 2.0 * reach * i as f64 / tries as f64)
        .collect();
    candidates.push(nominal.clamp(-reach, reach));
    candidates.sort_by(|a, b| (a - nominal).abs().total_cmp(&(b - nominal).abs()));
    let shifts: Vec<f64> = (0..line.len())
        .map(|i| {
            let here = |o: f64| is_clear(moved_point(line, i, o), ground);
            candidates
                .iter()
                .copied()
                .find(|o| here(*o))
                .unwrap_or(nominal)
        })
        .collect();
    // The furthest shift around each point, then the mean of those: smooth, and nowhere less than needed.
    let around = |i: usize| i.saturating_sub(EASE)..(i + EASE + 1).min(line.len());
    let far = |range: std::ops::Range<usize>| {
        range
            .map(|k| shifts[k])
            .max_by(|a, b| (a - nominal).abs().total_cmp(&(b - nominal).abs()))
    };
    let furthest: Vec<f64> = (0..line.len())
        .map(|i| far(around(i)).unwrap_or(nominal))
        .collect();
    (0..line.len())
        .map(|i| around(i).map(|k| furthest[k]).sum::<f64>() / around(i).len() as f64)
        .collect()
}

/// Whether a car's width fits at a point of its lane.
fn is_clear(point: MapPoint, ground: &Ground) -> bool {
    ground.clearance(point).0 >= HALF[1] + BESIDE - PERSON_RADIUS
}

fn moved_point(line: &[MapPoint], i: usize, offset: f64) -> MapPoint {
    let (a, b) = (line[i.max(1) - 1], line[(i + 1).min(line.len() - 1)]);
    let length = a.distance(b).max(1e-9);
    MapPoint::new(
        line[i].x - (b.y - a.y) / length * offset,
        line[i].y + (b.x - a.x) / length * offset,
    )
}

fn moved(line: &[MapPoint], offsets: &[f64]) -> Vec<MapPoint> {
    match offsets {
        // A lane at an even distance keeps its bends mitred.
        [first, rest @ ..] if rest.iter().all(|o| o == first) => shifted(line, *first),
        _ => (0..line.len())
            .map(|i| moved_point(line, i, offsets[i]))
            .collect(),
    }
}

/// The parts of a lane where nothing stands that hang together with one of its ends.
fn clear_runs(points: &[MapPoint], limit: f64, ends: [usize; 2], ground: &Ground) -> Vec<Lane> {
    let clear: Vec<bool> = points.iter().map(|p| is_clear(*p, ground)).collect();
    let first = clear.iter().position(|c| !c).unwrap_or(points.len());
    let last = clear.iter().rposition(|c| !c).map_or(0, |i| i + 1);
    let runs = if first == points.len() {
        vec![(0..points.len(), Some(ends[0]), Some(ends[1]))]
    } else {
        vec![
            (0..first, Some(ends[0]), None),
            (last..points.len(), None, Some(ends[1])),
        ]
    };
    let long = runs.into_iter().filter(|(range, ..)| {
        range.len() > 1
            && length(&points[range.clone()]) >= if first == points.len() { 2.0 } else { SHORTEST }
    });
    long.map(|(range, from, to)| Lane {
        piece: Piece::new(&points[range], limit),
        from,
        to,
        street: 0,
    })
    .collect()
}

/// The turn from the end of `a` to the beginning of `b`, if a car can drive it.
fn turn(a: &Piece, b: &Piece, ground: &Ground) -> Option<Piece> {
    let (from, to) = (a.pose(a.length), b.pose(0.0));
    let away = from.point().distance(to.point());
    if wrap_angle(to.yaw - from.yaw).abs() > SHARPEST || !(0.3..=LONGEST_TURN).contains(&away) {
        return None;
    }
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
    let line: Vec<MapPoint> = (0..=steps).map(at).collect();
    let limit = a.speed(a.length).max(b.speed(0.0));
    line.iter()
        .all(|p| is_clear(*p, ground))
        .then(|| Piece::new(&line, limit))
}

/// Whether cars on both would touch.
fn meet(a: &Piece, b: &Piece) -> bool {
    a.points
        .iter()
        .any(|p| b.points.iter().any(|q| p.distance(*q) < APART))
}

fn root(cluster: &[usize], mut junction: usize) -> usize {
    while cluster[junction] != junction {
        junction = cluster[junction];
    }
    junction
}

fn length(line: &[MapPoint]) -> f64 {
    line.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// The line without its first `begin` and last `end` metres.
fn trimmed(line: &[MapPoint], begin: f64, end: f64) -> Vec<MapPoint> {
    let whole = length(line);
    let (low, high) = (begin, whole - end);
    let mut kept = vec![at_run(line, low)];
    let mut run = 0.0;
    for (i, p) in line.iter().enumerate() {
        run += if i > 0 { line[i - 1].distance(*p) } else { 0.0 };
        if run > low + 0.01 && run < high - 0.01 {
            kept.push(*p);
        }
    }
    kept.push(at_run(line, high));
    kept
}

/// The same line with points at even distances of about `spacing` metres; two points or more.
fn even(line: &[MapPoint], spacing: f64) -> Vec<MapPoint> {
    let whole = length(line);
    let steps = (whole / spacing).round().clamp(1.0, 100_000.0) as usize;
    let mut points = Vec::with_capacity(steps + 1);
    let (mut i, mut before) = (0, 0.0);
    for k in 0..=steps {
        let run = whole * k as f64 / steps as f64;
        while i + 2 < line.len() && before + line[i].distance(line[i + 1]) < run {
            before += line[i].distance(line[i + 1]);
            i += 1;
        }
        points.push(between(line[i], line[i + 1], run - before));
    }
    points
}

fn at_run(line: &[MapPoint], run: f64) -> MapPoint {
    let mut left = run;
    for w in line.windows(2) {
        let step = w[0].distance(w[1]);
        if left <= step {
            return between(w[0], w[1], left);
        }
        left -= step;
    }
    line[line.len() - 1]
}

/// The point `run` metres from `a` towards `b`.
fn between(a: MapPoint, b: MapPoint, run: f64) -> MapPoint {
    let share = (run / a.distance(b).max(1e-9)).clamp(0.0, 1.0);
    MapPoint::new(a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share)
}
