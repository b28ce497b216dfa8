//! The part of an answer that a model has written, and detection of repetitions.

use std::ops::RangeInclusive;

use llama_cpp_2::token::LlamaToken;

use crate::quote::quote;

/// Lengths of sequences that count as a loop if they are repeated, tokens. Shorter ones are usual
/// in JSON: lists of equal brackets, commas and keys.
const LOOP_TOKENS: RangeInclusive<usize> = 8..=200;
/// Number of repetitions that count as a loop.
const LOOP_REPETITIONS: usize = 4;
/// Length of the end of an answer in errors, characters.
const QUOTED_CHARS: usize = 120;

/// The answer so far.
#[derive(Default)]
pub(super) struct Written {
    pub bytes: Vec<u8>,
    pub tokens: Vec<LlamaToken>,
}

impl Written {
    /// Whether the end is a loop. Small models do not leave a loop once they are in one.
    pub(super) fn repeats_itself(&self) -> bool {
        LOOP_TOKENS
            .into_iter()
            .any(|length| ends_with_loop(&self.tokens, length))
    }

    /// The end of the answer, for errors.
    pub(super) fn end(&self) -> String {
        let text = String::from_utf8_lossy(&self.bytes);
        let skip = text.chars().count().saturating_sub(QUOTED_CHARS);
        format!(": …{}", quote(&text.chars().skip(skip).collect::<String>()))
    }
}

/// Whether the end repeats a sequence of `length` tokens.
fn ends_with_loop<T: PartialEq>(tokens: &[T], length: usize) -> bool {
    let Some(begin) = tokens.len().checked_sub(LOOP_REPETITIONS * length) else {
        return false;
    };
    let end = &tokens[begin..];
    // Equal to itself shifted by `length`: the end is periodic, which is the same as four equal
    // pieces.
    end[length..] == end[..end.len() - length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_has_four_repetitions() {
        let four = "ababcdcdcdcd";
        assert!(ends_with_loop(four.as_bytes(), 2));
        assert!(!ends_with_loop(&four.as_bytes()[..11], 2));
        assert!(!ends_with_loop(four.as_bytes(), 3) && !ends_with_loop(four.as_bytes(), 4));
    }
}
