//! Which buildings and units an instruction mentions: words for levels with the numbers that belong to them, lists and ranges
//! of those, the map's own names.
//!
//! Numbers without a word for a level are no address, except after `#` and, in [`super::fallback`], where nothing else is there.

use std::ops::Range;

use super::lexicon::{Class, LANGUAGES};
use super::numbers;
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
    /// All units of the building but those with these labels.
    All {
        but: Vec<String>,
        /// How many there are, where only their number says that all are meant: `the four units`.
        count: Option<usize>,
        /// What is left of the labels divided by two, where only those are meant: `even units`.
        parity: Option<usize>,
    },
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
/// So many words at most stand between a word for all and that for the level: `each of the four units`.
const MOST_BEFORE_ALL: usize = 4;

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
        let mut endings = LANGUAGES.iter().flat_map(|lexicon| lexicon.plural_endings);
        self.token(at).is_some_and(|t| t.text.len() > 3 && endings.any(|ending| t.text.ends_with(ending)))
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

    /// The number in `第二个`, which is one word where it stands before things.
    pub(crate) fn ordinal_determiner(&self, at: usize) -> Option<u32> {
        let lexeme = self.lexemes.get(at).filter(|lexeme| lexeme.is(Class::Determiner))?;
        let [first, number, ..] = self.tokens.get(lexeme.tokens.clone())? else { return None };
        (first.text == "第").then(|| numbers::numeral(&number.text)).flatten()
    }

    pub(crate) fn is_ordinal(&self, at: usize) -> bool {
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

/// `2号室から4号室まで`, `von Gebäude 4 bis Gebäude 7`, where something is for each of them: else it is a way from one to the other.
fn join_ranges(reading: &Reading<'_>, found: &mut Vec<Mention>) {
    let is_each = |at: usize| {
        matches!(reading.class(at), Some(Class::Each | Class::Respectively | Class::All | Class::AllUnits))
    };
    let is_for_each = (0..reading.lexemes.len()).any(is_each);
    let mut i = 1;
    while i < found.len() {
        // `2号棟から4号棟までのユニット1`
        let is_linked = reading.class(found[i].at.end + 1) == Some(Class::Link)
            && reading.class(found[i - 1].at.end) == Some(Class::NotBefore);
        let is_behind_building = found[i].level != Level::Building
            && reading.class(found[i - 1].at.end) == Some(Class::NotBefore)
            && found[i].at.start == found[i - 1].at.end + 1;
        let range = || range_between(reading, &found[i - 1], &found[i]);
        if let Some(targets) = (is_for_each || is_linked || is_behind_building).then(range).flatten() {
            let second = found.remove(i);
            let is_behind = reading.class(second.at.end) == Some(Class::Toward);
            let is_headed = found[i - 1].at.start > 0
                && reading.class(found[i - 1].at.end) != Some(Class::NotBefore)
                && is_from(reading, found[i - 1].at.start - 1);
            found[i - 1].targets = targets;
            found[i - 1].at.start -= usize::from(is_headed);
            found[i - 1].at.end = second.at.end + usize::from(is_behind);
        } else {
            i += 1;
        }
    }
}

fn range_between(reading: &Reading<'_>, a: &Mention, b: &Mention) -> Option<Vec<Target>> {
    let from = reading.class(a.at.end) == Some(Class::NotBefore) && a.at.end + 1 == b.at.start;
    let to = reading.class(b.at.end) == Some(Class::Toward);
    let is_between = |at: usize| {
        let class = reading.class(at);
        matches!(class, Some(Class::Range | Class::Toward | Class::Article | Class::Link | Class::Filler))
    };
    let is_to = |at: usize| matches!(reading.class(at), Some(Class::Range | Class::Toward));
    let mut gap = a.at.end..b.at.start;
    let is_tied = gap.clone().any(is_to) && gap.all(is_between);
    // `3号楼到6号楼`
    let is_headed = b.at.start == a.at.end + 1 || a.at.start > 0 && is_from(reading, a.at.start - 1);
    let ([Target::Label { label: first, .. }], [Target::Label { label: last, said }]) =
        (&a.targets[..], &b.targets[..])
    else {
        return None;
    };
    let is_range = a.level == b.level && (from && to || is_headed && is_tied);
    let numbers = is_range.then(|| span(first, last)).flatten()?;
    Some(numbers.into_iter().map(|label| Target::Label { label, said: said.clone() }).collect())
}

/// `from`, `von`
fn is_from(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.class(at), Some(Class::Elsewhere | Class::Link))
}

fn mention(reading: &Reading<'_>, at: usize, taken: usize, last: Option<&Mention>) -> Option<Mention> {
    if at < taken {
        return None;
    }
    match reading.lex(at)? {
        // `Frau Rosenhof`
        Lex::Name(_) if at > 0 && reading.class(at - 1) == Some(Class::Title) => None,
        Lex::Name(i) => {
            let targets = vec![Target::Name(*i)];
            Some(Mention { level: Level::Building, targets, at: at..at + 1, weak: false })
        }
        Lex::Word(Class::BuildingLetter, _) => lettered(reading, at, Level::Building),
        Lex::Word(Class::UnitLetter, _) => {
            lettered(reading, at, Level::Unit).or_else(|| spaced_unit(reading, at, last))
        }
        Lex::Word(Class::AllUnits, _) => Some(all_of(Level::Unit, at..at + 1, None)),
        Lex::Word(Class::Sign, _) => signed(reading, at, last),
        Lex::Word(class, number_first) => {
            let level = level(*class)?;
            if is_described(reading, at) {
                return None;
            }
            let numbered = || levelled(reading, at, level, *number_first, taken);
            let numbered =
                if level != Level::Building && is_counted(reading, at) { None } else { numbered() };
            numbered.or_else(|| all_units(reading, at, level, taken))
        }
        _ => None,
    }
}

/// `一共有四个单元`, `12棟あります`: how many there are, not which.
fn is_described(reading: &Reading<'_>, at: usize) -> bool {
    let text = |at: usize| reading.token(at).map_or("", |token| token.text.as_str());
    let is_number = |at: usize| matches!(reading.lex(at), Some(Lex::Number { ordinal: false, .. }));
    if at == 0 || !is_number(at - 1) {
        return false;
    }
    let is_told_behind = text(at + 1) == "あ" && text(at + 2) == "り";
    let is_counter = text(at) == "个" || matches!(reading.words(at..at + 1), "栋楼" | "幢楼" | "座楼");
    let is_told_before = at > 1 && matches!(text(at - 2), "有" | "共" | "每");
    is_told_behind || is_counter && is_told_before
}

/// `四个单元`, `全四室`: so many units, but `第四个单元` is one.
fn is_counted(reading: &Reading<'_>, at: usize) -> bool {
    let is_counter = reading.token(at).is_some_and(|token| token.text == "个");
    let is_number = |at: usize| matches!(reading.lex(at), Some(Lex::Number { ordinal: false, .. }));
    let before = at.checked_sub(2).and_then(|at| reading.class(at));
    at > 0 && is_number(at - 1) && (before == Some(Class::All) || is_counter && before != Some(Class::Sign))
}

fn all_of(level: Level, at: Range<usize>, count: Option<usize>) -> Mention {
    let all = Target::All { but: Vec::new(), count, parity: None };
    Mention { level, targets: vec![all], at, weak: false }
}

/// `all four units`, `each of the entrances`
fn all_units(reading: &Reading<'_>, at: usize, level: Level, taken: usize) -> Option<Mention> {
    // `all units of insulin`
    let is_of_a_thing = reading.class(at + 1) == Some(Class::Link)
        && matches!(reading.lex(at + 2), Some(Lex::Unknown | Lex::Word(Class::Item, _)));
    if level == Level::Building || is_of_a_thing {
        return None;
    }
    let is_passed = |at: &usize| {
        matches!(
            reading.lex(*at),
            Some(Lex::Number { ordinal: false, .. } | Lex::Word(Class::Article | Class::Link, _))
        )
    };
    if let Some((parity, range)) = every_second(reading, at, taken) {
        let some = Target::All { but: Vec::new(), count: None, parity: Some(parity) };
        return Some(Mention { level, targets: vec![some], at: range, weak: false });
    }
    // `入口ぜんぶ`
    if matches!(reading.lex(at + 1), Some(Lex::Word(Class::All, true))) {
        return Some(all_of(level, at..at + 2, None));
    }
    let before = (taken..at).rev().take(MOST_BEFORE_ALL).find(|at| !is_passed(at));
    if let Some(before) = before
        && matches!(reading.class(before), Some(Class::All | Class::Each))
    {
        return Some(all_of(level, before..at + 1, None));
    }
    counted_units(reading, at, level, taken)
}

/// `the even units`, `les entrées paires`
fn every_second(reading: &Reading<'_>, at: usize, taken: usize) -> Option<(usize, Range<usize>)> {
    let parity = |at: usize| match reading.class(at)? {
        Class::Even => Some(0),
        Class::Odd => Some(1),
        _ => None,
    };
    // `偶数の号室`
    let is_linked = at > taken + 1 && reading.class(at - 1) == Some(Class::Link);
    let before = at.checked_sub(1 + usize::from(is_linked)).filter(|before| *before >= taken);
    let in_front = before.and_then(|before| Some((parity(before)?, before..at + 1)));
    in_front.or_else(|| Some((parity(at + 1)?, at..at + 2)))
}

/// `the four units`, `四个单元`
fn counted_units(reading: &Reading<'_>, at: usize, level: Level, taken: usize) -> Option<Mention> {
    let number = at.checked_sub(1).filter(|number| *number >= taken)?;
    let Some(Lex::Number { label, ordinal: false }) = reading.lex(number) else { return None };
    let is_definite = || {
        let article = number.checked_sub(1).filter(|article| *article >= taken);
        article.is_some_and(|article| reading.class(article) == Some(Class::Article)) && reading.is_plural(at)
    };
    if !is_counted(reading, at) && !is_definite() {
        return None;
    }
    Some(all_of(level, number..at + 1, Some(label.parse().ok()?)))
}

/// `building 12 u 4`, `bldg. 8 u. 3`: right behind a building the letter need not be glued to its number.
fn spaced_unit(reading: &Reading<'_>, at: usize, last: Option<&Mention>) -> Option<Mention> {
    let last = last.filter(|last| last.level == Level::Building)?;
    let is_beside = (last.at.end..at).all(|at| reading.lex(at) == Some(&Lex::Comma));
    let is_point = reading.token(at + 1).is_some_and(|token| token.text == "." && token.glued);
    let number = at + 1 + usize::from(is_point);
    if !is_beside || !matches!(reading.lex(number), Some(Lex::Number { ordinal: false, .. })) {
        return None;
    }
    let targets = vec![target(reading, number, at..number + 1)?];
    Some(Mention { level: Level::Unit, targets, at: at..number + 1, weak: false })
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
    // `6#2单元`
    let is_glued = reading.token(at).is_some_and(|token| token.glued)
        && at > 0
        && matches!(reading.lex(at - 1), Some(Lex::Number { .. }));
    let range = if reading.label(at + 1).is_some() && !is_glued {
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
    // `the unit is number 2`, `la unidad es la 2`
    if reading.class(at) == Some(Class::Verb)
        && matches!(reading.class(at + 1), Some(Class::Sign | Class::Article))
    {
        let is_label = reading.label(at + 2).is_some()
            && matches!(reading.lex(at + 3), None | Some(Lex::Stop | Lex::Comma | Lex::Word(Class::And, _)));
        at += if is_label { 2 } else { 1 };
    }
    let plural = reading.is_plural(level);
    // `unidades de la 2 a la 4`
    let is_passed =
        |class: Class| class == Class::Sign || plural && matches!(class, Class::Link | Class::Article);
    // `入口は3番`
    let is_own =
        |at: usize| reading.label(at).is_some() && reading.class(at + 1).and_then(self::level).is_none();
    if matches!(reading.lex(at), Some(Lex::Word(Class::Toward, true))) && is_own(at + 1) {
        at += 1;
    }
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
        // `Gebäude 1, 6 und 11 waren geplant`
        // `entrée 1 et 6 pour le bâtiment 11`
        let is_counted = joined && goes_to_a_building(reading, number + 1);
        let is_or = reading
            .token(number.saturating_sub(1))
            .is_some_and(|token| matches!(token.text.as_str(), "o" | "u" | "ou" | "oder" | "or"));
        let ends_a_list =
            joined && !is_or && !pending.is_empty() && reading.lex(number + 1) == Some(&Lex::Unknown);
        // `unit 2 in building 5 and I will be happy`
        let is_pronoun = reading.token(number).is_some_and(|token| token.text == "i");
        let is_listed = !is_pronoun && (reading.continues_list(number) || before_a_word || ends_a_list);
        if !is_listed || is_counted || numbers.len() + pending.len() >= LONGEST_LIST {
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

/// `for building 11`
fn goes_to_a_building(reading: &Reading<'_>, at: usize) -> bool {
    let is_toward = matches!(reading.class(at), Some(Class::Toward | Class::TowardOrAfter));
    let article = usize::from(reading.class(at + 1) == Some(Class::Article));
    is_toward && matches!(reading.lex(at + 1 + article), Some(Lex::Name(_) | Lex::Word(Class::Building, _)))
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
    // `la unidad 1 y la 4`, but `unité 2, et le 6, unité 4`
    let is_alone = reading.lex(start) != Some(&Lex::Comma);
    at += usize::from(joined && is_alone && reading.class(at) == Some(Class::Article));
    (at > start).then_some((at, joined))
}

/// The end of a range and where it stands: `units 1 to 3`, `Eingang 1 bis 3`.
fn range_end(reading: &Reading<'_>, at: usize, plural: bool) -> Option<(String, usize)> {
    let loose = reading.lex(at) == Some(&Lex::Dash) || reading.class(at) == Some(Class::Toward);
    // `入口1から4まで`
    let is_from_to =
        reading.class(at) == Some(Class::NotBefore) && reading.class(at + 2) == Some(Class::Toward);
    if let Some(label) = reading.label(at + 1).filter(|_| is_from_to) {
        return Some((label.to_owned(), at + 3));
    }
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
    if let Some(label) = reading.ordinal_determiner(at).filter(|_| number_first) {
        return Some((vec![label.to_string()], at));
    }
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
    // `一番と四番の入口`
    let joined = reading.class(i) == Some(Class::And);
    if joined && number_first && i > 0 && reading.class(i - 1) == Some(Class::Sign) {
        i -= 1;
    }
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
