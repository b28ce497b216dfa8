//! Which buildings and units an instruction mentions: words for levels with the numbers that belong to them, lists and ranges
//! of those, the map's own names.
//!
//! Numbers without a word for a level are no address, except after `#`; where they are one all the same (`sorry, 2`, `another for 6, unit 1`, `to 105`) is the matter
//! of [`super::intent`], [`super::pairing`] and [`super::fallback`].

mod every;
mod lists;

use std::ops::Range;

use self::every::{all_of, all_units, is_counted, is_described};
use self::lists::{join_ranges, numbers_after, numbers_before};
use super::lexicon::Class;
use super::reading::Reading;
use super::words::Lex;

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

fn level(class: Class) -> Option<Level> {
    match class {
        Class::Building | Class::WeakBuilding => Some(Level::Building),
        Class::Unit => Some(Level::Unit),
        Class::Room => Some(Level::Room),
        _ => None,
    }
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

/// `B8`: only with the number glued to the letter.
fn lettered(reading: &Reading<'_>, at: usize, level: Level) -> Option<Mention> {
    let token = reading.token(at + 1).filter(|t| t.glued)?;
    let Some(Lex::Number { label, ordinal: false }) = reading.lex(at + 1) else { return None };
    let said = format!("{}{}", reading.words(at..at + 1), token.text);
    let targets = vec![Target::Label { label: label.clone(), said }];
    Some(Mention { level, targets, at: at..at + 2, weak: false })
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
