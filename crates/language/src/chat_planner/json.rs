//! JSON as chat models write it: in code fences, with prose around it, with trailing commas.
//!
//! Not repaired: answers that are cut off, single quotes, comments. The model is asked again
//! instead.

use serde_json::Value;

use crate::error::AnswerError;

/// Answers longer than this, in bytes, are not read.
const LONGEST_ANSWER: usize = 200_000;
/// How many opening brackets are tried.
const MOST_STARTS: usize = 50;

/// The first object or array in `text`.
pub(super) fn find_json(text: &str) -> Result<Value, AnswerError> {
    if text.len() > LONGEST_ANSWER {
        return Err(AnswerError::TooLong);
    }
    // Models that think aloud do so before this mark.
    let answer = text.rsplit("</think>").next().unwrap_or(text);
    let starts = answer
        .char_indices()
        .filter(|(_, c)| matches!(c, '{' | '['))
        .map(|(i, _)| i);
    // Prose may hold brackets too, so the next one is tried. Each try may read the whole answer, so
    // their number is bounded.
    let found = starts
        .take(MOST_STARTS)
        .find_map(|start| value_at(&answer[start..]));
    found.ok_or(AnswerError::NoJson)
}

fn value_at(text: &str) -> Option<Value> {
    let piece = &text[..closing(text)?];
    let value: Value = serde_json::from_str(piece)
        // Repaired only if it does not parse as it is.
        .or_else(|_| serde_json::from_str(&without_trailing_commas(piece)))
        .ok()?;
    (value.is_object() || value.is_array()).then_some(value)
}

/// Follows which characters of JSON are inside a string.
#[derive(Default)]
struct Strings {
    is_inside: bool,
    is_escaped: bool,
}

impl Strings {
    /// Whether the next character is outside all strings.
    fn is_outside(&mut self, next: char) -> bool {
        if self.is_escaped {
            self.is_escaped = false;
            return false;
        }
        match next {
            '\\' if self.is_inside => self.is_escaped = true,
            '"' => self.is_inside = !self.is_inside,
            _ => {}
        }
        !self.is_inside
    }
}

/// Where the bracket that opens `text` is closed.
fn closing(text: &str) -> Option<usize> {
    let mut strings = Strings::default();
    let mut depth = 0_usize;
    for (at, c) in text.char_indices() {
        if !strings.is_outside(c) {
            continue;
        }
        match c {
            '{' | '[' => depth += 1,
            '}' | ']' => {
                // Brackets need not match in kind here: the parser decides that.
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return Some(at + c.len_utf8());
                }
            }
            _ => {}
        }
    }
    None
}

fn without_trailing_commas(text: &str) -> String {
    let mut strings = Strings::default();
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if strings.is_outside(c) && matches!(c, '}' | ']') {
            let kept = out.trim_end().trim_end_matches(',').len();
            out.truncate(kept);
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn json_is_found_in_what_models_say() {
        let wanted = json!({"order": [2, 1]});
        for text in [
            "{\"order\": [2, 1]}",
            "Sure!\n```json\n{\"order\": [2, 1,],}\n```\nAnything else?",
            "<think>maybe {\"order\": [1, 2]}</think>{\"order\": [2, 1]}",
            "I {think} so: {\"order\": [2, 1]}",
        ] {
            assert_eq!(find_json(text), Ok(wanted.clone()), "{text}");
        }
        assert_eq!(find_json("[{\"a\": \"}],\"}]"), Ok(json!([{"a": "}],"}])));
    }

    #[test]
    fn half_json_is_refused() {
        for text in ["", "no", "{\"order\": [2,", "{'order': 1}"] {
            assert!(find_json(text).is_err(), "{text}");
        }
    }
}
