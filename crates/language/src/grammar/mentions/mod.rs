//! Which buildings and units an instruction mentions: words for levels with the numbers that belong
//! to them, lists and ranges of those, the map's own names.
//!
//! Numbers without a word for a level are no address, except after `#`. Where they are one all the
//! same (`sorry, 2`, `another for 6, unit 1`, `to 105`) is the matter of [`super::intent`],
//! [`super::pairing`] and [`super::fallback`].

mod every;
mod lists;
pub(crate) mod mention;

use std::ops::Range;

use self::every::{all_units, is_counted, is_described};
use self::lists::{Numbers, numbers_after, numbers_before};
use self::mention::{Level, Mention, Target};
use super::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::marks;

/// All mentions, in the order of the text.
pub(crate) fn mentions(reading: &Reading<'_>) -> Vec<Mention> {
    let mut found: Vec<Mention> = Vec::new();
    for at in 0..reading.lexemes.len() {
        let taken = found.last().map_or(0, |mention| mention.at.end);
        let Some(mention) = mention(reading, at, taken, found.last()) else {
            continue;
        };
        // `3号、5号楼`: the list takes what seemed to be a place of its own.
        while found
            .last()
            .is_some_and(|last| last.at.end > mention.at.start)
        {
            found.pop();
        }
        let compact = compact_unit(reading, &mention);
        found.push(mention);
        found.extend(compact);
    }
    lists::join_ranges(reading, &mut found);
    found
}

/// The mention whose word for a level, name or sign stands at a place. Lexemes before `taken`
/// belong to the mention before it, `last`.
fn mention(
    reading: &Reading<'_>,
    at: usize,
    taken: usize,
    last: Option<&Mention>,
) -> Option<Mention> {
    // The list of the mention before may reach beyond its word; its lexemes are not read again.
    if at < taken {
        return None;
    }
    match reading.lex(at)? {
        Lex::Name(name) => named(reading, at, *name),
        Lex::Word(Class::BuildingLetter, _) => lettered(reading, at, Level::Building),
        Lex::Word(Class::UnitLetter, _) => {
            lettered(reading, at, Level::Unit).or_else(|| spaced_unit(reading, at, last))
        }
        Lex::Word(Class::AllUnits, _) => Some(Mention::all(Level::Unit, at..at + 1, None)),
        Lex::Word(Class::Sign, _) => signed(reading, at, last),
        Lex::Word(class, number_first) => {
            let level = Level::of(*class)?;
            levelled(reading, at, level, *number_first, taken)
        }
        _ => None,
    }
}

/// A name of the map, unless it is a person's: `Frau Rosenhof`.
fn named(reading: &Reading<'_>, at: usize, name: usize) -> Option<Mention> {
    let is_person = at > 0 && reading.class(at - 1) == Some(Class::Title);
    (!is_person).then(|| Mention::one(Level::Building, Target::Name(name), at..at + 1))
}

/// What the word for a level at a place mentions: some of the level by number, or all of it.
fn levelled(
    reading: &Reading<'_>,
    at: usize,
    level: Level,
    number_first: bool,
    taken: usize,
) -> Option<Mention> {
    if is_described(reading, at) {
        return None;
    }
    let is_amount = level != Level::Building && is_counted(reading, at);
    let numbered = if is_amount {
        None
    } else {
        numbered(reading, at, level, number_first, taken)
    };
    numbered.or_else(|| all_units(reading, at, level, taken))
}

/// A word for a level and the numbers beside it: before it or behind it, as its language puts them.
fn numbered(
    reading: &Reading<'_>,
    at: usize,
    level: Level,
    number_first: bool,
    taken: usize,
) -> Option<Mention> {
    let weak = reading.class(at) == Some(Class::WeakBuilding);
    let before = || numbers_before(reading, at, number_first, taken);
    let after = || numbers_after(reading, at);
    // A weak word counts with its number before it only, as in `3楼`.
    let Numbers { labels, at: range } = if weak {
        before()
    } else if number_first {
        before().or_else(after)
    } else {
        after().or_else(before)
    }?;
    let is_single = labels.len() == 1;
    let target = |label: String| {
        // The words as written may be a name of the map: `Tower 3`. In a list each number gets the
        // word.
        let said = if is_single {
            reading.words(range.clone()).to_owned()
        } else {
            format!("{} {label}", reading.words(at..at + 1))
        };
        Target::Label { label, said }
    };
    let targets = labels.into_iter().map(target).collect();
    Some(Mention {
        level,
        targets,
        at: range,
        weak,
    })
}

/// `B8`: only with the number glued to the letter.
fn lettered(reading: &Reading<'_>, at: usize, level: Level) -> Option<Mention> {
    let token = reading.token(at + 1).filter(|token| token.glued)?;
    let Some(Lex::Number {
        label,
        ordinal: false,
    }) = reading.lex(at + 1)
    else {
        return None;
    };
    let said = format!("{}{}", reading.words(at..at + 1), token.text);
    Some(Mention::one(
        level,
        Target::Label {
            label: label.clone(),
            said,
        },
        at..at + 2,
    ))
}

/// `building 12 u 4`, `bldg. 8 u. 3`: right behind a building the letter need not be glued to its
/// number.
fn spaced_unit(reading: &Reading<'_>, at: usize, last: Option<&Mention>) -> Option<Mention> {
    let last = last.filter(|last| last.is_building())?;
    let is_beside = (last.at.end..at).all(|at| reading.lex(at) == Some(&Lex::Comma));
    let is_abbreviated = reading.begins_with(at + 1, marks::POINT) && reading.is_glued(at + 1);
    let number = at + 1 + usize::from(is_abbreviated);
    if !is_beside || !reading.is_cardinal(number) {
        return None;
    }
    let target = target(reading, number, at..number + 1)?;
    Some(Mention::one(Level::Unit, target, at..number + 1))
}

/// `#12` is a building, or a unit where it follows a building; `3#` is a building.
fn signed(reading: &Reading<'_>, at: usize, last: Option<&Mention>) -> Option<Mention> {
    if !reading.begins_with(at, marks::NUMBER_SIGN) || numbers_a_thing(reading, at) {
        return None;
    }
    let is_apart = |at: usize| matches!(reading.lex(at), Some(Lex::Comma | Lex::Dash));
    let is_behind_building =
        last.is_some_and(|last| last.is_building() && (last.at.end..at).all(is_apart));
    let level = if is_behind_building {
        Level::Unit
    } else {
        Level::Building
    };
    let before = at
        .checked_sub(1)
        .filter(|at| matches!(reading.lex(*at), Some(Lex::Number { .. })));
    // `6#2单元`
    let is_of_before = reading.is_glued(at) && before.is_some();
    let (number, range) = if reading.label(at + 1).is_some() && !is_of_before {
        (at + 1, at..at + 2)
    } else {
        (before?, before?..at + 1)
    };
    let target = target(reading, number, range.clone())?;
    // A sign names no level, so its number gives way where a building is named by its word.
    let weak = level == Level::Building;
    Some(Mention {
        level,
        targets: vec![target],
        at: range,
        weak,
    })
}

/// `order #99`: whether the sign at a place is that of a thing.
fn numbers_a_thing(reading: &Reading<'_>, at: usize) -> bool {
    let before = at.checked_sub(1).and_then(|before| reading.lex(before));
    matches!(
        before,
        Some(Lex::Unknown | Lex::Word(Class::Reference | Class::Item, _))
    )
}

fn target(reading: &Reading<'_>, number: usize, said: Range<usize>) -> Option<Target> {
    let label = reading.label(number)?.to_owned();
    Some(Target::Label {
        label,
        said: reading.words(said).to_owned(),
    })
}

/// `building 3-2`: the second number is the unit.
fn compact_unit(reading: &Reading<'_>, building: &Mention) -> Option<Mention> {
    let dash = building.at.end;
    let is_single = building.is_building() && building.targets.len() == 1;
    let is_tied = reading.lex(dash) == Some(&Lex::Dash)
        && reading.is_glued(dash)
        && reading.is_glued(dash + 1);
    if !is_single || !is_tied || !reading.continues_list(dash + 1) {
        return None;
    }
    let target = target(reading, dash + 1, dash + 1..dash + 2)?;
    Some(Mention::one(Level::Unit, target, dash..dash + 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lexicon::lexer::lexemes;
    use crate::lexicon::tokens::tokenize;
    use crate::lexicon::words::Words;

    /// Mentions as `b3`, `u1+2`, `r502`, weak ones with `?`.
    fn read(text: &str) -> String {
        let words = Words::new();
        let tokens = tokenize(text);
        let lexemes = lexemes(&tokens, &[], words.vocabulary(&tokens));
        let found = mentions(&Reading {
            text,
            tokens: &tokens,
            lexemes: &lexemes,
        });
        let show = |m: &Mention| {
            let level = match m.level {
                Level::Building => "b",
                Level::Unit => "u",
                Level::Room => "r",
            };
            let labels: Vec<&str> = m
                .targets
                .iter()
                .filter_map(|t| {
                    if let Target::Label { label, .. } = t {
                        Some(label.as_str())
                    } else {
                        None
                    }
                })
                .collect();
            format!(
                "{level}{}{}",
                labels.join("+"),
                if m.weak { "?" } else { "" }
            )
        };
        found.iter().map(show).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn numbers_belong_to_the_level_beside_them() {
        assert_eq!(read("unit1, building3"), "u1 b3");
        assert_eq!(
            read("bldg. #4, No. 7 building, building number nine"),
            "b4 b7 b9"
        );
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
