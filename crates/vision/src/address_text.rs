//! The unit that the text of a plate names.
//!
//! Letters that readers confuse with digits are accepted where a digit must be: after a word for
//! "unit" or in a number of its own. These are `I`, `l`, `|`, `!`, `工` for 1 and `O`, `o` for 0.
//! `Z`, `S` and `B` are not accepted, since on worn plates they may be 7 or 2, 3 or 5, 3 or 8.
//!
//! The word may have one wrong letter, which lowers the score. A number is read completely or not
//! at all, so `UNIT 11` is never `unit1`. A letter that may belong to the word or to the number, as
//! in `UNITI`, belongs to the word only if a number remains.

use openbench_core::address::fold_name;

/// Words for the level of an address below the building, in lower case without spaces.
const WORDS: [&str; 8] = [
    "unit",
    "apartment",
    "apt",
    "number",
    "no",
    "flat",
    "suite",
    "door",
];
/// Chinese words for unit, number and door, which follow the number.
const SUFFIXES: [&str; 4] = ["单元", "單元", "号", "门"];
/// Maximum number of digits of a unit. Longer numbers are telephone numbers or years.
const MAX_DIGITS: usize = 4;
/// Score of a number without a word for "unit".
const BARE_NUMBER_SCORE: f32 = 0.6;
/// Score of a letter in place of a digit that looks like it.
const LOOK_ALIKE_SCORE: f32 = 0.9;
/// Score of a word with one wrong letter.
const MISSPELT_WORD_SCORE: f32 = 0.7;

/// The unit that the text of a plate names.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitText {
    /// Canonical name of the unit: `unit<N>`, without leading zeros.
    pub unit: String,
    /// How literally the text names it, 0 to 1: 1 for "UNIT 12", less for each wrong letter and for
    /// numbers without a word.
    pub score: f32,
    /// Whether the text contains a word for "unit". A number alone is weak evidence, since readers
    /// see digits in window frames and pipes.
    pub worded: bool,
}

/// The unit that the text of a plate names, or `None` if it names none clearly.
///
/// ```
/// use openbench_vision::parse_unit;
/// assert_eq!(parse_unit("UNlT 12").unwrap().unit, "unit12");
/// assert_eq!(parse_unit("1单元").unwrap().unit, "unit1");
/// assert_eq!(parse_unit("EXIT"), None);
/// ```
pub fn parse_unit(text: &str) -> Option<UnitText> {
    if names_a_range(text) {
        return None;
    }
    let folded: String = fold_name(text).chars().filter(|c| !is_mark(*c)).collect();
    let candidates = [after_word(&folded), before_word(&folded), bare(&folded)];
    candidates
        .into_iter()
        .flatten()
        .max_by(|a, b| a.score.total_cmp(&b.score))
}

/// Whether a mark stands between two digits, as in `UNIT 1-4`: several units, or part of a number.
fn names_a_range(text: &str) -> bool {
    let letters: Vec<char> = text.chars().filter(|c| !c.is_whitespace()).collect();
    let is_range = |w: &[char]| w[0].is_ascii_digit() && is_mark(w[1]) && w[2].is_ascii_digit();
    letters.windows(3).any(is_range)
}

/// Marks between word and number, as in `No. 12`, `UNIT-3`, `N° 4`.
fn is_mark(letter: char) -> bool {
    matches!(
        letter,
        '.' | ':' | '#' | '-' | '–' | '~' | '°' | '：' | '．'
    )
}

/// A number after a word, as in `unit12`. The word may have one wrong letter.
fn after_word(text: &str) -> Option<UnitText> {
    let letters: Vec<char> = text.chars().collect();
    let mut best: Option<UnitText> = None;
    for word in WORDS {
        // The word with one letter less, as many, or one more, but no single letter, which says
        // nothing. `word.len()` is in letters, since these words are ASCII.
        for length in
            word.chars().count().saturating_sub(1).max(2)..=(word.len() + 1).min(letters.len())
        {
            let Some(word_score) = likeness(&letters[..length], word) else {
                continue;
            };
            let Some(number) = number(&letters[length..]) else {
                continue;
            };
            // A wrong word and a wrong number together are ambiguous: UNTI may be UNIT or UNIT 1.
            if word_score < 1.0 && number.score < 1.0 {
                continue;
            }
            let found = UnitText {
                score: word_score * number.score,
                ..number
            };
            if best.as_ref().is_none_or(|best| found.score > best.score) {
                best = Some(found);
            }
        }
    }
    best
}

/// A number in front of a word, as in `1单元`, with Arabic or Chinese digits.
fn before_word(text: &str) -> Option<UnitText> {
    let head = SUFFIXES.iter().find_map(|word| text.strip_suffix(word))?;
    let letters: Vec<char> = head.chars().map(western_digit).collect();
    number(&letters)
}

/// A number alone, as in `12`, with at least one digit, since a single `I` or `O` is ambiguous.
fn bare(text: &str) -> Option<UnitText> {
    let letters: Vec<char> = text.chars().collect();
    let has_digit = letters.iter().any(char::is_ascii_digit);
    let number = number(&letters).filter(|_| has_digit)?;
    Some(UnitText {
        score: BARE_NUMBER_SCORE * number.score,
        worded: false,
        ..number
    })
}

/// All letters as the number of a unit with a word for "unit".
fn number(letters: &[char]) -> Option<UnitText> {
    // Also keeps `value` far below the limit of `u32`.
    if letters.is_empty() || letters.len() > MAX_DIGITS {
        return None;
    }
    let (mut value, mut score) = (0_u32, 1.0);
    for &letter in letters {
        let digit = Digit::of(letter)?;
        value = 10 * value + digit.value;
        score *= digit.score;
    }
    // Units are counted from 1.
    (value > 0).then(|| UnitText {
        unit: format!("unit{value}"),
        score,
        worded: true,
    })
}

/// A letter as a digit.
struct Digit {
    value: u32,
    /// 1 for a digit, less for a letter that looks like one.
    score: f32,
}

impl Digit {
    fn of(letter: char) -> Option<Self> {
        match letter {
            '0'..='9' => Some(Self {
                value: letter.to_digit(10)?,
                score: 1.0,
            }),
            'i' | 'l' | '|' | '!' | '工' => Some(Self {
                value: 1,
                score: LOOK_ALIKE_SCORE,
            }),
            'o' => Some(Self {
                value: 0,
                score: LOOK_ALIKE_SCORE,
            }),
            _ => None,
        }
    }
}

fn western_digit(letter: char) -> char {
    "零一二三四五六七八九"
        .chars()
        .position(|c| c == letter)
        .and_then(|n| char::from_digit(n as u32, 10))
        .unwrap_or(letter)
}

/// The score of letters as a word: 1 if they are equal or look alike, less for one mistake in a
/// word of at least four letters, `None` for more mistakes.
fn likeness(letters: &[char], word: &str) -> Option<f32> {
    let word: Vec<char> = word.chars().collect();
    // Of equal length a mistake is a replaced letter; of lengths that differ by one it is a letter
    // too many or missing. Together this is an edit distance of at most one.
    if letters.len() == word.len() {
        let wrong = letters
            .iter()
            .zip(&word)
            .filter(|(a, b)| !is_same(**a, **b))
            .count();
        return score_of(wrong, word.len());
    }
    let one_more = if letters.len() > word.len() {
        has_one_more_letter(letters, &word)
    } else {
        has_one_more_letter(&word, letters)
    };
    if one_more {
        score_of(1, word.len())
    } else {
        None
    }
}

/// Whether `long` without one of its letters is `short`, as far as both go.
fn has_one_more_letter(long: &[char], short: &[char]) -> bool {
    (0..long.len()).any(|skip| {
        let rest = long[..skip].iter().chain(&long[skip + 1..]);
        rest.zip(short).all(|(a, b)| is_same(*a, *b))
    })
}

fn is_same(a: char, b: char) -> bool {
    a == b || look_alike(a) == look_alike(b)
}

fn score_of(mistakes: usize, word_length: usize) -> Option<f32> {
    match mistakes {
        0 => Some(1.0),
        1 if word_length >= 4 => Some(MISSPELT_WORD_SCORE),
        _ => None,
    }
}

fn look_alike(letter: char) -> char {
    match letter {
        '1' | 'l' | '|' | '!' => 'i',
        '0' => 'o',
        // Only in words, which have no digits. In numbers a 7 is a digit.
        '7' => 't',
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn unit(text: &str) -> Option<String> {
        parse_unit(text).map(|found| found.unit)
    }

    #[test]
    fn correct_texts_name_their_unit() {
        for text in [
            "UNIT 1",
            "Unit1",
            "unit 01",
            " U N I T  1 ",
            "Apt. 1",
            "Apartment 1",
            "No. 1",
            "No.1",
            "#1",
            "1",
            "1单元",
            "一单元",
            "1号",
        ] {
            assert_eq!(unit(text).as_deref(), Some("unit1"), "{text}");
        }
        assert_eq!(unit("UNIT 12").as_deref(), Some("unit12"));
        assert_eq!(unit("Flat 305").as_deref(), Some("unit305"));
    }

    #[test]
    fn misread_texts_name_their_unit() {
        for text in [
            "UNlT 1", "UN1T 1", "UNITI", "unit l", "UNIT|", "UMIT 1", "UNT1", "ONIT 1", "unit工",
        ] {
            assert_eq!(unit(text).as_deref(), Some("unit1"), "{text}");
        }
        assert_eq!(unit("UNIT 1O").as_deref(), Some("unit10"));
        assert_eq!(unit("UNlTI2").as_deref(), Some("unit12"));
    }

    #[test]
    fn other_texts_name_no_unit() {
        for text in [
            "",
            "UNIT",
            "EXIT",
            "EXIT 1",
            "UNIT A",
            "UNIT 7Z",
            "unit 0",
            "I",
            "O",
            "Il",
            "010-62781234",
            "UNIT 1-2/3",
            "UNIT 1-4",
            "Main Street 5b",
            "UNT",
            "UNTI",
            "工",
        ] {
            assert_eq!(unit(text), None, "{text}");
        }
    }

    #[test]
    fn wrong_letters_lower_the_score() {
        let score = |text| parse_unit(text).unwrap().score;
        assert_eq!(score("UNIT 1"), 1.0);
        assert!(score("UNIT 1") > score("UNIT I") && score("UNIT I") > score("UNT 1"));
        assert!(score("1") < score("UNIT 1"));
        assert!(
            !parse_unit("1").unwrap().worded
                && parse_unit("UNIT 1").unwrap().worded
                && parse_unit("1号").unwrap().worded
        );
    }

    proptest! {
        #[test]
        fn numbers_are_read_completely(number in 1_u32..10_000) {
            let texts = [
                format!("UNIT {number}"),
                format!("unit{number}"),
                format!("{number}单元"),
                format!("No. {number}"),
                format!("{number}"),
            ];
            for text in texts {
                prop_assert_eq!(unit(&text), Some(format!("unit{}", number)));
            }
        }

        #[test]
        fn no_text_panics(text in "\\PC{0,40}") {
            let _ = parse_unit(&text);
        }
    }
}
