//! Which mentions are meant: not those after `not`, those that a correction replaces, origins and landmarks, floors.

use super::lexicon::Class;
use super::mentions::{Level, Mention, Reading};
use super::words::Lex;

/// Why a mention is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Why {
    Denied,
    Elsewhere,
}

/// How many words may stand between `not` and the place.
const REACH: usize = 7;

/// The mentions that the robot shall go to.
pub(crate) fn meant(reading: &Reading<'_>, mentions: Vec<Mention>) -> Vec<Mention> {
    let mut left_out: Vec<Option<Why>> = mentions.iter().map(|m| denial(reading, m)).collect();
    spread(reading, &mentions, &mut left_out);
    correct(reading, &mentions, &mut left_out);
    let strong = |i: usize, out: &[Option<Why>]| {
        out[i].is_none() && !mentions[i].weak && mentions[i].level == Level::Building
    };
    if !(0..mentions.len()).any(|i| left_out[i].is_none() && mentions[i].level == Level::Building) {
        // `Leave it behind building 3`: the landmark is the place after all.
        left_out.iter_mut().filter(|why| **why == Some(Why::Elsewhere)).for_each(|why| *why = None);
    }
    let any_strong = (0..mentions.len()).any(|i| strong(i, &left_out));
    let kept = mentions.into_iter().zip(left_out);
    kept.filter(|(m, why)| why.is_none() && !(m.weak && any_strong)).map(|(m, _)| m).collect()
}

fn denial(reading: &Reading<'_>, mention: &Mention) -> Option<Why> {
    if reading.class(mention.at.end) == Some(Class::NotBefore) {
        return Some(Why::Elsewhere);
    }
    for at in (0..mention.at.start).rev().take(REACH) {
        match reading.lex(at)? {
            Lex::Word(Class::Not, _) => return Some(Why::Denied),
            Lex::Word(Class::Elsewhere, _) => return Some(Why::Elsewhere),
            Lex::Word(
                Class::Article
                | Class::Link
                | Class::Toward
                | Class::Verb
                | Class::Filler
                | Class::Determiner
                | Class::Item,
                _,
            ) => {}
            _ => return None,
        }
    }
    None
}

/// `not unit 2 of building 6`: what is tied to a place left out is left out too.
fn spread(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    for i in 1..mentions.len() {
        let gap = mentions[i - 1].at.end..mentions[i].at.start;
        let tie = |at: usize| {
            matches!(reading.class(at), Some(Class::Link | Class::Article))
                || reading.lex(at) == Some(&Lex::Dash)
        };
        let tied = gap.clone().all(tie) && mentions[i].level != mentions[i - 1].level;
        if tied && left_out[i].is_none() {
            left_out[i] = left_out[i - 1];
        }
    }
}

/// After `no wait` and the like each level named replaces the last one of its level.
fn correct(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    for at in (0..reading.lexemes.len()).filter(|at| reading.class(*at) == Some(Class::Correct)) {
        let Some(next) = mentions.iter().position(|m| m.at.start > at) else { continue };
        if mentions[next].at.start - at > REACH {
            continue;
        }
        let mut replaced = Vec::new();
        for i in next..mentions.len() {
            let ends = |at: usize| {
                matches!(
                    reading.lex(at),
                    Some(Lex::Stop | Lex::Word(Class::Then | Class::And | Class::Correct, _))
                )
            };
            if i > next && (mentions[i - 1].at.end..mentions[i].at.start).any(ends) {
                break;
            }
            let level = mentions[i].level;
            let old = (0..next).rev().find(|o| left_out[*o].is_none() && mentions[*o].level == level);
            if let Some(old) = old.filter(|_| left_out[i].is_none() && !replaced.contains(&level)) {
                left_out[old] = Some(Why::Denied);
                replaced.push(level);
            }
        }
    }
}
