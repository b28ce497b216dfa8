//! A profile's rules applied to the tags of a way.

use openbench_osm::Tags;

use super::rules::{Access, listed, matching};
use super::{Places, Profile};

/// How a way is travelled in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Metres per second.
    pub speed: f64,
    /// A factor from time to weight.
    pub cost: f64,
    /// Whether the way may be used only by routes that begin or end there.
    pub ends_only: bool,
}

/// Key that distinguishes the crossing of a pedestrian area from its outline.
pub(crate) const CROSSING: &str = "openbench:crossing";
/// Key of a ferry's speed by its timetable, km/h.
pub(crate) const TIMETABLE: &str = "openbench:timetable";

/// The meaning of an access value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AccessValue {
    Open,
    AtEnds,
    Closed,
    Other,
}

impl Access {
    /// Of several values the most permissive one counts, and an unknown value least.
    fn classify(&self, value: &str) -> AccessValue {
        let has = |list: &[String]| {
            value
                .split(';')
                .any(|part| list.iter().any(|known| known == part.trim()))
        };
        // The order is the precedence, from the most permissive meaning on.
        let lists = [
            (&self.open, AccessValue::Open),
            (&self.at_ends, AccessValue::AtEnds),
            (&self.closed, AccessValue::Closed),
        ];
        lists
            .into_iter()
            .find(|(list, _)| has(list))
            .map_or(AccessValue::Other, |(_, meaning)| meaning)
    }

    /// The access value for a direction, `:forward` or `:backward`.
    fn directed(&self, tags: &Tags, direction: &str) -> Option<AccessValue> {
        let value = self.keys.iter().find_map(|key| {
            tags.get(&format!("{key}{direction}"))
                .or_else(|| tags.get(key))
        });
        value.map(|value| self.classify(value))
    }

    /// Whether the access value of a node closes it.
    pub(super) fn node_closed(&self, tags: &Tags) -> Option<bool> {
        let value = self.keys.iter().find_map(|key| tags.get(key))?;
        Some(self.closed.iter().any(|known| known == value))
    }

    /// Whether a node may be passed only by routes that begin or end near it.
    pub(super) fn node_at_ends(&self, tags: &Tags) -> bool {
        let value = self.keys.iter().find_map(|key| tags.get(key));
        value.is_some_and(|value| self.at_ends.iter().any(|known| known == value))
    }
}

impl Profile {
    /// How ways with these tags are travelled, along their nodes and against them; `None` where a
    /// direction is closed.
    pub fn way(&self, tags: &Tags) -> [Option<Travel>; 2] {
        let crossing_only = tags.has(CROSSING) && self.places() == Places::Outline;
        if crossing_only || listed(&self.rules.ways.closed, tags) {
            return [None; 2];
        }
        let open = self.directions(tags);
        let sides = [":forward", ":backward"].map(|side| self.rules.access.directed(tags, side));
        [0, 1].map(|i| open[i].then(|| self.travel(tags, sides[i])).flatten())
    }

    /// How a way is travelled in a direction with this access value, one-way rules aside.
    fn travel(&self, tags: &Tags, access: Option<AccessValue>) -> Option<Travel> {
        let ways = &self.rules.ways;
        let is_closed = match access {
            None => listed(&ways.closed_unless_open, tags),
            Some(access) => access == AccessValue::Closed,
        };
        if is_closed {
            return None;
        }
        // A way without any speed is closed, even if a timetable or a limit gives it one.
        let by_tags = matching(&ways.speed, tags).reduce(f64::max);
        let by_tags = by_tags.or(ways.speed_if_open.filter(|_| access.is_some()))?;
        let speed = timetable_speed(tags)
            .or_else(|| self.max_speed(tags))
            .unwrap_or(by_tags);
        let speed = matching(&ways.limit, tags).fold(speed, f64::min);
        Some(Travel {
            speed: speed / 3.6,
            cost: matching(&ways.cost, tags).product(),
            ends_only: access == Some(AccessValue::AtEnds),
        })
    }

    /// The driven share of the way's speed limit, km/h.
    fn max_speed(&self, tags: &Tags) -> Option<f64> {
        const MILE: f64 = 1.609_344;
        let rule = self.rules.ways.maxspeed.as_ref()?;
        let text = rule.keys.iter().find_map(|key| tags.get(key))?;
        let limit: f64 = match text.strip_suffix("mph") {
            Some(miles) => miles.trim().parse::<f64>().ok()? * MILE,
            // Words such as `walk` or `none` are no number: then the speed by tags counts.
            None => text.trim_end_matches("km/h").trim().parse().ok()?,
        };
        (1.0..=300.0).contains(&limit).then_some(limit * rule.share)
    }

    /// Which directions the one-way rules leave open.
    fn directions(&self, tags: &Tags) -> [bool; 2] {
        let rule = &self.rules.ways.oneway;
        let stated = rule.keys.iter().find_map(|key| match tags.get(key)? {
            "yes" | "true" | "1" | "forward" => Some([true, false]),
            "-1" | "reverse" | "backward" => Some([false, true]),
            "no" | "false" | "0" | "alternating" => Some([true, true]),
            // The present direction is not known.
            "reversible" => Some([false, false]),
            _ => None,
        });
        stated.unwrap_or_else(|| [true, !listed(&rule.implied, tags)])
    }
}

/// A ferry's speed by its timetable, km/h.
fn timetable_speed(tags: &Tags) -> Option<f64> {
    let speed = tags.get(TIMETABLE)?.parse().ok()?;
    (0.1..=100.0).contains(&speed).then_some(speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(profile: &str, pairs: &[(&'static str, &'static str)]) -> [bool; 2] {
        let tags: Tags = pairs.iter().copied().collect();
        Profile::named(profile)
            .unwrap()
            .way(&tags)
            .map(|travel| travel.is_some())
    }

    fn travel(profile: &str, pairs: &[(&'static str, &'static str)]) -> Travel {
        let tags: Tags = pairs.iter().copied().collect();
        Profile::named(profile).unwrap().way(&tags)[0].unwrap()
    }

    #[test]
    fn robots_take_no_steps_but_enter_private_ground() {
        let steps = [("highway", "steps")];
        assert_eq!(
            (open("delivery", &steps), open("foot", &steps)),
            ([false; 2], [true; 2])
        );
        let private = [("highway", "service"), ("access", "private")];
        assert!(travel("delivery", &private).ends_only);
        assert_eq!(open("foot", &private), [false; 2]);
        assert_eq!(
            open("delivery", &[("highway", "footway"), ("wheelchair", "no")]),
            [false; 2]
        );
    }

    #[test]
    fn the_most_specific_access_tag_counts() {
        let allowed = [
            ("highway", "residential"),
            ("access", "no"),
            ("foot", "yes"),
        ];
        assert_eq!(
            (open("foot", &allowed), open("car", &allowed)),
            ([true; 2], [false; 2])
        );
        // Of several values the most permissive one counts.
        assert_eq!(
            open("foot", &[("highway", "path"), ("foot", "no; permissive")]),
            [true; 2]
        );
    }

    #[test]
    fn one_way_streets_bind_cars_only() {
        let street = [("highway", "residential"), ("oneway", "yes")];
        assert_eq!(
            (open("car", &street), open("delivery", &street)),
            ([true, false], [true; 2])
        );
        assert_eq!(
            open("car", &[("highway", "residential"), ("oneway", "-1")]),
            [false, true]
        );
        assert_eq!(
            open("car", &[("highway", "primary"), ("junction", "roundabout")]),
            [true, false]
        );
        let let_out = [("highway", "motorway"), ("oneway", "no")];
        assert_eq!(open("car", &let_out), [true; 2]);
        assert_eq!(
            open("foot", &[("highway", "footway"), ("conveying", "backward")]),
            [false, true]
        );
    }

    #[test]
    fn tags_for_one_direction_count_there() {
        let pairs = [("highway", "cycleway"), ("foot:forward", "yes")];
        assert_eq!(open("foot", &pairs), [true, false]);
        assert_eq!(
            open("foot", &[("highway", "path"), ("foot:backward", "no")]),
            [true, false]
        );
    }

    /// The rules of `osrm.md` for cycleways, separate pavements and surfaces.
    #[test]
    fn pedestrians_follow_osrms_rules() {
        assert_eq!(open("foot", &[("highway", "cycleway")]), [false; 2]);
        assert_eq!(
            open("foot", &[("highway", "cycleway"), ("access", "yes")]),
            [true; 2]
        );
        assert_eq!(
            open(
                "foot",
                &[("highway", "residential"), ("sidewalk", "separate")]
            ),
            [false; 2]
        );
        let asked = [
            ("highway", "residential"),
            ("sidewalk", "separate"),
            ("foot", "destination"),
        ];
        assert_eq!(open("foot", &asked), [true; 2]);
        let gravel = travel("foot", &[("highway", "track"), ("surface", "gravel")]);
        assert!((gravel.speed - 3.75 / 3.6).abs() < 1e-12);
    }

    #[test]
    fn cars_drive_a_share_of_the_limit() {
        let speed =
            |limit| travel("car", &[("highway", "residential"), ("maxspeed", limit)]).speed * 3.6;
        for (limit, expected) in [
            ("50", 40.0),
            ("30 mph", 30.0 * 1.609_344 * 0.8),
            ("signals", 25.0),
            ("-5", 25.0),
        ] {
            assert!(
                (speed(limit) - expected).abs() < 1e-9,
                "{limit}: {}",
                speed(limit)
            );
        }
    }

    #[test]
    fn squares_are_crossed_or_walked_around() {
        let crossing = [("highway", "pedestrian"), (CROSSING, "yes")];
        assert_eq!(
            (open("delivery", &crossing), open("foot", &crossing)),
            ([true; 2], [false; 2])
        );
    }
}
