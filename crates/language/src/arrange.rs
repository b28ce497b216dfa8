//! From resolved stops to planned deliveries: driving order, steps.

use openbench_core::{MapPoint, PlannedDelivery};

use crate::PlanRequest;
use crate::order::{Precedence, UNKNOWN, best_order};
use crate::resolve::{Stop, Stops};
use crate::steps::{destination, steps};

/// Deliveries in the best order that the instruction allows.
pub(crate) fn arrange(request: &PlanRequest<'_>, stops: Stops) -> Vec<PlannedDelivery> {
    let order = shortest(request, &stops);
    in_order(request, stops.stops, &order)
}

/// The best order that the instruction allows: a permutation of the stops' indices.
pub(crate) fn shortest(request: &PlanRequest<'_>, stops: &Stops) -> Vec<usize> {
    if stops.stops.len() < 2 {
        return (0..stops.stops.len()).collect();
    }
    best_order(&travel_times(request, &stops.stops), &precedence(stops))
}

/// What the instruction asks for, as far as it does not contradict itself.
pub(crate) fn precedence(stops: &Stops) -> Precedence {
    let mut precedence = Precedence::new(stops.stops.len());
    for (earlier, later) in &stops.before {
        precedence.add(*earlier, *later);
    }
    precedence
}

/// Deliveries in a given order: a permutation of the stops' indices.
pub(crate) fn in_order(request: &PlanRequest<'_>, stops: Vec<Stop>, order: &[usize]) -> Vec<PlannedDelivery> {
    let delivery = |index: &usize| {
        let stop = stops.get(*index)?;
        Some(PlannedDelivery {
            instruction_index: *index,
            item: stop.items.join(", "),
            building: stop.address.building.clone(),
            unit: stop.address.unit.clone(),
            steps: steps(request.map, &stop.address),
            problem: stop.problem.clone(),
        })
    };
    order.iter().filter_map(delivery).collect()
}

/// Milliseconds from the start (row and column 0) and each stop to each; [`UNKNOWN`] where the map or the router knows none.
pub(crate) fn travel_times(request: &PlanRequest<'_>, stops: &[Stop]) -> Vec<Vec<u64>> {
    let at: Vec<Option<MapPoint>> =
        std::iter::once(Some(request.start))
            .chain(stops.iter().map(|stop| {
                stop.problem.is_none().then(|| destination(request.map, &stop.address)).flatten()
            }))
            .collect();
    let mut places: Vec<MapPoint> = Vec::new();
    let index: Vec<Option<usize>> = at
        .into_iter()
        .map(|point| {
            let point = point?;
            let known = places.iter().position(|p| *p == point);
            Some(known.unwrap_or_else(|| {
                places.push(point);
                places.len() - 1
            }))
        })
        .collect();
    let seconds = request.times.matrix(&places);
    let time = |from: Option<usize>, to: Option<usize>| match (from, to) {
        (Some(from), Some(to)) if from == to => 0,
        (Some(from), Some(to)) => seconds.get(from * places.len() + to).map_or(UNKNOWN, |s| milliseconds(*s)),
        _ => UNKNOWN,
    };
    index.iter().map(|from| index.iter().map(|to| time(*from, *to)).collect()).collect()
}

fn milliseconds(seconds: f64) -> u64 {
    let known = seconds.is_finite() && seconds >= 0.0;
    if known { libm::round(seconds * 1000.0).min(UNKNOWN as f64) as u64 } else { UNKNOWN }
}
