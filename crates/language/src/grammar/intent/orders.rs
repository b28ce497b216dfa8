//! Places that are meant in spite of the words beside them, since these words order the stops.

use super::selection::{Selection, Why};
use crate::grammar::mentions::mention::Mention;
use crate::grammar::negated_order::is_order_after_not;
use crate::grammar::reading::Reading;
use crate::lexicon::class::Class;

/// `从3号楼2单元开始`: not where it comes from, but where to begin.
pub(super) fn allow_where_to_begin(reading: &Reading<'_>, selection: &mut Selection) {
    for i in 0..selection.count() {
        let mention = &selection.mentions[i];
        let is_of_it =
            |next: &&Mention| next.at.start == mention.at.end && next.level != mention.level;
        let next = selection.mentions.get(i + 1).filter(is_of_it);
        let end = next.unwrap_or(mention).at.end;
        let is_elsewhere = selection.left_out[i] == Some(Why::Elsewhere);
        if is_elsewhere && reading.class(end) == Some(Class::First) {
            selection.left_out[i] = None;
        }
    }
}

/// `Don't go to building 3 before building 4`: both are meant.
pub(super) fn allow_what_is_put_in_order(reading: &Reading<'_>, selection: &mut Selection) {
    let sentences = sentences(reading);
    for at in (0..reading.lexemes.len()).filter(|at| is_order_after_not(reading, *at)) {
        let is_beside =
            |i: &usize| sentences.get(selection.mentions[*i].at.start) == sentences.get(at);
        let split = selection
            .mentions
            .partition_point(|mention| mention.at.end <= at);
        // A building and its unit on each side.
        let before: Vec<usize> = (split.saturating_sub(2)..split).filter(is_beside).collect();
        let behind: Vec<usize> = (split..selection.count().min(split + 2))
            .filter(is_beside)
            .collect();
        if !before.is_empty() && !behind.is_empty() {
            for i in before.into_iter().chain(behind) {
                selection.left_out[i] = None;
            }
        }
    }
}

/// The number of each lexeme's sentence.
fn sentences(reading: &Reading<'_>) -> Vec<usize> {
    let mut sentence = 0;
    let mut count = |at: usize| {
        sentence += usize::from(reading.is_stop(at));
        sentence
    };
    (0..reading.lexemes.len()).map(&mut count).collect()
}
