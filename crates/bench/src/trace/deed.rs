//! What an agent does besides driving: as much of it as enters a trace.

use openbench_core::{
    AcceptedPose, Address, Event, GiveUp, Health, Hypothesis, MapComparison, MapPoint, ModelUse,
    PlaceScores, Plan, Pose2, PoseEstimate, Stage,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::computing::Computing;

/// A number in JSON, where what is not finite is null.
///
/// Agents may report anything. JSON has no NaN and no infinity, so all of them become NaN here, in
/// the trace as in its recording.
#[derive(Debug, Clone, Copy)]
pub struct Number(f64);

impl Number {
    /// A number; infinities become NaN.
    pub fn new(value: f64) -> Self {
        Self(if value.is_finite() { value } else { f64::NAN })
    }

    /// Its value.
    pub fn value(self) -> f64 {
        self.0
    }
}

/// By bits: a recording that is read again is equal, and 0.0 is not -0.0.
impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Some(self.0).filter(|v| v.is_finite()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Option::<f64>::deserialize(deserializer)?;
        Ok(Self::new(value.unwrap_or(f64::NAN)))
    }
}

/// A point in the `map` frame, metres: x, y.
type Point = [Number; 2];

fn point(at: MapPoint) -> Point {
    [at.x, at.y].map(Number::new)
}

fn map_point(at: Point) -> MapPoint {
    MapPoint::new(at[0].value(), at[1].value())
}

/// What an agent does besides driving.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Deed {
    /// It could not begin.
    Refused(GiveUp),
    /// It made a plan.
    Planned(Plan),
    /// What it did from then on.
    Began(Stage),
    /// It planned a route over roads, points in `map`.
    Routed(Vec<Point>),
    /// It estimated its pose: x, y in metres, yaw in radians.
    Estimated([Number; 3], Health),
    /// It estimated its pose at an earlier instant, nanoseconds: it is behind with its work.
    EstimatedAt([Number; 3], Health, u64),
    /// It looked for itself on its map.
    Compared(Comparison),
    /// It wrote a door into its map.
    WroteDoor(Address, Point),
    /// It read a plate.
    Read(Reading),
    /// It reported its use of models so far; without latency.
    Asked(ModelUse),
    /// What it computed in the whole episode, at its end.
    Computed(Computing),
    /// It declared a delivery.
    Delivered(Address),
    /// It gave up deliveries.
    GaveUp(GiveUp),
}

/// What an agent found when it looked for itself on its map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Poses that it may have: x, y in metres, yaw in radians, probability.
    pub hypotheses: Vec<[Number; 4]>,
    /// The pose that it goes by.
    pub accepted: Option<Accepted>,
    /// Whether what it saw did not confirm that pose.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub refused: bool,
    /// Facades that it saw, in whole centimetres.
    pub facades: Vec<[i64; 2]>,
    /// How well all places fit, while it does not know where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub places: Option<Places>,
}

/// How well places fit what an agent saw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Places {
    /// South-west corner.
    pub origin: Point,
    /// Side of a cell, metres.
    pub cell_m: Number,
    /// Columns.
    pub width: usize,
    /// Scores, row by row: 0 to 100, -1 where the agent cannot be.
    pub cells: Vec<i8>,
}

impl Places {
    fn of(scores: &PlaceScores) -> Self {
        Self {
            origin: point(scores.origin),
            cell_m: Number::new(scores.cell_m),
            width: scores.width,
            cells: scores.cells.clone(),
        }
    }

    fn reported(&self) -> PlaceScores {
        PlaceScores {
            origin: map_point(self.origin),
            cell_m: self.cell_m.value(),
            width: self.width,
            cells: self.cells.clone(),
        }
    }
}

/// A pose that an agent goes by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Accepted {
    /// x, y in metres, yaw in radians.
    pub pose: [Number; 3],
    /// Its covariance: m² and rad².
    pub covariance: [[Number; 3]; 3],
}

impl Comparison {
    fn of(comparison: &MapComparison) -> Self {
        let hypotheses = comparison.hypotheses.iter();
        // What lies beyond the range of an i64 is cut off.
        let centimetres = |metres: f64| (metres * 100.0).round() as i64;
        let is_finite = |at: &&MapPoint| at.x.is_finite() && at.y.is_finite();
        Self {
            hypotheses: hypotheses
                .map(|one| [one.pose.x, one.pose.y, one.pose.yaw, one.probability].map(Number::new))
                .collect(),
            accepted: comparison.accepted.map(|own| Accepted {
                pose: [own.pose.x, own.pose.y, own.pose.yaw].map(Number::new),
                covariance: own.covariance.map(|row| row.map(Number::new)),
            }),
            refused: comparison.is_refused,
            facades: comparison
                .facades
                .iter()
                .filter(is_finite)
                .map(|at| [centimetres(at.x), centimetres(at.y)])
                .collect(),
            places: comparison.places.as_ref().map(Places::of),
        }
    }

    /// The same as agents report it.
    pub fn reported(&self) -> MapComparison {
        let pose = |[x, y, yaw]: [Number; 3]| Pose2::new(x.value(), y.value(), yaw.value());
        let hypotheses = self.hypotheses.iter().map(|one| Hypothesis {
            pose: pose([one[0], one[1], one[2]]),
            probability: one[3].value(),
        });
        let metres = |centimetres: i64| centimetres as f64 / 100.0;
        let facades = self.facades.iter();
        MapComparison {
            hypotheses: hypotheses.collect(),
            accepted: self.accepted.map(|own| AcceptedPose {
                pose: pose(own.pose),
                covariance: own.covariance.map(|row| row.map(Number::value)),
            }),
            is_refused: self.refused,
            facades: facades
                .map(|at| MapPoint::new(metres(at[0]), metres(at[1])))
                .collect(),
            places: self.places.as_ref().map(Places::reported),
        }
    }
}

/// A plate as it was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reading {
    /// The text.
    pub text: String,
    /// Confidence of the reader, 0 to 1.
    pub confidence: Number,
    /// Corners of the text, pixels, clockwise from the top left.
    pub corners: [Point; 4],
}

impl Reading {
    /// The confidence as readers give it.
    pub fn confidence(&self) -> f32 {
        self.confidence.value() as f32
    }

    /// The corners as readers give them.
    pub fn corners(&self) -> [[f32; 2]; 4] {
        self.corners.map(|corner| corner.map(|c| c.value() as f32))
    }
}

impl Deed {
    /// What an event adds to a trace; `None` for events that are for logs alone.
    pub fn of(event: &Event) -> Option<Self> {
        Some(match event {
            Event::Plan(plan) => Self::Planned(plan.clone()),
            Event::Stage(stage) => Self::Began(*stage),
            Event::Route(points) => Self::Routed(points.iter().map(|p| point(*p)).collect()),
            Event::PoseEstimate(PoseEstimate { pose, health }) => {
                Self::Estimated([pose.x, pose.y, pose.yaw].map(Number::new), *health)
            }
            Event::MapComparison(comparison) => Self::Compared(Comparison::of(comparison)),
            Event::DoorWritten { address, position } => {
                Self::WroteDoor(address.clone(), point(*position))
            }
            Event::PlateRead {
                text,
                confidence,
                corners,
                ..
            } => Self::Read(Reading {
                text: text.clone(),
                confidence: Number::new(f64::from(*confidence)),
                corners: corners.map(|corner| corner.map(|c| Number::new(f64::from(c)))),
            }),
            // Without the time until the answers, which is the machine's: episodes repeat.
            Event::Models(used) => Self::Asked(ModelUse {
                latency_ms: 0,
                ..*used
            }),
            Event::Task(_)
            | Event::Path(_)
            | Event::Costmap(_)
            | Event::Waypoints(_)
            | Event::Work(_)
            | Event::WallTime(_)
            | Event::Note(_) => return None,
        })
    }

    /// The points of a route.
    pub fn route(points: &[[Number; 2]]) -> Vec<MapPoint> {
        points.iter().map(|p| map_point(*p)).collect()
    }

    /// A position in the `map` frame.
    pub fn position(at: [Number; 2]) -> MapPoint {
        map_point(at)
    }

    /// An estimated pose.
    pub fn estimate([x, y, yaw]: [Number; 3], health: Health) -> PoseEstimate {
        let pose = Pose2::new(x.value(), y.value(), yaw.value());
        PoseEstimate { pose, health }
    }
}

/// A deed and its time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedDeed {
    /// Number of steps of 50 ms before it.
    pub step: u32,
    /// The deed.
    #[serde(rename = "do")]
    pub deed: Deed,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_is_null_in_json_and_nan_again() {
        let pose = Pose2::new(f64::INFINITY, -0.0, 0.1 + 0.2);
        let estimate = PoseEstimate {
            pose,
            health: Health::Lost,
        };
        let deed = Deed::of(&Event::PoseEstimate(estimate)).unwrap();
        let json = serde_json::to_string(&deed).unwrap();
        assert_eq!(
            json,
            r#"{"estimated":[[null,-0.0,0.30000000000000004],"lost"]}"#
        );
        assert_eq!(serde_json::from_str::<Deed>(&json).unwrap(), deed);
    }

    #[test]
    fn a_comparison_is_kept_with_its_facades_to_the_centimetre() {
        let pose = Pose2::new(0.1 + 0.2, f64::NAN, 1.0);
        let found = MapComparison {
            hypotheses: vec![Hypothesis {
                pose,
                probability: 0.3,
            }],
            accepted: Some(AcceptedPose {
                pose: Pose2::new(1.0, 2.0, 3.0),
                covariance: [[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]],
            }),
            is_refused: true,
            facades: vec![MapPoint::new(1.234, -5.678), MapPoint::new(f64::NAN, 0.0)],
            places: Some(PlaceScores {
                origin: MapPoint::new(-0.3, 1e6),
                cell_m: 2.5,
                width: 2,
                cells: vec![0, 100, -1, 7],
            }),
        };
        let deed = Deed::of(&Event::MapComparison(found.clone())).unwrap();
        let json = serde_json::to_string(&deed).unwrap();
        let Deed::Compared(again) = serde_json::from_str(&json).unwrap() else {
            panic!("{json}")
        };
        assert_eq!(deed, Deed::Compared(again.clone()));
        let again = again.reported();
        assert_eq!(again.accepted, found.accepted);
        assert!(again.is_refused);
        assert_eq!(again.places, found.places);
        assert_eq!(again.facades, [MapPoint::new(1.23, -5.68)]);
        assert!(again.hypotheses[0].pose.y.is_nan());
        assert_eq!(again.hypotheses[0].pose.x, pose.x);
    }

    #[test]
    fn single_precision_is_kept_to_the_bit() {
        let corners = [[0.1, 0.2], [1e-30, 3e30], [f32::NAN, 0.7], [5.5, -0.0]];
        let reading = Reading {
            text: "UNIT 1".into(),
            confidence: Number::new(f64::from(0.9_f32)),
            corners: corners.map(|corner| corner.map(|c| Number::new(f64::from(c)))),
        };
        let json = serde_json::to_string(&reading).unwrap();
        let again: Reading = serde_json::from_str(&json).unwrap();
        assert_eq!(again.confidence(), 0.9);
        let bits = |corners: [[f32; 2]; 4]| corners.map(|corner| corner.map(f32::to_bits));
        assert_eq!(bits(again.corners())[1], bits(corners)[1]);
        assert!(again.corners()[2][0].is_nan());
    }
}
