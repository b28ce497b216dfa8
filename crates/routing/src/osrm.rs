//! Answers in the words of OSRM's HTTP API, version 1 (*route* service): codes, waypoints, legs, GeoJSON geometry.
//! Steps and annotations are left empty.

use openbench_core::LonLat;
use openbench_osm::Projection;
use serde::Serialize;

use crate::{Route, RouteError, Router};

/// The answer to a route request.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RouteResponse {
    /// `Ok`, `NoSegment`, `NoRoute` or `InvalidQuery`.
    pub code: &'static str,
    /// What went wrong, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// The routes found, best first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub routes: Vec<RouteObject>,
    /// The places asked for, on the network.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub waypoints: Vec<Waypoint>,
}

/// A route.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RouteObject {
    /// Metres.
    pub distance: f64,
    /// Seconds.
    pub duration: f64,
    /// Seconds.
    pub weight: f64,
    /// What the weight counts.
    pub weight_name: &'static str,
    /// The line, GeoJSON.
    pub geometry: LineString,
    /// One leg between each two places.
    pub legs: Vec<Leg>,
}

/// A GeoJSON line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LineString {
    /// Always `LineString`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Longitude and latitude.
    pub coordinates: Vec<[f64; 2]>,
}

/// The part of a route between two of the places.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Leg {
    /// Metres.
    pub distance: f64,
    /// Seconds.
    pub duration: f64,
    /// Seconds.
    pub weight: f64,
    /// Names of the roads.
    pub summary: String,
    /// Left empty.
    pub steps: Vec<()>,
}

/// A place on the network.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Waypoint {
    /// Name of the road, if it has one.
    pub name: String,
    /// Longitude and latitude.
    pub location: [f64; 2],
    /// Metres from the place that was asked for.
    pub distance: f64,
}

/// The route through all of `places`, in order.
pub fn route(router: &impl Router, projection: &Projection, places: &[LonLat]) -> RouteResponse {
    if places.len() < 2 {
        return failure("InvalidQuery", "a route needs two places or more".into());
    }
    let points: Vec<_> = places.iter().map(|p| projection.to_map(*p)).collect();
    let legs: Result<Vec<Route>, RouteError> = points.windows(2).map(|w| router.route(w[0], w[1])).collect();
    match legs {
        Ok(legs) => success(projection, &points, &legs),
        Err(error @ RouteError::NoSegment { .. }) => failure("NoSegment", error.to_string()),
        Err(error @ RouteError::NoRoute { .. }) => failure("NoRoute", error.to_string()),
    }
}

fn failure(code: &'static str, message: String) -> RouteResponse {
    RouteResponse { code, message: Some(message), routes: Vec::new(), waypoints: Vec::new() }
}

fn success(projection: &Projection, asked: &[openbench_core::MapPoint], legs: &[Route]) -> RouteResponse {
    let rounded = |v: f64, digits: f64| libm::round(v * digits) / digits;
    let location = |p: openbench_core::MapPoint| {
        let at = projection.to_lonlat(p);
        [rounded(at.lon, 1e6), rounded(at.lat, 1e6)]
    };
    let mut coordinates: Vec<[f64; 2]> = legs.iter().flat_map(|l| &l.points).map(|p| location(*p)).collect();
    coordinates.dedup();
    let starts = legs.iter().filter_map(|l| Some((*l.points.first()?, l.names.first())));
    let end = legs.last().and_then(|l| Some((*l.points.last()?, l.names.last())));
    let waypoint =
        |((at, name), asked): ((openbench_core::MapPoint, Option<&String>), &openbench_core::MapPoint)| {
            Waypoint {
                name: name.cloned().unwrap_or_default(),
                location: location(at),
                distance: rounded(at.distance(*asked), 10.0),
            }
        };
    let waypoints = starts.chain(end).zip(asked).map(waypoint).collect();
    let total = |f: fn(&Route) -> f64| rounded(legs.iter().map(f).sum(), 10.0);
    let leg = |l: &Route| Leg {
        distance: rounded(l.distance, 10.0),
        duration: rounded(l.duration, 10.0),
        weight: rounded(l.duration, 10.0),
        summary: l.names.join(", "),
        steps: Vec::new(),
    };
    let route = RouteObject {
        distance: total(|l| l.distance),
        duration: total(|l| l.duration),
        weight: total(|l| l.duration),
        weight_name: "duration",
        geometry: LineString { kind: "LineString", coordinates },
        legs: legs.iter().map(leg).collect(),
    };
    RouteResponse { code: "Ok", message: None, routes: vec![route], waypoints }
}
