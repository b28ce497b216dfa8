//! What the LiDAR saw on a few metres of the way, in the frame `odom`.

use std::f64::consts::TAU;
use std::time::Duration;

use nalgebra::{Point3, Vector3};
use openbench_core::{LidarScan, MapPoint, Pose2, Pose3};

use super::columns::{CELL_M, Columns, Facade};

/// A stretch ends after this distance, metres.
pub const STRETCH_M: f64 = 5.0;
/// A scan is taken after this distance, metres,
const SCAN_DISTANCE_M: f64 = 0.3;
/// or this turn, radians.
const SCAN_TURN_RAD: f64 = 0.2;
/// At the start so many scans are taken, though the robot stands.
const FIRST_SCANS: usize = 5;
/// Places this far apart count as different views, metres.
const VIEW_DISTANCE_M: f64 = 1.0;
/// Directions of a panorama.
pub const DIRECTIONS: usize = 360;
/// Points farther away are left out, metres: their heights are uncertain.
const MAX_RANGE_M: f64 = 45.0;
/// A scan is put straight in slices of this duration.
const SLICE: Duration = Duration::from_millis(10);

/// How far the robot saw over free ground from one place, by direction.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Panorama {
    /// The place.
    pub from: MapPoint,
    /// Metres of free ground in each direction, from that of the x axis counter-clockwise.
    pub free: Vec<f32>,
}

/// What was seen on a few metres.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Stretch {
    /// Pose of the robot at its end, in `odom`.
    pub end: Pose2,
    /// Distance driven, metres.
    pub metres: f64,
    /// Pieces of facades.
    pub facades: Vec<Facade>,
    /// What was free, from places about a metre apart.
    pub panoramas: Vec<Panorama>,
}

/// Where the robot is while a scan is taken: poses of `base_link` in `odom`.
pub trait Track {
    /// The pose at an instant of the last second.
    fn pose_at(&self, time: openbench_core::SimTime) -> Pose3;
}

/// Gathers scans into stretches.
#[derive(Debug, Clone)]
pub struct Gatherer {
    /// Pose of the LiDAR in `base_link`.
    lidar: Pose3,
    open: Option<Open>,
}

/// A stretch that has not ended.
#[derive(Debug, Clone)]
struct Open {
    columns: Columns,
    views: Vec<View>,
    scans: usize,
    /// Where the last scan was taken.
    last: Pose2,
    metres: f64,
}

/// A place from which was seen.
#[derive(Debug, Clone)]
struct View {
    from: MapPoint,
    /// The farthest return in each direction, metres.
    farthest: Vec<f32>,
}

impl Gatherer {
    /// For a LiDAR at this pose in `base_link`.
    pub fn new(lidar: Pose3) -> Self {
        Self { lidar, open: None }
    }

    /// Takes in a scan; gives the stretch that it ends, if it does.
    pub fn take(&mut self, scan: &LidarScan, track: &dyn Track) -> Option<Stretch> {
        let last = scan.points.last()?;
        let end = scan.stamp + Duration::from_nanos(u64::from(last.offset_ns));
        let here = Pose2::from_pose3(&track.pose_at(end));
        let open = self.open.get_or_insert_with(|| Open::at(here));
        if !open.is_due(here) {
            return None;
        }
        open.metres += open.last.point().distance(here.point());
        open.last = here;
        open.scans += 1;
        open.begin_view(here.point());
        open.add(scan, &self.lidar, track);
        if open.metres < STRETCH_M {
            return None;
        }
        let ended = open.stretch();
        self.open = None;
        Some(ended)
    }

    /// The stretch as it is now; `None` before the first scan.
    pub fn unfinished(&self) -> Option<Stretch> {
        self.open.as_ref().map(Open::stretch)
    }
}

impl Open {
    fn at(start: Pose2) -> Self {
        Self {
            columns: Columns::around(start.point()),
            views: Vec::new(),
            scans: 0,
            last: start,
            metres: 0.0,
        }
    }

    fn is_due(&self, here: Pose2) -> bool {
        let turn = openbench_core::frames::wrap_angle(here.yaw - self.last.yaw).abs();
        self.scans < FIRST_SCANS
            || here.point().distance(self.last.point()) >= SCAN_DISTANCE_M
            || turn >= SCAN_TURN_RAD
    }

    fn begin_view(&mut self, here: MapPoint) {
        let is_new = self
            .views
            .last()
            .is_none_or(|view| view.from.distance(here) >= VIEW_DISTANCE_M);
        if is_new {
            self.views.push(View {
                from: here,
                farthest: vec![0.0; DIRECTIONS],
            });
        }
    }

    fn add(&mut self, scan: &LidarScan, lidar: &Pose3, track: &dyn Track) {
        let number = (self.views.len() - 1) as u16;
        let Some(view) = self.views.last_mut() else {
            return;
        };
        let slice_ns = SLICE.as_nanos() as u32;
        for points in scan
            .points
            .chunk_by(|a, b| a.offset_ns / slice_ns == b.offset_ns / slice_ns)
        {
            let middle = (points[0].offset_ns / slice_ns) as u64 * u64::from(slice_ns);
            let time = scan.stamp + Duration::from_nanos(middle) + SLICE / 2;
            let base = track.pose_at(time);
            let sensor = base * lidar;
            let ground = base.translation.z;
            for point in points {
                let xyz = Point3::from(Vector3::from(point.xyz).cast::<f64>());
                let at = sensor * xyz;
                let place = MapPoint::new(at.x, at.y);
                let range = view.from.distance(place);
                if range > MAX_RANGE_M {
                    continue;
                }
                let direction = direction(view.from.bearing_to(place));
                view.farthest[direction] = view.farthest[direction].max(range as f32);
                self.columns.add(place, (at.z - ground) as f32, number);
            }
        }
    }

    fn stretch(&self) -> Stretch {
        Stretch {
            end: self.last,
            metres: self.metres,
            facades: self.columns.facades(self.last.point()),
            panoramas: self.views.iter().map(|view| self.panorama(view)).collect(),
        }
    }

    fn panorama(&self, view: &View) -> Panorama {
        let free = view.farthest.iter().enumerate().map(|(i, farthest)| {
            let bearing = (i as f64 + 0.5) * TAU / DIRECTIONS as f64;
            let (sine, cosine) = libm::sincos(bearing);
            let mut range = 0.5;
            while range < f64::from(*farthest) {
                let at = MapPoint::new(view.from.x + cosine * range, view.from.y + sine * range);
                if self.columns.is_occupied(at) {
                    break;
                }
                range += 0.5 * CELL_M;
            }
            range.min(f64::from(*farthest)) as f32
        });
        Panorama {
            from: view.from,
            free: free.collect(),
        }
    }
}

/// The direction of a panorama that a bearing belongs to.
pub(super) fn direction(bearing: f64) -> usize {
    let turned = bearing.rem_euclid(TAU) / TAU * DIRECTIONS as f64;
    (turned as usize).min(DIRECTIONS - 1)
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::super::town::{Still, block, scan, stretch_at};
    use super::*;

    #[test]
    fn a_wall_is_seen_where_it_is_and_the_ground_before_it_is_free() {
        let seen = stretch_at(&[block(10.0, 0.0, 6.0, 8.0)], Pose2::default());
        assert!(seen.facades.len() > 10);
        let is_on_wall = |facade: &&Facade| (facade.at.x - 7.0).abs() < 0.01;
        assert!(seen.facades.iter().filter(is_on_wall).count() >= 10);
        let panorama = &seen.panoramas[0];
        let ahead = panorama.free[direction(0.01)];
        assert!((6.5..7.1).contains(&ahead), "{ahead}");
        // To the rear nothing is met: the ground is seen as far as the beams come back.
        let rear = panorama.free[direction(3.0)];
        assert!(rear > 15.0, "{rear}");
    }

    #[test]
    fn a_stretch_ends_after_five_metres() {
        let houses = [block(10.0, 9.0, 30.0, 8.0)];
        let mut gatherer = Gatherer::new(Pose3::translation(0.0, 0.0, 0.3));
        let mut ended = Vec::new();
        for i in 0..60 {
            let pose = Pose2::new(0.2 * f64::from(i), 0.0, 0.0);
            let scan = scan(&houses, pose, SimTime::from_millis(100 * i as u64));
            ended.extend(gatherer.take(&scan, &Still(pose)));
        }
        assert_eq!(ended.len(), 2);
        for stretch in &ended {
            assert!((5.0..5.5).contains(&stretch.metres), "{}", stretch.metres);
            assert!((5..=6).contains(&stretch.panoramas.len()));
            let most = stretch.facades.iter().map(|facade| facade.views).max();
            assert!((5..=6).contains(&most.unwrap()), "{most:?}");
        }
    }

    #[test]
    fn an_empty_scan_is_no_evidence() {
        let mut gatherer = Gatherer::new(Pose3::identity());
        let scan = LidarScan {
            stamp: SimTime::ZERO,
            points: Vec::new(),
        };
        assert_eq!(gatherer.take(&scan, &Still(Pose2::default())), None);
        assert_eq!(gatherer.unfinished(), None);
    }
}
