//! Random scenes of some metres for local planners.
//!
//! Each kind is drawn straight ahead of a robot at the origin, then turned and mirrored by chance,
//! so that no planner gains from the axes.

use openbench_core::{MapPoint, Pose2, RobotDescription};
use openbench_motion::{Obstacle, ShapeError, Vector2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

/// Speed at which the robot probably approaches, m/s: people are timed to meet it.
const ROBOT_SPEED_MPS: f64 = 0.45;

/// The difficulty of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Kind {
    /// Few obstacles.
    Open,
    /// Many obstacles.
    Cluttered,
    /// A gap five centimetres wider than the robot.
    NarrowGap,
    /// A pocket or corridor that the robot must leave, too narrow to turn in or closed ahead.
    DeadEnd,
    /// A doorway into a corridor that crosses directly behind it.
    Doorway,
    /// A goal behind the robot.
    UTurn,
    /// People who cross the robot's path and do not yield.
    Crossers,
    /// A person who approaches head-on.
    HeadOn,
    /// The robot is in contact or near contact with an obstacle at the start.
    Touching,
    /// The pose estimate jumps by half a metre during the drive.
    Jump,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 10] = [
        Self::Open,
        Self::Cluttered,
        Self::NarrowGap,
        Self::DeadEnd,
        Self::Doorway,
        Self::UTurn,
        Self::Crossers,
        Self::HeadOn,
        Self::Touching,
        Self::Jump,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Cluttered => "cluttered",
            Self::NarrowGap => "narrow gap",
            Self::DeadEnd => "dead end",
            Self::Doorway => "doorway",
            Self::UTurn => "u-turn",
            Self::Crossers => "crossers",
            Self::HeadOn => "head-on",
            Self::Touching => "touching",
            Self::Jump => "jump",
        }
    }
}

/// A jump of the estimated pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// Time since the start, seconds.
    pub at: f64,
    /// Displacement in the `map` frame, metres.
    pub by: Vector2,
}

/// A scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Its difficulty.
    pub kind: Kind,
    /// Start pose of the robot.
    pub start: Pose2,
    /// Goal pose.
    pub goal: Pose2,
    /// Obstacles, at their initial positions.
    pub obstacles: Vec<Obstacle>,
    /// Jump of the pose estimate, if any.
    pub jump: Option<Jump>,
}

/// Draws scene `number`, whose kind is `Kind::ALL[number % 10]`, from a seed.
///
/// ```
/// use openbench_core::RobotDescription;
/// use openbench_trials::motion::scene::{Kind, scene};
///
/// let scene = scene(12, 1, &RobotDescription::sentry())?;
/// assert_eq!(scene.kind, Kind::NarrowGap);
/// assert!(scene.start.point().distance(scene.goal.point()) < 9.0);
/// # Ok::<(), openbench_motion::ShapeError>(())
/// ```
///
/// # Errors
/// An obstacle of invalid shape, which only an invalid robot description causes.
pub fn scene(number: usize, seed: u64, robot: &RobotDescription) -> Result<Scene, ShapeError> {
    // 2^64 divided by the golden ratio: consecutive numbers differ in many bits of the seed.
    let mut rng =
        Pcg64Mcg::seed_from_u64(seed ^ (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let kind = Kind::ALL[number % Kind::ALL.len()];
    let mut draft = Draft {
        rng: &mut rng,
        robot,
        goal: Pose2::default(),
        obstacles: Vec::new(),
        jump: None,
    };
    draft.draw(kind)?;
    // Taken apart, since the draft borrows the generator.
    let Draft {
        goal,
        obstacles,
        jump,
        ..
    } = draft;
    let place = Placing {
        mirror: if rng.random::<bool>() { -1.0 } else { 1.0 },
        at: Pose2::new(
            rng.random_range(-50.0..50.0),
            rng.random_range(-50.0..50.0),
            rng.random_range(-3.1..3.1),
        ),
    };
    Ok(Scene {
        kind,
        start: place.pose(Pose2::default()),
        goal: place.pose(goal),
        obstacles: obstacles
            .iter()
            .map(|o| place.obstacle(o))
            .collect::<Result<_, _>>()?,
        jump: jump.map(|j| Jump {
            by: place.vector(j.by),
            ..j
        }),
    })
}

/// The transformation of a scene drawn at the origin: a reflection, then a rigid motion.
struct Placing {
    mirror: f64,
    at: Pose2,
}

impl Placing {
    fn point(&self, p: MapPoint) -> MapPoint {
        self.at.transform(p.x, self.mirror * p.y)
    }

    fn vector(&self, v: Vector2) -> Vector2 {
        // The difference of two points: a vector is mirrored and rotated, but not moved.
        let (a, b) = (self.point(v.point()), self.point(MapPoint::default()));
        Vector2::new(a.x - b.x, a.y - b.y)
    }

    fn pose(&self, p: Pose2) -> Pose2 {
        let at = self.point(p.point());
        Pose2::new(at.x, at.y, self.at.yaw + self.mirror * p.yaw)
    }

    fn obstacle(&self, o: &Obstacle) -> Result<Obstacle, ShapeError> {
        let (corners, rounding) = (o.corners(), o.rounding());
        let mut corners: Vec<MapPoint> = corners.map(|c| self.point(c)).collect();
        // A reflection reverses the order of the corners, which is counter-clockwise.
        if self.mirror < 0.0 {
            corners.reverse();
        }
        Obstacle::new(&corners, rounding, self.vector(o.velocity()))
    }
}

/// A scene under construction, with the robot at the origin facing east.
struct Draft<'a> {
    rng: &'a mut Pcg64Mcg,
    robot: &'a RobotDescription,
    goal: Pose2,
    obstacles: Vec<Obstacle>,
    jump: Option<Jump>,
}

impl Draft<'_> {
    fn draw(&mut self, kind: Kind) -> Result<(), ShapeError> {
        match kind {
            Kind::Open => self.open(),
            Kind::Cluttered => self.cluttered(),
            Kind::NarrowGap => self.narrow_gap(),
            Kind::DeadEnd => self.dead_end(),
            Kind::Doorway => self.doorway(),
            Kind::UTurn => self.u_turn(),
            Kind::Crossers => self.crossers(),
            Kind::HeadOn => self.head_on(),
            Kind::Touching => self.touching(),
            Kind::Jump => self.jump(),
        }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.rng.random_range(low..high)
    }

    fn chance(&mut self, share: f64) -> bool {
        self.rng.random::<f64>() < share
    }

    fn goal_ahead(&mut self) {
        let (distance, bearing) = (self.between(3.0, 6.0), self.between(-0.5, 0.5));
        let at = MapPoint::default().offset(bearing, distance);
        self.goal = Pose2::new(at.x, at.y, self.between(-3.1, 3.1));
    }

    fn wall(&mut self, from: MapPoint, to: MapPoint) -> Result<(), ShapeError> {
        self.obstacles.push(Obstacle::wall(from, to)?);
        Ok(())
    }

    /// Adds an axis-parallel box.
    fn block(&mut self, low: MapPoint, high: MapPoint) -> Result<(), ShapeError> {
        let corners = [low, point(high.x, low.y), high, point(low.x, high.y)];
        self.obstacles
            .push(Obstacle::new(&corners, 0.0, Vector2::ZERO)?);
        Ok(())
    }

    /// Adds the four walls of an axis-parallel room.
    fn room(&mut self, low: MapPoint, high: MapPoint) -> Result<(), ShapeError> {
        let corners = [low, point(high.x, low.y), high, point(low.x, high.y), low];
        corners.windows(2).try_for_each(|w| self.wall(w[0], w[1]))
    }

    /// Adds a random disc, wall or polygon, unless it is within `keep` metres of start or goal.
    fn obstacle(&mut self, keep: f64) -> Result<(), ShapeError> {
        let at = MapPoint::new(self.between(-1.0, 7.0), self.between(-3.0, 3.0));
        let size = self.between(0.05, 0.45);
        let obstacle = match self.rng.random_range(0..3) {
            0 => Obstacle::disc(at, size)?,
            1 => Obstacle::wall(at, at.offset(self.between(-3.1, 3.1), 2.0 * size))?,
            _ => {
                let (sides, turn) = (self.rng.random_range(3..7), self.between(0.0, 6.3));
                // Corners on a circle, so that the polygon is convex, as an obstacle must be.
                let corner = |i: usize| {
                    at.offset(turn + std::f64::consts::TAU * i as f64 / sides as f64, size)
                };
                Obstacle::new(
                    &(0..sides).map(corner).collect::<Vec<_>>(),
                    0.0,
                    Vector2::ZERO,
                )?
            }
        };
        let is_clear = |p: MapPoint| obstacle.distance_to(p) > keep;
        if is_clear(MapPoint::default()) && is_clear(self.goal.point()) {
            self.obstacles.push(obstacle);
        }
        Ok(())
    }

    fn obstacles(&mut self, count: usize, keep: f64) -> Result<(), ShapeError> {
        (0..count).try_for_each(|_| self.obstacle(keep))
    }

    fn open(&mut self) -> Result<(), ShapeError> {
        self.goal_ahead();
        let count = self.rng.random_range(0..4);
        self.obstacles(count, 0.5)
    }

    fn cluttered(&mut self) -> Result<(), ShapeError> {
        self.goal_ahead();
        let count = self.rng.random_range(12..36);
        self.obstacles(count, 0.3)
    }

    fn narrow_gap(&mut self) -> Result<(), ShapeError> {
        // One gap in seven is narrower than the robot, which has to be recognized.
        let spare = if self.chance(0.85) {
            0.05
        } else {
            self.between(-0.05, -0.01)
        };
        let half = (self.robot.width + spare) / 2.0;
        let (x, y, thick) = (
            self.between(1.2, 2.5),
            self.between(-1.5, 1.5),
            self.between(0.02, 0.5),
        );
        // A room around the wall, so that no path leads round it.
        self.room(point(-1.0, -3.0), point(5.0, 3.0))?;
        self.block(point(x, -3.0), point(x + thick, y - half))?;
        self.block(point(x, y + half), point(x + thick, 3.0))?;
        self.goal = Pose2::new(
            self.between(x + thick + 0.6, 4.5),
            self.between(-2.0, 2.0),
            self.between(-3.1, 3.1),
        );
        Ok(())
    }

    fn dead_end(&mut self) -> Result<(), ShapeError> {
        let narrow = self.chance(0.5);
        // Narrow: less than the robot's diagonal, so that it can only leave backwards.
        let half = if narrow {
            self.between(0.19, 0.22)
        } else {
            self.between(0.3, 0.8)
        };
        let (front, back) = (self.between(0.3, 1.5), self.between(0.5, 2.0));
        // Closed on all sides, so that there is no motion.
        let closed = self.chance(0.15);
        // Outside of the pocket, but inside this room, lies the goal.
        self.room(point(-back - 3.0, -3.0), point(front + 2.0, 3.0))?;
        self.block(point(-back, half), point(front, half + 0.1))?;
        self.block(point(-back, -half - 0.1), point(front, -half))?;
        self.block(point(front, -half - 0.1), point(front + 0.1, half + 0.1))?;
        if closed {
            self.block(point(-back - 0.1, -half - 0.1), point(-back, half + 0.1))?;
        }
        let behind = self.chance(0.5);
        let x = if behind {
            -back - self.between(0.8, 2.0)
        } else {
            front + self.between(0.6, 1.4)
        };
        self.goal = Pose2::new(x, self.between(-1.5, 1.5), self.between(-3.1, 3.1));
        Ok(())
    }

    fn doorway(&mut self) -> Result<(), ShapeError> {
        let (x, half) = (self.between(0.8, 2.0), self.between(0.25, 0.5));
        let y = self.between(-1.0, 1.0);
        let width = self.between(0.5, 1.0);
        let far = x + 0.1 + width;
        // The far wall of the room is that of the corridor.
        self.room(point(-1.5, -3.0), point(far, 3.0))?;
        self.block(point(x, -3.0), point(x + 0.1, y - half))?;
        self.block(point(x, y + half), point(x + 0.1, 3.0))?;
        let side = if self.rng.random::<bool>() { 1.0 } else { -1.0 };
        // Along the corridor, so that the robot turns directly behind the door.
        let along = side * self.between(1.0, 1.8) + y;
        self.goal = Pose2::new(
            x + 0.1 + width / 2.0,
            along,
            side * std::f64::consts::FRAC_PI_2,
        );
        Ok(())
    }

    fn u_turn(&mut self) -> Result<(), ShapeError> {
        let half = self.between(0.3, 1.0);
        self.room(point(-5.0, -half), point(2.0, half))?;
        let x = -self.between(1.0, 4.0);
        self.goal = Pose2::new(
            x,
            // The robot's circumscribed circle, of 0.22 m, fits between goal and wall.
            self.between(-half + 0.25, half - 0.25),
            std::f64::consts::PI,
        );
        Ok(())
    }

    /// Adds a person who passes through `at` after `seconds`, with `speed` in m/s towards
    /// `bearing`.
    fn person(
        &mut self,
        at: MapPoint,
        seconds: f64,
        speed: f64,
        bearing: f64,
    ) -> Result<(), ShapeError> {
        let from = at.offset(bearing + std::f64::consts::PI, speed * seconds);
        let (sin, cos) = libm::sincos(bearing);
        let radius = self.between(0.2, 0.3);
        self.obstacles.push(Obstacle::new(
            &[from],
            radius,
            Vector2::new(speed * cos, speed * sin),
        )?);
        Ok(())
    }

    fn crossers(&mut self) -> Result<(), ShapeError> {
        self.goal = Pose2::new(self.between(4.0, 6.0), 0.0, 0.0);
        for _ in 0..self.rng.random_range(2..6) {
            let at = MapPoint::new(self.between(1.0, 4.0), 0.0);
            let side = if self.rng.random::<bool>() { 1.0 } else { -1.0 };
            let bearing = side * self.between(0.9, 2.2);
            let (seconds, speed) = (
                at.x / ROBOT_SPEED_MPS + self.between(-1.0, 1.0),
                self.between(0.4, 1.3),
            );
            self.person(at, seconds, speed, bearing)?;
        }
        Ok(())
    }

    fn head_on(&mut self) -> Result<(), ShapeError> {
        self.goal = Pose2::new(self.between(4.0, 6.0), 0.0, 0.0);
        if self.chance(0.5) {
            let half = self.between(0.9, 1.5);
            self.wall(point(-3.0, half), point(8.0, half))?;
            self.wall(point(-3.0, -half), point(8.0, -half))?;
        }
        let speed = self.between(0.4, 1.3);
        let at = MapPoint::new(self.between(1.5, 2.5), self.between(-0.1, 0.1));
        self.person(at, at.x / ROBOT_SPEED_MPS, speed, std::f64::consts::PI)
    }

    fn touching(&mut self) -> Result<(), ShapeError> {
        self.goal_ahead();
        let count = self.rng.random_range(3..12);
        self.obstacles(count, 0.4)?;
        let gap = self.between(0.0, 0.005);
        let (x, y) = (self.robot.length / 2.0, self.robot.width / 2.0);
        // In front of the robot, beside it, or behind and beside it.
        match self.rng.random_range(0..3) {
            0 => self.block(point(x + gap, -0.4), point(x + gap + 0.2, 0.4)),
            1 => self.block(point(-0.5, y + gap), point(0.8, y + gap + 0.1)),
            _ => {
                self.block(point(-x - gap - 0.1, -0.4), point(-x - gap, 0.4))?;
                self.block(point(-0.5, y + gap), point(0.8, y + gap + 0.1))
            }
        }
    }

    fn jump(&mut self) -> Result<(), ShapeError> {
        self.goal_ahead();
        let count = self.rng.random_range(2..10);
        // The true goal is half a metre from the goal, and must be free as well.
        self.obstacles(count, 0.9)?;
        let (sin, cos) = libm::sincos(self.between(-3.1, 3.1));
        self.jump = Some(Jump {
            at: self.between(1.0, 5.0),
            by: Vector2::new(0.5 * cos, 0.5 * sin),
        });
        Ok(())
    }
}

fn point(x: f64, y: f64) -> MapPoint {
    MapPoint::new(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_motion::Footprint;
    use openbench_motion::feasible::clearance;

    #[test]
    fn a_scene_depends_on_number_and_seed_only() {
        let robot = RobotDescription::sentry();
        let draw = |number, seed| scene(number, seed, &robot).unwrap();
        for number in 0..30 {
            let (one, next) = (draw(number, 1), draw(number + 10, 1));
            assert_eq!(one, draw(number, 1));
            assert_eq!((one.kind, next.kind), (Kind::ALL[number % 10], one.kind));
            assert!(one != next && one != draw(number, 2), "{number}");
        }
    }

    #[test]
    fn only_scenes_of_the_kind_touching_start_near_contact() {
        let robot = RobotDescription::sentry();
        let footprint = Footprint::of(&robot).unwrap();
        for number in 0..500 {
            let scene = scene(number, 7, &robot).unwrap();
            let clear = clearance(&footprint, scene.obstacles.iter(), scene.start, 0.0, 1.0);
            let touching = scene.kind == Kind::Touching;
            assert!(
                if touching {
                    (-1e-9..=0.0051).contains(&clear)
                } else {
                    clear > 0.0
                },
                "{number} {clear}"
            );
            let length = scene.start.point().distance(scene.goal.point());
            assert!((0.4..9.0).contains(&length), "{number} {length}");
            let by = scene.jump.map(|jump| libm::hypot(jump.by.x, jump.by.y));
            assert_eq!(scene.kind == Kind::Jump, by.is_some());
            assert!(by.is_none_or(|by| (by - 0.5).abs() < 1e-9));
            let moves = scene.obstacles.iter().any(Obstacle::is_moving);
            assert_eq!(
                moves,
                matches!(scene.kind, Kind::Crossers | Kind::HeadOn),
                "{number}"
            );
        }
    }
}
