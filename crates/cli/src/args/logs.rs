//! Arguments of the commands on logs: `record`, `odometry`, `evaluate` and `verify`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::values::*;

/// Arguments of `record`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The log (MCAP, ROS 2 messages) holds /livox/imu, /livox/lidar, /joint_states (wheels) and
/ground_truth/odom.

Examples:
  openbench record small --out small.mcap
  openbench record medium --minutes 10 --pedestrians 50 --cars 20 --seed 3 --out busy.mcap
  openbench record worlds/corridor --via 0,0 --via 60,0 --wild --gap 30,0.5 --out hard.mcap")]
pub struct RecordArgs {
    /// A built-in world (small, medium, large), a suite file (.toml), or a world folder
    pub world: String,
    /// The log to write
    #[arg(long, value_name = "FILE.mcap", value_parser = mcap_file)]
    pub out: PathBuf,
    /// Duration of the drive, minutes
    #[arg(long, default_value_t = 3.0, value_parser = minutes)]
    pub minutes: f64,
    /// Drive through this point, metres; may be repeated [default: from door to door]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = place)]
    pub via: Vec<openbench_core::MapPoint>,
    /// Drive with full turns, swerves and hard stops
    #[arg(long)]
    pub wild: bool,
    /// A gap in the data of IMU and LiDAR: start and duration, seconds
    #[arg(long, value_name = "AT,SECONDS", value_parser = pair)]
    pub gap: Option<(f64, f64)>,
    /// Measurement range of the IMU: rad/s and m/s²
    #[arg(long, value_name = "TURN,FORCE", value_parser = pair)]
    pub imu_range: Option<(f64, f64)>,
    /// Number of pedestrians [default: as in the suite]
    #[arg(long)]
    pub pedestrians: Option<u16>,
    /// Number of moving cars [default: as in the suite]
    #[arg(long)]
    pub cars: Option<u16>,
    /// Seed of noise, traffic and the order of doors; with small, medium, large and tracks also of
    /// the neighbourhood, where 0 is the built-in world
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Seed of noise, traffic and the order of doors alone [default: that of --seed]
    #[arg(long)]
    pub noise_seed: Option<u64>,
}

/// Arguments of `odometry`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench run small --record full --out run
  openbench odometry run/episodes/000.mcap --out trajectory.tum --truth truth.tum

The output has poses of base_link in odom, which begins at the start of the log, z up. Each
line is `seconds x y z qx qy qz qw` (TUM format, as evo reads it).

A file for --robot; every key is optional:
  imu = { xyz = [0.12, 0.0, 0.185], rpy = [0.0, 0.0, 0.0] }     # in base_link, metres, radians
  lidar = { xyz = [0.12, 0.0, 0.235] }
  imu_topic = \"/livox/imu\"          # default: every topic of the type
  lidar_topic = \"/livox/lidar\"
  accel_unit = 9.80665               # if accelerations are recorded in g
  gyro_noise = 2e-4                  # rad/s/√Hz; accel_noise, gyro_walk, accel_walk likewise
  imu_limits = [34.9, 78.4]          # measurement range, rad/s and m/s²
  range_noise = 0.02                 # metres
  angle_noise = 0.001                # radians
  blind = 0.3                        # nearer points are the robot's own, metres
  typical_speed = 0.5                # m/s
  estimate_lidar = true              # if the LiDAR's pose is known roughly only")]
pub struct OdometryArgs {
    /// A log: an MCAP file or the folder of a rosbag2, with sensor_msgs/Imu and
    /// sensor_msgs/PointCloud2 or livox_ros_driver2/CustomMsg
    pub log: PathBuf,
    /// Poses and properties of the sensors (TOML, see below) [default: the benchmark's robot]
    #[arg(long)]
    pub robot: Option<PathBuf>,
    /// File for the trajectory, TUM format
    #[arg(long)]
    pub out: PathBuf,
    /// File for the recorded truth, if the log has it
    #[arg(long)]
    pub truth: Option<PathBuf>,
    /// Use wheel odometry too (/joint_states of the benchmark's robot)
    #[arg(long)]
    pub wheels: bool,
    /// Print JSON: scans, degenerate scans, CPU time, rejected data, consistency (NEES)
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `evaluate`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench evaluate --log recorder.csv --truth gt.txt")]
pub struct EvaluateArgs {
    /// CSV file of the paper's recorder: timestamp,status,address,robot_x,robot_y,robot_z
    #[arg(long)]
    pub log: PathBuf,
    /// File of true door positions, one `(x, y)` a line
    #[arg(long)]
    pub truth: PathBuf,
    /// The deliveries form a sequence
    #[arg(long)]
    pub sequence: bool,
}

/// Arguments of `verify`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Not checked: times of the machine, commit, processor and command line. Who made the actions is
checked with --agent only.

Examples:
  openbench verify runs/medium
  openbench verify runs/medium --agent --jobs 2")]
pub struct VerifyArgs {
    /// Folder of a run, or of the runs of several seeds
    pub run: PathBuf,
    /// Run the agent again, with the recorded answers of models, and compare its actions
    #[arg(long)]
    pub agent: bool,
    /// Episodes in parallel
    #[arg(
        long,
        default_value_t = 1,
        value_parser = clap::value_parser!(u16).range(1..=256)
    )]
    pub jobs: u16,
}
