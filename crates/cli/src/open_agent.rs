//! OPEN as an agent of the benchmark: made from settings, and compared with the truth where the
//! settings ask for that by name.

use std::collections::BTreeMap;
use std::path::PathBuf;

use openbench_agents::Open;
use openbench_agents::open::parts::{FixesPart, LocalizerPart, MakeFixes, PartError};
use openbench_agents::open::settings::DEFAULT_READER;
use openbench_agents::open::{Catalogue, Choices, Models, Settings};
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::{
    AgentFactory, AgentRequest, FixNoise, ModelDigest, Setting, SimulatedFixes, TruthHandle,
    TruthLocalizer,
};
use openbench_core::{Agent, RobotDescription};
use openbench_models::{CATALOGUE, ModelFile, ModelSpec, ModelStore, PullEvent};
use openbench_vision::readers::model_files;

/// The name of the agent.
pub const NAME: &str = "open";
/// The localizer that returns the true pose.
const TRUE_POSE: &str = "truth";
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
pub const RESERVED: [Reserved; 4] = [
    Reserved {
        kind: "agent",
        name: NAME,
        meaning: "the baseline agent",
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
        name: openbench_agents::open::settings::NO_FIXES,
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
        let catalogue = with_truth(self.catalogue.clone(), &request.truth, request.seed);
        let parts = catalogue.assemble(&settings, &mut models, request.memory.cloned())?;
        Ok(Box::new(Open::new(parts)))
    }

    fn check(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        let settings = Settings::parse(settings)?;
        // Only names are looked up, so an empty handle will do.
        let catalogue = with_truth(self.catalogue.clone(), &TruthHandle::default(), 0);
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
        let choices = self.catalogue.choices().into_iter();
        let setting = |choices: Choices| {
            let value = settings.get(choices.key).unwrap_or(&choices.default);
            let setting = Setting::new(value.clone(), &choices.default);
            (choices.key.to_owned(), setting)
        };
        choices.map(setting).collect()
    }

    fn models(&self, settings: &AgentSettings) -> Vec<ModelDigest> {
        let list = settings.get("reader");
        let list = list.map_or(DEFAULT_READER, String::as_str);
        let sets = model_files(&self.catalogue.readers, list);
        let files = CATALOGUE.iter().filter(|file| sets.contains(&file.set));
        let digest = |file: &ModelFile| ModelDigest {
            name: file.name.to_owned(),
            sha256: file.sha256.to_owned(),
        };
        files.map(digest).collect()
    }

    fn inputs(&self, settings: &AgentSettings) -> Vec<PathBuf> {
        let words = settings
            .values()
            .flat_map(|value| self.catalogue.readers.split(value));
        words.filter_map(recording).collect()
    }

    fn uses_truth(&self, settings: &AgentSettings) -> bool {
        names(settings, "localizer", TRUE_POSE) || names(settings, "fixes", DISTURBED_TRUTH)
    }
}

/// Whether a setting names a part, with or without an argument.
fn names(settings: &AgentSettings, key: &str, part: &str) -> bool {
    let value = settings.get(key);
    value.is_some_and(|value| value.split(':').next() == Some(part))
}

/// The recording that a model spec names.
fn recording(word: &str) -> Option<PathBuf> {
    match ModelSpec::parse(word) {
        Ok(ModelSpec::Replay(path)) => Some(path),
        _ => None,
    }
}

/// The catalogue with the parts that know the truth: yardsticks, which the results name.
fn with_truth(mut catalogue: Catalogue, truth: &TruthHandle, seed: u64) -> Catalogue {
    // Each closure owns a handle. All handles lead to the same poses.
    let handle = truth.clone();
    catalogue.localizers = catalogue.localizers.with(
        TRUE_POSE,
        "the true pose",
        LocalizerPart::without_fixes(move |_| Box::new(TruthLocalizer::new(handle.clone()))),
    );
    let handle = truth.clone();
    let read = move |argument: &str| -> Result<Box<MakeFixes>, PartError> {
        let noise = fix_noise(argument)?;
        let truth = handle.clone();
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

fn fix_noise(argument: &str) -> Result<FixNoise, PartError> {
    if argument.is_empty() {
        Ok(FixNoise::default())
    } else {
        Ok(argument.parse()?)
    }
}

#[cfg(test)]
mod tests {
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
        assert!(!uses(&[]));
        assert!(!uses(&[
            ("localizer", "fused"),
            ("fixes", "gnss"),
            ("planner", "truth")
        ]));
        assert!(!uses(&[("localizer", "truthful")]));
    }

    #[test]
    fn all_settings_in_force_are_named_with_their_defaults() {
        let open = OpenFactory::new(Catalogue::default());
        let words = [("localizer", "truth"), ("motion", "teb"), ("planner", "m")];
        let in_force = open.in_force(&settings(&words));
        assert_eq!(in_force["localizer"], Setting::new("truth", "fused"));
        assert!(in_force["motion"].default && in_force["budget"].default);
        assert!(!in_force["planner"].default);
        // Each default is a value that can be set, and means the same as no setting.
        let words = in_force.iter().filter(|(_, setting)| setting.default);
        let words = words.map(|(key, setting)| (key.clone(), setting.value.clone()));
        let spelled_out = Settings::parse(&words.collect());
        assert_eq!(spelled_out.unwrap(), Settings::default());
    }

    #[test]
    fn names_of_parts_are_checked_before_a_run() {
        let open = OpenFactory::new(Catalogue::default());
        let refused = |key: &str, value: &str| open.check(&settings(&[(key, value)])).is_err();
        assert!(refused("colour", "red"));
        assert!(refused("planner", "oracle"));
        assert!(refused("reader", "eyes"));
        assert!(refused("localizer", "stars"));
        assert!(refused("fixes", "stars"));
        assert!(refused("fixes", "disturbed-truth:1,7,9"));
        assert!(refused("motion", "nothing"));
        assert!(!refused("localizer", "truth"));
        assert!(!refused("fixes", "disturbed-truth:1,0,1"));
    }
}
