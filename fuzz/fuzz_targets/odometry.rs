#![no_main]
//! The odometry among whatever sensors say: an input is a row of samples and scans, each begun by a byte that says what it is. Numbers are taken as they are, or of a size that happens.

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use nalgebra::Vector3;
use openbench_core::{ImuSample, LidarPoint, LidarScan, RobotDescription, SimTime};
use openbench_fuzz::number;
use openbench_localization::lidar_inertial::sensor_settings;
use openbench_localization::lio::{Estimate, LidarInertialOdometry, Speed};

fn vector(input: &mut Unstructured<'_>, size: f64) -> Result<[f64; 3]> {
    Ok([
        number(input, size)?,
        number(input, size)?,
        number(input, size)?,
    ])
}

/// Some milliseconds on, or anywhere.
fn stamp(input: &mut Unstructured<'_>, last: &mut SimTime) -> Result<SimTime> {
    if input.ratio(1, 100)? {
        return Ok(SimTime(input.arbitrary()?));
    }
    last.0 = last
        .0
        .wrapping_add(u64::from(input.arbitrary::<u8>()?) * 200_000);
    Ok(*last)
}

fn scan(input: &mut Unstructured<'_>, stamp: SimTime) -> Result<LidarScan> {
    // Two walls and a floor, so that there is something to go by, and points anywhere.
    let (distances, count) = (vector(input, 10.0)?, input.int_in_range(0..=3000_u32)?);
    let mut points = Vec::new();
    for i in 0..count {
        let axis = i as usize % 3;
        let mut xyz = [
            f64::from(i % 60) * 0.1,
            f64::from(i / 60) * 0.1,
            distances[axis],
        ];
        xyz.rotate_left(axis);
        if i % 50 == 0 {
            xyz = vector(input, 50.0)?;
        }
        points.push(LidarPoint {
            xyz: xyz.map(|x| x as f32),
            offset_ns: i * 30_000,
            reflectivity: 0,
            line: 0,
        });
    }
    Ok(LidarScan { stamp, points })
}

fn run(input: &mut Unstructured<'_>) -> Result<()> {
    let mut odometry = LidarInertialOdometry::new(sensor_settings(&RobotDescription::sentry()));
    let (mut now, mut estimates): (_, Vec<Estimate>) = (SimTime::ZERO, Vec::new());
    while !input.is_empty() {
        let stamp = stamp(input, &mut now)?;
        match input.int_in_range(0..=9)? {
            0 => estimates.extend(odometry.scan(scan(input, stamp)?)),
            1 => {
                let (velocity, deviation) = (vector(input, 2.0)?, vector(input, 1.0)?);
                let deviation = deviation.map(|x| x.abs() + 1e-3);
                odometry.speed(Speed {
                    stamp,
                    velocity: velocity.into(),
                    deviation: deviation.into(),
                    turn: velocity[1],
                });
            }
            _ => {
                let (gyro, mut accel) = (vector(input, 1.0)?, vector(input, 2.0)?);
                accel[2] += 9.8;
                // Samples come in bursts: the start takes a second of them.
                for i in 0..input.int_in_range(1..=40_u64)? {
                    let stamp = SimTime(stamp.0.saturating_add(i * 10_000_000));
                    estimates.extend(odometry.imu(ImuSample { stamp, gyro, accel }));
                    now = now.max(stamp);
                }
            }
        }
    }
    let finite = |v: Vector3<f64>| v.iter().all(|x| x.is_finite());
    assert!(
        estimates
            .iter()
            .all(|estimate| finite(estimate.pose.translation.vector) && finite(estimate.velocity))
    );
    assert!(
        estimates
            .iter()
            .all(|estimate| estimate.covariance.iter().all(|x| x.is_finite()))
    );
    assert!(
        estimates
            .iter()
            .all(|estimate| estimate.covariance.diagonal().iter().all(|x| *x >= 0.0))
    );
    Ok(())
}

fuzz_target!(|bytes: &[u8]| {
    let _ = run(&mut Unstructured::new(bytes));
});
