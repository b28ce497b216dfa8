//! From the text on a plate to the unit that it names.
//!
//! Letters that readers confuse with digits are forgiven only where a digit must stand, after a word for "unit" or in a number on its own:
//! `I`, `l`, `|`, `!`, `工` for 1 and `O`, `o` for 0. `Z`, `S` and `B` are not: on worn plates they stand for 7 and 2, 3 and 5, 3 and 8.
//! The word itself may be misread in one letter, at a price in the score. A number is taken whole or not at all, so `UNIT 11` is never `unit1`;
//! where a letter may belong to the word or to the number (`UNITI`), the longer word wins only if a number remains.

use openbench_core::address::fold_name;

/// Words for the level of an address below the building. All are compared in lower case without spaces.
const WORDS: [&str; 8] = ["unit", "apartment", "apt", "number", "no", "flat", "suite", "door"];
/// Chinese words, which stand behind the number: unit, number, door.
const WORDS_BEHIND: [&str; 4] = ["单元", "單元", "号", "门"];
/// Longer numbers are telephone numbers or years, not units.
const MAX_DIGITS: usize = 4;
/// What a number without a word for "unit" counts.
const BARE_NUMBER_SCORE: f32 = 0.6;
/// What a letter counts that stands for a digit which looks like it.
const LOOK_ALIKE_SCORE: f32 = 0.9;
/// What a word counts that is wrong in one letter.
const MISSPELT_WORD_SCORE: f32 = 0.7;

/// What a plate says about its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitText {
    /// The unit's canonical name: `unit<N>`, without leading zeros.
    pub unit: String,
    /// How literally the plate says so, 0 to 1: 1 for "UNIT 12" letter by letter, less for every letter that had to be forgiven, and for bare numbers.
    pub score: f32,
    /// Whether a word for "unit" stands with the number. A bare number is weak evidence: readers see digits in window frames and pipes.
    pub worded: bool,
}

/// The unit that a plate's text names, or `None` if it names none clearly.
///
/// ```
/// use openbench_vision::parse_unit;
/// assert_eq!(parse_unit("UNlT 12").unwrap().unit, "unit12");
/// assert_eq!(parse_unit("1单元").unwrap().unit, "unit1");
/// assert_eq!(parse_unit("EXIT"), None);
/// ```
pub fn parse_unit(text: &str) -> Option<UnitText> {
    let folded: String =
        fold_name(text).chars().filter(|c| !matches!(c, '.' | ':' | '#' | '-' | '°' | '：' | '．')).collect();
    let candidates = [after_word(&folded), before_word(&folded), bare(&folded)];
    candidates.into_iter().flatten().max_by(|a, b| a.score.total_cmp(&b.score))
}

/// "unit12", the word perhaps misread in one letter.
fn after_word(text: &str) -> Option<UnitText> {
    let letters: Vec<char> = text.chars().collect();
    let mut best: Option<UnitText> = None;
    for word in WORDS {
        for length in word.chars().count().saturating_sub(1).max(2)..=(word.len() + 1).min(letters.len()) {
            let Some(word_score) = likeness(&letters[..length], word) else { continue };
            let Some(number) = number(&letters[length..]) else { continue };
            // A wrong word before a wrong number may be anything: UNTI is UNIT as well as UNIT 1.
            if word_score < 1.0 && number.score < 1.0 {
                continue;
            }
            let found = UnitText { score: word_score * number.score, ..number };
            if best.as_ref().is_none_or(|best| found.score > best.score) {
                best = Some(found);
            }
        }
    }
    best
}

/// "1单元", with Arabic or Chinese digits.
fn before_word(text: &str) -> Option<UnitText> {
    let head = WORDS_BEHIND.iter().find_map(|word| text.strip_suffix(word))?;
    let letters: Vec<char> = head.chars().map(western_digit).collect();
    number(&letters)
}

/// "12", with at least one true digit, for a lone "I" or "O" may be anything.
fn bare(text: &str) -> Option<UnitText> {
    let letters: Vec<char> = text.chars().collect();
    let has_digit = letters.iter().any(char::is_ascii_digit);
    let number = number(&letters).filter(|_| has_digit)?;
    Some(UnitText { score: BARE_NUMBER_SCORE * number.score, worded: false, ..number })
}

/// The whole of `letters` as a number beside a word for "unit".
fn number(letters: &[char]) -> Option<UnitText> {
    if letters.is_empty() || letters.len() > MAX_DIGITS {
        return None;
    }
    let (mut value, mut score) = (0_u32, 1.0);
    for &letter in letters {
        let digit = Digit::of(letter)?;
        value = 10 * value + digit.value;
        score *= digit.score;
    }
    (value > 0).then(|| UnitText { unit: format!("unit{value}"), score, worded: true })
}

/// What a letter counts for where a digit must stand.
struct Digit {
    value: u32,
    /// 1 for a digit, less for a letter that readers confuse with one.
    score: f32,
}

impl Digit {
    fn of(letter: char) -> Option<Self> {
        match letter {
            '0'..='9' => Some(Self { value: letter.to_digit(10)?, score: 1.0 }),
            'i' | 'l' | '|' | '!' | '工' => Some(Self { value: 1, score: LOOK_ALIKE_SCORE }),
            'o' => Some(Self { value: 0, score: LOOK_ALIKE_SCORE }),
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

/// 1 for the word itself, also with look-alike letters; 0.7 for one other mistake in a word of four letters or more; `None` for more.
fn likeness(letters: &[char], word: &str) -> Option<f32> {
    let word: Vec<char> = word.chars().collect();
    if letters.len() == word.len() {
        let wrong = letters.iter().zip(&word).filter(|(a, b)| !is_same(**a, **b)).count();
        return score_of(wrong, word.len());
    }
    let one_more = if letters.len() > word.len() {
        is_with_one_more(letters, &word)
    } else {
        is_with_one_more(&word, letters)
    };
    if one_more { score_of(1, word.len()) } else { None }
}

/// Whether leaving out one letter of `long` makes it begin as `short` does.
fn is_with_one_more(long: &[char], short: &[char]) -> bool {
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
    fn plates_as_painted() {
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
    fn plates_as_misread() {
        for text in ["UNlT 1", "UN1T 1", "UNITI", "unit l", "UNIT|", "UMIT 1", "UNT1", "ONIT 1", "unit工"] {
            assert_eq!(unit(text).as_deref(), Some("unit1"), "{text}");
        }
        assert_eq!(unit("UNIT 1O").as_deref(), Some("unit10"));
        assert_eq!(unit("UNlTI2").as_deref(), Some("unit12"));
    }

    #[test]
    fn texts_that_name_no_unit() {
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
            "Main Street 5b",
            "UNT",
            "UNTI",
            "工",
        ] {
            assert_eq!(unit(text), None, "{text}");
        }
    }

    #[test]
    fn forgiven_letters_cost_score() {
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
        fn every_number_comes_back_whole(number in 1_u32..10_000) {
            for text in [format!("UNIT {number}"), format!("unit{number}"), format!("{number}单元"), format!("No. {number}"), format!("{number}")] {
                prop_assert_eq!(unit(&text), Some(format!("unit{}", number)));
            }
        }

        #[test]
        fn any_text_is_survived(text in "\\PC{0,40}") {
            let _ = parse_unit(&text);
        }
    }
}
