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
    /// Sum of their impulses, newton seconds.
    pub impulse_ns: f64,
}

/// A robot that is slower than this stands, m/s.
const STANDING: f64 = 0.05;

impl CollisionSum {
    /// Adds one collision of a robot with a speed, m/s.
    pub fn add(&mut self, impulse_ns: f64, speed: f64) {
        self.count += 1;
        self.driven_into += usize::from(speed > STANDING);
        self.impulse_ns += impulse_ns;
    }
}

/// Sums collisions given as class, impulse (newton seconds) and the robot's speed (m/s), by class.
pub fn by_class<'a>(
    collisions: impl IntoIterator<Item = (&'a str, f64, f64)>,
) -> BTreeMap<String, CollisionSum> {
    let mut sums = BTreeMap::<String, CollisionSum>::new();
    for (class, impulse, speed) in collisions {
        sums.entry(class.to_owned()).or_default().add(impulse, speed);
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
        sum.impulse_ns += part.impulse_ns;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_summed_apart() {
        let first = by_class([("wall", 1.0, 0.5), ("car", 0.5, 0.3), ("wall", 0.25, 0.0)]);
        assert_eq!(first["wall"], CollisionSum { count: 2, driven_into: 1, impulse_ns: 1.25 });
        let both = total([&first, &by_class([("car", 2.0, 0.0)])]);
        assert_eq!(both["car"], CollisionSum { count: 2, driven_into: 1, impulse_ns: 2.5 });
        assert_eq!(both["wall"].count, 2);
    }
}
