//! OPEN as an agent of the benchmark: made from settings, and compared with the truth where the
//! settings ask for that by name.

use std::collections::BTreeMap;
use std::path::PathBuf;

use openbench_agents::Open;
use openbench_agents::open::parts::{FixesPart, LocalizerPart, MakeFixes, PartError};
use openbench_agents::open::settings::{DEFAULT_LOCALIZER, DEFAULT_READER, NO_FIXES};
use openbench_agents::open::{Catalogue, Choices, Models, Settings};
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::yardsticks::{
    FixNoise, LetterHeight, SimulatedFixes, TruthLocalizer, TruthReader,
};
use openbench_bench::{AgentFactory, AgentRequest, ModelDigest, Setting, Truth};
use openbench_core::{Agent, RobotDescription};
use openbench_models::{CATALOGUE, ModelFile, ModelSpec, ModelStore, PullEvent};
use openbench_vision::readers::model_files;
use openbench_vision::{ReaderContext, ReaderPart};

/// The name of the agent.
pub const NAME: &str = "open";
/// The localizer that returns the true pose.
const TRUE_POSE: &str = "truth";
/// The reader of what is written on the plates in view.
const TRUE_PLATES: &str = "truth";
/// The source of fixes that the robot's satellite receiver is.
const RECEIVER: &str = "gnss";
/// The source of fixes with errors of known size.
const DISTURBED_TRUTH: &str = "disturbed-truth";

/// A name that keeps its meaning, because results contain it.
pub struct Reserved {
    /// What kind of part it names.
    pub kind: &'static str,
    /// The name.
    pub name: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

/// The names that extensions cannot replace.
pub const RESERVED: [Reserved; 10] = [
    Reserved {
        kind: "agent",
        name: NAME,
        meaning: "the baseline agent",
    },
    Reserved {
        kind: "agent",
        name: "omniscient",
        meaning: "a yardstick that knows the truth",
    },
    Reserved {
        kind: "agent",
        name: "straight-line",
        meaning: "a yardstick that knows the truth",
    },
    Reserved {
        kind: "agent",
        name: "random",
        meaning: "a yardstick of chance",
    },
    Reserved {
        kind: "agent",
        name: "python",
        meaning: "a class in a Python file",
    },
    Reserved {
        kind: "agent",
        name: "program",
        meaning: "a program that speaks the policy protocol",
    },
    Reserved {
        kind: "plate reader",
        name: TRUE_PLATES,
        meaning: "what is written on the plates in view",
    },
    Reserved {
        kind: "localizer",
        name: TRUE_POSE,
        meaning: "the true pose",
    },
    Reserved {
        kind: "source of fixes",
        name: DISTURBED_TRUTH,
        meaning: "the true pose with errors of known size",
    },
    Reserved {
        kind: "source of fixes",
        name: NO_FIXES,
        meaning: "no fixes",
    },
];

/// Makes OPEN of the parts in a catalogue.
pub struct OpenFactory {
    catalogue: Catalogue,
}

impl OpenFactory {
    /// OPEN of these parts.
    pub fn new(catalogue: Catalogue) -> Self {
        Self { catalogue }
    }
}

impl AgentFactory for OpenFactory {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        let settings = Settings::parse(request.settings)?;
        let mut models = Models::new(settings.budget, request.exchanges.clone());
        // For each episode anew, since the true pose and the seed are those of the episode.
        let truth = request.truth.as_ref();
        let catalogue = with_truth(self.catalogue.clone(), truth, request.seed);
        let parts = catalogue.assemble(&settings, &mut models, request.memory.cloned())?;
        Ok(Box::new(Open::new(parts)))
    }

    fn check(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        let settings = Settings::parse(settings)?;
        // Only names are looked up, so no truth is needed.
        let catalogue = with_truth(self.catalogue.clone(), None, 0);
        for word in catalogue.readers.split(&settings.reader) {
            if let Some(height) = true_plates(word) {
                letter_height(height)?;
            }
        }
        Ok(catalogue.check(&settings)?)
    }

    fn check_robot(
        &self,
        settings: &AgentSettings,
        robot: &RobotDescription,
    ) -> Result<(), AgentError> {
        if names(settings, "fixes", RECEIVER) && robot.gnss.is_none() {
            return Err(
                "fixes=gnss: the robot has no receiver; add `gnss = true` under [sensors] to the \
                 suite"
                    .into(),
            );
        }
        Ok(())
    }

    fn prepare(
        &self,
        settings: &AgentSettings,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), AgentError> {
        let settings = Settings::parse(settings)?;
        for files in model_files(&self.catalogue.readers, &settings.reader) {
            ModelStore::from_environment()?.download(files, observer)?;
        }
        Ok(())
    }

    fn in_force(&self, settings: &AgentSettings) -> BTreeMap<String, Setting> {
        let localizer = settings.get("localizer");
        let localizer = localizer.map_or(DEFAULT_LOCALIZER, String::as_str);
        let is_without_fixes = !self.catalogue.takes_fixes(localizer);
        let choices = self.catalogue.choices().into_iter();
        let setting = |choices: Choices| {
            let unset = match choices.key {
                "fixes" if is_without_fixes => NO_FIXES,
                _ => &choices.default,
            };
            let value = settings.get(choices.key).map_or(unset, String::as_str);
            let is_replaced = choices.replaced.iter().any(|word| word == value);
            let value = if is_replaced {
                format!("{value} (replaced)")
            } else {
                value.to_owned()
            };
            let setting = Setting::new(value, &choices.default);
            (choices.key.to_owned(), setting)
        };
        choices.map(setting).collect()
    }

    fn models(&self, settings: &AgentSettings) -> Result<Vec<ModelDigest>, AgentError> {
        let readers = settings.get("reader");
        let readers = readers.map_or(DEFAULT_READER, String::as_str);
        let sets = model_files(&self.catalogue.readers, readers);
        let files = CATALOGUE.iter().filter(|file| sets.contains(&file.set));
        let digest = |file: &ModelFile| ModelDigest {
            name: file.name.to_owned(),
            sha256: file.sha256.to_owned(),
        };
        let planners = settings.get("planner").map_or("", String::as_str);
        let words = planners.split(',');
        let words = words.chain(self.catalogue.readers.split(readers));
        let mut models: Vec<ModelDigest> = files.map(digest).collect();
        for name in words.filter_map(local_model) {
            let sha256 = ModelStore::from_environment()?.chat_model_digest(&name)?;
            models.push(ModelDigest { name, sha256 });
        }
        Ok(models)
    }

    fn inputs(&self, settings: &AgentSettings) -> Vec<PathBuf> {
        let words = settings
            .values()
            .flat_map(|value| self.catalogue.readers.split(value));
        words.filter_map(recording).collect()
    }

    fn uses_truth(&self, settings: &AgentSettings) -> bool {
        names(settings, "localizer", TRUE_POSE)
            || names(settings, "fixes", DISTURBED_TRUTH)
            || reads_truth(&self.catalogue, settings)
    }
}

/// Whether a setting names a part, with or without an argument.
fn names(settings: &AgentSettings, key: &str, part: &str) -> bool {
    let value = settings.get(key);
    value.is_some_and(|value| value.split(':').next() == Some(part))
}

/// Whether one of the readers in a list knows what is written.
fn reads_truth(catalogue: &Catalogue, settings: &AgentSettings) -> bool {
    // With the reader's entry, since a list is split by what is registered.
    let catalogue = with_truth(catalogue.clone(), None, 0);
    let list = settings.get("reader").map_or("", String::as_str);
    let words = catalogue.readers.split(list);
    words.into_iter().any(|word| true_plates(word).is_some())
}

/// The argument of the reader that knows what is written; `None` for other readers.
fn true_plates(word: &str) -> Option<&str> {
    let (name, height) = word.split_once(':').unwrap_or((word, ""));
    (name == TRUE_PLATES).then_some(height)
}

fn letter_height(argument: &str) -> Result<LetterHeight, PartError> {
    if argument.is_empty() {
        Ok(LetterHeight::default())
    } else {
        Ok(argument.parse()?)
    }
}

/// The recording that a model spec names.
fn recording(word: &str) -> Option<PathBuf> {
    match ModelSpec::parse(word) {
        Ok(ModelSpec::Replay(path)) => Some(path),
        _ => None,
    }
}

/// The catalogue with the parts that know the truth: yardsticks, which the results name.
fn with_truth(mut catalogue: Catalogue, truth: Option<&Truth<'_>>, seed: u64) -> Catalogue {
    catalogue.readers = catalogue.readers.with(
        &format!("{TRUE_PLATES}:PIXELS"),
        "what is written on the plates in view, with capitals of so many pixels",
        true_reader(truth),
    );
    // Each closure owns a handle. All handles lead to the same poses.
    let truth = truth.map(Truth::poses_on_map).unwrap_or_default();
    let poses = truth.clone();
    catalogue.localizers = catalogue.localizers.with(
        TRUE_POSE,
        "the true pose",
        LocalizerPart::without_fixes(move |_| Box::new(TruthLocalizer::new(poses.clone()))),
    );
    let poses = truth.clone();
    let read = move |argument: &str| -> Result<Box<MakeFixes>, PartError> {
        let noise = fix_noise(argument)?;
        let truth = poses.clone();
        Ok(Box::new(move |_| {
            vec![Box::new(SimulatedFixes::new(truth.clone(), noise, seed))]
        }))
    };
    catalogue.fixes = catalogue.fixes.with(
        &format!("{DISTURBED_TRUTH}:NOISE,SHARE,FAR"),
        "fixes with errors of known size",
        FixesPart::with_argument(read),
    );
    catalogue
}

fn true_reader(truth: Option<&Truth<'_>>) -> ReaderPart {
    // A reader of each height is made of this one, since the truth lives no longer than its run.
    let reader = truth.map(TruthReader::new);
    ReaderPart::new(move |height, _: &mut ReaderContext<'_>| {
        let reader = reader.clone().ok_or("there is no episode")?;
        Ok(Box::new(reader.with_least(letter_height(height)?)))
    })
}

fn fix_noise(argument: &str) -> Result<FixNoise, PartError> {
    if argument.is_empty() {
        Ok(FixNoise::default())
    } else {
        Ok(argument.parse()?)
    }
}

/// The name or path of a model that runs in this process; `None` for other words.
fn local_model(word: &str) -> Option<String> {
    match ModelSpec::parse(word).ok()? {
        ModelSpec::Local(name) => Some(name),
        ModelSpec::Remote { .. } | ModelSpec::Replay(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use openbench_agents::open::settings::DEFAULT_FIXES;

    use super::*;

    fn settings(words: &[(&str, &str)]) -> AgentSettings {
        words
            .iter()
            .map(|(key, word)| ((*key).to_owned(), (*word).to_owned()))
            .collect()
    }

    #[test]
    fn the_truth_is_used_only_where_a_setting_names_it() {
        let open = OpenFactory::new(Catalogue::default());
        let uses = |words: &[(&str, &str)]| open.uses_truth(&settings(words));
        assert!(uses(&[("localizer", "truth")]));
        assert!(uses(&[("fixes", "disturbed-truth")]));
        assert!(uses(&[("fixes", "disturbed-truth:1,0,1")]));
        assert!(uses(&[("reader", "truth")]));
        assert!(uses(&[("reader", "ppocr-v4,truth:12")]));
        assert!(!uses(&[("reader", "ppocr-v4")]));
        assert!(!uses(&[]));
        assert!(!uses(&[
            ("localizer", "fused"),
            ("fixes", "gnss"),
            ("planner", "truth")
        ]));
        assert!(!uses(&[("localizer", "truthful")]));
    }

    #[test]
    fn the_files_of_local_models_are_named_with_their_hash() {
        let file = tempfile::NamedTempFile::with_suffix(".gguf").unwrap();
        std::fs::write(file.path(), "GGUF").unwrap();
        let path = file.path().display().to_string();
        let open = OpenFactory::new(Catalogue::default());
        let planner = format!("local:{path},grammar");
        let words = [("planner", planner.as_str()), ("reader", "truth")];
        let models = open.models(&settings(&words)).unwrap();
        assert_eq!(models.len(), 1);
        let missing = open.models(&settings(&[("planner", "local:/nowhere/m.gguf")]));
        assert!(missing.unwrap_err().to_string().contains("/nowhere/m.gguf"));
        assert_eq!((&models[0].name, models[0].sha256.len()), (&path, 64));
    }

    #[test]
    fn a_part_in_the_place_of_another_one_is_no_default() {
        let mut catalogue = Catalogue::default();
        let other = catalogue.localizers.get("dead-reckoning").unwrap().clone();
        catalogue.localizers = catalogue.localizers.with("fused", "another", other);
        let in_force = OpenFactory::new(catalogue).in_force(&settings(&[]));
        assert_eq!(
            in_force["localizer"],
            Setting::new("fused (replaced)", "fused")
        );
        assert!(in_force["reader"].default);
    }

    #[test]
    fn all_settings_in_force_are_named_with_their_defaults() {
        let open = OpenFactory::new(Catalogue::default());
        let words = [("localizer", "truth"), ("motion", "teb"), ("planner", "m")];
        let in_force = open.in_force(&settings(&words));
        assert_eq!(in_force["localizer"], Setting::new("truth", "fused"));
        assert!(in_force["motion"].default && in_force["budget"].default);
        assert!(!in_force["planner"].default);
        assert_eq!(in_force["fixes"], Setting::new("none", DEFAULT_FIXES));
        // Each default is a value that can be set, and means the same as no setting.
        let words = in_force.iter().filter(|(_, setting)| setting.default);
        let words = words.map(|(key, setting)| (key.clone(), setting.value.clone()));
        let spelled_out = Settings::parse(&words.collect());
        assert_eq!(spelled_out.unwrap(), Settings::default());
        let in_force = open.in_force(&settings(&[]));
        assert_eq!(
            in_force["fixes"],
            Setting::new(DEFAULT_FIXES, DEFAULT_FIXES)
        );
    }

    #[test]
    fn names_of_parts_are_checked_before_a_run() {
        let open = OpenFactory::new(Catalogue::default());
        let refused = |key: &str, value: &str| open.check(&settings(&[(key, value)])).is_err();
        assert!(refused("colour", "red"));
        assert!(refused("planner", "oracle"));
        assert!(refused("reader", "eyes"));
        assert!(refused("reader", "truth:far"));
        assert!(!refused("reader", "truth:12"));
        assert!(refused("localizer", "stars"));
        assert!(refused("fixes", "stars"));
        assert!(refused("fixes", "disturbed-truth:1,7,9"));
        assert!(refused("motion", "nothing"));
        assert!(!refused("localizer", "truth"));
        assert!(!refused("fixes", "disturbed-truth:1,0,1"));
    }
}
