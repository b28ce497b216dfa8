//! What is taken back of what was named before, and all units of a building but some.

use super::selection::{Selection, Why};
use crate::grammar::mentions::mention::{Level, Mention, Target};
use crate::grammar::ownership::owners;
use crate::grammar::reading::Reading;
use crate::grammar::weight::{REACH, is_light, weighty_from};
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;

/// A target that is taken back.
struct Taken {
    /// The mention that named it.
    mention: usize,
    target: Target,
}

/// `Units 2 and 4 of building 7 …, but unit 4 has just cancelled`: what is denied is taken back
/// where it was named before.
pub(super) fn take_back(reading: &Reading<'_>, selection: &mut Selection) {
    // Both are found before any is taken back, since taking back changes what is meant.
    let mut taken = named_before(reading, selection);
    taken.extend(by_number(reading, selection));
    for Taken { mention, target } in taken {
        let targets = &mut selection.mentions[mention].targets;
        // A mention must keep a target, so the last one is left out with its mention.
        if targets.iter().all(|other| other.is_same(&target)) {
            selection.left_out[mention] = Some(Why::Denied);
        } else {
            targets.retain(|other| !other.is_same(&target));
        }
    }
}

/// What denied mentions name that mentions before them name too.
fn named_before(reading: &Reading<'_>, selection: &Selection) -> Vec<Taken> {
    let mentions = &selection.mentions;
    let owners = owners(reading, mentions);
    let mut taken = Vec::new();
    for denied in 0..mentions.len() {
        if selection.left_out[denied] != Some(Why::Denied) {
            continue;
        }
        // A building with units is denied for their sake: `not building 5 unit 2`.
        let is_building = mentions[denied].is_building();
        if is_building && has_unit(&owners, denied) {
            continue;
        }
        for earlier in (0..denied).filter(|i| selection.is_meant(*i)) {
            let is_same = mentions[earlier].level == mentions[denied].level
                && (is_building || are_of_one_building(mentions, owners[earlier], owners[denied]));
            let targets = mentions[denied].targets.iter();
            let targets = targets.filter(|target| is_same && mentions[earlier].names(target));
            taken.extend(targets.map(|target| Taken {
                mention: earlier,
                target: target.clone(),
            }));
        }
    }
    taken
}

/// Whether a building owns another mention than itself.
fn has_unit(owners: &[Option<usize>], building: usize) -> bool {
    (0..owners.len()).any(|i| i != building && owners[i] == Some(building))
}

/// `Buildings 1, 6 and 11 …. The 6 has cancelled`: places taken back by their numbers alone.
fn by_number(reading: &Reading<'_>, selection: &Selection) -> Vec<Taken> {
    let mut taken = Vec::new();
    for at in 0..reading.lexemes.len() {
        if is_in_a_mention(&selection.mentions, at) || !is_headed(reading, at) {
            continue;
        }
        let Some(Lex::Number {
            label,
            ordinal: false,
        }) = reading.lex(at)
        else {
            continue;
        };
        if !is_denied_behind(reading, at + 1) {
            continue;
        }
        let target = Target::bare(label);
        let mention = named_by_number(selection, at, &target);
        taken.extend(mention.map(|mention| Taken { mention, target }));
    }
    taken
}

fn is_in_a_mention(mentions: &[Mention], at: usize) -> bool {
    mentions.iter().any(|mention| mention.at.contains(&at))
}

/// `the 6`: whether a word that heads a noun stands before a place. A bare number counts.
fn is_headed(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{Article, Determiner, Link};
    at > 0 && matches!(reading.class(at - 1), Some(Article | Link | Determiner))
}

/// The mention before a place that a number alone means: a building rather than a unit.
fn named_by_number(selection: &Selection, at: usize, target: &Target) -> Option<usize> {
    let mentions = &selection.mentions;
    let named: Vec<usize> = (0..mentions.len())
        .filter(|i| selection.is_meant(*i))
        .filter(|i| mentions[*i].at.end <= at && mentions[*i].names(target))
        .collect();
    let building = named.iter().find(|i| mentions[**i].is_building());
    building.or(named.first()).copied()
}

/// `The 6 has cancelled`, `en el 6 no, que …`
fn is_denied_behind(reading: &Reading<'_>, at: usize) -> bool {
    let is_not = reading.class(at) == Some(Class::Not)
        && matches!(reading.lex(at + 1), None | Some(Lex::Comma | Lex::Stop));
    is_not || weighty_from(reading, at) == Some(Class::Dropped)
}

/// Whether two owners are one building, by its number or name.
fn are_of_one_building(mentions: &[Mention], a: Option<usize>, b: Option<usize>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a == b || mentions[a].names_all_of(&mentions[b]),
        _ => a == b,
    }
}

/// `Everyone in building 3 apart from unit 2`: an exception implies all other units.
pub(super) fn all_but(reading: &Reading<'_>, selection: &mut Selection) {
    let owners = owners(reading, &selection.mentions);
    let found: Vec<usize> = (0..selection.count())
        .filter(|i| selection.is_building(*i) && selection.is_meant(*i))
        .filter(|building| has_only_exceptions(reading, selection, &owners, *building))
        .collect();
    // From the end, so that indices stay right.
    for building in found.into_iter().rev() {
        let end = selection.mentions[building].at.end;
        selection.insert(building + 1, Mention::all(Level::Unit, end..end, None));
    }
}

/// Whether a building has units that an exception leaves out, and none that is meant.
fn has_only_exceptions(
    reading: &Reading<'_>,
    selection: &Selection,
    owners: &[Option<usize>],
    building: usize,
) -> bool {
    let units: Vec<usize> = (0..selection.count())
        .filter(|i| !selection.is_building(*i) && owners[*i] == Some(building))
        .collect();
    !units.iter().any(|unit| selection.is_meant(*unit))
        && units
            .iter()
            .any(|unit| is_excepted(reading, &selection.mentions[*unit]))
}

/// `but unit 1 and unit 3`: what is listed with an exception is one.
pub(super) fn except_lists(reading: &Reading<'_>, selection: &mut Selection) {
    for i in 1..selection.count() {
        let (before, mention) = (&selection.mentions[i - 1], &selection.mentions[i]);
        let is_next = selection.is_meant(i) && !selection.is_meant(i - 1);
        if is_next && is_joined(reading, before, mention) && is_excepted(reading, before) {
            selection.left_out[i] = selection.left_out[i - 1];
        }
    }
}

/// Whether a word for an exception stands before a place, or before one that it is listed with.
fn is_excepted(reading: &Reading<'_>, mention: &Mention) -> bool {
    if reading.class(mention.at.end) == Some(Class::ExceptBehind) {
        return true;
    }
    let weighty = (0..mention.at.start)
        .rev()
        .take(REACH)
        .find(|at| !may_be_listed(reading, *at));
    let class = weighty.and_then(|at| reading.class(at));
    matches!(class, Some(Class::Except | Class::Between))
}

/// Whether a lexeme may stand between a word for an exception and the last unit of its list.
fn may_be_listed(reading: &Reading<'_>, at: usize) -> bool {
    match reading.lex(at) {
        Some(Lex::Number { .. } | Lex::Word(Class::Unit | Class::Room | Class::And, _)) => true,
        Some(Lex::Word(class, _)) => is_light(*class),
        _ => false,
    }
}

/// `all units of building 3 but unit 2`: all units are those that are not left out.
pub(super) fn except(reading: &Reading<'_>, selection: &mut Selection) {
    let owners = owners(reading, &selection.mentions);
    for all in 0..selection.count() {
        let is_all = matches!(selection.mentions[all].targets[..], [Target::All { .. }]);
        if !is_all || !selection.is_meant(all) {
            continue;
        }
        let is_of_it: Vec<bool> = (0..selection.count())
            .map(|i| {
                !selection.is_building(i)
                    && are_of_one_building(&selection.mentions, owners[all], owners[i])
            })
            .collect();
        if lists_units(selection, &is_of_it) {
            selection.left_out[all] = Some(Why::Denied);
            continue;
        }
        leave_out_joined(reading, selection, all, &is_of_it);
        let mut excepted = labels_left_out(selection, &is_of_it);
        // Numbers without their word are no mentions, so they are read here.
        excepted.extend(bare_exceptions(reading, selection.mentions[all].at.end));
        if let [Target::All { but, .. }] = &mut selection.mentions[all].targets[..] {
            *but = excepted;
        }
    }
}

/// `units 1 to 3, one for each unit`: whether units of a building are listed, so that `each` means
/// those.
fn lists_units(selection: &Selection, is_of_it: &[bool]) -> bool {
    (0..selection.count())
        .any(|i| is_of_it[i] && selection.is_meant(i) && selection.mentions[i].targets.len() > 1)
}

/// Leaves out what is listed before a unit that is left out.
fn leave_out_joined(
    reading: &Reading<'_>,
    selection: &mut Selection,
    all: usize,
    is_of_it: &[bool],
) {
    // From the end, so that `units 2, 3 and 4 have theirs` leaves out one after the other.
    for i in (0..selection.count().saturating_sub(1)).rev() {
        let is_next =
            i != all && is_of_it[i] && selection.is_meant(i) && !selection.is_meant(i + 1);
        if is_next && is_joined(reading, &selection.mentions[i], &selection.mentions[i + 1]) {
            selection.left_out[i] = selection.left_out[i + 1];
        }
    }
}

/// The labels of the units of a building that are left out.
fn labels_left_out(selection: &Selection, is_of_it: &[bool]) -> Vec<String> {
    let excepted = (0..selection.count()).filter(|i| is_of_it[*i] && !selection.is_meant(*i));
    excepted
        .flat_map(|i| &selection.mentions[i].targets)
        .filter_map(|target| match target {
            Target::Label { label, .. } => Some(label.clone()),
            _ => None,
        })
        .collect()
}

/// `units 2 and 3 have theirs already`: places of one level with `and` between them.
fn is_joined(reading: &Reading<'_>, a: &Mention, b: &Mention) -> bool {
    let mut gap = a.at.end..b.at.start;
    a.level == b.level && !gap.is_empty() && gap.all(|at| reading.class(at) == Some(Class::And))
}

/// `all units of building 4 but 3 and 4`: numbers without a word for their level.
fn bare_exceptions(reading: &Reading<'_>, from: usize) -> Vec<String> {
    (from..reading.lexemes.len())
        .take_while(|at| !reading.is_stop(*at))
        .skip_while(|at| !matches!(reading.class(*at), Some(Class::Not | Class::Except)))
        .skip(1)
        .take_while(|at| is_in_a_list_of_numbers(reading, *at))
        .filter_map(|at| match reading.lex(at) {
            Some(Lex::Number { label, .. }) => Some(label.clone()),
            _ => None,
        })
        .collect()
}

/// Whether a lexeme may be of a list of numbers: one itself, or what parts them.
fn is_in_a_list_of_numbers(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{And, Article, Link, Sign, Toward};
    reading.is_cardinal(at)
        || matches!(
            reading.lex(at),
            Some(Lex::Comma | Lex::Word(Article | And | Sign | Toward | Link, _))
        )
}
