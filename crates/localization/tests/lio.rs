//! Odometry in a room whose walls are known, along a way that is known.

use nalgebra::{UnitQuaternion, Vector3};
use openbench_core::{ImuSample, LidarPoint, LidarScan, Pose3, SimTime};
use openbench_localization::lio::{
    Estimate, ImuNoise, LidarInertialOdometry, LidarNoise, Settings, Status,
};

const GRAVITY: f64 = 9.8;
/// Milliseconds between samples of the IMU, and between scans.
const IMU: u64 = 10;
const SCAN: u64 = 100;
/// West, south, floor, east, north, ceiling.
const ROOM: [f64; 6] = [-6.0, -4.0, -0.5, 10.0, 9.0, 3.0];

/// Noise that is the same each time.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn settings() -> Settings {
    Settings {
        imu: Pose3::identity(),
        lidar: Pose3::translation(0.1, 0.0, 0.2),
        estimate_lidar: false,
        imu_noise: ImuNoise {
            gyro: 2e-4,
            accel: 2e-3,
            gyro_walk: 1e-5,
            accel_walk: 1e-4,
        },
        imu_limits: None,
        lidar_noise: LidarNoise {
            range: 0.01,
            angle: 0.001,
        },
        typical_speed: 1.0,
        blind: 0.3,
    }
}

/// Where something is at a time in seconds.
type Way = fn(f64) -> Pose3;
/// How far a ray goes from a place in a direction.
type Range = fn(Vector3<f64>, Vector3<f64>) -> f64;

/// At rest for one and a half seconds, then faster and faster round a circle of three metres, up to 0.9 m/s.
fn truth(seconds: f64) -> Pose3 {
    let t = (seconds - 1.5).max(0.0);
    let angle = if t < 1.5 {
        0.1 * t * t
    } else {
        0.225 + 0.3 * (t - 1.5)
    };
    let position = Vector3::new(3.0 * libm::sin(angle), 3.0 * (1.0 - libm::cos(angle)), 0.0);
    Pose3::from_parts(
        position.into(),
        UnitQuaternion::from_euler_angles(0.0, 0.0, angle),
    )
}

fn imu(way: Way, millis: u64, noise: &mut Noise) -> ImuSample {
    let (t, dt) = (millis as f64 / 1e3, 1e-3);
    let [before, here, after] = [t - dt, t, t + dt].map(way);
    let position = |pose: &Pose3| pose.translation.vector;
    let acceleration = (position(&after) - position(&here) * 2.0 + position(&before)) / (dt * dt);
    let force = here.rotation.inverse() * (acceleration + Vector3::z() * GRAVITY);
    let rate = (before.rotation.inverse() * after.rotation).scaled_axis() / (2.0 * dt);
    let mut noisy = |v: Vector3<f64>, bias: f64, white: f64| {
        [0, 1, 2].map(|i| v[i] + bias + white * noise.normal())
    };
    let (gyro, accel) = (noisy(rate, 0.002, 5e-4), noisy(force, 0.01, 5e-3));
    ImuSample {
        stamp: SimTime::from_millis(millis),
        gyro,
        accel,
    }
}

/// How far a wall of the room is.
fn room(from: Vector3<f64>, along: Vector3<f64>) -> f64 {
    let range = (0..3).map(|i| (ROOM[if along[i] > 0.0 { i + 3 } else { i }] - from[i]) / along[i]);
    range.fold(f64::INFINITY, f64::min)
}

fn scan(way: Way, range: Range, millis: u64, noise: &mut Noise) -> LidarScan {
    let rays = 4000;
    let points = (0..rays).filter_map(|ray| {
        let offset_ns = (SCAN * 1_000_000 * ray / rays) as u32;
        let pose = way(millis as f64 / 1e3 + f64::from(offset_ns) * 1e-9) * settings().lidar;
        let (up, round) = (
            2.0 * noise.uniform() - 1.0,
            std::f64::consts::TAU * noise.uniform(),
        );
        let level = (1.0 - up * up).sqrt();
        let direction = Vector3::new(level * libm::cos(round), level * libm::sin(round), up);
        let (from, along) = (pose.translation.vector, pose.rotation * direction);
        let range = range(from, along) + 0.01 * noise.normal();
        let xyz = (direction * range).map(|x| x as f32).into();
        range.is_finite().then_some(LidarPoint {
            xyz,
            offset_ns,
            reflectivity: 100,
            line: 0,
        })
    });
    LidarScan {
        stamp: SimTime::from_millis(millis),
        points: points.collect(),
    }
}

/// The way of so many seconds; `spoil` may change or take away what the sensors say.
fn drive(
    seconds: u64,
    spoil: impl Fn(u64, Option<ImuSample>, Option<LidarScan>) -> (Option<ImuSample>, Option<LidarScan>),
) -> (LidarInertialOdometry, Vec<Estimate>) {
    drive_along(truth, room, seconds, spoil)
}

fn drive_along(
    way: Way,
    range: Range,
    seconds: u64,
    spoil: impl Fn(u64, Option<ImuSample>, Option<LidarScan>) -> (Option<ImuSample>, Option<LidarScan>),
) -> (LidarInertialOdometry, Vec<Estimate>) {
    let (mut odometry, mut noise) = (LidarInertialOdometry::new(settings()), Noise(1));
    let mut estimates = Vec::new();
    for millis in (0..seconds * 1000).step_by(IMU as usize) {
        let begun = (millis.is_multiple_of(SCAN)).then(|| scan(way, range, millis, &mut noise));
        let (sample, scan) = spoil(millis, Some(imu(way, millis, &mut noise)), begun);
        estimates.extend(sample.into_iter().flat_map(|sample| odometry.imu(sample)));
        estimates.extend(scan.into_iter().flat_map(|scan| odometry.scan(scan)));
    }
    (odometry, estimates)
}

fn error(estimate: &Estimate) -> f64 {
    (estimate.pose.translation.vector - truth(estimate.stamp.seconds()).translation.vector)
        .xy()
        .norm()
}

#[test]
fn a_round_in_a_room_ends_where_it_ends() {
    let (odometry, estimates) = drive(20, |_, imu, scan| (imu, scan));
    assert!(estimates.len() > 180 && odometry.refused().imu == 0);
    // The first scan finds no map.
    assert!(
        estimates[1..]
            .iter()
            .all(|estimate| estimate.status == Status::Tracking)
    );
    let worst = estimates.iter().map(error).fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst}");
    let last = &estimates[estimates.len() - 1];
    assert!(
        last.pose
            .rotation
            .angle_to(&truth(last.stamp.seconds()).rotation)
            < 0.005
    );
    assert!((0.2..1.2).contains(&last.fit), "{}", last.fit);
}

#[test]
fn the_same_data_give_the_same_way_to_the_bit() {
    let drive = || drive(4, |_, imu, scan| (imu, scan)).1;
    assert_eq!(drive(), drive());
}

#[test]
fn half_a_second_without_sensors_is_survived() {
    let gone = |millis: u64| (6000..6500).contains(&millis);
    let spoil = |millis, imu: Option<_>, scan: Option<_>| {
        (
            imu.filter(|_| !gone(millis)),
            scan.filter(|_| !gone(millis)),
        )
    };
    let (odometry, estimates) = drive(12, spoil);
    assert_eq!(odometry.refused().gaps, 1);
    assert!(
        error(&estimates[estimates.len() - 1]) < 0.05,
        "{}",
        error(&estimates[estimates.len() - 1])
    );
}

#[test]
fn a_blind_lidar_is_announced_and_the_covariance_grows() {
    let (_, estimates) = drive(8, |millis, imu, scan| {
        let blinded = scan.map(|mut scan| {
            if millis >= 5000 {
                scan.points.truncate(10);
            }
            scan
        });
        (imu, blinded)
    });
    let (seeing, blind) =
        estimates.split_at(estimates.partition_point(|e| e.stamp < SimTime::from_millis(5000)));
    assert!(
        blind.len() > 20
            && blind
                .iter()
                .all(|estimate| estimate.status == Status::Coasting)
    );
    let variance = |estimate: &Estimate| estimate.covariance[(3, 3)];
    let last = &blind[blind.len() - 1];
    assert!(variance(last) > 10.0 * variance(&seeing[seeing.len() - 1]));
    assert!(error(last) < 4.0 * (last.covariance[(3, 3)] + last.covariance[(4, 4)]).sqrt() + 0.02);
}

#[test]
fn a_lidar_that_is_turned_otherwise_than_is_believed_is_told() {
    for turned in [Vector3::y() * 0.1, Vector3::x() * -0.1, Vector3::z() * 0.4] {
        let turn = UnitQuaternion::new(turned).cast::<f32>();
        let (_, estimates) = drive(12, |_, imu, mut scan: Option<LidarScan>| {
            for point in scan.iter_mut().flat_map(|scan| &mut scan.points) {
                point.xyz = (turn * Vector3::from(point.xyz)).into();
            }
            (imu, scan)
        });
        let disputed = estimates
            .iter()
            .filter(|estimate| estimate.status == Status::Disputed)
            .count();
        assert!(disputed > 20, "{turned}: {disputed} of {}", estimates.len());
    }
}

#[test]
fn nonsense_is_refused_and_counted() {
    let (odometry, estimates) = drive(6, |millis, imu, scan| {
        let imu = imu.map(|mut sample| {
            match millis {
                2010 => sample.gyro[1] = f64::NAN,
                2020 => sample.accel[2] = f64::INFINITY,
                2030 => sample.stamp = SimTime::ZERO,
                2040 => sample.gyro[0] = 1e200,
                _ => {}
            }
            sample
        });
        let scan = scan.map(|mut scan| {
            match millis {
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
            scan
        });
        (imu, scan)
    });
    let refused = odometry.refused();
    assert_eq!((refused.imu, refused.points), (4, 8000));
    assert!(refused.scans >= 1, "{refused:?}");
    assert!(error(&estimates[estimates.len() - 1]) < 0.03);
}

#[test]
fn without_scans_the_way_goes_on_and_says_so() {
    let (_, estimates) = drive(8, |millis, imu, scan| (imu, scan.filter(|_| millis < 5000)));
    let late: Vec<_> = estimates
        .iter()
        .filter(|e| e.stamp > SimTime::from_millis(5200))
        .collect();
    assert!(
        late.len() > 5
            && late
                .iter()
                .all(|estimate| estimate.status == Status::Coasting)
    );
    let last = late[late.len() - 1];
    assert!(last.stamp > SimTime::from_millis(7500));
    assert!(error(last) < 4.0 * (last.covariance[(3, 3)] + last.covariance[(4, 4)]).sqrt() + 0.02);
}

#[test]
fn an_hour_without_sensors_is_told_and_a_scan_of_another_clock_stops_nothing() {
    let hour = 3_600_000;
    let (odometry, estimates) = drive(10, |millis, imu, scan| {
        let late = |stamp: SimTime| {
            if millis < 6000 {
                stamp
            } else {
                SimTime::from_millis(hour) + stamp.since(SimTime::ZERO)
            }
        };
        let imu = imu.map(|imu| ImuSample {
            stamp: late(imu.stamp),
            ..imu
        });
        let scan = scan.map(|mut scan| {
            let elsewhere = millis == 3000 || millis == 0;
            scan.stamp = if elsewhere {
                SimTime(u64::MAX - 5)
            } else {
                late(scan.stamp)
            };
            scan
        });
        (imu, scan)
    });
    assert_eq!((odometry.refused().gaps, odometry.refused().imu), (1, 0));
    let lost: Vec<_> = estimates
        .iter()
        .filter(|estimate| estimate.status == Status::Lost)
        .collect();
    assert!(lost.len() == 1 && lost[0].covariance[(3, 3)] > 1e3);
    let before = estimates
        .iter()
        .rfind(|estimate| estimate.stamp < lost[0].stamp)
        .unwrap();
    assert!(before.status == Status::Tracking && error(before) < 0.02);
    let last = &estimates[estimates.len() - 1];
    assert!(last.status == Status::Tracking && last.stamp > SimTime::from_millis(hour + 9500));
}

/// Straight on after one and a half seconds, up to 1 m/s.
fn ahead(seconds: f64) -> Pose3 {
    let t = (seconds - 1.5).max(0.0);
    Pose3::translation(if t < 1.0 { 0.5 * t * t } else { t - 0.5 }, 0.0, 0.0)
}

/// Level ground and pillars on both sides of it as far as the LiDAR sees. Ground far off seems to lie too low, as it may where rays graze it.
fn bending_street(from: Vector3<f64>, along: Vector3<f64>) -> f64 {
    const FARTHEST: f64 = 25.0;
    const BEND: f64 = 2e-4;
    let ground = (-0.5 - from.z) / along.z;
    let ground = if ground > 0.0 { ground } else { f64::INFINITY };
    // What lies too low by b d² / 2 is met later by that over the ray's slope.
    let ground = ground * (1.0 + 0.5 * BEND * ground * ground / 0.7);
    let pillars =
        (-8..25).flat_map(|i| [(f64::from(i) * 4.0, -3.0), (f64::from(i) * 4.0 + 1.0, 4.0)]);
    let hits = pillars.filter_map(|(x, y)| {
        let sides = |i: usize, low: f64| {
            let [a, b] = [low, low + 1.0].map(|side| (side - from[i]) / along[i]);
            (a.min(b), a.max(b))
        };
        let ((x0, x1), (y0, y1)) = (sides(0, x), sides(1, y));
        let (near, far) = (x0.max(y0), x1.min(y1));
        (near < far && near > 0.0).then_some(near)
    });
    let range = hits.fold(ground, f64::min);
    if range < FARTHEST {
        range
    } else {
        f64::INFINITY
    }
}

#[test]
fn gravity_keeps_a_map_level_whose_far_ground_seems_too_low() {
    let (_, estimates) = drive_along(ahead, bending_street, 60, |_, imu, scan| (imu, scan));
    let last = &estimates[estimates.len() - 1];
    let (there, height) = (
        ahead(last.stamp.seconds()).translation.vector,
        last.pose.translation.z,
    );
    // With the map taken for level it ends 7 cm too low, and leans by 2.6 milliradians.
    let pitch = last.pose.rotation.scaled_axis().y;
    assert!(
        height.abs() < 0.03 && pitch.abs() < 1e-3,
        "{height} {pitch}"
    );
    assert!(height.abs() < 4.0 * last.covariance[(5, 5)].sqrt());
    assert!((last.pose.translation.vector - there).xy().norm() < 0.05);
}

/// The usual way, but from the eighth second on it stands tipped forwards.
fn tipped(seconds: f64) -> Pose3 {
    let lean = if seconds < 8.0 { 0.0 } else { 0.1 };
    truth(seconds.min(7.0)) * Pose3::rotation(Vector3::y() * lean)
}

#[test]
fn a_robot_that_was_tipped_while_nothing_was_said_knows_how_it_leans() {
    let gone = |millis: u64| (7000..9500).contains(&millis);
    let (_, estimates) = drive_along(tipped, room, 25, |millis, imu, scan| {
        (
            imu.filter(|_| !gone(millis)),
            scan.filter(|_| !gone(millis)),
        )
    });
    let last = &estimates[estimates.len() - 1];
    assert!(last.stamp > SimTime::from_millis(24_500) && last.status == Status::Tracking);
    let up = |pose: &Pose3| pose.rotation.inverse() * Vector3::z();
    let off = up(&last.pose).angle(&up(&tipped(25.0)));
    assert!(off < 0.01, "{off}");
}
