//! From resolved stops to planned deliveries: driving order, steps.

use openbench_core::{Deadline, MapPoint, PlannedDelivery};

use crate::PlanRequest;
use crate::order::{Precedence, UNKNOWN, best_order, order_in_time};
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
    let times = travel_times(request, &stops.stops);
    let precedence = precedence(stops);
    // A stop that is late even if it comes first, or that no route leads to, delays no other.
    let due: Vec<Option<u64>> = stops
        .stops
        .iter()
        .zip(&times[0][1..])
        .map(|(stop, soonest)| due_ms(stop.due).filter(|due| soonest <= due))
        .collect();
    if due.iter().all(Option::is_none) {
        return best_order(&times, &precedence);
    }
    order_in_time(&times, &precedence, &due)
        // Not all can be in time, or there are too many stops for the exact search.
        .unwrap_or_else(|| best_order(&times, &sooner_first(precedence, &stops.stops)))
}

/// A deadline in milliseconds from the start; none for a time of day.
fn due_ms(due: Option<Deadline>) -> Option<u64> {
    match due? {
        Deadline::Within { seconds } => Some(u64::from(seconds) * 1000),
        Deadline::Clock { .. } => None,
    }
}

/// What the instruction asks for, as far as it does not contradict itself.
///
/// The time of day at the start is unknown: what is due at a time of day comes in the order of
/// those times, and before what is due at none.
pub(crate) fn precedence(stops: &Stops) -> Precedence {
    let mut precedence = Precedence::new(stops.stops.len());
    for order in &stops.before {
        // An order that would close a circle with those before it is refused, so the first ones
        // win.
        precedence.add(order.earlier, order.later);
    }
    put_in_order(
        &mut precedence,
        &stops.stops,
        // What is due within a time cannot be compared with a time of day.
        |stop| stop.due.is_none() || due_by_clock(stop).is_some(),
        |stop| Urgency::of(due_of_building(&stops.stops, stop)),
    );
    precedence
}

/// How soon a stop is due, the most urgent first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Urgency {
    /// What is due at no time comes last, so this field is compared first.
    is_open: bool,
    due: Option<Deadline>,
}

impl Urgency {
    fn of(due: Option<Deadline>) -> Self {
        Self {
            is_open: due.is_none(),
            due,
        }
    }
}

fn due_by_clock(stop: &Stop) -> Option<Deadline> {
    stop.due.filter(|due| matches!(due, Deadline::Clock { .. }))
}

/// The soonest time of day at which a door of a stop's building is due: doors of one building are
/// driven to together.
fn due_of_building(stops: &[Stop], stop: &Stop) -> Option<Deadline> {
    let is_same = |other: &&Stop| other.address.building == stop.address.building;
    stops.iter().filter(is_same).filter_map(due_by_clock).min()
}

/// Where not all can be in time, what is due sooner comes first.
fn sooner_first(mut precedence: Precedence, stops: &[Stop]) -> Precedence {
    put_in_order(
        &mut precedence,
        stops,
        |_| true,
        |stop| Urgency::of(stop.due),
    );
    precedence
}

/// Puts more urgent stops before less urgent ones, of those that count and have no problem.
fn put_in_order(
    precedence: &mut Precedence,
    stops: &[Stop],
    counts: impl Fn(&Stop) -> bool,
    urgency: impl Fn(&Stop) -> Urgency,
) {
    let counting: Vec<usize> = (0..stops.len())
        .filter(|i| stops[*i].problem.is_none() && counts(&stops[*i]))
        .collect();
    let urgencies: Vec<Urgency> = stops.iter().map(urgency).collect();
    for earlier in &counting {
        for later in &counting {
            if urgencies[*earlier] < urgencies[*later] {
                // What the instruction orders was added before and wins over deadlines.
                precedence.add(*earlier, *later);
            }
        }
    }
}

/// Deliveries in a given order: a permutation of the stops' indices.
pub(crate) fn in_order(
    request: &PlanRequest<'_>,
    stops: Vec<Stop>,
    order: &[usize],
) -> Vec<PlannedDelivery> {
    order
        .iter()
        .filter_map(|index| Some(delivery(request, *index, stops.get(*index)?)))
        .collect()
}

fn delivery(request: &PlanRequest<'_>, instruction_index: usize, stop: &Stop) -> PlannedDelivery {
    PlannedDelivery {
        instruction_index,
        item: stop.items.join(", "),
        building: stop.address.building.clone(),
        unit: stop.address.unit.clone(),
        levels: stop.levels.clone(),
        steps: steps(request.map, &stop.address, &stop.levels),
        confidence: stop.confidence,
        problem: stop.problem.clone(),
        deadline: stop.due,
    }
}

/// Milliseconds from the start (row and column 0) and each stop to each; [`UNKNOWN`] where the map
/// has no place or the router no route.
pub(crate) fn travel_times(request: &PlanRequest<'_>, stops: &[Stop]) -> Vec<Vec<u64>> {
    let mut places: Vec<MapPoint> = Vec::new();
    let mut index = vec![Some(place_once(&mut places, request.start))];
    for stop in stops {
        // A stop with a problem is not driven to, so its place must not change the order of the
        // others.
        let is_known = stop.problem.is_none();
        let at = is_known
            .then(|| destination(request.map, &stop.address))
            .flatten();
        index.push(at.map(|at| place_once(&mut places, at)));
    }
    let matrix = TimeMatrix {
        seconds: request.times.matrix(&places),
        size: places.len(),
    };
    index
        .iter()
        .map(|from| index.iter().map(|to| matrix.time(*from, *to)).collect())
        .collect()
}

/// Times between places, row by row.
struct TimeMatrix {
    seconds: Vec<f64>,
    /// Number of places.
    size: usize,
}

impl TimeMatrix {
    /// Milliseconds between two places, either of which the map may lack.
    fn time(&self, from: Option<usize>, to: Option<usize>) -> u64 {
        match (from, to) {
            // Not from the router: stops at one place have exactly no time between them, which
            // makes them a group.
            (Some(from), Some(to)) if from == to => 0,
            (Some(from), Some(to)) => self
                .seconds
                // `get`, since the matrix is another crate's and may be too short.
                .get(from * self.size + to)
                .map_or(UNKNOWN, |seconds| milliseconds(*seconds)),
            _ => UNKNOWN,
        }
    }
}

/// The index of a place, which is added unless it is there.
fn place_once(places: &mut Vec<MapPoint>, place: MapPoint) -> usize {
    places
        .iter()
        .position(|known| *known == place)
        .unwrap_or_else(|| {
            places.push(place);
            places.len() - 1
        })
}

fn milliseconds(seconds: f64) -> u64 {
    let is_known = seconds.is_finite() && seconds >= 0.0;
    if is_known {
        // No known time exceeds that of an unknown route.
        libm::round(seconds * 1000.0).min(UNKNOWN as f64) as u64
    } else {
        UNKNOWN
    }
}
