//! Collisions, counted by the class of what was hit. They do not end an episode.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Collisions with one class of things.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CollisionSum {
    /// How many.
    pub count: usize,
    /// Sum of their impulses, newton seconds.
    pub impulse_ns: f64,
}

impl CollisionSum {
    /// Adds one collision.
    pub fn add(&mut self, impulse_ns: f64) {
        self.count += 1;
        self.impulse_ns += impulse_ns;
    }
}

/// Sums collisions given as class and impulse (newton seconds), by class.
pub fn by_class<'a>(collisions: impl IntoIterator<Item = (&'a str, f64)>) -> BTreeMap<String, CollisionSum> {
    let mut sums = BTreeMap::<String, CollisionSum>::new();
    for (class, impulse) in collisions {
        sums.entry(class.to_owned()).or_default().add(impulse);
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
        sum.impulse_ns += part.impulse_ns;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_summed_apart() {
        let first = by_class([("wall", 1.0), ("car", 0.5), ("wall", 0.25)]);
        assert_eq!(first["wall"], CollisionSum { count: 2, impulse_ns: 1.25 });
        let both = total([&first, &by_class([("car", 2.0)])]);
        assert_eq!(both["car"], CollisionSum { count: 2, impulse_ns: 2.5 });
        assert_eq!(both["wall"].count, 2);
    }
}
