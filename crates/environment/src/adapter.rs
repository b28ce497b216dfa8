//! The policy's side: sensor data to observations, actions to velocities.

use std::num::NonZeroU32;
use std::sync::Arc;

use openbench_core::{
    Image, ImuSample, LidarScan, MapPoint, Pose2, PoseEstimate, RobotDescription, SimTime, Velocity,
};
use openbench_localization::wheels::Wheels;
use openbench_localization::{DeadReckoning, LidarInertial, Localizer};
use openbench_sim::lidar::is_of_one_firing_in;

use crate::course::Course;
use crate::error::EnvironmentError;
use crate::observation::{self, IMU_SAMPLES, Observation};
use crate::options::{Observe, Options, PoseSource};

/// Rest at the beginning of a short episode. The gyroscope's bias is then known to 2e-4 rad/s, less
/// than a degree in a minute.
const SHORT_REST: SimTime = SimTime::from_millis(500);

/// What a policy sees and does, between it and any source of sensor data: an
/// [`Environment`](crate::Environment) in training, a run of the benchmark afterwards.
///
/// ```
/// use openbench_bench::{Prepared, Rollout, builtin_suite};
/// use openbench_core::{Action, Velocity};
/// use openbench_environment::{Adapter, Observe, Options, RangeImage};
///
/// let size = RangeImage { rows: 2, columns: 36 };
/// let options = Options {
///     observe: Observe { range_image: Some(size), ..Observe::default() },
///     ..Options::default()
/// };
/// let prepared = Prepared::new(builtin_suite("small")?, None)?;
/// let mut rollout = Rollout::new(&prepared, 0, 7)?;
/// let briefing = rollout.briefing();
/// let mut adapter = Adapter::new(&options, &briefing.robot, briefing.start_pose()?, None)?;
/// while !adapter.is_ready(rollout.observation().time) {
///     rollout.step(Action::Drive(Velocity::ZERO));
///     adapter.take(&rollout.observation());
/// }
/// assert_eq!(adapter.observation().range_image.len(), 2 * 36);
/// adapter.begin([0.3, 0.0]);
/// assert_eq!(adapter.velocity(rollout.observation().time), Velocity::new(0.3, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Adapter {
    observe: Observe,
    /// Rows of the array of IMU samples.
    imu_rows: usize,
    /// Whether episodes begin near their door.
    is_short: bool,
    goal: Option<MapPoint>,
    course: Course,
    localizer: Option<Box<dyn Localizer + Send>>,
    scan: Option<LidarScan>,
    image: Option<Arc<Image>>,
    imu: Vec<ImuSample>,
    wheels: Wheels,
    speeds: [f32; 2],
}

impl Adapter {
    /// For a robot at the start of an episode, both in `map`. A `goal` that is a point is seen from
    /// the estimated pose.
    ///
    /// # Errors
    /// [`EnvironmentError::Option`] of actions that the robot cannot do.
    pub fn new(
        options: &Options,
        robot: &RobotDescription,
        start: Pose2,
        goal: Option<MapPoint>,
    ) -> Result<Self, EnvironmentError> {
        let mut localizer: Option<Box<dyn Localizer + Send>> = match options.observe.pose {
            None => None,
            Some(PoseSource::Wheels) => Some(Box::new(DeadReckoning::new(robot.clone()))),
            Some(PoseSource::Odometry) => Some(Box::new(LidarInertial::new(robot.clone()))),
        };
        if let Some(localizer) = &mut localizer {
            localizer.reset(start);
        }
        Ok(Self {
            observe: options.observe.clone(),
            imu_rows: IMU_SAMPLES * options.steps_per_action as usize,
            is_short: options.start.is_some(),
            goal,
            course: Course::new(options.actions, robot)?,
            localizer,
            scan: None,
            image: None,
            imu: Vec::new(),
            wheels: Wheels::new(robot),
            speeds: [0.0; 2],
        })
    }

    /// Takes in what was sensed during a step of 50 ms; all but images.
    pub fn take(&mut self, sensed: &openbench_core::Observation<'_>) {
        if let Some(localizer) = &mut self.localizer {
            localizer.update(sensed);
        }
        if self.observe.sees_scans()
            && let Some(scan) = sensed.scan
        {
            // Into the memory of the last one.
            let seen = self.scan.get_or_insert_default();
            seen.clone_from(scan);
            let one_in = self.observe.one_firing_in;
            if one_in > NonZeroU32::MIN {
                // A run casts whole scans.
                seen.points
                    .retain(|point| is_of_one_firing_in(point, one_in));
            }
        }
        if self.observe.imu {
            self.imu.extend_from_slice(sensed.imu);
            self.imu
                .drain(..self.imu.len().saturating_sub(self.imu_rows));
        }
        for sample in sensed.wheels {
            if let Some(speed) = self.wheels.take(sample) {
                self.speeds = [speed.velocity.x as f32, speed.turn as f32];
            }
        }
    }

    /// Takes an image, if one is wanted and the camera has one.
    pub fn look(&mut self, sensed: &openbench_core::Observation<'_>) {
        if self.observe.image
            && let Some(image) = sensed.camera.image()
        {
            self.image = Some(image);
        }
    }

    /// Whether there is something to see at this time, and a pose. Until then the robot should
    /// stand.
    pub fn is_ready(&self, time: SimTime) -> bool {
        let is_blind = self.observe.sees_scans() && self.scan.is_none();
        !is_blind && self.has_pose(time)
    }

    /// Whether the localizer can be trusted at this time. Episodes that begin near their door do
    /// not need the last digits of the heading, for which the gyroscope rests for four seconds.
    fn has_pose(&self, time: SimTime) -> bool {
        let Some(localizer) = &self.localizer else {
            return true;
        };
        let is_short = self.is_short && self.observe.pose == Some(PoseSource::Wheels);
        localizer.ready() || (is_short && time >= SHORT_REST)
    }

    /// Where the robot takes itself to be, if that is observed.
    pub fn estimate(&self) -> Option<PoseEstimate> {
        let localizer = self.localizer.as_ref()?;
        Some(PoseEstimate {
            pose: localizer.pose(),
            health: localizer.health(),
        })
    }

    /// What the policy gets.
    pub fn observation(&self) -> Observation {
        let (observe, estimate) = (&self.observe, self.estimate());
        let scan = self.scan.as_ref();
        Observation {
            image: self.image.clone(),
            points: scan
                .filter(|_| observe.points)
                .map(observation::points_of)
                .unwrap_or_default(),
            range_image: observe
                .range_image
                .map(|size| observation::range_image_of(scan, size))
                .unwrap_or_default(),
            imu: if observe.imu {
                observation::imu_of(&self.imu, self.imu_rows)
            } else {
                Vec::new()
            },
            wheels: self.speeds,
            pose: estimate.map(|estimate| estimate.pose),
            health: estimate.map(|estimate| estimate.health).unwrap_or_default(),
            goal: estimate
                .zip(self.goal)
                .map(|(estimate, goal)| observation::seen_from(estimate.pose, goal)),
        }
    }

    /// Begins an action: two numbers as [`Actions`](crate::Actions) has them.
    pub fn begin(&mut self, action: [f64; 2]) {
        let pose = self.pose();
        self.course.begin(action, pose);
    }

    /// The velocity of the next step of the action that began last.
    pub fn velocity(&mut self, time: SimTime) -> Velocity {
        let pose = self.pose();
        self.course.velocity(time, pose)
    }

    fn pose(&self) -> Pose2 {
        let localizer = self.localizer.as_ref();
        localizer.map_or_else(Pose2::default, |localizer| localizer.pose())
    }
}
