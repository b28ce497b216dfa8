//! Profiles: who may go where, how fast and at which cost, as rules over tags in a TOML file.
//!
//! Tags are read as the OSM wiki's *Key:access* and *Key:highway* describe them: the tag of the
//! most specific mode counts, and tags for one direction count before tags for both. Tags that hold
//! at some times only are ignored.
//!
//! | module | contents |
//! |---|---|
//! | `rules` | the content of such a file |
//! | `way` | the rules applied to a way's tags |
//! | `node` | the rules applied to a node's tags |

mod node;
mod rules;
mod way;

use std::path::Path;

use openbench_osm::Tags;

pub(crate) use node::Passing;
pub use rules::OutOfRange;
pub(crate) use rules::{Places, Turns};
pub use way::Travel;
pub(crate) use way::{CROSSING, TIMETABLE};

use rules::Rules;

/// A means of transport.
///
/// ```
/// use openbench_osm::Tags;
/// use openbench_routing::Profile;
///
/// let delivery = Profile::open("delivery")?;
/// let path = Tags::from([("highway", "footway")]);
/// // 0.5 m/s, in both directions.
/// for travel in delivery.way(&path) {
///     assert_eq!(travel.map(|travel| travel.speed), Some(0.5));
/// }
/// // The robot has no legs.
/// assert_eq!(delivery.way(&Tags::from([("highway", "steps")])), [None; 2]);
/// # Ok::<(), openbench_routing::ProfileError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    name: String,
    rules: Rules,
}

/// Why a profile cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileError {
    /// Neither a built-in profile nor a file.
    #[error(
        "no profile is called {name}: choose {}, or give the path of a TOML file",
        Profile::NAMES.join(", ")
    )]
    Unknown {
        /// The name that was requested.
        name: String,
    },
    /// The file cannot be read.
    #[error("cannot read the profile {name}")]
    Io {
        /// The name that was requested.
        name: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is not TOML, or holds other keys than a profile.
    #[error("the profile {name} cannot be used")]
    Malformed {
        /// The name that was requested.
        name: String,
        /// What is wrong, and where.
        source: toml::de::Error,
    },
    /// A number in the file is out of range.
    #[error("the profile {name} cannot be used")]
    OutOfRange {
        /// The name that was requested.
        name: String,
        /// The number.
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

    /// A pavement robot that delivers parcels.
    #[expect(clippy::expect_used, reason = "the built-in file is tested")]
    pub fn delivery() -> Self {
        Self::named("delivery").expect("the built-in profile can be read")
    }

    /// The built-in profile of that name, else the profile in the file of that name.
    ///
    /// # Errors
    /// If there is neither, or the file cannot be used.
    pub fn open(name: &str) -> Result<Self, ProfileError> {
        if let Some(profile) = Self::named(name) {
            return Ok(profile);
        }
        if !Path::new(name).exists() {
            return Err(ProfileError::Unknown {
                name: name.to_owned(),
            });
        }
        let text = openbench_core::input::read_text(Path::new(name)).map_err(|source| {
            ProfileError::Io {
                name: name.to_owned(),
                source,
            }
        })?;
        Self::from_toml(name, &text)
    }

    /// The built-in profile of that name.
    pub fn named(name: &str) -> Option<Self> {
        // The built-in files are tested.
        Self::from_toml(name, Self::text(name)?).ok()
    }

    /// The file of a built-in profile, as a start for one's own.
    pub fn text(name: &str) -> Option<&'static str> {
        match name {
            "delivery" => Some(include_str!("../../profiles/delivery.toml")),
            "foot" => Some(include_str!("../../profiles/foot.toml")),
            "car" => Some(include_str!("../../profiles/car.toml")),
            _ => None,
        }
    }

    /// Reads a profile. `name` is its name in errors and answers.
    ///
    /// # Errors
    /// If the text is not TOML, has unknown keys, or a number is out of range.
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

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its description.
    pub fn description(&self) -> &str {
        &self.rules.description
    }

    /// Whether pedestrian areas are crossed or walked around.
    pub(crate) fn places(&self) -> Places {
        self.rules.places
    }

    /// The costs of turns, if turns matter.
    pub(crate) fn turns(&self) -> Option<&Turns> {
        self.rules.turns.as_ref()
    }

    /// What a turn restriction with these tags means to the profile; `None` if it does not bind it.
    pub(crate) fn restricts(&self, tags: &Tags) -> Option<RestrictionKind> {
        let modes = &self.turns()?.restrictions;
        let is_exempt = |list: &str| {
            list.split(';')
                .any(|mode| modes.iter().any(|own| own == mode.trim()))
        };
        if tags.get("except").is_some_and(is_exempt) {
            return None;
        }
        // A restriction for the profile's own mode counts before the general one.
        let own = modes
            .iter()
            .find_map(|mode| tags.get(&format!("restriction:{mode}")));
        match own.or_else(|| tags.get("restriction"))? {
            only if only.starts_with("only_") => Some(RestrictionKind::Only),
            no if no.starts_with("no_") => Some(RestrictionKind::Forbidden),
            _ => None,
        }
    }

    /// The weight, in seconds, of entering places that are closed to through traffic.
    pub(crate) fn entry(&self) -> f64 {
        self.rules.access.entry
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::with_causes;

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
        let problem = |text: &str| with_causes(&Profile::from_toml("mine.toml", text).unwrap_err());
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
    fn errors_about_unknown_profiles_list_the_known_ones() {
        let error = Profile::open("hovercraft").unwrap_err().to_string();
        assert!(
            error.contains("hovercraft") && error.contains("delivery, foot, car"),
            "{error}"
        );
    }
}
