//! Quotations of foreign text in errors.

/// Characters that a quotation has at most.
const LONGEST: usize = 300;

/// The beginning of a text, on one line.
pub(crate) fn quote(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(LONGEST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotations_are_one_short_line() {
        assert_eq!(quote("a\r\nb"), "a  b");
        assert_eq!(quote(&"ü".repeat(LONGEST + 1)).chars().count(), LONGEST);
    }
}
