//! `Don't go to building 3 before building 4`: orders that a `not` turns round.

use super::reading::Reading;
use super::weight::is_light;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;

/// Whether the `before` at a place puts two stops in order the other way round.
///
/// One stop is named between the `not` and the `before`, and the other right behind it. Where the
/// place comes before its word, the `not` follows, before or behind the other stop.
pub(crate) fn is_order_after_not(reading: &Reading<'_>, at: usize) -> bool {
    match reading.lex(at) {
        Some(Lex::Word(Class::Before, true)) => is_negated_behind(reading, at),
        Some(Lex::Word(Class::Before, false)) => is_negated_before(reading, at),
        _ => false,
    }
}

/// `9号楼没送完之前别去2号楼`
fn is_negated_behind(reading: &Reading<'_>, at: usize) -> bool {
    let mut buildings = 0;
    for i in (at + 1..reading.lexemes.len()).take_while(|i| !reading.is_stop(*i)) {
        match reading.class(i) {
            Some(Class::Not) => return buildings == 0,
            Some(Class::Dropped) => return buildings == 1,
            _ => buildings += usize::from(is_building(reading, i)),
        }
    }
    false
}

/// `Don't go to building 2 until building 9 is done`
fn is_negated_before(reading: &Reading<'_>, at: usize) -> bool {
    let mut next = at + 1..reading.lexemes.len();
    let next = next.find(|i| is_building(reading, *i) || !goes_on(reading, *i));
    let is_before_a_place = next.is_some_and(|i| is_building(reading, i) || is_level(reading, i));
    let mut buildings = 0;
    let mut others = 0;
    for i in (0..at).rev().take_while(|i| !reading.is_stop(*i)) {
        match reading.class(i) {
            Some(Class::Not) => return is_before_a_place && buildings == 1 && others == 0,
            Some(Class::And | Class::Then) => others += 1,
            _ => buildings += usize::from(is_building(reading, i)),
        }
    }
    false
}

fn is_building(reading: &Reading<'_>, at: usize) -> bool {
    let lex = reading.lex(at);
    matches!(
        lex,
        Some(Lex::Name(_) | Lex::Word(Class::Building | Class::WeakBuilding, _))
    )
}

fn is_level(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.class(at), Some(Class::Unit | Class::Room))
}

/// Whether what stands at a place may stand between `before` and its stop.
fn goes_on(reading: &Reading<'_>, at: usize) -> bool {
    match reading.lex(at) {
        Some(Lex::Word(class, _)) => is_light(*class),
        Some(Lex::Number { .. } | Lex::Name(_)) => true,
        _ => false,
    }
}
