//! Recognition of a line of text, with greedy CTC decoding.

use std::path::Path;
use std::sync::Arc;

use rten::ThreadPool;
use rten_tensor::prelude::*;
use rten_tensor::{NdTensor, NdTensorView};

use super::keys;
use super::network::Network;
use crate::error::{Cause, ReaderError};

/// The name of this stage in errors.
const STAGE: &str = "recognition";

/// Recognizes a line of text.
pub(super) struct Recogniser {
    network: Network,
    keys: Vec<String>,
}

impl Recogniser {
    pub(super) fn load(file: &Path, keys: Option<&Path>) -> Result<Self, ReaderError> {
        let network = Network::load(file, STAGE)?;
        let keys = match keys {
            Some(keys) => keys::read(keys)?,
            None => keys_inside(&network).map_err(|source| ReaderError::Model {
                file: file.to_owned(),
                source,
            })?,
        };
        Ok(Self { network, keys })
    }

    /// The text of a strip.
    pub(super) fn read(
        &self,
        strip: NdTensor<f32, 4>,
        thread: &Arc<ThreadPool>,
    ) -> Result<Line, ReaderError> {
        let classes: NdTensor<f32, 3> = self.network.run(strip, thread)?;
        let [batch, _, count] = classes.shape();
        // Also what makes `keys[class]` safe in `decode`.
        if batch != 1 || count != self.keys.len() {
            let detail = format!(
                "{count} classes, but the alphabet has {}: the files are of different models",
                self.keys.len()
            );
            return Err(ReaderError::Inference {
                stage: STAGE,
                source: detail.into(),
            });
        }
        Ok(decode(classes.slice(0), &self.keys))
    }
}

/// A recognized line.
#[derive(Debug, PartialEq)]
pub(super) struct Line {
    pub text: String,
    /// Mean probability of its characters, 0 if there are none.
    pub confidence: f32,
}

/// The alphabet in the file of the network.
fn keys_inside(network: &Network) -> Result<Vec<String>, Cause> {
    let Some(characters) = network.metadata("character") else {
        return Err("it contains no alphabet, and no file with one is given".into());
    };
    Ok(keys::from_metadata(characters)?)
}

/// Greedy CTC decoding: the most probable class of each step, without repetitions and blanks (class
/// 0).
fn decode(steps: NdTensorView<f32, 2>, keys: &[String]) -> Line {
    let (mut text, mut sum, mut count, mut previous) = (String::new(), 0.0, 0_u32, 0);
    for step in 0..steps.size(0) {
        let (class, probability) = most_probable(steps.slice(step));
        if class != 0 && class != previous {
            text.push_str(&keys[class]);
            sum += probability;
            count += 1;
        }
        // The blank counts as well: between two blanks the same letter is a new one, as in `ll`.
        previous = class;
    }
    Line {
        text,
        confidence: if count == 0 { 0.0 } else { sum / count as f32 },
    }
}

fn most_probable(probabilities: NdTensorView<f32, 1>) -> (usize, f32) {
    probabilities.iter().enumerate().fold(
        (0, f32::MIN),
        |best, (class, &p)| if p > best.1 { (class, p) } else { best },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alphabet() -> Vec<String> {
        ["blank", "1", "U", " "].map(String::from).to_vec()
    }

    fn steps(classes: &[usize]) -> NdTensor<f32, 2> {
        NdTensor::from_fn([classes.len(), 4], |[step, class]| {
            if classes[step] == class { 0.7 } else { 0.1 }
        })
    }

    #[test]
    fn repetitions_merge_unless_a_blank_separates_them() {
        let line = decode(steps(&[2, 2, 0, 3, 0, 1, 1, 0, 1]).view(), &alphabet());
        assert_eq!(line.text, "U 11");
        assert!((line.confidence - 0.7).abs() < 1e-6);
    }

    #[test]
    fn blanks_only_are_no_text() {
        let line = decode(steps(&[0, 0, 0]).view(), &alphabet());
        assert_eq!(
            line,
            Line {
                text: String::new(),
                confidence: 0.0
            }
        );
    }
}
