//! What is observed, asked and rewarded.

use std::num::NonZeroU32;

use openbench_bench::suite::GoalKind;
use openbench_sim::lidar::Scanning;

use crate::error::EnvironmentError;

/// Largest number of steps that an action lasts: ten seconds.
const MOST_STEPS: u32 = 200;
/// Steps from the end of a scan to that of the next.
const STEPS_PER_SCAN: u32 = 2;
/// Largest number of rows and columns of an image of distances.
const MOST_PIXELS: usize = 1024;
/// Fewest rays that are cast: of one firing in so many.
const MOST_FIRINGS: u32 = 100;
/// Largest distance of a start, metres.
const FARTHEST_M: f64 = 1000.0;
/// Longest time limit, seconds.
const LONGEST_S: f64 = 86_400.0;

/// What an environment observes, asks and rewards.
///
/// ```
/// use openbench_bench::suite::GoalKind;
/// use openbench_environment::{Declaration, Observe, Options, PoseSource, RangeImage};
///
/// // A place to drive to, seen from where the wheels say that the robot is.
/// let options = Options {
///     goal: GoalKind::Point,
///     observe: Observe {
///         range_image: Some(RangeImage { rows: 2, columns: 36 }),
///         pose: Some(PoseSource::Wheels),
///         ..Observe::default()
///     },
///     declaration: Declaration::Arrival(1.0),
///     ..Options::default()
/// };
/// assert!(options.check().is_ok());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The arrays of an observation.
    pub observe: Observe,
    /// What policies are told to do.
    pub goal: GoalKind,
    /// How far from the door episodes begin; `None` for the start of the world, as in a run.
    pub start: Option<StartDistance>,
    /// Steps of 50 ms that an action lasts.
    pub steps_per_action: u32,
    /// What the first two numbers of an action are.
    pub actions: Actions,
    /// Who declares a delivery.
    pub declaration: Declaration,
    /// What is rewarded.
    pub rewards: Rewards,
    /// Simulated time from the first observation after which an episode is truncated, seconds;
    /// `None` for the benchmark's, which counts the rest at the beginning, too.
    pub time_limit_s: Option<f64>,
}

impl Options {
    /// Checks that the options make sense.
    ///
    /// # Errors
    /// [`EnvironmentError::Option`] of the first one that does not.
    pub fn check(&self) -> Result<(), EnvironmentError> {
        let refuse = |option, problem: &str| {
            let problem = problem.to_owned();
            Err(EnvironmentError::Option { option, problem })
        };
        if !(1..=MOST_STEPS).contains(&self.steps_per_action) {
            return refuse("steps_per_action", "write 1 to 200");
        }
        if let Some(size) = self.observe.range_image {
            let sides = 1..=MOST_PIXELS;
            if !sides.contains(&size.rows) || !sides.contains(&size.columns) {
                return refuse("range_image", "write 1 to 1024 rows and columns");
            }
        }
        if self.observe.one_firing_in.get() > MOST_FIRINGS {
            return refuse("one_firing_in", "write 1 to 100");
        }
        if let Some(start) = self.start
            && !(0.0 <= start.least && start.least < start.largest && start.largest <= FARTHEST_M)
        {
            return refuse(
                "start",
                "write two distances in ascending order, at most 1000 m",
            );
        }
        if self.actions == Actions::Waypoint && self.observe.pose.is_none() {
            return refuse("actions", "waypoints need an observed pose");
        }
        if let Declaration::Arrival(radius) = self.declaration
            && !(radius > 0.0 && radius <= 2.0)
        {
            return refuse("declaration", "write a distance of at most 2 m");
        }
        let is_limit = |seconds: f64| seconds > 0.0 && seconds <= LONGEST_S;
        if !self.time_limit_s.is_none_or(is_limit) {
            return refuse("time_limit", "write seconds, at most a day");
        }
        let Rewards {
            progress,
            success,
            failure,
            contact,
            time,
        } = self.rewards;
        if ![progress, success, failure, contact, time]
            .iter()
            .all(|r| r.is_finite())
        {
            return refuse("rewards", "write finite numbers");
        }
        Ok(())
    }
}

impl Observe {
    /// Whether scans are observed.
    pub(crate) fn sees_scans(&self) -> bool {
        self.points || self.range_image.is_some()
    }

    /// Whether scans are observed, or odometry needs them.
    pub fn needs_scans(&self) -> bool {
        self.sees_scans() || self.pose == Some(PoseSource::Odometry)
    }

    /// What the LiDAR does during a step, after which the action has so many more. Of an action's
    /// scans the last one is observed, and odometry needs all.
    pub(crate) fn scanning(&self, steps_left: u32) -> Scanning {
        let is_last = steps_left < STEPS_PER_SCAN;
        let is_used = self.sees_scans() && is_last;
        if is_used || self.pose == Some(PoseSource::Odometry) {
            Scanning::OneFiringIn(self.one_firing_in)
        } else {
            Scanning::Off
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            observe: Observe::default(),
            goal: GoalKind::Instruction,
            start: None,
            steps_per_action: 1,
            actions: Actions::Velocity,
            declaration: Declaration::Policy,
            rewards: Rewards::default(),
            time_limit_s: None,
        }
    }
}

/// The arrays of an observation. What is not asked for costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Observe {
    /// The camera's image.
    pub image: bool,
    /// The points of the last scan.
    pub points: bool,
    /// The last scan as an image of distances.
    pub range_image: Option<RangeImage>,
    /// The rays of one firing in so many are cast; 1 is the real LiDAR. A coarse image of distances
    /// needs few, and rays are most of the time of a step.
    pub one_firing_in: NonZeroU32,
    /// The samples of the IMU since the last observation.
    pub imu: bool,
    /// Speeds from the wheels.
    pub wheels: bool,
    /// An estimate of the pose, by this means. A goal that is a point is seen from it.
    pub pose: Option<PoseSource>,
}

impl Default for Observe {
    fn default() -> Self {
        Self {
            image: false,
            points: false,
            range_image: None,
            one_firing_in: NonZeroU32::MIN,
            imu: false,
            wheels: false,
            pose: None,
        }
    }
}

/// Size of an image of distances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RangeImage {
    /// Rows, from the highest rays to the lowest.
    pub rows: usize,
    /// Columns, from behind the robot by its left, front and right.
    pub columns: usize,
}

impl Default for RangeImage {
    fn default() -> Self {
        Self {
            rows: 8,
            columns: 120,
        }
    }
}

/// Where an estimate of the pose comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseSource {
    /// Distance from the wheels, heading from the gyroscope.
    Wheels,
    /// LiDAR-inertial odometry. The robot stands still until it is ready.
    Odometry,
}

/// Least and largest length of the shortest way to the door at the beginning, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartDistance {
    /// Least.
    pub least: f64,
    /// Largest.
    pub largest: f64,
}

/// What the first two numbers of an action are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Actions {
    /// Linear velocity, m/s, and angular velocity, rad/s.
    Velocity,
    /// A point in `base_link`, metres ahead and to the left, which the robot drives to by pure
    /// pursuit, from where it takes itself to be. It waits there for the end of the action.
    Waypoint,
}

/// Who declares a delivery.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Declaration {
    /// The policy, by an action whose third number is above 0.5.
    Policy,
    /// The environment, when the robot is nearer to the place before the door than this, metres. It
    /// uses the truth, so results of such episodes are those of training.
    Arrival(f64),
}

/// What is rewarded. All of it uses the truth, which no observation has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rewards {
    /// For each metre by which the shortest way to the door became shorter.
    pub progress: f64,
    /// For a delivery at the right door (2 m).
    pub success: f64,
    /// For any other end of a delivery but the end of time.
    pub failure: f64,
    /// For each second in contact with an obstacle.
    pub contact: f64,
    /// For each second.
    pub time: f64,
}

impl Default for Rewards {
    fn default() -> Self {
        Self {
            progress: 1.0,
            success: 10.0,
            failure: -5.0,
            contact: -1.0,
            time: -0.05,
        }
    }
}
