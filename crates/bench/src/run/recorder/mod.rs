//! The log of an episode: MCAP with ROS 2 messages.
//!
//! | module | content |
//! |---|---|
//! | `robot` | the robot's frames, and its form as URDF |
//! | `markers` | the map, the true doors, and what the agent found |

mod markers;
mod robot;

use std::path::Path;
use std::str::FromStr;

use openbench_core::{
    CostGrid, Event, Image, ImuSample, LidarScan, MapComparison, MapPoint, ModelUse, Observation,
    PlaceScores, Pose2, Pose3, RobotDescription, SimTime, Velocity,
};
use openbench_logs::messages::{
    CAMERA_OPTICAL, CameraInfo, Clock, CompressedImage, Header, Imu, JointState, MarkerArray,
    NavSatFix, OccupancyGrid, Odometry, Path as PathMessage, PointCloud2, Pose, PoseArray,
    PoseStamped, StringMessage, TfMessage, Twist,
};
use openbench_logs::{LogError, LogFile};
use openbench_osm::Projection;
use openbench_scene::Door;
use openbench_sim::Simulator;
use openbench_sim::traffic::MoverKind;
use serde::{Deserialize, Serialize};

use super::observer::Observer;
use crate::BenchError;
use crate::image_file;
use crate::worlds::Prepared;

/// The content of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// No log.
    None,
    /// Poses, plans, plates, and every twentieth point of every fifth scan.
    Thin,
    /// Every sample, every point, and every image in which a plate was read.
    Full,
}

/// A word that is no level of recording.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no level of recording; write none, thin or full")]
pub struct LevelError(pub String);

impl FromStr for Level {
    type Err = LevelError;

    fn from_str(word: &str) -> Result<Self, LevelError> {
        match word {
            "none" => Ok(Self::None),
            "thin" => Ok(Self::Thin),
            "full" => Ok(Self::Full),
            _ => Err(LevelError(word.to_owned())),
        }
    }
}

/// A thin log has one of so many scans.
const THIN_SCAN_STRIDE: u64 = 5;
/// A scan of a thin log has one of so many points.
const THIN_POINT_STRIDE: usize = 20;
/// Time between two scans.
const SCAN_PERIOD_NS: u64 = 100_000_000;
/// Time between two records of the poses of people and cars.
const MOVERS_PERIOD_NS: u64 = 200_000_000;

/// The frame of the true pose: clouds and images lie where they were taken.
const BASE: &str = "base_link";
/// The frame of the pose that the agent estimates.
const ESTIMATED: &str = "base_link_estimated";

/// Simulated faults of the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// An interval, its end excluded, without IMU samples and without scans.
    pub gap: Option<[SimTime; 2]>,
    /// The IMU's measurement range; unlimited by default.
    pub imu_range: Option<ImuRange>,
}

/// The largest values that an IMU measures; it reports these for larger ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImuRange {
    /// Angular rate about each axis, rad/s.
    pub rate: f64,
    /// Acceleration along each axis, m/s².
    pub acceleration: f64,
}

impl Faults {
    fn hides(&self, stamp: SimTime) -> bool {
        self.gap
            .is_some_and(|[from, until]| (from..until).contains(&stamp))
    }

    /// What a faulty IMU reports for a sample; `None` in the gap.
    fn imu(&self, sample: ImuSample) -> Option<ImuSample> {
        if self.hides(sample.stamp) {
            return None;
        }
        let Some(range) = self.imu_range else {
            return Some(sample);
        };
        Some(ImuSample {
            gyro: saturated(sample.gyro, range.rate),
            accel: saturated(sample.accel, range.acceleration),
            ..sample
        })
    }
}

fn saturated(measured: [f64; 3], max: f64) -> [f64; 3] {
    measured.map(|value| value.clamp(-max, max))
}

/// Writes the states and events of an episode into a log.
pub struct Recorder {
    log: Option<LogFile>,
    level: Level,
    faults: Faults,
    scenery: Option<Scenery>,
    /// The world in the `map` frame of the log, that of the public map; `None` if they are one.
    frame: Option<Pose2>,
    /// Whether what does not change is written.
    has_begun: bool,
    /// Number of plates and doors that were marked.
    marked: i32,
}

/// What a log shows beside the robot.
struct Scenery {
    /// From the `map` frame to longitude and latitude.
    projection: Projection,
    map: MarkerArray,
    doors: MarkerArray,
}

impl Recorder {
    /// A recorder that writes nothing.
    pub fn none() -> Self {
        Self {
            log: None,
            level: Level::None,
            faults: Faults::default(),
            scenery: None,
            frame: None,
            has_begun: false,
            marked: 0,
        }
    }

    /// A recorder that writes to a file what happens in the world of a suite.
    ///
    /// # Errors
    /// A file that cannot be created.
    pub fn create(path: &Path, level: Level, prepared: &Prepared) -> Result<Self, LogError> {
        if level == Level::None {
            return Ok(Self::none());
        }
        Ok(Self {
            log: Some(LogFile::create(path)?),
            level,
            faults: Faults::default(),
            scenery: Some(Scenery {
                projection: Projection::new(prepared.public_georeference()),
                map: markers::of_map(prepared.public_map()),
                doors: markers::of_doors(&doors_on_map(prepared)),
            }),
            frame: prepared.on_map().frame(),
            has_begun: false,
            marked: 0,
        })
    }

    /// The same recorder with faulty sensors.
    #[must_use]
    pub fn with_faults(self, faults: Faults) -> Self {
        Self { faults, ..self }
    }

    /// Records what does not change, and where everything is before the first step.
    ///
    /// # Errors
    /// A message that cannot be written.
    pub fn begin(&mut self, simulator: &Simulator) -> Result<(), LogError> {
        self.write_fixed(simulator)?;
        match &mut self.log {
            Some(log) => write_state(log, simulator, self.frame, Velocity::ZERO),
            None => Ok(()),
        }
    }

    /// Writes what does not change, once.
    fn write_fixed(&mut self, simulator: &Simulator) -> Result<(), LogError> {
        let Some(log) = self.log.as_mut().filter(|_| !self.has_begun) else {
            return Ok(());
        };
        self.has_begun = true;
        let (time, robot) = (simulator.time(), simulator.robot());
        log.write_lasting("/tf_static", time, &robot::fixed_transforms(robot))?;
        let urdf = StringMessage(robot::urdf(robot));
        log.write_lasting("/robot_description", time, &urdf)?;
        if let Some(scenery) = &self.scenery {
            log.write_lasting("/map/markers", time, &scenery.map)?;
            log.write_lasting("/ground_truth/doors", time, &scenery.doors)?;
        }
        write_camera_info(log, time, robot)
    }

    /// Records the state after a step and the commanded velocity.
    ///
    /// # Errors
    /// A message that cannot be written.
    pub fn step(&mut self, simulator: &Simulator, velocity: Velocity) -> Result<(), LogError> {
        // A drive that nobody announced begins with its first step.
        self.write_fixed(simulator)?;
        let Some(log) = &mut self.log else {
            return Ok(());
        };
        let time = simulator.time();
        let observation = simulator.observation();
        write_state(log, simulator, self.frame, velocity)?;
        // Steps end at multiples of 50 ms, so no multiple of the period is missed.
        if !simulator.movers().is_empty() && time.0.is_multiple_of(MOVERS_PERIOD_NS) {
            write_movers(log, simulator, self.frame)?;
        }
        if self.level == Level::Full {
            let projection = self.scenery.as_ref().map(|scenery| &scenery.projection);
            write_samples(log, &observation, &self.faults, projection)?;
        }
        match observation
            .scan
            .filter(|scan| !self.faults.hides(scan.stamp))
        {
            Some(scan) if self.level == Level::Full => {
                log.write("/livox/lidar", time, &PointCloud2::from(scan))
            }
            // A scan ends together with a step, at a multiple of its period: the quotient counts
            // scans.
            Some(scan) if (time.0 / SCAN_PERIOD_NS).is_multiple_of(THIN_SCAN_STRIDE) => {
                log.write("/livox/lidar", time, &PointCloud2::from(&thinned(scan)))
            }
            _ => Ok(()),
        }
    }

    /// Records an event of the agent.
    ///
    /// # Errors
    /// A message that cannot be written.
    pub fn event(&mut self, time: SimTime, event: &Event) -> Result<(), LogError> {
        let Some(log) = &mut self.log else {
            return Ok(());
        };
        let header = || Header::new(time, "map");
        match event {
            Event::Plan(plan) => log.write(
                "/plan",
                time,
                &StringMessage(serde_json::to_string(plan).unwrap_or_default()),
            ),
            Event::Stage(stage) => log.write("/stage", time, &StringMessage(stage.to_string())),
            Event::Task(address) => log.write("/task", time, &StringMessage(address.to_string())),
            Event::Route(points) => log.write("/route", time, &PathMessage::over(header(), points)),
            Event::Path(points) => log.write("/path", time, &PathMessage::over(header(), points)),
            Event::PoseEstimate(estimate) => {
                log.write("/pose", time, &stamped(header(), estimate.pose))?;
                write_pose(log, time, ESTIMATED, estimate.pose.to_pose3(0.0))
            }
            Event::MapComparison(found) => write_comparison(log, time, found),
            Event::Costmap(grid) => log.write("/costmap", time, &occupancy(header(), grid)),
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
                position,
                ..
            } => {
                let said = format!("{text} ({confidence:.2})");
                if let Some(position) = position {
                    self.marked += 1;
                    let markers = markers::of_plate(time, self.marked, &said, *position);
                    log.write("/found", time, &markers)?;
                }
                log.write("/plate", time, &StringMessage(said))?;
                // Images in which nothing was read would fill the log.
                write_image(log, time, image)
            }
            Event::DoorWritten { address, position } => {
                self.marked += 1;
                let markers = markers::of_door(time, self.marked, address, *position);
                log.write("/found", time, &markers)?;
                let text = format!("{address} at {position}");
                log.write("/door", time, &StringMessage(text))
            }
            Event::Models(used) => log.write("/models", time, &StringMessage(used_in_words(used))),
            Event::Note(text) => log.write("/note", time, &StringMessage(text.clone())),
            // Several for each observation: the sums are in the results.
            Event::Work(_) | Event::WallTime(_) => Ok(()),
        }
    }

    /// Completes the log.
    ///
    /// # Errors
    /// An index that cannot be written.
    pub fn finish(self) -> Result<(), LogError> {
        match self.log {
            Some(log) => log.finish().map(drop),
            None => Ok(()),
        }
    }
}

// By reference: a rollout drops its observers, but a recorder must complete its log afterwards.
impl Observer for &mut Recorder {
    fn begin(&mut self, simulator: &Simulator) -> Result<(), BenchError> {
        Ok(Recorder::begin(self, simulator)?)
    }

    fn step(&mut self, simulator: &Simulator, velocity: Velocity) -> Result<(), BenchError> {
        Ok(Recorder::step(self, simulator, velocity)?)
    }

    fn event(&mut self, time: SimTime, event: &Event) -> Result<(), BenchError> {
        Ok(Recorder::event(self, time, event)?)
    }
}

/// Writes the time, the true pose and the commanded velocity.
fn write_state(
    log: &mut LogFile,
    simulator: &Simulator,
    frame: Option<Pose2>,
    velocity: Velocity,
) -> Result<(), LogError> {
    let time = simulator.time();
    let base_link = simulator.base_link();
    let base_link = frame.map_or(base_link, |frame| frame.to_pose3(0.0) * base_link);
    log.write("/clock", time, &Clock(time))?;
    write_pose(log, time, BASE, base_link)?;
    let twist = Twist::from(velocity);
    log.write("/cmd_vel", time, &twist)?;
    let pose = base_link.into();
    let odometry = Odometry::new(Header::new(time, "map"), BASE, pose, twist);
    log.write("/ground_truth/odom", time, &odometry)
}

/// Writes the pose of a frame in `map`.
fn write_pose(log: &mut LogFile, time: SimTime, name: &str, pose: Pose3) -> Result<(), LogError> {
    let transform = robot::transform(time, "map", name, pose);
    log.write("/tf", time, &TfMessage(vec![transform]))
}

/// Writes the poses that the agent may have, and the facades by which it looked for them.
fn write_comparison(
    log: &mut LogFile,
    time: SimTime,
    found: &MapComparison,
) -> Result<(), LogError> {
    let poses = found.hypotheses.iter();
    let hypotheses = PoseArray {
        header: Header::new(time, "map"),
        poses: poses.map(|one| Pose::from(one.pose)).collect(),
    };
    log.write("/hypotheses", time, &hypotheses)?;
    if let Some(places) = &found.places {
        log.write(
            "/places",
            time,
            &scored_places(Header::new(time, "map"), places),
        )?;
    }
    let facades = markers::of_facades(time, &found.facades);
    log.write("/facades", time, &facades)
}

/// Without the latency, which differs from run to run.
fn used_in_words(used: &ModelUse) -> String {
    let ModelUse {
        calls,
        failed,
        prompt_tokens,
        completion_tokens,
        ..
    } = used;
    format!(
        "{calls} calls, {failed} failed, {prompt_tokens} prompt tokens, {completion_tokens} \
         completion tokens"
    )
}

fn write_camera_info(
    log: &mut LogFile,
    time: SimTime,
    robot: &RobotDescription,
) -> Result<(), LogError> {
    let info = CameraInfo::new(time, CAMERA_OPTICAL, robot.camera_intrinsics);
    log.write_lasting("/camera/camera_info", time, &info)
}

fn write_image(log: &mut LogFile, time: SimTime, image: &Image) -> Result<(), LogError> {
    // Empty if JPEG cannot hold the image: an error would end the episode.
    let jpeg = image_file::jpeg(image).unwrap_or_default();
    let message = CompressedImage::jpeg(image.stamp, jpeg);
    log.write("/camera/image/compressed", time, &message)
}

fn scored_places(header: Header, scores: &PlaceScores) -> OccupancyGrid {
    let grid = CostGrid {
        origin: scores.origin,
        cell_m: scores.cell_m,
        width: scores.width,
        cells: scores.cells.clone(),
    };
    occupancy(header, &grid)
}

fn occupancy(header: Header, grid: &CostGrid) -> OccupancyGrid {
    // A grid without columns has no cells.
    let rows = grid.cells.len().checked_div(grid.width).unwrap_or_default();
    OccupancyGrid {
        header,
        resolution: grid.cell_m as f32,
        width: grid.width as u32,
        height: rows as u32,
        origin: Pose2::new(grid.origin.x, grid.origin.y, 0.0).into(),
        data: grid.cells.clone(),
    }
}

/// Writes the true poses of people and cars.
fn write_movers(
    log: &mut LogFile,
    simulator: &Simulator,
    frame: Option<Pose2>,
) -> Result<(), LogError> {
    let time = simulator.time();
    for (topic, kind) in [
        ("/ground_truth/people", MoverKind::Pedestrian),
        ("/ground_truth/cars", MoverKind::Car),
    ] {
        let poses = PoseArray {
            header: Header::new(time, "map"),
            poses: poses_of(kind, simulator, frame),
        };
        log.write(topic, time, &poses)?;
    }
    Ok(())
}

/// Writes the samples of IMU, wheels and GNSS receiver.
fn write_samples(
    log: &mut LogFile,
    observation: &Observation<'_>,
    faults: &Faults,
    projection: Option<&Projection>,
) -> Result<(), LogError> {
    for sample in observation
        .imu
        .iter()
        .filter_map(|sample| faults.imu(*sample))
    {
        log.write("/livox/imu", sample.stamp, &Imu::from(sample))?;
    }
    for sample in observation.wheels {
        log.write("/joint_states", sample.stamp, &JointState::from(*sample))?;
    }
    if let (Some(fix), Some(projection)) = (observation.gnss, projection) {
        let at = projection.to_lonlat(MapPoint::new(fix.position[0], fix.position[1]));
        log.write("/gnss/fix", fix.stamp, &NavSatFix::new(fix, at))?;
    }
    Ok(())
}

fn poses_of(kind: MoverKind, simulator: &Simulator, frame: Option<Pose2>) -> Vec<Pose> {
    let there = simulator
        .movers()
        .iter()
        .filter(|m| m.present && m.kind == kind);
    let on_map = |pose: Pose2| frame.map_or(pose, |frame| frame.compose(pose));
    there.map(|m| on_map(m.pose).into()).collect()
}

/// The doors of the world where the public map has them.
fn doors_on_map(prepared: &Prepared) -> Vec<Door> {
    let doors = prepared.world.scene.doors.iter().enumerate();
    let on_map = prepared.on_map();
    let moved = doors.map(|(number, door)| {
        let at = on_map.beside(prepared.building(number), door.point());
        Door {
            plate: [at.x, at.y, door.plate[2]],
            ..door.clone()
        }
    });
    moved.collect()
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
        points: scan
            .points
            .iter()
            .step_by(THIN_POINT_STRIDE)
            .copied()
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::{Prepared, builtin_suite};
    use openbench_logs::LogReader;
    use std::collections::BTreeMap;

    fn sample(ms: u64) -> ImuSample {
        ImuSample {
            stamp: SimTime::from_millis(ms),
            gyro: [3.0, -3.0, 0.5],
            accel: [0.0, 20.0, -9.81],
        }
    }

    #[test]
    fn samples_are_hidden_in_the_gap_and_limited_to_the_range() {
        let intact = Faults::default();
        assert_eq!(intact.imu(sample(0)), Some(sample(0)));
        let faults = Faults {
            gap: Some([SimTime::from_millis(100), SimTime::from_millis(200)]),
            imu_range: Some(ImuRange {
                rate: 2.0,
                acceleration: 10.0,
            }),
        };
        assert_eq!(faults.imu(sample(100)), None);
        let limited = faults.imu(sample(200)).unwrap();
        assert_eq!(limited.gyro, [2.0, -2.0, 0.5]);
        assert_eq!(limited.accel, [0.0, 10.0, -9.81]);
    }

    /// Number of messages by topic in the log of two seconds.
    fn recorded(level: Level) -> BTreeMap<String, usize> {
        let prepared = Prepared::world_of(builtin_suite("small").unwrap()).unwrap();
        let mut simulator = prepared.simulator(1).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.mcap");
        let mut recorder = Recorder::create(&path, level, &prepared).unwrap();
        recorder.begin(&simulator).unwrap();
        for _ in 0..40 {
            simulator.step(Velocity::ZERO);
            recorder.step(&simulator, Velocity::ZERO).unwrap();
        }
        let note = Event::Note("done".into());
        recorder.event(simulator.time(), &note).unwrap();
        recorder.finish().unwrap();
        let mut counts = BTreeMap::new();
        if path.exists() {
            for message in LogReader::open(&path).unwrap() {
                let topic = message.unwrap().topic.to_string();
                *counts.entry(topic).or_default() += 1;
            }
        }
        counts
    }

    #[test]
    fn a_thin_log_has_poses_events_and_every_fifth_scan() {
        let counts = recorded(Level::Thin);
        for topic in ["/ground_truth/odom", "/clock", "/tf", "/cmd_vel"] {
            assert_eq!(counts[topic], 41, "{topic}");
        }
        for topic in [
            "/tf_static",
            "/robot_description",
            "/camera/camera_info",
            "/map/markers",
            "/ground_truth/doors",
        ] {
            assert_eq!(counts[topic], 1, "{topic}");
        }
        assert_eq!(counts["/note"], 1);
        assert_eq!(counts["/livox/lidar"], 4);
        assert!(!counts.contains_key("/livox/imu"), "{counts:?}");
    }

    #[test]
    fn a_full_log_has_every_sample() {
        let counts = recorded(Level::Full);
        // Two seconds of 10 scans and 100 samples a second, but for the last scan, which is due.
        assert!((19..=20).contains(&counts["/livox/lidar"]), "{counts:?}");
        assert!((199..=200).contains(&counts["/livox/imu"]), "{counts:?}");
    }

    #[test]
    fn no_log_is_written_without_a_level() {
        assert!(recorded(Level::None).is_empty());
    }
}
