//! Where the robot is, and what its LiDAR shows there.

use openbench_core::frames::wrap_angle;
use openbench_core::{
    Event, Events, Health, MapPoint, Observation, Pose2, PoseEstimate, RobotDescription, Work,
};
use openbench_localization::Localizer;
use openbench_localization::registration::BuildingOffset;
use openbench_motion::RangeRing;

use crate::open::perception::Perception;

/// Localizers correct the pose slowly. A correction that is longer at once is a jump, metres,
const JUMP_M: f64 = 0.1;
/// or one that turns it further, radians.
const JUMP_RAD: f64 = 0.05;
/// A pending correction of the pose from which on it is noted.
const NOTABLE_CORRECTION_M: f64 = 0.3;

/// What a localizer found out about the robot's place on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// The robot is so many metres from where it was thought to be; that may turn out wrong if
    /// [`Senses::is_located`] does not hold.
    Found(f64),
    /// The robot is not where it was thought to be.
    Lost,
}

/// A change of the pose of `odom` in `map`. What was seen stays where it is in `odom`, and so moves
/// on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// The pose of `odom` in `map` as it was known before,
    pub before: Pose2,
    /// and as it is known now.
    pub after: Pose2,
}

impl Correction {
    /// The position of something that was seen at a point of the map.
    pub fn point(&self, seen: MapPoint) -> MapPoint {
        self.pose(Pose2::new(seen.x, seen.y, 0.0)).point()
    }

    /// The position and direction of something that was seen there, facing so.
    pub fn pose(&self, seen: Pose2) -> Pose2 {
        self.after.compose(seen.seen_from(self.before))
    }
}

/// What an observation says.
pub struct Sensed {
    /// The ground around the robot, if a scan shows it.
    pub ring: Option<RangeRing>,
    /// How the pose of `odom` in `map` changed, if it did.
    pub correction: Option<Correction>,
    /// What was found out about the place of the robot.
    pub finding: Option<Finding>,
}

/// The localizer, and the scans of the last second.
pub struct Senses {
    robot: RobotDescription,
    localizer: Box<dyn Localizer>,
    perception: Perception,
    /// Whether a notable correction of the pose is pending.
    correcting: bool,
    /// Whether the localizer knew where the robot is on the map,
    is_located: bool,
    /// or where it probably is.
    is_presumed: bool,
    /// How many registrations to the map were reported.
    map_registrations: u64,
}

impl Senses {
    /// Of a robot with a localizer that has begun.
    pub fn new(robot: RobotDescription, localizer: Box<dyn Localizer>) -> Self {
        Self {
            perception: Perception::new(robot.clone()),
            correcting: false,
            is_located: localizer.is_located(),
            is_presumed: localizer.is_presumed(),
            map_registrations: 0,
            robot,
            localizer,
        }
    }

    /// Takes in all that the sensors measured, but images.
    pub fn take(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Sensed {
        let before = self.localizer.odom();
        self.localizer.update(observation);
        // By what was known before it.
        let work = if self.is_located {
            Work::MapRegistration
        } else {
            Work::MapSearch
        };
        let registrations = self.localizer.map_registrations();
        for _ in self.map_registrations..registrations {
            events.record(Event::Work(work));
        }
        if registrations > self.map_registrations
            && let Some(comparison) = self.localizer.comparison()
        {
            events.record(Event::MapComparison(comparison));
        }
        self.map_registrations = registrations;
        let correction = Correction {
            before,
            after: self.localizer.odom(),
        };
        let finding = self.finding(&correction);
        let ring = observation.scan.map(|scan| {
            if self.localizer.registers_scans() {
                events.record(Event::Work(Work::Registration));
            }
            events.record(Event::Work(Work::Mapping));
            // After the localizer took in the same observation: the scan is undistorted with its
            // poses.
            self.perception.observe(scan, self.localizer.as_ref())
        });
        Sensed {
            ring,
            correction: (correction.before != correction.after).then_some(correction),
            finding,
        }
    }

    /// From the correction by the newest observation.
    fn finding(&mut self, correction: &Correction) -> Option<Finding> {
        let (was_located, was_placed) = (self.is_located, self.is_placed());
        self.is_located = self.localizer.is_located();
        self.is_presumed = self.localizer.is_presumed();
        let pose = self.pose();
        let thought = correction.before.compose(pose.seen_from(correction.after));
        let away = pose.point().distance(thought.point());
        let is_jump = away > JUMP_M || wrap_angle(pose.yaw - thought.yaw).abs() > JUMP_RAD;
        match (was_placed, self.is_placed()) {
            (false, true) => self.found(away),
            (true, true) if !was_located && is_jump => self.found(away),
            (true, false) => Some(Finding::Lost),
            _ => None,
        }
    }

    fn found(&mut self, away: f64) -> Option<Finding> {
        // Earlier scans are where the robot was thought to be.
        self.perception = Perception::new(self.robot.clone());
        Some(Finding::Found(away))
    }

    /// Notes a pending correction of the pose that is large enough to be visible.
    pub fn announce(&mut self, events: &mut dyn Events) {
        let pending = self.localizer.pending();
        if pending > NOTABLE_CORRECTION_M && !self.correcting {
            events.record(Event::Note(format!(
                "the pose turns out to be {pending:.1} m off and is corrected"
            )));
        }
        // Hysteresis: one correction that shrinks past the threshold and back is noted once.
        self.correcting = pending > NOTABLE_CORRECTION_M
            || self.correcting && pending > NOTABLE_CORRECTION_M / 2.0;
    }

    /// Whether the localizer knows where the robot is on the map.
    pub fn is_located(&self) -> bool {
        self.is_located
    }

    /// Whether it knows that, or where the robot probably is.
    pub fn is_placed(&self) -> bool {
        self.is_located || self.is_presumed
    }

    /// The newest pose: on the map if [`Senses::is_placed`].
    pub fn pose(&self) -> Pose2 {
        self.localizer.pose()
    }

    /// How far buildings are from where the map shows them, as far as it is known.
    pub fn building_offsets(&self) -> &[BuildingOffset] {
        self.localizer.building_offsets()
    }

    /// How far the pose can be trusted.
    pub fn health(&self) -> Health {
        self.localizer.health()
    }

    /// Whether the pose can be used already. The robot should stand still until then.
    pub fn is_ready(&self) -> bool {
        self.localizer.ready()
    }

    /// The pose and its health, to be recorded.
    pub fn estimate(&self) -> PoseEstimate {
        PoseEstimate {
            pose: self.pose(),
            health: self.health(),
        }
    }

    /// The scans of the last second.
    pub fn perception(&self) -> &Perception {
        &self.perception
    }
}
