//! Cars: along their lanes behind each other, through junctions one after the other, and never over people.
//!
//! Accelerations by the intelligent driver model (M. Treiber, A. Hennecke and D. Helbing, *Congested traffic states in
//! empirical observations and microscopic simulations*, Phys. Rev. E 62, 2000, arXiv cond-mat/0002177), with exponent 4 and without
//! its term of the square root of speed, as usual; the numbers are ours, for streets rather than motorways. A person or the robot on
//! the lane ahead, or about to step onto it, is a leader that stands or walks. A turn at a junction must be had before it is entered:
//! turns that meet are not had by two cars at once, who has waited longer goes first, and nobody enters who cannot leave.
//! Where a lane ends cars leave, and come in again elsewhere, both out of the robot's sight.

use openbench_core::MapPoint;

use super::ground::Ground;
use super::hull::CarHull;
use super::lanes::{HALF, Lanes, slowing};
use super::mover::RobotState;
use super::neighbours::Neighbours;
use super::pedestrians::Pedestrians;
use crate::noise::Noise;

/// Largest acceleration and comfortable deceleration, m/s².
const ACCELERATION: f64 = 1.5;
const COMFORTABLE: f64 = 2.0;
/// Hardest braking, m/s²: dry asphalt.
pub(super) const HARDEST: f64 = 8.0;
/// Time behind the car ahead, seconds, and distance to it at rest, metres.
const HEADWAY: f64 = 1.2;
const AT_REST: f64 = 1.5;
/// The middle of a lane is free of people for half a car and this, metres.
const ASIDE: f64 = 0.35;
/// Who will be on the lane within this time is yielded to, seconds, if walking towards it faster than this, m/s.
const ABOUT_TO: (f64, f64) = (1.5, 0.4);
/// The robot sees a car that is nearer than this unless something stands between, metres: the reach of its LiDAR.
const IN_SIGHT: f64 = 50.0;
/// A car that has stood this long leaves as soon as nobody sees it, seconds.
const PATIENCE: f64 = 60.0;
/// Free lane that a car needs to come in, metres.
const ENTRY_ROOM: f64 = 18.0;
/// Side of the cells in which people look for cars, metres.
pub(super) const SIGHT: f64 = 40.0;

/// A car.
#[derive(Debug, Clone)]
pub(super) struct Car {
    /// Which lane or turn its middle is on, and how far along, metres.
    piece: u32,
    s: f64,
    pub speed: f64,
    /// The turn after this lane.
    turn: Option<u32>,
    has_turn: bool,
    /// The turn behind that the tail is still on.
    leaves: Option<u32>,
    /// Seconds without moving.
    stands: f64,
    pub present: bool,
    /// Seconds until it wants to come in.
    away: f64,
}

/// All cars.
#[derive(Debug)]
pub(super) struct Cars {
    pub cars: Vec<Car>,
    pub hulls: Vec<CarHull>,
    pub near: Neighbours,
    lanes: Lanes,
    entries: Vec<u32>,
    noise: Noise,
    /// Cars by piece and place on it.
    order: Vec<u32>,
    /// For each piece: how many have it, the longest time that one waits for it, and room before its last car.
    had: Vec<u32>,
    wait: Vec<f64>,
    room: Vec<f64>,
    accelerations: Vec<f64>,
}

/// Something ahead: the free distance to it, metres, and its speed along the lane, m/s.
#[derive(Debug, Clone, Copy)]
struct Leader {
    gap: f64,
    speed: f64,
}

impl Cars {
    /// `count` cars, none within 12 m of `start` or 4 m of a person; none at all without a lane. Those that find no place
    /// wait outside.
    pub fn new(
        lanes: Lanes,
        count: usize,
        start: MapPoint,
        people: &Pedestrians,
        noise: Noise,
    ) -> Self {
        let entry = |k: &u32| lanes.pieces[*k as usize].is_entry;
        let mut entries: Vec<u32> = (0..lanes.lanes as u32).filter(entry).collect();
        if entries.is_empty() {
            entries = (0..lanes.lanes as u32).collect();
        }
        let pieces = lanes.pieces.len();
        let mut all = Self {
            cars: Vec::new(),
            hulls: Vec::new(),
            near: Neighbours::new(SIGHT),
            entries,
            noise,
            order: Vec::new(),
            had: vec![0; pieces],
            wait: vec![0.0; pieces],
            room: vec![0.0; pieces],
            accelerations: vec![0.0; count],
            lanes,
        };
        for _ in 0..if all.lanes.lanes == 0 { 0 } else { count } {
            let car = all.place(start, people);
            all.cars.push(car);
        }
        all.accelerations.truncate(all.cars.len());
        all.order = (0..all.cars.len() as u32).collect();
        let outside = CarHull::default();
        all.hulls = vec![outside; all.cars.len()];
        all.look_round();
        all
    }

    /// A car at a place drawn from all lanes.
    fn place(&mut self, start: MapPoint, people: &Pedestrians) -> Car {
        let lanes = &self.lanes.pieces[..self.lanes.lanes];
        let whole: f64 = lanes.iter().map(|p| p.length).sum();
        let mut car = Car {
            piece: 0,
            s: 0.0,
            speed: 0.0,
            turn: None,
            has_turn: false,
            leaves: None,
            stands: 0.0,
            present: false,
            away: 5.0 * self.noise.uniform(),
        };
        for _ in 0..40 {
            let mut run = self.noise.uniform() * whole;
            let Some(k) = lanes.iter().position(|p| {
                run -= p.length;
                run < 0.0
            }) else {
                continue;
            };
            let s = run + lanes[k].length;
            let inside = s > HALF[0] + 1.0 && s < lanes[k].length - HALF[0] - 3.0;
            let alone = |c: &Car| !c.present || c.piece != k as u32 || (c.s - s).abs() > 10.0;
            let at = lanes[k].pose(s).point();
            let clear = people.people.iter().all(|p| p.position.distance(at) > 4.0);
            if inside && clear && at.distance(start) > 12.0 && self.cars.iter().all(alone) {
                (car.piece, car.s, car.present) = (k as u32, s, true);
                car.speed = 0.5 * lanes[k].speed(s);
                car.turn = draw(&lanes[k].next, &mut self.noise);
                break;
            }
        }
        car
    }

    /// Moves all cars by `dt` seconds.
    pub fn step(&mut self, dt: f64, ground: &Ground, robot: &RobotState, people: &Pedestrians) {
        self.sort();
        self.give_turns(dt);
        for i in 0..self.cars.len() {
            if self.cars[i].present {
                self.accelerations[i] = self.acceleration(i, ground, robot, people);
            }
        }
        for i in 0..self.cars.len() {
            if self.cars[i].present {
                self.drive(i, dt, ground, robot);
            } else {
                self.come_in(i, dt, ground, robot, people);
            }
        }
        self.look_round();
    }

    fn look_round(&mut self) {
        for (car, hull) in self.cars.iter().zip(&mut self.hulls) {
            let piece = &self.lanes.pieces[car.piece as usize];
            *hull = CarHull {
                pose: piece.pose(car.s),
                half: HALF,
                speed: car.speed,
            };
        }
        let present = self
            .cars
            .iter()
            .zip(&self.hulls)
            .map(|(c, h)| c.present.then(|| h.pose.point()));
        self.near.fill(present);
    }

    /// Sorts cars by piece and place, those outside last, and measures the room before the last car of each piece.
    fn sort(&mut self) {
        let (cars, pieces) = (&self.cars, &self.lanes.pieces);
        let key = |i: &u32| (!cars[*i as usize].present, cars[*i as usize].piece);
        self.order.sort_unstable_by(|a, b| {
            let by_place = || cars[*a as usize].s.total_cmp(&cars[*b as usize].s);
            key(a).cmp(&key(b)).then_with(by_place).then(a.cmp(b))
        });
        self.room
            .iter_mut()
            .zip(pieces)
            .for_each(|(room, piece)| *room = piece.length + 3.0);
        for &i in self.order.iter().rev() {
            let car = &cars[i as usize];
            if car.present {
                self.room[car.piece as usize] = car.s - HALF[0];
            }
        }
    }

    /// Lets cars that are near their turn have it: who waits longer first.
    fn give_turns(&mut self, dt: f64) {
        self.wait.fill(0.0);
        for car in self.cars.iter().filter(|c| c.present && !c.has_turn) {
            if let Some(turn) = car.turn {
                self.wait[turn as usize] = self.wait[turn as usize].max(car.stands);
            }
        }
        for i in 0..self.cars.len() {
            let car = &self.cars[i];
            let piece = &self.lanes.pieces[car.piece as usize];
            let near =
                piece.length - car.s - HALF[0] < car.speed * car.speed / 3.0 + car.speed + 3.0;
            let (Some(turn), true) = (car.turn, car.present && !car.has_turn && near) else {
                continue;
            };
            // The first of those that wait asks; the others are behind it.
            let goes = self.is_first(i) && self.may_turn(turn, car.stands);
            if goes {
                self.had[turn as usize] += 1;
                self.cars[i].has_turn = true;
            }
        }
        self.cars
            .iter_mut()
            .for_each(|c| c.stands = if c.speed < 0.1 { c.stands + dt } else { 0.0 });
    }

    /// Whether no car is between this one and the end of its lane.
    fn is_first(&self, i: usize) -> bool {
        self.ahead_on_piece(i).is_none_or(|j| self.cars[j].has_turn)
    }

    fn may_turn(&self, turn: u32, waited: f64) -> bool {
        let piece = &self.lanes.pieces[turn as usize];
        let mut others = piece.conflicts.iter().map(|c| *c as usize);
        let out = piece.next[0] as usize;
        let room = f64::from(self.had[turn as usize] + 1) * (2.0 * HALF[0] + AT_REST);
        self.room[out] >= room && others.all(|c| self.had[c] == 0 && self.wait[c] <= waited + 2.0)
    }

    /// The next car on the same piece.
    fn ahead_on_piece(&self, i: usize) -> Option<usize> {
        let car = &self.cars[i];
        let key = |j: u32| {
            let c = &self.cars[j as usize];
            (!c.present, c.piece)
        };
        let after = |j: &u32| {
            let c = &self.cars[*j as usize];
            key(*j)
                .cmp(&(false, car.piece))
                .then(c.s.total_cmp(&car.s))
                .then(j.cmp(&(i as u32)))
                .is_le()
        };
        let next = *self.order.get(self.order.partition_point(after))?;
        (key(next) == (false, car.piece)).then_some(next as usize)
    }

    /// The last car on a piece.
    fn last_on(&self, piece: u32) -> Option<usize> {
        let before = |j: &u32| {
            let c = &self.cars[*j as usize];
            (!c.present, c.piece) < (false, piece)
        };
        let first = *self.order.get(self.order.partition_point(before))? as usize;
        (self.cars[first].present && self.cars[first].piece == piece).then_some(first)
    }

    fn acceleration(
        &self,
        i: usize,
        ground: &Ground,
        robot: &RobotState,
        people: &Pedestrians,
    ) -> f64 {
        let car = &self.cars[i];
        let piece = &self.lanes.pieces[car.piece as usize];
        let left = piece.length - car.s;
        let next = self.next_piece(car);
        let mut limit = piece.speed(car.s);
        let mut worst = f64::INFINITY;
        let mut mind = |leader: Leader| worst = worst.min(behind(car.speed, limit, leader));
        match next {
            Some(next) if car.has_turn || car.piece as usize >= self.lanes.lanes => {
                limit = limit.min(slowing(self.lanes.pieces[next as usize].speed(0.0), left));
            }
            None if is_hidden(ground, robot, piece.pose(car.s).point()) => {}
            // The line before a turn that others have, or the end of the road.
            _ => mind(Leader {
                gap: left - HALF[0] + AT_REST - 0.2,
                speed: 0.0,
            }),
        }
        let mut mind = |leader: Leader| worst = worst.min(behind(car.speed, limit, leader));
        if let Some(leader) = self.leader(i) {
            mind(leader);
        }
        self.in_the_way(car, robot, people, mind);
        worst
            .min(free(car.speed, limit))
            .clamp(-HARDEST, ACCELERATION)
    }

    fn next_piece(&self, car: &Car) -> Option<u32> {
        let on_turn = car.piece as usize >= self.lanes.lanes;
        if on_turn {
            Some(self.lanes.pieces[car.piece as usize].next[0])
        } else {
            car.turn
        }
    }

    /// The car ahead on this piece or the next two.
    fn leader(&self, i: usize) -> Option<Leader> {
        let car = &self.cars[i];
        let length = 2.0 * HALF[0];
        let leader = |j: usize, run: f64| Leader {
            gap: run - length,
            speed: self.cars[j].speed,
        };
        if let Some(j) = self.ahead_on_piece(i) {
            return Some(leader(j, self.cars[j].s - car.s));
        }
        let mut run = self.lanes.pieces[car.piece as usize].length - car.s;
        let mut next = self.next_piece(car);
        for _ in 0..3 {
            let piece = next?;
            if let Some(j) = self.last_on(piece).filter(|j| *j != i) {
                return Some(leader(j, run + self.cars[j].s));
            }
            run += self.lanes.pieces[piece as usize].length;
            next = (piece as usize >= self.lanes.lanes)
                .then(|| self.lanes.pieces[piece as usize].next[0]);
        }
        None
    }

    /// People and the robot on the lane ahead, or about to be.
    fn in_the_way(
        &self,
        car: &Car,
        robot: &RobotState,
        people: &Pedestrians,
        mut mind: impl FnMut(Leader),
    ) {
        let range = car.speed * car.speed / (2.0 * COMFORTABLE) + 2.0 * car.speed + 8.0;
        let (mut piece, mut s) = (car.piece, car.s);
        let mut run = 0.0;
        while run < range + HALF[0] {
            let here = &self.lanes.pieces[piece as usize];
            let pose = here.pose(s);
            let (sin, cos) = libm::sincos(pose.yaw);
            let mut look = |position: MapPoint, velocity: [f64; 2], radius: f64| {
                let (dx, dy) = (position.x - pose.x, position.y - pose.y);
                let (forward, left) = (cos * dx + sin * dy, cos * dy - sin * dx);
                if !(-0.8..=0.8).contains(&forward) || left.abs() > 4.0 {
                    return;
                }
                let across = cos * velocity[1] - sin * velocity[0];
                let gap = run + forward - HALF[0] - radius;
                // Who is beside the front is passed; who touches it stops the car.
                let touches = left.abs() < HALF[1] + radius;
                if touches || (gap > -0.5 && is_in_the_way(left, across, radius)) {
                    mind(Leader {
                        gap,
                        speed: (cos * velocity[0] + sin * velocity[1]).max(0.0),
                    });
                }
            };
            people.near.near(pose.point(), |j| {
                let person = &people.people[j];
                look(person.position, person.velocity, person.radius);
            });
            look(robot.position, robot.velocity, robot.radius);
            (run, s) = (run + 1.5, s + 1.5);
            if s > here.length {
                s -= here.length;
                let on_turn = piece as usize >= self.lanes.lanes;
                let next = if on_turn {
                    Some(here.next[0])
                } else {
                    car.turn.filter(|_| piece == car.piece)
                };
                let Some(next) = next else { return };
                piece = next;
            }
        }
    }

    fn drive(&mut self, i: usize, dt: f64, ground: &Ground, robot: &RobotState) {
        let car = &mut self.cars[i];
        car.speed = (car.speed + self.accelerations[i] * dt).max(0.0);
        car.s += car.speed * dt;
        let piece = &self.lanes.pieces[car.piece as usize];
        if car.leaves.is_some() && car.s > HALF[0] + 0.5 {
            car.leaves
                .take()
                .into_iter()
                .for_each(|turn| self.had[turn as usize] -= 1);
        }
        let hidden = |s: f64| is_hidden(ground, robot, piece.pose(s).point());
        let tired = car.stands > PATIENCE && hidden(car.s);
        let gone =
            car.turn.is_none() && (car.piece as usize) < self.lanes.lanes && car.s >= piece.length;
        if tired || (gone && hidden(piece.length)) {
            self.leave(i);
        } else if car.s >= piece.length {
            self.enter_next(i);
        }
    }

    fn enter_next(&mut self, i: usize) {
        let car = &mut self.cars[i];
        let piece = &self.lanes.pieces[car.piece as usize];
        let on_turn = car.piece as usize >= self.lanes.lanes;
        let over = car.s - piece.length;
        let next = if on_turn {
            Some(piece.next[0])
        } else {
            car.turn.filter(|_| car.has_turn)
        };
        let Some(next) = next else {
            // Pressed over the line: it stands there.
            (car.s, car.speed) = (piece.length, 0.0);
            return;
        };
        if on_turn {
            // On a lane so short that the tail is still on the turn before, that one is given up late but surely.
            car.leaves
                .replace(car.piece)
                .into_iter()
                .for_each(|turn| self.had[turn as usize] -= 1);
            car.turn = draw(&self.lanes.pieces[next as usize].next, &mut self.noise);
            car.has_turn = false;
        }
        (car.piece, car.s) = (next, over);
    }

    fn leave(&mut self, i: usize) {
        let car = &mut self.cars[i];
        let on_turn = car.piece as usize >= self.lanes.lanes;
        let held = if on_turn {
            Some(car.piece)
        } else {
            car.turn.filter(|_| car.has_turn)
        };
        held.into_iter()
            .chain(car.leaves.take())
            .for_each(|turn| self.had[turn as usize] -= 1);
        (car.present, car.has_turn, car.turn, car.stands, car.speed) =
            (false, false, None, 0.0, 0.0);
        car.away = 2.0 + 10.0 * self.noise.uniform();
    }

    fn come_in(
        &mut self,
        i: usize,
        dt: f64,
        ground: &Ground,
        robot: &RobotState,
        people: &Pedestrians,
    ) {
        self.cars[i].away -= dt;
        if self.cars[i].away > 0.0 {
            return;
        }
        // Tried again a little later, elsewhere.
        self.cars[i].away = 0.5;
        let Some(entry) = draw(&self.entries, &mut self.noise) else {
            return;
        };
        let piece = &self.lanes.pieces[entry as usize];
        let pose = piece.pose(0.0);
        let mut clear = self.room[entry as usize] >= ENTRY_ROOM.min(piece.length);
        people.near.near(pose.point(), |_| clear = false);
        clear &= self.hulls.iter().zip(&self.cars).all(|(h, c)| {
            !c.present || h.pose.point().distance(pose.point()) > 2.0 * HALF[0] + AT_REST
        });
        if clear && is_hidden(ground, robot, pose.point()) {
            let car = &mut self.cars[i];
            (car.piece, car.s, car.present, car.has_turn) = (entry, 0.0, true, false);
            car.speed = 0.6 * piece.speed(0.0);
            car.turn = draw(&piece.next, &mut self.noise);
            // No second one in the same instant, nor before it in the order of this one.
            self.room[entry as usize] = 0.0;
            self.hulls[i] = CarHull {
                pose,
                half: HALF,
                speed: car.speed,
            };
        }
    }
}

/// Whether the robot cannot see a car at `point`.
fn is_hidden(ground: &Ground, robot: &RobotState, point: MapPoint) -> bool {
    robot.position.distance(point) > IN_SIGHT || !ground.sees(robot.position, point)
}

/// Whether a body `left` metres beside the middle of the lane that moves leftwards at `across` m/s is on it or about to be.
fn is_in_the_way(left: f64, across: f64, radius: f64) -> bool {
    let half = HALF[1] + ASIDE + radius;
    let later = left + across * ABOUT_TO.0;
    let enters = across.abs() > ABOUT_TO.1 && across * left < 0.0;
    left.abs() < half || (enters && (later.abs() < half || later * left < 0.0))
}

/// Without a leader: `a (1 - (v / v0)^4)`; above the limit a brisk return to it, which is ours.
fn free(speed: f64, limit: f64) -> f64 {
    if speed > limit {
        return ((limit - speed) / 0.5).max(-COMFORTABLE * 1.5);
    }
    let share = speed / limit.max(0.1);
    ACCELERATION * (1.0 - share * share * share * share)
}

/// Behind a leader: `a (1 - (v / v0)^4 - (s* / s)²)` with `s* = s0 + v T + v dv / (2 sqrt(a b))`. The sum of the last two terms
/// is kept from falling below zero (as in M. Treiber and A. Kesting, *Traffic Flow Dynamics*, 2013): nobody brakes for one who drives away.
fn behind(speed: f64, limit: f64, leader: Leader) -> f64 {
    let approach = speed * (speed - leader.speed) / (2.0 * (ACCELERATION * COMFORTABLE).sqrt());
    let desired = AT_REST + (speed * HEADWAY + approach).max(0.0);
    let share = desired / leader.gap.max(0.05);
    free(speed, limit) - ACCELERATION * share * share
}

fn draw(choices: &[u32], noise: &mut Noise) -> Option<u32> {
    let i = (noise.uniform() * choices.len() as f64) as usize;
    choices.get(i).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behind_a_steady_leader_the_gap_is_that_of_the_equilibrium() {
        // (s0 + v T) / sqrt(1 - (v / v0)^4) at half the limit.
        let gap = (AT_REST + 5.0 * HEADWAY) / (1.0_f64 - 0.0625).sqrt();
        let at = |gap: f64| behind(5.0, 10.0, Leader { gap, speed: 5.0 });
        assert!(at(gap).abs() < 1e-12 && at(gap - 1.0) < -0.1 && at(gap + 1.0) > 0.1);
    }

    #[test]
    fn before_a_wall_a_car_brakes_gently_and_stops_short_of_it() {
        let (mut speed, mut gap, mut hardest) = (8.0_f64, 100.0, 0.0_f64);
        for _ in 0..1200 {
            let acceleration = behind(speed, 8.0, Leader { gap, speed: 0.0 });
            hardest = hardest.min(acceleration);
            speed = (speed + 0.05 * acceleration).max(0.0);
            gap -= 0.05 * speed;
        }
        assert!(hardest > -1.5 * COMFORTABLE, "{hardest}");
        assert!(
            speed < 0.05 && (0.9 * AT_REST..1.5 * AT_REST).contains(&gap),
            "{speed} {gap}"
        );
    }

    #[test]
    fn nobody_brakes_for_one_who_drives_away() {
        assert!(
            behind(
                5.0,
                10.0,
                Leader {
                    gap: 20.0,
                    speed: 15.0
                }
            ) > 1.3
        );
    }
}
