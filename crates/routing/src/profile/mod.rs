//! Who may go where, how fast and how gladly: rules over tags, in a TOML file.
//!
//! Tags are read as the OSM wiki's *Key:access* and *Key:highway* describe them: the most specific mode's word counts, words for one
//! direction count before words for both. Words that hold at some times only are not regarded.
//!
//! | module | its one job |
//! |---|---|
//! | `rules` | what such a file may hold |
//! | `way` | what the rules make of a way's words |
//! | `node` | what they make of a node's |

mod node;
mod rules;
mod way;

use std::path::Path;

use openbench_osm::Tags;

pub use node::Passing;
pub use rules::{OutOfRange, Places, Turns};
pub use way::Going;
pub(crate) use way::{CROSSING, TIMETABLE};

use rules::Rules;

/// A means of transport.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    name: String,
    rules: Rules,
}

/// Why there is no such profile.
#[derive(Debug, thiserror::Error)]
pub enum ProfileError {
    /// Neither a built-in profile nor a file.
    #[error("no profile is called {name}: choose {}, or name a TOML file of your own", Profile::NAMES.join(", "))]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// The file cannot be read.
    #[error("cannot read the profile {name}: {source}")]
    Io {
        /// What was asked for.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file is not TOML, or holds other keys than a profile.
    #[error("the profile {name} cannot be used: {source}")]
    Malformed {
        /// What was asked for.
        name: String,
        /// What is wrong, and where.
        source: toml::de::Error,
    },
    /// A number in the file is out of range.
    #[error("the profile {name} cannot be used: {source}")]
    OutOfRange {
        /// What was asked for.
        name: String,
        /// Which number.
        source: OutOfRange,
    },
}

/// What a turn restriction does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RestrictionKind {
    /// It forbids the turns that it names.
    Forbidden,
    /// It forbids all turns but those that it names.
    Only,
}

impl Profile {
    /// The names of the built-in profiles.
    pub const NAMES: [&'static str; 3] = ["delivery", "foot", "car"];

    /// A pavement robot with a parcel.
    #[expect(clippy::expect_used, reason = "the built-in file is tested")]
    pub fn delivery() -> Self {
        Self::named("delivery").expect("the built-in profile can be read")
    }

    /// The built-in profile of that name, or else the profile in the file of that name.
    pub fn open(name: &str) -> Result<Self, ProfileError> {
        if let Some(profile) = Self::named(name) {
            return Ok(profile);
        }
        if !Path::new(name).exists() {
            return Err(ProfileError::Unknown {
                name: name.to_owned(),
            });
        }
        let text = std::fs::read_to_string(name).map_err(|source| ProfileError::Io {
            name: name.to_owned(),
            source,
        })?;
        Self::from_toml(name, &text)
    }

    /// The built-in profile of that name.
    pub fn named(name: &str) -> Option<Self> {
        // The built-in files are tested.
        Self::from_toml(name, Self::text(name)?).ok()
    }

    /// The file of a built-in profile, to begin one's own with.
    pub fn text(name: &str) -> Option<&'static str> {
        match name {
            "delivery" => Some(include_str!("../../profiles/delivery.toml")),
            "foot" => Some(include_str!("../../profiles/foot.toml")),
            "car" => Some(include_str!("../../profiles/car.toml")),
            _ => None,
        }
    }

    /// Reads a profile; `name` is what it is called in errors and answers.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, ProfileError> {
        let rules: Rules = toml::from_str(text).map_err(|source| ProfileError::Malformed {
            name: name.to_owned(),
            source,
        })?;
        rules.check().map_err(|source| ProfileError::OutOfRange {
            name: name.to_owned(),
            source,
        })?;
        Ok(Self {
            name: name.to_owned(),
            rules,
        })
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it is, in words.
    pub fn description(&self) -> &str {
        &self.rules.description
    }

    /// Whether pedestrian areas are crossed or walked round.
    pub fn places(&self) -> Places {
        self.rules.places
    }

    /// What turning costs, if that matters.
    pub fn turns(&self) -> Option<&Turns> {
        self.rules.turns.as_ref()
    }

    /// What a turn restriction with these tags means to the profile; `None` if it does not bind it.
    pub fn restricts(&self, tags: &Tags) -> Option<RestrictionKind> {
        let modes = &self.turns()?.restrictions;
        let is_exempt = |list: &str| {
            list.split(';')
                .any(|mode| modes.iter().any(|own| own == mode.trim()))
        };
        if tags.get("except").is_some_and(is_exempt) {
            return None;
        }
        let own = modes
            .iter()
            .find_map(|mode| tags.get(&format!("restriction:{mode}")));
        match own.or_else(|| tags.get("restriction"))? {
            only if only.starts_with("only_") => Some(RestrictionKind::Only),
            no if no.starts_with("no_") => Some(RestrictionKind::Forbidden),
            _ => None,
        }
    }

    /// Seconds that going through a place counts as which may be entered at the route's ends only.
    pub fn entry(&self) -> f64 {
        self.rules.access.entry
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_profiles_can_be_read() {
        for name in Profile::NAMES {
            let profile = Profile::from_toml(name, Profile::text(name).unwrap()).unwrap();
            assert!(!profile.description().is_empty());
        }
    }

    #[test]
    fn wrong_keys_and_values_are_named() {
        let problem = |text: &str| {
            Profile::from_toml("mine.toml", text)
                .unwrap_err()
                .to_string()
        };
        let foot = Profile::text("foot").unwrap();
        let wrong = problem(&foot.replace("[ways.limit]", "[ways.limits]"));
        assert!(
            wrong.contains("mine.toml") && wrong.contains("limits") && wrong.contains("line"),
            "{wrong}"
        );
        for bad in ["-3", "0", "nan", "inf", "1e9"] {
            let wrong =
                problem(&foot.replace("highway.path = 5", &format!("highway.path = {bad}")));
            assert!(wrong.contains("ways.speed highway.path"), "{wrong}");
        }
        assert!(
            problem("").contains("missing field `description`"),
            "{}",
            problem("")
        );
    }

    #[test]
    fn unknown_profiles_are_told_the_known_ones() {
        let error = Profile::open("hovercraft").unwrap_err().to_string();
        assert!(
            error.contains("hovercraft") && error.contains("delivery, foot, car"),
            "{error}"
        );
    }
}
