//! The border between the `map` frame of a briefing and the frame that an agent works in.
//!
//! A briefing may be in raw UTM, thousands of kilometres from the origin. Behind the border the
//! origin is near the start, so that costmaps, sightings and scans in single precision keep their
//! last digits. Both frames belong to one projection and differ by their false origins alone,
//! without rotation or scale.

use openbench_core::{
    AcceptedPose, Briefing, CostGrid, Event, Events, GnssFix, Goal, Hypothesis, MapComparison,
    MapPoint, Observation, PlaceScores, Pose2, PoseEstimate,
};

/// A start nearer to the origin than this keeps its frame.
const NEAR_M: f64 = 500.0;

/// Translates between both frames.
///
/// ```
/// use std::time::Duration;
///
/// use openbench_agents::Border;
/// use openbench_core::{Briefing, Goal, MapPoint, Pose2, RobotDescription, Start};
///
/// // A start in raw UTM coordinates, zone 33 north: Krems on the Danube.
/// let briefing = Briefing {
///     map_osm: Vec::new(),
///     georeference: "utm:33N,0,0".parse().unwrap(),
///     goal: Goal::Point(MapPoint::new(544_760.0, 5_362_020.0)),
///     start: Start::exact(Pose2::new(544_700.0, 5_362_000.0, 0.0)),
///     robot: RobotDescription::sentry(),
///     time_limit: Duration::from_secs(600),
/// };
/// let (_, inner) = Border::of(&briefing);
/// let start = inner.start.about().unwrap();
/// assert!(start.distance(MapPoint::default()) < 500.0);
/// let Goal::Point(goal) = inner.goal else { unreachable!() };
/// assert!((goal.distance(start) - 63.25).abs() < 0.01);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Border {
    /// Coordinates of the briefing's frame less those of the inner frame, metres.
    shift: MapPoint,
}

impl Border {
    /// The border of a briefing, and the briefing in the inner frame.
    pub fn of(briefing: &Briefing) -> (Self, Briefing) {
        // An agent that may be anywhere keeps the frame of its map.
        let start = briefing.start.about().unwrap_or_default();
        if start.distance(MapPoint::default()) <= NEAR_M {
            return (Self::default(), briefing.clone());
        }
        // The same projection with its origin near the start. A frame's coordinates are those of
        // the projection plus its offset, so the difference of the offsets is the shift.
        let georeference = briefing.georeference.about(start);
        let (outer, inner) = (briefing.georeference.offset(), georeference.offset());
        let border = Self {
            shift: MapPoint::new(outer.x - inner.x, outer.y - inner.y),
        };
        let goal = match &briefing.goal {
            Goal::Point(point) => Goal::Point(border.inwards(*point)),
            goal => goal.clone(),
        };
        let start = briefing.start.shifted(border.inwards(MapPoint::default()));
        (
            border,
            Briefing {
                georeference,
                goal,
                start,
                ..briefing.clone()
            },
        )
    }

    /// The satellite fix of an observation in the inner frame.
    pub fn fix(&self, observation: &Observation<'_>) -> Option<GnssFix> {
        let fix = *observation.gnss?;
        let [x, y, z] = fix.position;
        Some(GnssFix {
            position: [x - self.shift.x, y - self.shift.y, z],
            ..fix
        })
    }

    /// A recorder that translates events into the briefing's frame.
    pub fn events<'a>(&self, events: &'a mut dyn Events) -> Outwards<'a> {
        Outwards {
            border: *self,
            events,
        }
    }

    fn inwards(&self, point: MapPoint) -> MapPoint {
        MapPoint::new(point.x - self.shift.x, point.y - self.shift.y)
    }

    fn outwards(&self, point: MapPoint) -> MapPoint {
        MapPoint::new(point.x + self.shift.x, point.y + self.shift.y)
    }

    fn pose_outwards(&self, pose: Pose2) -> Pose2 {
        Pose2::new(pose.x + self.shift.x, pose.y + self.shift.y, pose.yaw)
    }

    fn comparison_outwards(&self, comparison: MapComparison) -> MapComparison {
        let hypotheses = comparison.hypotheses.into_iter().map(|one| Hypothesis {
            pose: self.pose_outwards(one.pose),
            ..one
        });
        let accepted = comparison.accepted.map(|accepted| AcceptedPose {
            pose: self.pose_outwards(accepted.pose),
            ..accepted
        });
        let facades = comparison.facades.into_iter();
        let places = comparison.places.map(|places| PlaceScores {
            origin: self.outwards(places.origin),
            ..places
        });
        MapComparison {
            hypotheses: hypotheses.collect(),
            accepted,
            is_refused: comparison.is_refused,
            facades: facades.map(|at| self.outwards(at)).collect(),
            places,
        }
    }

    fn event_outwards(&self, event: Event) -> Event {
        let points = |points: Vec<MapPoint>| points.into_iter().map(|p| self.outwards(p)).collect();
        match event {
            Event::Route(route) => Event::Route(points(route)),
            Event::Path(path) => Event::Path(points(path)),
            Event::Costmap(grid) => Event::Costmap(CostGrid {
                origin: self.outwards(grid.origin),
                ..grid
            }),
            Event::PoseEstimate(PoseEstimate { pose, health }) => {
                Event::PoseEstimate(PoseEstimate {
                    pose: self.pose_outwards(pose),
                    health,
                })
            }
            Event::MapComparison(comparison) => {
                Event::MapComparison(self.comparison_outwards(comparison))
            }
            Event::Waypoints(poses) => Event::Waypoints(
                poses
                    .into_iter()
                    .map(|pose| self.pose_outwards(pose))
                    .collect(),
            ),
            Event::PlateRead {
                text,
                confidence,
                corners,
                position,
                image,
            } => {
                let position = position.map(|p| self.outwards(p));
                Event::PlateRead {
                    text,
                    confidence,
                    corners,
                    position,
                    image,
                }
            }
            Event::DoorWritten { address, position } => Event::DoorWritten {
                address,
                position: self.outwards(position),
            },
            // Without coordinates. The match names all variants, so that an event with a position
            // that is added later does not pass through untranslated.
            Event::Plan(_)
            | Event::Task(_)
            | Event::Stage(_)
            | Event::Models(_)
            | Event::Work(_)
            | Event::WallTime(_)
            | Event::Note(_) => event,
        }
    }
}

/// Records events of the inner frame in the briefing's frame.
pub struct Outwards<'a> {
    border: Border,
    events: &'a mut dyn Events,
}

impl Events for Outwards<'_> {
    fn record(&mut self, event: Event) {
        self.events.record(self.border.event_outwards(event));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_on_the_map_is_told_in_the_frame_of_the_briefing() {
        let border = Border {
            shift: MapPoint::new(5000.0, -300.0),
        };
        let mut told = Vec::new();
        let pose = Pose2::new(1.0, 2.0, 0.5);
        let covariance = [[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]];
        let places = |origin| PlaceScores {
            origin,
            cell_m: 2.0,
            width: 1,
            cells: vec![100],
        };
        border
            .events(&mut told)
            .record(Event::MapComparison(MapComparison {
                hypotheses: vec![Hypothesis {
                    pose,
                    probability: 0.9,
                }],
                accepted: Some(AcceptedPose { pose, covariance }),
                is_refused: true,
                facades: vec![MapPoint::new(7.0, 8.0)],
                places: Some(places(MapPoint::new(-9.0, 4.0))),
            }));
        let pose = Pose2::new(5001.0, -298.0, 0.5);
        let outer = MapComparison {
            hypotheses: vec![Hypothesis {
                pose,
                probability: 0.9,
            }],
            accepted: Some(AcceptedPose { pose, covariance }),
            is_refused: true,
            facades: vec![MapPoint::new(5007.0, -292.0)],
            places: Some(places(MapPoint::new(4991.0, -296.0))),
        };
        assert_eq!(told, [Event::MapComparison(outer)]);
    }
}
