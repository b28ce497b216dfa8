//! What a strip of text says: the recognition network and greedy CTC decoding.

use std::path::Path;
use std::sync::Arc;

use rten::ThreadPool;
use rten_tensor::prelude::*;
use rten_tensor::{NdTensor, NdTensorView};

use super::keys;
use super::network::Network;
use crate::reader::ReaderError;

/// Reads one line of text.
pub(super) struct Recogniser {
    network: Network,
    keys: Vec<String>,
}

impl Recogniser {
    pub(super) fn load(file: &Path, keys: Option<&Path>) -> Result<Self, ReaderError> {
        let network = Network::load(file, "recognition")?;
        let broken = |detail: String| ReaderError::Model { file: file.to_owned(), detail };
        let keys = match (keys, network.metadata("character")) {
            (Some(keys), _) => keys::read(keys)?,
            (None, Some(characters)) => keys::from_metadata(characters).map_err(broken)?,
            (None, None) => {
                return Err(broken("it has no alphabet inside and no file of keys was given".into()));
            }
        };
        Ok(Self { network, keys })
    }

    /// The text of a strip and the mean probability of its characters, 0 where there are none.
    pub(super) fn read(
        &self,
        strip: NdTensor<f32, 4>,
        thread: &Arc<ThreadPool>,
    ) -> Result<(String, f32), ReaderError> {
        let classes: NdTensor<f32, 3> = self.network.run(strip, thread)?;
        let [batch, _, count] = classes.shape();
        if batch != 1 || count != self.keys.len() {
            let detail = format!(
                "{count} classes, but the alphabet has {}: the files do not belong together",
                self.keys.len()
            );
            return Err(ReaderError::Inference { stage: "recognition", detail });
        }
        Ok(decode(classes.slice(0), &self.keys))
    }
}

/// Greedy CTC: the likeliest class of each step, repetitions counted once, blanks (class 0) dropped.
fn decode(steps: NdTensorView<f32, 2>, keys: &[String]) -> (String, f32) {
    let (mut text, mut sum, mut count, mut previous) = (String::new(), 0.0, 0_u32, 0);
    for step in 0..steps.size(0) {
        let (class, probability) = likeliest(steps.slice(step));
        if class != 0 && class != previous {
            text.push_str(&keys[class]);
            sum += probability;
            count += 1;
        }
        previous = class;
    }
    (text, if count == 0 { 0.0 } else { sum / count as f32 })
}

fn likeliest(probabilities: NdTensorView<f32, 1>) -> (usize, f32) {
    probabilities
        .iter()
        .enumerate()
        .fold((0, f32::MIN), |best, (class, &p)| if p > best.1 { (class, p) } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alphabet() -> Vec<String> {
        ["blank", "1", "U", " "].map(String::from).to_vec()
    }

    fn steps(classes: &[usize]) -> NdTensor<f32, 2> {
        NdTensor::from_fn([classes.len(), 4], |[step, class]| if classes[step] == class { 0.7 } else { 0.1 })
    }

    #[test]
    fn repetitions_merge_unless_a_blank_parts_them() {
        let (text, confidence) = decode(steps(&[2, 2, 0, 3, 0, 1, 1, 0, 1]).view(), &alphabet());
        assert_eq!(text, "U 11");
        assert!((confidence - 0.7).abs() < 1e-6);
    }

    #[test]
    fn nothing_but_blanks_is_no_text() {
        assert_eq!(decode(steps(&[0, 0, 0]).view(), &alphabet()), (String::new(), 0.0));
    }
}
