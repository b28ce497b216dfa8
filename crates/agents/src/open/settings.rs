//! OPEN's settings, as written with `--set KEY=VALUE`, and the constants that its parts are tuned
//! to.

use std::collections::BTreeMap;
use std::error::Error;

use openbench_core::{RobotDescription, UnknownName};
use openbench_models::{Budget, BudgetError};
use openbench_motion::costmap::Preferences;
use openbench_motion::teb::Margins;
use openbench_motion::{PlannerSettings, TebSettings};
use openbench_vision::ReaderSettings;

/// The keys of [`Settings`].
pub(super) const KEYS: [&str; 8] = [
    "planner",
    "reader",
    "localizer",
    "fixes",
    "motion",
    "ground",
    "budget",
    "thinking",
];
/// The planner that needs no model.
pub const GRAMMAR: &str = "grammar";
/// The plate reader by default.
pub const DEFAULT_READER: &str = "ppocr-v4";
/// The localizer by default.
pub const DEFAULT_LOCALIZER: &str = "fused";
/// The source of fixes by default, of a localizer that takes some.
pub const DEFAULT_FIXES: &str = "osm";
/// The source that gives no fixes. Every localizer takes it.
pub const NO_FIXES: &str = "none";

/// What OPEN is made of. Each field is a key of `--set`.
///
/// ```
/// use std::collections::BTreeMap;
///
/// use openbench_agents::open::Settings;
///
/// let words = BTreeMap::from([("localizer".to_owned(), "dead-reckoning".to_owned())]);
/// let settings = Settings::parse(&words)?;
/// assert_eq!(settings.localizer, "dead-reckoning");
/// assert_eq!(settings.planner, "grammar");
/// # Ok::<(), openbench_agents::open::SettingsError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// `planner`: `grammar`, a chat model as [`ModelSpec`](openbench_models::ModelSpec) has it, or
    /// such a model with the grammar as fallback, as in `ollama:qwen2.5,grammar`.
    pub planner: String,
    /// `reader`: plate readers that are asked in turn, separated by commas; each a name of
    /// [`Catalogue::readers`](super::Catalogue::readers) or a vision model.
    pub reader: String,
    /// `localizer`: a name of [`Catalogue::localizers`](super::Catalogue::localizers).
    pub localizer: String,
    /// `fixes`: a name of [`Catalogue::fixes`](super::Catalogue::fixes), with its argument after a
    /// colon. `None` means [`DEFAULT_FIXES`] for a localizer that takes fixes, and none for others.
    pub fixes: Option<String>,
    /// `motion`: a name of [`Catalogue::local_planners`](super::Catalogue::local_planners).
    pub motion: String,
    /// `ground`: `alike`, or `pavements` to prefer them to roads and grass.
    pub ground: Preferences,
    /// `budget`: the most that a mission may ask of models, `CALLS,TOKENS,SECONDS`.
    pub budget: Budget,
    /// `thinking`: whether the robot stands still in the world for as long as models take to
    /// answer: `free` or `charged`.
    pub thinks_in_simulated_time: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            planner: GRAMMAR.into(),
            reader: DEFAULT_READER.into(),
            localizer: DEFAULT_LOCALIZER.into(),
            fixes: None,
            motion: "teb".into(),
            ground: Preferences::NONE,
            budget: Budget::default(),
            thinks_in_simulated_time: false,
        }
    }
}

/// A setting that OPEN does not have, or a value that it does not know.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// There is no such key.
    #[error("there is no setting `{key}`; known: {}", KEYS.join(", "))]
    UnknownKey {
        /// What was written.
        key: String,
    },
    /// No part is registered under that name.
    #[error("{key}={value}")]
    UnknownPart {
        /// The key.
        key: &'static str,
        /// What was written.
        value: String,
        /// What there is.
        source: UnknownName,
    },
    /// The value is none of a few words.
    #[error("{key}={value}: write {expected}")]
    BadWord {
        /// The key.
        key: &'static str,
        /// What was written.
        value: String,
        /// The words that there are.
        expected: &'static str,
    },
    /// The value is no planner and no chat model that can be opened.
    #[error("planner={value} (the alternative is grammar)")]
    Planner {
        /// What was written.
        value: String,
        /// Why it is no chat model that can be opened.
        source: Box<dyn Error + Send + Sync>,
    },
    /// A part cannot be made.
    #[error("{key}={value}")]
    Part {
        /// The key.
        key: &'static str,
        /// What was written.
        value: String,
        /// Why.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The localizer takes no fixes.
    #[error(
        "fixes={fixes}: localizer={localizer} takes no fixes; use localizer=fused, or drop fixes"
    )]
    TakesNoFixes {
        /// The value of `fixes`.
        fixes: String,
        /// The value of `localizer`.
        localizer: String,
    },
}

impl Settings {
    /// Reads settings from keys and values. Keys that are left out keep their defaults.
    ///
    /// # Errors
    /// [`SettingsError`] for a key or a value that does not exist. Names of parts are looked up by
    /// [`Catalogue::assemble`](super::Catalogue::assemble).
    pub fn parse(words: &BTreeMap<String, String>) -> Result<Self, SettingsError> {
        let mut settings = Self::default();
        for (key, value) in words {
            settings.set(key, value)?;
        }
        Ok(settings)
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), SettingsError> {
        match key {
            "planner" => self.planner = value.to_owned(),
            "reader" => self.reader = value.to_owned(),
            "localizer" => self.localizer = value.to_owned(),
            "fixes" => self.fixes = Some(value.to_owned()),
            "motion" => self.motion = value.to_owned(),
            "ground" => self.ground = ground(value)?,
            "budget" => self.budget = budget(value)?,
            "thinking" => self.thinks_in_simulated_time = thinking(value)?,
            _ => {
                return Err(SettingsError::UnknownKey {
                    key: key.to_owned(),
                });
            }
        }
        Ok(())
    }
}

fn ground(value: &str) -> Result<Preferences, SettingsError> {
    match value {
        "alike" => Ok(Preferences::NONE),
        "pavements" => Ok(Preferences::default()),
        _ => Err(bad_word("ground", value, "alike or pavements")),
    }
}

fn thinking(value: &str) -> Result<bool, SettingsError> {
    match value {
        "free" => Ok(false),
        "charged" => Ok(true),
        _ => Err(bad_word(
            "thinking",
            value,
            "free, or charged for models that take simulated time",
        )),
    }
}

fn budget(value: &str) -> Result<Budget, SettingsError> {
    value
        .parse()
        .map_err(|error: BudgetError| SettingsError::Part {
            key: "budget",
            value: value.to_owned(),
            source: error.into(),
        })
}

fn bad_word(key: &'static str, value: &str, expected: &'static str) -> SettingsError {
    SettingsError::BadWord {
        key,
        value: value.to_owned(),
        expected,
    }
}

/// Distance from a place at which OPEN has arrived, metres: what it looks at is metres away.
const GOAL_TOLERANCE_M: f64 = 0.15;
/// Distances that OPEN keeps. Static obstacles are known to half a cell of its costmap, and cars
/// bulge between the rings of the LiDAR.
const MARGINS: Margins = Margins {
    least: 0.06,
    moving: 0.3,
    comfort: 0.35,
};
/// How much faster than predicted people may approach, m/s: they accelerate and turn at will.
const PEOPLE_SPEED_MARGIN_MPS: f64 = 0.7;
/// Time that a person needs to stop, seconds: half a second, and the predictions lag a little.
const PEOPLE_STOPPING_TIME_S: f64 = 0.6;
/// What a metre of path costs, in seconds. SPL counts the path's length too, so OPEN rather turns
/// on the spot than drives an arc.
const PATH_COST_S_PER_M: f64 = 12.0;
/// The camera is level and lower than any plate, so nothing below the horizon is read: the part of
/// the image above it, with some to spare.
const IMAGE_PART_ABOVE_HORIZON: f32 = 0.6;
/// Seed of local planners that draw random numbers: runs repeat.
const PLANNER_SEED: u64 = 1;

/// The settings of OPEN's Timed Elastic Band.
pub fn teb() -> TebSettings {
    let mut settings = TebSettings {
        tolerance: GOAL_TOLERANCE_M,
        approach_margin_mps: Some(PEOPLE_SPEED_MARGIN_MPS),
        ..TebSettings::default()
    };
    settings.stopping_time_s = Some(PEOPLE_STOPPING_TIME_S);
    settings.band.margins = MARGINS;
    settings.band.weights.length = PATH_COST_S_PER_M;
    settings
}

/// The settings that all of OPEN's local planners are made from.
pub fn planning(robot: &RobotDescription) -> PlannerSettings {
    PlannerSettings::new(robot.clone()).with_seed(PLANNER_SEED)
}

/// The settings of OPEN's plate readers.
pub fn reading() -> ReaderSettings {
    ReaderSettings::default().with_upper_part(IMAGE_PART_ABOVE_HORIZON)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(key: &str, value: &str) -> Result<Settings, SettingsError> {
        Settings::parse(&BTreeMap::from([(key.to_owned(), value.to_owned())]))
    }

    #[test]
    fn what_is_not_set_keeps_its_default() {
        assert_eq!(
            Settings::parse(&BTreeMap::new()).unwrap(),
            Settings::default()
        );
        let charged = parse("thinking", "charged").unwrap();
        assert_eq!(
            charged,
            Settings {
                thinks_in_simulated_time: true,
                ..Settings::default()
            }
        );
    }

    #[test]
    fn every_key_can_be_set() {
        for key in KEYS {
            let value = match key {
                "ground" => "pavements",
                "budget" => "1,2,3",
                "thinking" => "charged",
                _ => "something",
            };
            assert_ne!(parse(key, value).unwrap(), Settings::default(), "{key}");
        }
    }

    #[test]
    fn errors_name_key_value_and_what_there_is() {
        let error = parse("colour", "red").unwrap_err().to_string();
        assert!(
            error.contains("`colour`") && error.contains("planner, reader"),
            "{error}"
        );
        let error = parse("ground", "sand").unwrap_err().to_string();
        assert!(
            error.contains("ground=sand") && error.contains("pavements"),
            "{error}"
        );
        assert!(
            parse("budget", "much")
                .unwrap_err()
                .to_string()
                .contains("budget=much")
        );
    }
}
