//! How much a policy server may say.

/// Limit of the length of an answer, bytes: the largest one in double precision is half as long.
/// Not larger, since a value of one byte takes many times as much when it is decoded.
pub const MAX_ANSWER_BYTES: usize = 4 << 20;
/// Limit of the number of rows of an answer: actions, or points of a path.
pub const MAX_ROWS: usize = 4096;
/// Limit of the number of columns of an answer.
pub const MAX_COLUMNS: usize = 64;
/// Shortest time that a velocity lasts, seconds.
pub const MIN_PERIOD_S: f64 = 1e-3;
/// Longest time that a velocity lasts, or anything is waited for, seconds.
pub const MAX_PERIOD_S: f64 = 86_400.0;
/// Limit of what is shown of an error of a server, characters.
const MAX_SHOWN: usize = 400;

/// The end of a text, which of a traceback says what went wrong, on one line.
pub fn shown(text: &str) -> String {
    // No escape sequences for a terminal.
    let text: String = text
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
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
        let lines = "\n  \u{1b}[31mline".repeat(500);
        let traceback = format!("Traceback{lines}\nKeyError: 'image'\n");
        let shown = shown(&traceback);
        assert!(shown.ends_with("[31mline KeyError: 'image'"), "{shown}");
        assert!(shown.chars().count() <= MAX_SHOWN + 2);
    }
}
