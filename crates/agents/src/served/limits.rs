//! How much a policy server may say.

/// Limit of the length of an answer, bytes.
pub const MAX_ANSWER_BYTES: usize = 16 << 20;
/// Limit of the number of rows of an answer: actions, or points of a path.
pub const MAX_ROWS: usize = 4096;
/// Limit of the number of columns of an answer.
pub const MAX_COLUMNS: usize = 64;
/// Limit of what is shown of an error of a server, characters.
const MAX_SHOWN: usize = 400;

/// The end of a text, which of a traceback says what went wrong, on one line.
pub fn shown(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let length = line.chars().count();
    if length <= MAX_SHOWN {
        return line;
    }
    let end: String = line.chars().skip(length - MAX_SHOWN).collect();
    format!("… {end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_error_the_end_is_shown() {
        let traceback = format!("Traceback{}\nKeyError: 'image'\n", "\n  line".repeat(500));
        let shown = shown(&traceback);
        assert!(shown.ends_with("line KeyError: 'image'"), "{shown}");
        assert!(shown.chars().count() <= MAX_SHOWN + 2);
    }
}
