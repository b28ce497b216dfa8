//! Which buildings and units an instruction mentions: words for levels with the numbers that belong to them, lists and ranges
//! of those, the map's own names.
//!
//! Numbers without a word for a level are no address, except after `#` and, in [`super::fallback`], where nothing else is there.

use std::ops::Range;

use super::lexicon::Class;
use super::text::{Kind, Token};
use super::words::{Lex, Lexeme};

/// A level of the address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Level {
    Building,
    Unit,
    /// Below the unit; stands for it where no unit is named.
    Room,
}

/// What is named at a level.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Target {
    /// A number or letter, folded, and the words that it stands with: `3` and `Tower 3`.
    Label { label: String, said: String },
    /// A name on the map: index into the names found in the text.
    Name(usize),
    /// Words that the map does not have.
    Words(String),
}

/// A place that is named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Mention {
    pub level: Level,
    /// One or more: `units 1 and 2`.
    pub targets: Vec<Target>,
    /// The lexemes that it takes.
    pub at: Range<usize>,
    /// Whether it counts only where no other building is named.
    pub weak: bool,
}

/// No list or range names more places than this.
const LONGEST_LIST: usize = 50;

/// What is read: the instruction, its tokens and its lexemes.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'a> {
    pub text: &'a str,
    pub tokens: &'a [Token],
    pub lexemes: &'a [Lexeme],
}

impl Reading<'_> {
    pub(crate) fn lex(&self, at: usize) -> Option<&Lex> {
        self.lexemes.get(at).map(|l| &l.lex)
    }

    pub(crate) fn class(&self, at: usize) -> Option<Class> {
        match self.lex(at)? {
            Lex::Word(class, _) => Some(*class),
            _ => None,
        }
    }

    /// The words of some lexemes as they were written.
    pub(crate) fn words(&self, at: Range<usize>) -> &str {
        let first = self.lexemes.get(at.start).and_then(|l| self.tokens.get(l.tokens.start));
        let last = self.lexemes.get(at.end.saturating_sub(1)).and_then(|l| self.tokens.get(l.tokens.end - 1));
        first.zip(last).and_then(|(a, b)| self.text.get(a.span.start..b.span.end)).unwrap_or_default()
    }

    pub(crate) fn token(&self, at: usize) -> Option<&Token> {
        self.tokens.get(self.lexemes.get(at)?.tokens.start)
    }

    fn is_plural(&self, at: usize) -> bool {
        self.token(at).is_some_and(|t| t.text.len() > 3 && t.text.ends_with('s'))
    }

    /// The label at a place: a number, or a single capital.
    fn label(&self, at: usize) -> Option<&str> {
        match self.lex(at)? {
            Lex::Number { label, .. } => Some(label),
            Lex::Word(..) | Lex::Unknown => {
                let token = self.token(at)?;
                (token.capital && token.text.chars().count() == 1).then_some(token.text.as_str())
            }
            _ => None,
        }
    }

    fn is_ordinal(&self, at: usize) -> bool {
        matches!(self.lex(at), Some(Lex::Number { ordinal: true, .. }))
    }

    /// Whether the number at `at` may continue a list: nothing that is counted follows, and no level of its own.
    fn continues_list(&self, at: usize) -> bool {
        let number =
            matches!(self.lex(at), Some(Lex::Number { ordinal: false, .. })) || self.label(at).is_some();
        // `building 4 and one for building 5`
        let spelt = self.token(at).is_some_and(|t| t.kind == Kind::Letters && t.text.chars().count() > 1);
        let is_pronoun = spelt
            && self.label(at) == Some("1")
            && matches!(self.class(at + 1), Some(Class::Toward | Class::TowardOrAfter));
        let number = number && !is_pronoun;
        let alone = match self.lex(at + 1) {
            None | Some(Lex::Stop | Lex::Comma | Lex::Dash | Lex::Mark) => true,
            Some(Lex::Word(class, _)) => !matches!(
                class,
                Class::Building
                    | Class::WeakBuilding
                    | Class::Unit
                    | Class::Room
                    | Class::Floor
                    | Class::Item
                    | Class::Measure
            ),
            _ => false,
        };
        number && alone
    }
}

/// All mentions, in the order of the text.
pub(crate) fn mentions(reading: &Reading<'_>) -> Vec<Mention> {
    let mut found: Vec<Mention> = Vec::new();
    for at in 0..reading.lexemes.len() {
        let taken = found.last().map_or(0, |m| m.at.end);
        let Some(mention) = mention(reading, at, taken, found.last()) else { continue };
        // `3号、5号楼`: the list takes what seemed to be a place of its own.
        while found.last().is_some_and(|last| last.at.end > mention.at.start) {
            found.pop();
        }
        let compact = compact_unit(reading, &mention);
        found.push(mention);
        found.extend(compact);
    }
    join_ranges(reading, &mut found);
    found
}

/// `2号室から4号室まで`, where something is for each of them: else it is a way from one to the other.
fn join_ranges(reading: &Reading<'_>, found: &mut Vec<Mention>) {
    let is_each = |at: usize| matches!(reading.class(at), Some(Class::Each | Class::Respectively));
    if !(0..reading.lexemes.len()).any(is_each) {
        return;
    }
    let mut i = 1;
    while i < found.len() {
        if let Some(targets) = range_between(reading, &found[i - 1], &found[i]) {
            let second = found.remove(i);
            found[i - 1].targets = targets;
            found[i - 1].at.end = second.at.end + 1;
        } else {
            i += 1;
        }
    }
}

fn range_between(reading: &Reading<'_>, a: &Mention, b: &Mention) -> Option<Vec<Target>> {
    let from = reading.class(a.at.end) == Some(Class::NotBefore) && a.at.end + 1 == b.at.start;
    let to = reading.class(b.at.end) == Some(Class::Toward);
    let ([Target::Label { label: first, .. }], [Target::Label { label: last, said }]) =
        (&a.targets[..], &b.targets[..])
    else {
        return None;
    };
    let is_range = from && to && a.level == b.level && a.level != Level::Building;
    let numbers = is_range.then(|| span(first, last)).flatten()?;
    Some(numbers.into_iter().map(|label| Target::Label { label, said: said.clone() }).collect())
}

fn mention(reading: &Reading<'_>, at: usize, taken: usize, last: Option<&Mention>) -> Option<Mention> {
    if at < taken {
        return None;
    }
    match reading.lex(at)? {
        Lex::Name(i) => {
            let targets = vec![Target::Name(*i)];
            Some(Mention { level: Level::Building, targets, at: at..at + 1, weak: false })
        }
        Lex::Word(Class::BuildingLetter, _) => lettered(reading, at, Level::Building),
        Lex::Word(Class::UnitLetter, _) => lettered(reading, at, Level::Unit),
        Lex::Word(Class::Sign, _) => signed(reading, at, last),
        Lex::Word(class, number_first) => levelled(reading, at, level(*class)?, *number_first, taken),
        _ => None,
    }
}

fn level(class: Class) -> Option<Level> {
    match class {
        Class::Building | Class::WeakBuilding => Some(Level::Building),
        Class::Unit => Some(Level::Unit),
        Class::Room => Some(Level::Room),
        _ => None,
    }
}

/// `B8`: only with the number glued to the letter.
fn lettered(reading: &Reading<'_>, at: usize, level: Level) -> Option<Mention> {
    let token = reading.token(at + 1).filter(|t| t.glued)?;
    let Some(Lex::Number { label, ordinal: false }) = reading.lex(at + 1) else { return None };
    let said = format!("{}{}", reading.words(at..at + 1), token.text);
    let targets = vec![Target::Label { label: label.clone(), said }];
    Some(Mention { level, targets, at: at..at + 2, weak: false })
}

/// `#12` is a building, or a unit where it follows a building; `3#` is a building.
fn signed(reading: &Reading<'_>, at: usize, last: Option<&Mention>) -> Option<Mention> {
    let hash = reading.token(at).is_some_and(|t| t.text == "#");
    let named = at > 0
        && matches!(reading.lex(at - 1), Some(Lex::Unknown | Lex::Word(Class::Reference | Class::Item, _)));
    if !hash || named {
        return None;
    }
    let after_building = last.is_some_and(|m| {
        let gap = m.at.end..at;
        m.level == Level::Building
            && gap.clone().all(|i| matches!(reading.lex(i), Some(Lex::Comma | Lex::Dash)))
    });
    let level = if after_building { Level::Unit } else { Level::Building };
    let range = if reading.label(at + 1).is_some() {
        at..at + 2
    } else {
        at.checked_sub(1).filter(|i| matches!(reading.lex(*i), Some(Lex::Number { .. })))?..at + 1
    };
    let number = if range.start == at { at + 1 } else { range.start };
    let targets = vec![target(reading, number, range.clone())?];
    Some(Mention { level, targets, at: range, weak: level == Level::Building })
}

fn target(reading: &Reading<'_>, number: usize, said: Range<usize>) -> Option<Target> {
    let label = reading.label(number)?.to_owned();
    Some(Target::Label { label, said: reading.words(said).to_owned() })
}

fn levelled(
    reading: &Reading<'_>,
    at: usize,
    level: Level,
    number_first: bool,
    taken: usize,
) -> Option<Mention> {
    let weak = reading.class(at) == Some(Class::WeakBuilding);
    let before =
        || numbers_before(reading, at, number_first, taken).map(|(numbers, start)| (numbers, start..at + 1));
    let after = || numbers_after(reading, at).map(|(numbers, end)| (numbers, at..end));
    let (numbers, range) = if weak {
        before()
    } else if number_first {
        before().or_else(after)
    } else {
        after().or_else(before)
    }?;
    let single = numbers.len() == 1;
    let said = |number: &String| {
        if single {
            reading.words(range.clone()).to_owned()
        } else {
            format!("{} {number}", reading.words(at..at + 1))
        }
    };
    let targets = numbers.iter().map(|n| Target::Label { label: n.clone(), said: said(n) }).collect();
    Some(Mention { level, targets, at: range, weak })
}

/// The numbers after a level and where they end: `building no. 3`, `units 1, 2 and 4`, `units 1 to 3`.
fn numbers_after(reading: &Reading<'_>, level: usize) -> Option<(Vec<String>, usize)> {
    let mut at = level + 1;
    // `the unit is number 2`
    if reading.class(at) == Some(Class::Verb) && reading.class(at + 1) == Some(Class::Sign) {
        at += 1;
    }
    let plural = reading.is_plural(level);
    // `unidades de la 2 a la 4`
    let is_passed =
        |class: Class| class == Class::Sign || plural && matches!(class, Class::Link | Class::Article);
    while reading.class(at).is_some_and(is_passed)
        || reading.lex(at) == Some(&Lex::Dash)
        || is_colon(reading, at)
    {
        at += 1;
    }
    let first = reading.label(at)?.to_owned();
    if reading.is_ordinal(at) {
        return None;
    }
    let (mut numbers, mut end) = (vec![first], at + 1);
    if let Some((last, end)) = range_end(reading, end, plural) {
        return Some((span(&numbers[0], &last)?, end));
    }
    // Commas alone make a list only after a plural; else the list must close with `and`.
    let (mut pending, mut next) = (Vec::new(), end);
    while let Some((number, joined)) = list_separator(reading, next) {
        // `buildings 4 and 2 want milk`: after a plural what follows may be any word.
        let before_a_word = plural
            && reading.lex(number + 1) == Some(&Lex::Unknown)
            && matches!(reading.lex(number), Some(Lex::Number { ordinal: false, .. }));
        let is_listed = reading.continues_list(number) || before_a_word;
        if !is_listed || numbers.len() + pending.len() >= LONGEST_LIST {
            break;
        }
        pending.extend(reading.label(number).map(str::to_owned));
        next = number + 1;
        if joined || plural {
            numbers.append(&mut pending);
            end = next;
        }
    }
    Some((numbers, end))
}

fn is_colon(reading: &Reading<'_>, at: usize) -> bool {
    reading.lex(at) == Some(&Lex::Mark) && reading.token(at).is_some_and(|t| t.text == ":")
}

/// Past a comma, `and`, or both: where the next number should be, and whether there was an `and`.
fn list_separator(reading: &Reading<'_>, mut at: usize) -> Option<(usize, bool)> {
    let start = at;
    if reading.lex(at) == Some(&Lex::Comma) {
        at += 1;
    }
    let joined = reading.class(at) == Some(Class::And);
    at += usize::from(joined);
    (at > start).then_some((at, joined))
}

/// The end of a range and where it stands: `units 1 to 3`, `Eingang 1 bis 3`.
fn range_end(reading: &Reading<'_>, at: usize, plural: bool) -> Option<(String, usize)> {
    let loose = reading.lex(at) == Some(&Lex::Dash) || reading.class(at) == Some(Class::Toward);
    let tied = reading.class(at) == Some(Class::Range) || plural && loose;
    let last = at + 1 + usize::from(reading.class(at + 1) == Some(Class::Article));
    let label = (tied && reading.continues_list(last)).then(|| reading.label(last)).flatten()?;
    Some((label.to_owned(), last + 1))
}

fn span(first: &str, last: &str) -> Option<Vec<String>> {
    let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
    let short = first < last && last - first < LONGEST_LIST;
    short.then(|| (first..=last).map(|n| n.to_string()).collect())
}

/// The numbers before a level and where they begin: `the first and second unit`, `No. 3 building`, `1、2单元`, `1到3单元`.
fn numbers_before(
    reading: &Reading<'_>,
    level: usize,
    number_first: bool,
    taken: usize,
) -> Option<(Vec<String>, usize)> {
    let mut at = level.checked_sub(1).filter(|at| *at >= taken)?;
    if reading.lex(at) == Some(&Lex::Dash) && number_first {
        at = at.checked_sub(1)?;
    }
    let first = reading.label(at)?.to_owned();
    let signed = at > taken && reading.class(at - 1) == Some(Class::Sign);
    if !(number_first || signed || reading.is_ordinal(at)) {
        return None;
    }
    if number_first && let Some((numbers, start)) = range_before(reading, at, taken) {
        return Some((numbers, start));
    }
    let mut numbers = vec![first];
    let mut start = at - usize::from(signed);
    while let Some(number) = listed_before(reading, start, number_first, taken) {
        numbers.extend(reading.label(number).map(str::to_owned));
        start = number;
        if numbers.len() >= LONGEST_LIST {
            break;
        }
    }
    numbers.reverse();
    Some((numbers, start))
}

fn range_before(reading: &Reading<'_>, at: usize, taken: usize) -> Option<(Vec<String>, usize)> {
    let start = at.checked_sub(2).filter(|start| *start >= taken)?;
    let tied = reading.lex(at - 1) == Some(&Lex::Dash)
        || matches!(reading.class(at - 1), Some(Class::Range | Class::Toward));
    tied.then(|| span(reading.label(start)?, reading.label(at)?)).flatten().map(|numbers| (numbers, start))
}

/// The number that `…, ` or `… and ` puts before the one at `at` in a list.
fn listed_before(reading: &Reading<'_>, at: usize, number_first: bool, taken: usize) -> Option<usize> {
    let mut i = at.checked_sub(1)?;
    if reading.class(i) == Some(Class::Article) {
        i = i.checked_sub(1)?;
    }
    let joined = reading.class(i) == Some(Class::And);
    if !joined && (number_first || reading.lex(i) != Some(&Lex::Comma)) {
        return None;
    }
    i = i.checked_sub(1)?;
    // `3号、5号楼`
    let floor = if number_first && reading.class(i) == Some(Class::WeakBuilding) {
        i = i.checked_sub(1)?;
        0
    } else {
        taken
    };
    let number =
        matches!(reading.lex(i), Some(Lex::Number { .. })) && (number_first || reading.is_ordinal(i));
    (number && i >= floor).then_some(i)
}

/// `building 3-2`: the second number is the unit.
fn compact_unit(reading: &Reading<'_>, building: &Mention) -> Option<Mention> {
    let end = building.at.end;
    let glued = |at: usize| reading.token(at).is_some_and(|t| t.glued);
    let single = building.level == Level::Building && building.targets.len() == 1;
    if !single
        || reading.lex(end) != Some(&Lex::Dash)
        || !glued(end)
        || !glued(end + 1)
        || !reading.continues_list(end + 1)
    {
        return None;
    }
    let targets = vec![target(reading, end + 1, end + 1..end + 2)?];
    Some(Mention { level: Level::Unit, targets, at: end..end + 2, weak: false })
}

#[cfg(test)]
mod tests {
    use super::super::text::tokenize;
    use super::super::words::Words;
    use super::*;

    /// Mentions as `b3`, `u1+2`, `r502`, weak ones with `?`.
    fn read(text: &str) -> String {
        let words = Words::new();
        let tokens = tokenize(text);
        let lexemes = words.lexemes(&tokens, &[], words.languages(&tokens));
        let found = mentions(&Reading { text, tokens: &tokens, lexemes: &lexemes });
        let show = |m: &Mention| {
            let level = match m.level {
                Level::Building => "b",
                Level::Unit => "u",
                Level::Room => "r",
            };
            let labels: Vec<&str> = m
                .targets
                .iter()
                .filter_map(|t| if let Target::Label { label, .. } = t { Some(label.as_str()) } else { None })
                .collect();
            format!("{level}{}{}", labels.join("+"), if m.weak { "?" } else { "" })
        };
        found.iter().map(show).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn numbers_belong_to_the_level_beside_them() {
        assert_eq!(read("unit1, building3"), "u1 b3");
        assert_eq!(read("bldg. #4, No. 7 building, building number nine"), "b4 b7 b9");
        assert_eq!(read("the second unit in building six"), "u2 b6");
        assert_eq!(read("B8-U3 and b2u1"), "b8 u3 b2 u1");
        assert_eq!(read("Tower B, unit 12A"), "bb u12a");
        assert_eq!(read("three buildings, two units, 5 kg"), "");
        assert_eq!(read("building 3-2"), "b3 u2");
        assert_eq!(read("to #12, building 5 #2, order #99"), "b12? b5 u2");
    }

    #[test]
    fn lists_and_ranges_are_one_mention() {
        assert_eq!(read("buildings 2, 3 and 5"), "b2+3+5");
        assert_eq!(read("building 2, 3 and 5"), "b2+3+5");
        assert_eq!(read("units 1 and 2 of building 3"), "u1+2 b3");
        assert_eq!(read("the first and second units of building 3"), "u1+2 b3");
        assert_eq!(read("units 2 to 4"), "u2+3+4");
        assert_eq!(read("building 3, 2 boxes"), "b3");
        assert_eq!(read("building 3 and 2 parcels for building 4"), "b3 b4");
        assert_eq!(read("unit 1, 5 kg"), "u1");
    }

    #[test]
    fn chinese_puts_the_number_first() {
        assert_eq!(read("3号楼1单元502室"), "b3 u1 r502");
        assert_eq!(read("12栋4单元"), "b12 u4");
        assert_eq!(read("五号楼第二单元"), "b5 u2");
        assert_eq!(read("3号、5号楼的1、2单元"), "b3+5 u1+2");
        assert_eq!(read("2号楼1到3单元"), "b2 u1+2+3");
        assert_eq!(read("A座2单元"), "ba u2");
        assert_eq!(read("3#楼, 5楼"), "b3 b5?");
        assert_eq!(read("3号棟の2号室に"), "b3 r2");
    }
}
