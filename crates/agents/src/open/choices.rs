//! The values that each setting takes, for help texts.

use openbench_models::spec::FORMS;

use super::catalogue::Catalogue;
use super::settings::{DEFAULT_FIXES, GRAMMAR, Settings};

/// What stands for the name of a chat or vision model, of one of the forms [`FORMS`].
pub const MODEL: &str = "MODEL";

/// A setting, and the values that it takes.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Choices {
    /// Its key.
    pub key: &'static str,
    /// What it decides, in one line.
    pub about: &'static str,
    /// Its values, or the form of them, in the order in which they are listed.
    pub values: Vec<String>,
    /// The value that it has where it is not set.
    pub default: String,
    /// Those of the values that mean other parts than the built-in ones of these names.
    pub replaced: Vec<String>,
}

impl Catalogue {
    /// The settings, and the values that they take with the parts of this catalogue.
    ///
    /// ```
    /// use openbench_agents::open::Catalogue;
    ///
    /// let choices = Catalogue::default().choices();
    /// let motion = choices.iter().find(|choices| choices.key == "motion").unwrap();
    /// assert_eq!(motion.values, ["teb", "follower", "mppi"]);
    /// assert_eq!(motion.default, "teb");
    /// ```
    pub fn choices(&self) -> Vec<Choices> {
        let default = Settings::default();
        let fixes = default.fixes.as_deref().unwrap_or(DEFAULT_FIXES);
        vec![
            Choices {
                key: "planner",
                about: "plans the deliveries of an instruction",
                values: owned([GRAMMAR, MODEL]),
                default: default.planner,
                replaced: Vec::new(),
            },
            Choices {
                key: "reader",
                about: "reads plates; of a list (MODEL,ppocr-v4) the next one reads where one fails",
                values: self.reader_names(),
                default: default.reader,
                replaced: owned(self.readers.replaced()),
            },
            Choices {
                key: "localizer",
                about: "estimates the robot's pose",
                values: owned(self.localizers.names()),
                default: default.localizer,
                replaced: owned(self.localizers.replaced()),
            },
            Choices {
                key: "fixes",
                about: "measures positions, for localizers that take them",
                values: owned(self.fixes.names()),
                default: fixes.to_owned(),
                replaced: owned(self.fixes.replaced()),
            },
            Choices {
                key: "motion",
                about: "local planner: turns paths into velocities",
                values: owned(self.local_planners.names()),
                default: default.motion,
                replaced: owned(self.local_planners.replaced()),
            },
            Choices {
                key: "ground",
                about: "pavements: prefer them, with detours of up to a fifth",
                values: owned(["alike", "pavements"]),
                // Written out: `Preferences` and the flag of `thinking` have no names of their own.
                default: "alike".to_owned(),
                replaced: Vec::new(),
            },
            Choices {
                key: "budget",
                about: "the most that an episode may ask of models",
                values: owned(["CALLS,TOKENS,SECONDS"]),
                default: default.budget.to_string(),
                replaced: Vec::new(),
            },
            Choices {
                key: "thinking",
                about: "charged: the robot stands still while models answer",
                values: owned(["free", "charged"]),
                default: "free".to_owned(),
                replaced: Vec::new(),
            },
        ]
    }

    /// The names of plate readers, with one word for those of models.
    fn reader_names(&self) -> Vec<String> {
        let named = self.readers.names().filter(|name| !is_model(name));
        owned(named.chain([MODEL]))
    }
}

/// Whether a name is a form of the names of models.
fn is_model(name: &str) -> bool {
    FORMS.iter().any(|form| form.name == name)
}

fn owned<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    names.into_iter().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::open::settings::{DEFAULT_READER, KEYS};

    #[test]
    fn every_key_has_its_choices() {
        let choices = Catalogue::default().choices();
        let keys: Vec<&str> = choices.iter().map(|choices| choices.key).collect();
        assert_eq!(keys, KEYS);
    }

    #[test]
    fn defaults_are_those_of_the_settings() {
        let choices = Catalogue::default().choices();
        let words: BTreeMap<String, String> = choices
            .into_iter()
            .map(|choices| (choices.key.to_owned(), choices.default))
            .collect();
        let spelled_out = Settings {
            fixes: Some(DEFAULT_FIXES.into()),
            ..Settings::default()
        };
        assert_eq!(Settings::parse(&words).unwrap(), spelled_out);
    }

    #[test]
    fn models_are_one_choice_of_readers() {
        let choices = Catalogue::default().choices();
        assert_eq!(choices[1].values, [DEFAULT_READER, MODEL]);
    }

    #[test]
    fn listed_parts_can_be_set() {
        let catalogue = Catalogue::default();
        for choices in catalogue.choices() {
            let words = choices.values.iter().filter(|value| {
                let is_form = value.contains(MODEL) || value.contains("CALLS");
                !is_form
            });
            for word in words {
                let one = BTreeMap::from([(choices.key.to_owned(), word.clone())]);
                let settings = Settings::parse(&one).unwrap();
                catalogue.check(&settings).unwrap();
            }
        }
    }
}
