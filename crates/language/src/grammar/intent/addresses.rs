//! A building goes with its units, and they with it.

use super::selection::Selection;
use crate::grammar::mentions::mention::{Level, Mention};
use crate::grammar::ownership::{is_of_the_same, owners};
use crate::grammar::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;

/// `not unit 2 of building 6`: what is tied to a place left out is left out too.
pub(super) fn spread(reading: &Reading<'_>, selection: &mut Selection) {
    // In the order of the text, so that it spreads over more than two mentions.
    for i in 1..selection.count() {
        let (before, mention) = (&selection.mentions[i - 1], &selection.mentions[i]);
        let is_tied = before.level != mention.level && is_tied(reading, before, mention);
        if is_tied && selection.is_meant(i) {
            selection.left_out[i] = selection.left_out[i - 1];
        }
    }
}

/// Whether nothing but `of`, articles and dashes stand between two mentions.
fn is_tied(reading: &Reading<'_>, a: &Mention, b: &Mention) -> bool {
    (a.at.end..b.at.start).all(|at| {
        matches!(
            reading.lex(at),
            Some(Lex::Dash | Lex::Word(Class::Link | Class::Article, _))
        )
    })
}

/// `not unit 3, building 5, but …`, `building 5 unit 3 was cancelled`: a building is left out with
/// all its units, and they with it.
pub(super) fn together(reading: &Reading<'_>, selection: &mut Selection) {
    let owners = owners(reading, &selection.mentions);
    let units_of = |selection: &Selection, building: usize| -> Vec<usize> {
        let units = (0..selection.count()).filter(|i| !selection.is_building(*i));
        units.filter(|i| owners[*i] == Some(building)).collect()
    };
    for building in 0..selection.count() {
        if !selection.is_building(building) {
            continue;
        }
        let all = units_of(selection, building);
        let own: Vec<usize> = all
            .iter()
            .copied()
            .filter(|i| is_own(reading, selection, *i, building))
            .collect();
        let Some(first) = own.first() else { continue };
        let has_only_own = own.len() == all.len();
        let is_none_meant = !own.iter().any(|i| selection.is_meant(*i));
        match selection.left_out[building] {
            None if has_only_own && is_none_meant => {
                selection.left_out[building] = selection.left_out[*first];
            }
            None => {}
            // `not unit 1 of building 5 …. Unit 4 of the same building`
            Some(_)
                if own
                    .iter()
                    .any(|i| is_meant_of_the_same(reading, selection, *i)) =>
            {
                selection.left_out[building] = None;
            }
            Some(why) => {
                // `not building 6, unit 2, but building 8`: the unit may belong to a building that
                // is meant, if one has none.
                let is_bare = |b: usize| {
                    let is_building = selection.is_building(b) && selection.is_meant(b);
                    is_building && units_of(selection, b).is_empty()
                };
                if !(0..selection.count()).any(is_bare) {
                    for unit in own {
                        selection.left_out[unit] = selection.left_out[unit].or(Some(why));
                    }
                }
            }
        }
    }
}

/// Whether nothing between a unit and its building denies one of them alone.
fn is_own(reading: &Reading<'_>, selection: &Selection, unit: usize, building: usize) -> bool {
    let mentions = &selection.mentions;
    let (first, second) = (unit.min(building), unit.max(building));
    // `unit 2, not in building 6`: what is denied begins between them.
    let parts = |at: usize| {
        use Class::{Correct, Dropped, Elsewhere, Except, Not, NotBefore};
        let class = reading.class(at);
        matches!(
            class,
            Some(Not | Except | NotBefore | Dropped | Elsewhere | Correct)
        )
    };
    let is_parted = (mentions[first].at.end..mentions[second].at.start).any(parts);
    let is_excepted = reading.class(mentions[unit].at.end) == Some(Class::ExceptBehind);
    !is_parted && !is_excepted
}

fn is_meant_of_the_same(reading: &Reading<'_>, selection: &Selection, unit: usize) -> bool {
    selection.is_meant(unit) && is_of_the_same(reading, selection.mentions[unit].at.end)
}

/// `Cancel building 3 unit 1; unit 4 stays`: where a unit is meant its building is, if no other one
/// is.
pub(super) fn return_to_units(reading: &Reading<'_>, selection: &mut Selection) {
    if selection.has_building() {
        return;
    }
    let owners = owners(reading, &selection.mentions);
    let is_unit = |i: &usize| selection.mentions[*i].level == Level::Unit;
    let unit = (0..selection.count()).find(|i| is_unit(i) && selection.is_meant(*i));
    if let Some(building) = unit.and_then(|unit| owners[unit]) {
        selection.left_out[building] = None;
    }
}
