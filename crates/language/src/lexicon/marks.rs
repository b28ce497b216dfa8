//! Punctuation, folded, that structures an instruction whatever its language.

/// Marks that part the items of a list.
const COMMAS: [&str; 1] = [","];
/// Marks that end a sentence.
const STOPS: [&str; 5] = [".", "。", "!", "?", ";"];
/// Marks that tie numbers.
const DASHES: [&str; 2] = ["-", "/"];
/// Marks that no name runs across.
const DIVIDERS: [&str; 6] = [",", ";", ":", ".", "、", "。"];
/// Marks inside a word.
const INSIDE_WORDS: [&str; 2] = ["'", "-"];

/// Makes the number beside it a label.
pub(crate) const NUMBER_SIGN: &str = "#";
/// Ends a sentence, an initial, an abbreviation or an ordinal; parts hours and minutes.
pub(crate) const POINT: &str = ".";
/// Announces what follows; parts hours and minutes.
pub(crate) const COLON: &str = ":";
/// Ties the numbers of a range, of a telephone number, of tens and units.
pub(crate) const HYPHEN: &str = "-";

/// Whether a mark parts the items of a list.
pub(crate) fn is_comma(mark: &str) -> bool {
    COMMAS.contains(&mark)
}

/// Whether a mark ends a sentence.
pub(crate) fn is_stop(mark: &str) -> bool {
    STOPS.contains(&mark)
}

/// Whether a mark ties numbers.
pub(crate) fn is_dash(mark: &str) -> bool {
    DASHES.contains(&mark)
}

/// Whether no name runs across a mark.
pub(crate) fn is_divider(mark: &str) -> bool {
    DIVIDERS.contains(&mark)
}

/// Whether a mark may stand inside a word: `Don't`.
pub(crate) fn is_inside_words(mark: &str) -> bool {
    INSIDE_WORDS.contains(&mark)
}
