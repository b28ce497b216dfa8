//! What could be done in a scene: a proof that nothing can, or the fastest motion that a long search finds.
//!
//! A motion found is proof that there is one: it is looked at every hundredth of a second, keeps to the robot's limits, and its time is what planners are compared with, unless what can be made of their own drives ([`polished`]) is faster. That there is none is proven by the largest circle in the
//! footprint: where even that has no way on a fine grid, grown by half a cell's diagonal in the robot's favour, the footprint has none. Scenes in between are not used.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, Velocity};
use openbench_grid::GridGeometry;
use openbench_motion::feasible::clearance;
use openbench_motion::maneuver::maneuver;
use openbench_motion::teb::band::{Band, Knot};
use openbench_motion::teb::classes::{Explorer, Exploring};
use openbench_motion::teb::optimize::{Effort, Optimizer};
use openbench_motion::teb::settings::{Limits, Margins, Resolution, Settings, Weights};
use openbench_motion::teb::terms::Problem;
use openbench_motion::{Footprint, Obstacle};

use super::drive::is_there;
use super::retime::retimed;
use super::scene::Scene;

/// Side of a cell of the proof, metres.
const FINE: f64 = 0.005;
/// Ground around start and goal that the proof looks at, metres.
const AROUND: f64 = 4.0;
/// Distances from obstacles that are tried, metres: nearer is faster, but between two knots it may be nearer still.
const MARGINS: [f64; 3] = [0.005, 0.015, 0.03];
/// Seconds that the robot waits at first, for those who move to pass.
const WAITS: [f64; 5] = [0.0, 1.0, 2.0, 4.0, 7.0];
/// Waits that are tried before setting out as fast as can be, seconds, and how many of them.
const WAIT: f64 = 0.25;
const MOST_WAITS: u32 = 40;
/// Sideways share of the rims' way that is none.
const SLIP: f64 = 0.01;
/// Ways to the sides on which those who move are passed, metres.
const ASIDE: [f64; 5] = [0.0, 0.5, -0.5, 1.0, -1.0];

/// What can be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Possible {
    /// A motion, the fastest of those found, starting and ending at rest, and the seconds after which it is within the tolerance of the goal for good.
    Motion(Band, f64),
    /// It is proven that there is none.
    Nothing,
    /// Neither.
    Unknown,
}

/// Looks for the fastest motion through a scene. A jump of the estimate is regarded as known from the start.
pub fn possible(scene: &Scene, robot: &RobotDescription) -> Option<Possible> {
    let (footprint, limits) = (Footprint::of(robot).ok()?, Limits::of(robot).ok()?);
    let search = Search {
        scene,
        footprint: &footprint,
        limits: &limits,
        goal: true_goal(scene),
    };
    let fastest = search
        .drafts()
        .into_iter()
        .filter_map(|draft| search.settle(&draft));
    let fastest = fastest
        .map(|band| (arrival(&band, search.goal), band))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    Some(match fastest {
        Some((seconds, band)) => Possible::Motion(band, seconds),
        None if search.proves_nothing() => Possible::Nothing,
        None => Possible::Unknown,
    })
}

/// The seconds after which the goal is reached by what a drive can be made into: its poses, and the seconds between two of them.
pub fn polished(
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
    let mut knots: Vec<Knot> = Vec::with_capacity(track.len());
    for (i, &pose) in track.iter().enumerate() {
        let yaw = knots
            .last()
            .map_or(pose.yaw, |k| k.pose.yaw + wrap_angle(pose.yaw - k.pose.yaw));
        knots.push(Knot {
            pose: Pose2 { yaw, ..pose },
            time: i as f64 * seconds,
        });
    }
    search
        .settle(&Band::new(knots)?)
        .map(|band| arrival(&band, search.goal))
}

/// Where the goal will be once the estimate has jumped.
fn true_goal(scene: &Scene) -> Pose2 {
    let by = scene.jump.map_or([0.0; 2], |j| j.by);
    Pose2::new(scene.goal.x - by[0], scene.goal.y - by[1], scene.goal.yaw)
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

    /// Bands of all classes, both turns, with waits and ways aside where somebody moves, and maneuvers.
    fn drafts(&self) -> Vec<Band> {
        let (start, obstacles) = (self.scene.start, &self.scene.obstacles);
        let standing: Vec<Obstacle> = obstacles
            .iter()
            .filter(|o| !o.is_moving())
            .cloned()
            .collect();
        let moving = standing.len() < obstacles.len();
        let how = Exploring {
            cell: 0.05,
            around: 2.5,
            keep: self.footprint.inscribed(),
            comfort: self.footprint.inscribed() + 0.1,
            most: 8,
            longest: 2.0,
        };
        let mut explorer = Explorer::default();
        let ways = explorer.explore(start.point(), self.goal.point(), &standing, &how);
        let mut drafts = Vec::new();
        for way in &ways {
            let behind = way
                .corners
                .get(1)
                .is_some_and(|c| start.inverse_transform(*c).0 < 0.0);
            for side in [-1.0, 1.0].into_iter().take(1 + usize::from(behind)) {
                let along = |corners: &[MapPoint]| {
                    Band::along(start, corners, Some(self.goal.yaw), self.limits, side)
                };
                let plain = along(&way.corners[1..]);
                drafts.extend(plain.as_ref().and_then(turned_the_other_way));
                drafts.extend(plain);
                if moving {
                    let bent = ASIDE
                        .iter()
                        .filter_map(|aside| along(&bent(&way.corners, *aside)));
                    drafts.extend(bent.flat_map(|band| {
                        WAITS.map(|wait| band.delayed(wait).unwrap_or(band.clone()))
                    }));
                }
            }
        }
        let backed = |length: f64| self.backed(&ways.first()?.corners, length);
        drafts.extend([0.2, 0.5, 1.0].into_iter().filter_map(backed));
        let yaw = Some(self.goal.yaw);
        drafts.extend(maneuver(
            self.footprint,
            self.limits,
            &standing,
            start,
            self.goal.point(),
            yaw,
        ));
        drafts
    }

    /// Backwards at first, then along the way.
    fn backed(&self, corners: &[MapPoint], length: f64) -> Option<Band> {
        let start = self.scene.start;
        let back = start.transform(-length, 0.0);
        let from = Pose2::new(back.x, back.y, start.yaw);
        let seconds = length / self.limits.backward;
        let rest = Band::along(from, &corners[1..], Some(self.goal.yaw), self.limits, 1.0)?;
        let later = rest.knots().iter().map(|k| Knot {
            time: k.time + seconds,
            ..*k
        });
        Band::new(
            std::iter::once(Knot {
                pose: start,
                time: 0.0,
            })
            .chain(later)
            .collect(),
        )
    }

    /// The fastest motion that a draft leads to: itself, or improved with one of several margins.
    fn settle(&self, draft: &Band) -> Option<Band> {
        let improved = MARGINS.iter().map(|least| self.improved(draft, *least));
        let settled = improved
            .chain([draft.clone()])
            .filter_map(|band| self.timed(&band));
        self.earliest(settled)
    }

    /// The motion that is first within the tolerance of the goal.
    fn earliest(&self, bands: impl Iterator<Item = Band>) -> Option<Band> {
        bands.min_by(|a, b| arrival(a, self.goal).total_cmp(&arrival(b, self.goal)))
    }

    /// The same way as fast as the robot can drive it without touching anything: at the times that it has, slowed down, or at the shortest, standing nowhere but at the start if need be.
    fn timed(&self, band: &Band) -> Option<Band> {
        let shortest = retimed(band, self.limits);
        let moving = self.scene.obstacles.iter().any(Obstacle::is_moving);
        let waits = (1..=MOST_WAITS)
            .take_while(|_| moving)
            .map(|i| f64::from(i) * WAIT);
        let delayed = waits.filter_map(|wait| shortest.as_ref()?.delayed(wait));
        let mut bands = shortest.iter().cloned().chain(delayed);
        let at_once = bands.find_map(|band| self.slowed(&band).filter(|band| self.is_clear(band)));
        let as_it_is = self.slowed(band).filter(|band| self.is_clear(band));
        self.earliest(at_once.into_iter().chain(as_it_is))
    }

    fn improved(&self, draft: &Band, least: f64) -> Band {
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
        let mut band = draft.clone();
        Optimizer::default().improve(&mut band, &problem, &[], &Effort::PATIENT);
        band
    }

    /// With all times longer by the ratio by which the worst limit is broken.
    fn slowed(&self, band: &Band) -> Option<Band> {
        let knots = band.knots();
        let mut ratio = 1.0_f64;
        let mut before: Option<(Velocity, f64)> = None;
        for i in 0..knots.len() - 1 {
            let (v, seconds) = (band.velocity(i), knots[i + 1].time - knots[i].time);
            ratio = ratio
                .max(v.linear / self.limits.forward)
                .max(-v.linear / self.limits.backward);
            ratio = ratio.max(v.angular.abs() / self.limits.turn);
            let (from, between) = before.map_or((Velocity::ZERO, seconds / 2.0), |(u, s)| {
                (u, (s + seconds) / 2.0)
            });
            ratio = ratio.max((self.rims(from, v) / between / self.limits.acceleration).sqrt());
            before = Some((v, seconds));
        }
        if let Some((v, seconds)) = before {
            let braking = self.rims(v, Velocity::ZERO) / (seconds / 2.0);
            ratio = ratio.max((braking / self.limits.acceleration).sqrt());
        }
        // Stretches of next to no time at the ends are not worth more than their own slowing.
        Band::new(
            knots
                .iter()
                .map(|k| Knot {
                    time: k.time * ratio,
                    ..*k
                })
                .collect(),
        )
        .filter(|_| ratio < 1.2)
    }

    fn rims(&self, a: Velocity, b: Velocity) -> f64 {
        let (v, w) = (
            b.linear - a.linear,
            self.limits.half_track * (b.angular - a.angular),
        );
        (v + w).abs().max((v - w).abs())
    }

    fn is_clear(&self, band: &Band) -> bool {
        let (obstacles, footprint) = (&self.scene.obstacles, self.footprint);
        let mut floor = f64::NEG_INFINITY;
        let steps = (band.duration() / 0.01).ceil() as usize;
        (0..=steps).all(|i| {
            let time = (i as f64 * 0.01).min(band.duration());
            let clear = clearance(footprint, obstacles.iter(), band.pose_at(time), time, 0.1);
            if i == 0 {
                floor = clear.min(0.0);
            }
            clear >= floor
        }) && self.is_drivable(band)
    }

    /// Whether next to nothing of it is sideways: a hundredth of what the rims get.
    fn is_drivable(&self, band: &Band) -> bool {
        let slips = band.knots().windows(2).map(|w| {
            let turn = self.limits.half_track * (w[1].pose.yaw - w[0].pose.yaw);
            let (sin, cos) = libm::sincos((w[0].pose.yaw + w[1].pose.yaw) / 2.0);
            let (dx, dy) = (w[1].pose.x - w[0].pose.x, w[1].pose.y - w[0].pose.y);
            let (along, aside) = (dx * cos + dy * sin, dy * cos - dx * sin);
            aside.abs() - SLIP * (along.abs() + turn.abs())
        });
        slips.sum::<f64>() < 0.0
    }

    fn proves_nothing(&self) -> bool {
        let (start, goal) = (self.scene.start.point(), self.goal.point());
        let low = MapPoint::new(start.x.min(goal.x) - AROUND, start.y.min(goal.y) - AROUND);
        let high = MapPoint::new(start.x.max(goal.x) + AROUND, start.y.max(goal.y) + AROUND);
        let grid = GridGeometry::covering(low, high, FINE, 4000);
        let least = self.footprint.inscribed() - std::f64::consts::FRAC_1_SQRT_2 * FINE;
        let mut blocked = vec![false; grid.len()];
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

/// Whether a way leads from one cell to another, or off the grid, from where it may come back. Marks cells as blocked once it has been there.
fn connected(grid: &GridGeometry, mut blocked: Vec<bool>, from: usize, to: usize) -> bool {
    if blocked[to] {
        return false;
    }
    let reaches_border = |from: usize, target: Option<usize>, blocked: &mut Vec<bool>| {
        let mut open = vec![from];
        let mut border = false;
        while let Some(cell) = open.pop() {
            if Some(cell) == target {
                return (true, border);
            }
            let (x, y) = grid.column_row(cell);
            for (dx, dy) in [
                (1, 0),
                (0, 1),
                (-1, 0),
                (0, -1),
                (1, 1),
                (-1, 1),
                (-1, -1),
                (1, -1),
            ] {
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
        (false, border)
    };
    let mut target_free = blocked.clone();
    let (found, out) = reaches_border(from, Some(to), &mut blocked);
    found || (out && reaches_border(to, None, &mut target_free).1)
}

/// The same with its last turn to the other side.
fn turned_the_other_way(band: &Band) -> Option<Band> {
    let mut knots = band.knots().to_vec();
    let before = knots[knots.len().checked_sub(2)?].pose.yaw;
    let last = knots.last_mut()?;
    let turn = last.pose.yaw - before;
    last.pose.yaw -= std::f64::consts::TAU.copysign(turn);
    // Times are for the optimizer to find, from a rate of one radian a second.
    last.time += std::f64::consts::TAU - 2.0 * turn.abs();
    (turn.abs() > 1.0).then(|| Band::new(knots)).flatten()
}

/// Seconds until a band is within the tolerance of its goal and stays there.
fn arrival(band: &Band, goal: Pose2) -> f64 {
    let steps = (band.duration() / 0.05) as usize;
    let away = (0..=steps)
        .rev()
        .find(|&i| !is_there(band.pose_at(i as f64 * 0.05), goal));
    away.map_or(0.0, |i| (i + 1) as f64 * 0.05)
        .min(band.duration())
}

/// A way with its middle moved aside.
fn bent(corners: &[MapPoint], aside: f64) -> Vec<MapPoint> {
    let (first, last) = (corners[0], corners[corners.len() - 1]);
    let left = first.bearing_to(last) + std::f64::consts::FRAC_PI_2;
    let middle = MapPoint::new((first.x + last.x) / 2.0, (first.y + last.y) / 2.0);
    vec![middle.offset(left, aside), last]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::scene::Kind;

    fn point(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    /// Three metres straight ahead, past walls.
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

    /// A room with a wall across that has a gap.
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
    fn the_fastest_motion_straight_ahead_takes_as_long_as_physics_says() {
        let robot = RobotDescription::sentry();
        let limits = Limits::of(&robot).unwrap();
        let Some(Possible::Motion(band, seconds)) = possible(&ahead(&[]), &robot) else {
            panic!("no motion")
        };
        // Both ramps at the acceleration's limit; all but the last 10 cm, the tolerance.
        let (v, a) = (limits.forward, limits.acceleration);
        let physical = 3.0 / v + v / a - (2.0 * 0.1 / a).sqrt();
        assert!(
            (physical - 0.01..1.05 * physical + 0.05).contains(&seconds),
            "{seconds} {physical}"
        );
        assert!(
            band.pose_at(band.duration())
                .point()
                .distance(point(3.0, 0.0))
                < 0.02
        );
    }

    #[test]
    fn what_slips_sideways_is_no_motion() {
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
        let band = |x: f64, y: f64| {
            let to = Pose2::new(x, y, 0.0);
            Band::new(vec![
                Knot {
                    pose: scene.start,
                    time: 0.0,
                },
                Knot {
                    pose: to,
                    time: 9.0,
                },
            ])
            .unwrap()
        };
        assert!(
            search.timed(&band(1.0, 0.0)).is_some() && search.timed(&band(1.0, 0.005)).is_some()
        );
        assert_eq!(
            (
                search.timed(&band(1.0, 0.09)),
                search.timed(&band(1e-5, 0.05))
            ),
            (None, None)
        );
    }

    #[test]
    fn a_gap_is_a_motion_or_a_proof() {
        let robot = RobotDescription::sentry();
        let motion = |width| possible(&gap(width), &robot);
        assert!(matches!(
            motion(robot.width + 0.05),
            Some(Possible::Motion(..))
        ));
        assert_eq!(motion(robot.width - 0.05), Some(Possible::Nothing));
    }

    #[test]
    fn a_room_without_a_door_is_a_proof_and_a_way_around_is_none() {
        let robot = RobotDescription::sentry();
        let corners = [
            (1.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (-1.0, -1.0),
            (1.0, -1.0),
        ];
        let walls: Vec<_> = corners.windows(2).map(|w| [w[0], w[1]]).collect();
        assert_eq!(possible(&ahead(&walls), &robot), Some(Possible::Nothing));
        assert!(matches!(
            possible(&ahead(&walls[..1]), &robot),
            Some(Possible::Motion(..))
        ));
    }
}
