//! What makes a run harder than the paper's: wrong maps, vague starts, worn robots.
//!
//! A suite names a level (`map = "city"`), or numbers (`[map]`, `shift_m = 3`), which may change a
//! level (`level = "city"`). All are off in the paper's suites. What they draw depends on the seed
//! of the suite, or on that of an episode, and on nothing else.
//!
//! | module | content |
//! |---|---|
//! | `level` | conditions by name, or by numbers |
//! | `map` | `[map]`: how wrong the public map is |
//! | `doors` | `[doors]`: where doors are that no map has |
//! | `plates` | `[plates]`: what door plates are like |
//! | `scenery` | `[scenery]`: what makes streets differ |
//! | `start` | `[start]`: how well an agent knows where it starts |
//! | `robot` | `[robot]`: how far the robot differs from its description |
//! | `camera` | `[camera]`: what is wrong with the camera |
//! | `light` | `[light]`: the hour of day, clouds, lamps |
//! | `weather` | `[weather]`: rain, fog, wet ground |
//! | `lidar` | `[lidar]`: edges, panes and mirrors |
//! | `compute` | `[compute]`: whether computing takes simulated time |

mod camera;
mod compute;
mod doors;
mod level;
mod lidar;
mod light;
mod map;
mod plates;
mod robot;
mod scenery;
mod start;
mod weather;

use openbench_osm::disturb::MapErrors;
use openbench_scene::generate::{Alterations, PlateOptions, SceneryOptions};
use openbench_scene::plates::StreetPlates;
use openbench_scene::scenery::Scenery;
use openbench_sim::lidar::BeamErrors;
use openbench_sim::{CameraErrors, Weather};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

pub(crate) use camera::draw_lens;
pub use compute::Compute;
pub use doors::DoorPlaces;
pub use level::{Condition, ConditionError};
pub use light::LightLevel;
pub use robot::RobotErrors;
pub use start::StartErrors;

/// The conditions, each with its field and type: all that depends on which there are.
macro_rules! conditions {
    ($(#[$about:meta])* pub struct Conditions {
        $( $(#[$doc:meta])* $field:ident: $kind:ty, )*
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
        #[serde(default)]
        pub struct Conditions {
            $(
                $(#[$doc])*
                #[serde(
                    serialize_with = "level::serialize",
                    deserialize_with = "level::deserialize",
                    skip_serializing_if = "Condition::is_off"
                )]
                pub $field: $kind,
            )*
        }

        impl Conditions {
            /// The conditions by name.
            pub const NAMES: &'static [&'static str] = &[$(<$kind>::KEY),*];

            /// Whether nothing is harder than in the paper.
            pub fn are_off(&self) -> bool {
                true $(&& self.$field.is_off())*
            }

            /// Those that are not off, as the command line takes them: `map=city`, and
            /// `map.shift_m=3` for each number that its level has not.
            pub fn words(&self) -> Vec<String> {
                [$(level::words(&self.$field)),*].concat()
            }

            /// The names of a condition's levels; the first one is off.
            ///
            /// # Errors
            /// A condition that there is not.
            pub fn levels(key: &str) -> Result<Vec<&'static str>, ConditionError> {
                match key {
                    $(<$kind>::KEY => Ok(names::<$kind>()),)*
                    _ => Err(unknown(key)),
                }
            }

            /// Sets conditions to levels (`map`, `city`), or numbers of them (`map.shift_m`, `3`),
            /// in any order: numbers change the level that is set with them, or else what was set
            /// before. Of two values for one key the later one counts.
            ///
            /// # Errors
            /// A condition, level or number that there is not, or a number out of its range; then
            /// nothing is changed.
            pub fn set_all<'a>(
                &mut self,
                words: impl IntoIterator<Item = (&'a str, &'a str)>,
            ) -> Result<(), ConditionError> {
                let mut changes: Vec<(&str, Change<'_>)> = Vec::new();
                for (key, value) in words {
                    let (name, number) = match key.split_once('.') {
                        Some((name, number)) => (name, Some(number)),
                        None => (key, None),
                    };
                    if !Self::NAMES.contains(&name) {
                        return Err(unknown(key));
                    }
                    let at = changes.iter().position(|(known, _)| *known == name);
                    let at = at.unwrap_or_else(|| {
                        changes.push((name, Change::default()));
                        changes.len() - 1
                    });
                    changes[at].1.add(number, value);
                }
                let mut changed = *self;
                for (name, change) in changes {
                    match name {
                        $(<$kind>::KEY => changed.$field = change.of(changed.$field)?,)*
                        _ => return Err(unknown(name)),
                    }
                }
                *self = changed;
                Ok(())
            }

            /// Sets one of them, see [`set_all`](Self::set_all).
            ///
            /// # Errors
            /// As [`set_all`](Self::set_all).
            pub fn set(&mut self, key: &str, value: &str) -> Result<(), ConditionError> {
                self.set_all([(key, value)])
            }
        }
    };
}

conditions! {
    /// The conditions of a suite; all off by default.
    ///
    /// ```
    /// use openbench_bench::suite::Conditions;
    ///
    /// let mut conditions = Conditions::default();
    /// assert!(conditions.are_off());
    /// conditions.set("map", "city")?;
    /// conditions.set("map.missing", "0.1")?;
    /// assert_eq!((conditions.map.shift_m, conditions.map.missing), (1.5, 0.1));
    /// assert!(conditions.set("map", "village").unwrap_err().to_string().contains("exact, good"));
    /// # Ok::<(), openbench_bench::suite::ConditionError>(())
    /// ```
    pub struct Conditions {
        /// How wrong the public map is.
        map: MapErrors,
        /// How well agents know where they start.
        start: StartErrors,
        /// How far the robot differs from its description.
        robot: RobotErrors,
        /// What is wrong with the camera.
        camera: CameraErrors,
        /// The hour of day, clouds, lamps.
        light: LightLevel,
        /// Rain, fog, wet ground.
        weather: Weather,
        /// What is wrong with the LiDAR's returns.
        lidar: BeamErrors,
        /// Where doors are that no map has.
        doors: DoorPlaces,
        /// What door plates are like, and other text.
        plates: StreetPlates,
        /// What makes streets differ: ground, shapes, things in the way, steps and kerbs.
        scenery: Scenery,
        /// Whether computing takes simulated time.
        compute: Compute,
    }
}

impl Conditions {
    /// What they change about the world itself, drawn from the seed of a run.
    pub fn alterations(&self, seed: u64) -> Alterations {
        let plates = PlateOptions {
            shares: self.plates,
            seed,
        };
        Alterations {
            // Without the seed where it draws nothing, so that equal worlds are known as equal.
            plates: match self.plates.is_off() {
                true => PlateOptions::default(),
                false => plates,
            },
            drawn_doors: self.doors.drawn.then_some(seed),
            scenery: match self.scenery.is_off() {
                true => SceneryOptions::default(),
                false => SceneryOptions {
                    amounts: self.scenery,
                    seed,
                },
            },
        }
    }

    /// Those that change nothing about the world itself.
    #[must_use]
    pub fn outside_world(self) -> Self {
        Self {
            plates: StreetPlates::off(),
            doors: DoorPlaces::off(),
            scenery: Scenery::off(),
            ..self
        }
    }
}

fn unknown(key: &str) -> ConditionError {
    let known = Conditions::NAMES.join(", ");
    ConditionError {
        key: key.to_owned(),
        problem: format!("there is no such condition; there are {known}"),
    }
}

fn names<C: Condition>() -> Vec<&'static str> {
    C::LEVELS.iter().map(|(name, _)| *name).collect()
}

/// What is to be changed about one condition.
#[derive(Default)]
struct Change<'a> {
    level: Option<&'a str>,
    numbers: Map<String, Value>,
}

impl<'a> Change<'a> {
    fn add(&mut self, number: Option<&str>, value: &'a str) {
        match number {
            None => self.level = Some(value),
            Some(number) => {
                // Numbers and truth values; anything else is reported where it is no number.
                let value = value.parse().unwrap_or_else(|_| Value::from(value));
                self.numbers.insert(number.to_owned(), value);
            }
        }
    }

    /// A condition with these changes.
    fn of<C: Condition>(&self, before: C) -> Result<C, ConditionError> {
        let base = match self.level {
            Some(name) => level::named(name)?,
            None => before,
        };
        level::changed(base, &self.numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Conditions, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_level_is_its_name_or_a_table_that_changes_one() {
        let conditions = read("map = \"city\"\nstart = \"5m\"").unwrap();
        assert_eq!(conditions.map, MapErrors::CITY);
        assert_eq!(conditions.start.level(), Some("5m"));
        let changed = read("[map]\nlevel = \"city\"\nshift_m = 3").unwrap();
        assert_eq!(changed.map.shift_m, 3.0);
        assert_eq!(changed.map.building_shift_m, 1.5);
        assert_eq!(read("[map]\nmissing = 0.1").unwrap().map.missing, 0.1);
    }

    #[test]
    fn conditions_are_equal_after_writing_and_reading() {
        for text in [
            "",
            "map = \"poor\"",
            "[map]\nshift_m = 3.5\n[start]\narea_m = 20.0",
            "camera = \"cheap\"\nlight = \"night\"",
            "[camera]\nlevel = \"good\"\ndrops = 7\n[light]\ndrawn = true",
        ] {
            let conditions = read(text).unwrap();
            let toml = toml::to_string(&conditions).unwrap();
            assert_eq!(read(&toml).unwrap(), conditions, "{toml}");
            let json = serde_json::to_string(&conditions).unwrap();
            assert_eq!(
                serde_json::from_str::<Conditions>(&json).unwrap(),
                conditions
            );
        }
        assert_eq!(toml::to_string(&Conditions::default()).unwrap(), "");
        let city = read("map = \"city\"").unwrap();
        assert_eq!(toml::to_string(&city).unwrap().trim(), "map = \"city\"");
    }

    #[test]
    fn what_cannot_be_is_refused_with_what_can() {
        for (text, expected) in [
            (
                "map = \"citty\"",
                "no level `citty`; write one of exact, good, city, poor",
            ),
            ("map = 3", "write the name of a level, or a table"),
            ("[map]\nshift = 3", "there is no `shift`; there are level, "),
            (
                "[map]\nshift_m = -3",
                "shift_m = -3: give a number from 0 to 100",
            ),
            (
                "[map]\nmissing = 1.5",
                "missing = 1.5: give a number from 0 to 1",
            ),
            ("[map]\nmissing = \"all\"", "invalid type"),
            ("[start]\nyaw_deg = nan", "start: invalid type"),
            (
                "[robot]\nencoder_marks = 0",
                "encoder_marks = 0: give at least 1",
            ),
            ("[robot]\nencoder_marks = -1", "invalid value"),
            ("[start]\nlevel = 5", "level: write its name in quotes"),
            (
                "camera = \"old\"",
                "no level `old`; write one of perfect, good, cheap",
            ),
            (
                "[camera]\nvignetting = 1.5",
                "vignetting = 1.5: give a number from 0 to 1",
            ),
            (
                "[camera]\nreadout_ms = -1",
                "readout_ms = -1: give a number from 0 to 50",
            ),
            ("[camera]\ndrops = -1", "invalid value"),
            ("weather = \"snow\"", "write one of dry, wet, rain, fog"),
            (
                "[weather]\nrain_mm_h = -2",
                "rain_mm_h = -2: give a number from 0 to 200",
            ),
            (
                "[lidar]\nglass = 1.5",
                "glass = 1.5: give a number from 0 to 1",
            ),
            ("doors = \"real\"", "write one of mapped, drawn"),
            ("[doors]\ndrawn = 3", "invalid type"),
            ("light = \"dawn\"", "write one of noon, day, overcast, dusk"),
            (
                "[light]\nclouds = 2",
                "clouds = 2: give a number from 0 to 1",
            ),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
        let mut conditions = Conditions::default();
        for (key, value, expected) in [
            (
                "maps",
                "city",
                "there is no such condition; there are map, start, robot, ",
            ),
            ("map.shift_m", "far", "map: "),
            ("map.shift_m", "-1", "shift_m = -1: give a number"),
            ("start", "20m", "no level `20m`"),
        ] {
            let error = conditions.set(key, value).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        assert!(conditions.are_off());
    }

    #[test]
    fn every_level_of_every_condition_can_be_set() {
        for key in Conditions::NAMES {
            for (i, level) in Conditions::levels(key).unwrap().into_iter().enumerate() {
                let mut conditions = Conditions::default();
                conditions.set(key, level).unwrap();
                assert_eq!(conditions.are_off(), i == 0, "{key}={level}");
                let words = conditions.words();
                assert_eq!(words.len(), usize::from(i > 0), "{words:?}");
            }
        }
        assert!(Conditions::levels("maps").is_err());
    }

    #[test]
    fn conditions_in_words_set_them_again() {
        let mut conditions = Conditions::default();
        assert!(conditions.words().is_empty());
        for (key, value) in [("map", "city"), ("start", "5m"), ("start.yaw_deg", "7.5")] {
            conditions.set(key, value).unwrap();
        }
        let words = conditions.words();
        assert_eq!(words, ["map=city", "start=5m", "start.yaw_deg=7.5"]);
        for text in [
            "[plates]\nlevel = \"real\"\nmissing = 0.2\ndirty = 0.0",
            "[light]\nlevel = \"dusk\"\nclouds = 0.7",
            "[light]\ndrawn = true\nsun_from_deg = 60.0\nsun_to_deg = 61.0",
            "[lidar]\nglass = 0.5\nghosts = 0.2",
            "[map]\nmissing = 0.25\n[doors]\ndrawn = true",
        ] {
            let conditions = read(text).unwrap();
            let words = conditions.words();
            let mut again = Conditions::default();
            // Backwards too: their order does not matter.
            let backwards = words.iter().rev().map(|word| word.split_once('=').unwrap());
            again.set_all(backwards).unwrap();
            assert_eq!(again, conditions, "{words:?}");
        }
    }

    #[test]
    fn numbers_that_belong_together_are_checked_together() {
        let set = |words: &[(&str, &str)]| {
            let mut conditions = Conditions::default();
            let set = conditions.set_all(words.iter().copied());
            set.map(|()| conditions).map_err(|error| error.to_string())
        };
        let ghosts = set(&[("lidar.ghosts", "0.1"), ("lidar.glass", "0.5")]).unwrap();
        assert_eq!(ghosts.lidar.ghosts, 0.1);
        let low = [("light.sun_to_deg", "3"), ("light.sun_from_deg", "2")];
        let low = set(&[("light", "day"), low[0], low[1]]).unwrap();
        assert_eq!((low.light.sun_from_deg, low.light.sun_to_deg), (2.0, 3.0));
        let plates = set(&[("plates.missing", "0.1"), ("plates", "real")]).unwrap();
        assert!(plates.plates.real && plates.plates.missing == 0.1);
        assert!(
            set(&[("lidar.ghosts", "0.1")])
                .unwrap_err()
                .contains("set glass too")
        );
        let (wrong, before) = (
            set(&[("map", "city"), ("start", "9m")]),
            Conditions::default(),
        );
        assert!(wrong.unwrap_err().contains("no level `9m`"));
        assert!(before.are_off());
    }
}
