//! Mentions that say how to find another one, and those that count only if nothing else is named.

use super::selection::{Selection, Why};
use crate::grammar::mentions::mention::Mention;
use crate::grammar::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::feature::Feature;

/// `unit 2, first door on the left`: an ordinal of another word right behind a unit says how to
/// find it.
pub(super) fn pass_hints(reading: &Reading<'_>, selection: &mut Selection) {
    for i in 1..selection.count() {
        if is_hint(reading, &selection.mentions[i - 1], &selection.mentions[i]) {
            selection.left_out[i] = Some(Why::Elsewhere);
        }
    }
}

/// Whether a mention says how to find the unit before it.
fn is_hint(reading: &Reading<'_>, unit: &Mention, hint: &Mention) -> bool {
    let are_units = !unit.is_building() && !hint.is_building();
    let start = hint.at.start;
    let is_ordinal = reading.is_ordinal(start) || reading.ordinal_determiner(start).is_some();
    // The same word again is another unit: `unit 2, first unit`.
    let is_other = level_word(reading, unit) != level_word(reading, hint)
        && !reading.is_ordinal(unit.at.start);
    let adds = |at: usize| {
        use Class::{Also, And, Then, Toward};
        matches!(reading.class(at), Some(And | Also | Then | Toward))
            && !reading.has(at, Feature::EnumerationComma)
    };
    are_units && is_ordinal && is_other && !(unit.at.end..start).any(adds)
}

/// The word for the level in a mention of a unit.
fn level_word<'a>(reading: &'a Reading<'_>, mention: &Mention) -> Option<&'a str> {
    let is_level = |at: &usize| matches!(reading.class(*at), Some(Class::Unit | Class::Room));
    let at = mention.at.clone().find(is_level)?;
    reading.token(at).map(|token| token.text.as_str())
}

/// `Leave it behind building 3`: where no building is meant, the landmark is the place after all.
pub(super) fn return_to_landmarks(_: &Reading<'_>, selection: &mut Selection) {
    if selection.has_building() {
        return;
    }
    for why in &mut selection.left_out {
        if *why == Some(Why::Elsewhere) {
            *why = None;
        }
    }
}

/// `3号楼` beside `5楼`: what may be no building is none where another one is named.
pub(super) fn drop_weak(_: &Reading<'_>, selection: &mut Selection) {
    let is_strong =
        |i: usize| selection.is_meant(i) && selection.is_building(i) && !selection.mentions[i].weak;
    if !(0..selection.count()).any(is_strong) {
        return;
    }
    for i in 0..selection.count() {
        if selection.mentions[i].weak && selection.is_meant(i) {
            selection.left_out[i] = Some(Why::Elsewhere);
        }
    }
}
