//! `openbench odometry`: where a recorded log's sensors went.
//!
//! | module | contents |
//! |---|---|
//! | `bag` | the files of a log |
//! | `sensors` | what the sensors are like |

mod bag;
mod sensors;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context;
use cpu_time::ThreadTime;
use openbench_bench::score::metrics::{EstimatedPose, Nees, StampedPose, nees};
use openbench_core::{Pose3, RobotDescription, SimTime, with_causes};
use openbench_localization::lio::{Estimate, LidarInertialOdometry, Refused, Status};
use openbench_localization::wheels::Wheels;
use openbench_logs::messages::{CustomMsg, Imu, JointState, Message, Odometry, PointCloud2};
use openbench_logs::{LogReader, LoggedMessage};
use serde::Serialize;

use crate::args::OdometryArgs;
use crate::commands::spare_inputs;
use crate::outcome::{Outcome, say_json, tell};

use sensors::Sensors;

/// Reads a log and writes the way.
pub fn run(args: &OdometryArgs) -> anyhow::Result<Outcome> {
    let files = bag::files(&args.log)?;
    let read = files.iter().chain(&args.robot).map(PathBuf::as_path);
    let written = args.truth.iter().chain([&args.out]).map(PathBuf::as_path);
    spare_inputs(&read.collect::<Vec<_>>(), &written.collect::<Vec<_>>())?;
    let mut drive = Drive::new(Sensors::new(args.robot.as_deref())?, args.wheels);
    // A damaged file is used up to its first error. The files after it are still read.
    for file in files {
        let name = || file.display().to_string();
        for message in LogReader::open(&file).with_context(name)? {
            match message {
                Ok(message) => drive.take(&message).with_context(name)?,
                Err(error) => {
                    tell(&format!(
                        "{}: only the messages before this error are used: {}",
                        file.display(),
                        with_causes(&error)
                    ));
                    break;
                }
            }
        }
    }
    drive
        .check()
        .with_context(|| args.log.display().to_string())?;
    openbench_osm::write_atomically(&args.out, drive.path.as_bytes())?;
    if let Some(file) = &args.truth {
        openbench_osm::write_atomically(file, drive.truth.as_bytes())?;
    }
    let summary = drive.summary();
    if args.json {
        say_json(&summary)?;
    } else {
        tell(&summary.text());
    }
    Ok(Outcome::Done)
}

/// A log on its way through the odometry.
struct Drive {
    sensors: Sensors,
    odometry: LidarInertialOdometry,
    wheels: Option<Wheels>,
    path: String,
    truth: String,
    estimates: Vec<EstimatedPose>,
    true_poses: Vec<StampedPose>,
    /// Messages of the IMU and of the LiDAR.
    imu_messages: usize,
    lidar_messages: usize,
    scans: usize,
    coasting: usize,
    disputed: usize,
    noisy: usize,
    lost: usize,
    /// CPU time since the last estimate, and of each one.
    spent: Duration,
    times: Vec<Duration>,
}

impl Drive {
    fn new(sensors: Sensors, wheels: bool) -> Self {
        Self {
            odometry: LidarInertialOdometry::new(sensors.settings.clone()),
            wheels: wheels.then(|| Wheels::new(&RobotDescription::sentry())),
            sensors,
            path: String::new(),
            truth: String::new(),
            estimates: Vec::new(),
            true_poses: Vec::new(),
            imu_messages: 0,
            lidar_messages: 0,
            scans: 0,
            coasting: 0,
            disputed: 0,
            noisy: 0,
            lost: 0,
            spent: Duration::ZERO,
            times: Vec::new(),
        }
    }

    fn take(&mut self, message: &LoggedMessage) -> anyhow::Result<()> {
        let began = ThreadTime::now();
        let estimates = match &*message.type_name {
            name if name == Imu::DEFINITION.full_name() => {
                // Returning here leaves the time out: other sensors are no work of the odometry.
                if !self.sensors.imu_is_on(&message.topic) {
                    return Ok(());
                }
                self.imu_messages += 1;
                self.odometry
                    .imu(self.sensors.sample((&message.decode::<Imu>()?).into()))
            }
            name if name == PointCloud2::DEFINITION.full_name() => {
                if !self.sensors.lidar_is_on(&message.topic) {
                    return Ok(());
                }
                let cloud = message.decode::<PointCloud2>()?;
                self.lidar_messages += 1;
                self.odometry.scan(
                    cloud
                        .to_scan()
                        .with_context(|| format!("{}", message.time))?,
                )
            }
            "livox_ros_driver2/msg/CustomMsg" if self.sensors.lidar_is_on(&message.topic) => {
                self.lidar_messages += 1;
                self.odometry.scan(message.decode::<CustomMsg>()?.to_scan())
            }
            name if name == JointState::DEFINITION.full_name() && self.wheels.is_some() => {
                let sample = message.decode::<JointState>()?.wheels();
                let speed = sample.and_then(|sample| self.wheels.as_mut()?.take(&sample));
                speed
                    .into_iter()
                    .for_each(|speed| self.odometry.speed(speed));
                Vec::new()
            }
            name if name == Odometry::DEFINITION.full_name()
                && *message.topic == *"/ground_truth/odom" =>
            {
                if let Some(there) = message.decode::<Odometry>()?.pose.to_pose3() {
                    line(&mut self.truth, message.time, &there);
                    self.true_poses.push(StampedPose {
                        time: message.time,
                        pose: there,
                    });
                }
                return Ok(());
            }
            _ => return Ok(()),
        };
        // Summed up until an estimate comes: it costs what all messages before it have cost.
        self.spent += began.elapsed();
        if !estimates.is_empty() {
            self.times.push(std::mem::take(&mut self.spent));
        }
        estimates.iter().for_each(|estimate| self.note(estimate));
        Ok(())
    }

    /// Whether there is a trajectory.
    fn check(&self) -> anyhow::Result<()> {
        if self.scans > 0 {
            return Ok(());
        }
        let (imu, lidar) = (self.imu_messages, self.lidar_messages);
        let hint = match (imu, lidar) {
            (0, _) | (_, 0) => {
                "both are needed; the description of the robot (--robot) can name their topics"
            }
            _ => "they are too short, or their times do not overlap",
        };
        anyhow::bail!("no pose follows from {imu} IMU samples and {lidar} scans: {hint}");
    }

    fn note(&mut self, estimate: &Estimate) {
        self.scans += 1;
        self.coasting += usize::from(estimate.status == Status::Coasting);
        self.disputed += usize::from(estimate.status == Status::Disputed);
        self.noisy += usize::from(estimate.status == Status::Noisy);
        self.lost += usize::from(estimate.status == Status::Lost);
        line(&mut self.path, estimate.stamp, &estimate.pose);
        self.estimates.push(EstimatedPose {
            time: estimate.stamp,
            pose: estimate.pose,
            covariance: estimate.covariance,
        });
    }

    fn summary(mut self) -> Summary {
        self.times.sort_unstable();
        let at = |part: usize| {
            let time = self
                .times
                .get(self.times.len() * part / 100)
                .copied()
                .unwrap_or_default();
            time.as_secs_f64() * 1e3
        };
        Summary {
            scans: self.scans,
            coasting: self.coasting,
            disputed: self.disputed,
            noisy: self.noisy,
            lost: self.lost,
            cpu_ms_p50: at(50),
            cpu_ms_p99: at(99),
            cubes: self.odometry.map_size(),
            refused: self.odometry.refused(),
            nees: nees(
                &self.estimates,
                &self.true_poses,
                &self.sensors.settings.imu,
            ),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// What came of a log.
#[derive(Debug, Serialize)]
struct Summary {
    /// Poses that were written.
    scans: usize,
    /// Of them those that only IMU and wheels know.
    coasting: usize,
    /// Of them those while scans and IMU contradict each other.
    disputed: usize,
    /// Of them those while points are scattered several times as widely as the LiDAR's noise says.
    noisy: usize,
    /// Times after which nobody knows how far the sensors have gone.
    lost: usize,
    /// CPU time a scan, reading it and the IMU included.
    cpu_ms_p50: f64,
    cpu_ms_p99: f64,
    /// Size of the map at the end.
    cubes: usize,
    refused: Refused,
    /// Whether errors are as large as the odometry says; none where the log has no truth.
    nees: Option<Nees>,
    version: &'static str,
}

/// Share of degenerate scans above which the log or the robot description is probably wrong.
const SUSPICIOUS_SHARE: f64 = 0.1;

impl Summary {
    fn text(&self) -> String {
        let Refused {
            imu,
            scans,
            speeds,
            points,
            gaps,
            restarts,
        } = self.refused;
        let mut text = format!(
            "{} scans; CPU time a scan: median {:.1} ms, 99 % {:.1} ms\n",
            self.scans, self.cpu_ms_p50, self.cpu_ms_p99
        );
        for (count, what) in [
            (
                self.coasting,
                "degenerate scans: their poses are predicted by the IMU",
            ),
            (
                self.disputed,
                "scans during which LiDAR and IMU contradict each other",
            ),
            (
                self.noisy,
                "scans with several times the LiDAR's nominal noise",
            ),
            (
                self.lost,
                "gaps of the IMU after which the trajectory is no longer connected",
            ),
            (gaps, "gaps in the samples of the IMU"),
            (
                restarts,
                "divergences from wheels and gyroscope, after which the filter was restarted",
            ),
            (imu, "IMU samples rejected: not finite, or out of order"),
            (scans, "scans rejected: out of order, or before the start"),
            (speeds, "wheel speeds rejected"),
            (points, "points rejected: not finite, or too near"),
        ] {
            if count > 0 {
                let _ = writeln!(text, "{count} {what}");
            }
        }
        if self.disputed > 0 || self.coasting as f64 > SUSPICIOUS_SHARE * self.scans as f64 {
            text.push_str(
                "do not trust this trajectory; possible causes: sensor poses or the unit of \
                 acceleration differ from the description (--robot, see --help), IMU and \
                 LiDAR have different clocks, or the surroundings are degenerate, such as \
                 a long corridor (--wheels)\n",
            );
        }
        // `tell` ends the line itself.
        text.truncate(text.trim_end().len());
        text
    }
}

/// A line as TUM has it: seconds, position, quaternion.
fn line(text: &mut String, time: SimTime, pose: &Pose3) {
    let (p, q) = (pose.translation.vector, pose.rotation.coords);
    let _ = writeln!(
        text,
        "{:.9} {:.6} {:.6} {:.6} {:.9} {:.9} {:.9} {:.9}",
        time.seconds(),
        p.x,
        p.y,
        p.z,
        q.x,
        q.y,
        q.z,
        q.w
    );
}
