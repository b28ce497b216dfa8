//! Numbers in an instruction: digits, words, ordinals, Chinese numerals; and what looks like a number but labels nothing (times,
//! decimals, measures, telephone numbers).
//!
//! Numbers above 99,999 label nothing. Word numbers reach 999.

use super::lexicon::{Class, LANGUAGES};
use super::text::{Kind, Token};
use super::words::{Languages, Lex, Meaning, Words};

/// Digits tied by dashes that are a telephone number at least.
const SHORTEST_TELEPHONE: usize = 7;
/// The same of one that does not begin with a zero.
const SHORTEST_WITHOUT_ZERO: usize = 9;

/// The number at token `at`: how many tokens it takes and what it is.
pub(crate) fn number(
    words: &Words,
    tokens: &[Token],
    at: usize,
    languages: Languages,
) -> Option<(usize, Lex)> {
    match tokens[at].kind {
        Kind::Digits => Some(digits(words, tokens, at, languages)),
        Kind::Ideograph => ideographs(words, &tokens[at..], languages),
        Kind::Letters => {
            lettered(&tokens[at..]).or_else(|| spelt(words, &tokens[at..], languages)).or_else(|| {
                let value = compound(&tokens[at].text, languages)?;
                Some((1, plain(value)))
            })
        }
        Kind::Mark => None,
    }
}

fn plain(value: u32) -> Lex {
    Lex::Number { label: value.to_string(), ordinal: false }
}

fn digits(words: &Words, tokens: &[Token], at: usize, languages: Languages) -> (usize, Lex) {
    let glued = |i: usize, kind: Kind| tokens.get(i).filter(|t| t.glued && t.kind == kind);
    if let Some(mark) = glued(at + 1, Kind::Mark).filter(|t| matches!(t.text.as_str(), "." | ":"))
        && glued(at + 2, Kind::Digits).is_some()
    {
        let longer = mark.text == ":" || glued(at + 3, Kind::Letters).is_none();
        return if longer { (3, Lex::Quantity) } else { (4, Lex::Quantity) };
    }
    if let Some(length) = telephone(tokens, at) {
        return (length, Lex::Quantity);
    }
    let text = tokens[at].text.trim_start_matches('0');
    let text = if text.is_empty() { "0" } else { text };
    let label = |suffix: &str, ordinal| Lex::Number { label: format!("{text}{suffix}"), ordinal };
    let (length, lex) = match glued(at + 1, Kind::Letters) {
        None => (1, label("", false)),
        Some(next) if is_ordinal_ending(&next.text, languages) => (2, label("", true)),
        Some(next) if next.text.chars().count() == 1 && !is_letter_level(tokens, at + 1) => {
            let measure = !next.capital && is_class(words, &tokens[at + 1..], languages, Class::Measure);
            (2, if measure { Lex::Quantity } else { label(&next.text, false) })
        }
        Some(_) if is_class(words, &tokens[at + 1..], languages, Class::Measure) => (2, Lex::Quantity),
        Some(_) => (1, label("", false)),
    };
    if text.len() > 5 { (length, Lex::Quantity) } else { measured(words, tokens, at, length, lex, languages) }
}

/// `0800-22-3344`: digits tied by dashes, more of them than an address has.
fn telephone(tokens: &[Token], at: usize) -> Option<usize> {
    let glued = |i: usize, kind: Kind| tokens.get(i).filter(|t| t.glued && t.kind == kind);
    let (mut length, mut digits) = (1, tokens[at].text.len());
    while glued(at + length, Kind::Mark).is_some_and(|t| t.text == "-")
        && let Some(next) = glued(at + length + 1, Kind::Digits)
    {
        (length, digits) = (length + 2, digits + next.text.len());
    }
    // `12-3-1502` and `1201-1204` are addresses.
    let least = if tokens[at].text.starts_with('0') { SHORTEST_TELEPHONE } else { SHORTEST_WITHOUT_ZERO };
    (length > 1 && digits >= least).then_some(length)
}

/// A number before a measure is a quantity: `5 kg`, `6点`. Not so before `door` or `unit`, which a measure never is.
fn measured(
    words: &Words,
    tokens: &[Token],
    at: usize,
    length: usize,
    lex: Lex,
    languages: Languages,
) -> (usize, Lex) {
    let follows = tokens.get(at + length..).unwrap_or_default();
    let ordinal = matches!(lex, Lex::Number { ordinal: true, .. });
    let measure = !ordinal && is_class(words, follows, languages, Class::Measure);
    if measure { (length, Lex::Quantity) } else { (length, lex) }
}

/// `B8`, `U3`: the letter after digits begins the next level, as in `B8U3`.
fn is_letter_level(tokens: &[Token], at: usize) -> bool {
    matches!(tokens[at].text.as_str(), "b" | "u")
        && tokens.get(at + 1).is_some_and(|t| t.glued && t.kind == Kind::Digits)
}

fn is_ordinal_ending(text: &str, languages: Languages) -> bool {
    let active = LANGUAGES.iter().enumerate().filter(|(i, _)| languages & (1 << i) != 0);
    active.flat_map(|(_, l)| l.ordinal_endings).any(|ending| super::text::condensed(ending) == text)
}

fn is_class(words: &Words, tokens: &[Token], languages: Languages, class: Class) -> bool {
    words.longest(tokens, languages).is_some_and(|(_, meaning, _)| meaning == Meaning::Word(class))
}

/// `A3`: a capital with a number glued to it, except the letters that stand for levels.
fn lettered(tokens: &[Token]) -> Option<(usize, Lex)> {
    let (letter, number) = (tokens.first()?, tokens.get(1)?);
    let single = letter.capital && letter.text.chars().count() == 1 && !is_letter_level(tokens, 0);
    if !single || !number.glued || number.kind != Kind::Digits || number.text.len() > 5 {
        return None;
    }
    Some((2, Lex::Number { label: format!("{}{}", letter.text, number.text), ordinal: false }))
}

/// `three`, `twenty-first`, `one hundred and five`.
fn spelt(words: &Words, tokens: &[Token], languages: Languages) -> Option<(usize, Lex)> {
    let (mut used, mut total, mut ordinal, language) = match words.longest(tokens, languages)? {
        (length, Meaning::Cardinal(value), language) => (length, value, false, language),
        (length, Meaning::Ordinal(value), language) => (length, value, true, language),
        _ => return None,
    };
    while !ordinal && used < tokens.len() {
        let joint = joint(tokens, used, language, total);
        let Some((length, meaning, _)) =
            words.longest(&tokens[(used + joint).min(tokens.len())..], languages)
        else {
            break;
        };
        let (value, last) = match meaning {
            Meaning::Cardinal(value) => (value, false),
            Meaning::Ordinal(value) => (value, true),
            Meaning::Word(_) => break,
        };
        let Some(sum) = joined(total, value, joint > 0) else { break };
        (total, used, ordinal) = (sum, used + joint + length, last);
    }
    Some((used, Lex::Number { label: total.to_string(), ordinal }))
}

/// How many tokens join tens and units at `at`: a hyphen, or a word such as `y`; `and` only after hundreds.
fn joint(tokens: &[Token], at: usize, language: usize, total: u32) -> usize {
    let text = tokens[at].text.as_str();
    let hyphen = text == "-" && tokens[at].glued && total >= 20;
    let word = LANGUAGES[language].joints.contains(&text) && total >= 20;
    let hundreds = text == "and" && total >= 100 && total.is_multiple_of(100);
    usize::from(hyphen || word || hundreds)
}

fn joined(total: u32, value: u32, joint: bool) -> Option<u32> {
    let tens = (20..100).contains(&total) && total.is_multiple_of(10) && (1..10).contains(&value);
    // `soixante-douze`
    let vigesimal = matches!(total, 60 | 80) && (10..20).contains(&value) && joint;
    let hundreds = total >= 100 && total.is_multiple_of(100) && (1..100).contains(&value);
    let multiple = value == 100 && (1..10).contains(&total) && !joint;
    if multiple { Some(total * 100) } else { (tens || vigesimal || hundreds).then_some(total + value) }
}

/// `einundzwanzig`.
fn compound(word: &str, languages: Languages) -> Option<u32> {
    let (_, lexicon) =
        LANGUAGES.iter().enumerate().find(|(i, l)| languages & (1 << i) != 0 && l.units_first.is_some())?;
    let joint = lexicon.units_first?;
    let value = |text: &str| {
        let found = lexicon.cardinals.iter().find(|(word, _)| super::text::condensed(word) == text);
        found.map(|(_, n)| *n).or((text == "ein").then_some(1))
    };
    let splits = word
        .match_indices(joint)
        .filter_map(|(i, _)| Some((value(&word[..i])?, value(&word[i + joint.len()..])?)));
    let mut sums = splits.filter(|(units, tens)| *units < 10 && *tens >= 20 && *tens < 100);
    sums.next().map(|(units, tens)| units + tens)
}

/// `十二`, `二十`, `三〇二`, `百零五`.
fn ideographs(words: &Words, tokens: &[Token], languages: Languages) -> Option<(usize, Lex)> {
    // `一个箱子` begins an item.
    if let Some((length, Meaning::Word(_), _)) = words.longest(tokens, languages)
        && length > 1
    {
        return None;
    }
    let run = tokens.iter().take_while(|t| t.kind == Kind::Ideograph && numeral(&t.text).is_some()).count();
    let run = run.min(9);
    let values: Vec<u32> = tokens[..run].iter().filter_map(|t| numeral(&t.text)).collect();
    let value = ideograph_value(&values)?;
    let lex = plain(value);
    Some(measured(words, tokens, 0, run, lex, languages))
}

pub(super) fn numeral(text: &str) -> Option<u32> {
    Some(match text {
        "零" | "〇" => 0,
        "一" => 1,
        "二" | "两" => 2,
        "三" => 3,
        "四" => 4,
        "五" => 5,
        "六" => 6,
        "七" => 7,
        "八" => 8,
        "九" => 9,
        "十" => 10,
        "廿" => 20,
        "百" => 100,
        _ => return None,
    })
}

fn ideograph_value(values: &[u32]) -> Option<u32> {
    if values.is_empty() {
        return None;
    }
    if values.iter().all(|v| *v < 10) {
        return (values.len() <= 5).then(|| values.iter().fold(0, |sum, v| sum * 10 + v));
    }
    let (mut total, mut pending) = (0, None);
    for value in values {
        match value {
            10 | 100 => total += pending.take().unwrap_or(1) * value,
            20 => total += 20,
            _ => pending = Some(*value),
        }
    }
    Some(total + pending.unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::super::text::tokenize;
    use super::*;

    /// The labels in a text; quantities as `?`.
    fn labels(text: &str) -> String {
        let words = Words::new();
        let tokens = tokenize(text);
        let languages = words.languages(&tokens);
        let labels = words.lexemes(&tokens, &[], languages).into_iter().filter_map(|l| match l.lex {
            Lex::Number { label, ordinal: false } => Some(label),
            Lex::Number { label, ordinal: true } => Some(format!("{label}.")),
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
        assert_eq!(labels("building 3, 5 kg, 2.5kg, 18:30, 6pm, 13800138000"), "3 ? ? ? ? ?");
        assert_eq!(labels("3号楼，5公斤，6点"), "3 ? ?");
    }
}
