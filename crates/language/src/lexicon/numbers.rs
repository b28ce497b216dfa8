//! Numbers in an instruction: digits, words, ordinals, ideographs; and what looks like a number but
//! labels nothing (times, decimals, measures, telephone numbers).
//!
//! Numbers above 99,999 label nothing. Word numbers reach 999.

use super::class::Class;
use super::languages::{LANGUAGES, numeral, words_of};
use super::lexeme::Lex;
use super::marks;
use super::tokens::{Kind, Token, condensed};
use super::words::{Meaning, Vocabulary};

/// The fewest digits of a telephone number, which are tied by hyphens.
const SHORTEST_TELEPHONE: usize = 7;
/// The fewest digits of one that does not begin with a zero.
const SHORTEST_WITHOUT_ZERO: usize = 9;
/// More digits than these label nothing.
const MOST_DIGITS: usize = 5;
/// The most ideographs of a number.
const MOST_NUMERALS: usize = 9;

/// A number at the beginning of some tokens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Number {
    /// How many tokens it takes.
    pub length: usize,
    /// [`Lex::Number`] or [`Lex::Quantity`].
    pub lex: Lex,
}

impl Number {
    fn cardinal(length: usize, value: u32) -> Self {
        Self {
            length,
            lex: Lex::cardinal(value),
        }
    }

    fn quantity(length: usize) -> Self {
        Self {
            length,
            lex: Lex::Quantity,
        }
    }
}

/// The number at token `at`.
pub(crate) fn number(tokens: &[Token], at: usize, vocabulary: Vocabulary<'_>) -> Option<Number> {
    let rest = &tokens[at..];
    match tokens[at].kind {
        Kind::Digits => Some(digits(rest, vocabulary)),
        Kind::Ideograph => ideographs(rest, vocabulary),
        Kind::Letters => lettered(rest)
            .or_else(|| spelt(rest, vocabulary))
            .or_else(|| Some(Number::cardinal(1, compound(&rest[0].text, vocabulary)?))),
        Kind::Mark => None,
    }
}

/// The token at `at`, if it is of a kind and no white space stands before it.
fn glued(tokens: &[Token], at: usize, kind: Kind) -> Option<&Token> {
    tokens
        .get(at)
        .filter(|token| token.glued && token.kind == kind)
}

/// `3`, `3rd`, `12A`, and digits that label nothing.
fn digits(tokens: &[Token], vocabulary: Vocabulary<'_>) -> Number {
    // Before labels: the first digits of a decimal or a telephone number would be one.
    if let Some(number) = decimal_or_time(tokens) {
        return number;
    }
    if let Some(length) = telephone(tokens) {
        return Number::quantity(length);
    }
    let digits = without_zeros(&tokens[0].text);
    let number = labelled(digits, tokens, vocabulary);
    if digits.len() > MOST_DIGITS {
        return Number::quantity(number.length);
    }
    measured(number, tokens, vocabulary)
}

/// Digits without leading zeros.
fn without_zeros(digits: &str) -> &str {
    let short = digits.trim_start_matches('0');
    if short.is_empty() { "0" } else { short }
}

/// `2.5`, `2.5kg`, `18:30`.
fn decimal_or_time(tokens: &[Token]) -> Option<Number> {
    let mark = glued(tokens, 1, Kind::Mark)?.text.as_str();
    if mark != marks::POINT && mark != marks::COLON {
        return None;
    }
    glued(tokens, 2, Kind::Digits)?;
    let has_unit = mark == marks::POINT && glued(tokens, 3, Kind::Letters).is_some();
    Some(Number::quantity(if has_unit { 4 } else { 3 }))
}

/// Digits and the letters that are glued to them.
fn labelled(digits: &str, tokens: &[Token], vocabulary: Vocabulary<'_>) -> Number {
    let number = |length, suffix: &str, ordinal| {
        let label = format!("{digits}{suffix}");
        Number {
            length,
            lex: Lex::Number { label, ordinal },
        }
    };
    let Some(next) = glued(tokens, 1, Kind::Letters) else {
        return number(1, "", false);
    };
    let is_measure = vocabulary.begins_with(&tokens[1..], Class::Measure);
    let is_letter = next.text.chars().count() == 1 && !is_letter_level(&tokens[1..]);
    if is_ordinal_ending(&next.text, vocabulary) {
        number(2, "", true)
    // `12A` is a label; `12m` may be a length, so a small letter must be no measure.
    } else if is_letter && (next.capital || !is_measure) {
        number(2, &next.text, false)
    } else if is_measure {
        Number::quantity(2)
    } else {
        number(1, "", false)
    }
}

/// `0800-22-3344`: how many tokens of digits are tied by hyphens, if they are more than an address
/// has (`12-3-1502`, `1201-1204`).
fn telephone(tokens: &[Token]) -> Option<usize> {
    let first = &tokens[0].text;
    let mut length = 1;
    let mut digits = first.len();
    while glued(tokens, length, Kind::Mark).is_some_and(|mark| mark.text == marks::HYPHEN)
        && let Some(next) = glued(tokens, length + 1, Kind::Digits)
    {
        length += 2;
        digits += next.text.len();
    }
    let fewest = if first.starts_with('0') {
        SHORTEST_TELEPHONE
    } else {
        SHORTEST_WITHOUT_ZERO
    };
    (length > 1 && digits >= fewest).then_some(length)
}

/// A number before a measure is a quantity: `5 kg`, `6点`. An ordinal is not.
fn measured(number: Number, tokens: &[Token], vocabulary: Vocabulary<'_>) -> Number {
    let follows = tokens.get(number.length..).unwrap_or_default();
    let is_ordinal = matches!(number.lex, Lex::Number { ordinal: true, .. });
    let is_measured = !is_ordinal && vocabulary.begins_with(follows, Class::Measure);
    if is_measured {
        Number::quantity(number.length)
    } else {
        number
    }
}

/// `B8`, `U3`: the letter behind digits begins the next level, as in `B8U3`.
fn is_letter_level(tokens: &[Token]) -> bool {
    let mut letters = words_of(Class::BuildingLetter).chain(words_of(Class::UnitLetter));
    letters.any(|letter| letter == tokens[0].text) && glued(tokens, 1, Kind::Digits).is_some()
}

fn is_ordinal_ending(text: &str, vocabulary: Vocabulary<'_>) -> bool {
    let mut endings = vocabulary
        .languages()
        .flat_map(|language| language.ordinal_endings);
    endings.any(|ending| condensed(ending) == text)
}

/// `A3`: a capital with a number glued to it, except the letters that stand for levels.
fn lettered(tokens: &[Token]) -> Option<Number> {
    let letter = tokens.first()?;
    let number = glued(tokens, 1, Kind::Digits)?;
    let is_single = letter.capital && letter.text.chars().count() == 1 && !is_letter_level(tokens);
    if !is_single || number.text.len() > MOST_DIGITS {
        return None;
    }
    let label = format!("{}{}", letter.text, number.text);
    Some(Number {
        length: 2,
        lex: Lex::Number {
            label,
            ordinal: false,
        },
    })
}

/// `three`, `twenty-first`, `one hundred and five`.
fn spelt(tokens: &[Token], vocabulary: Vocabulary<'_>) -> Option<Number> {
    let first = vocabulary.longest(tokens)?;
    let (mut total, mut ordinal) = spelt_value(first.meaning)?;
    let mut used = first.length;
    // An ordinal ends its number: `twenty-first`, but never `first twenty`.
    while !ordinal && used < tokens.len() {
        let joint = joint(&tokens[used], first.language, total);
        let rest = &tokens[(used + joint).min(tokens.len())..];
        let Some(next) = vocabulary.longest(rest) else {
            break;
        };
        let Some((value, is_last)) = spelt_value(next.meaning) else {
            break;
        };
        let Some(sum) = joined(total, value, joint > 0) else {
            break;
        };
        total = sum;
        ordinal = is_last;
        used += joint + next.length;
    }
    Some(Number {
        length: used,
        lex: Lex::Number {
            label: total.to_string(),
            ordinal,
        },
    })
}

/// The value of a word for a number, and whether it is an ordinal.
fn spelt_value(meaning: Meaning) -> Option<(u32, bool)> {
    match meaning {
        Meaning::Cardinal(value) => Some((value, false)),
        Meaning::Ordinal(value) => Some((value, true)),
        Meaning::Word(_) => None,
    }
}

/// How many tokens, 0 or 1, join a number of a language to what follows: a hyphen, or a word such
/// as `y` behind tens and `and` behind hundreds.
fn joint(token: &Token, language: usize, total: u32) -> usize {
    let text = token.text.as_str();
    let language = LANGUAGES[language];
    let is_hundreds = total >= 100 && total.is_multiple_of(100);
    // From 20 on, where tens take units: `one-two` is no number.
    let hyphen = text == marks::HYPHEN && token.glued && total >= 20;
    let word = language.joints.contains(&text) && total >= 20;
    let hundreds = language.hundred_joints.contains(&text) && is_hundreds;
    usize::from(hyphen || word || hundreds)
}

/// The number that `value` makes behind `total`, if the two are one number.
fn joined(total: u32, value: u32, has_joint: bool) -> Option<u32> {
    let is_multiple = value == 100 && (1..10).contains(&total) && !has_joint;
    if is_multiple {
        return Some(total * 100);
    }
    let are_tens =
        (20..100).contains(&total) && total.is_multiple_of(10) && (1..10).contains(&value);
    // `soixante-douze`
    let are_vigesimal = matches!(total, 60 | 80) && (10..20).contains(&value) && has_joint;
    let are_hundreds = total >= 100 && total.is_multiple_of(100) && (1..100).contains(&value);
    (are_tens || are_vigesimal || are_hundreds).then_some(total + value)
}

/// `einundzwanzig`.
fn compound(word: &str, vocabulary: Vocabulary<'_>) -> Option<u32> {
    let (language, form) = vocabulary
        .languages()
        .find_map(|language| Some((language, language.units_first.as_ref()?)))?;
    let value = |text: &str| {
        let mut cardinals = language.cardinals.iter();
        let cardinal = cardinals
            .find(|(word, _)| condensed(word) == text)
            .map(|(_, n)| *n);
        cardinal.or((text == form.one).then_some(1))
    };
    word.match_indices(form.joint).find_map(|(at, joint)| {
        // At each joint, since a number may contain its letters: `hundert` holds `und`.
        let units = value(&word[..at]).filter(|units| *units < 10);
        let tens = value(&word[at + joint.len()..]).filter(|tens| (20..100).contains(tens));
        Some(units? + tens?)
    })
}

/// `十二`, `二十`, `三〇二`, `百零五`.
fn ideographs(tokens: &[Token], vocabulary: Vocabulary<'_>) -> Option<Number> {
    // `一个箱子` begins an item.
    let longest = vocabulary.longest(tokens);
    if longest.is_some_and(|word| word.length > 1 && matches!(word.meaning, Meaning::Word(_))) {
        return None;
    }
    let ideographs = tokens
        .iter()
        .take_while(|token| token.kind == Kind::Ideograph);
    let numerals = ideographs.map_while(|token| numeral(&token.text));
    let values: Vec<u32> = numerals.take(MOST_NUMERALS).collect();
    let number = Number::cardinal(values.len(), ideograph_value(&values)?);
    Some(measured(number, tokens, vocabulary))
}

/// The number that numerals make: digits side by side (`三〇二`), else sums of multiples.
fn ideograph_value(values: &[u32]) -> Option<u32> {
    if values.is_empty() {
        return None;
    }
    // Without a multiple among them numerals are digits in places. Bounded as digits are, so the
    // sum cannot overflow.
    if values.iter().all(|value| *value < 10) {
        let is_short = values.len() <= MOST_DIGITS;
        return is_short.then(|| values.iter().fold(0, |sum, value| sum * 10 + value));
    }
    let mut total = 0;
    let mut pending = None;
    for value in values {
        match value {
            // `十二` is 12: a multiple without a factor counts once.
            10 | 100 => total += pending.take().unwrap_or(1) * value,
            20 => total += 20,
            _ => pending = Some(*value),
        }
    }
    Some(total + pending.unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lexicon::lexer::lexemes;
    use crate::lexicon::tokens::tokenize;
    use crate::lexicon::words::Words;

    /// The labels in a text; quantities as `?`.
    fn labels(text: &str) -> String {
        let words = Words::new();
        let tokens = tokenize(text);
        let lexemes = lexemes(&tokens, &[], words.vocabulary(&tokens));
        let labels = lexemes.into_iter().filter_map(|l| match l.lex {
            Lex::Number {
                label,
                ordinal: false,
            } => Some(label),
            Lex::Number {
                label,
                ordinal: true,
            } => Some(format!("{label}.")),
            Lex::Quantity => Some("?".into()),
            _ => None,
        });
        labels.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn digits_words_and_ordinals_are_read() {
        assert_eq!(labels("building 007"), "7");
        assert_eq!(labels("building twenty-one, unit twenty"), "21 20");
        assert_eq!(labels("building one hundred and five"), "105");
        assert_eq!(labels("building two hundred"), "200");
        assert_eq!(labels("the twenty-first building, 3rd entrance"), "21. 3.");
        assert_eq!(labels("buildings twenty and one"), "20 1");
        assert_eq!(labels("unit 12A, building A3"), "12a a3");
    }

    #[test]
    fn chinese_numerals_are_read() {
        assert_eq!(labels("十二号楼"), "12");
        assert_eq!(labels("二十号楼三〇二室"), "20 302");
        assert_eq!(labels("一百零五号楼两单元"), "105 2");
        assert_eq!(labels("廿一栋"), "21");
        assert_eq!(labels("送一个包裹"), "");
    }

    #[test]
    fn other_languages_have_their_own_compounds() {
        assert_eq!(labels("das Paket in Gebäude einundzwanzig"), "21");
        assert_eq!(labels("la caja al edificio treinta y uno"), "31");
        assert_eq!(labels("le colis au bâtiment soixante-douze"), "72");
        assert_eq!(labels("le colis au bâtiment vingt et deux"), "22");
    }

    #[test]
    fn quantities_label_nothing() {
        assert_eq!(
            labels("building 3, 5 kg, 2.5kg, 18:30, 6pm, 13800138000"),
            "3 ? ? ? ? ?"
        );
        assert_eq!(labels("3号楼，5公斤，6点"), "3 ? ?");
    }
}
