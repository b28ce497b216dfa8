//! Quotation of text from servers and models in errors.

/// Maximum length of a quotation, characters: some servers answer with whole pages of HTML.
const MAX_CHARS: usize = 300;

/// The beginning of a text, with control characters replaced by spaces.
pub(crate) fn quote(text: &str) -> String {
    text.chars()
        // One line, and no escape sequences for a terminal.
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(MAX_CHARS)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotations_are_one_short_line() {
        assert_eq!(quote("a\r\nb"), "a  b");
        assert_eq!(quote(&"ü".repeat(MAX_CHARS + 1)).chars().count(), MAX_CHARS);
    }
}
