//! Cars: along their lanes behind each other, through junctions one after the other, and never over
//! people.
//!
//! Accelerations are those of the [driver model](super::driver_model). A person or the robot on the
//! lane ahead, or about to step onto it, is a leader. A car reserves a turn before it enters it.
//! Turns that conflict are not reserved by two cars at once; the car that has waited longer goes
//! first, and none enters a junction that it cannot leave. Where a lane ends, cars leave the map
//! and come in again elsewhere, both out of the robot's sight.

use openbench_core::{MapPoint, Pose2};

use super::driver_model::{ACCELERATION, AT_REST_M, COMFORTABLE, HARDEST, Leader, behind, free};
use super::ground::Ground;
use super::hull::{CAR_HALF_LENGTH_M, CarHull};
use super::lanes::Lanes;
use super::mover::RobotState;
use super::neighbours::Neighbours;
use super::obstruction::{LanePoint, STEP_M};
use super::pedestrians::Pedestrians;
use super::piece::slowing;
use super::social_force::Body;
use crate::noise::Noise;

/// The robot sees a car that is nearer than this unless an obstacle stands between, metres: the
/// reach of its LiDAR.
const IN_SIGHT_M: f64 = 50.0;
/// A car that has stood this long leaves the map as soon as the robot does not see it, seconds.
const PATIENCE_S: f64 = 60.0;
/// A car slower than this waits, m/s.
const WAITING_SPEED: f64 = 0.1;
/// A car may reserve a turn unless another has waited longer by this time, seconds.
const WAITING_MARGIN_S: f64 = 2.0;
/// Free lane that a car needs to come in, metres.
const ENTRY_ROOM_M: f64 = 18.0;
/// Side of the cells in which people look for cars, metres.
const CELL_M: f64 = 40.0;
/// Draws of a place for each car, before it waits outside.
const DRAWS: usize = 40;
/// Least distance of a car from the robot, from people and from other cars at the start, metres.
const START_FROM_ROBOT_M: f64 = 12.0;
const START_FROM_PEOPLE_M: f64 = 4.0;
const START_FROM_CARS_M: f64 = 10.0;

/// A car.
#[derive(Debug, Clone)]
pub(super) struct Car {
    /// The lane or turn that its middle is on.
    piece: u32,
    /// Distance driven on it, metres.
    s: f64,
    /// m/s.
    pub speed: f64,
    /// The turn after this lane.
    turn: Option<u32>,
    /// Whether it has reserved that turn.
    reserved: bool,
    /// The turn behind that the tail is still on.
    leaves: Option<u32>,
    /// Seconds without moving.
    stands: f64,
    /// Whether it is on the map.
    pub present: bool,
    /// Seconds until it tries to come in.
    away: f64,
}

/// All cars.
#[derive(Debug)]
pub(super) struct Cars {
    pub cars: Vec<Car>,
    pub hulls: Vec<CarHull>,
    pub near: Neighbours,
    lanes: Lanes,
    /// Lanes on which cars come in.
    entries: Vec<u32>,
    noise: Noise,
    /// Cars by piece and place on it.
    order: Vec<u32>,
    pieces: Vec<PieceState>,
    accelerations: Vec<f64>,
}

/// The traffic on a lane or turn.
#[derive(Debug, Clone, Copy, Default)]
struct PieceState {
    /// How many cars have reserved it.
    reserved: u32,
    /// The longest time that a car waits for it, seconds.
    wait: f64,
    /// Room before its last car, metres.
    room: f64,
}

impl Cars {
    /// `count` cars, none near `start` or a person; none at all without a lane. Cars that find no
    /// place wait outside.
    pub fn new(
        lanes: Lanes,
        count: usize,
        start: MapPoint,
        people: &Pedestrians,
        noise: Noise,
    ) -> Self {
        let is_entry = |k: &u32| lanes.pieces[*k as usize].is_entry;
        let mut entries: Vec<u32> = (0..lanes.lanes as u32).filter(is_entry).collect();
        // In a map without open ends cars come in on any lane.
        if entries.is_empty() {
            entries = (0..lanes.lanes as u32).collect();
        }
        let count = if lanes.lanes == 0 { 0 } else { count };
        let mut all = Self {
            cars: Vec::new(),
            hulls: Vec::new(),
            near: Neighbours::new(CELL_M),
            entries,
            noise,
            order: Vec::new(),
            pieces: vec![PieceState::default(); lanes.pieces.len()],
            accelerations: vec![0.0; count],
            lanes,
        };
        for _ in 0..count {
            let car = all.place(start, people);
            all.cars.push(car);
        }
        all.order = (0..count as u32).collect();
        all.hulls = vec![CarHull::new(Pose2::default(), 0.0); count];
        all.update_hulls();
        all
    }

    /// A car at a place drawn from all lanes, or outside.
    fn place(&mut self, start: MapPoint, people: &Pedestrians) -> Car {
        // Lanes only: a car that began on a turn would not have reserved it.
        let lanes = &self.lanes.pieces[..self.lanes.lanes];
        let whole: f64 = lanes.iter().map(|p| p.length).sum();
        let mut car = Car {
            piece: 0,
            s: 0.0,
            speed: 0.0,
            turn: None,
            reserved: false,
            leaves: None,
            stands: 0.0,
            present: false,
            away: 5.0 * self.noise.uniform(),
        };
        for _ in 0..DRAWS {
            let mut run = self.noise.uniform() * whole;
            let drawn = lanes.iter().position(|p| {
                run -= p.length;
                run < 0.0
            });
            let Some(k) = drawn else { continue };
            // What was taken off last is this lane, so the draw ends at this distance along it.
            let s = run + lanes[k].length;
            let at = lanes[k].pose(s).point();
            // The whole car stands on the lane, and no turn is under its ends.
            let begin = CAR_HALF_LENGTH_M + 1.0;
            let end = lanes[k].length - CAR_HALF_LENGTH_M - 3.0;
            // Lanes lie `APART_M` beside each other, so only cars on the same lane can be too near.
            let is_apart =
                |c: &Car| !c.present || c.piece != k as u32 || (c.s - s).abs() > START_FROM_CARS_M;
            if s > begin
                && s < end
                && people
                    .people
                    .iter()
                    .all(|p| p.position.distance(at) > START_FROM_PEOPLE_M)
                && at.distance(start) > START_FROM_ROBOT_M
                && self.cars.iter().all(is_apart)
            {
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
        self.reserve_turns(dt);
        for i in 0..self.cars.len() {
            if self.cars[i].present {
                // All decide by the same instant before any of them moves, so their order does not
                // matter.
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
        self.update_hulls();
    }

    fn update_hulls(&mut self) {
        for (car, hull) in self.cars.iter().zip(&mut self.hulls) {
            let piece = &self.lanes.pieces[car.piece as usize];
            *hull = CarHull::new(piece.pose(car.s), car.speed);
        }
        let hulls = self.cars.iter().zip(&self.hulls);
        self.near
            .fill(hulls.map(|(car, hull)| car.present.then(|| hull.pose.point())));
    }

    /// Sorts cars by piece and place, those outside last, and measures the room before the last car
    /// of each piece.
    fn sort(&mut self) {
        let (cars, pieces) = (&self.cars, &self.lanes.pieces);
        let key = |i: &u32| (!cars[*i as usize].present, cars[*i as usize].piece);
        self.order.sort_unstable_by(|a, b| {
            let by_place = || cars[*a as usize].s.total_cmp(&cars[*b as usize].s);
            key(a).cmp(&key(b)).then_with(by_place).then(a.cmp(b))
        });
        for (state, piece) in self.pieces.iter_mut().zip(pieces) {
            state.room = piece.length + 3.0;
        }
        // From the first car of a piece back to its last, which therefore has the last word.
        for &i in self.order.iter().rev() {
            let car = &cars[i as usize];
            if car.present {
                self.pieces[car.piece as usize].room = car.s - CAR_HALF_LENGTH_M;
            }
        }
    }

    /// Lets cars that are near their turn reserve it. The first in line asks; the others are behind
    /// it.
    fn reserve_turns(&mut self, dt: f64) {
        // How long cars wait for each turn, before any of them reserves one: that is what
        // `may_turn` compares.
        self.pieces.iter_mut().for_each(|state| state.wait = 0.0);
        for car in self.cars.iter().filter(|c| c.present && !c.reserved) {
            if let Some(turn) = car.turn {
                let state = &mut self.pieces[turn as usize];
                state.wait = state.wait.max(car.stands);
            }
        }
        for i in 0..self.cars.len() {
            let car = &self.cars[i];
            let Some(turn) = car.turn.filter(|_| car.present && !car.reserved) else {
                continue;
            };
            let piece = &self.lanes.pieces[car.piece as usize];
            let left = piece.length - car.s - CAR_HALF_LENGTH_M;
            // The braking distance at 1.5 m/s², a second of driving and a few metres: a car that
            // may turn does not brake first.
            let near = left < car.speed * car.speed / 3.0 + car.speed + 3.0;
            if near && self.is_first(i) && self.may_turn(turn, car.stands) {
                self.pieces[turn as usize].reserved += 1;
                self.cars[i].reserved = true;
            }
        }
        for car in &mut self.cars {
            car.stands = if car.speed < WAITING_SPEED {
                car.stands + dt
            } else {
                0.0
            };
        }
    }

    /// Whether no car without a reservation is between this one and the end of its lane.
    fn is_first(&self, i: usize) -> bool {
        self.ahead_on_piece(i).is_none_or(|j| self.cars[j].reserved)
    }

    /// Whether a car that has waited for so many seconds may reserve a turn: there is room behind
    /// it, no conflicting turn is reserved, and nobody has waited longer for one.
    fn may_turn(&self, turn: u32, waited: f64) -> bool {
        let piece = &self.lanes.pieces[turn as usize];
        let mut others = piece.conflicts.iter().map(|c| &self.pieces[*c as usize]);
        let out = piece.next[0] as usize;
        // Cars that have reserved the same turn will need room on that lane too.
        let cars = self.pieces[turn as usize].reserved + 1;
        let room = f64::from(cars) * (2.0 * CAR_HALF_LENGTH_M + AT_REST_M);
        self.pieces[out].room >= room
            && others.all(|c| c.reserved == 0 && c.wait <= waited + WAITING_MARGIN_S)
    }

    /// The next car on the same piece.
    fn ahead_on_piece(&self, i: usize) -> Option<usize> {
        let car = &self.cars[i];
        let key = |j: u32| {
            let c = &self.cars[j as usize];
            (!c.present, c.piece)
        };
        let is_behind = |j: &u32| {
            let by_piece = key(*j).cmp(&(false, car.piece));
            let by_place = self.cars[*j as usize].s.total_cmp(&car.s);
            by_piece.then(by_place).then(j.cmp(&(i as u32))).is_le()
        };
        // `order` is sorted by piece and place until cars drive, so halving finds the next car.
        let next = *self.order.get(self.order.partition_point(is_behind))?;
        (key(next) == (false, car.piece)).then_some(next as usize)
    }

    /// The last car on a piece.
    fn last_on(&self, piece: u32) -> Option<usize> {
        let is_before = |j: &u32| {
            let c = &self.cars[*j as usize];
            (!c.present, c.piece) < (false, piece)
        };
        // The lowest place on a piece is that of its last car.
        let first = *self.order.get(self.order.partition_point(is_before))? as usize;
        (self.cars[first].present && self.cars[first].piece == piece).then_some(first)
    }

    /// Acceleration of a car, m/s²: the least that its limit and its leaders allow.
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
        let mut limit = piece.speed(car.s);
        let mut worst = f64::INFINITY;
        match self.next_piece(car) {
            // A free course: the car slows down for the bend ahead only.
            Some(next) if car.reserved || self.lanes.is_turn(car.piece) => {
                limit = limit.min(slowing(self.lanes.pieces[next as usize].speed(0.0), left));
            }
            // Out of sight a car drives off the end of its lane, see `drive`.
            None if is_hidden(ground, robot, piece.pose(car.s).point()) => {}
            // The line before a turn that is not reserved, or the end of the road.
            _ => {
                let line = Leader {
                    // Cars stop `AT_REST_M` before a leader. This one is set so far beyond the line
                    // that the front stops 0.2 m before it.
                    gap: left - CAR_HALF_LENGTH_M + AT_REST_M - 0.2,
                    speed: 0.0,
                };
                worst = worst.min(behind(car.speed, limit, line));
            }
        }
        if let Some(leader) = self.leader(i) {
            worst = worst.min(behind(car.speed, limit, leader));
        }
        self.visit_obstructions(car, robot, people, |leader| {
            worst = worst.min(behind(car.speed, limit, leader));
        });
        worst
            .min(free(car.speed, limit))
            .clamp(-HARDEST, ACCELERATION)
    }

    /// The piece after the one that a car is on.
    fn next_piece(&self, car: &Car) -> Option<u32> {
        if self.lanes.is_turn(car.piece) {
            Some(self.lane_after(car.piece))
        } else {
            car.turn
        }
    }

    /// The lane after a turn.
    fn lane_after(&self, turn: u32) -> u32 {
        self.lanes.pieces[turn as usize].next[0]
    }

    /// The car ahead on this piece or the next ones.
    fn leader(&self, i: usize) -> Option<Leader> {
        let car = &self.cars[i];
        let leader = |j: usize, run: f64| Leader {
            gap: run - 2.0 * CAR_HALF_LENGTH_M,
            speed: self.cars[j].speed,
        };
        if let Some(j) = self.ahead_on_piece(i) {
            return Some(leader(j, self.cars[j].s - car.s));
        }
        let mut run = self.lanes.pieces[car.piece as usize].length - car.s;
        let mut next = self.next_piece(car);
        // A turn and the lane after it: which turn a car takes from there is not drawn yet.
        for _ in 0..3 {
            let piece = next?;
            if let Some(j) = self.last_on(piece).filter(|j| *j != i) {
                return Some(leader(j, run + self.cars[j].s));
            }
            run += self.lanes.pieces[piece as usize].length;
            next = self.lanes.is_turn(piece).then(|| self.lane_after(piece));
        }
        None
    }

    /// Visits people and the robot on the lane ahead or about to enter it, as leaders.
    fn visit_obstructions(
        &self,
        car: &Car,
        robot: &RobotState,
        people: &Pedestrians,
        mut visit: impl FnMut(Leader),
    ) {
        // As far as the car needs to stop comfortably, two seconds of driving, and some metres at
        // rest.
        let braking = car.speed * car.speed / (2.0 * COMFORTABLE);
        let range = braking + 2.0 * car.speed + 8.0;
        let (mut piece, mut s) = (car.piece, car.s);
        let mut run = 0.0;
        while run < range + CAR_HALF_LENGTH_M {
            let here = &self.lanes.pieces[piece as usize];
            let point = LanePoint::new(here.pose(s), run);
            people.near.near(point.pose.point(), |j| {
                if let Some(leader) = point.obstruction(people.people[j].body()) {
                    visit(leader);
                }
            });
            if let Some(leader) = point.obstruction(Body::from(*robot)) {
                visit(leader);
            }
            (run, s) = (run + STEP_M, s + STEP_M);
            if s > here.length {
                s -= here.length;
                let next = if self.lanes.is_turn(piece) {
                    Some(here.next[0])
                } else {
                    // The turn is known for the car's own lane only.
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
        // The tail has left the turn: others may cross it.
        if car.s > CAR_HALF_LENGTH_M + 0.5
            && let Some(turn) = car.leaves.take()
        {
            self.pieces[turn as usize].reserved -= 1;
        }
        let piece = &self.lanes.pieces[car.piece as usize];
        let hidden = |s: f64| is_hidden(ground, robot, piece.pose(s).point());
        // Jams that the model cannot dissolve end here, unseen.
        let impatient = car.stands > PATIENCE_S && hidden(car.s);
        let at_end = car.turn.is_none() && !self.lanes.is_turn(car.piece) && car.s >= piece.length;
        if impatient || (at_end && hidden(piece.length)) {
            self.leave(i);
        } else if car.s >= piece.length {
            self.enter_next(i);
        }
    }

    /// Moves a car from the end of its piece onto the next.
    fn enter_next(&mut self, i: usize) {
        let car = &mut self.cars[i];
        let piece = &self.lanes.pieces[car.piece as usize];
        let is_turn = self.lanes.is_turn(car.piece);
        let over = car.s - piece.length;
        let next = if is_turn {
            Some(piece.next[0])
        } else {
            car.turn.filter(|_| car.reserved)
        };
        let Some(next) = next else {
            // Over the line without a reservation: it stands there.
            (car.s, car.speed) = (piece.length, 0.0);
            return;
        };
        if is_turn {
            // On a lane so short that the tail is still on the turn before, that turn's reservation
            // ends late but surely.
            if let Some(turn) = car.leaves.replace(car.piece) {
                self.pieces[turn as usize].reserved -= 1;
            }
            car.turn = draw(&self.lanes.pieces[next as usize].next, &mut self.noise);
            car.reserved = false;
        }
        (car.piece, car.s) = (next, over);
    }

    /// Takes a car off the map and ends its reservations.
    fn leave(&mut self, i: usize) {
        let car = &mut self.cars[i];
        let is_turn = self.lanes.is_turn(car.piece);
        let held = if is_turn {
            Some(car.piece)
        } else {
            car.turn.filter(|_| car.reserved)
        };
        for turn in held.into_iter().chain(car.leaves.take()) {
            self.pieces[turn as usize].reserved -= 1;
        }
        car.present = false;
        car.reserved = false;
        car.turn = None;
        car.stands = 0.0;
        car.speed = 0.0;
        car.away = 2.0 + 10.0 * self.noise.uniform();
    }

    /// Lets a car that is outside come in where the robot does not see it.
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
        // The next try is a little later, elsewhere.
        self.cars[i].away = 0.5;
        let Some(entry) = draw(&self.entries, &mut self.noise) else {
            return;
        };
        let piece = &self.lanes.pieces[entry as usize];
        // Its middle is at the lane's beginning, and its tail still behind that.
        let pose = piece.pose(0.0);
        let has_room = self.pieces[entry as usize].room >= ENTRY_ROOM_M.min(piece.length);
        if has_room && self.is_clear(pose.point(), people) && is_hidden(ground, robot, pose.point())
        {
            let car = &mut self.cars[i];
            (car.piece, car.s, car.present, car.reserved) = (entry, 0.0, true, false);
            car.speed = 0.6 * piece.speed(0.0);
            car.turn = draw(&piece.next, &mut self.noise);
            // No second car comes in at the same instant.
            self.pieces[entry as usize].room = 0.0;
            // Cars that try to come in after this one in the same step see it.
            self.hulls[i] = CarHull::new(pose, car.speed);
        }
    }

    /// Whether neither people nor cars are near a point.
    fn is_clear(&self, point: MapPoint, people: &Pedestrians) -> bool {
        let mut clear = true;
        people.near.near(point, |_| clear = false);
        let apart = 2.0 * CAR_HALF_LENGTH_M + AT_REST_M;
        let mut cars = self
            .cars
            .iter()
            .zip(&self.hulls)
            .filter(|(car, _)| car.present);
        clear && cars.all(|(_, hull)| hull.pose.point().distance(point) > apart)
    }
}

/// Whether the robot cannot see a car at `point`.
fn is_hidden(ground: &Ground, robot: &RobotState, point: MapPoint) -> bool {
    robot.position.distance(point) > IN_SIGHT_M || !ground.sees(robot.position, point)
}

fn draw(choices: &[u32], noise: &mut Noise) -> Option<u32> {
    let i = (noise.uniform() * choices.len() as f64) as usize;
    choices.get(i).copied()
}
