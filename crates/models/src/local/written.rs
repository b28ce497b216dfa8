//! What a model has written of an answer, and whether it goes round in circles.

use std::ops::RangeInclusive;

use llama_cpp_2::token::LlamaToken;

use crate::quote::quote;

/// How many tokens may stand how often one after the other before that is a loop.
const LOOPS: RangeInclusive<usize> = 8..=200;
const REPEATED: usize = 4;
/// Characters of an answer that an error quotes.
const QUOTED: usize = 120;

/// An answer so far.
#[derive(Default)]
pub(super) struct Written {
    pub bytes: Vec<u8>,
    pub tokens: Vec<LlamaToken>,
}

impl Written {
    /// Whether the end is the same several times over. Small models that fall into that do not get out of it.
    pub(super) fn repeats_itself(&self) -> bool {
        LOOPS.into_iter().any(|length| ends_with_loop(&self.tokens, length))
    }

    /// How it ends, in quotes.
    pub(super) fn end(&self) -> String {
        let text = String::from_utf8_lossy(&self.bytes);
        let skip = text.chars().count().saturating_sub(QUOTED);
        format!(": …{}", quote(&text.chars().skip(skip).collect::<String>()))
    }
}

/// Whether the end is the same so many tokens over and over.
fn ends_with_loop<T: PartialEq>(tokens: &[T], length: usize) -> bool {
    let Some(begin) = tokens.len().checked_sub(REPEATED * length) else { return false };
    let end = &tokens[begin..];
    end[length..] == end[..end.len() - length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_is_the_same_four_times_over() {
        let four = "ababcdcdcdcd";
        assert!(ends_with_loop(four.as_bytes(), 2));
        assert!(!ends_with_loop(&four.as_bytes()[..11], 2));
        assert!(!ends_with_loop(four.as_bytes(), 3) && !ends_with_loop(four.as_bytes(), 4));
    }
}
