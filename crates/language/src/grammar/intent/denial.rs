//! Which mentions the words beside them deny, or make an origin or a landmark.

use std::ops::Range;

use super::super::lexicon::Class;
use super::super::mentions::{Level, Mention};
use super::super::reading::Reading;
use super::super::words::Lex;
use super::{REACH, Why, after, is_light};

/// So many words of no lexicon at most are somebody's name.
const LONGEST_PERSON: usize = 4;

/// Why a place is not meant, by the words beside it.
pub(super) fn denial(reading: &Reading<'_>, mention: &Mention) -> Option<Why> {
    if let Some(why) = denied_behind(reading, mention) {
        // `Vergiss Gebäude 8 nicht!`
        let is_twice = reading.class(mention.at.end) == Some(Class::Not)
            && denied_before(reading, mention) == Some(Why::Denied);
        return (!is_twice).then_some(why);
    }
    let Range { start, end } = mention.at;
    if is_of_the_sender(reading, start)
        || is_where_to_fetch(reading, start)
        || is_fetched_behind(reading, end)
        || is_brought_from(reading, mention)
    {
        return Some(Why::Elsewhere);
    }
    denied_before(reading, mention)
}

/// The same by the words behind it.
fn denied_behind(reading: &Reading<'_>, mention: &Mention) -> Option<Why> {
    let end = mention.at.end;
    let class = |at: usize| reading.class(at);
    let why = match after(reading, end) {
        Some((Class::NotBefore | Class::Sends | Class::ExceptBehind, 0)) => Some(Why::Elsewhere),
        Some((Class::Absent, _)) => Some(Why::Elsewhere),
        Some((Class::Dropped, _)) if !is_conditional(reading, mention.at.start) => Some(Why::Denied),
        // `nur der Eingang 3 nicht.`
        Some((Class::Not, 0)) if ends_a_clause(reading, end + 1) => Some(Why::Denied),
        // `9号楼1单元的先别送，`
        Some((Class::Link, 0)) if class(end + 1) == Some(Class::Not) && ends_a_clause(reading, end + 2) => {
            Some(Why::Denied)
        }
        _ => None,
    };
    let behind_a_mark = || match reading.lex(end)? {
        // `building 6, unit 2, has cancelled`
        Lex::Comma => dropped_behind(reading, end + 1),
        // `Mrs Roche (building 6) sends`
        Lex::Mark => (class(end + 1) == Some(Class::Sends)).then_some(Why::Elsewhere),
        _ => None,
    };
    why.or_else(behind_a_mark).or_else(|| said_of_somebody(reading, end))
}

/// The same by the words before it.
fn denied_before(reading: &Reading<'_>, mention: &Mention) -> Option<Why> {
    for at in (0..mention.at.start).rev().take(REACH) {
        match reading.lex(at)? {
            Lex::Word(Class::Not | Class::Except, _) => return Some(Why::Denied),
            // `They called off the one in building 3`, but `goes out to building 3`
            Lex::Word(Class::Dropped, _) => {
                let is_object = (at + 1..mention.at.start)
                    .all(|i| matches!(reading.class(i), Some(Class::Article | Class::Determiner)));
                return (is_object && says_no_place_before(reading, at)).then_some(Why::Denied);
            }
            Lex::Word(Class::Elsewhere | Class::Between, _) => return Some(Why::Elsewhere),
            Lex::Word(Class::InFront, _) => {
                return (mention.level == Level::Building).then_some(Why::Elsewhere);
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

/// Why words drop the place before a clause that begins here; where the place comes before its verb they are of the next clause.
fn dropped_behind(reading: &Reading<'_>, from: usize) -> Option<Why> {
    let inside = |at: &usize| !matches!(reading.lex(*at), None | Some(Lex::Stop | Lex::Comma));
    let mut clause = (from..reading.lexemes.len()).take_while(inside);
    let why = |at: usize| match reading.lex(at)? {
        Lex::Word(Class::Dropped, false) => Some(Why::Denied),
        Lex::Word(Class::Absent, false) => Some(Why::Elsewhere),
        _ => None,
    };
    let is_light = |at: usize| reading.class(at).is_some_and(is_light);
    let first = clause.find(|at| !is_light(*at))?;
    let is_place = |at: usize| matches!(reading.lex(at), Some(Lex::Number { .. } | Lex::Name(_)));
    if clause.any(is_place) { None } else { why(first) }
}

/// `if nobody is in at building 3`, `only after building 3 has got theirs`
fn is_conditional(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{After, Before, If, Wait};
    let inside = |at: &usize| reading.lex(*at) != Some(&Lex::Stop);
    let conditions = |at: usize| matches!(reading.class(at), Some(If | After | Before | Wait));
    (0..at).rev().take_while(inside).take(REACH).any(conditions)
}

/// `Sender: building 2`, `From: Mrs Chen, building 2`
fn is_of_the_sender(reading: &Reading<'_>, from: usize) -> bool {
    let (mut is_somebodys, mut is_toward, mut commas) = (false, false, 0);
    for at in (0..from).rev().take(REACH) {
        match reading.lex(at) {
            Some(Lex::Word(Class::Sender, _)) => return !(is_somebodys && is_toward),
            Some(Lex::Comma) if commas == 0 => commas += 1,
            Some(Lex::Unknown) => is_somebodys = true,
            Some(Lex::Word(Class::Toward | Class::TowardOrAfter, _)) => is_toward = true,
            Some(Lex::Mark | Lex::Word(Class::Title, _)) => {}
            Some(Lex::Word(class, _)) if is_light(*class) => {}
            _ => return false,
        }
    }
    false
}

/// `pick up the keys in building 2`: a thing between the word and the place.
fn is_where_to_fetch(reading: &Reading<'_>, from: usize) -> bool {
    let mut is_thing = false;
    for at in (0..from).rev().take(REACH) {
        match reading.lex(at) {
            Some(Lex::Word(Class::Pickup, _)) => return is_thing || at + 1 == from,
            Some(Lex::Unknown | Lex::Number { .. } | Lex::Word(Class::Item, _)) => is_thing = true,
            Some(Lex::Word(Class::Article | Class::Determiner | Class::Link | Class::Filler, _)) => {}
            // `récupère le colis au bâtiment 4`
            Some(Lex::Word(Class::Toward, _))
                if reading
                    .token(at)
                    .is_some_and(|token| matches!(token.text.as_str(), "a" | "au" | "aux")) => {}
            _ => return false,
        }
    }
    false
}

/// `von Gebäude 3, Einheit 1 zu Gebäude 8`: a word that ties before a building, and the way to another place right behind it.
fn is_brought_from(reading: &Reading<'_>, mention: &Mention) -> bool {
    let text = |at: usize| reading.token(at).map_or("", |token| token.text.as_str());
    let start = mention.at.start;
    let is_tied = start > 0 && matches!(text(start - 1), "von" | "vom" | "de" | "del");
    if mention.level != Level::Building || !is_tied {
        return false;
    }
    let is_unit = |at: &usize| {
        matches!(
            reading.lex(*at),
            Some(Lex::Number { .. } | Lex::Comma | Lex::Word(Class::Unit | Class::Room, _))
        )
    };
    let to = mention.at.end + (mention.at.end..reading.lexemes.len()).take_while(is_unit).count();
    let place = to + 1 + usize::from(reading.class(to + 1) == Some(Class::Article));
    // `le colis du bâtiment 4 à l'entrée 2` is of one address.
    let has_unit =
        to > mention.at.end || start > 1 && matches!(reading.lex(start - 2), Some(Lex::Number { .. }));
    let is_place = match reading.lex(place) {
        Some(Lex::Name(_) | Lex::Word(Class::Building, _)) => true,
        Some(Lex::Word(Class::Unit, _)) => has_unit,
        _ => false,
    };
    is_place && matches!(reading.class(to), Some(Class::Toward | Class::TowardOrAfter))
}

/// `去2号楼老张家拿一下电钻`, `図書館で本を受け取って`: in languages that put the verb behind.
fn is_fetched_behind(reading: &Reading<'_>, from: usize) -> bool {
    let inside = |at: &usize| {
        let lex = reading.lex(*at);
        !matches!(
            lex,
            None | Some(
                Lex::Stop
                    | Lex::Comma
                    | Lex::Name(_)
                    | Lex::Word(Class::And | Class::Building | Class::Toward, _)
            )
        )
    };
    let mut clause = (from..reading.lexemes.len()).take_while(inside).take(REACH);
    clause.any(|at| reading.lex(at) == Some(&Lex::Word(Class::Pickup, true)))
}

/// What is said of somebody, unknown words that end at a place and have a link behind them: `from my sister's in building 9`, `not to her husband in unit 1`.
fn of_somebody(reading: &Reading<'_>, at: usize) -> Option<Why> {
    let is_somebody = |at: &usize| {
        matches!(reading.lex(*at), Some(Lex::Unknown | Lex::Mark))
            && reading.token(*at).is_none_or(|token| token.text != ":")
    };
    let start = (0..=at).rev().take_while(is_somebody).last()?;
    if at - start >= LONGEST_PERSON || reading.class(at + 1) != Some(Class::Link) {
        return None;
    }
    let is_article = |at: usize| matches!(reading.class(at), Some(Class::Article | Class::Determiner));
    let mut before = start.checked_sub(1)?;
    before = before.saturating_sub(usize::from(is_article(before)));
    match reading.class(before)? {
        Class::Elsewhere | Class::Speaking => Some(Why::Elsewhere),
        Class::Toward => {
            let denied = before.checked_sub(1).and_then(|before| reading.class(before));
            matches!(denied, Some(Class::Not | Class::Except)).then_some(Why::Denied)
        }
        _ => None,
    }
}

fn ends_a_clause(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.lex(at), None | Some(Lex::Stop | Lex::Comma))
}

/// `7号棟3号室の山本さんから`, `2号楼的王先生寄来的`, `2号楼的张阿姨搬走了`: what is said of who lives at a place, or of a thing there.
fn said_of_somebody(reading: &Reading<'_>, mut at: usize) -> Option<Why> {
    if reading.class(at) != Some(Class::Link) {
        return None;
    }
    at += 1;
    let is_name = |at: &usize| matches!(reading.lex(*at), Some(Lex::Unknown | Lex::Word(Class::Item, _)));
    let name = (at..reading.lexemes.len()).take_while(is_name).count();
    at += name;
    while matches!(reading.class(at), Some(Class::Filler | Class::Title)) {
        at += 1;
    }
    let class = reading.class(at).filter(|_| (1..=LONGEST_PERSON).contains(&name))?;
    match class {
        Class::NotBefore | Class::Sends | Class::Speaking | Class::Absent => Some(Why::Elsewhere),
        Class::Dropped => Some(Why::Denied),
        _ => None,
    }
}

/// Whether no level is named between the beginning of the clause and a place: what was cancelled comes after it then.
fn says_no_place_before(reading: &Reading<'_>, at: usize) -> bool {
    let inside = |i: &usize| !matches!(reading.lex(*i), Some(Lex::Stop | Lex::Comma));
    let is_place = |i: usize| {
        matches!(
            reading.lex(i),
            Some(
                Lex::Name(_) | Lex::Number { .. } | Lex::Word(Class::Building | Class::Unit | Class::Room, _)
            )
        )
    };
    !(0..at).rev().take_while(inside).any(is_place)
}
