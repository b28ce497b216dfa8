//! A profile's rules applied to the tags of a node.

use openbench_osm::Tags;

use super::Profile;
use super::rules::{listed, matching};

/// The cost of passing a node.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Passing {
    /// The time it takes, seconds.
    pub delay: f64,
    /// Additional weight that takes no time, seconds.
    pub cost: f64,
}

impl Profile {
    /// The cost of passing a node with these tags; `None` if it cannot be passed.
    pub(crate) fn node(&self, tags: &Tags) -> Option<Passing> {
        if tags.is_empty() {
            return Some(Passing::default());
        }
        let (access, nodes) = (&self.rules.access, &self.rules.nodes);
        // An access tag decides alone. The kind of barrier counts only without one.
        let stopped = || listed(&nodes.closed, tags) && !listed(&nodes.open, tags);
        if access.node_closed(tags).unwrap_or_else(stopped) {
            return None;
        }
        let most = |numbers| matching(numbers, tags).fold(0.0, f64::max);
        let entry = if access.node_at_ends(tags) {
            access.entry
        } else {
            0.0
        };
        Some(Passing {
            delay: most(&nodes.delay),
            cost: most(&nodes.cost) + entry,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passing(profile: &str, pairs: &[(&'static str, &'static str)]) -> Option<Passing> {
        Profile::named(profile)
            .unwrap()
            .node(&pairs.iter().copied().collect())
    }

    #[test]
    fn barriers_stop_the_profiles_that_they_are_made_for() {
        let bollard = [("barrier", "bollard")];
        assert!(passing("car", &bollard).is_none() && passing("foot", &bollard).is_some());
        assert!(passing("delivery", &[("barrier", "stile")]).is_none());
        assert!(passing("car", &[("barrier", "gate")]).is_some_and(|p| p.delay == 60.0));
        assert!(passing("car", &[("barrier", "swing_gate"), ("access", "no")]).is_none());
    }

    #[test]
    fn access_tags_count_before_the_kind_of_barrier() {
        assert!(passing("foot", &[("barrier", "wall"), ("foot", "yes")]).is_some());
        assert!(passing("foot", &[("barrier", "gate"), ("access", "private")]).is_none());
        assert!(
            passing("delivery", &[("barrier", "gate"), ("access", "private")])
                .is_some_and(|p| p.cost == 3600.0)
        );
    }

    #[test]
    fn signals_and_kerbs_cost_time_or_weight() {
        assert_eq!(
            passing("foot", &[("highway", "traffic_signals")])
                .unwrap()
                .delay,
            2.0
        );
        assert_eq!(
            passing("delivery", &[("kerb", "raised")]).unwrap(),
            Passing {
                delay: 0.0,
                cost: 120.0
            }
        );
        assert_eq!(passing("delivery", &[]), Some(Passing::default()));
    }
}
