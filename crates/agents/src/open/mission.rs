//! The deliveries and the stage that each is in.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::{
    Action, Address, Briefing, Event, Events, FailureCause, GiveUp, Goal, MapPoint, Observation,
    PlannedDelivery, PoseEstimate, RobotDescription, SimTime, Velocity,
};
use openbench_language::{PlanError, PlanRequest, Planner};
use openbench_localization::Localizer;
use openbench_osm::{Location, OsmData, OsmMap, locate};
use openbench_routing::{MapRouter, Profile, Router, RouterTimes};
use openbench_vision::PlateReader;

use crate::open::caution::{Caution, Measure};
use crate::open::doorstep;
use crate::open::driving::{Driver, Driving, Target};
use crate::open::exploration::{self, Waypoint};
use crate::open::memory::Memory;
use crate::open::parts::Parts;
use crate::open::perception::Perception;
use crate::open::sighting::Sighting;
use crate::open::terrain::Terrain;

mod looking;

/// A correction of the pose that is worth a word, metres.
const NOTABLE: f64 = 0.3;
/// Distances from the wall to look from: all places at the first, then all at the next.
const STANDOFFS: [f64; 3] = [4.0, 5.5, 2.6];
/// Distance in front of a known door from which its plate is read again, metres.
const CHECK_FROM: f64 = 3.6;
/// A road that ends within this distance is not worth setting out for, metres.
const NEARBY: f64 = 2.0;
/// A way over roads is taken if it is no longer than this many times the straight line.
const DETOUR: f64 = 1.3;

/// What the robot is doing about the current delivery.
#[derive(Debug, Clone, PartialEq)]
enum Stage {
    /// Along the road towards the building.
    Travel,
    /// To a place to look from.
    ToWaypoint,
    /// Standing, to look.
    Look(SimTime),
    /// To the door.
    Approach(Sighting),
}

/// The delivery at hand.
struct Task {
    address: Address,
    building: usize,
    stage: Stage,
    /// Places not yet looked from.
    waypoints: Vec<Waypoint>,
    /// The place that the robot is at or on its way to.
    place: Option<Waypoint>,
    /// How often all places were looked from.
    round: usize,
    /// Whether any place was looked from.
    looked: bool,
    /// Where map or memory have the door, to be trusted if its plate cannot be read there.
    expected: Option<Sighting>,
    /// The next doorstep is looked for so far from the plate or farther, metres.
    doorstep: f64,
}

/// All deliveries of an episode.
pub struct Mission {
    robot: RobotDescription,
    localizer: Box<dyn Localizer>,
    reader: Box<dyn PlateReader>,
    perception: Perception,
    driver: Driver,
    memory: Memory,
    queue: VecDeque<PlannedDelivery>,
    task: Option<Task>,
    seen: Vec<Sighting>,
    /// When, and heading where.
    last_glance: (SimTime, f64),
    /// Plates that could not be read, and were given a place to look from.
    puzzling: Vec<MapPoint>,
    /// Plates that were read once, not surely, as the one that is looked for, and were given a place to look from.
    doubted: Vec<MapPoint>,
    /// Whether the pose is being corrected by more than a little.
    correcting: bool,
    caution: Caution,
    /// Distance from which plates at door height are in the picture, metres.
    sees_from: f64,
}

impl Mission {
    /// Reads the map, understands the instruction, prepares to drive.
    pub fn begin(parts: Parts, briefing: &Briefing, events: &mut dyn Events) -> Result<Self, GiveUp> {
        let data =
            OsmData::from_bytes(&briefing.map_osm).map_err(|e| all(FailureCause::Briefing, e.to_string()))?;
        let memory = Memory::new(data, briefing.georeference, parts.memory.as_ref());
        let router = MapRouter::new(memory.data(), memory.map().projection.clone(), Profile::delivery())
            .map_err(|e| all(FailureCause::Briefing, e.to_string()))?;
        let queue = understand(parts.planner.as_ref(), briefing, memory.map(), &router, events)?;
        let robot = briefing.robot.clone();
        let terrain =
            Terrain::new(memory.map().clone(), Some(router), briefing.start.point(), &robot, parts.ground)
                .map_err(|e| all(FailureCause::Briefing, e.to_string()))?;
        let mut localizer = parts.localizer;
        localizer.reset(briefing.start);
        Ok(Self {
            perception: Perception::new(robot.clone()),
            driver: Driver::new(terrain, robot.clone(), parts.motion)?,
            reader: parts.reader,
            task: None,
            seen: Vec::new(),
            last_glance: (SimTime::ZERO, briefing.start.yaw),
            puzzling: Vec::new(),
            doubted: Vec::new(),
            correcting: false,
            caution: Caution::default(),
            sees_from: exploration::sees_plates_from(&robot),
            robot,
            localizer,
            memory,
            queue,
        })
    }

    /// The agent's map as OSM XML.
    pub fn map_osm(&self) -> Vec<u8> {
        self.memory.data().to_xml()
    }

    /// Stands still until the next observation, eyes open.
    pub fn wait(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        self.sense(observation, events);
        Action::Drive(Velocity::ZERO)
    }

    /// Goes on after it stood for so long while models were asked: neither late nor curious for that.
    pub fn resume(&mut self, stood: Duration) {
        self.driver.resume(stood);
        self.last_glance.0 = self.last_glance.0 + stood;
    }

    /// What to do until the next observation.
    pub fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        self.sense(observation, events);
        if !self.localizer.ready() {
            return Action::Drive(Velocity::ZERO);
        }
        let health = self.localizer.health();
        let measure = self.caution.look(health, observation.time);
        if self.caution.is_over() {
            events
                .record(Event::Note("the pose is trusted again; what was seen in doubt is forgotten".into()));
            self.driver.forget_seen();
        }
        match measure {
            Measure::GoOn => self.go_on(observation, events),
            Measure::Slow => match self.go_on(observation, events) {
                Action::Drive(velocity) => Action::Drive(Caution::slowed(velocity, &self.robot)),
                decided => decided,
            },
            Measure::Stand => Action::Drive(Velocity::ZERO),
            Measure::GiveUp => {
                let detail = "the localizer no longer knows where the robot is";
                Action::GiveUp(all(FailureCause::Lost, detail.into()))
            }
        }
    }

    fn go_on(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        match self.task.take() {
            Some(task) => self.pursue(task, observation, events),
            None => self.next_delivery(events),
        }
    }

    fn sense(&mut self, observation: &Observation<'_>, events: &mut dyn Events) {
        self.localizer.update(observation);
        self.driver.observe_wheels(observation.wheels);
        if let Some(scan) = observation.scan {
            let ring = self.perception.observe(scan, self.localizer.as_ref());
            self.driver.observe(&ring, observation.time);
            let (pose, health) = (self.localizer.pose(), self.localizer.health());
            events.record(Event::PoseEstimate(PoseEstimate { pose, health }));
        }
        self.announce(events);
    }

    /// Says when the pose is being corrected by so much that one who watches would wonder.
    fn announce(&mut self, events: &mut dyn Events) {
        let pending = self.localizer.pending();
        if pending > NOTABLE && !self.correcting {
            events
                .record(Event::Note(format!("the pose turns out to be {pending:.1} m off and is corrected")));
        }
        self.correcting = pending > NOTABLE || self.correcting && pending > NOTABLE / 2.0;
    }

    fn next_delivery(&mut self, events: &mut dyn Events) -> Action {
        let Some(delivery) = self.queue.pop_front() else {
            return Action::GiveUp(all(FailureCause::NotDeclared, "every planned delivery is done".into()));
        };
        let address = delivery.address();
        self.puzzling.clear();
        self.doubted.clear();
        events.record(Event::Task(address.clone()));
        if let Some(problem) = delivery.problem {
            return Action::GiveUp(one(address, FailureCause::UnknownAddress, problem));
        }
        let map = self.memory.map();
        let (building, entrance) = match locate(map, &address) {
            Location::Unit { entrance, building } => (building, Some(map.entrances[entrance].position)),
            Location::Building(building) => (building, None),
            Location::Unknown | Location::Ambiguous(_) => {
                let detail = format!("the map has no single building `{}`", address.building);
                return Action::GiveUp(one(address, FailureCause::UnknownAddress, detail));
            }
        };
        let expected = self.remembered(building, &address).or_else(|| {
            let wall = map.buildings[building].polygon.nearest_boundary_point(entrance?);
            Some(Sighting {
                unit: address.unit.clone().unwrap_or_default(),
                building,
                position: wall.point,
                facing: wall.normal,
                confidence: 1.0,
            })
        });
        let road = self.road_to(building, events);
        let task = Task {
            address,
            building,
            stage: Stage::Travel,
            waypoints: Vec::new(),
            place: None,
            round: 0,
            looked: false,
            expected,
            doorstep: doorstep::NEAREST,
        };
        match road {
            Some(end) if end.distance(self.localizer.pose().point()) > NEARBY => {
                self.driver.set_target(Target { point: end, yaw: None, must: false });
                self.task = Some(task);
                Action::Drive(Velocity::ZERO)
            }
            _ => self.end_travel(task, events),
        }
    }

    /// Where the road to a building ends, if the map has one worth taking.
    fn road_to(&self, building: usize, events: &mut dyn Events) -> Option<MapPoint> {
        let from = self.localizer.pose().point();
        let polygon = &self.memory.map().buildings[building].polygon;
        let to = polygon.nearest_boundary_point(from).point;
        let route = self.driver.terrain().roads()?.route(from, to).ok()?;
        let (first, last) = (*route.points.first()?, *route.points.last()?);
        let length = route.distance + from.distance(first) + to.distance(last);
        events.record(Event::Route(route.points));
        (length <= DETOUR * from.distance(to)).then_some(last)
    }

    fn pursue(&mut self, task: Task, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        let now = observation.time;
        match &task.stage {
            Stage::Look(since) => {
                let (since, task) = (*since, Task { looked: true, ..task });
                self.look(task, since, observation, events)
            }
            Stage::Travel | Stage::ToWaypoint | Stage::Approach(_) => {
                match self.glance(task, observation, events) {
                    Ok(task) => self.drive(task, now, events),
                    Err(action) => action,
                }
            }
        }
    }

    fn drive(&mut self, task: Task, now: SimTime, events: &mut dyn Events) -> Action {
        match self.driver.drive(self.localizer.pose(), now, events) {
            Driving::OnTheWay(velocity) => {
                self.task = Some(task);
                Action::Drive(velocity)
            }
            Driving::Arrived => self.arrived(task, now, events),
            Driving::Unreachable => self.missed(task, events),
        }
    }

    fn arrived(&mut self, mut task: Task, now: SimTime, events: &mut dyn Events) -> Action {
        match &task.stage {
            Stage::Travel => return self.end_travel(task, events),
            // What was seen on the way may have moved its end beside a porch.
            Stage::Approach(door) if !self.is_before(door) && task.doorstep <= doorstep::FARTHEST => {
                return self.missed(task, events);
            }
            Stage::Approach(_) => return Action::Delivered(task.address),
            Stage::ToWaypoint | Stage::Look(_) => {
                task.stage = Stage::Look(now);
                self.task = Some(task);
            }
        }
        Action::Drive(Velocity::ZERO)
    }

    /// A place could not be reached.
    fn missed(&mut self, mut task: Task, events: &mut dyn Events) -> Action {
        match &mut task.stage {
            Stage::Travel => return self.end_travel(task, events),
            Stage::Approach(door) => {
                let door = door.clone();
                if task.doorstep <= doorstep::FARTHEST {
                    self.approach(task, door);
                } else if doorstep::is_at_door(&door, self.localizer.pose().point()) {
                    return Action::Delivered(task.address);
                } else {
                    (task.expected, task.doorstep) = (None, doorstep::NEAREST);
                    return self.next_waypoint(task, events);
                }
            }
            Stage::ToWaypoint | Stage::Look(_) => {
                task.waypoints.extend(task.place.take().and_then(|place| place.nearer()));
                return self.next_waypoint(task, events);
            }
        }
        Action::Drive(Velocity::ZERO)
    }

    /// Near the building: to its door, where it is known, or to the first place to look from.
    fn end_travel(&mut self, task: Task, events: &mut dyn Events) -> Action {
        match task.expected.clone() {
            Some(door) => self.check_door(task, &door),
            None => return self.next_waypoint(task, events),
        }
        Action::Drive(Velocity::ZERO)
    }

    /// Goes to where a known door's plate can be read.
    fn check_door(&mut self, mut task: Task, door: &Sighting) {
        let point = door.position.offset(door.facing, CHECK_FROM);
        let target = Target { point, yaw: Some(point.bearing_to(door.position)), must: true };
        self.driver.set_target(target);
        task.stage = Stage::ToWaypoint;
        task.place = None;
        self.task = Some(task);
    }

    /// The nearest place not yet looked from that a way leads to; after the last one all again from another distance; then
    /// the door is not found, or nothing leads there.
    fn next_waypoint(&mut self, mut task: Task, events: &mut dyn Events) -> Action {
        let here = self.localizer.pose().point();
        let nearest = loop {
            if let Some(nearest) = exploration::nearest(&task.waypoints, here, self.driver.terrain()) {
                break nearest;
            }
            let Some(&standoff) = STANDOFFS.get(task.round) else {
                if !task.looked {
                    let wall =
                        self.memory.map().buildings[task.building].polygon.nearest_boundary_point(here);
                    let detail = self.driver.terrain().obstacle(here, wall.point);
                    return Action::GiveUp(one(task.address, FailureCause::NoRoute, detail));
                }
                let detail =
                    format!("no plate of {} was read from any place around the building", task.address);
                return Action::GiveUp(one(task.address, FailureCause::DoorNotFound, detail));
            };
            task.round += 1;
            task.waypoints =
                exploration::waypoints(self.memory.map(), task.building, standoff, self.sees_from);
            events.record(Event::Waypoints(task.waypoints.iter().map(|w| w.place).collect()));
        };
        let waypoint = task.waypoints.remove(nearest);
        self.go_to(task, waypoint);
        Action::Drive(Velocity::ZERO)
    }

    fn go_to(&mut self, mut task: Task, waypoint: Waypoint) {
        let waypoint = waypoint.before_obstacles(self.driver.terrain().near()).unwrap_or(waypoint);
        let target = Target { point: waypoint.place.point(), yaw: Some(waypoint.place.yaw), must: false };
        self.driver.set_target(target);
        task.place = Some(waypoint);
        task.stage = Stage::ToWaypoint;
        self.task = Some(task);
    }

    fn is_before(&self, door: &Sighting) -> bool {
        doorstep::is_in_front(door, self.localizer.pose().point())
    }

    fn approach(&mut self, mut task: Task, door: Sighting) {
        let step = doorstep::doorstep(&door, task.doorstep, self.driver.terrain().near());
        self.driver.set_target(Target { point: step.place, yaw: None, must: true });
        task.doorstep = step.next;
        task.stage = Stage::Approach(door);
        task.expected = None;
        self.task = Some(task);
    }
}

fn all(cause: FailureCause, detail: String) -> GiveUp {
    GiveUp { address: None, cause, detail }
}

fn one(address: Address, cause: FailureCause, detail: String) -> GiveUp {
    GiveUp { address: Some(address), cause, detail }
}

fn understand(
    planner: &dyn Planner,
    briefing: &Briefing,
    map: &OsmMap,
    router: &MapRouter,
    events: &mut dyn Events,
) -> Result<VecDeque<PlannedDelivery>, GiveUp> {
    let Goal::Instruction(instruction) = &briefing.goal else {
        return Err(all(FailureCause::NotUnderstood, "OPEN takes instructions in words only".into()));
    };
    let times = RouterTimes { router, speed: briefing.robot.max_forward };
    let request = PlanRequest { instruction, map, start: briefing.start.point(), times: &times };
    let plan = planner.plan(&request).map_err(|error| all(cause_of(&error), error.to_string()))?;
    events.record(Event::Plan(plan.clone()));
    Ok(plan.deliveries.into())
}

fn cause_of(error: &PlanError) -> FailureCause {
    match error {
        PlanError::NotUnderstood { .. } => FailureCause::NotUnderstood,
        _ => FailureCause::PlannerUnavailable,
    }
}
