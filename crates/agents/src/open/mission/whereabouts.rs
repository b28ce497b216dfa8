//! Where the robot is: what its sensors say, and what the mission does until it knows.

use openbench_core::{
    Action, Event, Events, FailureCause, GiveUp, MapPoint, Observation, Pose2, SimTime, Velocity,
};
use openbench_motion::costmap::Preferences;
use openbench_osm::{OsmData, OsmMap};
use openbench_routing::Router;

use crate::open::locating::{Limit, Locating, Search};
use crate::open::memory::Moves;
use crate::open::senses::{Correction, Finding, Sensed};
use crate::open::sighting::{self, Sighting};
use crate::open::terrain::Terrain;

use super::{Guess, Mission, Stage, Task, all, driver, unusable};

impl Mission {
    /// Takes in what the sensors measured.
    pub(super) fn sense(&mut self, observation: &Observation<'_>, events: &mut dyn Events) {
        let Sensed {
            ring,
            correction,
            finding,
        } = self.senses.take(observation, events);
        if let Some(correction) = correction {
            self.correct(&correction);
        }
        match finding {
            Some(Finding::Found(away)) => self.found(away, events),
            Some(Finding::Lost) => self.lost(events),
            None => {}
        }
        let is_searching = self.is_searching();
        let driver = match &mut self.locating {
            Some(locating) => locating.driver_mut(),
            None => &mut self.driver,
        };
        driver.observe_wheels(observation.wheels);
        if let Some(ring) = ring {
            driver.observe(&ring, observation.time);
            if let Some(locating) = &mut self.locating {
                locating.look(&ring);
            }
            // A robot that is searched for has no pose on the map.
            if !is_searching {
                events.record(Event::PoseEstimate(self.senses.estimate()));
            }
        }
        let moves = self.memory.correct(self.senses.building_offsets());
        if !moves.is_empty() {
            self.driver.set_map(self.memory.ground().clone());
            self.move_with_building(&moves);
            self.tell_buildings();
        }
        self.senses.announce(events);
    }

    /// Moves all plates that were seen, and the door that the robot drives to if it is one of them.
    fn correct(&mut self, by: &Correction) {
        for door in doors_seen(&mut self.task, &mut self.seen) {
            let there = Pose2::new(door.position.x, door.position.y, door.facing);
            let there = by.pose(there);
            (door.position, door.facing) = (there.point(), there.yaw);
        }
        let plates = self.unreadable.iter_mut();
        for plate in plates.chain(&mut self.uncertain_plates) {
            *plate = by.point(*plate);
        }
    }

    /// Moves what is known of the delivery by its building alone: the door of the map, the places
    /// to look from, and the target that is one of them.
    fn move_with_building(&mut self, moves: &Moves) {
        let Some(task) = &mut self.task else { return };
        let Some(&by) = moves.get(&task.building) else {
            return;
        };
        let is_seen = |door: &Sighting| self.seen.contains(door);
        let knows_place =
            task.place.is_some() || task.expected.as_ref().is_some_and(|d| !is_seen(d));
        if task.stage == Stage::ToWaypoint && knows_place {
            self.driver.move_target(by);
        }
        for door in task.doors_mut().filter(|door| !is_seen(door)) {
            let at = door.position;
            door.position = MapPoint::new(at.x + by.x, at.y + by.y);
        }
        // Those before plates too, although plates stay: they are looked at from some metres.
        for waypoint in task.waypoints.iter_mut().chain(&mut task.place) {
            *waypoint = waypoint.moved(by);
        }
    }

    /// Tells anew at which buildings the plates are that were seen: those are elsewhere now.
    fn tell_buildings(&mut self) {
        let ground = self.memory.ground();
        for door in doors_seen(&mut self.task, &mut self.seen) {
            // One that is at none any more is left where it was.
            door.building = sighting::building_at(ground, door.position).unwrap_or(door.building);
        }
    }

    /// Whether the robot first has to find out where it is.
    pub(super) fn is_searching(&self) -> bool {
        !self.senses.is_placed() && self.guess != Guess::Taken
    }

    /// Obstacles that were seen before are where the robot was thought to be.
    fn found(&mut self, away: f64, events: &mut dyn Events) {
        let way = self.locating.take().map(|search| search.metres());
        let search = way.map_or(String::new(), |way| {
            format!(", after a search of {way:.0} m")
        });
        let how = if self.senses.is_located() {
            "is"
        } else {
            "probably is"
        };
        events.record(Event::Note(format!(
            "the robot {how} {away:.1} m from where it was thought to be{search}"
        )));
        self.begin_anew();
    }

    /// The robot is elsewhere, and may be anywhere near.
    fn lost(&mut self, events: &mut dyn Events) {
        events.record(Event::Note(
            "the robot is not where it was thought to be, and is searched for".into(),
        ));
        self.guess = Guess::Missing;
        // Where these plates are on the map is known no better than where the robot was.
        self.seen.clear();
    }

    /// Forgets obstacles that were seen elsewhere, and sets out again from here.
    pub(super) fn begin_anew(&mut self) {
        let moves = self.memory.forget_corrections();
        self.driver.set_map(self.memory.ground().clone());
        self.driver.forget_seen(self.senses.pose().point());
        self.move_with_building(&moves);
        self.tell_buildings();
        if let Some(task) = &mut self.task {
            (task.stage, task.place) = (Stage::SetOut, None);
        }
    }

    /// Searches on, or goes on with the pose that was given.
    pub(super) fn search(&mut self, now: SimTime, events: &mut dyn Events) -> Action {
        let pose = self.senses.pose();
        let mut locating = match self.locating.take() {
            Some(locating) => locating,
            None => match self.new_search(events) {
                Ok(new) => new,
                Err(give_up) => return Action::GiveUp(give_up),
            },
        };
        match locating.step(pose, now, events) {
            Search::Drive(velocity) => {
                self.locating = Some(locating);
                Action::Drive(velocity)
            }
            Search::Over => self.end_search(locating.metres(), events),
        }
    }

    fn new_search(&self, events: &mut dyn Events) -> Result<Locating, GiveUp> {
        events.record(Event::Note("finding out where the robot is".into()));
        let (route, limit) = match self.guess {
            Guess::Given => (self.first_route(), Limit::WITH_POSE),
            _ => (Vec::new(), Limit::WITHOUT_POSE),
        };
        let nothing = OsmMap::new(
            &OsmData::default(),
            self.memory.map().projection.georeference(),
        );
        let here = self.senses.pose().point();
        let ground = Terrain::new(nothing, None, here, &self.robot, Preferences::NONE);
        let driver = driver(&self.motion, ground.map_err(unusable)?, &self.robot)?;
        Ok(Locating::new(driver, route, limit))
    }

    /// The route to the first delivery, as far as it is known; else nothing.
    fn first_route(&self) -> Vec<MapPoint> {
        let first = self.queue.as_ref().and_then(|queue| queue.front());
        let task = first.and_then(|delivery| self.look_up(delivery).ok());
        let here = self.senses.pose().point();
        let route = task.and_then(|task| {
            let roads = self.driver.terrain().roads()?;
            let wall = self.wall_nearest(task.building, here);
            let mut points = roads
                .route(here, wall)
                .map_or(Vec::new(), |route| route.points);
            points.push(wall);
            Some(points)
        });
        route.unwrap_or_default()
    }

    fn end_search(&mut self, metres: f64, events: &mut dyn Events) -> Action {
        if self.guess != Guess::Given {
            let detail = format!("on {metres:.0} m the robot did not find out where it is");
            return Action::GiveUp(all(FailureCause::Lost, detail));
        }
        events.record(Event::Note(format!(
            "on {metres:.0} m the robot did not find out where it is, and goes on with the start \
             as it was given"
        )));
        self.guess = Guess::Taken;
        self.begin_anew();
        Action::Drive(Velocity::ZERO)
    }
}

/// All doors that were seen, and those of a delivery that are among them: what only the map says
/// does not move with what is seen.
fn doors_seen<'a>(
    task: &'a mut Option<Task>,
    seen: &'a mut [Sighting],
) -> impl Iterator<Item = &'a mut Sighting> {
    let own = task.iter_mut().flat_map(Task::doors_mut);
    let own: Vec<_> = own.filter(|door| seen.contains(door)).collect();
    seen.iter_mut().chain(own)
}
