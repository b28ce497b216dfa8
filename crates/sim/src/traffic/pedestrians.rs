//! People who walk: the social force model.
//!
//! After D. Helbing and P. Molnár, *Social force model for pedestrian dynamics*, Phys. Rev. E 51, 1995 (arXiv cond-mat/9805244):
//!
//! - the drive towards the desired velocity, `(v0 e - v) / tau`;
//! - repulsion between people, minus the gradient of `V0 exp(-b / sigma)`, with the strengths given there; what is not in sight
//!   counts half;
//! - exponential repulsion from walls;
//! - desired speeds are normal, 1.34 m/s with a deviation of 0.26 m/s, and nobody exceeds 1.3 times his own.
//!
//! The semi-minor axis `b` of the ellipse is that of A. Johansson, D. Helbing and P. Shukla, *Specification of the social force
//! pedestrian model by evolutionary adjustment to video tracking data*, Adv. Complex Syst. 10, 2007 (arXiv 0810.4587), from the
//! relative motion: `2 b = sqrt((|d| + |d - y|)² - |y|²)` with `y` the way that the other comes towards us in a while. (In 1995 it
//! was the other's motion alone.) Ours are: the foresight of 1 s, the softer walls, the cars, and that distances are those
//! between rims. Forces alone let bodies overlap in a crowd; what still overlaps after a step is moved apart.
//!
//! Up to about one person a square metre speeds are those of Weidmann's fundamental diagram; denser crowds walk faster than they
//! should (`crowds` tests it).

use openbench_core::MapPoint;
use openbench_core::frames::wrap_angle;

use super::footways::Footways;
use super::ground::Ground;
use super::hull::CarHull;
use super::mover::{PERSON_RADIUS, RobotState};
use super::neighbours::Neighbours;
use crate::noise::Noise;

/// Nobody walks faster than this times the desired speed (Helbing and Molnár).
const HURRY: f64 = 1.3;
/// Largest acceleration, m/s².
const MAX_ACCELERATION: f64 = 4.0;
/// Time in which the desired velocity is taken up, seconds (Helbing and Molnár).
pub(super) const RELAXATION: f64 = 0.5;
/// Repulsion between people: V0 / sigma in m/s², sigma in metres (Helbing and Molnár: V0 = 2.1 m²/s²).
const PEOPLE: (f64, f64) = (2.1 / 0.3, 0.3);
/// Repulsion from obstacles, from the body's rim: m/s² and metres. Weaker than Helbing and Molnár's 10 m²/s² over 0.2 m,
/// which keeps people out of gates.
const OBSTACLES: (f64, f64) = (4.0, 0.2);
/// Repulsion from cars, m/s² and metres; ours.
const CARS: (f64, f64) = (6.0, 0.4);
/// How far ahead the motion of others is seen, seconds.
const FORESIGHT: f64 = 1.0;
/// What happens behind one's back counts this share (Helbing and Molnár's c), which is what lies more than 100 degrees off the
/// desired direction (their 2 phi is 200 degrees): the cosine of that.
const BEHIND: f64 = 0.5;
const BACK: f64 = -0.173_648;
/// How far people see each other: the side of a cell, metres.
pub(super) const SIGHT: f64 = 4.0;
/// Distance at which people look along their way, metres.
const LOOK_AHEAD: f64 = 2.0;
/// Length of a walking cycle, two steps, at usual speed, metres.
pub(super) const STRIDE: f64 = 1.4;
/// Fastest turn of the body, rad/s.
const MAX_TURN: f64 = 4.0;
/// Who moves less than half a metre in this time seeks another goal, seconds.
const PATIENCE: f64 = 5.0;
/// One does not step onto the carriageway before a car that is nearer than this, seconds.
const GAP: f64 = 4.0;

/// A person on a journey.
#[derive(Debug, Clone)]
pub(super) struct Person {
    pub position: MapPoint,
    pub velocity: [f64; 2],
    pub yaw: f64,
    pub radius: f64,
    /// Phase of the walking cycle, 0 to 1.
    pub gait: f64,
    /// How fast the person likes to walk, m/s.
    pub desired: f64,
    /// Share of the way's half width that this person keeps to the right of its middle.
    side: f64,
    way: Vec<u32>,
    next: usize,
    /// Where the person was when patience was last counted anew, and how long ago.
    anchor: (MapPoint, f64),
}

/// Everyone who walks.
#[derive(Debug)]
pub(super) struct Pedestrians {
    pub people: Vec<Person>,
    pub near: Neighbours,
    footways: Footways,
    noise: Noise,
    accelerations: Vec<[f64; 2]>,
}

impl Pedestrians {
    /// Up to `count` people on the ways, none within 3 m of `start`.
    pub fn new(
        footways: Footways,
        ground: &Ground,
        count: usize,
        start: MapPoint,
        mut noise: Noise,
    ) -> Self {
        let near = Neighbours::new(SIGHT);
        let mut all = Self {
            people: Vec::new(),
            near,
            footways,
            noise: noise.clone(),
            accelerations: vec![],
        };
        let tries = if all.footways.is_empty() {
            0
        } else {
            20 * count
        };
        for _ in 0..tries {
            if all.people.len() == count {
                break;
            }
            let place = all.footways.draw(&mut noise);
            let (along, across) = (noise.uniform() - 0.5, noise.uniform() - 0.5);
            let middle = all.footways.point(place);
            let at = MapPoint::new(middle.x + along, middle.y + across);
            let crowded = all.people.iter().any(|p| p.position.distance(at) < 0.6);
            if !crowded && at.distance(start) > 3.0 && ground.fits(at) && ground.sees(at, middle) {
                let person = Person::new(at, place, &mut all.footways, &mut noise);
                all.people.push(person);
            }
        }
        all.noise = noise;
        all.accelerations = vec![[0.0; 2]; all.people.len()];
        all.look_round();
        all
    }

    /// Notes where everyone is.
    pub fn look_round(&mut self) {
        self.near.fill(self.people.iter().map(|p| Some(p.position)));
    }

    /// Moves everyone by `dt` seconds. [`near`](Self::near) must be as of now.
    pub fn step(
        &mut self,
        dt: f64,
        ground: &Ground,
        robot: &RobotState,
        cars: (&[CarHull], &Neighbours),
    ) {
        for i in 0..self.people.len() {
            self.find_way(i, dt);
        }
        for i in 0..self.people.len() {
            self.accelerations[i] = self.acceleration(i, ground, robot, cars);
        }
        for (person, acceleration) in self.people.iter_mut().zip(&self.accelerations) {
            person.walk(dt, *acceleration, ground);
        }
        self.look_round();
        self.part(ground, robot, cars);
    }

    /// Passes places that were reached; seeks a new goal at the end of the way or when patience is.
    fn find_way(&mut self, i: usize, dt: f64) {
        let person = &mut self.people[i];
        while person.next < person.way.len() && person.has_passed(&self.footways) {
            person.next += 1;
        }
        person.anchor.1 += dt;
        let stuck = person.anchor.1 > PATIENCE && person.anchor.0.distance(person.position) < 0.5;
        if person.next == person.way.len() || stuck {
            let last = person.way[person.next - 1];
            self.footways
                .journey(last, &mut self.noise, &mut person.way);
            person.next = 1;
        }
        if person.anchor.1 > PATIENCE {
            person.anchor = (person.position, 0.0);
        }
    }

    fn acceleration(
        &self,
        i: usize,
        ground: &Ground,
        robot: &RobotState,
        (cars, near_cars): (&[CarHull], &Neighbours),
    ) -> [f64; 2] {
        let person = &self.people[i];
        let toward = person.direction(&self.footways, ground);
        let waits = person.waits(toward, ground, cars, near_cars);
        let speed = if waits { 0.0 } else { person.desired };
        // The drive: (v0 e - v) / tau.
        let mut sum = [0, 1].map(|k| (speed * toward[k] - person.velocity[k]) / RELAXATION);
        let mut add = |force: [f64; 2]| (0..2).for_each(|k| sum[k] += force[k]);
        self.near.near(person.position, |j| {
            let other = &self.people[j];
            if j != i {
                add(person.repulsion(toward, other.position, other.velocity, other.radius));
            }
        });
        add(person.repulsion(toward, robot.position, robot.velocity, robot.radius));
        let (clearance, slope) = ground.clearance(person.position);
        let strength = OBSTACLES.0 * libm::exp(-clearance / OBSTACLES.1);
        add(slope.map(|s| strength * s));
        near_cars.near(person.position, |c| add(person.car_repulsion(&cars[c])));
        let size = libm::hypot(sum[0], sum[1]);
        if size > MAX_ACCELERATION {
            sum.map(|v| v * MAX_ACCELERATION / size)
        } else {
            sum
        }
    }

    /// Moves bodies apart that overlap, each by half, and out of the robot and cars.
    fn part(
        &mut self,
        ground: &Ground,
        robot: &RobotState,
        (cars, near_cars): (&[CarHull], &Neighbours),
    ) {
        for _ in 0..3 {
            for i in 0..self.people.len() {
                let (position, radius) = (self.people[i].position, self.people[i].radius);
                let people = &self.people;
                let mut shift = [0.0; 2];
                let mut push = |center: MapPoint, reach: f64, share: f64| {
                    let (dx, dy) = (position.x - center.x, position.y - center.y);
                    let away = libm::hypot(dx, dy);
                    if away < reach && away > 1e-6 {
                        let by = share * (reach - away) / away;
                        (shift[0], shift[1]) = (shift[0] + by * dx, shift[1] + by * dy);
                    }
                };
                self.near.near(position, |j| {
                    if j != i {
                        push(people[j].position, radius + people[j].radius, 0.5);
                    }
                });
                push(robot.position, radius + robot.radius, 1.0);
                near_cars.near(position, |c| {
                    let out = cars[c].way_out(position, radius);
                    (shift[0], shift[1]) = (shift[0] + out[0], shift[1] + out[1]);
                });
                // A jostle is slow: the way out of a jam takes a few steps.
                let size = libm::hypot(shift[0], shift[1]);
                let scale = if size > 0.1 { 0.1 / size } else { 1.0 };
                self.people[i].shift(shift.map(|s| s * scale), ground);
            }
        }
    }
}

impl Person {
    fn new(position: MapPoint, place: u32, footways: &mut Footways, noise: &mut Noise) -> Self {
        let mut way = Vec::with_capacity(256);
        footways.journey(place, noise, &mut way);
        let desired = (1.34 + 0.26 * noise.normal()).clamp(0.7, 2.0);
        Self {
            position,
            velocity: [0.0; 2],
            yaw: position.bearing_to(footways.point(way[1.min(way.len() - 1)])),
            radius: 0.2 + (PERSON_RADIUS - 0.2) * noise.uniform(),
            gait: noise.uniform(),
            desired,
            side: 0.1 + 0.6 * noise.uniform(),
            way,
            next: 1,
            anchor: (position, 0.0),
        }
    }

    /// Whether the next place lies beside or behind, and near.
    fn has_passed(&self, footways: &Footways) -> bool {
        let place = footways.point(self.way[self.next]);
        let (dx, dy) = (place.x - self.position.x, place.y - self.position.y);
        let square = dx * dx + dy * dy;
        let after = self
            .way
            .get(self.next + 1)
            .map_or(place, |p| footways.point(*p));
        let ahead = dx * (after.x - place.x) + dy * (after.y - place.y);
        square < 0.5 || (square < 4.0 && ahead < 0.0)
    }

    /// Unit vector along the way to the next place, a little to the right of its middle.
    fn direction(&self, footways: &Footways, ground: &Ground) -> [f64; 2] {
        let Some(&next) = self.way.get(self.next) else {
            return [0.0; 2];
        };
        let (from, to) = (
            footways.point(self.way[self.next - 1]),
            footways.point(next),
        );
        let length = from.distance(to).max(1e-9);
        let along = [(to.x - from.x) / length, (to.y - from.y) / length];
        let right = self.side * (footways.half_width(next) - PERSON_RADIUS).max(0.0);
        let aside = MapPoint::new(to.x + along[1] * right, to.y - along[0] * right);
        let target = if ground.clearance(aside).0 > 0.1 {
            aside
        } else {
            to
        };
        let mut toward = [target.x - self.position.x, target.y - self.position.y];
        let ahead = toward[0] * along[0] + toward[1] * along[1];
        let off = (toward[1] * along[0] - toward[0] * along[1]).abs();
        // Who is nearly there looks past the place, along the way, so that what pushes aside does not turn the head.
        if (0.0..LOOK_AHEAD).contains(&ahead) && off < LOOK_AHEAD {
            (0..2).for_each(|k| toward[k] += (LOOK_AHEAD - ahead) * along[k]);
        }
        let away = libm::hypot(toward[0], toward[1]).max(0.1);
        toward.map(|t| t / away)
    }

    /// Whether a car comes whose way the person is about to walk into: from the kerb, or from between parked cars.
    fn waits(
        &self,
        toward: [f64; 2],
        ground: &Ground,
        cars: &[CarHull],
        near_cars: &Neighbours,
    ) -> bool {
        let ahead = |d: f64| {
            MapPoint::new(
                self.position.x + d * toward[0],
                self.position.y + d * toward[1],
            )
        };
        let at_kerb = !ground.is_road(self.position)
            && (ground.is_road(ahead(0.5)) || ground.is_road(ahead(1.0)));
        let (soon, later) = (ahead(1.0), ahead(2.0));
        let mut comes = false;
        near_cars.near(self.position, |c| {
            let car = &cars[c];
            if !car.is_within(self.position, car.speed * GAP) {
                return;
            }
            let (forward, left) = car.pose.inverse_transform(self.position);
            let front = forward - car.half[0];
            if car.speed < 1.0 || front > car.speed * GAP || front < -2.0 * car.half[0] - 0.5 {
                return;
            }
            let aside = |p: MapPoint| car.pose.inverse_transform(p).1;
            let beside = left.abs() > car.half[1] + self.radius;
            let into = aside(soon).abs() < car.half[1] + 0.5 || aside(soon) * left < 0.0;
            comes |= (beside && into) || (at_kerb && aside(later).abs() < 4.0);
        });
        comes
    }

    /// Repulsion from a body at `center` of another's `velocity`: minus the gradient of `V0 exp(-b / sigma)`, which is
    /// `V0 / sigma exp(-b / sigma) (|d| + |d - y|) / (4 b) (d / |d| + (d - y) / |d - y|)`. In the exponent stands the distance
    /// between rims plus one usual diameter, so that wide bodies keep wider apart.
    fn repulsion(
        &self,
        toward: [f64; 2],
        center: MapPoint,
        velocity: [f64; 2],
        radius: f64,
    ) -> [f64; 2] {
        let d = [self.position.x - center.x, self.position.y - center.y];
        let away = libm::hypot(d[0], d[1]);
        if !(1e-6..=SIGHT).contains(&away) {
            return [0.0; 2];
        }
        // The way that the other will have come towards us.
        let y = [0, 1].map(|k| (velocity[k] - self.velocity[k]) * FORESIGHT);
        let e = [d[0] - y[0], d[1] - y[1]];
        let later = libm::hypot(e[0], e[1]).max(1e-6);
        let sum = away + later;
        let b = (sum * sum - y[0] * y[0] - y[1] * y[1]).max(0.04).sqrt() / 2.0;
        let rims = b - (self.radius + radius - 2.0 * PERSON_RADIUS);
        let in_sight = -(d[0] * toward[0] + d[1] * toward[1]) >= BACK * away;
        let seen = if in_sight { 1.0 } else { BEHIND };
        let strength = seen * (PEOPLE.0 * libm::exp(-rims / PEOPLE.1) * sum / (4.0 * b)).min(8.0);
        [0, 1].map(|k| strength * (d[k] / away + e[k] / later))
    }

    /// Repulsion from a car and from where it will be in a second.
    fn car_repulsion(&self, car: &CarHull) -> [f64; 2] {
        // Further off the force is below 1 % of an acceleration that matters.
        if !car.is_within(self.position, car.speed * FORESIGHT + 6.0 * CARS.1) {
            return [0.0; 2];
        }
        let near = car.nearest(self.position, car.speed * FORESIGHT);
        let (dx, dy) = (self.position.x - near.x, self.position.y - near.y);
        let away = libm::hypot(dx, dy).max(1e-6);
        let strength = CARS.0 * libm::exp(-(away - self.radius) / CARS.1);
        [dx / away * strength, dy / away * strength]
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
        let walked = before.distance(self.position);
        self.gait = (self.gait + walked / STRIDE).fract();
        if speed > 0.15 {
            let turn = wrap_angle(libm::atan2(self.velocity[1], self.velocity[0]) - self.yaw);
            self.yaw = wrap_angle(self.yaw + turn.clamp(-MAX_TURN * dt, MAX_TURN * dt));
        }
    }

    /// Moves to where a person fits: there, or along one axis, or not at all. What cannot be walked is taken out of the velocity.
    fn shift(&mut self, by: [f64; 2], ground: &Ground) {
        let to = |x: f64, y: f64| MapPoint::new(self.position.x + x, self.position.y + y);
        let tries = [
            (to(by[0], by[1]), [1.0, 1.0]),
            (to(by[0], 0.0), [1.0, 0.0]),
            (to(0.0, by[1]), [0.0, 1.0]),
        ];
        let (position, kept) = tries
            .into_iter()
            .find(|(p, _)| ground.fits(*p))
            .unwrap_or((self.position, [0.0; 2]));
        self.position = position;
        (0..2).for_each(|k| self.velocity[k] *= kept[k]);
    }
}

#[cfg(test)]
impl Pedestrians {
    /// The place of the network nearest to a point.
    pub fn end_at(&self, point: MapPoint) -> u32 {
        self.footways.nearest(point)
    }

    /// Lets a person want to walk that fast, m/s.
    pub fn pace(&mut self, i: usize, desired: f64) {
        self.people[i].desired = desired;
    }

    /// Puts a person somewhere, with a straight way to a place.
    pub fn send(&mut self, i: usize, from: MapPoint, to: u32) {
        let near = self.footways.nearest(from);
        let person = &mut self.people[i];
        person.position = from;
        person.velocity = [0.0; 2];
        person.anchor = (from, 0.0);
        self.footways.way_to(near, to, &mut person.way);
        person.next = 1;
    }

    /// Who has passed `x` goes on so many metres further back, towards a place.
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

    fn person(velocity: [f64; 2]) -> Person {
        Person {
            position: MapPoint::default(),
            velocity,
            yaw: 0.0,
            radius: PERSON_RADIUS,
            gait: 0.0,
            desired: 1.3,
            side: 0.0,
            way: vec![],
            next: 0,
            anchor: (MapPoint::default(), 0.0),
        }
    }

    /// `V0 exp(-b / sigma)` at `d` from somebody who moves with the `relative` velocity.
    fn potential(d: [f64; 2], relative: [f64; 2]) -> f64 {
        let (x, y) = (
            d[0] - relative[0] * FORESIGHT,
            d[1] - relative[1] * FORESIGHT,
        );
        let sum = libm::hypot(d[0], d[1]) + libm::hypot(x, y);
        let way = libm::hypot(relative[0], relative[1]) * FORESIGHT;
        PEOPLE.0 * PEOPLE.1 * libm::exp(-(sum * sum - way * way).sqrt() / 2.0 / PEOPLE.1)
    }

    #[test]
    fn people_repel_each_other_down_the_slope_of_the_potential() {
        for (d, other) in [
            ([-1.0, 0.3], [-0.4, 0.1]),
            ([-0.7, -0.6], [0.3, 1.2]),
            ([-1.6, 0.1], [-1.3, 0.0]),
        ] {
            let own = [0.5, 0.2];
            let center = MapPoint::new(-d[0], -d[1]);
            let force = person(own).repulsion([1.0, 0.0], center, other, PERSON_RADIUS);
            let relative = [other[0] - own[0], other[1] - own[1]];
            let h = 1e-5;
            let slope = [[h, 0.0], [0.0, h]].map(|s| {
                let at = |sign: f64| potential([d[0] + sign * s[0], d[1] + sign * s[1]], relative);
                (at(1.0) - at(-1.0)) / (2.0 * h)
            });
            for k in 0..2 {
                assert!(
                    (force[k] + slope[k]).abs() < 1e-6 * (1.0 + force[k].abs()),
                    "{force:?} {slope:?}"
                );
            }
        }
    }

    #[test]
    fn what_is_behind_counts_half() {
        let force = |x: f64| {
            person([0.0; 2]).repulsion([1.0, 0.0], MapPoint::new(x, 0.0), [0.0; 2], 0.25)[0]
        };
        assert!(force(1.0) < 0.0 && (force(-1.0) + BEHIND * force(1.0)).abs() < 1e-12);
    }
}
