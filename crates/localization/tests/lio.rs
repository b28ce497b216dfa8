//! Odometry with simulated sensors: in a room, along a street, and with sensors that fail.

mod simulated;

use nalgebra::{UnitQuaternion, Vector3};
use openbench_core::{Pose3, SimTime};
use openbench_localization::lio::{Estimate, Status};
use simulated::{Drive, SensorData, circle, room};

/// Distance from the truth on the ground, metres.
fn error(estimate: &Estimate) -> f64 {
    let truth = circle(estimate.stamp.seconds());
    (estimate.pose.translation.vector - truth.translation.vector)
        .xy()
        .norm()
}

/// Whether the error is as large as the covariance allows.
fn is_consistent(estimate: &Estimate) -> bool {
    let variance = estimate.covariance[(3, 3)] + estimate.covariance[(4, 4)];
    error(estimate) < 4.0 * variance.sqrt() + 0.02
}

/// No sensor data for a time.
fn silence(data: &mut SensorData, millis: std::ops::Range<u64>) {
    if millis.contains(&data.millis) {
        data.imu = None;
        data.scan = None;
    }
}

#[test]
fn a_circle_in_a_room_is_followed_to_two_centimetres() {
    let drive = Drive::new(20, |_| ());
    assert!(drive.estimates.len() > 180);
    assert_eq!(drive.odometry.refused().imu, 0);
    // The first scan finds no map.
    let mut later = drive.estimates[1..].iter();
    assert!(later.all(|estimate| estimate.status == Status::Tracking));
    let worst = drive.estimates.iter().map(error).fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst}");
    let last = drive.last();
    let truth = circle(last.stamp.seconds());
    assert!(last.pose.rotation.angle_to(&truth.rotation) < 0.005);
    assert!((0.2..1.2).contains(&last.fit), "{}", last.fit);
}

#[test]
fn the_same_data_give_the_same_estimates_to_the_bit() {
    let drive = || Drive::new(4, |_| ()).estimates;
    assert_eq!(drive(), drive());
}

#[test]
fn half_a_second_without_sensors_is_bridged() {
    let drive = Drive::new(12, |data| silence(data, 6000..6500));
    assert_eq!(drive.odometry.refused().gaps, 1);
    let error = error(drive.last());
    assert!(error < 0.05, "{error}");
}

#[test]
fn with_a_blind_lidar_the_odometry_coasts_and_its_covariance_grows() {
    let begin = SimTime::from_millis(5000);
    let drive = Drive::new(8, |data| {
        if let Some(scan) = &mut data.scan
            && scan.stamp >= begin
        {
            scan.points.truncate(10);
        }
    });
    let first = drive
        .estimates
        .partition_point(|estimate| estimate.stamp < begin);
    let (seeing, blind) = drive.estimates.split_at(first);
    assert!(blind.len() > 20);
    assert!(
        blind
            .iter()
            .all(|estimate| estimate.status == Status::Coasting)
    );
    let before = seeing[seeing.len() - 1].covariance[(3, 3)];
    let last = drive.last();
    assert!(last.covariance[(3, 3)] > 10.0 * before);
    assert!(is_consistent(last));
}

#[test]
fn a_lidar_that_is_not_mounted_as_configured_is_disputed() {
    for rotation in [Vector3::y() * 0.1, Vector3::x() * -0.1, Vector3::z() * 0.4] {
        let turn = UnitQuaternion::new(rotation).cast::<f32>();
        let drive = Drive::new(12, |data| {
            for point in data.scan.iter_mut().flat_map(|scan| &mut scan.points) {
                point.xyz = (turn * Vector3::from(point.xyz)).into();
            }
        });
        let statuses = drive.estimates.iter().map(|estimate| estimate.status);
        let disputed = statuses
            .filter(|status| *status == Status::Disputed)
            .count();
        assert!(
            disputed > 20,
            "{rotation}: {disputed} of {}",
            drive.estimates.len()
        );
    }
}

#[test]
fn impossible_data_are_refused_and_counted() {
    let drive = Drive::new(6, |data| {
        if let Some(sample) = &mut data.imu {
            match data.millis {
                2010 => sample.gyro[1] = f64::NAN,
                2020 => sample.accel[2] = f64::INFINITY,
                2030 => sample.stamp = SimTime::ZERO,
                2040 => sample.gyro[0] = 1e200,
                _ => {}
            }
        }
        if let Some(scan) = &mut data.scan {
            match data.millis {
                3000 => scan.points.clear(),
                3100 => scan.stamp = SimTime::ZERO,
                3200 => scan
                    .points
                    .iter_mut()
                    .for_each(|point| point.xyz = [f32::NAN; 3]),
                3300 => scan
                    .points
                    .iter_mut()
                    .for_each(|point| point.xyz = [0.0; 3]),
                3400 => scan.points.reverse(),
                _ => {}
            }
        }
    });
    let refused = drive.odometry.refused();
    assert_eq!(refused.imu, 4);
    assert_eq!(refused.points, 8000);
    assert!(refused.scans >= 1, "{refused:?}");
    assert!(error(drive.last()) < 0.03);
}

#[test]
fn without_scans_the_odometry_coasts() {
    let drive = Drive::new(8, |data| {
        if data.millis >= 5000 {
            data.scan = None;
        }
    });
    let late = SimTime::from_millis(5200);
    let first = drive
        .estimates
        .partition_point(|estimate| estimate.stamp <= late);
    let late = &drive.estimates[first..];
    assert!(late.len() > 5);
    assert!(
        late.iter()
            .all(|estimate| estimate.status == Status::Coasting)
    );
    assert!(drive.last().stamp > SimTime::from_millis(7500));
    assert!(is_consistent(drive.last()));
}

/// An hour, in milliseconds.
const HOUR: u64 = 3_600_000;

/// An hour later after six seconds. Two scans are of another clock.
fn with_a_lost_hour(data: &mut SensorData) {
    let delay = if data.millis < 6000 { 0 } else { HOUR };
    let later = |stamp: SimTime| SimTime::from_millis(delay) + stamp.since(SimTime::ZERO);
    if let Some(sample) = &mut data.imu {
        sample.stamp = later(sample.stamp);
    }
    if let Some(scan) = &mut data.scan {
        let is_of_another_clock = data.millis == 3000 || data.millis == 0;
        let other_clock = SimTime(u64::MAX - 5);
        scan.stamp = if is_of_another_clock {
            other_clock
        } else {
            later(scan.stamp)
        };
    }
}

#[test]
fn after_an_hour_without_sensors_the_pose_is_lost_once() {
    let drive = Drive::new(10, with_a_lost_hour);
    let refused = drive.odometry.refused();
    assert_eq!(refused.gaps, 1);
    assert_eq!(refused.imu, 0);
    let is_lost = |estimate: &&Estimate| estimate.status == Status::Lost;
    let lost: Vec<_> = drive.estimates.iter().filter(is_lost).collect();
    assert_eq!(lost.len(), 1);
    assert!(lost[0].covariance[(3, 3)] > 1e3);
    let mut earlier = drive
        .estimates
        .iter()
        .filter(|estimate| estimate.stamp < lost[0].stamp);
    let before = earlier.next_back().unwrap();
    assert_eq!(before.status, Status::Tracking);
    assert!(error(before) < 0.02);
    assert_eq!(drive.last().status, Status::Tracking);
    assert!(drive.last().stamp > SimTime::from_millis(HOUR + 9500));
}

/// Straight on after one and a half seconds, up to 1 m/s.
fn ahead(seconds: f64) -> Pose3 {
    let t = (seconds - 1.5).max(0.0);
    Pose3::translation(if t < 1.0 { 0.5 * t * t } else { t - 0.5 }, 0.0, 0.0)
}

/// Range on level ground with pillars on both sides. Distant ground seems to lie too low, as it may
/// where rays graze it.
fn bending_street(from: Vector3<f64>, along: Vector3<f64>) -> f64 {
    const MAX_RANGE_M: f64 = 25.0;
    const BEND: f64 = 2e-4;
    let ground = (-0.5 - from.z) / along.z;
    let ground = if ground > 0.0 { ground } else { f64::INFINITY };
    // Ground that is too low by b d² / 2 is met later by that over the ray's slope.
    let mut range = ground * (1.0 + 0.5 * BEND * ground * ground / 0.7);
    for i in -8..25 {
        let x = f64::from(i) * 4.0;
        range = range.min(pillar(from, along, x, -3.0));
        range = range.min(pillar(from, along, x + 1.0, 4.0));
    }
    if range < MAX_RANGE_M {
        range
    } else {
        f64::INFINITY
    }
}

/// Range to an endless pillar of one metre whose south-west corner is at x and y.
fn pillar(from: Vector3<f64>, along: Vector3<f64>, x: f64, y: f64) -> f64 {
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for (axis, low) in [x, y].into_iter().enumerate() {
        let [a, b] = [low, low + 1.0].map(|side| (side - from[axis]) / along[axis]);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    if near < far && near > 0.0 {
        near
    } else {
        f64::INFINITY
    }
}

#[test]
fn gravity_keeps_a_map_level_whose_distant_ground_seems_too_low() {
    let drive = Drive::along(ahead, bending_street, 60, |_| ());
    let last = drive.last();
    let truth = ahead(last.stamp.seconds()).translation.vector;
    let height = last.pose.translation.z;
    // If the map counts as level, it ends 7 cm too low with a tilt of 2.6 milliradians.
    let pitch = last.pose.rotation.scaled_axis().y;
    assert!(
        height.abs() < 0.03 && pitch.abs() < 1e-3,
        "{height} {pitch}"
    );
    assert!(height.abs() < 4.0 * last.covariance[(5, 5)].sqrt());
    assert!((last.pose.translation.vector - truth).xy().norm() < 0.05);
}

/// The circle, but from the eighth second on the robot stands tipped forwards.
fn tipped(seconds: f64) -> Pose3 {
    let pitch = if seconds < 8.0 { 0.0 } else { 0.1 };
    circle(seconds.min(7.0)) * Pose3::rotation(Vector3::y() * pitch)
}

/// The vertical direction in a pose's frame.
fn up(pose: &Pose3) -> Vector3<f64> {
    pose.rotation.inverse() * Vector3::z()
}

#[test]
fn a_robot_that_was_tipped_during_silence_finds_its_tilt() {
    let drive = Drive::along(tipped, room, 25, |data| silence(data, 7000..9500));
    let last = drive.last();
    assert!(last.stamp > SimTime::from_millis(24_500));
    assert_eq!(last.status, Status::Tracking);
    let off = up(&last.pose).angle(&up(&tipped(25.0)));
    assert!(off < 0.01, "{off}");
}
