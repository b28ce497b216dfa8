//! The language and vision models of one mission: counted and bounded together, recorded, or repeated.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use openbench_bench::Exchanges;
use openbench_models::{Budget, ChatModel, Meter, Metered, ModelSpec, Recorder, Replay};

/// Opens the models that a mission asks.
pub struct Models {
    meter: Meter,
    exchanges: Exchanges,
    /// Where all of them are recorded.
    file: Option<Arc<File>>,
    /// What all of them answer from.
    replay: Option<Arc<Replay>>,
}

impl Models {
    /// Within a budget, with what they answer kept or repeated.
    pub fn new(budget: Budget, exchanges: Exchanges) -> Self {
        Self { meter: Meter::new(budget), exchanges, file: None, replay: None }
    }

    /// For a command line: as much as it takes, kept in a file if one is named.
    pub fn unbounded(planner: &str, exchanges: Option<&Path>) -> anyhow::Result<Self> {
        let read = planner.strip_prefix("replay:").map(Path::new);
        if let (Some(read), Some(kept)) = (read, exchanges)
            && (read == kept || read.canonicalize().is_ok_and(|read| kept.canonicalize().ok() == Some(read)))
        {
            anyhow::bail!("{} cannot be read and written at once; name another file", kept.display());
        }
        let budget = Budget { calls: u32::MAX, tokens: u64::MAX, seconds: u32::MAX };
        Ok(Self::new(budget, exchanges.map_or(Exchanges::Unkept, |path| Exchanges::Keep(path.to_owned()))))
    }

    /// What is asked of all of them.
    pub fn meter(&self) -> Meter {
        self.meter.clone()
    }

    /// The model that a word names.
    pub fn open(&mut self, word: &str) -> Result<Box<dyn ChatModel>, String> {
        let spec = ModelSpec::parse(word).map_err(|e| e.to_string())?;
        if let Exchanges::Repeat(path) = &self.exchanges {
            let replay = match &self.replay {
                Some(replay) => replay.clone(),
                None => self.replay.insert(Arc::new(Replay::open(path).map_err(|e| e.to_string())?)).clone(),
            };
            let name = match &spec {
                ModelSpec::Remote { model, .. } => model,
                ModelSpec::Local(name) => &openbench_models::spec::local_name(Path::new(name)),
                ModelSpec::Replay(_) => replay.name(),
            };
            return Ok(Box::new(Metered::new(replay.named(name), self.meter())));
        }
        let model = spec.open().map_err(|e| e.to_string())?;
        if let Exchanges::Keep(path) = &self.exchanges {
            let file = match &self.file {
                Some(file) => file.clone(),
                None => self.file.insert(Arc::new(create(path)?)).clone(),
            };
            return Ok(Box::new(Metered::new(Recorder::new(model, file), self.meter())));
        }
        Ok(Box::new(Metered::new(model, self.meter())))
    }
}

fn create(path: &Path) -> Result<File, String> {
    File::create(path).map_err(|e| format!("cannot keep what models answer in {}: {e}", path.display()))
}
