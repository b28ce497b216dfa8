//! The parts of a neighbourhood while it is planned, in metres of the plan: a rectangle around
//! the origin, which is turned and moved when it is written as a map.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::houses::DrawnDoor;

/// Width of the pavements that belong to a street, metres: as worlds are built.
pub(crate) const PAVEMENT_M: f64 = 1.8;
/// Half the width of a gate, metres: as worlds are built.
pub(crate) const GATE_HALF_WIDTH_M: f64 = 0.9;

/// Half the sides of the planned rectangle, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Half {
    pub x: f64,
    pub y: f64,
}

/// What a street is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Class {
    /// With pavements.
    Residential,
    /// Shared by people and cars.
    Living,
    /// An access road without a name.
    Service,
}

/// A place where a path joins a street.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Joint {
    /// Metres along the street.
    pub along: f64,
    pub point: MapPoint,
}

/// A street.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Street {
    pub class: Class,
    /// Its middle. Streets that meet share a point.
    pub line: Vec<MapPoint>,
    /// Width of the carriageway, metres.
    pub width: f64,
    pub joints: Vec<Joint>,
}

impl Street {
    /// Distance from the middle to the edge of the pavement, metres.
    pub fn edge(&self) -> f64 {
        let pavement = match self.class {
            Class::Residential => PAVEMENT_M,
            Class::Living | Class::Service => 0.0,
        };
        self.width / 2.0 + pavement
    }

    pub fn length(&self) -> f64 {
        openbench_geometry::line::length(&self.line)
    }

    /// The nearest place on the street, where a path may join it.
    pub fn nearest(&self, point: MapPoint) -> Joint {
        let (mut before, mut best) = (0.0, f64::INFINITY);
        let mut joint = Joint {
            along: 0.0,
            point: self.line[0],
        };
        for stretch in segments(&self.line) {
            let foot = stretch.nearest_point(point);
            let distance = foot.point.distance(point);
            if distance < best {
                best = distance;
                joint = Joint {
                    along: before + foot.share * stretch.length(),
                    point: foot.point,
                };
            }
            before += stretch.length();
        }
        joint
    }

    /// The pose so many metres along the street, facing along it.
    pub fn pose_at(&self, along: f64) -> Pose2 {
        let mut left = along.max(0.0);
        let last = self.line.len().saturating_sub(2);
        for (i, stretch) in segments(&self.line).enumerate() {
            let length = stretch.length();
            if left <= length || i == last {
                let at = stretch.at((left / length.max(1e-9)).min(1.0));
                return Pose2::new(at.x, at.y, stretch.bearing());
            }
            left -= length;
        }
        Pose2::default()
    }
}

/// A path for people, or a driveway.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Path {
    pub line: Vec<MapPoint>,
    pub driveway: bool,
    /// Metres.
    pub width: f64,
}

/// What a home is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HomeKind {
    Detached,
    Semi,
    /// One house of a row.
    Terraced,
    /// A row that the map draws as one building.
    Row,
    /// A house of flats in a closed row.
    Perimeter,
    Slab,
    Tower,
    Farm,
}

/// The side of a street, as one walks along its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Side {
    Left,
    Right,
}

/// The ground that belongs to a home, in the frame of its [`Home::pose`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lot {
    /// Metres along the street, the home's middle at half of it.
    pub width: f64,
    /// Metres from the edge of the pavement.
    pub depth: f64,
}

/// A building with doors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Home {
    pub kind: HomeKind,
    /// Counter-clockwise.
    pub outer: Vec<MapPoint>,
    pub court: Option<Vec<MapPoint>>,
    /// At the edge of the pavement before the middle of the home: x along the street, y away from
    /// it.
    pub pose: Pose2,
    /// Index of the street, and where the home is along it, metres.
    pub street: usize,
    pub side: Side,
    pub along: f64,
    pub lot: Option<Lot>,
    pub levels: u32,
    pub roof: Option<&'static str>,
    /// Number of the stream from which the rest of the home is drawn.
    pub stream: u64,
    /// House number, or the number in its estate.
    pub number: String,
    /// A name of its own.
    pub name: Option<String>,
    /// How many doors are wanted.
    pub wanted_doors: usize,
    pub doors: Vec<DrawnDoor>,
}

/// A garage or shed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outbuilding {
    pub outer: Vec<MapPoint>,
    pub kind: &'static str,
}

/// What a barrier is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BarrierKind {
    Hedge,
    Fence,
    Wall,
}

/// A barrier along a garden.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fence {
    pub kind: BarrierKind,
    pub line: Vec<MapPoint>,
    /// A point of the line.
    pub gate: Option<MapPoint>,
    /// Index of the home whose garden it bounds.
    pub home: usize,
}

impl Fence {
    /// The parts that stop a robot.
    pub fn standing(&self) -> Vec<Segment> {
        let mut parts = Vec::new();
        for stretch in segments(&self.line) {
            let length = stretch.length();
            let cut = GATE_HALF_WIDTH_M / length.max(1e-9);
            let is_gate = |p: MapPoint| self.gate.is_some_and(|gate| gate.distance(p) < 0.01);
            let from = if is_gate(stretch.start) { cut } else { 0.0 };
            let to = if is_gate(stretch.end) { 1.0 - cut } else { 1.0 };
            if from < to {
                parts.push(stretch.part(from, to));
            }
        }
        parts
    }
}

/// An area without walls.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Patch {
    pub outer: Vec<MapPoint>,
    pub key: &'static str,
    pub value: &'static str,
}

/// A thing on a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Thing {
    pub at: MapPoint,
    pub key: &'static str,
    pub value: &'static str,
}

/// A whole neighbourhood.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plan {
    pub half: Half,
    pub streets: Vec<Street>,
    pub paths: Vec<Path>,
    pub homes: Vec<Home>,
    pub outbuildings: Vec<Outbuilding>,
    pub fences: Vec<Fence>,
    pub patches: Vec<Patch>,
    pub things: Vec<Thing>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gate_opens_a_fence() {
        let p = MapPoint::new;
        let fence = Fence {
            kind: BarrierKind::Hedge,
            line: vec![p(0.0, 0.0), p(5.0, 0.0), p(10.0, 0.0)],
            gate: Some(p(5.0, 0.0)),
            home: 0,
        };
        let ends: Vec<[f64; 2]> = fence
            .standing()
            .iter()
            .map(|part| [part.start.x, part.end.x])
            .collect();
        let expected = [
            [0.0, 5.0 - GATE_HALF_WIDTH_M],
            [5.0 + GATE_HALF_WIDTH_M, 10.0],
        ];
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert_eq!(ends.len(), 2);
        let pairs = ends.iter().flatten().zip(expected.iter().flatten());
        assert!(pairs.clone().all(|(a, b)| near(*a, *b)), "{ends:?}");
    }

    #[test]
    fn a_street_has_a_pose_everywhere() {
        let p = MapPoint::new;
        let street = Street {
            class: Class::Living,
            line: vec![p(0.0, 0.0), p(10.0, 0.0), p(10.0, 5.0)],
            width: 5.0,
            joints: Vec::new(),
        };
        assert_eq!(street.pose_at(4.0).point(), p(4.0, 0.0));
        assert_eq!(street.pose_at(12.0).point(), p(10.0, 2.0));
        assert_eq!(street.pose_at(99.0).point(), p(10.0, 5.0));
    }
}
