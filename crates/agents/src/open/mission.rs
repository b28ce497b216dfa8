//! The mission: deliveries one after another, and the stages of each.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::{
    Action, Address, Briefing, Event, Events, FailureCause, GiveUp, Goal, MapPoint, Observation,
    PlannedDelivery, Pose2, RobotDescription, SimTime, Stage as ReportedStage, Velocity, Work,
    with_causes,
};
use openbench_language::{PlanError, PlanRequest, Planner};
use openbench_motion::local::{PlannerEntry, make_planner};
use openbench_osm::{Location, OsmData, OsmMap, locate};
use openbench_routing::{MapRouter, Profile, Router, RouterTimes};
use openbench_vision::{PlateReader, ReaderError};

use crate::open::caution::{Caution, Measure};
use crate::open::doorstep;
use crate::open::driving::{Driver, Driving, Target};
use crate::open::exploration::{self, Waypoint};
use crate::open::locating::Locating;
use crate::open::memory::Memory;
use crate::open::parts::{Parts, Situation};
use crate::open::senses::Senses;
use crate::open::settings;
use crate::open::sighting::Sighting;
use crate::open::terrain::Terrain;

mod looking;
mod task;
mod whereabouts;

use task::{Aim, Stage, Task};

/// Distances of waypoints from the wall: all at the first, then all at the next.
const STANDOFFS_M: [f64; 3] = [4.0, 5.5, 2.6];
/// Distance in front of a known door from which its plate is read again.
const CHECK_DISTANCE_M: f64 = 3.6;
/// A road that ends within this distance is ignored.
const NEARBY_M: f64 = 2.0;
/// A road route is taken if it is at most this many times as long as the straight line.
const DETOUR_FACTOR: f64 = 1.3;

/// The outcome of a decision.
enum Next {
    /// The delivery continues; the robot drives so until the next observation.
    GoOn(Box<Task>, Velocity),
    /// The delivery, or the episode, ends.
    End(Action),
}

impl Next {
    /// The delivery continues; the robot stands until the next observation.
    fn stand(task: Task) -> Self {
        Self::GoOn(Box::new(task), Velocity::ZERO)
    }

    /// The delivery is given up.
    fn give_up(task: Task, cause: FailureCause, detail: String) -> Self {
        Self::End(Action::GiveUp(one(task.address, cause, detail)))
    }

    /// The delivery is given up, since no plate can be read.
    fn unreadable(task: Task, error: &ReaderError) -> Self {
        Self::give_up(task, FailureCause::ReaderUnavailable, with_causes(error))
    }

    /// The parcel is put down.
    fn delivered(task: Task) -> Self {
        Self::End(Action::Delivered(task.address))
    }
}

/// When the robot last glanced, and its heading then, radians.
#[derive(Debug, Clone, Copy)]
struct Glance {
    time: SimTime,
    yaw: f64,
}

/// The pose to go on with if the robot is not found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Guess {
    /// There is none.
    Missing,
    /// The start as it was given.
    Given,
    /// The same, and the robot goes on with it.
    Taken,
}

/// What a glance on the way finds.
enum Glimpse {
    /// Nothing that changes the target.
    Nothing,
    /// The plate of the door that the robot approaches was read otherwise meanwhile.
    Refuted,
    /// A door of the address.
    Door(Sighting),
    /// A place from which to look again at an uncertain match.
    Uncertain(Waypoint),
    /// The image cannot be read.
    Unreadable(ReaderError),
}

/// All deliveries of an episode.
pub struct Mission {
    robot: RobotDescription,
    planner: Box<dyn Planner>,
    reader: Box<dyn PlateReader>,
    goal: Goal,
    senses: Senses,
    driver: Driver,
    /// Finds out where the robot is, if it does not know.
    locating: Option<Locating>,
    guess: Guess,
    motion: PlannerEntry,
    memory: Memory,
    /// What is still to do; `None` until the instruction is understood.
    queue: Option<VecDeque<PlannedDelivery>>,
    task: Option<Task>,
    /// The stage that was reported last.
    told: Option<ReportedStage>,
    seen: Vec<Sighting>,
    last_glance: Glance,
    /// Plates that could not be read and have a waypoint.
    unreadable: Vec<MapPoint>,
    /// Uncertain matches that have a waypoint.
    uncertain_plates: Vec<MapPoint>,
    caution: Caution,
    /// Distance from which plates at door height are in the picture, metres.
    sees_from: f64,
}

impl Mission {
    /// Reads the map, understands the instruction, and prepares to drive.
    ///
    /// # Errors
    /// A briefing that cannot be used, an instruction that is not understood, or a planner that
    /// cannot answer.
    pub fn begin(
        parts: Parts,
        briefing: &Briefing,
        events: &mut dyn Events,
    ) -> Result<Self, GiveUp> {
        let data = OsmData::from_bytes(&briefing.map_osm).map_err(unusable)?;
        let memory = Memory::new(data, briefing.georeference, parts.memory.as_ref());
        let projection = memory.map().projection.clone();
        let roads = MapRouter::new(memory.data(), projection, Profile::delivery());
        let robot = briefing.robot.clone();
        let mut localizer = (parts.localizer)(&Situation {
            robot: &robot,
            map: Some(memory.map()),
            start: briefing.start,
        });
        // A localizer that finds the robot by itself needs no pose to begin with.
        let given = briefing.start.pose();
        if localizer.is_located() {
            briefing.start_pose()?;
        }
        // Of an area its middle, from which the robot is not too far to be an outlier.
        let about = briefing.start.about().unwrap_or_default();
        let start = given.unwrap_or(Pose2::new(about.x, about.y, 0.0));
        localizer.reset(start);
        let terrain = Terrain::new(
            memory.map().clone(),
            Some(roads.map_err(unusable)?),
            start.point(),
            &robot,
            parts.ground,
        )
        .map_err(unusable)?;
        let mut mission = Self {
            senses: Senses::new(robot.clone(), localizer),
            driver: driver(&parts.motion, terrain, &robot)?,
            planner: parts.planner,
            reader: parts.reader,
            goal: briefing.goal.clone(),
            motion: parts.motion,
            locating: None,
            guess: given.map_or(Guess::Missing, |_| Guess::Given),
            queue: None,
            task: None,
            told: None,
            seen: Vec::new(),
            last_glance: Glance {
                time: SimTime::ZERO,
                yaw: start.yaw,
            },
            unreadable: Vec::new(),
            uncertain_plates: Vec::new(),
            caution: Caution::default(),
            sees_from: exploration::sees_plates_from(&robot),
            robot,
            memory,
        };
        // By a pose that is roughly right, too: what is not understood is known at once.
        if given.is_some() {
            mission.queue = Some(mission.understand(start.point(), events)?);
        }
        Ok(mission)
    }

    /// The agent's map as OSM XML.
    pub fn map_osm(&self) -> Vec<u8> {
        self.memory.data().to_xml()
    }

    /// Stands still until the next observation, and senses meanwhile.
    pub fn wait(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        self.sense(observation, events);
        Action::Drive(Velocity::ZERO)
    }

    /// Continues after the robot stood for this long while models were asked: that time counts
    /// against no timeout.
    pub fn resume(&mut self, stood: Duration) {
        self.driver.resume(stood);
        if let Some(locating) = &mut self.locating {
            locating.resume(stood);
        }
        self.last_glance.time = self.last_glance.time + stood;
    }

    /// Decides what to do until the next observation.
    pub fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        self.sense(observation, events);
        // Sensed before this test, since a localizer becomes ready by its sensors.
        if !self.senses.is_ready() {
            return Action::Drive(Velocity::ZERO);
        }
        let measure = self.caution.look(self.senses.health(), observation.time);
        // Before the mission decides, so that no path is planned around misplaced obstacles.
        if self.caution.is_over() {
            events.record(Event::Note(
                "the pose is trusted again; what was seen in doubt is forgotten".into(),
            ));
            self.driver.forget_seen(self.senses.pose().point());
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
        let action = self.decide(observation, events);
        let stage = match &self.locating {
            Some(_) => Some(ReportedStage::Locating),
            None => self.task.as_ref().map(|task| task.stage.reported()),
        };
        if let Some(stage) = stage.filter(|stage| self.told != Some(*stage)) {
            self.told = Some(stage);
            events.record(Event::Stage(stage));
        }
        action
    }

    fn decide(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        if self.is_searching() {
            return self.search(observation.time, events);
        }
        let next = match self.task.take() {
            Some(task) => self.pursue(task, observation, events),
            None => self.next_delivery(events),
        };
        match next {
            Next::GoOn(task, velocity) => {
                self.task = Some(*task);
                Action::Drive(velocity)
            }
            Next::End(action) => action,
        }
    }

    fn next_delivery(&mut self, events: &mut dyn Events) -> Next {
        let mut queue = match self.queue.take() {
            Some(queue) => queue,
            None => match self.understand(self.senses.pose().point(), events) {
                Ok(queue) => queue,
                Err(give_up) => return Next::End(Action::GiveUp(give_up)),
            },
        };
        let delivery = queue.pop_front();
        self.queue = Some(queue);
        let Some(delivery) = delivery else {
            let detail = "every planned delivery is done".to_owned();
            return Next::End(Action::GiveUp(all(FailureCause::NotDeclared, detail)));
        };
        // Their limits are for each delivery. `seen` is kept: a door seen on the way serves later
        // ones.
        self.unreadable.clear();
        self.uncertain_plates.clear();
        events.record(Event::Task(delivery.address()));
        match self.look_up(&delivery) {
            Ok(task) => self.set_out(task, events),
            Err(give_up) => Next::End(Action::GiveUp(give_up)),
        }
    }

    /// Begins to drive to the building.
    fn set_out(&mut self, task: Task, events: &mut dyn Events) -> Next {
        match self.road_to(task.building, events) {
            Some(end) if end.distance(self.senses.pose().point()) > NEARBY_M => {
                self.driver.set_target(Target {
                    point: end,
                    yaw: None,
                    must: false,
                });
                Next::stand(Task {
                    stage: Stage::Travel,
                    ..task
                })
            }
            _ => self.end_travel(task, events),
        }
    }

    /// Turns the instruction into deliveries, by the times that ways take from `start`.
    fn understand(
        &self,
        start: MapPoint,
        events: &mut dyn Events,
    ) -> Result<VecDeque<PlannedDelivery>, GiveUp> {
        let Goal::Instruction(instruction) = &self.goal else {
            return Err(all(
                FailureCause::NotUnderstood,
                "OPEN takes instructions in words only".into(),
            ));
        };
        let roads = self.driver.terrain().roads();
        let times = RouterTimes {
            router: roads.ok_or_else(|| all(FailureCause::Briefing, "no roads".into()))?,
            // The one speed for roads and open ground: the robot drives no faster on roads.
            off_road_speed: self.robot.max_forward,
        };
        let request = PlanRequest {
            instruction,
            map: self.memory.map(),
            start,
            times: &times,
        };
        let plan = self
            .planner
            .plan(&request)
            .map_err(|error| all(cause_of(&error), with_causes(&error)))?;
        events.record(Event::Plan(plan.clone()));
        Ok(plan.deliveries.into())
    }

    /// Finds the building of a delivery, and its door if map or memory have it.
    fn look_up(&self, delivery: &PlannedDelivery) -> Result<Task, GiveUp> {
        let address = delivery.address();
        let unknown = FailureCause::UnknownAddress;
        if let Some(problem) = &delivery.problem {
            return Err(one(address, unknown, problem.clone()));
        }
        let map = self.memory.ground();
        let (building, entrance) = match locate(map, &address) {
            Location::Unit { entrance, building } => {
                (building, Some(map.entrances[entrance].position))
            }
            Location::Building(building) => (building, None),
            Location::Unknown | Location::Ambiguous(_) => {
                let detail = format!("the map has no single building `{}`", address.building);
                return Err(one(address, unknown, detail));
            }
        };
        // A plate that was read is better evidence than the map.
        let expected = self
            .remembered(building, &address)
            .or_else(|| Some(mapped_door(map, building, &address, entrance?)));
        Ok(Task::new(address, building, expected))
    }

    /// The point of a building's outline that is nearest to a place.
    fn wall_nearest(&self, building: usize, place: MapPoint) -> MapPoint {
        let polygon = &self.memory.ground().buildings[building].polygon;
        polygon.nearest_boundary_point(place).point
    }

    /// Where the road to a building ends, if the map has one worth taking.
    fn road_to(&self, building: usize, events: &mut dyn Events) -> Option<MapPoint> {
        let from = self.senses.pose().point();
        let to = self.wall_nearest(building, from);
        let route = self.driver.terrain().roads()?.route(from, to).ok()?;
        let (first, last) = (*route.points.first()?, *route.points.last()?);
        // With both gaps between the road and the ends, to be comparable with the straight line. A
        // much longer route is left to the terrain, which may cross open ground.
        let length = route.distance + from.distance(first) + to.distance(last);
        events.record(Event::Route(route.points));
        (length <= DETOUR_FACTOR * from.distance(to)).then_some(last)
    }

    fn pursue(
        &mut self,
        mut task: Task,
        observation: &Observation<'_>,
        events: &mut dyn Events,
    ) -> Next {
        match task.stage {
            Stage::SetOut => self.set_out(task, events),
            Stage::Look(since) => {
                task.looked = true;
                self.look(task, since, observation, events)
            }
            Stage::Travel | Stage::ToWaypoint | Stage::Approach(_) => {
                let glimpse = self.glance(&mut task, observation, events);
                self.after_glance(task, glimpse, observation, events)
            }
        }
    }

    /// Drives on, unless something was seen on the way that changes the target.
    fn after_glance(
        &mut self,
        mut task: Task,
        glimpse: Glimpse,
        observation: &Observation<'_>,
        events: &mut dyn Events,
    ) -> Next {
        match glimpse {
            Glimpse::Nothing => self.drive(task, observation.time, events),
            Glimpse::Refuted => self.next_waypoint(task, events),
            Glimpse::Door(door) => {
                task.doorstep = doorstep::NEAREST_M;
                self.approach(task, door)
            }
            Glimpse::Uncertain(view) => self.look_from(task, view),
            Glimpse::Unreadable(error) => Next::unreadable(task, &error),
        }
    }

    fn drive(&mut self, task: Task, now: SimTime, events: &mut dyn Events) -> Next {
        match self.driver.drive(self.senses.pose(), now, events) {
            Driving::OnTheWay(velocity) => Next::GoOn(Box::new(task), velocity),
            Driving::Arrived => self.arrived(task, now, events),
            Driving::Unreachable => self.missed(task, events),
        }
    }

    fn arrived(&mut self, task: Task, now: SimTime, events: &mut dyn Events) -> Next {
        match &task.stage {
            Stage::SetOut | Stage::Travel => self.end_travel(task, events),
            // Obstacles seen on the way may have moved its end beside a porch.
            Stage::Approach(aim)
                if !self.is_before(&aim.door) && task.doorstep <= doorstep::FARTHEST_M =>
            {
                self.missed(task, events)
            }
            Stage::Approach(_) => Next::delivered(task),
            Stage::ToWaypoint | Stage::Look(_) => Next::stand(Task {
                stage: Stage::Look(now),
                ..task
            }),
        }
    }

    /// The target of the stage could not be reached.
    fn missed(&mut self, mut task: Task, events: &mut dyn Events) -> Next {
        match &task.stage {
            Stage::SetOut | Stage::Travel => self.end_travel(task, events),
            Stage::Approach(aim) => {
                let door = aim.door.clone();
                self.missed_door(task, door, events)
            }
            Stage::ToWaypoint | Stage::Look(_) => {
                task.waypoints
                    .extend(task.place.take().and_then(|place| place.nearer()));
                self.next_waypoint(task, events)
            }
        }
    }

    /// The doorstep could not be reached: one farther out, or here if that is near enough; else the
    /// door is searched for anew.
    fn missed_door(&mut self, mut task: Task, door: Sighting, events: &mut dyn Events) -> Next {
        if task.doorstep <= doorstep::FARTHEST_M {
            return self.approach(task, door);
        }
        // No doorstep can be reached. Near enough, the parcel is put down here.
        if doorstep::is_at_door(&door, self.senses.pose().point()) {
            return Next::delivered(task);
        }
        // The door may have been read wrongly or be mapped wrongly, so it is no longer expected.
        (task.expected, task.doorstep) = (None, doorstep::NEAREST_M);
        self.next_waypoint(task, events)
    }

    /// Near the building: to its door, where it is known, or to the first place to look from.
    fn end_travel(&mut self, task: Task, events: &mut dyn Events) -> Next {
        match task.expected.clone() {
            Some(door) => self.check_door(task, &door),
            None => self.next_waypoint(task, events),
        }
    }

    /// Goes to where a known door's plate can be read.
    fn check_door(&mut self, task: Task, door: &Sighting) -> Next {
        let point = door.position.offset(door.facing, CHECK_DISTANCE_M);
        let yaw = Some(point.bearing_to(door.position));
        self.driver.set_target(Target {
            point,
            yaw,
            must: true,
        });
        Next::stand(Task {
            stage: Stage::ToWaypoint,
            // No waypoint to return to: without its plate the door of the map is taken as it is.
            place: None,
            ..task
        })
    }

    /// The nearest place not yet looked from that a path leads to; after the last one all again
    /// from another distance; then the door is not found, or nothing leads there.
    fn next_waypoint(&mut self, mut task: Task, events: &mut dyn Events) -> Next {
        let here = self.senses.pose().point();
        let nearest = loop {
            let terrain = self.driver.terrain();
            events.record(Event::Work(Work::PathSearch));
            if let Some(nearest) = exploration::nearest(&task.waypoints, here, terrain) {
                break nearest;
            }
            // Each pass takes one distance from the list, so the loop ends.
            let Some(&standoff) = STANDOFFS_M.get(task.round) else {
                return self.not_found(task, here);
            };
            task.round += 1;
            task.waypoints = exploration::waypoints(
                self.memory.ground(),
                task.building,
                standoff,
                self.sees_from,
            );
            let places = task
                .waypoints
                .iter()
                .map(|waypoint| waypoint.place)
                .collect();
            events.record(Event::Waypoints(places));
        };
        let waypoint = task.waypoints.remove(nearest);
        self.go_to(task, waypoint)
    }

    /// Every place was looked from, or none could be reached.
    fn not_found(&mut self, mut task: Task, here: MapPoint) -> Next {
        if let Some(door) = self.beside(task.building, &task.address)
            && !task.is_last_resort
        {
            // Once, since the door may be out of reach.
            task.is_last_resort = true;
            return self.approach(task, door);
        }
        if task.looked {
            let detail = format!(
                "no plate of {} was read from any place around the building",
                task.address
            );
            return Next::give_up(task, FailureCause::DoorNotFound, detail);
        }
        let wall = self.wall_nearest(task.building, here);
        let detail = self.driver.terrain().obstacle(here, wall);
        Next::give_up(task, FailureCause::NoRoute, detail)
    }

    fn go_to(&mut self, task: Task, waypoint: Waypoint) -> Next {
        let near = self.driver.terrain().near();
        // An obstacle between waypoint and wall would hide the plates behind it.
        let waypoint = waypoint.before_obstacles(near).unwrap_or(waypoint);
        let (point, yaw) = (waypoint.place.point(), Some(waypoint.place.yaw));
        self.driver.set_target(Target {
            point,
            yaw,
            must: false,
        });
        Next::stand(Task {
            stage: Stage::ToWaypoint,
            place: Some(waypoint),
            ..task
        })
    }

    fn is_before(&self, door: &Sighting) -> bool {
        doorstep::is_in_front(door, self.senses.pose().point())
    }

    fn approach(&mut self, task: Task, door: Sighting) -> Next {
        let step = doorstep::doorstep(&door, task.doorstep, self.driver.terrain().near());
        self.driver.set_target(Target {
            point: step.place,
            yaw: None,
            must: true,
        });
        let stage = Stage::Approach(Aim::new(door));
        Next::stand(Task {
            doorstep: step.next,
            stage,
            // From here on the plate counts: read otherwise, the door is refuted; not reached, it
            // is searched for.
            expected: None,
            ..task
        })
    }
}

/// A door as the map has it, on the building's wall.
fn mapped_door(map: &OsmMap, building: usize, address: &Address, entrance: MapPoint) -> Sighting {
    let wall = map.buildings[building]
        .polygon
        .nearest_boundary_point(entrance);
    Sighting {
        unit: address.unit.clone().unwrap_or_default(),
        building,
        position: wall.point,
        facing: wall.normal,
        confidence: 1.0,
    }
}

fn all(cause: FailureCause, detail: String) -> GiveUp {
    GiveUp {
        address: None,
        cause,
        detail,
    }
}

fn one(address: Address, cause: FailureCause, detail: String) -> GiveUp {
    GiveUp {
        address: Some(address),
        cause,
        detail,
    }
}

fn unusable(error: impl std::error::Error) -> GiveUp {
    all(FailureCause::Briefing, with_causes(&error))
}

/// Drives a robot over ground with a local planner.
fn driver(
    motion: &PlannerEntry,
    terrain: Terrain,
    robot: &RobotDescription,
) -> Result<Driver, GiveUp> {
    let planner = make_planner(motion, &settings::planning(robot)).map_err(unusable)?;
    Driver::new(terrain, robot.clone(), planner).map_err(unusable)
}

fn cause_of(error: &PlanError) -> FailureCause {
    match error {
        PlanError::NotUnderstood { .. } => FailureCause::NotUnderstood,
        _ => FailureCause::PlannerUnavailable,
    }
}

#[cfg(test)]
mod tests;
