//! Tracks: suites that say how hard they are. Each seed of a run has a neighbourhood of its own.

use openbench_sim::traffic::TrafficPlan;

use super::conditions::{ConditionError, Conditions};

/// A track: neighbourhoods of the kind `medium`, with conditions and traffic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Track {
    /// Its name, and that of its suite.
    pub name: &'static str,
    /// How hard it is, in words.
    pub about: &'static str,
    /// Its conditions, as the command line takes them.
    conditions: &'static [(&'static str, &'static str)],
    /// More conditions, of which each seed has one set.
    either: &'static [&'static [(&'static str, &'static str)]],
    /// People and cars.
    pub traffic: TrafficPlan,
}

/// The kind of neighbourhood of all tracks.
pub const KIND: &str = "medium";

const NOBODY: TrafficPlan = TrafficPlan {
    pedestrians: 0,
    cars: 0,
};

/// All tracks, the easiest first.
pub const TRACKS: [Track; 3] = [
    Track {
        name: "paper",
        about: "as in the paper: the map is exact, the start is known, computing is free, noon",
        conditions: &[],
        either: &[],
        traffic: NOBODY,
    },
    Track {
        name: "street",
        about: "a day in a street: the map of a city, a start off by 5 m, real plates, streets \
                that differ, ten people, five cars, computing takes time",
        conditions: &[
            ("map", "city"),
            ("start", "5m"),
            ("robot", "calibrated"),
            ("doors", "drawn"),
            ("plates", "real"),
            ("scenery", "varied"),
            ("camera", "good"),
            ("light", "day"),
            ("lidar", "real"),
            ("compute", "charged"),
        ],
        either: &[],
        traffic: TrafficPlan {
            pedestrians: 10,
            cars: 5,
        },
    },
    Track {
        name: "hard",
        about: "dusk, rain or night: a poor map, a start somewhere in a block, real plates, \
                streets that differ, forty people, five cars, computing takes time",
        conditions: &[
            ("map", "poor"),
            ("start", "block"),
            ("robot", "worn"),
            ("doors", "drawn"),
            ("plates", "real"),
            ("scenery", "varied"),
            ("camera", "cheap"),
            ("lidar", "real"),
            ("compute", "charged"),
        ],
        either: &[
            &[("light", "dusk")],
            &[("light", "overcast"), ("weather", "rain")],
            &[("light", "night")],
        ],
        traffic: TrafficPlan {
            pedestrians: 40,
            cars: 5,
        },
    },
];

impl Track {
    /// The track of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        TRACKS.iter().find(|track| track.name == name)
    }

    /// Its conditions for the seed of a run.
    ///
    /// # Errors
    /// A condition or level that there is not: none of the tracks has one.
    pub fn conditions(&self, seed: u64) -> Result<Conditions, ConditionError> {
        let mut conditions = Conditions::default();
        let one_of = match self.either.len() {
            0 => &[],
            // In turn, so that ten seeds have all of them.
            count => self.either[(seed % count as u64) as usize],
        };
        conditions.set_all(self.conditions.iter().chain(one_of).copied())?;
        Ok(conditions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_track_has_conditions_that_there_are() {
        for track in &TRACKS {
            for seed in 0..3 {
                track.conditions(seed).unwrap();
            }
        }
        assert!(
            Track::named("paper")
                .unwrap()
                .conditions(5)
                .unwrap()
                .are_off()
        );
        let hard = Track::named("hard").unwrap();
        let of = |seed| hard.conditions(seed).unwrap();
        assert!(of(0) != of(1) && of(1) != of(2) && of(2) != of(0) && of(0) == of(3));
    }
}
