//! What a profile makes of a way's words.

use openbench_osm::Tags;

use super::rules::{Access, listed, matching};
use super::{Places, Profile};

/// How a way is travelled in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Going {
    /// Metres a second.
    pub speed: f64,
    /// How much longer a second counts than it is.
    pub cost: f64,
    /// Whether only those may go here who begin or end here.
    pub ends_only: bool,
}

/// Key under which the crossing of a pedestrian area is told from its outline.
pub(crate) const CROSSING: &str = "openbench:crossing";
/// Key under which a ferry has the speed of its timetable, km/h.
pub(crate) const TIMETABLE: &str = "openbench:timetable";

/// What an access word means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    Open,
    AtEnds,
    Closed,
    Other,
}

impl Access {
    /// Of several words the one that opens most counts; a word that is not known counts least.
    fn word(&self, value: &str) -> Word {
        let has = |list: &[String]| {
            value
                .split(';')
                .any(|part| list.iter().any(|word| word == part.trim()))
        };
        let lists = [
            (&self.open, Word::Open),
            (&self.at_ends, Word::AtEnds),
            (&self.closed, Word::Closed),
        ];
        lists
            .into_iter()
            .find(|(list, _)| has(list))
            .map_or(Word::Other, |(_, word)| word)
    }

    /// What is said of a direction, `:forward` or `:backward`.
    fn directed(&self, tags: &Tags, direction: &str) -> Option<Word> {
        let value = self.keys.iter().find_map(|key| {
            tags.get(&format!("{key}{direction}"))
                .or_else(|| tags.get(key))
        });
        value.map(|value| self.word(value))
    }

    /// What is said of a node.
    pub(super) fn node_closed(&self, tags: &Tags) -> Option<bool> {
        let value = self.keys.iter().find_map(|key| tags.get(key))?;
        Some(self.closed.iter().any(|word| word == value))
    }

    /// Whether a node is for those only who begin or end near it.
    pub(super) fn node_at_ends(&self, tags: &Tags) -> bool {
        let value = self.keys.iter().find_map(|key| tags.get(key));
        value.is_some_and(|value| self.at_ends.iter().any(|word| word == value))
    }
}

impl Profile {
    /// How ways with these words are travelled, along their nodes and against them; `None` where one may not go.
    pub fn way(&self, tags: &Tags) -> [Option<Going>; 2] {
        let crossing_only = tags.has(CROSSING) && self.places() == Places::Outline;
        if crossing_only || listed(&self.rules.ways.closed, tags) {
            return [None; 2];
        }
        let open = self.directions(tags);
        let sides = [":forward", ":backward"].map(|side| self.rules.access.directed(tags, side));
        [0, 1].map(|i| open[i].then(|| self.going(tags, sides[i])).flatten())
    }

    fn going(&self, tags: &Tags, word: Option<Word>) -> Option<Going> {
        let ways = &self.rules.ways;
        if word == Some(Word::Closed) || (word.is_none() && listed(&ways.closed_unless_open, tags))
        {
            return None;
        }
        let told = matching(&ways.speed, tags).reduce(f64::max);
        let told = told.or(ways.speed_if_open.filter(|_| word.is_some()))?;
        let timetable = tags.get(TIMETABLE).and_then(|speed| speed.parse().ok());
        let timetable = timetable.filter(|speed| (0.1..=100.0).contains(speed));
        let speed = timetable.or_else(|| self.max_speed(tags)).unwrap_or(told);
        let speed = matching(&ways.limit, tags).fold(speed, f64::min);
        let cost = matching(&ways.cost, tags).product();
        Some(Going {
            speed: speed / 3.6,
            cost,
            ends_only: word == Some(Word::AtEnds),
        })
    }

    /// The share of the way's speed limit that is driven, km/h.
    fn max_speed(&self, tags: &Tags) -> Option<f64> {
        const MILE: f64 = 1.609_344;
        let rule = self.rules.ways.maxspeed.as_ref()?;
        let text = rule.keys.iter().find_map(|key| tags.get(key))?;
        let limit: f64 = match text.strip_suffix("mph") {
            Some(miles) => miles.trim().parse::<f64>().ok()? * MILE,
            None => text.trim_end_matches("km/h").trim().parse().ok()?,
        };
        (1.0..=300.0).contains(&limit).then_some(limit * rule.share)
    }

    /// Whether one-way rules leave each direction open.
    fn directions(&self, tags: &Tags) -> [bool; 2] {
        let rule = &self.rules.ways.oneway;
        let told = rule.keys.iter().find_map(|key| match tags.get(key)? {
            "yes" | "true" | "1" | "forward" => Some([true, false]),
            "-1" | "reverse" | "backward" => Some([false, true]),
            "no" | "false" | "0" | "alternating" => Some([true, true]),
            // Whose turn it is cannot be known.
            "reversible" => Some([false, false]),
            _ => None,
        });
        told.unwrap_or_else(|| [true, !listed(&rule.implied, tags)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(profile: &str, words: &[(&'static str, &'static str)]) -> [bool; 2] {
        let tags: Tags = words.iter().copied().collect();
        Profile::named(profile)
            .unwrap()
            .way(&tags)
            .map(|going| going.is_some())
    }

    fn going(profile: &str, words: &[(&'static str, &'static str)]) -> Going {
        let tags: Tags = words.iter().copied().collect();
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
        assert!(going("delivery", &private).ends_only);
        assert_eq!(open("foot", &private), [false; 2]);
        assert_eq!(
            open("delivery", &[("highway", "footway"), ("wheelchair", "no")]),
            [false; 2]
        );
    }

    #[test]
    fn the_most_specific_word_counts() {
        let allowed = [
            ("highway", "residential"),
            ("access", "no"),
            ("foot", "yes"),
        ];
        assert_eq!(
            (open("foot", &allowed), open("car", &allowed)),
            ([true; 2], [false; 2])
        );
        // And of several the one that opens most.
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
    fn words_for_one_direction_count_there() {
        let words = [("highway", "cycleway"), ("foot:forward", "yes")];
        assert_eq!(open("foot", &words), [true, false]);
        assert_eq!(
            open("foot", &[("highway", "path"), ("foot:backward", "no")]),
            [true, false]
        );
    }

    /// What `osrm.md` says of cycleways, of pavements of their own and of surfaces.
    #[test]
    fn pedestrians_keep_osrms_rules() {
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
        let gravel = going("foot", &[("highway", "track"), ("surface", "gravel")]);
        assert!((gravel.speed - 3.75 / 3.6).abs() < 1e-12);
    }

    #[test]
    fn cars_drive_a_share_of_the_limit() {
        let speed =
            |limit| going("car", &[("highway", "residential"), ("maxspeed", limit)]).speed * 3.6;
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
    fn places_are_crossed_or_walked_round() {
        let crossing = [("highway", "pedestrian"), (CROSSING, "yes")];
        assert_eq!(
            (open("delivery", &crossing), open("foot", &crossing)),
            ([true; 2], [false; 2])
        );
    }
}
