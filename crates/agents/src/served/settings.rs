//! How a policy server is asked and its answers are read: the keys of `--set KEY=VALUE`.

use std::collections::BTreeMap;
use std::time::Duration;

use openbench_core::{MapPoint, Velocity};

use super::arrays::Rows;
use super::error::ServerError;
use super::limits::{MAX_PERIOD_S, MIN_PERIOD_S};
use super::picture::Size;
use super::question::{Answer, Question, Step};
use crate::remote::Patience;

/// Pixels of the side of an image.
const SIDES: std::ops::RangeInclusive<u32> = 16..=1024;
/// Longest name of a key, bytes.
const LONGEST_KEY: usize = 100;
/// A third number of a velocity above this declares the parcel delivered.
const DECLARES: f64 = 0.5;

/// The settings, in the order of the help.
pub const SETTINGS: [Setting; 11] = [
    Setting {
        key: "actions",
        default: "velocity",
        values: "velocity, waypoints or trajectory",
        about: "rows of an answer: m/s, rad/s[, above 0.5: delivered], or points x, y",
    },
    Setting {
        key: "period",
        default: "0.1",
        values: "SECONDS",
        about: "how long a velocity, or the drive to the next point of a trajectory, lasts",
    },
    Setting {
        key: "horizon",
        default: "all",
        values: "NUMBER or all",
        about: "velocities of an answer that are driven before the next question",
    },
    Setting {
        key: "replan",
        default: "0.5",
        values: "SECONDS",
        about: "how long points are followed before the next question",
    },
    Setting {
        key: "arrival",
        default: "1",
        values: "METRES (up to 2) or policy",
        about: "distance to a point goal, by odometry, at which the parcel is declared delivered",
    },
    Setting {
        key: "thinking",
        default: "free",
        values: "free or charged",
        about: "charged: an answer takes effect as late as it came",
    },
    Setting {
        key: "timeout",
        default: "60",
        values: "SECONDS",
        about: "the longest wait for an answer",
    },
    Setting {
        key: "begin-timeout",
        default: "300",
        values: "SECONDS",
        about: "the longest wait for a connection",
    },
    Setting {
        key: "size",
        default: "224",
        values: "PIXELS (16 to 1024) or camera",
        about: "side of the square images that are sent, or the camera's own size",
    },
    Setting {
        key: "image",
        default: "observation/image",
        values: "KEY",
        about: "the key of the image (openpi)",
    },
    Setting {
        key: "state",
        default: "observation/state",
        values: "KEY",
        about: "the key of pose and velocity (openpi)",
    },
];

/// A key of `--set`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// The key.
    pub key: &'static str,
    /// The value unless it is set.
    pub default: &'static str,
    /// What can be written.
    pub values: &'static str,
    /// What it is for.
    pub about: &'static str,
}

impl Setting {
    /// The value that is set.
    pub fn value<'a>(&self, words: &'a BTreeMap<String, String>) -> &'a str {
        words.get(self.key).map_or(self.default, String::as_str)
    }
}

/// Which settings a protocol has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Protocol {
    /// Its name on the command line.
    pub name: &'static str,
    /// The keys of [`SETTINGS`] that mean nothing to it.
    ignored: &'static [&'static str],
    /// What its answers are, if that is not set.
    actions: Option<Actions>,
}

/// openpi.
pub const OPENPI: Protocol = Protocol {
    name: "openpi",
    ignored: &[],
    actions: None,
};
/// vla-eval, whose observations have keys of their own.
pub const VLA_EVAL: Protocol = Protocol {
    name: "vla-eval",
    ignored: &["image", "state"],
    actions: None,
};
/// NavDP, which gets images as the camera has them, and answers points without times.
pub const NAVDP: Protocol = Protocol {
    name: "navdp",
    ignored: &["actions", "period", "horizon", "size", "image", "state"],
    actions: Some(Actions::Waypoints),
};

impl Protocol {
    /// The settings that it has.
    pub fn settings(&self) -> impl Iterator<Item = &'static Setting> {
        let is_known = |setting: &&Setting| !self.ignored.contains(&setting.key);
        SETTINGS.iter().filter(is_known)
    }
}

/// What the numbers of an answer are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Actions {
    /// m/s forward and rad/s, and perhaps a declaration; one row after the other.
    Velocity,
    /// Points x, y in `base_link` to pass.
    Waypoints,
    /// The same, one a period.
    Trajectory,
}

/// How a policy server is asked, and how its answers are read.
///
/// ```
/// use std::collections::BTreeMap;
///
/// use openbench_agents::served::{Actions, Settings};
///
/// let words = BTreeMap::from([("actions".to_owned(), "waypoints".to_owned())]);
/// let settings = Settings::parse(&words)?;
/// assert_eq!(settings.actions, Actions::Waypoints);
/// assert_eq!(settings.arrival_m, Some(1.0));
/// # Ok::<(), openbench_agents::served::SettingError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// `actions`: `velocity`, `waypoints` or `trajectory`.
    pub actions: Actions,
    /// `period`: how long a velocity, or the drive to the next point of a trajectory, lasts,
    /// seconds.
    pub period_s: f64,
    /// `horizon`: how many velocities of an answer are driven before the next question; `None`:
    /// `all`.
    pub horizon: Option<usize>,
    /// `replan`: how long a path is followed before the next question, seconds.
    pub replan: Duration,
    /// `arrival`: distance to a point goal, by the robot's own odometry, at which the parcel is
    /// declared delivered, metres; `None` (`policy`): only where the policy says so.
    pub arrival_m: Option<f64>,
    /// `thinking`: whether an answer takes effect only after as much simulated time as it took wall
    /// time: `free` or `charged`.
    pub is_charged: bool,
    /// `begin-timeout` and `timeout`, seconds of wall time.
    pub patience: Patience,
    /// `size`: that of the images, `camera` or the side of a square.
    pub size: Size,
    /// `image`: the key of the image in an observation.
    pub image: String,
    /// `state`: the key of the state in an observation.
    pub state: String,
}

/// A setting that there is not, or a value that it does not take.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// There is no such key.
    #[error("{protocol} has no setting `{key}`; known: {known}")]
    UnknownKey {
        /// The protocol.
        protocol: &'static str,
        /// What was written.
        key: String,
        /// What there is.
        known: String,
    },
    /// Neither the policy nor the robot would ever declare a delivery.
    #[error("arrival=policy: points declare no delivery; write metres, or actions=velocity")]
    NeverDeclares,
    /// The value is none of the setting.
    #[error("{key}={value}: write {expected}")]
    BadValue {
        /// The setting.
        key: &'static str,
        /// What was written.
        value: String,
        /// What could have been written.
        expected: &'static str,
    },
}

impl Settings {
    /// The settings of openpi that are written so; those that are not have their defaults.
    ///
    /// # Errors
    /// [`SettingError`] of the first one that is wrong.
    pub fn parse(words: &BTreeMap<String, String>) -> Result<Self, SettingError> {
        Self::of(&OPENPI, words)
    }

    /// As [`parse`](Self::parse), for any protocol.
    ///
    /// # Errors
    /// As `parse`.
    pub fn of(protocol: &Protocol, words: &BTreeMap<String, String>) -> Result<Self, SettingError> {
        let is_known = |key: &&String| protocol.settings().any(|known| known.key == **key);
        if let Some(key) = words.keys().find(|key| !is_known(key)) {
            let known: Vec<_> = protocol.settings().map(|setting| setting.key).collect();
            return Err(SettingError::UnknownKey {
                protocol: protocol.name,
                key: key.clone(),
                known: known.join(", "),
            });
        }
        let words = Words(words);
        let settings = Self {
            actions: match protocol.actions {
                Some(actions) => actions,
                None => words.read("actions", actions)?,
            },
            period_s: words.read("period", seconds)?.as_secs_f64(),
            horizon: words.read("horizon", horizon)?,
            replan: words.read("replan", seconds)?,
            arrival_m: words.read("arrival", arrival)?,
            is_charged: words.read("thinking", charged)?,
            patience: Patience {
                begin: words.read("begin-timeout", seconds)?,
                act: words.read("timeout", seconds)?,
            },
            size: words.read("size", size)?,
            image: words.read("image", key)?,
            state: words.read("state", key)?,
        };
        if settings.actions != Actions::Velocity && settings.arrival_m.is_none() {
            return Err(SettingError::NeverDeclares);
        }
        Ok(settings)
    }

    /// How long the answer to a question may take: a policy may be compiled for the first one.
    pub fn within(&self, question: &Question) -> Duration {
        let Patience { begin, act } = self.patience;
        if question.number == 0 {
            begin.max(act)
        } else {
            act
        }
    }

    /// The answer whose numbers these are.
    ///
    /// # Errors
    /// [`ServerError::Unreadable`] if they have too few columns.
    pub fn answer(&self, rows: &Rows) -> Result<Answer, ServerError> {
        if self.actions == Actions::Velocity {
            let rows = rows.with_columns(2, "linear, angular[, declare]")?;
            let steps = rows
                .take(self.horizon.unwrap_or(usize::MAX))
                .map(|row| Step {
                    velocity: Velocity::new(row[0], row[1]),
                    declares: row.get(2).is_some_and(|number| *number > DECLARES),
                });
            return Ok(Answer::Velocities {
                period_s: self.period_s,
                steps: steps.collect(),
            });
        }
        let rows = rows.with_columns(2, "x, y")?;
        let points: Vec<MapPoint> = rows.map(|row| MapPoint::new(row[0], row[1])).collect();
        let lasts_s = match self.actions {
            Actions::Trajectory => Some(self.period_s * points.len() as f64),
            _ => None,
        };
        Ok(Answer::Path { points, lasts_s })
    }
}

/// Settings as they are written.
struct Words<'a>(&'a BTreeMap<String, String>);

impl Words<'_> {
    fn read<T>(
        &self,
        key: &'static str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<T, SettingError> {
        let setting = SETTINGS.iter().find(|setting| setting.key == key);
        let value = setting.map_or("", |setting| setting.value(self.0));
        parse(value).ok_or_else(|| SettingError::BadValue {
            key,
            value: value.to_owned(),
            expected: setting.map_or("", |setting| setting.values),
        })
    }
}

fn seconds(word: &str) -> Option<Duration> {
    let seconds: f64 = word.parse().ok()?;
    (MIN_PERIOD_S..=MAX_PERIOD_S)
        .contains(&seconds)
        .then(|| Duration::from_secs_f64(seconds))
}

fn charged(word: &str) -> Option<bool> {
    match word {
        "free" => Some(false),
        "charged" => Some(true),
        _ => None,
    }
}

fn actions(word: &str) -> Option<Actions> {
    match word {
        "velocity" => Some(Actions::Velocity),
        "waypoints" => Some(Actions::Waypoints),
        "trajectory" => Some(Actions::Trajectory),
        _ => None,
    }
}

fn horizon(word: &str) -> Option<Option<usize>> {
    match word {
        "all" => Some(None),
        number => number.parse().ok().filter(|number| *number > 0).map(Some),
    }
}

fn arrival(word: &str) -> Option<Option<f64>> {
    match word {
        "policy" => Some(None),
        metres => {
            let metres: f64 = metres.parse().ok()?;
            (metres > 0.0 && metres <= 2.0).then_some(Some(metres))
        }
    }
}

fn size(word: &str) -> Option<Size> {
    match word {
        "camera" => Some(Size::Camera),
        pixels => {
            let side = pixels.parse().ok().filter(|side| SIDES.contains(side))?;
            Some(Size::Square(side))
        }
    }
}

fn key(word: &str) -> Option<String> {
    (1..=LONGEST_KEY)
        .contains(&word.len())
        .then(|| word.to_owned())
}

#[cfg(test)]
mod tests {
    use super::super::arrays::Array;
    use super::*;

    fn parse(words: &[(&str, &str)]) -> Result<Settings, SettingError> {
        let own = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        Settings::parse(&words.iter().map(own).collect())
    }

    fn rows(shape: [usize; 2], numbers: &[f64]) -> Rows {
        Rows::of(Array::new(shape.to_vec(), numbers.to_vec())).unwrap()
    }

    #[test]
    fn each_default_is_a_value() {
        let settings = parse(&[]).unwrap();
        assert_eq!(settings.patience, Patience::default());
        assert_eq!((settings.horizon, settings.arrival_m), (None, Some(1.0)));
    }

    #[test]
    fn what_is_no_setting_is_refused() {
        for (key, value) in [
            ("actions", "joints"),
            ("period", "0"),
            ("replan", "NaN"),
            ("timeout", "1e300"),
            ("horizon", "0"),
            ("arrival", "3"),
            ("thinking", "maybe"),
            ("size", "8"),
            ("image", ""),
        ] {
            let error = parse(&[(key, value)]).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("{key}={value}: write ")),
                "{error}"
            );
        }
        let error = parse(&[("motion", "teb")]).unwrap_err().to_string();
        assert!(error.contains("known: actions, period"), "{error}");
        let error = parse(&[("actions", "waypoints"), ("arrival", "policy")]);
        assert_eq!(error, Err(SettingError::NeverDeclares));
        let words = BTreeMap::from([("actions".to_owned(), "velocity".to_owned())]);
        let error = Settings::of(&NAVDP, &words).unwrap_err().to_string();
        assert!(error.contains("navdp has no setting `actions`"), "{error}");
    }

    #[test]
    fn numbers_are_velocities_or_points() {
        let numbers = rows([2, 3], &[0.5, 0.1, 0.0, 0.0, 0.0, 0.6]);
        let step = |linear, angular, declares| Step {
            velocity: Velocity::new(linear, angular),
            declares,
        };
        let settings = parse(&[("period", "0.2")]).unwrap();
        let steps = vec![step(0.5, 0.1, false), step(0.0, 0.0, true)];
        let (period_s, points) = (0.2, vec![MapPoint::new(0.5, 0.1), MapPoint::default()]);
        let velocities = Answer::Velocities {
            period_s,
            steps: steps.clone(),
        };
        assert_eq!(settings.answer(&numbers), Ok(velocities));
        let first = Answer::Velocities {
            period_s,
            steps: steps[..1].to_vec(),
        };
        let settings = parse(&[("period", "0.2"), ("horizon", "1")]).unwrap();
        assert_eq!(settings.answer(&numbers), Ok(first));
        let settings = parse(&[("period", "0.2"), ("actions", "trajectory")]).unwrap();
        let lasts_s = Some(0.4);
        assert_eq!(
            settings.answer(&numbers),
            Ok(Answer::Path { points, lasts_s })
        );
    }
}
