//! Collisions by class of the object that was hit. They do not end an episode.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Collisions with one class of objects.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CollisionSum {
    /// Number of collisions.
    pub count: usize,
    /// Collisions in which the robot was faster than 5 cm/s; in the others it was hit.
    #[serde(default)]
    pub driven_into: usize,
    /// Collisions in which the robot stood, but had entered the path of the other within its
    /// braking distance.
    #[serde(default)]
    pub cut_off: usize,
    /// Sum of the impulses, newton seconds.
    pub impulse_ns: f64,
    /// Time in contact, seconds: a long scrape is one collision, but not a short one.
    #[serde(default)]
    pub contact_s: f64,
}

/// The properties of a collision that are scored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bump {
    /// Impulse, newton seconds.
    pub impulse_ns: f64,
    /// Speed of the robot before the collision, m/s.
    pub speed_mps: f64,
    /// Whether the robot had entered the path of the other within its braking distance.
    pub cut_off: bool,
}

impl Bump {
    /// Whether the robot drove into the object, or had cut it off.
    pub fn is_at_fault(&self) -> bool {
        self.speed_mps > STANDSTILL_MPS || self.cut_off
    }
}

impl From<&openbench_sim::Collision> for Bump {
    fn from(collision: &openbench_sim::Collision) -> Self {
        let impulse_ns = collision.impulse;
        Self {
            impulse_ns,
            speed_mps: collision.speed,
            cut_off: collision.cut_off,
        }
    }
}

/// Maximum speed of a robot that is regarded as standing.
const STANDSTILL_MPS: f64 = 0.05;

impl CollisionSum {
    /// Adds one collision.
    pub fn add(
        &mut self,
        Bump {
            impulse_ns,
            speed_mps,
            cut_off,
        }: Bump,
    ) {
        self.count += 1;
        let drives = speed_mps > STANDSTILL_MPS;
        self.driven_into += usize::from(drives);
        // A robot that drives is at fault already. Each fault is counted once.
        self.cut_off += usize::from(!drives && cut_off);
        self.impulse_ns += impulse_ns;
    }
}

/// Sums the collisions by class.
pub fn by_class<'a>(
    collisions: impl IntoIterator<Item = (&'a str, Bump)>,
) -> BTreeMap<String, CollisionSum> {
    let mut sums = BTreeMap::<String, CollisionSum>::new();
    for (class, bump) in collisions {
        sums.entry(class.to_owned()).or_default().add(bump);
    }
    sums
}

/// The time in contact with anything, seconds.
pub fn contact_s(sums: &BTreeMap<String, CollisionSum>) -> f64 {
    // Folded from +0, since the `sum()` of nothing is -0, which JSON would show.
    sums.values().fold(0.0, |all, sum| all + sum.contact_s)
}

/// Adds the sums of several deliveries, by class.
pub fn total<'a>(
    parts: impl IntoIterator<Item = &'a BTreeMap<String, CollisionSum>>,
) -> BTreeMap<String, CollisionSum> {
    let mut sums = BTreeMap::<String, CollisionSum>::new();
    for (class, part) in parts.into_iter().flatten() {
        let sum = sums.entry(class.clone()).or_default();
        sum.count += part.count;
        sum.driven_into += part.driven_into;
        sum.cut_off += part.cut_off;
        sum.impulse_ns += part.impulse_ns;
        sum.contact_s += part.contact_s;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_class_has_its_own_sum() {
        let bump = |impulse_ns, speed_mps, cut_off| Bump {
            impulse_ns,
            speed_mps,
            cut_off,
        };
        let first = by_class([
            ("wall", bump(1.0, 0.5, false)),
            ("car", bump(0.5, 0.3, true)),
            ("wall", bump(0.25, 0.0, false)),
        ]);
        assert_eq!(
            first["wall"],
            CollisionSum {
                count: 2,
                driven_into: 1,
                cut_off: 0,
                impulse_ns: 1.25,
                contact_s: 0.0,
            }
        );
        let both = total([&first, &by_class([("car", bump(2.0, 0.0, true))])]);
        // A robot that drives into a car that it cut off is at fault only once.
        assert_eq!(
            both["car"],
            CollisionSum {
                count: 2,
                driven_into: 1,
                cut_off: 1,
                impulse_ns: 2.5,
                contact_s: 0.0,
            }
        );
        assert_eq!(both["wall"].count, 2);
    }
}
