//! Maneuvers: a search over places *and* headings with the whole footprint, for where a path of the
//! robot's middle says too little: out of corridors that are too narrow to turn in, or off a wall
//! that is touched.
//!
//! The robot drives straight forward or back, on arcs, and turns on the spot; each is one step of
//! the search (after D. Dolgov et al., *Practical Search Techniques in Path Planning for Autonomous
//! Driving*, 2008: continuous places are kept, one for each cell and heading). The heuristic is the
//! time from each cell to the goal without headings.

use std::f64::consts::TAU;

use openbench_core::{MapPoint, Pose2, frames::wrap_angle};
use openbench_geometry::grid::{Frontier, GridGeometry, NEIGHBOURS};

use crate::limits::Limits;
use crate::near_cells::each_cell_near;
use crate::shape::{Footprint, Obstacle, standing};
use crate::trajectory::{TimedPose, Trajectory};

/// Headings that are distinguished.
const HEADINGS: usize = 48;
/// Length of a step, metres.
const STEP_M: f64 = 0.05;
/// Side of a cell, metres.
const CELL_M: f64 = 0.025;
/// Ground beyond start and goal that may be used, metres.
const AROUND_M: f64 = 2.0;
/// Most cells along one side.
const MOST_CELLS: usize = 400;
/// Most places that are searched.
const MOST_PLACES: usize = 400_000;
/// Distance from the goal at which it is reached, metres.
const NEAR_M: f64 = 0.04;
/// Distance to obstacles that is kept, metres, unless the start is nearer.
const KEEP_M: f64 = 0.004;
/// Driving backward counts this many times its duration: it is avoided where driving forward takes
/// little longer.
const BACKWARD: f64 = 1.5;
/// Weight of the heuristic: with more than 1 the path may be longer than need be, and is found far
/// sooner. The band that begins with it is shortened later.
const GREED: f64 = 1.5;
/// No place.
const NOWHERE: u32 = u32::MAX;

/// Why there is no maneuver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoManeuver {
    /// The footprint does not fit at the goal.
    #[error("the footprint does not fit at the goal")]
    GoalBlocked,
    /// No reachable place is left to search.
    #[error("no path leads there for the footprint")]
    NoPath,
    /// The goal is too far, or too many places were searched.
    #[error("the goal is too far for a maneuver, or none was found among {MOST_PLACES} places")]
    TooFar,
}

/// A pose that was reached.
#[derive(Debug, Clone, Copy)]
struct Place {
    at: MapPoint,
    /// In steps of a full turn by [`HEADINGS`], from the start's heading.
    heading: usize,
    /// Cost until here, seconds.
    seconds: f64,
    /// Number of the place before.
    from: u32,
}

/// A search for one maneuver.
struct Search<'a> {
    footprint: &'a Footprint,
    obstacles: Vec<&'a Obstacle>,
    limits: &'a Limits,
    grid: GridGeometry,
    start: Pose2,
    /// Distance from each cell's middle to the nearest obstacle, as far as it matters, metres.
    clearance: Vec<f32>,
    /// Least time from each cell to the goal, seconds; infinite where the goal cannot be reached.
    left: Vec<f32>,
    places: Vec<Place>,
    /// Distance that the footprint keeps from obstacles, metres.
    keep: f64,
}

/// A band from `start` to `goal` around standing obstacles, with a heading there (radians) or any.
/// Moving obstacles are left out.
pub fn maneuver(
    footprint: &Footprint,
    limits: &Limits,
    obstacles: &[Obstacle],
    start: Pose2,
    goal: MapPoint,
    yaw: Option<f64>,
) -> Result<Trajectory, NoManeuver> {
    let low = MapPoint::new(
        start.x.min(goal.x) - AROUND_M,
        start.y.min(goal.y) - AROUND_M,
    );
    let high = MapPoint::new(
        start.x.max(goal.x) + AROUND_M,
        start.y.max(goal.y) + AROUND_M,
    );
    let side = (high.x - low.x).max(high.y - low.y);
    let grid = GridGeometry::covering(
        low,
        high,
        CELL_M.max(side / MOST_CELLS as f64),
        MOST_CELLS + 1,
    );
    // A step must lead out of its cell.
    if grid.cell > STEP_M * std::f64::consts::FRAC_1_SQRT_2 {
        return Err(NoManeuver::TooFar);
    }
    let mut search = Search {
        footprint,
        obstacles: standing(obstacles).collect(),
        limits,
        grid,
        start,
        clearance: Vec::new(),
        left: Vec::new(),
        places: Vec::new(),
        keep: KEEP_M,
    };
    search.measure();
    let here = search.exact(start);
    // Otherwise a start that is nearer would be blocked itself. Inside an obstacle it may not get
    // deeper, up to rounding.
    search.keep = KEEP_M.min(if here > 0.0 { 0.7 * here } else { here - 1e-4 });
    search.look_back(goal)?;
    let end = search.forward(goal, yaw)?;
    search.band(end, goal, yaw).ok_or(NoManeuver::NoPath)
}

impl Search<'_> {
    /// Fills [`Search::clearance`].
    fn measure(&mut self) {
        let reach = self.footprint.circumscribed() + 2.0 * self.grid.cell;
        self.clearance.resize(self.grid.len(), reach as f32);
        for obstacle in &self.obstacles {
            each_cell_near(&self.grid, obstacle, reach, |cell, distance| {
                self.clearance[cell] = self.clearance[cell].min(distance as f32);
            });
        }
    }

    /// Distance from the footprint to the nearest obstacle, metres, 0.1 at most.
    fn exact(&self, pose: Pose2) -> f64 {
        let (placed, circle) = (self.footprint.at(pose), self.footprint.circumscribed());
        let near = self
            .obstacles
            .iter()
            .filter_map(|o| o.contact(&placed, circle, 0.0, 0.1));
        near.map(|contact| contact.distance).fold(0.1, f64::min)
    }

    /// Whether the footprint keeps off all obstacles at a pose.
    fn is_free(&self, pose: Pose2) -> bool {
        let Some(cell) = self.grid.cell_at(pose.point()) else {
            return false;
        };
        // No place in a cell is further than 0.71 sides from its middle. By the circles most poses
        // are surely free or surely not; only those between need the exact distance.
        let (clear, off) = (f64::from(self.clearance[cell]), 0.71 * self.grid.cell);
        if clear > self.footprint.circumscribed() + off + self.keep {
            return true;
        }
        clear > self.footprint.inscribed() - off + self.keep && self.exact(pose) > self.keep
    }

    /// Fills [`Search::left`] by Dijkstra's algorithm over cells: at most 8 % more than along
    /// straight lines.
    fn look_back(&mut self, goal: MapPoint) -> Result<(), NoManeuver> {
        let to = self.grid.cell_at(goal).ok_or(NoManeuver::GoalBlocked)?;
        // Open if the robot may fit anywhere in the cell, at any heading: the estimate of the time
        // left must not miss a gap.
        let fits = self.footprint.inscribed() - 0.71 * self.grid.cell + self.keep;
        let free = |cell: usize| f64::from(self.clearance[cell]) > fits;
        if !free(to) {
            return Err(NoManeuver::GoalBlocked);
        }
        self.left.resize(self.grid.len(), f32::INFINITY);
        let mut queue = Frontier::default();
        self.left[to] = 0.0;
        queue.push(0.0, to);
        let second = self.grid.cell / self.limits.forward;
        while let Some((seconds, cell)) = queue.pop() {
            // An outdated entry: the cell was reached sooner since.
            if seconds > f64::from(self.left[cell]) + 1e-6 {
                continue;
            }
            let (x, y) = self.grid.column_row(cell);
            for (dx, dy) in NEIGHBOURS {
                // Corners may be cut here. The search forward checks the footprint itself.
                let Some(next) = self.grid.cell_in(x + dx, y + dy).filter(|&n| free(n)) else {
                    continue;
                };
                let length = if dx != 0 && dy != 0 {
                    std::f64::consts::SQRT_2
                } else {
                    1.0
                };
                let total = seconds + length * second;
                if total < f64::from(self.left[next]) - 1e-6 {
                    self.left[next] = total as f32;
                    // As it is stored: rounding would make the entry look outdated.
                    queue.push(f64::from(total as f32), next);
                }
            }
        }
        Ok(())
    }

    /// Radians of a numbered heading.
    fn heading(&self, heading: usize) -> f64 {
        self.start.yaw + TAU * heading as f64 / HEADINGS as f64
    }

    /// Searches forward from the start; the number of the place at the goal.
    fn forward(&mut self, goal: MapPoint, yaw: Option<f64>) -> Result<u32, NoManeuver> {
        let wanted = yaw.map(|yaw| self.number_of(yaw));
        let fits = |yaw: f64| self.is_free(Pose2::new(goal.x, goal.y, yaw));
        // Without a wanted heading only the search can tell whether one fits.
        if !yaw.is_none_or(fits) {
            return Err(NoManeuver::GoalBlocked);
        }
        // Each cell and heading is expanded once, from the first place that comes out of the queue
        // there.
        let mut closed = vec![false; self.grid.len() * HEADINGS];
        let mut queue = Frontier::default();
        let at = self.start.point();
        self.places.push(Place {
            at,
            heading: 0,
            seconds: 0.0,
            from: NOWHERE,
        });
        queue.push(0.0, 0);
        while let Some((_, number)) = queue.pop() {
            let place = self.places[number];
            let Some(cell) = self.grid.cell_at(place.at) else {
                continue;
            };
            if std::mem::replace(&mut closed[cell * HEADINGS + place.heading], true) {
                continue;
            }
            let is_there = place.at.distance(goal) < NEAR_M;
            if is_there && wanted.is_none_or(|wanted| wanted == place.heading) {
                return Ok(number as u32);
            }
            if self.places.len() > MOST_PLACES {
                return Err(NoManeuver::TooFar);
            }
            for step in STEPS {
                self.open(number, step, wanted, &closed, &mut queue);
            }
        }
        Err(NoManeuver::NoPath)
    }

    /// Opens the place to which a step leads, if the robot can drive there.
    fn open(
        &mut self,
        number: usize,
        step: Step,
        wanted: Option<usize>,
        closed: &[bool],
        queue: &mut Frontier,
    ) {
        if step.length < 0.0 && self.limits.backward <= 0.0 {
            return;
        }
        let place = self.places[number];
        // A whole turn more keeps the sum from falling below zero.
        let heading = (place.heading + HEADINGS).wrapping_add_signed(step.turn) % HEADINGS;
        // The chord of an arc points along the mean heading.
        let mean = self.heading(place.heading) + step.turn as f64 * TAU / HEADINGS as f64 / 2.0;
        let at = place.at.offset(mean, step.length * STEP_M);
        let Some(next) = self.grid.cell_at(at) else {
            return;
        };
        let left = f64::from(self.left[next]);
        if closed[next * HEADINGS + heading] || left.is_infinite() {
            return;
        }
        // Corners move further than the middle in a turn, so the pose halfway is checked too.
        let half = place.at.offset(mean, step.length * STEP_M / 2.0);
        let between = Pose2::new(half.x, half.y, mean);
        let end = Pose2::new(at.x, at.y, self.heading(heading));
        if !self.is_free(end) || !self.is_free(between) {
            return;
        }
        let seconds = place.seconds + self.seconds(step);
        let turning = wanted.map_or(0.0, |wanted| self.turning(heading, wanted));
        self.places.push(Place {
            at,
            heading,
            seconds,
            from: number as u32,
        });
        queue.push(seconds + GREED * (left + turning), self.places.len() - 1);
    }

    /// The number of the heading nearest to a yaw.
    fn number_of(&self, yaw: f64) -> usize {
        let turns = wrap_angle(yaw - self.start.yaw).rem_euclid(TAU) / TAU * HEADINGS as f64;
        turns.round() as usize % HEADINGS
    }

    /// Duration of a step, seconds.
    fn seconds(&self, Step { length, turn }: Step) -> f64 {
        let speed = if length < 0.0 {
            self.limits.backward / BACKWARD
        } else {
            self.limits.forward
        };
        let turning = turn.unsigned_abs() as f64 * TAU / HEADINGS as f64 / self.limits.turn;
        (length.abs() * STEP_M / speed).max(turning)
    }

    /// Seconds of a turn between two headings.
    fn turning(&self, from: usize, to: usize) -> f64 {
        let apart = (from + HEADINGS - to) % HEADINGS;
        apart.min(HEADINGS - apart) as f64 * TAU / HEADINGS as f64 / self.limits.turn
    }

    /// The band through the places that lead to `end`, and on to the goal.
    fn band(&self, end: u32, goal: MapPoint, yaw: Option<f64>) -> Option<Trajectory> {
        let mut chain = Vec::new();
        let mut at = end;
        while at != NOWHERE {
            chain.push(self.places[at as usize]);
            at = self.places[at as usize].from;
        }
        chain.reverse();
        let mut poses: Vec<TimedPose> = Vec::with_capacity(chain.len() + 1);
        for place in chain {
            let before = poses.last().map_or(self.start.yaw, |k| k.pose.yaw);
            // Yaws of a trajectory run on beyond a half turn, while headings are counted within one
            // turn.
            let heading = before + wrap_angle(self.heading(place.heading) - before);
            poses.push(TimedPose {
                pose: Pose2::new(place.at.x, place.at.y, heading),
                time: place.seconds,
            });
        }
        let last = poses[poses.len() - 1];
        let yaw = last.pose.yaw + yaw.map_or(0.0, |yaw| wrap_angle(yaw - last.pose.yaw));
        let pose = Pose2::new(goal.x, goal.y, yaw);
        poses.push(TimedPose {
            pose,
            time: last.time + 0.2,
        });
        Trajectory::new(poses)
    }
}

/// A step of the search.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// In [`STEP_M`]s; negative backward.
    length: f64,
    /// In headings; positive to the left.
    turn: isize,
}

/// The steps: forward, backward, straight and to both sides, and turns on the spot.
const STEPS: [Step; 8] = [
    Step {
        length: 1.0,
        turn: 0,
    },
    Step {
        length: 1.0,
        turn: 1,
    },
    Step {
        length: 1.0,
        turn: -1,
    },
    Step {
        length: -1.0,
        turn: 0,
    },
    Step {
        length: -1.0,
        turn: 1,
    },
    Step {
        length: -1.0,
        turn: -1,
    },
    Step {
        length: 0.0,
        turn: 1,
    },
    Step {
        length: 0.0,
        turn: -1,
    },
];
