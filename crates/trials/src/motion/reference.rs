//! The reference motion of a scene: the fastest motion that a long search finds, or a proof that
//! there is none.
//!
//! A motion is checked for collisions every 10 ms and respects the robot's limits. Its duration is
//! the reference for planners, unless a motion improved from their own drives is faster
//! ([`improved_duration`]).
//!
//! Infeasibility is proven for the inscribed circle of the footprint: if even the circle has no
//! path on a fine grid, the footprint has none. Obstacles are shrunk by half a cell's diagonal, so
//! that the grid excludes no possible path. Scenes for which neither is found are not used.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, Velocity};
use openbench_geometry::grid::{GridGeometry, NEIGHBOURS};
use openbench_motion::Limits;
use openbench_motion::feasible::clearance;
use openbench_motion::recovery::maneuver;
use openbench_motion::teb::Problem;
use openbench_motion::teb::{Effort, Optimizer};
use openbench_motion::teb::{Explorer, Exploring};
use openbench_motion::teb::{Margins, Settings, Weights};
use openbench_motion::trajectory::Resolution;
use openbench_motion::trajectory::{TimedPose, Trajectory};
use openbench_motion::{Footprint, Obstacle, Vector2};

use super::drive::{CYCLE_S, is_there};
use super::retime::retimed;
use super::scene::Scene;

/// Cell size of the grid in the proof of infeasibility.
const PROOF_CELL_M: f64 = 0.005;
/// Margin of that grid around start and goal.
const PROOF_MARGIN_M: f64 = 4.0;
/// Distances from obstacles to try. A smaller distance is faster, but the distance between two
/// knots may be smaller than at the knots.
const CLEARANCES_M: [f64; 3] = [0.005, 0.015, 0.03];
/// Initial waits of a draft, so that moving obstacles pass.
const DRAFT_WAITS_S: [f64; 5] = [0.0, 1.0, 2.0, 4.0, 7.0];
/// Step of the waits before a motion at the shortest times.
const WAIT_STEP_S: f64 = 0.25;
/// Maximum number of these waits.
const MAX_WAITS: u32 = 40;
/// Maximum lateral share of the motion of the wheel rims, which allows for rounding.
const MAX_LATERAL_SHARE: f64 = 0.01;
/// Scale of the times of a trajectory from which on it is not tried. It would hardly be the
/// fastest.
const MAX_SLOWDOWN: f64 = 1.2;
/// Time between two poses that are checked for collisions.
const CHECK_STEP_S: f64 = 0.01;
/// Lateral offsets at which moving obstacles are passed.
const OFFSETS_M: [f64; 5] = [0.0, 0.5, -0.5, 1.0, -1.0];

/// The result of the search.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// The fastest motion found.
    Motion(ReferenceMotion),
    /// It is proven that there is no motion.
    Infeasible,
    /// No motion was found, and no proof.
    Unknown,
}

/// A motion through a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceMotion {
    /// The motion, from rest to rest.
    pub trajectory: Trajectory,
    /// Time from which it stays within the tolerance of the goal, seconds.
    pub arrival_s: f64,
}

/// Searches for the fastest motion through a scene; `None` for a robot without a valid footprint or
/// limits. A jump of the pose estimate is regarded as known from the start.
pub fn reference_motion(scene: &Scene, robot: &RobotDescription) -> Option<Reference> {
    let (footprint, limits) = (Footprint::of(robot).ok()?, Limits::of(robot).ok()?);
    // Every draft is improved and timed, and the earliest arrival is kept. Only if none is left,
    // a proof is tried: a motion makes it needless.
    let search = Search {
        scene,
        footprint: &footprint,
        limits: &limits,
        goal: true_goal(scene),
    };
    let fastest = search
        .drafts()
        .into_iter()
        .filter_map(|draft| search.settle(&draft))
        .map(|trajectory| ReferenceMotion {
            arrival_s: arrival(&trajectory, search.goal),
            trajectory,
        })
        .min_by(|a, b| a.arrival_s.total_cmp(&b.arrival_s));
    Some(match fastest {
        Some(motion) => Reference::Motion(motion),
        None if search.proves_nothing() => Reference::Infeasible,
        None => Reference::Unknown,
    })
}

/// The time, in seconds, in which an improved version of a drive reaches the goal; `None` if it
/// cannot be improved to a valid motion. `track` are the poses of the drive, `seconds` the time
/// between two.
pub fn improved_duration(
    scene: &Scene,
    robot: &RobotDescription,
    track: &[Pose2],
    seconds: f64,
) -> Option<f64> {
    let (footprint, limits) = (Footprint::of(robot).ok()?, Limits::of(robot).ok()?);
    let search = Search {
        scene,
        footprint: &footprint,
        limits: &limits,
        goal: true_goal(scene),
    };
    let mut knots: Vec<TimedPose> = Vec::with_capacity(track.len());
    // Trajectories take the difference of two yaws as the turn, so the yaw must not wrap.
    for (i, &pose) in track.iter().enumerate() {
        let yaw = knots
            .last()
            .map_or(pose.yaw, |k| k.pose.yaw + wrap_angle(pose.yaw - k.pose.yaw));
        knots.push(TimedPose {
            pose: Pose2 { yaw, ..pose },
            time: i as f64 * seconds,
        });
    }
    search
        .settle(&Trajectory::new(knots)?)
        .map(|trajectory| arrival(&trajectory, search.goal))
}

/// The true pose at which the estimate, after its jump, is the goal.
fn true_goal(scene: &Scene) -> Pose2 {
    let by = scene.jump.map_or(Vector2::ZERO, |j| j.by);
    Pose2::new(scene.goal.x - by.x, scene.goal.y - by.y, scene.goal.yaw)
}

struct Search<'a> {
    scene: &'a Scene,
    footprint: &'a Footprint,
    limits: &'a Limits,
    goal: Pose2,
}

impl Search<'_> {
    fn settings(&self) -> Settings {
        Settings {
            resolution: Resolution {
                near: 0.1,
                far: 0.2,
                horizon: 2.0,
                most: 400,
            },
            // Only time counts: comfort, smoothness and preferences have no weight. Limits and
            // obstacles have ten times their default or more, since a motion that violates them is
            // rejected.
            weights: Weights {
                length: 0.0,
                speed: 4000.0,
                turn: 1000.0,
                acceleration: 300.0,
                steady: 0.0,
                backward: 0.0,
                obstacle: 20_000.0,
                comfort: 0.0,
                ..Weights::default()
            },
            ..Settings::default()
        }
    }

    /// Initial trajectories: all homotopy classes, both directions of the first and last turn,
    /// maneuvers, and with waits and lateral offsets if an obstacle moves.
    fn drafts(&self) -> Vec<Trajectory> {
        let (start, obstacles) = (self.scene.start, &self.scene.obstacles);
        let static_obstacles: Vec<Obstacle> = obstacles
            .iter()
            .filter(|o| !o.is_moving())
            .cloned()
            .collect();
        let moving = static_obstacles.len() < obstacles.len();
        // The smallest radius that could fit: where the footprint does not, `is_clear` rejects the
        // motion.
        let how = Exploring {
            cell: 0.05,
            around: 2.5,
            keep: self.footprint.inscribed(),
            comfort: self.footprint.inscribed() + 0.1,
            most: 8,
            longest: 2.0,
        };
        let mut explorer = Explorer::default();
        let paths = explorer.explore(start.point(), self.goal.point(), &static_obstacles, &how);
        let mut drafts = Vec::new();
        for path in &paths {
            let behind = path
                .corners
                .get(1)
                .is_some_and(|c| start.inverse_transform(*c).0 < 0.0);
            // Only if the path leads backwards, turning either way takes about the same time.
            for side in [-1.0, 1.0].into_iter().take(1 + usize::from(behind)) {
                let along = |corners: &[MapPoint]| {
                    Trajectory::along(start, corners, Some(self.goal.yaw), self.limits, side)
                };
                let plain = along(&path.corners[1..]);
                drafts.extend(plain.as_ref().and_then(with_opposite_last_turn));
                drafts.extend(plain);
                // Classes exist around static obstacles only. Moving ones are passed before, behind
                // or after a wait, which offsets and delays propose.
                if moving {
                    let shifted = OFFSETS_M
                        .iter()
                        .filter_map(|offset| along(&offset_path(&path.corners, *offset)));
                    drafts.extend(shifted.flat_map(|trajectory| {
                        DRAFT_WAITS_S
                            // `delayed` has no result for a wait of 0, which is the trajectory
                            // itself.
                            .map(|wait| trajectory.delayed(wait).unwrap_or(trajectory.clone()))
                    }));
                }
            }
        }
        // A robot that touches an obstacle may have to back away before it can turn.
        let backed = |length: f64| self.backed(&paths.first()?.corners, length);
        drafts.extend([0.2, 0.5, 1.0].into_iter().filter_map(backed));
        let yaw = Some(self.goal.yaw);
        drafts.extend(maneuver(
            self.footprint,
            self.limits,
            &static_obstacles,
            start,
            self.goal.point(),
            yaw,
        ));
        drafts
    }

    /// Backwards for `length` metres, then along the path.
    fn backed(&self, corners: &[MapPoint], length: f64) -> Option<Trajectory> {
        let start = self.scene.start;
        let back = start.transform(-length, 0.0);
        let from = Pose2::new(back.x, back.y, start.yaw);
        let seconds = length / self.limits.backward;
        let rest = Trajectory::along(from, &corners[1..], Some(self.goal.yaw), self.limits, 1.0)?;
        // The rest begins when the robot has backed off.
        let later = rest.poses().iter().map(|k| TimedPose {
            time: k.time + seconds,
            ..*k
        });
        Trajectory::new(
            std::iter::once(TimedPose {
                pose: start,
                time: 0.0,
            })
            .chain(later)
            .collect(),
        )
    }

    /// The fastest motion from a draft: the draft itself, or optimized with one of the clearances.
    fn settle(&self, draft: &Trajectory) -> Option<Trajectory> {
        let improved = CLEARANCES_M
            .iter()
            .map(|least| self.improved(draft, *least));
        let settled = improved
            .chain([draft.clone()])
            .filter_map(|trajectory| self.timed(&trajectory));
        self.earliest(settled)
    }

    /// The motion that first reaches the tolerance of the goal.
    fn earliest(&self, trajectories: impl Iterator<Item = Trajectory>) -> Option<Trajectory> {
        trajectories.min_by(|a, b| arrival(a, self.goal).total_cmp(&arrival(b, self.goal)))
    }

    /// The fastest collision-free timing of a trajectory's path: its own times, slowed to the
    /// robot's limits, or the shortest times, after a wait at the start if an obstacle moves.
    fn timed(&self, trajectory: &Trajectory) -> Option<Trajectory> {
        // The shortest times first, then the same after longer and longer waits: the first that is
        // clear is the earliest of these.
        let shortest = retimed(trajectory, self.limits);
        let moving = self.scene.obstacles.iter().any(Obstacle::is_moving);
        let waits = (1..=MAX_WAITS)
            .take_while(|_| moving)
            .map(|i| f64::from(i) * WAIT_STEP_S);
        let delayed = waits.filter_map(|wait| shortest.as_ref()?.delayed(wait));
        let mut trajectories = shortest.iter().cloned().chain(delayed);
        let at_once = trajectories.find_map(|trajectory| {
            // Retiming tolerates a small excess over the limits, which this removes.
            self.slowed(&trajectory)
                .filter(|trajectory| self.is_clear(trajectory))
        });
        // Where an obstacle moves, the shortest times may collide and the draft's own may not.
        let as_it_is = self
            .slowed(trajectory)
            .filter(|trajectory| self.is_clear(trajectory));
        self.earliest(at_once.into_iter().chain(as_it_is))
    }

    fn improved(&self, draft: &Trajectory, least: f64) -> Trajectory {
        let mut settings = self.settings();
        settings.margins = Margins {
            least,
            moving: least,
            comfort: least + 0.01,
        };
        let problem = Problem {
            footprint: self.footprint,
            obstacles: &self.scene.obstacles,
            limits: self.limits,
            settings: &settings,
            start: Velocity::ZERO,
            stops: true,
            end_yaw: true,
            side: 0.0,
        };
        let mut trajectory = draft.clone();
        Optimizer::default().improve(&mut trajectory, &problem, &[], &Effort::PATIENT);
        trajectory
    }

    /// The trajectory with all times scaled so that no limit is exceeded; `None` if they would need
    /// a scale of [`MAX_SLOWDOWN`] or more.
    fn slowed(&self, trajectory: &Trajectory) -> Option<Trajectory> {
        let knots = trajectory.poses();
        // Times scaled by r divide speeds by r and accelerations by r².
        let mut ratio = 1.0_f64;
        let mut before: Option<(Velocity, f64)> = None;
        for i in 0..knots.len() - 1 {
            let (v, seconds) = (trajectory.velocity(i), knots[i + 1].time - knots[i].time);
            ratio = ratio
                .max(v.linear / self.limits.forward)
                .max(-v.linear / self.limits.backward);
            ratio = ratio.max(v.angular.abs() / self.limits.turn);
            // A segment has its velocity in the middle. From rest, the first middle is half a
            // segment away.
            let (from, between) = before.map_or((Velocity::ZERO, seconds / 2.0), |(u, s)| {
                (u, (s + seconds) / 2.0)
            });
            ratio = ratio.max((self.rims(from, v) / between / self.limits.acceleration).sqrt());
            before = Some((v, seconds));
        }
        // To rest at the end, again over half a segment.
        if let Some((v, seconds)) = before {
            let braking = self.rims(v, Velocity::ZERO) / (seconds / 2.0);
            ratio = ratio.max((braking / self.limits.acceleration).sqrt());
        }
        // Segments of almost no duration at the ends would otherwise slow the whole trajectory.
        Trajectory::new(
            knots
                .iter()
                .map(|k| TimedPose {
                    time: k.time * ratio,
                    ..*k
                })
                .collect(),
        )
        .filter(|_| ratio < MAX_SLOWDOWN)
    }

    /// The larger change of speed of the two wheel rims between two velocities, m/s.
    fn rims(&self, a: Velocity, b: Velocity) -> f64 {
        let (v, w) = (
            b.linear - a.linear,
            self.limits.half_track * (b.angular - a.angular),
        );
        (v + w).abs().max((v - w).abs())
    }

    /// Whether the footprint collides nowhere, or no deeper than at the start, and the trajectory
    /// respects the non-holonomic constraint.
    fn is_clear(&self, trajectory: &Trajectory) -> bool {
        let (obstacles, footprint) = (&self.scene.obstacles, self.footprint);
        let mut floor = f64::NEG_INFINITY;
        let steps = (trajectory.duration() / CHECK_STEP_S).ceil() as usize;
        (0..=steps).all(|i| {
            let time = (i as f64 * CHECK_STEP_S).min(trajectory.duration());
            // Only negative clearances matter, so a reach of 10 cm is enough.
            let clear = clearance(
                footprint,
                obstacles.iter(),
                trajectory.pose_at(time),
                time,
                0.1,
            );
            // A robot may start in contact, within rounding.
            if i == 0 {
                floor = clear.min(0.0);
            }
            clear >= floor
        }) && self.is_drivable(trajectory)
    }

    /// Whether the lateral motion is below the maximum share, as the non-holonomic constraint
    /// demands.
    fn is_drivable(&self, trajectory: &Trajectory) -> bool {
        // The chord of an arc has the mean of the headings at its ends. What is left across it is
        // lateral motion.
        let slips = trajectory.poses().windows(2).map(|w| {
            let turn = self.limits.half_track * (w[1].pose.yaw - w[0].pose.yaw);
            let (sin, cos) = libm::sincos((w[0].pose.yaw + w[1].pose.yaw) / 2.0);
            let (dx, dy) = (w[1].pose.x - w[0].pose.x, w[1].pose.y - w[0].pose.y);
            let (along, aside) = (dx * cos + dy * sin, dy * cos - dx * sin);
            aside.abs() - MAX_LATERAL_SHARE * (along.abs() + turn.abs())
        });
        // Over the whole path: in a single short segment rounding may be a large share.
        slips.sum::<f64>() < 0.0
    }

    /// Whether even the inscribed circle of the footprint cannot reach the goal.
    fn proves_nothing(&self) -> bool {
        let (start, goal) = (self.scene.start.point(), self.goal.point());
        let low = MapPoint::new(
            start.x.min(goal.x) - PROOF_MARGIN_M,
            start.y.min(goal.y) - PROOF_MARGIN_M,
        );
        let high = MapPoint::new(
            start.x.max(goal.x) + PROOF_MARGIN_M,
            start.y.max(goal.y) + PROOF_MARGIN_M,
        );
        // At most 20 m a side. A goal beyond has no cell, and nothing is proven.
        let grid = GridGeometry::covering(low, high, PROOF_CELL_M, 4000);
        // A cell that the circle's centre crosses has its own centre within half a diagonal of the
        // path. It is therefore farther from obstacles than this, and stays free.
        let least = self.footprint.inscribed() - std::f64::consts::FRAC_1_SQRT_2 * PROOF_CELL_M;
        let mut blocked = vec![false; grid.len()];
        // A moving obstacle may make way, so it proves nothing.
        for obstacle in self.scene.obstacles.iter().filter(|o| !o.is_moving()) {
            let (middle, reach) = (obstacle.middle(), obstacle.radius() + least);
            let low = MapPoint::new(middle.x - reach, middle.y - reach);
            let high = MapPoint::new(middle.x + reach, middle.y + reach);
            let Some((columns, rows)) = grid.window(low, high) else {
                continue;
            };
            for row in rows.0..=rows.1 {
                for cell in (columns.0..=columns.1).filter_map(|column| grid.cell_in(column, row)) {
                    blocked[cell] =
                        blocked[cell] || obstacle.distance_to(grid.center(cell)) < least;
                }
            }
        }
        let (Some(from), Some(to)) = (grid.cell_at(start), grid.cell_at(goal)) else {
            return false;
        };
        !connected(&grid, blocked, from, to)
    }
}

/// Whether free cells connect two cells, directly or outside the grid: a path that leaves the grid
/// may come back.
fn connected(grid: &GridGeometry, mut blocked: Vec<bool>, from: usize, to: usize) -> bool {
    if blocked[to] {
        return false;
    }
    // A copy, since the first fill marks the cells that it reaches.
    let mut blocked_from_goal = blocked.clone();
    match flood(grid, &mut blocked, from, Some(to)) {
        Flood::Target => true,
        Flood::Enclosed => false,
        // From outside, the goal is reached if its own region extends to the border, too.
        Flood::Border => flood(grid, &mut blocked_from_goal, to, None) == Flood::Border,
    }
}

/// The end of a flood fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flood {
    /// It reached the target.
    Target,
    /// It reached the border of the grid, but not the target.
    Border,
    /// It reached neither.
    Enclosed,
}

/// Fills the free cells around `from`, with eight neighbours each, until it reaches `target`. Cells
/// that were reached are marked as blocked.
fn flood(grid: &GridGeometry, blocked: &mut [bool], from: usize, target: Option<usize>) -> Flood {
    // The first cell counts as free: the robot is there, even if it touches an obstacle.
    let mut open = vec![from];
    let mut border = false;
    while let Some(cell) = open.pop() {
        if Some(cell) == target {
            return Flood::Target;
        }
        let (x, y) = grid.column_row(cell);
        for (dx, dy) in NEIGHBOURS {
            match grid.cell_in(x + dx, y + dy) {
                Some(next) if !blocked[next] => {
                    blocked[next] = true;
                    open.push(next);
                }
                Some(_) => {}
                None => border = true,
            }
        }
    }
    if border {
        Flood::Border
    } else {
        Flood::Enclosed
    }
}

/// The trajectory with its last turn in the opposite direction; `None` if that turn is a radian or
/// less.
fn with_opposite_last_turn(trajectory: &Trajectory) -> Option<Trajectory> {
    let mut knots = trajectory.poses().to_vec();
    let before = knots[knots.len().checked_sub(2)?].pose.yaw;
    let last = knots.last_mut()?;
    let turn = last.pose.yaw - before;
    // A turn of t becomes one of t - 2π to the other side.
    last.pose.yaw -= std::f64::consts::TAU.copysign(turn);
    // An initial time at 1 rad/s; the optimizer improves it.
    last.time += std::f64::consts::TAU - 2.0 * turn.abs();
    (turn.abs() > 1.0).then(|| Trajectory::new(knots)).flatten()
}

/// The time, in seconds, from which a trajectory stays within the tolerance of its goal.
fn arrival(trajectory: &Trajectory, goal: Pose2) -> f64 {
    let steps = (trajectory.duration() / CYCLE_S) as usize;
    // From the end: a trajectory may pass through the tolerance and leave it again. It is sampled
    // at the planners' cycle, at which their arrival is noticed.
    let away = (0..=steps)
        .rev()
        .find(|&i| !is_there(trajectory.pose_at(i as f64 * CYCLE_S), goal));
    away.map_or(0.0, |i| (i + 1) as f64 * CYCLE_S)
        .min(trajectory.duration())
}

/// A path through the middle between the ends of another, moved `offset` metres to the left.
fn offset_path(corners: &[MapPoint], offset: f64) -> Vec<MapPoint> {
    let (first, last) = (corners[0], corners[corners.len() - 1]);
    let left = first.bearing_to(last) + std::f64::consts::FRAC_PI_2;
    let middle = MapPoint::new((first.x + last.x) / 2.0, (first.y + last.y) / 2.0);
    vec![middle.offset(left, offset), last]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::scene::Kind;

    fn point(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    /// A goal three metres straight ahead, and walls.
    fn ahead(walls: &[[(f64, f64); 2]]) -> Scene {
        let wall =
            |[a, b]: &[(f64, f64); 2]| Obstacle::wall(point(a.0, a.1), point(b.0, b.1)).unwrap();
        Scene {
            kind: Kind::Open,
            start: Pose2::default(),
            goal: Pose2::new(3.0, 0.0, 0.0),
            obstacles: walls.iter().map(wall).collect(),
            jump: None,
        }
    }

    /// A room divided by a wall with a gap.
    fn gap(width: f64) -> Scene {
        let corners = [
            (-1.0, -2.0),
            (4.0, -2.0),
            (4.0, 2.0),
            (-1.0, 2.0),
            (-1.0, -2.0),
        ];
        let room = corners.windows(2).map(|w| [w[0], w[1]]);
        let across = [
            [(1.5, -2.0), (1.5, -width / 2.0)],
            [(1.5, width / 2.0), (1.5, 2.0)],
        ];
        ahead(&room.chain(across).collect::<Vec<_>>())
    }

    #[test]
    fn the_fastest_straight_motion_has_the_analytic_duration() {
        let robot = RobotDescription::sentry();
        let limits = Limits::of(&robot).unwrap();
        let Some(Reference::Motion(found)) = reference_motion(&ahead(&[]), &robot) else {
            panic!("no motion")
        };
        let ReferenceMotion {
            trajectory,
            arrival_s,
        } = found;
        // Both ramps at the limit of the acceleration, up to the tolerance of 10 cm.
        let (v, a) = (limits.forward, limits.acceleration);
        let physical = 3.0 / v + v / a - (2.0 * 0.1 / a).sqrt();
        assert!(
            (physical - 0.01..1.05 * physical + 0.05).contains(&arrival_s),
            "{arrival_s} {physical}"
        );
        assert!(
            trajectory
                .pose_at(trajectory.duration())
                .point()
                .distance(point(3.0, 0.0))
                < 0.02
        );
    }

    #[test]
    fn lateral_motion_is_rejected() {
        let robot = RobotDescription::sentry();
        let (footprint, limits, scene) = (
            Footprint::of(&robot).unwrap(),
            Limits::of(&robot).unwrap(),
            ahead(&[]),
        );
        let search = Search {
            scene: &scene,
            footprint: &footprint,
            limits: &limits,
            goal: scene.goal,
        };
        let trajectory = |x: f64, y: f64| {
            let to = Pose2::new(x, y, 0.0);
            Trajectory::new(vec![
                TimedPose {
                    pose: scene.start,
                    time: 0.0,
                },
                TimedPose {
                    pose: to,
                    time: 9.0,
                },
            ])
            .unwrap()
        };
        assert!(
            search.timed(&trajectory(1.0, 0.0)).is_some()
                && search.timed(&trajectory(1.0, 0.005)).is_some()
        );
        assert_eq!(
            (
                search.timed(&trajectory(1.0, 0.09)),
                search.timed(&trajectory(1e-5, 0.05))
            ),
            (None, None)
        );
    }

    #[test]
    fn a_gap_wider_than_the_robot_has_a_motion_and_a_narrower_one_a_proof() {
        let robot = RobotDescription::sentry();
        let motion = |width| reference_motion(&gap(width), &robot);
        assert!(matches!(
            motion(robot.width + 0.05),
            Some(Reference::Motion(..))
        ));
        assert_eq!(motion(robot.width - 0.05), Some(Reference::Infeasible));
    }

    #[test]
    fn a_closed_room_has_a_proof_and_a_single_wall_a_motion() {
        let robot = RobotDescription::sentry();
        let corners = [
            (1.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (-1.0, -1.0),
            (1.0, -1.0),
        ];
        let walls: Vec<_> = corners.windows(2).map(|w| [w[0], w[1]]).collect();
        assert_eq!(
            reference_motion(&ahead(&walls), &robot),
            Some(Reference::Infeasible)
        );
        assert!(matches!(
            reference_motion(&ahead(&walls[..1]), &robot),
            Some(Reference::Motion(..))
        ));
    }
}
