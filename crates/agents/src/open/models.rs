//! The language and vision models of one mission: counted and bounded together, recorded, or
//! replayed.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use openbench_models::{
    Budget, ChatModel, Exchanges, Meter, Metered, ModelSpec, OpenError, Recorder, Replay,
    ReplayError, SpecError,
};

/// Opens the models that a mission asks.
pub struct Models {
    meter: Meter,
    exchanges: Exchanges,
    /// The file in which all of them are recorded.
    file: Option<Arc<File>>,
    /// The recording from which all of them answer.
    replay: Option<Arc<Replay>>,
}

/// A model that cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelsError {
    /// The text names no usable model.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The model cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The recording cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The file for the answers cannot be made.
    #[error("cannot record the answers of models in {}", path.display())]
    Record {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl Models {
    /// Models within a budget, with their answers recorded or replayed.
    pub fn new(budget: Budget, exchanges: Exchanges) -> Self {
        Self {
            meter: Meter::new(budget),
            exchanges,
            file: None,
            replay: None,
        }
    }

    /// What is asked of all of them.
    pub fn meter(&self) -> Meter {
        self.meter.clone()
    }

    /// The model that a word names, as [`ModelSpec`] has it.
    ///
    /// # Errors
    /// [`ModelsError`] if the word names none, or its recording cannot be read or written.
    pub fn open(&mut self, word: &str) -> Result<Box<dyn ChatModel>, ModelsError> {
        let spec = ModelSpec::parse(word)?;
        let model: Box<dyn ChatModel> = match self.exchanges.clone() {
            Exchanges::Unkept => spec.open()?,
            Exchanges::Keep(path) => Box::new(Recorder::new(spec.open()?, self.file(&path)?)),
            Exchanges::Repeat(path) => {
                let replay = self.replay(&path)?;
                Box::new(replay.named(&name_of(&spec, &replay)))
            }
        };
        // Outermost, so that replayed answers count against the budget as the recorded ones did.
        Ok(Box::new(Metered::new(model, self.meter())))
    }

    fn file(&mut self, path: &Path) -> Result<Arc<File>, ModelsError> {
        // Created once for all models: a second `create` would empty the file that the first one
        // writes.
        if let Some(file) = &self.file {
            return Ok(file.clone());
        }
        let made = File::create(path);
        let file = made.map_err(|source| ModelsError::Record {
            path: path.to_owned(),
            source,
        })?;
        Ok(self.file.insert(Arc::new(file)).clone())
    }

    fn replay(&mut self, path: &Path) -> Result<Arc<Replay>, ModelsError> {
        if let Some(replay) = &self.replay {
            return Ok(replay.clone());
        }
        Ok(self.replay.insert(Arc::new(Replay::open(path)?)).clone())
    }
}

/// The name under which a model is recorded.
fn name_of(spec: &ModelSpec, replay: &Replay) -> String {
    match spec {
        ModelSpec::Remote { model, .. } => model.clone(),
        ModelSpec::Local(name) => openbench_models::spec::local_name(Path::new(name)),
        ModelSpec::Replay(_) => replay.name().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn models(exchanges: Exchanges) -> Models {
        Models::new(Budget::default(), exchanges)
    }

    #[test]
    fn models_are_recorded_under_the_name_that_they_report() {
        let replay = Replay::from_reader(&b""[..]).unwrap();
        let name = |word: &str| name_of(&ModelSpec::parse(word).unwrap(), &replay);
        assert_eq!(
            name("openai:qwen2.5-vl@https://llm.example/v1"),
            "qwen2.5-vl"
        );
        assert_eq!(name("local:folder/mine.gguf"), "mine");
        assert_eq!(name("replay:answers.jsonl"), replay.name());
    }

    #[test]
    fn a_word_that_names_no_model_is_refused() {
        let error = models(Exchanges::Unkept).open("oracle").err().unwrap();
        assert!(matches!(error, ModelsError::Spec(_)), "{error}");
    }

    #[test]
    fn a_file_that_cannot_be_written_or_read_is_named() {
        let nowhere = || PathBuf::from("/nonexistent/models.jsonl");
        let model = "openai:m@http://127.0.0.1:1/v1";
        let kept = models(Exchanges::Keep(nowhere()))
            .open(model)
            .err()
            .unwrap();
        assert!(matches!(kept, ModelsError::Record { .. }), "{kept}");
        assert!(
            kept.to_string().contains("/nonexistent/models.jsonl"),
            "{kept}"
        );
        let repeated = models(Exchanges::Repeat(nowhere()))
            .open(model)
            .err()
            .unwrap();
        assert!(matches!(repeated, ModelsError::Replay(_)), "{repeated}");
    }
}
