//! The way through some places.

use std::ops::Range;

use super::failure::Failure;
use super::json::Json;
use super::request::{Overview, RouteRequest};
use super::service::{Service, ServiceMemory};
use super::simplify::simplified;
use super::step::geometry;
use crate::geo::{Place, distance};
use crate::leg::{Leg, Line, Measures};
use crate::metric::UNITS;
use crate::position::Position;
use crate::through::through;

/// Legs with their lines.
type Way = Vec<(Leg, Line)>;

impl Service {
    /// Answers *route*.
    pub fn route(
        &self,
        request: &RouteRequest,
        memory: &mut ServiceMemory,
    ) -> Result<Vec<u8>, Failure> {
        if request.places.places.len() < 2 {
            return Err(Failure::new(
                "InvalidOptions",
                "Number of coordinates needs to be at least two.",
            ));
        }
        let positions = self.positions(&request.places, &mut memory.nearest)?;
        let routes = self.ways(request, &positions, memory)?;
        let mut json = Json::default();
        json.object(|json| {
            json.key("code").string("Ok");
            json.key("routes")
                .array(|json| routes.iter().for_each(|way| self.way(json, request, way)));
            if !request.places.skip_waypoints {
                json.key("waypoints")
                    .array(|json| self.waypoints(json, request, &positions, &routes[0]));
            }
        });
        Ok(json.into_bytes())
    }

    fn ways(
        &self,
        request: &RouteRequest,
        positions: &[Vec<Position>],
        memory: &mut ServiceMemory,
    ) -> Result<Vec<Way>, Failure> {
        let with_line = |leg: Leg| {
            let line = leg.line(&self.roads);
            (leg, line)
        };
        let none = || Failure::new("NoRoute", "Impossible route between points");
        let (roads, metric, memory) = (&self.roads, &self.metric, &mut memory.legs);
        if let ([a, b], 1..) = (positions, request.alternatives) {
            let legs = Leg::alternatives(roads, metric, a, b, request.alternatives, memory);
            let ways: Vec<Way> = legs.into_iter().map(|leg| vec![with_line(leg)]).collect();
            return if ways.is_empty() {
                Err(none())
            } else {
                Ok(ways)
            };
        }
        let straight = metric
            .profile
            .turns()
            .is_some_and(|turns| turns.continue_straight);
        let straight = request.continue_straight.unwrap_or(straight);
        let legs = through(roads, metric, positions, straight, memory).ok_or_else(none)?;
        Ok(vec![legs.into_iter().map(with_line).collect()])
    }

    /// Which legs belong together: those between two of the places that divide legs.
    fn divided(request: &RouteRequest, legs: usize) -> Vec<Range<usize>> {
        match &request.waypoints[..] {
            [] => (0..legs).map(|leg| leg..leg + 1).collect(),
            dividing => dividing.windows(2).map(|pair| pair[0]..pair[1]).collect(),
        }
    }

    fn measures<'a>(&self, legs: impl Iterator<Item = &'a (Leg, Line)>) -> (f64, u64, u64) {
        legs.fold((0.0, 0, 0), |(length, duration, weight), (leg, _)| {
            let (metres, time) = leg.length_and_duration(&self.roads, &self.metric);
            (
                length + metres,
                duration + u64::from(time),
                weight + u64::from(leg.weight),
            )
        })
    }

    fn way(&self, json: &mut Json, request: &RouteRequest, way: &Way) {
        let (length, duration, weight) = self.measures(way.iter());
        json.object(|json| {
            json.key("legs").array(|json| {
                for legs in Self::divided(request, way.len()) {
                    self.leg(json, request, &way[legs.clone()]);
                }
            });
            json.key("weight_name").string("duration");
            match request.overview {
                Overview::Simplified => {
                    let lines: Vec<&[Place]> =
                        way.iter().map(|(_, line)| line.points.as_slice()).collect();
                    geometry(
                        json.key("geometry"),
                        &simplified(&lines),
                        request.geometries,
                    )
                }
                Overview::Full => geometry(json.key("geometry"), &whole(way), request.geometries),
                Overview::ByLegs | Overview::False => {}
            }
            json.key("weight").seconds(weight);
            json.key("duration").seconds(duration);
            json.key("distance").decimal(length, 1);
        });
    }

    fn leg(&self, json: &mut Json, request: &RouteRequest, legs: &[(Leg, Line)]) {
        let (length, duration, weight) = self.measures(legs.iter());
        let form = request.geometries;
        json.object(|json| {
            json.key("steps").array(|json| {
                legs.iter()
                    .filter(|_| request.steps)
                    .for_each(|(leg, line)| self.steps(json, leg, line, form));
            });
            json.key("weight").seconds(weight);
            json.key("summary").string(&if request.steps {
                self.summary(legs)
            } else {
                String::new()
            });
            json.key("duration").seconds(duration);
            json.key("distance").decimal(length, 1);
            if request.annotations != Default::default() {
                self.annotation(json, request, legs);
            }
            if request.overview == Overview::ByLegs {
                geometry(json.key("geometry"), &whole(legs), form);
            }
        });
    }

    /// The two names that are longest on the way, in the order in which they are met.
    fn summary(&self, legs: &[(Leg, Line)]) -> String {
        let mut names: Vec<(u32, f64)> = Vec::new();
        for (leg, _) in legs {
            for i in 0..leg.edges.len() {
                let name = self.roads.network.edges[leg.edges[i] as usize / 2].name;
                let length = leg.measures(&self.roads, &self.metric, i).length;
                match names.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, sum)) => *sum += length,
                    None => names.push((name, length)),
                }
            }
        }
        let text = |name: u32| self.roads.network.names.get(name).name;
        let mut named: Vec<(usize, (u32, f64))> = names
            .into_iter()
            .enumerate()
            .filter(|(_, (name, _))| !text(*name).is_empty())
            .collect();
        named.sort_by(|a, b| b.1.1.total_cmp(&a.1.1));
        named.truncate(2);
        named.sort_by_key(|(place, _)| *place);
        let words: Vec<&str> = named.iter().map(|(_, (name, _))| text(*name)).collect();
        words.join(", ")
    }

    fn waypoints(
        &self,
        json: &mut Json,
        request: &RouteRequest,
        positions: &[Vec<Position>],
        way: &Way,
    ) {
        let divides = |i: &usize| request.waypoints.is_empty() || request.waypoints.contains(i);
        for i in (0..positions.len()).filter(divides) {
            let at = match i.checked_sub(1) {
                None => &way[0].0.from,
                Some(before) => &way[before].0.to,
            };
            self.waypoint(json, at, request.places.hints, |_| {});
        }
    }

    /// What is asked about every segment.
    fn annotation(&self, json: &mut Json, request: &RouteRequest, legs: &[(Leg, Line)]) {
        let asked = request.annotations;
        let segments: Vec<Segment> = legs
            .iter()
            .flat_map(|(leg, line)| self.segments(leg, line))
            .collect();
        let list = |json: &mut Json, key: &str, write: &dyn Fn(&mut Json, &Segment)| {
            json.key(key)
                .array(|json| segments.iter().for_each(|segment| write(json, segment)));
        };
        json.key("annotation").object(|json| {
            if asked.datasources {
                json.key("metadata").object(|json| {
                    json.key("datasource_names")
                        .array(|json| json.string(self.metric.profile.name()));
                });
                list(json, "datasources", &|json, _| json.whole(0));
            }
            if asked.weight {
                list(json, "weight", &|json, s| json.decimal(s.weight / UNITS, 1));
            }
            if asked.nodes {
                let (leg, _) = &legs[0];
                let begins = segments
                    .first()
                    .map_or_else(|| self.nodes(leg, 0)[0], |segment| segment.nodes[0]);
                json.key("nodes").array(|json| {
                    json.whole(begins);
                    segments
                        .iter()
                        .for_each(|segment| json.whole(segment.nodes[1]));
                });
            }
            if asked.distance {
                list(json, "distance", &|json, s| json.decimal(s.length, 6));
            }
            if asked.duration {
                list(json, "duration", &|json, s| {
                    json.decimal(s.duration / UNITS, 1)
                });
            }
            if asked.speed {
                let speed = |s: &Segment| {
                    if s.duration > 0.0 {
                        s.length / s.duration * UNITS
                    } else {
                        0.0
                    }
                };
                list(json, "speed", &|json, s| json.decimal(speed(s), 1));
            }
        });
    }

    /// The segments of a leg: what its edges take, by length.
    fn segments(&self, leg: &Leg, line: &Line) -> Vec<Segment> {
        let mut segments = Vec::new();
        for (i, &directed) in leg.edges.iter().enumerate() {
            let points = line.part(i..i + 1);
            let Measures {
                length,
                duration,
                weight,
            } = leg.measures(&self.roads, &self.metric, i);
            let next = leg.edges.get(i + 1);
            let passed = next.map_or([0, 0], |next| {
                self.metric.passing(&self.roads, directed, *next)
            });
            let entry = i.checked_sub(1).map_or(0, |i| {
                self.metric
                    .entry_weight(&self.roads, leg.edges[i], directed)
            });
            let nodes = self.nodes(leg, i);
            for (pair, ids) in points.windows(2).zip(nodes.windows(2)) {
                let metres = distance(pair[0], pair[1]);
                let share = if length > 0.0 { metres / length } else { 0.0 };
                segments.push(Segment {
                    length: metres,
                    duration: f64::from(duration - passed[0]) * share,
                    weight: f64::from(weight - passed[1] - entry) * share,
                    nodes: [ids[0], ids[1]],
                });
            }
        }
        segments
    }

    /// The OSM nodes of the part of an edge that is travelled, one for each of its points: in the middle of a segment that is travelled in part, the
    /// node at its far end.
    fn nodes(&self, leg: &Leg, index: usize) -> Vec<i64> {
        let directed = leg.edges[index];
        let (places, all) = (
            self.roads.network.edge_points(directed / 2),
            self.roads.network.edge_nodes(directed / 2),
        );
        let forward = directed.is_multiple_of(2);
        let (begins, ends) = (index == 0, index + 1 == leg.edges.len());
        let [a, b] = if forward {
            [&leg.from, &leg.to]
        } else {
            [&leg.to, &leg.from]
        };
        let [first_here, last_here] = if forward {
            [begins, ends]
        } else {
            [ends, begins]
        };
        let mut along: Vec<(Place, i64)> = Vec::new();
        // As lines have it: of points in one place the first one stays, and the node of a place between two nodes is overwritten by a real one.
        let mut push = |place: Place, node: i64, real: bool| match along.last_mut() {
            Some(last) if last.0 == place => {
                if real {
                    last.1 = node;
                }
            }
            _ => along.push((place, node)),
        };
        let first = if first_here {
            a.segment as usize + 1
        } else {
            0
        };
        let last = if last_here {
            b.segment as usize + 1
        } else {
            all.len()
        };
        if first_here {
            push(a.place, all.at(a.segment as usize), false);
        }
        for i in first..last.max(first) {
            push(places.at(i), all.at(i), true);
        }
        if last_here {
            push(b.place, all.at(b.segment as usize + 1), false);
        }
        let mut nodes: Vec<i64> = along.into_iter().map(|(_, node)| node).collect();
        if !forward {
            nodes.reverse();
        }
        nodes
    }
}

/// The points of some legs, one after another.
fn whole(legs: &[(Leg, Line)]) -> Vec<Place> {
    let mut points: Vec<Place> = legs
        .iter()
        .flat_map(|(_, line)| line.points.iter().copied())
        .collect();
    points.dedup();
    points
}

/// A segment that is travelled.
#[derive(Debug, Clone, Copy)]
struct Segment {
    length: f64,
    /// Hundredths of a second.
    duration: f64,
    weight: f64,
    nodes: [i64; 2],
}
