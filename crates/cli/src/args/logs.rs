//! Arguments of what writes and reads logs: `record`, `odometry`, `evaluate` and `verify`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::values::*;

/// Arguments of `record`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The log (MCAP, ROS 2 messages) has /livox/imu, /livox/lidar, /joint_states (the wheels) and /ground_truth/odom.

Examples:
  openbench record small --out small.mcap
  openbench record medium --minutes 10 --pedestrians 50 --cars 20 --seed 3 --out busy.mcap
  openbench record worlds/corridor --via 0,0 --via 60,0 --wild --gap 30,0.5 --out hard.mcap")]
pub struct RecordArgs {
    /// A built-in world (small, medium, large), a suite file (.toml), or the folder of a generated or imported world
    pub world: String,
    /// The log to write (.mcap)
    #[arg(long)]
    pub out: PathBuf,
    /// How long to drive
    #[arg(long, default_value_t = 3.0, value_parser = minutes)]
    pub minutes: f64,
    /// Drive through this place, x,y in metres (may be given more than once; by default from door to door)
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = place)]
    pub via: Vec<openbench_core::MapPoint>,
    /// Full turns, swerves and stops as hard as the motors allow
    #[arg(long)]
    pub wild: bool,
    /// Neither IMU nor LiDAR say anything for a time: when and how long, seconds
    #[arg(long, value_name = "AT,SECONDS", value_parser = pair)]
    pub gap: Option<(f64, f64)>,
    /// The IMU shows no more than that: rad/s and m/s²
    #[arg(long, value_name = "TURN,FORCE", value_parser = pair)]
    pub imu_range: Option<(f64, f64)>,
    /// People who walk about; by default as many as the suite says
    #[arg(long)]
    pub pedestrians: Option<u16>,
    /// Cars that drive about; by default as many as the suite says
    #[arg(long)]
    pub cars: Option<u16>,
    /// What noise, traffic and the order of doors are drawn from
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

/// Arguments of `odometry`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench run small --record full --out run
  openbench odometry run/episodes/000.mcap --out way.tum --truth truth.tum

Poses are those of base_link in odom, which begins where the log begins, with z up. Lines are `seconds x y z qx qy qz qw`, as evo reads them.

A file for --robot; all of it may be left out:
  imu = { xyz = [0.12, 0.0, 0.185], rpy = [0.0, 0.0, 0.0] }     # in base_link, metres, radians
  lidar = { xyz = [0.12, 0.0, 0.235] }
  imu_topic = \"/livox/imu\"          # by default every topic of the type
  lidar_topic = \"/livox/lidar\"
  accel_unit = 9.80665               # where accelerations are recorded in g
  gyro_noise = 2e-4                  # rad/s/√Hz; accel_noise, gyro_walk, accel_walk likewise
  imu_limits = [34.9, 78.4]          # what it can show at most, rad/s and m/s²
  range_noise = 0.02                 # metres
  angle_noise = 0.001                # radians
  blind = 0.3                        # nearer points are of the robot itself, metres
  typical_speed = 0.5                # m/s
  estimate_lidar = true              # where the LiDAR's place is known roughly only")]
pub struct OdometryArgs {
    /// A log (.mcap, or the folder of a rosbag2 of such) with sensor_msgs/Imu and sensor_msgs/PointCloud2 or livox_ros_driver2/CustomMsg
    pub log: PathBuf,
    /// Where the sensors sit and what they are like (TOML, see below); by default those of the benchmark's robot
    #[arg(long)]
    pub robot: Option<PathBuf>,
    /// The file to write, as TUM has it
    #[arg(long)]
    pub out: PathBuf,
    /// Also write the recorded truth, where the log has it
    #[arg(long)]
    pub truth: Option<PathBuf>,
    /// Go by the wheels, too, where the log has them (/joint_states of the benchmark's robot)
    #[arg(long)]
    pub wheels: bool,
    /// Print JSON: scans, how many of them without enough to go by, CPU time, what was refused, and whether errors are as large as told (NEES)
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `evaluate`.
#[derive(Debug, ClapArgs)]
pub struct EvaluateArgs {
    /// The recorder's CSV
    #[arg(long)]
    pub log: PathBuf,
    /// The true positions
    #[arg(long)]
    pub truth: PathBuf,
    /// Deliveries follow on each other
    #[arg(long)]
    pub sequence: bool,
}

/// Arguments of `verify`.
#[derive(Debug, ClapArgs)]
pub struct VerifyArgs {
    /// Folder of the run
    pub run: PathBuf,
    /// Run the agent again too, with what models answered in the run, and compare what it does
    #[arg(long)]
    pub agent: bool,
    /// Episodes run at the same time, with --agent
    #[arg(long, default_value_t = 1, requires = "agent", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: u16,
}
