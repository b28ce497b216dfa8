//! An ONNX network with one input and one output.

use std::path::Path;
use std::sync::Arc;

use rten::{Model, ModelOptions, RunOptions, ThreadPool};
use rten_tensor::NdTensor;

use crate::error::{Cause, ReaderError};

/// Maximum length of a model file, bytes.
const MAX_FILE_BYTES: u64 = 256 << 20;

/// A loaded network.
pub(super) struct Network {
    model: Model,
    stage: &'static str,
}

impl Network {
    /// Loads an ONNX file. `stage` is the name of the network in errors.
    pub(super) fn load(file: &Path, stage: &'static str) -> Result<Self, ReaderError> {
        let model = load(file).map_err(|source| ReaderError::Model {
            file: file.to_owned(),
            source,
        })?;
        Ok(Self { model, stage })
    }

    /// A field in the metadata of the file.
    pub(super) fn metadata(&self, field: &str) -> Option<&str> {
        self.model.metadata().get(field)
    }

    /// Runs the network on `thread`.
    ///
    /// The axes of the input are images, channels, rows, columns; the output has `N` axes.
    pub(super) fn run<const N: usize>(
        &self,
        input: NdTensor<f32, 4>,
        thread: &Arc<ThreadPool>,
    ) -> Result<NdTensor<f32, N>, ReaderError> {
        self.try_run(input, thread)
            .map_err(|source| ReaderError::Inference {
                stage: self.stage,
                source,
            })
    }

    fn try_run<const N: usize>(
        &self,
        input: NdTensor<f32, 4>,
        thread: &Arc<ThreadPool>,
    ) -> Result<NdTensor<f32, N>, Cause> {
        let inputs = vec![(self.model.input_ids()[0], input.into())];
        let outputs = [self.model.output_ids()[0]];
        let options = RunOptions::default().with_thread_pool(Some(thread.clone()));
        let [output] = self.model.run_n(inputs, outputs, Some(options))?;
        Ok(output.try_into()?)
    }
}

fn load(file: &Path) -> Result<Model, Cause> {
    let bytes = read_bounded(file)?;
    let mut options = ModelOptions::with_all_ops();
    let model = options.prepack_weights(true).load(bytes)?;
    // Here, since `try_run` indexes the first of both.
    let (inputs, outputs) = (model.input_ids().len(), model.output_ids().len());
    if inputs != 1 || outputs == 0 {
        return Err(format!("{inputs} inputs, {outputs} outputs").into());
    }
    Ok(model)
}

fn read_bounded(file: &Path) -> std::io::Result<Vec<u8>> {
    let size = std::fs::metadata(file)?.len();
    if size > MAX_FILE_BYTES {
        return Err(std::io::Error::other(format!(
            "{size} bytes are too many for a PP-OCR network"
        )));
    }
    std::fs::read(file)
}
