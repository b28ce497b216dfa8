//! What the grammar reads of doors that a model lists: which building of one name, orders,
//! deadlines, floors, doubts.

use crate::resolve::{Stop, Stops};
use crate::wish::Precedes;

/// Of several buildings of one name the one that the grammar reads, by the street or quarter that
/// is said beside it.
pub(super) fn adopt_places(stops: &mut Stops, read: &Stops) {
    let mut taken = vec![false; read.stops.len()];
    for stop in stops.stops.iter_mut().filter(|stop| stop.problem.is_some()) {
        let free = (0..taken.len()).find(|i| !taken[*i] && is_narrower(&read.stops[*i], stop));
        if let Some(at) = free {
            // Each door of the grammar once: two buildings of one name may both be meant.
            taken[at] = true;
            let read = &read.stops[at];
            stop.address = read.address.clone();
            stop.problem.clone_from(&read.problem);
            stop.confidence = read.confidence;
        }
    }
}

/// Whether a stop is the same door as another one, with its building disambiguated.
fn is_narrower(read: &Stop, stop: &Stop) -> bool {
    let rest = read.address.building.strip_prefix(&stop.address.building);
    rest.is_some_and(|rest| rest.starts_with(", ")) && read.address.unit == stop.address.unit
}

/// Orders, deadlines, levels and doubts as the grammar reads them.
pub(super) fn adopt_rest(stops: &mut Stops, read: &Stops) {
    for stop in &mut stops.stops {
        adopt_doubt(stop, read);
    }
    for stop in &mut stops.stops {
        adopt_details(stop, read);
    }
    stops.before = orders(stops, read);
}

/// What the grammar doubts that the sender said stays in doubt, however sure the model is.
fn adopt_doubt(stop: &mut Stop, read: &Stops) {
    let doubtful = read
        .stops
        .iter()
        .find(|read| read.is_doubtful() && read.address.building == stop.address.building);
    let is_sure = read
        .stops
        .iter()
        .any(|read| !read.is_doubtful() && read.address.same_door(&stop.address));
    if let Some(doubtful) = doubtful.filter(|_| !is_sure) {
        stop.problem.clone_from(&doubtful.problem);
    }
}

/// Until when, on which floor, and how surely that building.
fn adopt_details(stop: &mut Stop, read: &Stops) {
    let same = read
        .stops
        .iter()
        .find(|read| read.address.same_door(&stop.address));
    let Some(same) = same else { return };
    stop.due = same.due;
    stop.levels.clone_from(&same.levels);
    stop.confidence = stop.confidence.min(same.confidence);
}

/// The orders among some stops that the grammar reads.
fn orders(stops: &Stops, read: &Stops) -> Vec<Precedes> {
    read.before
        .iter()
        .filter_map(|order| {
            Some(Precedes {
                earlier: same_door(stops, &read.stops[order.earlier])?,
                later: same_door(stops, &read.stops[order.later])?,
            })
        })
        .collect()
}

/// The index of the first stop at the door of another one.
fn same_door(stops: &Stops, of: &Stop) -> Option<usize> {
    stops
        .stops
        .iter()
        .position(|stop| stop.address.same_door(&of.address))
}
