//! The service *route*: the route through some places.

use std::ops::Range;

use super::failure::Failure;
use super::json::Json;
use super::request::{Overview, RouteRequest};
use super::segments::Segment;
use super::service::{Service, ServiceMemory};
use super::simplify::simplified;
use super::step::geometry;
use crate::costs::UNITS_PER_SECOND;
use crate::geo::Place;
use crate::leg::{Leg, Line};
use crate::position::Position;
use crate::through::through;

/// A leg with its line.
pub(super) struct DrawnLeg {
    pub(super) leg: Leg,
    pub(super) line: Line,
}

/// The sums over some legs, in the units of the API's fields.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Metres.
    length: f64,
    /// Hundredths of a second.
    duration: u64,
    /// Hundredths of a second.
    weight: u64,
}

impl Service {
    /// Answers *route*.
    ///
    /// # Errors
    /// If there are fewer than two places, a place is far from all roads, or there is no route.
    pub fn route(
        &self,
        request: &RouteRequest,
        memory: &mut ServiceMemory,
    ) -> Result<Vec<u8>, Failure> {
        if request.places.coordinates.len() < 2 {
            let message = "Number of coordinates needs to be at least two.";
            return Err(Failure::new("InvalidOptions", message));
        }
        let positions = self.positions(&request.places, &mut memory.nearest)?;
        // All that can fail is done before the answer begins: JSON is written in one pass.
        let routes = self.routes(request, &positions, memory)?;
        let mut json = Json::default();
        json.object(|json| {
            json.key("code").string("Ok");
            json.key("routes").array(|json| {
                routes
                    .iter()
                    .for_each(|legs| self.one_route(json, request, legs));
            });
            if !request.places.skip_waypoints {
                json.key("waypoints")
                    .array(|json| self.waypoints(json, request, &routes[0]));
            }
        });
        Ok(json.into_bytes())
    }

    /// The route and its alternatives, each as its legs.
    fn routes(
        &self,
        request: &RouteRequest,
        positions: &[Vec<Position>],
        memory: &mut ServiceMemory,
    ) -> Result<Vec<Vec<DrawnLeg>>, Failure> {
        let (roads, metric, memory) = (&self.roads, &self.metric, &mut memory.legs);
        // Alternatives exist between two places only. Other requests that ask for some get the one
        // route.
        if let ([a, b], 1..) = (positions, request.alternatives) {
            let legs = Leg::alternatives(roads, metric, a, b, request.alternatives, memory);
            let routes: Vec<_> = legs.into_iter().map(|leg| vec![self.drawn(leg)]).collect();
            return if routes.is_empty() {
                Err(no_route())
            } else {
                Ok(routes)
            };
        }
        let by_default = metric
            .profile
            .turns()
            .is_some_and(|turns| turns.continue_straight);
        let straight = request.continue_straight.unwrap_or(by_default);
        let legs = through(roads, metric, positions, straight, memory).ok_or_else(no_route)?;
        Ok(vec![legs.into_iter().map(|leg| self.drawn(leg)).collect()])
    }

    fn drawn(&self, leg: Leg) -> DrawnLeg {
        let line = leg.line(&self.roads);
        DrawnLeg { leg, line }
    }

    fn sums(&self, legs: &[DrawnLeg]) -> Sums {
        legs.iter()
            .fold(Sums::default(), |sums, DrawnLeg { leg, .. }| {
                let takes = leg.length_and_duration(&self.roads, &self.metric);
                Sums {
                    length: sums.length + takes.length,
                    duration: sums.duration + u64::from(takes.duration),
                    weight: sums.weight + u64::from(leg.weight),
                }
            })
    }

    fn one_route(&self, json: &mut Json, request: &RouteRequest, legs: &[DrawnLeg]) {
        let sums = self.sums(legs);
        json.object(|json| {
            json.key("legs").array(|json| {
                for range in divided(request, legs.len()) {
                    self.one_leg(json, request, &legs[range]);
                }
            });
            json.key("weight_name").string("duration");
            match request.overview {
                Overview::Simplified => {
                    let lines: Vec<&[Place]> =
                        legs.iter().map(|leg| leg.line.points.as_slice()).collect();
                    geometry(
                        json.key("geometry"),
                        &simplified(&lines),
                        request.geometries,
                    );
                }
                Overview::Full => geometry(json.key("geometry"), &whole(legs), request.geometries),
                Overview::ByLegs | Overview::False => {}
            }
            json.key("weight").seconds(sums.weight);
            json.key("duration").seconds(sums.duration);
            json.key("distance").decimal(sums.length, 1);
        });
    }

    /// Legs between two of the places that divide the route, as one.
    fn one_leg(&self, json: &mut Json, request: &RouteRequest, legs: &[DrawnLeg]) {
        let sums = self.sums(legs);
        let form = request.geometries;
        json.object(|json| {
            json.key("steps").array(|json| {
                if request.steps {
                    legs.iter()
                        .for_each(|leg| self.steps(json, &leg.leg, &leg.line, form));
                }
            });
            json.key("weight").seconds(sums.weight);
            let summary = if request.steps {
                self.summary(legs)
            } else {
                String::new()
            };
            json.key("summary").string(&summary);
            json.key("duration").seconds(sums.duration);
            json.key("distance").decimal(sums.length, 1);
            if request.annotations != Default::default() {
                self.annotation(json, request, legs);
            }
            if request.overview == Overview::ByLegs {
                geometry(json.key("geometry"), &whole(legs), form);
            }
        });
    }

    /// The names of the two roads that are used longest, in the order in which they are met.
    fn summary(&self, legs: &[DrawnLeg]) -> String {
        let mut lengths: Vec<NamedLength> = Vec::new();
        for DrawnLeg { leg, .. } in legs {
            for i in 0..leg.edges.len() {
                let name = self.roads.network.edges[leg.edges[i] as usize / 2].name;
                let length = leg.measures(&self.roads, &self.metric, i).length;
                match lengths.iter_mut().find(|known| known.name == name) {
                    Some(known) => known.length += length,
                    None => lengths.push(NamedLength { name, length }),
                }
            }
        }
        let text = |name: u32| self.roads.network.names.get(name).name;
        // Roads without a name cannot be named in a summary.
        lengths.retain(|named| !text(named.name).is_empty());
        let mut order: Vec<usize> = (0..lengths.len()).collect();
        // The longest two, then back in the order of travel.
        order.sort_by(|a, b| lengths[*b].length.total_cmp(&lengths[*a].length));
        order.truncate(2);
        order.sort_unstable();
        let names: Vec<&str> = order.iter().map(|i| text(lengths[*i].name)).collect();
        names.join(", ")
    }

    fn waypoints(&self, json: &mut Json, request: &RouteRequest, legs: &[DrawnLeg]) {
        let divides = |i: &usize| request.waypoints.is_empty() || request.waypoints.contains(i);
        for i in (0..=legs.len()).filter(divides) {
            let at = match i.checked_sub(1) {
                None => &legs[0].leg.from,
                Some(before) => &legs[before].leg.to,
            };
            self.waypoint(json, at, request.places.hints, |_| {});
        }
    }

    /// What the request asks about every segment.
    fn annotation(&self, json: &mut Json, request: &RouteRequest, legs: &[DrawnLeg]) {
        let asked = request.annotations;
        let segments: Vec<Segment> = legs
            .iter()
            .flat_map(|leg| self.segments(&leg.leg, &leg.line))
            .collect();
        json.key("annotation").object(|json| {
            if asked.datasources {
                json.key("metadata").object(|json| {
                    json.key("datasource_names")
                        .array(|json| json.string(self.metric.profile.name()));
                });
                list(json, "datasources", &segments, |json, _| json.whole(0));
            }
            if asked.weight {
                list(json, "weight", &segments, |json, segment| {
                    json.decimal(segment.weight / UNITS_PER_SECOND, 1);
                });
            }
            if asked.nodes {
                let begin = match segments.first() {
                    Some(segment) => segment.nodes[0],
                    // A leg without length has no segment, but it is at some node.
                    None => self.nodes(&legs[0].leg, 0)[0],
                };
                // Each segment begins at the node where the one before it ends, so one node more
                // than segments is enough.
                json.key("nodes").array(|json| {
                    json.whole(begin);
                    segments
                        .iter()
                        .for_each(|segment| json.whole(segment.nodes[1]));
                });
            }
            if asked.distance {
                list(json, "distance", &segments, |json, segment| {
                    json.decimal(segment.length, 6);
                });
            }
            if asked.duration {
                list(json, "duration", &segments, |json, segment| {
                    json.decimal(segment.duration / UNITS_PER_SECOND, 1);
                });
            }
            if asked.speed {
                list(json, "speed", &segments, |json, segment| {
                    json.decimal(segment.speed(), 1)
                });
            }
        });
    }
}

fn no_route() -> Failure {
    Failure::new("NoRoute", "Impossible route between points")
}

/// Which legs belong together: those between two of the places that divide the route.
fn divided(request: &RouteRequest, legs: usize) -> Vec<Range<usize>> {
    match &request.waypoints[..] {
        [] => (0..legs).map(|leg| leg..leg + 1).collect(),
        dividing => dividing.windows(2).map(|pair| pair[0]..pair[1]).collect(),
    }
}

/// The points of some legs, one after another.
fn whole(legs: &[DrawnLeg]) -> Vec<Place> {
    let mut points: Vec<Place> = legs
        .iter()
        .flat_map(|leg| leg.line.points.iter().copied())
        .collect();
    // A leg begins where the one before it ends.
    points.dedup();
    points
}

/// An array with a value for each segment.
fn list(json: &mut Json, key: &str, segments: &[Segment], write: impl Fn(&mut Json, &Segment)) {
    json.key(key)
        .array(|json| segments.iter().for_each(|segment| write(json, segment)));
}

/// How long a route follows roads of one name.
struct NamedLength {
    /// Number of the name.
    name: u32,
    /// Metres.
    length: f64,
}
