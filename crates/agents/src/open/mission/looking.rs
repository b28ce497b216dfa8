//! Looking for the door: images taken from places chosen for it and on the way, what they say, and where to look again.

use std::sync::Arc;
use std::time::Duration;

use openbench_core::address::fold_name;
use openbench_core::frames::wrap_angle;
use openbench_core::{
    Action, Address, Event, Events, FailureCause, Image, MapPoint, Observation, SimTime, Velocity,
};
use openbench_vision::parse_unit;

use crate::open::doorstep;
use crate::open::exploration::{self, Waypoint};
use crate::open::sighting::{self, Sighting};

use super::{Mission, Stage, Task, one};

/// On the way to a door its newer place is taken if it is this far from the older one, metres.
const CORRECTION: f64 = 0.25;
/// Standing still before an image is taken.
const STEADY: Duration = Duration::from_millis(400);
/// Time between two glances while driving near the building, and how near that is, metres.
const GLANCE: (Duration, f64) = (Duration::from_millis(1500), 10.0);
/// Plates that could not be read and are looked at again, at most, in a delivery: letters may be on anything.
const MOST_PUZZLING: usize = 8;
/// Plates that were read, but not surely, and are looked at again, at most, in a delivery.
const MOST_DOUBTED: usize = 8;
/// Turning, the robot glances again after this share of the camera's field of view, so that no wall passes by between two glances.
const TURNED: f64 = 1.0 / 3.0;

impl Mission {
    pub(super) fn look(
        &mut self,
        task: Task,
        since: SimTime,
        observation: &Observation<'_>,
        events: &mut dyn Events,
    ) -> Action {
        if observation.time.since(since) < STEADY {
            self.task = Some(task);
            return Action::Drive(Velocity::ZERO);
        }
        let Some(image) = observation.camera.image() else {
            self.task = Some(task);
            return Action::Drive(Velocity::ZERO);
        };
        let known = self.seen.len();
        match self.read(&image, events) {
            Err(detail) => Action::GiveUp(one(task.address, FailureCause::ReaderUnavailable, detail)),
            Ok(unread) => {
                let mut task = task;
                self.look_closer(&mut task, &unread);
                self.after_look(task, known, events)
            }
        }
    }

    fn after_look(&mut self, mut task: Task, known: usize, events: &mut dyn Events) -> Action {
        let door = self.remembered(task.building, &task.address).or_else(|| task.expected.take());
        match door {
            Some(door) => {
                self.approach(task, door);
                Action::Drive(Velocity::ZERO)
            }
            None => {
                let hidden =
                    task.place.take().and_then(|place| place.before_obstacles(self.driver.terrain().near()));
                task.waypoints.extend(hidden);
                match self.doubtful(&task, known) {
                    Some(view) => self.look_from(task, view),
                    None => return self.next_waypoint(task, events),
                }
                Action::Drive(Velocity::ZERO)
            }
        }
    }

    /// Where to look from at a plate that was just read, not surely, as the one that is looked for, if one was among the sightings after the first `known`; once for each plate.
    fn doubtful(&mut self, task: &Task, known: usize) -> Option<Waypoint> {
        if task.expected.is_some() || matches!(task.stage, Stage::Approach(_)) {
            return None;
        }
        let may_be_it =
            |s: &&Sighting| fits(s, task.building, &task.address) && sighting::is_doubtful(s, &self.seen);
        let (position, facing) = self.seen[known..].iter().find(may_be_it).map(|s| (s.position, s.facing))?;
        let looked_at = self.doubted.iter().any(|p| p.distance(position) <= sighting::SAME_PLATE);
        if looked_at || self.doubted.len() == MOST_DOUBTED {
            return None;
        }
        self.doubted.push(position);
        let here = self.localizer.pose().point();
        let map = self.memory.map();
        Some(exploration::nearer_to_plate(map, position, facing, here, self.sees_from))
    }

    /// Goes to look from a place before all others.
    fn look_from(&mut self, mut task: Task, view: Waypoint) {
        task.waypoints.extend(task.place.take());
        self.go_to(task, view);
    }

    /// Reads what the camera happens to see on the way, near the building.
    pub(super) fn glance(
        &mut self,
        task: Task,
        observation: &Observation<'_>,
        events: &mut dyn Events,
    ) -> Result<Task, Action> {
        if !self.is_new_view(observation.time) || !self.faces(task.building) {
            return Ok(task);
        }
        let Some(image) = observation.camera.image() else { return Ok(task) };
        self.last_glance = (observation.time, self.localizer.pose().yaw);
        let mut task = task;
        let known = self.seen.len();
        match self.read(&image, events) {
            Ok(unread) => self.look_closer(&mut task, &unread),
            Err(detail) => {
                return Err(Action::GiveUp(one(task.address, FailureCause::ReaderUnavailable, detail)));
            }
        }
        if self.is_refuted(&task) {
            return Err(self.next_waypoint(task, events));
        }
        match self.remembered(task.building, &task.address).filter(|door| wants(&task, door)) {
            Some(door) => {
                task.doorstep = doorstep::NEAREST;
                self.approach(task, door);
                Err(Action::Drive(Velocity::ZERO))
            }
            None => match self.doubtful(&task, known) {
                Some(view) => {
                    self.look_from(task, view);
                    Err(Action::Drive(Velocity::ZERO))
                }
                None => Ok(task),
            },
        }
    }

    /// Whether the camera may show what it did not show at the last glance.
    fn is_new_view(&self, now: SimTime) -> bool {
        let (then, heading) = self.last_glance;
        let turned = wrap_angle(self.localizer.pose().yaw - heading).abs();
        now.since(then) >= GLANCE.0 || turned >= TURNED * self.robot.camera_intrinsics.horizontal_fov
    }

    /// Whether the door that the robot is on its way to was read otherwise meanwhile.
    fn is_refuted(&self, task: &Task) -> bool {
        let Stage::Approach(aim) = &task.stage else { return false };
        self.seen.contains(aim) && !sighting::is_trusted(aim, &self.seen)
    }

    /// Whether the camera looks at a building from near enough to read its plates.
    fn faces(&self, building: usize) -> bool {
        let (map, pose) = (self.memory.map(), self.localizer.pose());
        if map.distance_to_building(building, pose.point()) > GLANCE.1 {
            return false;
        }
        let half_view = self.robot.camera_intrinsics.horizontal_fov / 2.0;
        [-0.7, 0.0, 0.7].iter().any(|side| {
            let end = pose.point().offset(pose.yaw + side * half_view, GLANCE.1);
            let mut walls = map.buildings[building].polygon.sides();
            walls.any(|wall| cross_each_other(pose.point(), end, wall.start, wall.end))
        })
    }

    /// Plates of the building that were seen but not read get a place to look from, once each.
    fn look_closer(&mut self, task: &mut Task, unread: &[(MapPoint, f64)]) {
        for &(plate, facing) in unread {
            let known = |at: &MapPoint| at.distance(plate) <= sighting::SAME_PLATE;
            if self.puzzling.iter().any(known) || self.seen.iter().any(|s| known(&s.position)) {
                continue;
            }
            let map = self.memory.map();
            let its = map.nearest_building(plate) == Some(task.building)
                && map.distance_to_building(task.building, plate) <= sighting::OFF_BUILDING;
            if its && self.puzzling.len() < MOST_PUZZLING {
                self.puzzling.push(plate);
                task.waypoints.extend(exploration::before_plate(map, plate, facing, self.sees_from));
            }
        }
    }

    /// Reads an image and remembers every door in it; where plates are that it could not read.
    fn read(&mut self, image: &Arc<Image>, events: &mut dyn Events) -> Result<Vec<(MapPoint, f64)>, String> {
        let pose = self.localizer.pose();
        let readings = self.reader.read(image).map_err(|e| e.to_string())?;
        for reading in readings.iter().filter(|r| parse_unit(&r.text).is_some()) {
            let placed = sighting::place(reading, &self.perception, pose, &self.robot.camera_intrinsics);
            events.record(Event::PlateRead {
                text: reading.text.clone(),
                confidence: reading.confidence,
                corners: reading.corners,
                position: placed.map(|p| p.0),
                image: image.clone(),
            });
            if let Some(seen) = sighting::recognise(reading, placed, self.memory.map()) {
                self.seen.push(seen.clone());
                if sighting::is_trusted(&seen, &self.seen) {
                    self.memory.write(&seen, events);
                }
            }
        }
        let unread = readings.iter().filter(|r| sighting::is_puzzling(r));
        let place = |r| sighting::place(r, &self.perception, pose, &self.robot.camera_intrinsics);
        Ok(unread.filter_map(place).collect())
    }

    pub(super) fn remembered(&self, building: usize, address: &Address) -> Option<Sighting> {
        let fitting = self.seen.iter().rev().filter(|s| fits(s, building, address));
        fitting.into_iter().find(|s| sighting::is_trusted(s, &self.seen)).cloned()
    }
}

/// Whether two segments cross.
fn cross_each_other(a: MapPoint, b: MapPoint, c: MapPoint, d: MapPoint) -> bool {
    let side = |p: MapPoint, q: MapPoint, r: MapPoint| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Whether a door that was just seen changes where the robot goes.
fn wants(task: &Task, door: &Sighting) -> bool {
    match &task.stage {
        Stage::Approach(aim) => aim.position.distance(door.position) > CORRECTION,
        // A known door is looked at from its own place first.
        _ => task.expected.is_none(),
    }
}

/// Whether a sighting is the door of an address; an address without a unit is content with any door.
fn fits(sighting: &Sighting, building: usize, address: &Address) -> bool {
    let unit = address.unit.as_deref();
    sighting.building == building && unit.is_none_or(|u| fold_name(u) == fold_name(&sighting.unit))
}
