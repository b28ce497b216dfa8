//! What a profile makes of a node's words.

use openbench_osm::Tags;

use super::Profile;
use super::rules::{listed, matching};

/// What passing a node costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Passing {
    /// Seconds.
    pub delay: f64,
    /// Seconds that count beside it but are not spent.
    pub cost: f64,
}

impl Profile {
    /// What passing a node with these words costs; `None` where one may not pass.
    pub fn node(&self, tags: &Tags) -> Option<Passing> {
        if tags.is_empty() {
            return Some(Passing::default());
        }
        let (access, nodes) = (&self.rules.access, &self.rules.nodes);
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

    fn passing(profile: &str, words: &[(&'static str, &'static str)]) -> Option<Passing> {
        Profile::named(profile)
            .unwrap()
            .node(&words.iter().copied().collect())
    }

    #[test]
    fn barriers_stop_those_whom_they_are_made_for() {
        let bollard = [("barrier", "bollard")];
        assert!(passing("car", &bollard).is_none() && passing("foot", &bollard).is_some());
        assert!(passing("delivery", &[("barrier", "stile")]).is_none());
        assert!(passing("car", &[("barrier", "gate")]).is_some_and(|p| p.delay == 60.0));
        assert!(passing("car", &[("barrier", "swing_gate"), ("access", "no")]).is_none());
    }

    #[test]
    fn access_words_come_before_the_kind_of_barrier() {
        assert!(passing("foot", &[("barrier", "wall"), ("foot", "yes")]).is_some());
        assert!(passing("foot", &[("barrier", "gate"), ("access", "private")]).is_none());
        assert!(
            passing("delivery", &[("barrier", "gate"), ("access", "private")])
                .is_some_and(|p| p.cost == 3600.0)
        );
    }

    #[test]
    fn signals_and_kerbs_are_not_free() {
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
