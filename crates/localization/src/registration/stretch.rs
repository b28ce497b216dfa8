//! What the LiDAR saw on a few metres of the way, in the frame `odom`.

use std::f64::consts::TAU;
use std::time::Duration;

use nalgebra::{Matrix3, Point3, Vector3};
use openbench_core::frames::wrap_angle;
use openbench_core::{LidarScan, MapPoint, Pose2, Pose3};

use crate::reckoned::Reckoned;
use crate::track::Track;

use super::columns::{CELL_M, Columns, Facade, Label, Sight, Surveyed};

/// A stretch ends after this distance, metres.
pub const STRETCH_M: f64 = 5.0;
/// A scan is taken after this distance, metres,
const SCAN_DISTANCE_M: f64 = 0.3;
/// or this turn, radians.
const SCAN_TURN_RAD: f64 = 0.2;
/// At the start so many scans are taken, though the robot stands.
pub const FIRST_SCANS: u16 = 5;
/// No more scans are taken, as when a robot turns on the spot.
const MOST_SCANS: u16 = 60;
/// A pose farther than this from the last one is of another `odom`, metres.
const JUMP_M: f64 = 3.0;
/// Places this far apart count as different views, metres.
const VIEW_DISTANCE_M: f64 = 1.0;
/// Directions of a panorama.
pub const DIRECTIONS: usize = 360;
/// Points farther away are left out, metres: their heights are uncertain.
const MAX_RANGE_M: f64 = 45.0;
/// Returns with a lower probability of being on a facade never count as facade.
const FACADE_PROBABILITY: f32 = 0.5;
/// A scan is put straight in slices of this duration.
const SLICE: Duration = Duration::from_millis(10);
/// Later points of a scan are in its last slice.
const MOST_SLICES: u32 = 50;

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
    /// Covariance of the motion since the end of the stretch before, as odometry has it, in the
    /// frame of `end`: forward, left, yaw; m² and rad².
    pub drift: [[f64; 3]; 3],
    /// Pieces of facades.
    pub facades: Vec<Facade>,
    /// What was free, from places about a metre apart.
    pub panoramas: Vec<Panorama>,
}

/// Gathers scans into stretches.
#[derive(Debug, Clone)]
pub struct Gatherer {
    /// Pose of the LiDAR in `base_link`.
    lidar: Pose3,
    open: Option<Open>,
    /// The end of the last stretch; where there is none, the beginning of this one.
    since: Option<Reckoned>,
}

/// A stretch that has not ended.
#[derive(Debug, Clone)]
struct Open {
    columns: Columns,
    views: Vec<View>,
    scans: u16,
    /// Where the last scan was taken,
    last: Pose2,
    /// and where the robot is, which may have taken no scan there.
    newest: Reckoned,
    metres: f64,
}

/// A place from which was seen.
#[derive(Debug, Clone)]
struct View {
    from: MapPoint,
    farthest: Vec<Farthest>,
}

/// The farthest returns in a direction, metres. One alone may have come through a window.
#[derive(Debug, Clone, Copy, Default)]
struct Farthest {
    first: f32,
    second: f32,
}

impl Stretch {
    /// The same in another frame; `by` is the pose of this frame in that one. Directions of
    /// panoramas are rounded to whole ones.
    #[must_use]
    pub fn moved(&self, by: Pose2) -> Self {
        let facades = self.facades.iter().map(|facade| facade.moved(by));
        let panoramas = self.panoramas.iter().map(|panorama| panorama.moved(by));
        Self {
            end: by.compose(self.end),
            metres: self.metres,
            drift: self.drift,
            facades: facades.collect(),
            panoramas: panoramas.collect(),
        }
    }
}

impl Panorama {
    /// Bearing of each direction, radians, and metres of free ground along it.
    pub fn rays(&self) -> impl Iterator<Item = (f64, f64)> {
        let step = TAU / self.free.len() as f64;
        let free = self.free.iter().enumerate();
        free.map(move |(i, free)| ((i as f64 + 0.5) * step, f64::from(*free)))
    }

    fn moved(&self, by: Pose2) -> Self {
        let count = self.free.len();
        let steps = libm::round(by.yaw.rem_euclid(TAU) / TAU * count as f64) as usize;
        let mut free = self.free.clone();
        free.rotate_right(steps.min(count));
        Self {
            from: by.transform(self.from.x, self.from.y),
            free,
        }
    }
}

impl Gatherer {
    /// For a LiDAR at this pose in `base_link`.
    pub fn new(lidar: Pose3) -> Self {
        Self {
            lidar,
            open: None,
            since: None,
        }
    }

    /// Adds a scan, and returns the stretch if the scan ends one. Geometry alone decides what a
    /// facade is.
    pub fn take(&mut self, scan: &LidarScan, track: &dyn Track) -> Option<Stretch> {
        self.take_labelled(scan, &|_| 1.0, track)
    }

    /// The same for a scan with labels: `facade` is the probability that the point of this index is
    /// on a facade. Points below 0.5 never count as facade; for the others geometry decides.
    pub fn take_labelled(
        &mut self,
        scan: &LidarScan,
        facade: &dyn Fn(usize) -> f32,
        track: &dyn Track,
    ) -> Option<Stretch> {
        // Points are nearly in the order of their time, not quite.
        let last = scan.points.iter().map(|point| point.offset_ns).max()?;
        let end = scan.stamp + Duration::from_nanos(u64::from(last));
        let here = Pose2::from_pose3(&track.pose3_at(end));
        if !(here.x.is_finite() && here.y.is_finite() && here.yaw.is_finite()) {
            return None;
        }
        let jumped = |open: &Open| open.newest.pose.point().distance(here.point()) > JUMP_M;
        if self.open.as_ref().is_some_and(jumped) {
            (self.open, self.since) = (None, None);
        }
        let now = Reckoned {
            pose: here,
            covariance: track.pose_covariance().unwrap_or_else(Matrix3::zeros),
        };
        self.since.get_or_insert(now);
        let open = self.open.get_or_insert_with(|| Open::at(now));
        open.newest = now;
        if !open.is_due(here) {
            return None;
        }
        open.metres += open.last.point().distance(here.point());
        open.last = here;
        open.scans += 1;
        open.begin_view(here.point());
        open.add(scan, facade, last, &self.lidar, track);
        if open.metres < STRETCH_M {
            return None;
        }
        self.end()
    }

    /// Ends the stretch as it is now, after a look around; `None` before the first scan. The next
    /// one shows none of its scans again.
    pub fn end(&mut self) -> Option<Stretch> {
        let open = self.open.take()?;
        let since = self.since.replace(open.newest)?;
        Some(open.stretch(open.newest.growth_since(&since)))
    }

    /// Drops the scans of a stretch that has not ended. Its drift counts with the next one.
    pub fn restart(&mut self) {
        self.open = None;
    }
}

impl Open {
    fn at(start: Reckoned) -> Self {
        Self {
            columns: Columns::around(start.pose.point()),
            views: Vec::new(),
            scans: 0,
            last: start.pose,
            newest: start,
            metres: 0.0,
        }
    }

    fn is_due(&self, here: Pose2) -> bool {
        let turn = wrap_angle(here.yaw - self.last.yaw).abs();
        if self.scans == MOST_SCANS {
            // Where it drives on, the stretch shall end.
            return here.point().distance(self.last.point()) >= STRETCH_M;
        }
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
                farthest: vec![Farthest::default(); DIRECTIONS],
            });
        }
    }

    /// Takes in a scan whose last point is `last_ns` after its first.
    fn add(
        &mut self,
        scan: &LidarScan,
        facade: &dyn Fn(usize) -> f32,
        last_ns: u32,
        lidar: &Pose3,
        track: &dyn Track,
    ) {
        let Some(number) = self.views.len().checked_sub(1) else {
            return;
        };
        let view = &mut self.views[number];
        let slice_ns = SLICE.as_nanos() as u32;
        let slices = (last_ns / slice_ns).min(MOST_SLICES - 1);
        let bases: Vec<Pose3> = (0..=slices)
            .map(|slice| track.pose3_at(scan.stamp + SLICE * slice + SLICE / 2))
            .collect();
        let sight = Sight {
            scan: self.scans,
            view: number as u16,
            from: view.from,
        };
        for (index, point) in scan.points.iter().enumerate() {
            let slice = (point.offset_ns / slice_ns).min(slices);
            let base = &bases[slice as usize];
            let xyz = Point3::from(Vector3::from(point.xyz).cast::<f64>());
            let at = base * (lidar * xyz);
            let place = MapPoint::new(at.x, at.y);
            let range = view.from.distance(place);
            if range.is_nan() || range > MAX_RANGE_M {
                continue;
            }
            let direction = direction(view.from.bearing_to(place));
            view.farthest[direction].add(range as f32);
            let height = (at.z - base.translation.z) as f32;
            let label = if facade(index) >= FACADE_PROBABILITY {
                Label::Facade
            } else {
                Label::Other
            };
            self.columns.add(place, height, label, &sight);
        }
    }

    fn stretch(&self, drift: Matrix3<f64>) -> Stretch {
        let surveyed = self.columns.survey();
        let panoramas = self.views.iter().map(|view| view.panorama(&surveyed));
        Stretch {
            end: self.last,
            metres: self.metres,
            drift: drift.into(),
            panoramas: panoramas.collect(),
            facades: surveyed.facades,
        }
    }
}

impl View {
    /// What is free from here.
    fn panorama(&self, surveyed: &Surveyed) -> Panorama {
        let free = self.farthest.iter().enumerate().map(|(i, farthest)| {
            let farthest = f64::from(farthest.second);
            let bearing = (i as f64 + 0.5) * TAU / DIRECTIONS as f64;
            let (sine, cosine) = libm::sincos(bearing);
            let mut range = 0.5;
            while range < farthest {
                let at = MapPoint::new(self.from.x + cosine * range, self.from.y + sine * range);
                if surveyed.is_occupied(at) {
                    break;
                }
                range += 0.5 * CELL_M;
            }
            range.min(farthest) as f32
        });
        Panorama {
            from: self.from,
            free: free.collect(),
        }
    }
}

impl Farthest {
    fn add(&mut self, range: f32) {
        self.second = self.second.max(range.min(self.first));
        self.first = self.first.max(range);
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
    fn a_gable_faces_the_side_from_which_it_was_seen() {
        // The robot drives past a house and beyond it; at the end it is behind the near gable.
        let houses = [block(4.0, 5.0, 3.0, 6.0)];
        let mut gatherer = Gatherer::new(Pose3::translation(0.0, 0.0, 0.3));
        let mut ended = None;
        for i in 0..30 {
            let pose = Pose2::new(0.2 * f64::from(i), 0.0, 0.0);
            let scan = scan(&houses, pose, SimTime::from_millis(100 * i as u64));
            ended = ended.or(gatherer.take(&scan, &Still(pose)));
        }
        let ended = ended.unwrap();
        assert!(ended.end.x > 4.5, "{:?}", ended.end);
        let near_gable = ended
            .facades
            .iter()
            .filter(|f| f.at.x < 2.6 && f.at.y > 3.0);
        let facing: Vec<f64> = near_gable.map(|f| f.facing.abs()).collect();
        assert!(
            facing.len() > 4 && facing.iter().all(|f| *f > 3.0),
            "{facing:?}"
        );
    }

    #[test]
    fn poses_that_jump_or_are_none_begin_a_new_stretch() {
        let houses = [block(10.0, 9.0, 30.0, 8.0)];
        let mut gatherer = Gatherer::new(Pose3::translation(0.0, 0.0, 0.3));
        let at = |x: f64| Pose2::new(x, 0.0, 0.0);
        let seen = scan(&houses, at(0.0), SimTime::ZERO);
        gatherer.take(&seen, &Still(at(0.0)));
        assert_eq!(gatherer.take(&seen, &Still(at(f64::NAN))), None);
        assert_eq!(gatherer.clone().end().unwrap().end, at(0.0));
        assert_eq!(gatherer.take(&seen, &Still(at(100.0))), None);
        let again = gatherer.end().unwrap();
        assert_eq!((again.end, again.metres), (at(100.0), 0.0));
    }

    #[test]
    fn a_robot_that_turned_for_long_ends_its_stretch_when_it_drives_on() {
        let houses = [block(10.0, 9.0, 30.0, 8.0)];
        let mut gatherer = Gatherer::new(Pose3::translation(0.0, 0.0, 0.3));
        let turning = (0..100).map(|i| Pose2::new(0.0, 0.0, 0.25 * f64::from(i)));
        let driving = (0..30).map(|i| Pose2::new(0.2 * f64::from(i), 0.0, 0.0));
        let ended = turning.chain(driving).filter_map(|pose| {
            let scan = scan(&houses, pose, SimTime::ZERO);
            gatherer.take(&scan, &Still(pose))
        });
        let ended: Vec<Stretch> = ended.collect();
        assert_eq!(ended.len(), 1);
        assert!((5.0..5.5).contains(&ended[0].metres), "{}", ended[0].metres);
    }

    /// A track whose variances of x and y grow by a hundredth of a square metre with each metre.
    struct Drifting(Pose2);

    impl Track for Drifting {
        fn pose3_at(&self, _: SimTime) -> Pose3 {
            Still(self.0).pose3_at(SimTime::ZERO)
        }

        fn pose_covariance(&self) -> Option<Matrix3<f64>> {
            let variance = 0.01 * self.0.x;
            Some(Matrix3::from_diagonal(&Vector3::new(
                variance, variance, 0.0,
            )))
        }
    }

    #[test]
    fn drift_is_counted_once_whatever_ends_a_stretch() {
        let mut gatherer = Gatherer::new(Pose3::translation(0.0, 0.0, 0.3));
        let take = |gatherer: &mut Gatherer, x: f64| {
            let pose = Pose2::new(x, 0.0, 0.0);
            let scan = scan(&[block(10.0, 9.0, 30.0, 8.0)], pose, SimTime::ZERO);
            gatherer.take(&scan, &Drifting(pose));
        };
        take(&mut gatherer, 0.0);
        take(&mut gatherer, 1.0);
        let look = gatherer.end().unwrap();
        assert!((look.drift[0][0] - 0.01).abs() < 1e-12, "{:?}", look.drift);
        assert_eq!(gatherer.end(), None, "its scans count once");
        take(&mut gatherer, 2.0);
        gatherer.restart();
        take(&mut gatherer, 3.0);
        let drift = gatherer.end().unwrap().drift;
        assert!((drift[0][0] - 0.02).abs() < 1e-12, "{drift:?}");
    }

    #[test]
    fn points_that_are_of_no_facade_are_in_the_way_and_no_more() {
        let pose = Pose2::default();
        let seen = scan(&[block(10.0, 0.0, 6.0, 8.0)], pose, SimTime::ZERO);
        let labelled = |probability: f32| {
            let mut gatherer = Gatherer::new(Pose3::translation(0.0, 0.0, 0.3));
            for _ in 0..FIRST_SCANS {
                gatherer.take_labelled(&seen, &|_| probability, &Still(pose));
            }
            gatherer.end().unwrap()
        };
        let (hedge, wall) = (labelled(0.2), labelled(0.9));
        assert!(hedge.facades.is_empty() && wall.facades.len() > 10);
        assert_eq!(hedge.panoramas, wall.panoramas);
    }

    #[test]
    fn a_stretch_in_another_frame_shows_the_same_from_there() {
        let seen = stretch_at(&[block(10.0, 0.0, 6.0, 8.0)], Pose2::default());
        // Forward is now to the left.
        let moved = seen.moved(Pose2::new(1.0, 2.0, TAU / 4.0));
        assert_eq!((moved.end.x, moved.end.y), (1.0, 2.0));
        for (before, after) in seen.facades.iter().zip(&moved.facades) {
            assert!((after.at.y - before.at.x - 2.0).abs() < 1e-9);
            let turn = wrap_angle(after.facing - before.facing);
            assert!((turn - TAU / 4.0).abs() < 1e-9);
        }
        let free = |stretch: &Stretch, bearing| stretch.panoramas[0].free[direction(bearing)];
        assert_eq!(free(&moved, 0.01 + TAU / 4.0), free(&seen, 0.01));
    }

    #[test]
    fn an_empty_scan_is_no_evidence() {
        let mut gatherer = Gatherer::new(Pose3::identity());
        let scan = LidarScan {
            stamp: SimTime::ZERO,
            points: Vec::new(),
        };
        assert_eq!(gatherer.take(&scan, &Still(Pose2::default())), None);
        assert_eq!(gatherer.end(), None);
    }
}
