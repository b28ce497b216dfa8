//! Turn-by-turn instructions as JSON.

use super::json::Json;
use super::polyline;
use super::request::Geometries;
use super::service::Service;
use crate::geo::Place;
use crate::guidance::{Guide, Step};
use crate::leg::{Leg, Line};

/// A line in the format of a request.
pub(super) fn geometry(json: &mut Json, points: &[Place], form: Geometries) {
    // A line has two points even if it has no length.
    let doubled = [points[0]; 2];
    let points = if points.len() == 1 { &doubled } else { points };
    match form {
        Geometries::Polyline => json.string(&polyline::encode(points, 5)),
        Geometries::Polyline6 => json.string(&polyline::encode(points, 6)),
        Geometries::GeoJson => json.object(|json| {
            json.key("coordinates")
                .array(|json| points.iter().for_each(|point| json.place(*point)));
            json.key("type").string("LineString");
        }),
    }
}

/// A bearing from 0 to 359 degrees.
fn degrees(bearing: f64) -> i64 {
    libm::round(bearing) as i64 % 360
}

impl Service {
    pub(super) fn steps(&self, json: &mut Json, leg: &Leg, line: &Line, form: Geometries) {
        let guide = Guide {
            roads: &self.roads,
            metric: &self.metric,
        };
        for step in guide.steps(leg, line) {
            self.step(json, &guide, leg, line, &step, form);
        }
    }

    fn step(
        &self,
        json: &mut Json,
        guide: &Guide<'_>,
        leg: &Leg,
        line: &Line,
        step: &Step,
        form: Geometries,
    ) {
        let points = line.part(step.edges.clone());
        // The arrival is on the last edge.
        let edge = leg.edges[step.edges.start.min(leg.edges.len() - 1)] / 2;
        let name = self.roads.network.name(edge);
        json.object(|json| {
            json.key("intersections")
                .array(|json| self.intersections(json, guide, leg, step, points));
            json.key("driving_side")
                .string(match self.metric.profile.turns() {
                    Some(turns) if !turns.right_hand => "left",
                    _ => "right",
                });
            geometry(json.key("geometry"), points, form);
            json.key("maneuver").object(|json| {
                json.key("bearing_after").whole(degrees(step.bearings[1]));
                json.key("bearing_before").whole(degrees(step.bearings[0]));
                json.key("location").place(points[0]);
                if let Some(modifier) = step.modifier {
                    json.key("modifier").string(modifier);
                }
                if let Some(exit) = step.exit {
                    json.key("exit").whole(exit as i64);
                }
                json.key("type").string(step.kind.word());
            });
            json.key("name").string(name.name);
            if !name.reference.is_empty() {
                json.key("ref").string(name.reference);
            }
            json.key("mode").string(self.mode(edge));
            json.key("weight").seconds(step.measures.weight.into());
            json.key("duration").seconds(step.measures.duration.into());
            json.key("distance").decimal(step.measures.length, 1);
        });
    }

    fn mode(&self, edge: u32) -> &'static str {
        let network = &self.roads.network;
        match network
            .way_tags
            .is(network.edges[edge as usize].class, "route", "ferry")
        {
            true => "ferry",
            false if self.metric.profile.turns().is_some() => "driving",
            false => "walking",
        }
    }

    /// The begin of the step, and the junctions that are passed in it.
    fn intersections(
        &self,
        json: &mut Json,
        guide: &Guide<'_>,
        leg: &Leg,
        step: &Step,
        points: &[Place],
    ) {
        let network = &self.roads.network;
        let end = |json: &mut Json, bearing: f64, word: &str| {
            json.object(|json| {
                json.key(word).whole(0);
                json.key("entry").array(|json| json.boolean(true));
                json.key("bearings")
                    .array(|json| json.whole(degrees(bearing)));
                json.key("location").place(points[0]);
            });
        };
        if step.edges.is_empty() {
            // Bearings of an intersection point away from it. The road of arrival is seen
            // backwards.
            return end(json, step.bearings[0] + 180.0, "in");
        }
        for i in step.edges.clone() {
            if i == 0 {
                end(json, step.bearings[1], "out");
                continue;
            }
            let [from, to] = [leg.edges[i - 1], leg.edges[i]];
            let vertex = network.ends(to)[0];
            let mut exits: Vec<_> = guide.exits(vertex).collect();
            // An edge that ends where it begins is no arc.
            for directed in [to, from ^ 1] {
                if exits.iter().all(|exit| exit.directed != directed) {
                    exits.push(guide.exit(directed));
                }
            }
            // Where only two edges meet there is nothing to decide: no intersection. The maneuver's
            // own place is always one.
            if i > step.edges.start && exits.len() < 3 {
                continue;
            }
            exits.sort_by(|a, b| a.bearing.total_cmp(&b.bearing));
            let position = |directed: u32| exits.iter().position(|exit| exit.directed == directed);
            json.object(|json| {
                if let Some(out) = position(to) {
                    json.key("out").whole(out as i64);
                }
                if let Some(back) = position(from ^ 1) {
                    json.key("in").whole(back as i64);
                }
                json.key("entry").array(|json| {
                    exits.iter().for_each(|exit| {
                        json.boolean(
                            // The way back may not be entered, unless the route itself turns round.
                            exit.open && (exit.directed != from ^ 1 || exit.directed == to),
                        )
                    });
                });
                json.key("bearings").array(|json| {
                    exits
                        .iter()
                        .for_each(|exit| json.whole(degrees(exit.bearing)))
                });
                json.key("location")
                    .place(network.vertices[vertex as usize]);
            });
        }
    }
}
