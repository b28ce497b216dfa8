//! The log of an episode, MCAP with ROS 2 messages.

use std::path::Path;
use std::str::FromStr;

use openbench_core::{
    Event, Georeference, ImuSample, LidarScan, MapPoint, ModelUse, Pose2, SimTime, Velocity,
};
use openbench_logs::messages::{
    CompressedImage, Header, Imu, JointState, NavSatFix, Odometry, Path as PathMessage,
    PointCloud2, Pose, PoseArray, PoseStamped, StringMessage, Twist,
};
use openbench_logs::{LogError, LogFile};
use openbench_osm::Projection;
use openbench_sim::Simulator;
use openbench_sim::traffic::MoverKind;

use super::observer::Observer;
use crate::BenchError;
use crate::image_file;

/// How much is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Nothing.
    None,
    /// Poses, plans, plates, and every twentieth point of every fifth scan.
    Thin,
    /// Every sample, every point and every image that the agent asked for.
    Full,
}

impl FromStr for Level {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "none" => Ok(Self::None),
            "thin" => Ok(Self::Thin),
            "full" => Ok(Self::Full),
            _ => Err(format!(
                "`{word}` is no level of recording; write none, thin or full"
            )),
        }
    }
}

/// Of how many scans one is kept when thinned, and of how many points.
const THIN: (u64, usize) = (5, 20);
const SCAN_NS: u64 = 100_000_000;
/// Time between two records of where people and cars are.
const MOVERS_NS: u64 = 200_000_000;

/// What is wrong with the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// No sample of the IMU and no scan begins in this time.
    pub gap: Option<[SimTime; 2]>,
    /// The IMU shows no more than that, rad/s and m/s².
    pub imu_range: Option<[f64; 2]>,
}

impl Faults {
    fn hides(&self, stamp: SimTime) -> bool {
        self.gap
            .is_some_and(|[from, until]| (from..until).contains(&stamp))
    }

    fn imu(&self, sample: ImuSample) -> Option<ImuSample> {
        let [turn, force] = self.imu_range.unwrap_or([f64::INFINITY; 2]);
        let within = |v: [f64; 3], most: f64| v.map(|x| x.clamp(-most, most));
        let seen = ImuSample {
            gyro: within(sample.gyro, turn),
            accel: within(sample.accel, force),
            ..sample
        };
        (!self.hides(sample.stamp)).then_some(seen)
    }
}

/// Writes what happens into a log.
pub struct Recorder {
    log: Option<LogFile>,
    level: Level,
    faults: Faults,
    /// For what is recorded in degrees.
    projection: Option<Projection>,
}

impl Recorder {
    /// A recorder that writes nothing.
    pub fn none() -> Self {
        Self {
            log: None,
            level: Level::None,
            faults: Faults::default(),
            projection: None,
        }
    }

    /// A recorder into a file, of a world that lies there on the Earth.
    pub fn create(path: &Path, level: Level, georeference: Georeference) -> Result<Self, LogError> {
        let log = if level == Level::None {
            None
        } else {
            Some(LogFile::create(path)?)
        };
        Ok(Self {
            log,
            level,
            faults: Faults::default(),
            projection: Some(Projection::new(georeference)),
        })
    }

    /// The same with sensors that fail.
    #[must_use]
    pub fn with_faults(self, faults: Faults) -> Self {
        Self { faults, ..self }
    }

    /// Records the state after a step.
    pub fn step(&mut self, simulator: &Simulator, velocity: Velocity) -> Result<(), LogError> {
        let Some(log) = &mut self.log else {
            return Ok(());
        };
        let time = simulator.time();
        let observation = simulator.observation();
        let twist = Twist {
            linear: [velocity.linear, 0.0, 0.0],
            angular: [0.0, 0.0, velocity.angular],
        };
        let odometry = Odometry::new(
            Header::new(time, "map"),
            "base_link",
            simulator.base_link().into(),
            twist,
        );
        log.write("/ground_truth/odom", time, &odometry)?;
        if !simulator.movers().is_empty() && time.0.is_multiple_of(MOVERS_NS) {
            let poses = |kind| poses_of(kind, simulator);
            let header = || Header::new(time, "map");
            let people = PoseArray {
                header: header(),
                poses: poses(MoverKind::Pedestrian),
            };
            log.write("/ground_truth/people", time, &people)?;
            log.write(
                "/ground_truth/cars",
                time,
                &PoseArray {
                    header: header(),
                    poses: poses(MoverKind::Car),
                },
            )?;
        }
        if self.level == Level::Full {
            for sample in observation
                .imu
                .iter()
                .filter_map(|sample| self.faults.imu(*sample))
            {
                log.write("/livox/imu", sample.stamp, &Imu::from(sample))?;
            }
            for sample in observation.wheels {
                log.write("/joint_states", sample.stamp, &JointState::from(*sample))?;
            }
            if let (Some(fix), Some(projection)) = (observation.gnss, &self.projection) {
                let at = projection.to_lonlat(MapPoint::new(fix.position[0], fix.position[1]));
                log.write("/gnss/fix", fix.stamp, &NavSatFix::new(fix, at))?;
            }
        }
        match observation
            .scan
            .filter(|scan| !self.faults.hides(scan.stamp))
        {
            Some(scan) if self.level == Level::Full => {
                log.write("/livox/lidar", time, &PointCloud2::from(scan))
            }
            Some(scan) if (time.0 / SCAN_NS).is_multiple_of(THIN.0) => {
                log.write("/livox/lidar", time, &PointCloud2::from(&thinned(scan)))
            }
            _ => Ok(()),
        }
    }

    /// Records an event.
    pub fn event(&mut self, time: SimTime, event: &Event) -> Result<(), LogError> {
        let Some(log) = &mut self.log else {
            return Ok(());
        };
        let header = || Header::new(time, "map");
        let say = |text: String| StringMessage(text);
        match event {
            Event::Plan(plan) => log.write(
                "/plan",
                time,
                &say(serde_json::to_string(plan).unwrap_or_default()),
            ),
            Event::Task(address) => log.write("/task", time, &say(address.to_string())),
            Event::Route(points) => log.write("/route", time, &PathMessage::over(header(), points)),
            Event::Path(points) => log.write("/path", time, &PathMessage::over(header(), points)),
            Event::PoseEstimate(told) => log.write("/pose", time, &stamped(header(), told.pose)),
            Event::Waypoints(poses) => {
                let poses = poses.iter().map(|p| stamped(header(), *p)).collect();
                log.write(
                    "/waypoints",
                    time,
                    &PathMessage {
                        header: header(),
                        poses,
                    },
                )
            }
            Event::PlateRead {
                text,
                confidence,
                image,
                ..
            } => {
                log.write("/plate", time, &say(format!("{text} ({confidence:.2})")))?;
                log.write(
                    "/camera/image/compressed",
                    time,
                    &CompressedImage::jpeg(
                        image.stamp,
                        image_file::jpeg(image).unwrap_or_default(),
                    ),
                )
            }
            Event::DoorWritten { address, position } => {
                log.write("/door", time, &say(format!("{address} at {position}")))
            }
            Event::Models(used) => {
                // Without the time that it took, which differs from run to run.
                let ModelUse {
                    calls,
                    failed,
                    prompt_tokens,
                    completion_tokens,
                    ..
                } = used;
                let text = format!(
                    "{calls} calls, {failed} failed, {prompt_tokens} tokens read, {completion_tokens} written"
                );
                log.write("/models", time, &say(text))
            }
            Event::Note(text) => log.write("/note", time, &say(text.clone())),
        }
    }

    /// Ends the log.
    pub fn finish(self) -> Result<(), LogError> {
        match self.log {
            Some(log) => log.finish().map(drop),
            None => Ok(()),
        }
    }
}

impl Observer for &mut Recorder {
    fn step(&mut self, simulator: &Simulator, velocity: Velocity) -> Result<(), BenchError> {
        Ok(Recorder::step(self, simulator, velocity)?)
    }

    fn event(&mut self, time: SimTime, event: &Event) -> Result<(), BenchError> {
        Ok(Recorder::event(self, time, event)?)
    }
}

fn poses_of(kind: MoverKind, simulator: &Simulator) -> Vec<Pose> {
    let there = simulator
        .movers()
        .iter()
        .filter(|m| m.present && m.kind == kind);
    there.map(|m| m.pose.into()).collect()
}

fn stamped(header: Header, pose: Pose2) -> PoseStamped {
    PoseStamped {
        header,
        pose: pose.into(),
    }
}

fn thinned(scan: &LidarScan) -> LidarScan {
    LidarScan {
        stamp: scan.stamp,
        points: scan.points.iter().step_by(THIN.1).copied().collect(),
    }
}
