//! Collisions, made of contacts that follow each other.

use std::collections::BTreeMap;
use std::time::Duration;

use openbench_core::{Pose2, SimTime};
use openbench_scene::SemanticClass;

use crate::clock::STEP_NS;

/// A collision: a contact after half a second or more without one with the same class.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Collision {
    /// When it began.
    pub time: SimTime,
    /// Class of the object that was hit.
    pub class: SemanticClass,
    /// Impulse of the first contact, N s.
    pub impulse: f64,
    /// Pose of the robot.
    pub pose: Pose2,
    /// Speed of the robot's fastest corner when the observation's step began, up to 50 ms before,
    /// m/s. The turn counts at its commanded rate. It tells a robot that drives into somebody from
    /// one that stands and is run into.
    pub speed: f64,
    /// Whether the robot had entered the path of the person or car within its braking distance.
    pub cut_off: bool,
}

/// Contacts that follow each other within this time belong to one collision.
const SAME_COLLISION_NS: u64 = 500_000_000;

/// The last contact with each class of object.
#[derive(Debug, Default)]
pub(crate) struct ContactHistory {
    last: Vec<LastContact>,
}

#[derive(Debug)]
struct LastContact {
    class: SemanticClass,
    time: SimTime,
    /// Number of contacts: steps of the physics in which the class was touched.
    steps: u64,
}

impl ContactHistory {
    /// Notes a contact and returns whether it begins a collision.
    pub(crate) fn begins_collision(&mut self, class: SemanticClass, now: SimTime) -> bool {
        match self.last.iter_mut().find(|contact| contact.class == class) {
            Some(contact) => {
                // Every contact renews the time, so a robot that scrapes along a wall collides with
                // it once.
                let before = std::mem::replace(&mut contact.time, now);
                contact.steps += 1;
                now.0 - before.0 > SAME_COLLISION_NS
            }
            None => {
                self.last.push(LastContact {
                    class,
                    time: now,
                    steps: 1,
                });
                true
            }
        }
    }

    /// The time in contact with each class, by class.
    pub(crate) fn durations(&self) -> BTreeMap<SemanticClass, Duration> {
        let duration = |contact: &LastContact| {
            let time = Duration::from_nanos(contact.steps * STEP_NS);
            (contact.class, time)
        };
        self.last.iter().map(duration).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_within_half_a_second_are_one_collision() {
        let mut history = ContactHistory::default();
        let mut begins =
            |class, millis| history.begins_collision(class, SimTime::from_millis(millis));
        assert!(begins(SemanticClass::Wall, 0));
        assert!(!begins(SemanticClass::Wall, 400) && !begins(SemanticClass::Wall, 900));
        assert!(begins(SemanticClass::Kerb, 900), "another class");
        assert!(begins(SemanticClass::Wall, 1401));
        // Every contact lasts for a step of 2.5 ms.
        let walls = history.durations()[&SemanticClass::Wall];
        assert_eq!(walls, Duration::from_millis(10));
    }
}
