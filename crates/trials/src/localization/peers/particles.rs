//! Monte Carlo localization with a likelihood field: S. Thrun, W. Burgard and D. Fox,
//! *Probabilistic Robotics*, 2005, tables 6.3 and 8.2, as in ROS's AMCL.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use openbench_core::{MapPoint, Pose2, Start};
use openbench_geometry::grid::{GridGeometry, squared_distances};
use openbench_geometry::{Bounds, Segment};
use openbench_localization::registration::Stretch;
use openbench_osm::OsmMap;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::peer::{Peer, PeerError, bounds, guess, seen_from, walls};

/// Particles: the most of AMCL's defaults.
const PARTICLES: usize = 5000;
/// Points of a stretch that count: the beams of AMCL's defaults.
const POINTS: usize = 60;
/// Standard deviation of a point's distance from its wall, metres: of sensor and map.
const HIT_M: f64 = 1.0;
/// Share of points that are of nothing on the map.
const RANDOM: f64 = 0.1;
/// Odometry errs by this share of the way, and by so many radians a metre.
const NOISE: f64 = 0.05;
const NOISE_RAD: f64 = 0.005;
/// Side of a cell of the field, metres, unless the map is so large that cells must be larger.
const CELL_M: f64 = 0.25;
const MOST_CELLS: usize = 3000;
/// The field reaches beyond the buildings by this, metres.
const BEYOND_M: f64 = 30.0;
/// Poses in boxes of these sides are one hypothesis: metres and radians.
const BOX_M: f64 = 4.0;
const BOX_RAD: f64 = 0.5;

/// A cloud of poses.
pub(super) struct Particles {
    field: Option<Field>,
    poses: Vec<Pose2>,
    start: Pose2,
    last: Option<Pose2>,
    random: Pcg32,
}

impl Particles {
    /// On a map, from a start.
    pub(super) fn new(map: &OsmMap, start: &Start, seed: u64) -> Self {
        let mut random = Pcg32::seed_from_u64(seed);
        let area = bounds(map);
        let poses = (0..PARTICLES).map(|_| draw(start, area, &mut random));
        Self {
            poses: poses.collect(),
            field: area.map(|area| Field::of(&walls(map), area.grown(BEYOND_M))),
            start: guess(map, start),
            last: None,
            random,
        }
    }

    /// Moves all poses by what odometry says, with noise.
    fn predict(&mut self, by: Pose2) {
        let metres = by.point().distance(MapPoint::default());
        let (level, turn) = (NOISE * metres, NOISE_RAD * metres);
        for pose in &mut self.poses {
            let noisy = Pose2::new(
                by.x + level * normal(&mut self.random),
                by.y + level * normal(&mut self.random),
                by.yaw + turn * normal(&mut self.random),
            );
            *pose = pose.compose(noisy);
        }
    }

    /// Draws poses anew by how well they fit the points (low variance sampling, table 4.4).
    fn resample(&mut self, points: &[MapPoint]) {
        let Some(field) = &self.field else { return };
        let fits: Vec<f64> = self
            .poses
            .iter()
            .map(|pose| field.log_likelihood(points, *pose))
            .collect();
        let best = fits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = fits.iter().map(|fit| libm::exp(fit - best)).collect();
        let step = weights.iter().sum::<f64>() / PARTICLES as f64;
        let mut at = step * self.random.random::<f64>();
        let (mut index, mut reached) = (0, weights[0]);
        let drawn = (0..PARTICLES).map(|_| {
            while reached < at && index + 1 < weights.len() {
                index += 1;
                reached += weights[index];
            }
            at += step;
            self.poses[index]
        });
        self.poses = drawn.collect();
    }

    /// Mean of the hypothesis with most poses.
    fn mean(&self) -> Pose2 {
        let key = |pose: &Pose2| {
            let index = |value: f64, side: f64| libm::floor(value / side) as i64;
            (
                index(pose.x, BOX_M),
                index(pose.y, BOX_M),
                index(pose.yaw.rem_euclid(TAU), BOX_RAD),
            )
        };
        let mut counts = BTreeMap::new();
        for pose in &self.poses {
            *counts.entry(key(pose)).or_insert(0_usize) += 1;
        }
        let most = counts.into_iter().max_by_key(|(_, count)| *count);
        let Some((fullest, count)) = most else {
            return self.start;
        };
        let sums = self.poses.iter().filter(|pose| key(pose) == fullest).fold(
            [0.0; 4],
            |[x, y, cosine, sine], pose| {
                let (s, c) = libm::sincos(pose.yaw);
                [x + pose.x, y + pose.y, cosine + c, sine + s]
            },
        );
        let count = count as f64;
        Pose2::new(
            sums[0] / count,
            sums[1] / count,
            libm::atan2(sums[3], sums[2]),
        )
    }
}

impl Peer for Particles {
    fn take(&mut self, stretch: &Stretch) -> Result<Pose2, PeerError> {
        let last = self.last.replace(stretch.end).unwrap_or(stretch.end);
        self.predict(stretch.end.seen_from(last));
        let stride = stretch.facades.len().div_ceil(POINTS).max(1);
        let points: Vec<MapPoint> = stretch
            .facades
            .iter()
            .step_by(stride)
            .map(|facade| seen_from(stretch.end, facade.at))
            .collect();
        self.resample(&points);
        Ok(self.mean())
    }
}

/// Distances to the nearest wall.
struct Field {
    grid: GridGeometry,
    /// Squared, in sides of cells.
    squares: Vec<f32>,
}

impl Field {
    fn of(walls: &[Segment], area: Bounds) -> Self {
        let side = (area.high.x - area.low.x).max(area.high.y - area.low.y);
        let cell = CELL_M.max(side / MOST_CELLS as f64);
        let grid = GridGeometry::covering(area.low, area.high, cell, MOST_CELLS);
        let mut marked = vec![false; grid.len()];
        // Only what is near: a side may be hundreds of kilometres long.
        for wall in walls.iter().filter_map(|wall| {
            let inside = area.clip(*wall)?;
            Some(wall.part(inside.start, inside.end))
        }) {
            let steps = (wall.length() / (0.5 * cell)).ceil().max(1.0) as usize;
            for i in 0..=steps {
                let share = i as f64 / steps as f64;
                let at = MapPoint::new(
                    wall.start.x + share * (wall.end.x - wall.start.x),
                    wall.start.y + share * (wall.end.y - wall.start.y),
                );
                if let Some(cell) = grid.cell_at(at) {
                    marked[cell] = true;
                }
            }
        }
        Self {
            squares: squared_distances(&marked, grid.width, grid.height),
            grid,
        }
    }

    fn log_likelihood(&self, points: &[MapPoint], pose: Pose2) -> f64 {
        let one = |point: &MapPoint| {
            let at = pose.transform(point.x, point.y);
            let square = self.grid.cell_at(at).map_or(f64::INFINITY, |cell| {
                f64::from(self.squares[cell]) * self.grid.cell * self.grid.cell
            });
            let hit = libm::exp(-square / (2.0 * HIT_M * HIT_M));
            libm::log((1.0 - RANDOM) * hit + RANDOM)
        };
        points.iter().map(one).sum()
    }
}

/// A pose that the start allows.
fn draw(start: &Start, area: Option<Bounds>, random: &mut Pcg32) -> Pose2 {
    let yaw = TAU * random.random::<f64>();
    match start {
        Start::Pose { pose, covariance } => {
            // Errors of a start are independent along x, y and yaw.
            let deviation = |i: usize| covariance[i][i].max(0.0).sqrt();
            Pose2::new(
                pose.x + deviation(0) * normal(random),
                pose.y + deviation(1) * normal(random),
                pose.yaw + deviation(2) * normal(random),
            )
        }
        Start::Area { centre, radius_m } => {
            let away = radius_m * random.random::<f64>().sqrt();
            let at = centre.offset(TAU * random.random::<f64>(), away);
            Pose2::new(at.x, at.y, yaw)
        }
        Start::Anywhere => {
            let area = area.unwrap_or(Bounds::of_point(MapPoint::default()));
            let share = |low: f64, high: f64, share: f64| low + share * (high - low);
            Pose2::new(
                share(area.low.x, area.high.x, random.random()),
                share(area.low.y, area.high.y, random.random()),
                yaw,
            )
        }
    }
}

/// A number from the standard normal distribution (Box and Muller).
fn normal(random: &mut Pcg32) -> f64 {
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - random.random::<f64>()));
    radius * libm::cos(TAU * random.random::<f64>())
}
