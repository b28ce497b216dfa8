//! Collisions, counted by the class of what was hit. They do not end an episode.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Collisions with one class of things.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CollisionSum {
    /// How many.
    pub count: usize,
    /// Of these, those into which the robot drove faster than 5 cm/s; into the others it was run.
    #[serde(default)]
    pub driven_into: usize,
    /// Of the others, those with somebody in whose way the robot had got within the braking distance.
    #[serde(default)]
    pub cut_off: usize,
    /// Sum of their impulses, newton seconds.
    pub impulse_ns: f64,
}

/// A collision, as far as it counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bump {
    /// Its impulse, newton seconds.
    pub impulse_ns: f64,
    /// The robot's speed before it, m/s.
    pub speed_mps: f64,
    /// Whether the robot had got into the other's way within the braking distance.
    pub cut_off: bool,
}

impl Bump {
    /// Whether the robot drove, or had cut the other off.
    pub fn is_at_fault(&self) -> bool {
        self.speed_mps > STANDING || self.cut_off
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

/// A robot that is slower than this stands, m/s.
const STANDING: f64 = 0.05;

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
        let drives = speed_mps > STANDING;
        self.driven_into += usize::from(drives);
        self.cut_off += usize::from(!drives && cut_off);
        self.impulse_ns += impulse_ns;
    }
}

/// Sums collisions by class.
pub fn by_class<'a>(
    collisions: impl IntoIterator<Item = (&'a str, Bump)>,
) -> BTreeMap<String, CollisionSum> {
    let mut sums = BTreeMap::<String, CollisionSum>::new();
    for (class, bump) in collisions {
        sums.entry(class.to_owned()).or_default().add(bump);
    }
    sums
}

/// Sums the sums of several deliveries, by class.
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
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_summed_apart() {
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
                impulse_ns: 1.25
            }
        );
        let both = total([&first, &by_class([("car", bump(2.0, 0.0, true))])]);
        // Who drives into a car that it cut off is to blame once.
        assert_eq!(
            both["car"],
            CollisionSum {
                count: 2,
                driven_into: 1,
                cut_off: 1,
                impulse_ns: 2.5
            }
        );
        assert_eq!(both["wall"].count, 2);
    }
}
