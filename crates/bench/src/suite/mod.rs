//! Suites: a world and the episodes in it, as files. Pure data: worlds are loaded by
//! [`worlds`](crate::worlds).
//!
//! | module | content |
//! |---|---|
//! | `source` | [`WorldSource`]: the source of the world |
//! | `target_source` | [`TargetSource`]: where the requested doors are known from |
//! | `goal` | [`GoalKind`]: what agents are told to do |
//! | `sensors` | [`Sensors`]: sensors in addition to the benchmark's own |
//! | `conditions` | [`Conditions`]: what makes a run harder than the paper's |
//! | `builtin` | the contents of the built-in suites |
//! | [`split`] | [`Split`](split::Split): what worlds and seeds may be used for |
//! | `tracks` | [`Track`]: suites that say how hard they are |
//! | [`deliveries`] | files of deliveries, with or without annotations |
//! | [`truth_file`] | the published files of true door positions |
//! | [`draw`] | random deliveries with instructions |

pub(crate) mod builtin;
mod conditions;
pub mod deliveries;
pub mod draw;
mod goal;
mod sensors;
mod source;
pub mod split;
mod target_source;
pub(crate) mod tracks;
pub mod truth_file;

use std::path::{Path, PathBuf};

use openbench_core::Address;
use openbench_scene::generate::Alterations;
use openbench_sim::traffic::TrafficPlan;
use serde::{Deserialize, Serialize};

pub(crate) use self::conditions::draw_lens;
pub use self::conditions::{
    Compute, Condition, ConditionError, Conditions, DoorPlaces, LightLevel, RobotErrors,
    StartErrors,
};
pub use self::goal::GoalKind;
pub use self::sensors::Sensors;
pub use self::source::WorldSource;
pub use self::target_source::TargetSource;
pub use self::tracks::{TRACKS, Track};
use crate::BenchError;

/// One episode: an instruction and the doors that it requests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Episode {
    /// The instruction for the agent.
    pub instruction: String,
    /// Addresses of the requested doors, each once; empty if only their positions are known.
    pub deliveries: Vec<Address>,
    /// Pairs of indices into `deliveries`: the first has to be visited before the second. Without
    /// pairs every order is admissible.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub before: Vec<(usize, usize)>,
}

impl Episode {
    /// An instruction whose doors are not known.
    pub fn unannotated(instruction: impl Into<String>) -> Self {
        Self {
            instruction: instruction.into(),
            deliveries: Vec::new(),
            before: Vec::new(),
        }
    }

    /// Checks that each door is named once and that `before` names two of them.
    ///
    /// # Errors
    /// What is wrong, in words.
    fn check(&self) -> Result<(), String> {
        for (i, door) in self.deliveries.iter().enumerate() {
            if self.deliveries[..i].iter().any(|d| d.same_door(door)) {
                return Err(format!("{door} is named twice; name each door once"));
            }
        }
        let count = self.deliveries.len();
        let is_pair = |&(a, b): &(usize, usize)| a < count && b < count && a != b;
        match self.before.iter().find(|pair| !is_pair(pair)) {
            Some((a, b)) => Err(format!(
                "`before` has the pair {a}, {b}; write two different indices below the number of \
                 deliveries, {count}"
            )),
            None => Ok(()),
        }
    }
}

/// Most people, and most cars, that a suite may ask for. A neighbourhood has space for hundreds.
const MOST_MOVERS: usize = 10_000;

/// A world and the episodes in it.
///
/// ```
/// use openbench_bench::{Sensors, Suite, WorldSource, suite::Episode};
/// use openbench_core::Address;
///
/// let suite = Suite {
///     name: "one-parcel".into(),
///     world: WorldSource::Builtin { name: "small".into(), seed: 1 },
///     traffic: Default::default(),
///     episodes: vec![Episode {
///         instruction: "Please take this parcel to unit2, building1.".into(),
///         deliveries: vec![Address::new("building1", "unit2")],
///         before: vec![],
///     }],
///     targets: Default::default(),
///     goal: Default::default(),
///     sensors: Sensors::default(),
///     conditions: Default::default(),
///     seed: 0,
/// };
/// assert!(suite.to_toml().contains("building = \"building1\""));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Name of the suite in results.
    pub name: String,
    /// The world.
    pub world: WorldSource,
    /// Where the doors of the episodes are known from.
    #[serde(default)]
    pub targets: TargetSource,
    /// What agents are told to do: the instruction, by default.
    #[serde(default, skip_serializing_if = "GoalKind::is_instruction")]
    pub goal: GoalKind,
    /// Moving people and cars; none by default and in the published suites.
    #[serde(default, skip_serializing_if = "TrafficPlan::is_empty")]
    pub traffic: TrafficPlan,
    /// The episodes, all starting at the world's start pose.
    pub episodes: Vec<Episode>,
    /// Sensors in addition to the benchmark's own.
    #[serde(default, skip_serializing_if = "Sensors::none")]
    pub sensors: Sensors,
    /// What makes runs harder than the paper's, a key each: [`Conditions::NAMES`].
    #[serde(flatten)]
    pub conditions: Conditions,
    /// Seed of what the conditions draw for all episodes alike; that of a run takes its place.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub seed: u64,
}

fn is_zero(seed: &u64) -> bool {
    *seed == 0
}

impl Suite {
    /// Reads a suite from a TOML file. Relative paths in it count from the file's folder.
    ///
    /// # Errors
    /// [`BenchError::File`], [`BenchError::WrongFormat`], or [`BenchError::BadFile`] for a suite
    /// without episodes.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let text = openbench_core::input::read_text(path).map_err(|e| BenchError::file(path, e))?;
        let suite: Self =
            toml::from_str(&text).map_err(|e| BenchError::wrong_format(path, "suite", e))?;
        if suite.episodes.is_empty() {
            return Err(BenchError::bad_file(path, "the suite has no episodes"));
        }
        if suite.traffic.pedestrians.max(suite.traffic.cars) > MOST_MOVERS {
            let problem = format!("[traffic]: at most {MOST_MOVERS} pedestrians and as many cars");
            return Err(BenchError::bad_file(path, problem));
        }
        for (number, episode) in suite.episodes.iter().enumerate() {
            let bad = |problem| format!("episode {number}: {problem}");
            let checked = episode.check().map_err(bad);
            checked.map_err(|problem| BenchError::bad_file(path, problem))?;
        }
        Ok(suite.relative_to(path.parent().unwrap_or(Path::new("."))))
    }

    /// What the conditions change about the world itself, with the suite's seed.
    pub fn alterations(&self) -> Alterations {
        self.conditions.alterations(self.seed)
    }

    /// Whether maps, their frames, robots or surroundings of this suite differ from seed to seed.
    pub fn depends_on_seed(&self) -> bool {
        // Starts are drawn for each episode, and costs of computing are the same for all.
        let drawn = Conditions {
            start: StartErrors::default(),
            compute: Compute::default(),
            ..self.conditions
        };
        !drawn.are_off()
    }

    /// The suite as it is with a run's seed.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        // Where nothing depends on it, suites of different runs are equal.
        let seed = if self.depends_on_seed() { seed } else { 0 };
        Self { seed, ..self }
    }

    /// The suite as a TOML file.
    pub fn to_toml(&self) -> String {
        // Only strings, integers, booleans and lists: every value has a TOML form.
        toml::to_string_pretty(self).unwrap_or_default()
    }

    /// The suite with its relative paths resolved against `folder`.
    fn relative_to(mut self, folder: &Path) -> Self {
        let paths: Vec<&mut PathBuf> = match &mut self.world {
            WorldSource::Builtin { .. } | WorldSource::Drawn { .. } => Vec::new(),
            WorldSource::Imported {
                world, map, models, ..
            } => [world, map].into_iter().chain(models).collect(),
            WorldSource::Folder { path } => vec![path],
        };
        for path in paths {
            // Absolute, since the suite is copied into `run.json`, which lies in another folder.
            let joined = folder.join(&*path);
            *path = std::path::absolute(&joined).unwrap_or(joined);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::builtin_suite;
    use openbench_core::with_causes;

    #[test]
    fn a_suite_is_equal_after_writing_and_reading() {
        let suite = Suite {
            goal: GoalKind::default(),
            name: "yard".into(),
            world: WorldSource::Imported {
                world: "yard.world".into(),
                map: "yard.osm".into(),
                models: vec!["models".into()],
                georeference: Some("utm:50N,-500000,-4483000".into()),
            },
            traffic: TrafficPlan {
                pedestrians: 5,
                cars: 0,
            },
            episodes: vec![Episode {
                instruction: "To unit1, building2, \"please\".".into(),
                deliveries: vec![Address::new("building2", "unit1")],
                before: vec![],
            }],
            targets: TargetSource::World,
            sensors: Sensors { gnss: true },
            conditions: Conditions::default(),
            seed: 0,
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("yard.toml");
        std::fs::write(&path, suite.to_toml()).unwrap();
        let read = Suite::read(&path).unwrap();
        assert_eq!(
            (read.traffic, &read.episodes),
            (suite.traffic, &suite.episodes)
        );
        assert_eq!((read.sensors, read.targets), (suite.sensors, suite.targets));
        let WorldSource::Imported { world, .. } = read.world else {
            panic!("another source")
        };
        assert_eq!(world, folder.path().join("yard.world"));
    }

    #[test]
    fn there_is_traffic_only_if_a_suite_requests_it() {
        assert!(builtin_suite("small").unwrap().traffic.is_empty());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("crowded.toml");
        let without_traffic = builtin_suite("small").unwrap().to_toml();
        assert!(!without_traffic.contains("traffic"));
        std::fs::write(
            &path,
            format!("{without_traffic}\n[traffic]\npedestrians = 12\n"),
        )
        .unwrap();
        assert_eq!(
            Suite::read(&path).unwrap().traffic,
            TrafficPlan {
                pedestrians: 12,
                cars: 0
            }
        );
        std::fs::write(
            &path,
            format!("{without_traffic}\n[traffic]\npedestrian = 12\n"),
        )
        .unwrap();
        assert!(with_causes(&Suite::read(&path).unwrap_err()).contains("pedestrian"));
    }

    #[test]
    fn the_robot_has_a_gnss_receiver_only_if_a_suite_requests_it() {
        let plain = "name = 'a'\n[world.builtin]\nname = 'small'\nseed = 1\n\
                     [[episodes]]\ninstruction = 'x'\ndeliveries = []\n";
        let sensors =
            |text: &str| toml::from_str::<Suite>(text).map(|s| s.sensors.robot().gnss.is_some());
        assert_eq!(sensors(plain), Ok(false));
        assert_eq!(
            sensors(&format!("{plain}[sensors]\ngnss = true\n")),
            Ok(true)
        );
        assert!(
            sensors(&format!("{plain}[sensors]\nradar = true\n"))
                .unwrap_err()
                .to_string()
                .contains("radar")
        );
        assert!(
            !toml::from_str::<Suite>(plain)
                .unwrap()
                .to_toml()
                .contains("sensors")
        );
    }

    #[test]
    fn conditions_are_keys_of_suites() {
        let plain = "name = 'a'\n[world.builtin]\nname = 'small'\nseed = 1\n\
                     [[episodes]]\ninstruction = 'x'\ndeliveries = []\n";
        let read = |text: &str| toml::from_str::<Suite>(text).map_err(|e| e.to_string());
        assert!(read(plain).unwrap().conditions.are_off());
        let hard = read(&format!(
            "map = 'poor'\nseed = 4\n{plain}[start]\narea_m = 30\n"
        ));
        let hard = hard.unwrap();
        assert_eq!(hard.conditions.map.level(), Some("poor"));
        assert_eq!((hard.conditions.start.area_m, hard.seed), (30.0, 4));
        assert_eq!(read(&hard.to_toml()).unwrap(), hard);
        let error = read(&format!("maps = 'poor'\n{plain}")).unwrap_err();
        assert!(error.contains("maps"), "{error}");
    }

    #[test]
    fn a_seed_counts_where_something_depends_on_it() {
        let suite = builtin_suite("small").unwrap();
        assert_eq!(suite.clone().with_seed(7), suite);
        let mut wrong = suite;
        wrong.conditions.set("map", "good").unwrap();
        assert_eq!(wrong.with_seed(7).seed, 7);
    }

    #[test]
    fn a_file_that_is_no_suite_is_reported_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nonsense.toml");
        std::fs::write(&path, "name = 3").unwrap();
        assert!(with_causes(&Suite::read(&path).unwrap_err()).contains("nonsense.toml"));
    }
}
