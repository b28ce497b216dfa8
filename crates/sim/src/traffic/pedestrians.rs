//! People who walk along the footways by the [social force model](super::social_force).
//!
//! Desired speeds are normal, 1.34 m/s with a standard deviation of 0.26 m/s, and nobody exceeds
//! 1.3 times his own (Helbing and Molnár). Forces alone let bodies overlap in a crowd; bodies that
//! still overlap after a step are moved apart.
//!
//! Up to about one person a square metre, speeds are those of Weidmann's fundamental diagram;
//! denser crowds walk faster than they should (`crowds` tests it).

use openbench_core::MapPoint;
use openbench_core::frames::wrap_angle;

use super::ground::Ground;
use super::hull::CarHull;
use super::mover::{PERSON_RADIUS_M, RobotState};
use super::neighbours::Neighbours;
use super::social_force::{self, Body, SIGHT_M};
use super::walk_graph::WalkGraph;
use crate::noise::Noise;

/// Nobody walks faster than this times the desired speed (Helbing and Molnár).
const HURRY: f64 = 1.3;
/// Largest acceleration, m/s².
const MAX_ACCELERATION: f64 = 4.0;
/// Distance at which people look along their path, metres.
const LOOK_AHEAD_M: f64 = 2.0;
/// Length of a walking cycle, two steps, at usual speed, metres.
pub(super) const STRIDE_M: f64 = 1.4;
/// Fastest turn of the body, rad/s: half round in 0.8 s.
const MAX_TURN: f64 = 4.0;
/// Below this speed the body does not turn, m/s.
const TURNING_SPEED: f64 = 0.15;
/// A person who has moved less than half a metre in this time takes another goal, seconds.
const PATIENCE_S: f64 = 5.0;
const PATIENCE_M: f64 = 0.5;
/// Nobody steps onto the carriageway before a car that is nearer than this, seconds.
const GAP_S: f64 = 4.0;
/// Least distance between two people at the start, metres.
const START_APART_M: f64 = 0.6;
/// Least distance of people from the robot at the start, metres.
const START_FROM_ROBOT_M: f64 = 3.0;
/// Draws of a place for each person, before fewer people than planned are accepted.
const DRAWS: usize = 20;
/// Largest shift of overlapping bodies in one round, metres: a jam dissolves in a few steps.
const MAX_PUSH_M: f64 = 0.1;
/// Rounds in which overlapping bodies are moved apart.
const PUSH_ROUNDS: usize = 3;

/// A person on a journey.
#[derive(Debug, Clone)]
pub(super) struct Person {
    pub position: MapPoint,
    /// In `map`, m/s.
    pub velocity: [f64; 2],
    pub yaw: f64,
    /// Metres.
    pub radius: f64,
    /// Phase of the walking cycle, 0 to 1.
    pub gait: f64,
    /// Desired speed, m/s.
    pub desired: f64,
    /// Share of the path's half width that this person keeps to the right of its middle.
    side: f64,
    /// Places of the journey.
    path: Vec<u32>,
    /// Index in `path` of the place that the person walks to.
    next: usize,
    patience: Patience,
}

/// How far a person has got lately.
#[derive(Debug, Clone, Copy)]
struct Patience {
    /// Where the person was when this began.
    from: MapPoint,
    /// How long ago, seconds.
    age: f64,
}

/// All people.
#[derive(Debug)]
pub(super) struct Pedestrians {
    pub people: Vec<Person>,
    pub near: Neighbours,
    footways: WalkGraph,
    noise: Noise,
    accelerations: Vec<[f64; 2]>,
}

/// What people react to besides each other.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub ground: &'a Ground,
    pub robot: &'a RobotState,
    pub cars: &'a [CarHull],
    /// Finds cars by place.
    pub near_cars: &'a Neighbours,
}

impl Pedestrians {
    /// Up to `count` people on the footways, none within 3 m of `start`.
    pub fn new(
        footways: WalkGraph,
        ground: &Ground,
        count: usize,
        start: MapPoint,
        mut noise: Noise,
    ) -> Self {
        let mut all = Self {
            people: Vec::new(),
            near: Neighbours::new(SIGHT_M),
            footways,
            // A stand-in: the draws below need the numbers while `all` is borrowed.
            noise: noise.clone(),
            accelerations: vec![],
        };
        let draws = if all.footways.is_empty() {
            0
        } else {
            DRAWS * count
        };
        for _ in 0..draws {
            if all.people.len() == count {
                break;
            }
            let place = all.footways.draw(&mut noise);
            let (along, across) = (noise.uniform() - 0.5, noise.uniform() - 0.5);
            let middle = all.footways.point(place);
            let at = MapPoint::new(middle.x + along, middle.y + across);
            let crowded = all
                .people
                .iter()
                .any(|p| p.position.distance(at) < START_APART_M);
            let apart = at.distance(start) > START_FROM_ROBOT_M;
            if !crowded && apart && ground.fits(at) && ground.sees(at, middle) {
                let person = Person::new(at, place, &mut all.footways, &mut noise);
                all.people.push(person);
            }
        }
        all.noise = noise;
        all.accelerations = vec![[0.0; 2]; all.people.len()];
        all.update_neighbours();
        all
    }

    /// Sorts people by place, after they have moved.
    pub fn update_neighbours(&mut self) {
        self.near.fill(self.people.iter().map(|p| Some(p.position)));
    }

    /// Moves all people by `dt` seconds. [`near`](Self::near) must be up to date.
    pub fn step(&mut self, dt: f64, around: Surroundings<'_>) {
        for i in 0..self.people.len() {
            self.follow_path(i, dt);
        }
        for i in 0..self.people.len() {
            // All decide by the same instant before any of them moves.
            self.accelerations[i] = self.acceleration(i, around);
        }
        for (person, acceleration) in self.people.iter_mut().zip(&self.accelerations) {
            person.walk(dt, *acceleration, around.ground);
        }
        self.update_neighbours();
        // Moving one pair apart may push one of them into a third. A round shifts a body by 10 cm
        // at most, so the neighbours found before still hold.
        for _ in 0..PUSH_ROUNDS {
            self.push_apart(around);
        }
    }

    /// Passes places that were reached. Takes a new goal at the end of the path, or when patience
    /// is exhausted.
    fn follow_path(&mut self, i: usize, dt: f64) {
        let person = &mut self.people[i];
        while person.next < person.path.len() && person.has_passed(&self.footways) {
            person.next += 1;
        }
        person.patience.age += dt;
        // Progress is judged over whole intervals of patience, not from step to step: people sway.
        let waited = person.patience.age > PATIENCE_S;
        let stuck = waited && person.patience.from.distance(person.position) < PATIENCE_M;
        if person.next == person.path.len() || stuck {
            // The place that was passed last: from there a path leads on without a detour.
            let last = person.path[person.next - 1];
            self.footways
                .journey(last, &mut self.noise, &mut person.path);
            person.next = 1;
        }
        if waited {
            person.patience = Patience {
                from: person.position,
                age: 0.0,
            };
        }
    }

    fn acceleration(&self, i: usize, around: Surroundings<'_>) -> [f64; 2] {
        let Surroundings {
            ground,
            robot,
            cars,
            near_cars,
        } = around;
        let person = &self.people[i];
        let body = person.body();
        let heading = person.heading(&self.footways, ground);
        let waits = person.waits(heading, ground, cars, near_cars);
        // A person who waits keeps all repulsions, and is driven towards standing.
        let speed = if waits { 0.0 } else { person.desired };
        let mut sum = social_force::drive(body, heading, speed);
        self.near.near(person.position, |j| {
            if j != i {
                add(
                    &mut sum,
                    social_force::from_body(body, heading, self.people[j].body()),
                );
            }
        });
        add(
            &mut sum,
            social_force::from_body(body, heading, Body::from(*robot)),
        );
        add(
            &mut sum,
            social_force::from_obstacles(ground.clearance(person.position)),
        );
        near_cars.near(person.position, |c| {
            add(&mut sum, social_force::from_car(body, &cars[c]));
        });
        // Repulsions from several sides add up to more than legs can do.
        let size = libm::hypot(sum[0], sum[1]);
        if size > MAX_ACCELERATION {
            sum.map(|v| v * MAX_ACCELERATION / size)
        } else {
            sum
        }
    }

    /// Moves bodies that overlap apart, each by half, and out of the robot and cars.
    fn push_apart(&mut self, around: Surroundings<'_>) {
        let Surroundings {
            ground,
            robot,
            cars,
            near_cars,
        } = around;
        for i in 0..self.people.len() {
            let body = self.people[i].body();
            let mut shift = [0.0; 2];
            self.near.near(body.position, |j| {
                if j != i {
                    // By half, as the other moves by the other half in its own turn. Robot and cars
                    // do not give way.
                    add(&mut shift, push(body, self.people[j].body(), 0.5));
                }
            });
            add(&mut shift, push(body, Body::from(*robot), 1.0));
            near_cars.near(body.position, |c| {
                add(&mut shift, cars[c].way_out(body.position, body.radius));
            });
            let size = libm::hypot(shift[0], shift[1]);
            let scale = if size > MAX_PUSH_M {
                MAX_PUSH_M / size
            } else {
                1.0
            };
            self.people[i].shift(shift.map(|s| s * scale), ground);
        }
    }
}

fn add(sum: &mut [f64; 2], vector: [f64; 2]) {
    sum[0] += vector[0];
    sum[1] += vector[1];
}

/// Shift of `body` by a share of its overlap with `other`, metres; zero if they do not overlap.
fn push(body: Body, other: Body, share: f64) -> [f64; 2] {
    let reach = body.radius + other.radius;
    let (dx, dy) = (
        body.position.x - other.position.x,
        body.position.y - other.position.y,
    );
    let away = libm::hypot(dx, dy);
    // Bodies at one point have no direction in which they part.
    if away < reach && away > 1e-6 {
        let by = share * (reach - away) / away;
        [by * dx, by * dy]
    } else {
        [0.0; 2]
    }
}

impl Person {
    fn new(position: MapPoint, place: u32, footways: &mut WalkGraph, noise: &mut Noise) -> Self {
        let mut path = Vec::with_capacity(256);
        footways.journey(place, noise, &mut path);
        let desired = (1.34 + 0.26 * noise.normal()).clamp(0.7, 2.0);
        Self {
            position,
            velocity: [0.0; 2],
            // A path that begins and ends at one place has no second one.
            yaw: position.bearing_to(footways.point(path[1.min(path.len() - 1)])),
            radius: 0.2 + (PERSON_RADIUS_M - 0.2) * noise.uniform(),
            gait: noise.uniform(),
            desired,
            side: 0.1 + 0.6 * noise.uniform(),
            path,
            next: 1,
            patience: Patience {
                from: position,
                age: 0.0,
            },
        }
    }

    pub fn body(&self) -> Body {
        Body {
            position: self.position,
            velocity: self.velocity,
            radius: self.radius,
        }
    }

    /// Whether the next place is near, and lies beside or behind.
    fn has_passed(&self, footways: &WalkGraph) -> bool {
        let place = footways.point(self.path[self.next]);
        let (dx, dy) = (place.x - self.position.x, place.y - self.position.y);
        let square = dx * dx + dy * dy;
        let after = self
            .path
            .get(self.next + 1)
            .map_or(place, |p| footways.point(*p));
        let ahead = dx * (after.x - place.x) + dy * (after.y - place.y);
        // Within 0.7 m, or within 2 m if going there would mean going back.
        square < 0.5 || (square < 4.0 && ahead < 0.0)
    }

    /// Unit vector along the path to the next place, a little to the right of its middle.
    fn heading(&self, footways: &WalkGraph, ground: &Ground) -> [f64; 2] {
        let Some(&next) = self.path.get(self.next) else {
            return [0.0; 2];
        };
        let (from, to) = (
            footways.point(self.path[self.next - 1]),
            footways.point(next),
        );
        let length = from.distance(to).max(1e-9);
        let along = [(to.x - from.x) / length, (to.y - from.y) / length];
        let right = self.side * (footways.half_width(next) - PERSON_RADIUS_M).max(0.0);
        let aside = MapPoint::new(to.x + along[1] * right, to.y - along[0] * right);
        // Where the side is blocked, people go through the middle.
        let target = if ground.clearance(aside).distance > 0.1 {
            aside
        } else {
            to
        };
        let mut toward = [target.x - self.position.x, target.y - self.position.y];
        let ahead = toward[0] * along[0] + toward[1] * along[1];
        let off = (toward[1] * along[0] - toward[0] * along[1]).abs();
        // A person who is nearly there looks past the place, along the path, so that a push to the
        // side does not turn the head.
        if (0.0..LOOK_AHEAD_M).contains(&ahead) && off < LOOK_AHEAD_M {
            (0..2).for_each(|k| toward[k] += (LOOK_AHEAD_M - ahead) * along[k]);
        }
        // At the target itself the vector fades instead of turning at random.
        let away = libm::hypot(toward[0], toward[1]).max(0.1);
        toward.map(|t| t / away)
    }

    /// The point `distance` metres ahead.
    fn ahead(&self, heading: [f64; 2], distance: f64) -> MapPoint {
        MapPoint::new(
            self.position.x + distance * heading[0],
            self.position.y + distance * heading[1],
        )
    }

    /// Whether a car comes into whose path the person is about to walk, from the kerb or from
    /// between parked cars.
    fn waits(
        &self,
        heading: [f64; 2],
        ground: &Ground,
        cars: &[CarHull],
        near_cars: &Neighbours,
    ) -> bool {
        let at_kerb = !ground.is_road(self.position)
            && (ground.is_road(self.ahead(heading, 0.5))
                || ground.is_road(self.ahead(heading, 1.0)));
        let mut comes = false;
        near_cars.near(self.position, |c| {
            comes |= self.waits_for(&cars[c], heading, at_kerb)
        });
        comes
    }

    /// Whether this car comes and the person is about to walk into its path.
    fn waits_for(&self, car: &CarHull, heading: [f64; 2], at_kerb: bool) -> bool {
        if !car.may_reach(self.position, car.speed * GAP_S) {
            return false;
        }
        let (forward, left) = car.pose.inverse_transform(self.position);
        // Distance ahead of the bumper, in the car's axes.
        let front = forward - car.half_length;
        let far = front > car.speed * GAP_S;
        let passed = front < -2.0 * car.half_length - 0.5;
        if car.speed < 1.0 || far || passed {
            return false;
        }
        let (_, soon) = car.pose.inverse_transform(self.ahead(heading, 1.0));
        let (_, later) = car.pose.inverse_transform(self.ahead(heading, 2.0));
        let beside = left.abs() > car.half_width + self.radius;
        let into = soon.abs() < car.half_width + 0.5 || soon * left < 0.0;
        // A person who is already in the car's path walks on, and out of it.
        (beside && into) || (at_kerb && later.abs() < 4.0)
    }

    fn walk(&mut self, dt: f64, acceleration: [f64; 2], ground: &Ground) {
        (0..2).for_each(|k| self.velocity[k] += acceleration[k] * dt);
        let speed = libm::hypot(self.velocity[0], self.velocity[1]);
        let limit = HURRY * self.desired;
        if speed > limit {
            self.velocity = self.velocity.map(|v| v * limit / speed);
        }
        let before = self.position;
        self.shift(self.velocity.map(|v| v * dt), ground);
        // By the distance really covered: feet do not walk on the spot against a wall.
        let walked = before.distance(self.position);
        self.gait = (self.gait + walked / STRIDE_M).fract();
        if speed > TURNING_SPEED {
            let turn = wrap_angle(libm::atan2(self.velocity[1], self.velocity[0]) - self.yaw);
            self.yaw = wrap_angle(self.yaw + turn.clamp(-MAX_TURN * dt, MAX_TURN * dt));
        }
    }

    /// Moves to where a person fits: by the whole shift, along one axis, or not at all. Components
    /// that are blocked are removed from the velocity.
    fn shift(&mut self, by: [f64; 2], ground: &Ground) {
        for kept in [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]] {
            let to = MapPoint::new(
                self.position.x + if kept[0] > 0.0 { by[0] } else { 0.0 },
                self.position.y + if kept[1] > 0.0 { by[1] } else { 0.0 },
            );
            if ground.fits(to) {
                self.position = to;
                (0..2).for_each(|k| self.velocity[k] *= kept[k]);
                return;
            }
        }
        self.velocity = self.velocity.map(|v| v * 0.0);
    }
}

#[cfg(test)]
impl Pedestrians {
    /// The place of the network nearest to a point.
    pub fn end_at(&self, point: MapPoint) -> u32 {
        self.footways.nearest(point)
    }

    /// Sets a person's desired speed, m/s.
    pub fn pace(&mut self, i: usize, desired: f64) {
        self.people[i].desired = desired;
    }

    /// Puts a person somewhere, with a shortest path to a place.
    pub fn send(&mut self, i: usize, from: MapPoint, to: u32) {
        let near = self.footways.nearest(from);
        let person = &mut self.people[i];
        person.position = from;
        person.velocity = [0.0; 2];
        person.patience = Patience { from, age: 0.0 };
        self.footways.path_to(near, to, &mut person.path);
        person.next = 1;
    }

    /// Moves a person who has passed `x` back by that many metres, towards a place.
    pub fn wrap(&mut self, i: usize, x: f64, back: f64, to: u32) {
        let person = &mut self.people[i];
        if (person.position.x - x) * back > 0.0 {
            let (velocity, at) = (person.velocity, person.position);
            self.send(i, MapPoint::new(at.x - back, at.y), to);
            self.people[i].velocity = velocity;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_bodies_are_pushed_apart_by_half_each() {
        let at = |x: f64| Body {
            position: MapPoint::new(x, 0.0),
            velocity: [0.0; 2],
            radius: 0.25,
        };
        assert_eq!(push(at(0.0), at(0.25), 0.5), [-0.125, 0.0]);
        assert_eq!(push(at(0.0), at(0.5), 0.5), [0.0; 2]);
    }
}
