//! How an answer of a policy becomes velocities.

use std::time::Duration;

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::follower::{Follower, FollowerError, Tolerance};
use openbench_motion::local::{LocalPlanner, Situation};

use super::question::{Answer, Step};

/// The end of a path is reached within this distance, at any heading, metres.
const END_M: f64 = 0.05;

/// What the robot does now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// It drives.
    Drive(Velocity),
    /// It declares the parcel delivered.
    Declare,
}

/// Follows the newest answer.
pub struct Driving {
    follower: Follower,
    /// How long a path is followed before the next question.
    replan: Duration,
    under_way: Option<UnderWay>,
}

/// An answer that is being followed.
#[derive(Debug, Clone, PartialEq)]
struct UnderWay {
    began: SimTime,
    course: Course,
}

#[derive(Debug, Clone, PartialEq)]
enum Course {
    Steps {
        period: Duration,
        steps: Vec<Step>,
    },
    /// In `map`.
    Path {
        points: Vec<MapPoint>,
        /// Mean speed along it, m/s.
        speed: Option<f64>,
    },
}

impl Driving {
    /// For a robot.
    ///
    /// # Errors
    /// A robot whose limits or sizes are none.
    pub fn new(robot: &RobotDescription, replan: Duration) -> Result<Self, FollowerError> {
        let tolerance = Tolerance {
            distance: END_M,
            yaw: std::f64::consts::PI,
        };
        Ok(Self {
            follower: Follower::new(robot.clone())?.with_tolerance(tolerance),
            replan,
            under_way: None,
        })
    }

    /// Follows an answer from now on, to a question that was asked at `pose`.
    pub fn follow(&mut self, answer: Answer, pose: Pose2, now: SimTime) {
        let course = match answer {
            Answer::Velocities { period_s, steps } => Course::Steps {
                // Sound answers have a period.
                period: Duration::try_from_secs_f64(period_s).unwrap_or_default(),
                steps,
            },
            Answer::Path { points, lasts_s } => path(pose, &points, lasts_s),
        };
        self.follower.reset();
        self.under_way = Some(UnderWay { began: now, course });
    }

    /// Forgets the answer that is followed.
    pub fn stop(&mut self) {
        self.under_way = None;
    }

    /// The path that is followed, in `map`; empty if it is none.
    pub fn path(&self) -> &[MapPoint] {
        match self.under_way.as_ref().map(|under_way| &under_way.course) {
            Some(Course::Path { points, .. }) => points,
            _ => &[],
        }
    }

    /// Whether the policy should be asked now.
    pub fn is_due(&self, now: SimTime) -> bool {
        let Some(UnderWay { began, course }) = &self.under_way else {
            return true;
        };
        let since = now.since(*began);
        match course {
            Course::Steps { period, steps } => step_at(steps, *period, since).is_none(),
            Course::Path { .. } => since >= self.replan,
        }
    }

    /// What the robot does now. It stands where an answer ends.
    pub fn command(&mut self, now: SimTime, pose: Pose2, velocity: Velocity) -> Command {
        let Some(UnderWay { began, course }) = &self.under_way else {
            return Command::Drive(Velocity::ZERO);
        };
        let (path, speed) = match course {
            Course::Steps { period, steps } => {
                return match step_at(steps, *period, now.since(*began)) {
                    Some(step) if step.declares => Command::Declare,
                    Some(step) => Command::Drive(step.velocity),
                    None => Command::Drive(Velocity::ZERO),
                };
            }
            Course::Path { points, speed } => (points, *speed),
        };
        let situation = Situation {
            time: now,
            pose,
            velocity,
            path,
            final_yaw: None,
            obstacles: &[],
        };
        // Without obstacles it is blocked only by a path that is none.
        let progress = self.follower.plan(&situation).ok();
        let wanted = progress.and_then(|progress| progress.velocity());
        Command::Drive(slowed(wanted.unwrap_or_default(), speed))
    }
}

/// A path from points in `base_link` of this pose.
fn path(pose: Pose2, points: &[MapPoint], lasts_s: Option<f64>) -> Course {
    let in_map = points.iter().map(|point| pose.transform(point.x, point.y));
    let points: Vec<MapPoint> = [pose.point()].into_iter().chain(in_map).collect();
    let length: f64 = points
        .windows(2)
        .map(|pair| pair[0].distance(pair[1]))
        .sum();
    let speed = lasts_s.map(|seconds| length / seconds);
    Course::Path { points, speed }
}

/// The step of an instant; `None` after the last one.
fn step_at(steps: &[Step], period: Duration, since: Duration) -> Option<&Step> {
    let index = since.as_nanos() / period.as_nanos().max(1);
    steps.get(usize::try_from(index).ok()?)
}

/// A velocity whose linear part is no faster than `speed`, on the same arc.
fn slowed(velocity: Velocity, speed: Option<f64>) -> Velocity {
    match speed {
        Some(speed) if velocity.linear > speed => {
            let share = speed / velocity.linear;
            Velocity::new(velocity.linear * share, velocity.angular * share)
        }
        _ => velocity,
    }
}

#[cfg(test)]
mod tests {
    use openbench_motion::kinematics::arc;

    use super::*;

    fn driving() -> Driving {
        Driving::new(&RobotDescription::sentry(), Duration::from_millis(500)).unwrap()
    }

    fn at(millis: u64) -> SimTime {
        SimTime::from_millis(millis)
    }

    fn drives(command: Command) -> Velocity {
        match command {
            Command::Drive(velocity) => velocity,
            Command::Declare => panic!("{command:?}"),
        }
    }

    #[test]
    fn velocities_last_a_period_each_and_then_it_stands() {
        let mut driving = driving();
        assert!(driving.is_due(at(0)));
        let step = |linear, declares| Step {
            velocity: Velocity::new(linear, 0.0),
            declares,
        };
        let answer = Answer::Velocities {
            period_s: 0.1,
            steps: vec![step(0.3, false), step(0.2, false), step(0.0, true)],
        };
        driving.follow(answer, Pose2::default(), at(1000));
        let command = |driving: &mut Driving, millis| {
            driving.command(at(millis), Pose2::default(), Velocity::ZERO)
        };
        for (millis, linear) in [(1000, 0.3), (1050, 0.3), (1100, 0.2), (1150, 0.2)] {
            assert_eq!(drives(command(&mut driving, millis)).linear, linear);
            assert!(!driving.is_due(at(millis)));
        }
        assert_eq!(command(&mut driving, 1200), Command::Declare);
        assert!(driving.is_due(at(1300)));
        assert_eq!(drives(command(&mut driving, 1300)), Velocity::ZERO);
    }

    #[test]
    fn a_path_leads_where_it_was_asked_for_and_not_where_the_robot_is_since() {
        let mut driving = driving();
        // Asked facing north at (5, 0): two metres ahead, then one to the left.
        let asked = Pose2::new(5.0, 0.0, std::f64::consts::FRAC_PI_2);
        let points = vec![MapPoint::new(2.0, 0.0), MapPoint::new(2.0, 1.0)];
        let lasts_s = None;
        driving.follow(Answer::Path { points, lasts_s }, asked, at(0));
        let (mut pose, mut velocity) = (asked, Velocity::ZERO);
        for step in 0..400 {
            velocity = drives(driving.command(at(50 * step), pose, velocity));
            pose = arc(pose, velocity, 0.05);
        }
        assert_eq!(velocity, Velocity::ZERO);
        assert!(
            pose.point().distance(MapPoint::new(4.0, 2.0)) < 2.0 * END_M,
            "{pose:?}"
        );
        assert!(driving.is_due(at(500)) && !driving.is_due(at(450)));
    }

    #[test]
    fn without_points_it_stands() {
        let mut driving = driving();
        let (points, lasts_s) = (Vec::new(), None);
        driving.follow(Answer::Path { points, lasts_s }, Pose2::default(), at(0));
        let command = driving.command(at(50), Pose2::default(), Velocity::ZERO);
        assert_eq!(drives(command), Velocity::ZERO);
    }

    #[test]
    fn a_trajectory_is_no_faster_than_its_points() {
        let mut driving = driving();
        let points = vec![MapPoint::new(0.5, 0.0), MapPoint::new(1.0, 0.0)];
        let lasts_s = Some(5.0);
        driving.follow(Answer::Path { points, lasts_s }, Pose2::default(), at(0));
        let velocity = drives(driving.command(at(0), Pose2::default(), Velocity::ZERO));
        assert!((velocity.linear - 0.2).abs() < 1e-9, "{velocity:?}");
    }
}
