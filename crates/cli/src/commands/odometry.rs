//! `openbench odometry`: where a recorded log's sensors went.

use std::fmt::Write as _;

use anyhow::Context;
use cpu_time::ThreadTime;
use openbench_core::{Pose3, RobotDescription};
use openbench_localization::lidar_inertial::settings;
use openbench_localization::lio::{LidarInertialOdometry, Status};
use openbench_logs::LogReader;
use openbench_logs::messages::{Imu, Message, Odometry, PointCloud2};

use crate::args::OdometryArgs;
use crate::outcome::{Outcome, tell};

/// Reads a log and writes the way.
pub fn run(args: &OdometryArgs) -> anyhow::Result<Outcome> {
    let robot = RobotDescription::sentry();
    let mut odometry = LidarInertialOdometry::new(settings(&robot));
    let (mut path, mut truth) = (String::new(), String::new());
    let (mut scans, mut coasting) = (0, 0);
    let (mut times, mut spent) = (Vec::new(), std::time::Duration::ZERO);
    for message in LogReader::open(&args.log)? {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                tell(&format!("{error}; what stands before that is used"));
                break;
            }
        };
        let begun = ThreadTime::now();
        let estimates = match &*message.type_name {
            name if name == Imu::DEFINITION.full_name() => odometry.imu((&message.decode::<Imu>()?).into()),
            name if name == PointCloud2::DEFINITION.full_name() => {
                let cloud = message.decode::<PointCloud2>()?;
                odometry.scan(cloud.to_scan().with_context(|| format!("{}", message.time))?)
            }
            name if name == Odometry::DEFINITION.full_name() && *message.topic == *"/ground_truth/odom" => {
                let there = message.decode::<Odometry>()?;
                let there = there.pose.to_pose3();
                there.iter().for_each(|pose| line(&mut truth, message.time.seconds(), pose));
                Vec::new()
            }
            _ => Vec::new(),
        };
        spent += begun.elapsed();
        if !estimates.is_empty() {
            times.push(std::mem::take(&mut spent));
        }
        for estimate in estimates {
            scans += 1;
            coasting += usize::from(estimate.status == Status::Coasting);
            line(&mut path, estimate.stamp.seconds(), &estimate.pose);
        }
    }
    openbench_osm::write_atomically(&args.out, path.as_bytes())?;
    if let Some(file) = &args.truth {
        openbench_osm::write_atomically(file, truth.as_bytes())?;
    }
    times.sort_unstable();
    let at =
        |part: usize| times.get(times.len() * part / 100).copied().unwrap_or_default().as_secs_f64() * 1e3;
    tell(&format!(
        "CPU time a scan: median {:.1} ms, 99 % {:.1} ms; {} cubes",
        at(50),
        at(99),
        odometry.map_size()
    ));
    tell(&format!("{scans} scans, {coasting} of them without enough to go by; {:?}", odometry.refused()));
    Ok(Outcome::Done)
}

/// A line as TUM has it: seconds, position, quaternion.
fn line(text: &mut String, seconds: f64, pose: &Pose3) {
    let (p, q) = (pose.translation.vector, pose.rotation.coords);
    let _ = writeln!(
        text,
        "{seconds:.9} {:.6} {:.6} {:.6} {:.9} {:.9} {:.9} {:.9}",
        p.x, p.y, p.z, q.x, q.y, q.z, q.w
    );
}
