//! What the words beside a mention make of it: denied, an origin, a landmark.

use std::ops::Range;

use super::selection::Why;
use crate::grammar::mentions::mention::{Level, Mention};
use crate::grammar::reading::Reading;
use crate::grammar::rule::{Example, Rule};
use crate::grammar::weight::{REACH, is_light, weighty_from};
use crate::lexicon::class::Class;
use crate::lexicon::feature::Feature;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::marks;

/// The most words of no lexicon that are a person's name. Each ideograph is a word.
const LONGEST_PERSON: usize = 4;

/// What a rule makes of a mention.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Meant,
    LeftOut(Why),
}

use Verdict::{LeftOut, Meant};
use Why::{Denied, Elsewhere};

/// A rule of [`DENIALS`].
pub(crate) type Denial = Rule<fn(&Reading<'_>, &Mention) -> Option<Verdict>>;

/// What words beside a mention make of it. The first rule that says anything decides.
///
/// Words behind a mention are asked first, since words in front of it may be of an earlier place.
/// The last rule takes the nearest word with weight, whatever it is, so no rule can follow it.
pub(crate) const DENIALS: &[Denial] = &[
    Denial {
        name: "what comes from a place, or is beside it, is said behind it",
        examples: &[
            Example("3号楼旁边的5号楼2单元", "building5/unit2"),
            Example("6号棟ではなく8号棟に届けてください", "building8"),
        ],
        apply: elsewhere_behind,
    },
    Denial {
        name: "a place that is closed or empty is no destination",
        examples: &[Example(
            "L'ascenseur du bâtiment 4 est en panne. Le colis va au bâtiment 6, unité 3.",
            "building6/unit3",
        )],
        apply: absent_behind,
    },
    Denial {
        name: "a place is cancelled behind it",
        examples: &[Example(
            "6栋2单元已经取消了，只剩4栋3单元。",
            "building4/unit3",
        )],
        apply: dropped_behind,
    },
    Denial {
        name: "a `not` before and a `not` behind make a place meant",
        examples: &[Example("Vergiss Gebäude 8 nicht!", "building8")],
        apply: denied_twice,
    },
    Denial {
        name: "a `not` that ends a clause denies the place before it",
        examples: &[Example(
            "刚才说的2号楼4单元取消，只送10号楼3单元。",
            "building10/unit3",
        )],
        apply: not_behind,
    },
    Denial {
        name: "a place is cancelled behind a comma",
        examples: &[Example(
            "Building 7, unit 2 and building 8, unit 1. Building 8, unit 1, has cancelled.",
            "building7/unit2",
        )],
        apply: dropped_behind_a_comma,
    },
    Denial {
        name: "an address in brackets behind a name is a sender's",
        examples: &[Example(
            "Mme Roche (bâtiment 6, entrée 4) envoie ce pot de miel à M. Petit, qui habite \
                 bâtiment 2, entrée 3.",
            "building2/unit3",
        )],
        apply: sends_behind_a_mark,
    },
    Denial {
        name: "what is said of a resident is said of the address",
        examples: &[Example(
            "7号棟3号室の山本さんから預かった荷物を、12号棟2号室に",
            "building12/unit2",
        )],
        apply: said_of_somebody,
    },
    Denial {
        name: "a sender's address is an origin",
        examples: &[Example(
            "Sender: building 2 unit 4, recipient: building 9 unit 3",
            "building9/unit3",
        )],
        apply: of_the_sender,
    },
    Denial {
        name: "things are fetched from an origin",
        examples: &[Example(
            "Pick up the keys in building 2 and take them to building 5",
            "building5",
        )],
        apply: where_to_fetch,
    },
    Denial {
        name: "things are fetched from an origin, the verb behind it",
        examples: &[Example(
            "去2号楼4单元老张家拿一下电钻，送到5号楼1单元",
            "building5/unit1",
        )],
        apply: fetched_behind,
    },
    Denial {
        name: "things are brought from one place to another",
        examples: &[Example(
            "Bring den Tisch von Gebäude 3, Einheit 1 zu Gebäude 8, Einheit 2.",
            "building8/unit2",
        )],
        apply: brought_from,
    },
    Denial {
        name: "the nearest word with weight before a place denies it",
        examples: &[
            Example("not building 6, building 8", "building8"),
            Example(
                "Building 4, the one next to building 5, unit 2",
                "building4/unit2",
            ),
        ],
        apply: denied_before,
    },
];

/// Why a mention is left out by the words beside it.
pub(super) fn denial(rules: &[Denial], reading: &Reading<'_>, mention: &Mention) -> Option<Why> {
    match rules
        .iter()
        .find_map(|rule| (rule.apply)(reading, mention))?
    {
        Meant => None,
        LeftOut(why) => Some(why),
    }
}

/// `3号楼旁边的5号楼`, `6号棟ではなく8号棟に`
fn elsewhere_behind(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let class = reading.class(mention.at.end)?;
    let is_elsewhere = matches!(class, Class::NotBefore | Class::Sends | Class::ExceptBehind);
    is_elsewhere.then_some(LeftOut(Elsewhere))
}

/// `The office in building 3 is closed`
fn absent_behind(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let class = weighty_from(reading, mention.at.end)?;
    (class == Class::Absent).then_some(LeftOut(Elsewhere))
}

/// `building 3 was cancelled`
fn dropped_behind(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let class = weighty_from(reading, mention.at.end)?;
    let is_dropped = class == Class::Dropped && !is_conditional(reading, mention.at.start);
    is_dropped.then_some(LeftOut(Denied))
}

/// `if nobody is in at building 3`, `only after building 3 has got theirs`
fn is_conditional(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{After, Before, If, Wait};
    (0..at)
        .rev()
        .take_while(|at| !reading.is_stop(*at))
        .take(REACH)
        .any(|at| matches!(reading.class(at), Some(If | After | Before | Wait)))
}

/// `Vergiss Gebäude 8 nicht!`
fn denied_twice(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let is_denied_behind = is_not_behind(reading, mention.at.end);
    let is_twice = is_denied_behind && denied_before(reading, mention) == Some(LeftOut(Denied));
    is_twice.then_some(Meant)
}

/// `nur der Eingang 3 nicht.`, `9号楼1单元的先别送，`
fn not_behind(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let end = mention.at.end;
    let is_linked = reading.class(end) == Some(Class::Link);
    let is_denied = is_not_behind(reading, end) || is_linked && is_not_behind(reading, end + 1);
    is_denied.then_some(LeftOut(Denied))
}

/// Whether a `not` stands at a place and ends its clause.
fn is_not_behind(reading: &Reading<'_>, at: usize) -> bool {
    reading.class(at) == Some(Class::Not) && ends_a_clause(reading, at + 1)
}

fn ends_a_clause(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.lex(at), None | Some(Lex::Stop | Lex::Comma))
}

/// `building 6, unit 2, has cancelled`. If a place comes before the verb, it is the next clause's.
fn dropped_behind_a_comma(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    if reading.lex(mention.at.end) != Some(&Lex::Comma) {
        return None;
    }
    let from = mention.at.end + 1;
    let mut clause = (from..reading.lexemes.len()).take_while(|at| !ends_a_clause(reading, *at));
    // The verb of the clause; `clause` goes on behind it.
    let first = clause.find(|at| !reading.class(*at).is_some_and(is_light))?;
    if clause.any(|at| matches!(reading.lex(at), Some(Lex::Number { .. } | Lex::Name(_)))) {
        return None;
    }
    match reading.lex(first)? {
        Lex::Word(Class::Dropped, false) => Some(LeftOut(Denied)),
        Lex::Word(Class::Absent, false) => Some(LeftOut(Elsewhere)),
        _ => None,
    }
}

/// `Mrs Roche (building 6) sends`
fn sends_behind_a_mark(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let end = mention.at.end;
    let is_sent =
        reading.lex(end) == Some(&Lex::Mark) && reading.class(end + 1) == Some(Class::Sends);
    is_sent.then_some(LeftOut(Elsewhere))
}

/// `7号棟3号室の山本さんから`, `2号楼的王先生寄来的`, `2号楼的张阿姨搬走了`: what is said of a person who
/// lives at a place, or of a thing there.
fn said_of_somebody(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    if reading.class(mention.at.end) != Some(Class::Link) {
        return None;
    }
    let name = mention.at.end + 1;
    let length = (name..reading.lexemes.len())
        .take_while(|at| is_of_a_person_or_thing(reading, *at))
        .count();
    // A longer run of unknown words is a clause in a language that has no spaces.
    if !(1..=LONGEST_PERSON).contains(&length) {
        return None;
    }
    let mut at = name + length;
    while matches!(reading.class(at), Some(Class::Filler | Class::Title)) {
        at += 1;
    }
    match reading.class(at)? {
        Class::NotBefore | Class::Sends | Class::Speaking | Class::Absent => {
            Some(LeftOut(Elsewhere))
        }
        Class::Dropped => Some(LeftOut(Denied)),
        _ => None,
    }
}

/// Whether a lexeme may be of a person's name or of a thing: `山本さん`, `の荷物`.
fn is_of_a_person_or_thing(reading: &Reading<'_>, at: usize) -> bool {
    matches!(
        reading.lex(at),
        Some(Lex::Unknown | Lex::Word(Class::Item, _))
    )
}

/// `Sender: building 2`, `From: Mrs Chen, building 2`
fn of_the_sender(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let mut is_somebodys = false;
    let mut is_toward = false;
    let mut has_comma = false;
    for at in (0..mention.at.start).rev().take(REACH) {
        match reading.lex(at)? {
            Lex::Word(Class::Sender, _) => {
                // `on behalf of Mrs Chen to building 2`
                let is_recipients = is_somebodys && is_toward;
                return (!is_recipients).then_some(LeftOut(Elsewhere));
            }
            // A name may be between the word and its address; a second comma begins something else.
            Lex::Comma if !has_comma => has_comma = true,
            Lex::Unknown => is_somebodys = true,
            Lex::Word(Class::Toward | Class::TowardOrAfter, _) => is_toward = true,
            Lex::Mark | Lex::Word(Class::Title, _) => {}
            Lex::Word(class, _) if is_light(*class) => {}
            _ => return None,
        }
    }
    None
}

/// `pick up the keys in building 2`: a thing between the word and the place.
fn where_to_fetch(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let mut has_thing = false;
    for at in (0..mention.at.start).rev().take(REACH) {
        match reading.lex(at)? {
            Lex::Word(Class::Pickup, _) => {
                let is_origin = has_thing || at + 1 == mention.at.start;
                return is_origin.then_some(LeftOut(Elsewhere));
            }
            Lex::Unknown | Lex::Number { .. } | Lex::Word(Class::Item, _) => has_thing = true,
            Lex::Word(Class::Article | Class::Determiner | Class::Link | Class::Filler, _) => {}
            // `récupère le colis au bâtiment 4`
            Lex::Word(Class::Toward, _) if reading.has(at, Feature::Locative) => {}
            _ => return None,
        }
    }
    None
}

/// `去2号楼老张家拿一下电钻`, `図書館で本を受け取って`: in languages that put the verb behind.
fn fetched_behind(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    (mention.at.end..reading.lexemes.len())
        .take_while(|at| !begins_another_place(reading, *at))
        .take(REACH)
        .any(|at| reading.lex(at) == Some(&Lex::Word(Class::Pickup, true)))
        .then_some(LeftOut(Elsewhere))
}

/// Whether another clause or place begins, of which the verb behind it is said.
fn begins_another_place(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{And, Building, Toward};
    matches!(
        reading.lex(at),
        None | Some(Lex::Stop | Lex::Comma | Lex::Name(_) | Lex::Word(And | Building | Toward, _))
    )
}

/// `von Gebäude 3, Einheit 1 zu Gebäude 8`: `of` or `from` before a building, and words for where
/// to with another place right behind its address.
fn brought_from(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let Range { start, end } = mention.at;
    let is_from = start > 0 && reading.has(start - 1, Feature::Ablative);
    if mention.level != Level::Building || !is_from {
        return None;
    }
    let to = end
        + (end..reading.lexemes.len())
            .take_while(|at| is_of_an_address(reading, *at))
            .count();
    let is_toward = matches!(
        reading.class(to),
        Some(Class::Toward | Class::TowardOrAfter)
    );
    let place = to + 1 + usize::from(reading.class(to + 1) == Some(Class::Article));
    // `le colis du bâtiment 4 à l'entrée 2` is of one address.
    let has_unit =
        to > end || start > 1 && matches!(reading.lex(start - 2), Some(Lex::Number { .. }));
    let is_place = match reading.lex(place) {
        Some(Lex::Name(_) | Lex::Word(Class::Building, _)) => true,
        Some(Lex::Word(Class::Unit, _)) => has_unit,
        _ => false,
    };
    (is_toward && is_place).then_some(LeftOut(Elsewhere))
}

/// Whether a lexeme may be of an address behind its building: `, Einheit 1`.
fn is_of_an_address(reading: &Reading<'_>, at: usize) -> bool {
    matches!(
        reading.lex(at),
        Some(Lex::Number { .. } | Lex::Comma | Lex::Word(Class::Unit | Class::Room, _))
    )
}

/// `not building 6`, `next to building 5`: light words and things may stand between.
fn denied_before(reading: &Reading<'_>, mention: &Mention) -> Option<Verdict> {
    let start = mention.at.start;
    for at in (0..start).rev().take(REACH) {
        match reading.lex(at)? {
            Lex::Word(Class::Not | Class::Except, _) => return Some(LeftOut(Denied)),
            Lex::Word(Class::Dropped, _) => {
                return is_object(reading, at, start).then_some(LeftOut(Denied));
            }
            Lex::Word(Class::Elsewhere | Class::Between, _) => return Some(LeftOut(Elsewhere)),
            // In front of a building is a landmark, but in front of a unit is its door.
            Lex::Word(Class::InFront, _) => {
                return mention.is_building().then_some(LeftOut(Elsewhere));
            }
            Lex::Word(class, _) if is_light(*class) || *class == Class::Item => {}
            // `collected three bags in building 3`
            Lex::Number { ordinal: false, .. } if reading.class(at + 1) == Some(Class::Item) => {}
            // `from reception at the Town Hall`
            Lex::Unknown => return of_somebody(reading, at),
            _ => return None,
        }
    }
    None
}

/// `They called off the one in building 3`, but `goes out to building 3`: whether the place at
/// `start` is the object of the word that drops.
fn is_object(reading: &Reading<'_>, dropped: usize, start: usize) -> bool {
    (dropped + 1..start).all(|at| is_article_or_determiner(reading, at))
        && says_no_place_before(reading, dropped)
}

fn is_article_or_determiner(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.class(at), Some(Class::Article | Class::Determiner))
}

/// Whether no level is named between the beginning of the clause and a place: what was cancelled
/// comes behind it then.
fn says_no_place_before(reading: &Reading<'_>, at: usize) -> bool {
    !(0..at)
        .rev()
        .take_while(|at| !ends_a_clause(reading, *at))
        .any(|at| is_of_a_place(reading, at))
}

/// Whether a lexeme names a place or is of its name.
fn is_of_a_place(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{Building, Room, Unit};
    matches!(
        reading.lex(at),
        Some(Lex::Name(_) | Lex::Number { .. } | Lex::Word(Building | Unit | Room, _))
    )
}

/// What is said of a person, unknown words that end at a place and have a link behind them: `from
/// my sister's in building 9`, `not to her husband in unit 1`.
fn of_somebody(reading: &Reading<'_>, at: usize) -> Option<Verdict> {
    let start = (0..=at)
        .rev()
        .take_while(|at| is_of_a_persons_name(reading, *at))
        .last()?;
    if at - start >= LONGEST_PERSON || reading.class(at + 1) != Some(Class::Link) {
        return None;
    }
    let mut before = start.checked_sub(1)?;
    if is_article_or_determiner(reading, before) {
        before = before.saturating_sub(1);
    }
    match reading.class(before)? {
        Class::Elsewhere | Class::Speaking => Some(LeftOut(Elsewhere)),
        Class::Toward => {
            let denied = before
                .checked_sub(1)
                .and_then(|before| reading.class(before));
            matches!(denied, Some(Class::Not | Class::Except)).then_some(LeftOut(Denied))
        }
        _ => None,
    }
}

/// Whether a lexeme may be of a person's name: unknown words, and the mark in `sister's`. A colon
/// ends what it is said of.
fn is_of_a_persons_name(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.lex(at), Some(Lex::Unknown | Lex::Mark))
        && !reading.begins_with(at, marks::COLON)
}
