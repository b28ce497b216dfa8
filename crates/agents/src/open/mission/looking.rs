//! Looking for the door: images from waypoints and on the way, what they show, and where to look
//! again.

use std::sync::Arc;
use std::time::Duration;

use openbench_core::address::fold_name;
use openbench_core::frames::wrap_angle;
use openbench_core::{Address, Event, Events, Image, MapPoint, Observation, SimTime, Work};
use openbench_geometry::Segment;
use openbench_vision::{ReaderError, parse_unit};

use crate::open::exploration::{self, Waypoint};
use crate::open::sighting::{self, Location, Sighting};

use super::{Glance, Glimpse, Mission, Next, Stage, Task};

/// On the way to a door, its position is corrected if it moved by more than this.
const CORRECTION_M: f64 = 0.25;
/// How long the robot stands still before it takes an image.
const STEADY_TIME: Duration = Duration::from_millis(400);
/// Time between two glances while driving near the building.
const GLANCE_INTERVAL: Duration = Duration::from_millis(1500);
/// Distance from the building within which the robot glances.
const GLANCE_DISTANCE_M: f64 = 10.0;
/// Most unreadable plates that are looked at again in a delivery: letters may be on anything.
const MOST_UNREADABLE: usize = 8;
/// Most uncertain matches that are looked at again in a delivery.
const MOST_UNCERTAIN: usize = 8;
/// While turning, the robot glances again after this share of the camera's field of view, so that
/// no wall is missed between two glances.
const GLANCE_TURN: f64 = 1.0 / 3.0;

impl Mission {
    pub(super) fn look(
        &mut self,
        mut task: Task,
        since: SimTime,
        observation: &Observation<'_>,
        events: &mut dyn Events,
    ) -> Next {
        // A blurred image, or one that does not fit the pose, would misplace the plates.
        if observation.time.since(since) < STEADY_TIME {
            return Next::stand(task);
        }
        // Between two images of the camera; the next one is waited for.
        let Some(image) = observation.camera.image() else {
            return Next::stand(task);
        };
        // Sightings are only appended, so those after this index are from this image.
        let known = self.seen.len();
        match self.read(&image, events) {
            Err(error) => Next::unreadable(task, &error),
            Ok(unread) => {
                self.look_closer(&mut task, &unread);
                self.after_look(task, known, events)
            }
        }
    }

    fn after_look(&mut self, mut task: Task, known: usize, events: &mut dyn Events) -> Next {
        // A plate that was read comes before the expected door. That one is taken only once, since
        // a second attempt must not return to a door that could not be reached.
        let door = self.remembered(task.building, &task.address);
        if let Some(door) = door.or_else(|| task.expected.take()) {
            return self.approach(task, door);
        }
        let near = self.driver.terrain().near();
        // Scans from the waypoint may show an obstacle that was unknown when it was chosen.
        let hidden = task
            .place
            .take()
            .and_then(|place| place.before_obstacles(near));
        task.waypoints.extend(hidden);
        match self.uncertain(&task, known) {
            Some(view) => self.look_from(task, view),
            None => self.next_waypoint(task, events),
        }
    }

    /// Where to look from at an uncertain match, if there is one among the sightings after the
    /// first `known`; once for each plate.
    fn uncertain(&mut self, task: &Task, known: usize) -> Option<Waypoint> {
        // The robot looks from in front of a known door anyway.
        if task.expected.is_some() || matches!(task.stage, Stage::Approach(_)) {
            return None;
        }
        let may_be_it = |s: &&Sighting| {
            fits(s, task.building, &task.address) && sighting::is_doubtful(s, &self.seen)
        };
        let (position, facing) = self.seen[known..]
            .iter()
            .find(may_be_it)
            .map(|s| (s.position, s.facing))?;
        let looked_at = self
            .uncertain_plates
            .iter()
            .any(|p| p.distance(position) <= sighting::SAME_PLATE_M);
        // Bounded, since each look costs a drive and readers see letters in many things.
        if looked_at || self.uncertain_plates.len() == MOST_UNCERTAIN {
            return None;
        }
        self.uncertain_plates.push(position);
        let here = self.senses.pose().point();
        let map = self.memory.ground();
        Some(exploration::nearer_to_plate(
            map,
            position,
            facing,
            here,
            self.sees_from,
        ))
    }

    /// Looks from a place before all others.
    pub(super) fn look_from(&mut self, mut task: Task, view: Waypoint) -> Next {
        // The interrupted waypoint was not looked from yet, so it goes back to the others.
        task.waypoints.extend(task.place.take());
        self.go_to(task, view)
    }

    /// Reads what the camera happens to see on the way, near the building, unless the pose was
    /// corrected so far that the target changes by that alone.
    pub(super) fn glance(
        &mut self,
        task: &mut Task,
        observation: &Observation<'_>,
        events: &mut dyn Events,
    ) -> Glimpse {
        if let Some(moved) = moved_door(task) {
            return moved;
        }
        if !self.is_new_view(observation.time) || !self.faces(task.building) {
            return Glimpse::Nothing;
        }
        let Some(image) = observation.camera.image() else {
            return Glimpse::Nothing;
        };
        // Before reading, so that an image that shows nothing counts as a glance as well.
        self.last_glance = Glance {
            time: observation.time,
            yaw: self.senses.pose().yaw,
        };
        let known = self.seen.len();
        match self.read(&image, events) {
            Ok(unread) => self.look_closer(task, &unread),
            Err(error) => return Glimpse::Unreadable(error),
        }
        if self.is_refuted(task) {
            return Glimpse::Refuted;
        }
        let door = self.remembered(task.building, &task.address);
        if let Some(door) = door.filter(|door| wants(task, door)) {
            return Glimpse::Door(door);
        }
        match self.uncertain(task, known) {
            Some(view) => Glimpse::Uncertain(view),
            None => Glimpse::Nothing,
        }
    }

    /// Whether the view may have changed since the last glance.
    fn is_new_view(&self, now: SimTime) -> bool {
        let turned = wrap_angle(self.senses.pose().yaw - self.last_glance.yaw).abs();
        now.since(self.last_glance.time) >= GLANCE_INTERVAL
            || turned >= GLANCE_TURN * self.robot.camera_intrinsics.horizontal_fov
    }

    /// Whether the plate of the door that the robot approaches was read otherwise meanwhile.
    fn is_refuted(&self, task: &Task) -> bool {
        let Stage::Approach(aim) = &task.stage else {
            return false;
        };
        // A door known only from the map is not among the sightings, so no readings of it can be
        // compared.
        self.seen.contains(&aim.door) && !sighting::is_trusted(&aim.door, &self.seen)
    }

    /// Whether the camera faces a building from near enough to read its plates.
    fn faces(&self, building: usize) -> bool {
        let (map, pose) = (self.memory.ground(), self.senses.pose());
        if map.distance_to_building(building, pose.point()) > GLANCE_DISTANCE_M {
            return false;
        }
        let half_view = self.robot.camera_intrinsics.horizontal_fov / 2.0;
        // Three rays within the field of view stand for it; a wall that only fills its margin shows
        // no legible plate.
        [-0.7, 0.0, 0.7].iter().any(|side| {
            let end = pose
                .point()
                .offset(pose.yaw + side * half_view, GLANCE_DISTANCE_M);
            let mut walls = map.buildings[building].polygon.sides();
            walls.any(|wall| Segment::new(pose.point(), end).crosses(wall))
        })
    }

    /// Adds waypoints for plates of the building that were seen but not read, once each.
    pub(super) fn look_closer(&mut self, task: &mut Task, unread: &[Location]) {
        for &Location {
            position: plate,
            facing,
        } in unread
        {
            let known = |at: &MapPoint| at.distance(plate) <= sighting::SAME_PLATE_M;
            // Once for each plate, and never for one that another reading of it already explains.
            if self.unreadable.iter().any(known) || self.seen.iter().any(|s| known(&s.position)) {
                continue;
            }
            let map = self.memory.ground();
            let its = sighting::building_at(map, plate) == Some(task.building);
            if its && self.unreadable.len() < MOST_UNREADABLE {
                self.unreadable.push(plate);
                task.waypoints.extend(exploration::before_plate(
                    map,
                    plate,
                    facing,
                    self.sees_from,
                ));
            }
        }
    }

    /// Reads an image and remembers every door in it. Returns the locations of plates that it could
    /// not read.
    fn read(
        &mut self,
        image: &Arc<Image>,
        events: &mut dyn Events,
    ) -> Result<Vec<Location>, ReaderError> {
        let pose = self.senses.pose();
        // What models are asked is counted by itself.
        if self.reader.computes_here() {
            events.record(Event::Work(Work::Reading));
        }
        let readings = self.reader.read(image)?;
        // All texts of plates are recorded, also those that are not located or trusted: the record
        // shows what the reader saw.
        for reading in readings.iter().filter(|r| parse_unit(&r.text).is_some()) {
            let located = sighting::locate(
                reading,
                self.senses.perception(),
                pose,
                &self.robot.camera_intrinsics,
            );
            events.record(Event::PlateRead {
                text: reading.text.clone(),
                confidence: reading.confidence,
                corners: reading.corners,
                position: located.map(|at| at.position),
                image: image.clone(),
            });
            if let Some(seen) = sighting::recognise(reading, located, self.memory.ground()) {
                // Before the test, which sums over all sightings of the plate, this one included.
                self.seen.push(seen.clone());
                if sighting::is_trusted(&seen, &self.seen) {
                    self.memory.write(&seen, events);
                }
            }
        }
        let unread = readings.iter().filter(|r| sighting::is_puzzling(r));
        let locate = |r| {
            sighting::locate(
                r,
                self.senses.perception(),
                pose,
                &self.robot.camera_intrinsics,
            )
        };
        Ok(unread.filter_map(locate).collect())
    }

    pub(super) fn remembered(&self, building: usize, address: &Address) -> Option<Sighting> {
        // The newest first, so that a correction of the door's position follows the latest view.
        let fitting = self
            .seen
            .iter()
            .rev()
            .filter(|s| fits(s, building, address));
        fitting
            .into_iter()
            .find(|s| sighting::is_trusted(s, &self.seen))
            .cloned()
    }

    /// The nearest plate with the unit of an address that seemed to be at the building beside it.
    /// Where houses adjoin, that depends on a metre, which a map may be off.
    pub(super) fn beside(&self, building: usize, address: &Address) -> Option<Sighting> {
        let map = self.memory.ground();
        let away = |s: &Sighting| map.distance_to_building(building, s.position);
        let fitting = self.seen.iter().filter(|s| {
            s.building != building
                && fits(s, s.building, address)
                && away(s) <= sighting::OFF_BUILDING_M
                && sighting::is_trusted(s, &self.seen)
        });
        let nearest = fitting.min_by(|a, b| away(a).total_cmp(&away(b)))?;
        Some(Sighting {
            building,
            ..nearest.clone()
        })
    }
}

/// What a correction of the pose says about the door that the robot drives to.
fn moved_door(task: &Task) -> Option<Glimpse> {
    let Stage::Approach(aim) = &task.stage else {
        return None;
    };
    if aim.door.building != task.building {
        return Some(Glimpse::Refuted);
    }
    let is_elsewhere = wants(task, &aim.door);
    is_elsewhere.then(|| Glimpse::Door(aim.door.clone()))
}

/// Whether a door that was just seen changes the robot's target.
fn wants(task: &Task, door: &Sighting) -> bool {
    match &task.stage {
        Stage::Approach(aim) => aim.then.distance(door.position) > CORRECTION_M,
        // A known door is first looked at from in front of it.
        _ => task.expected.is_none(),
    }
}

/// Whether a sighting is the door of an address. Any door of the building matches an address
/// without a unit.
fn fits(sighting: &Sighting, building: usize, address: &Address) -> bool {
    let unit = address.unit.as_deref();
    sighting.building == building && unit.is_none_or(|u| fold_name(u) == fold_name(&sighting.unit))
}

#[cfg(test)]
mod tests {
    use super::super::Aim;
    use super::*;

    fn address(unit: Option<&str>) -> Address {
        Address {
            building: "building1".into(),
            unit: unit.map(str::to_owned),
        }
    }

    fn door(unit: &str, x: f64) -> Sighting {
        Sighting {
            unit: unit.into(),
            building: 0,
            position: MapPoint::new(x, 0.0),
            facing: 0.0,
            confidence: 1.0,
        }
    }

    #[test]
    fn a_door_fits_an_address_of_its_building_and_unit() {
        let seen = door("unit1", 0.0);
        assert!(fits(&seen, 0, &address(Some("Unit 1"))));
        assert!(!fits(&seen, 0, &address(Some("unit11"))));
        assert!(!fits(&seen, 1, &address(Some("unit1"))));
    }

    #[test]
    fn any_door_of_the_building_fits_an_address_without_a_unit() {
        assert!(fits(&door("unit7", 0.0), 0, &address(None)));
        assert!(!fits(&door("unit7", 0.0), 1, &address(None)));
    }

    #[test]
    fn a_door_is_approached_anew_only_if_it_moved_notably() {
        let mut task = Task::new(address(Some("unit1")), 0, None);
        task.stage = Stage::Approach(Aim::new(door("unit1", 0.0)));
        assert!(!wants(&task, &door("unit1", 0.9 * CORRECTION_M)));
        assert!(wants(&task, &door("unit1", 1.1 * CORRECTION_M)));
    }

    #[test]
    fn a_known_door_is_looked_at_before_what_is_seen_on_the_way_counts() {
        let (known, seen) = (door("unit1", 0.0), door("unit1", 5.0));
        let expecting = Task::new(address(Some("unit1")), 0, Some(known));
        let searching = Task::new(address(Some("unit1")), 0, None);
        assert!(!wants(&expecting, &seen));
        assert!(wants(&searching, &seen));
    }
}
