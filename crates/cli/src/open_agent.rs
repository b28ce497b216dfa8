//! OPEN as an agent of the benchmark: made from settings, and compared with the truth where the
//! settings ask for that by name.

use std::path::PathBuf;
use std::sync::Arc;

use openbench_agents::Open;
use openbench_agents::open::parts::{LocalizerPart, MakeFixes, PartError};
use openbench_agents::open::{Catalogue, Models, Settings};
use openbench_bench::run::registry::{AgentError, AgentSettings};
use openbench_bench::{AgentFactory, AgentRequest, FixNoise, SimulatedFixes, TruthLocalizer};
use openbench_core::Agent;
use openbench_models::{ModelSpec, ModelStore, PullEvent};

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
        let catalogue = with_truth(self.catalogue.clone(), request);
        let parts = catalogue.assemble(&settings, &mut models, request.memory.cloned())?;
        Ok(Box::new(Open::new(parts)))
    }

    fn prepare(
        &self,
        settings: &AgentSettings,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), AgentError> {
        let settings = Settings::parse(settings)?;
        for files in self.catalogue.readers.model_files(&settings.reader) {
            ModelStore::from_environment()?.download(files, observer)?;
        }
        Ok(())
    }

    fn inputs(&self, settings: &AgentSettings) -> Vec<PathBuf> {
        let words = settings
            .values()
            .flat_map(|value| self.catalogue.readers.split(value));
        words.filter_map(recording).collect()
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
fn with_truth(mut catalogue: Catalogue, request: &AgentRequest<'_>) -> Catalogue {
    let truth = request.truth.clone();
    catalogue.localizers = catalogue.localizers.with(
        "truth",
        "the true pose",
        LocalizerPart::WithoutFixes(Arc::new(move |_| {
            Box::new(TruthLocalizer::new(truth.clone()))
        })),
    );
    let (truth, seed) = (request.truth.clone(), request.seed);
    let read = move |argument: &str| -> Result<MakeFixes, PartError> {
        let noise = fix_noise(argument)?;
        let truth = truth.clone();
        Ok(Box::new(move |_| {
            vec![Box::new(SimulatedFixes::new(truth.clone(), noise, seed))]
        }))
    };
    catalogue.fixes = catalogue.fixes.with(
        "disturbed-truth",
        "fixes with errors of known size",
        Arc::new(read),
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
