//! Answers requests.

use super::failure::Failure;
use super::json::Json;
use super::request::{Limits, Request, RequestPlaces};
use crate::leg::Memory;
use crate::metric::Metric;
use crate::position::{Position, Snap};
use crate::roads::Roads;
use crate::search::TableMemory;
use crate::tree::Nearest;

/// A network and a profile that answer requests.
///
/// ```
/// use openbench_osm::OsmData;
/// use openbench_routing::osrm::{Limits, Service, ServiceMemory};
/// use openbench_routing::{Metric, Profile, Roads};
///
/// // 222 m of a street along the equator.
/// let map = OsmData::from_xml(
///     br#"<osm version="0.6"><node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.002"/>
///         <way id="7"><nd ref="1"/><nd ref="2"/><tag k="highway" v="footway"/></way></osm>"#,
/// )?;
/// let roads = Roads::read(&map, &Default::default())?;
/// let metric = Metric::new(&roads, Profile::open("foot")?)?;
/// let service = Service { roads, metric, limits: Limits::default() };
/// let answer = service.answer(
///     "/route/v1/foot/0.0005,0;0.0015,0?overview=false",
///     &mut ServiceMemory::default(),
/// );
/// let body: serde_json::Value = serde_json::from_slice(&answer.body)?;
/// assert_eq!((answer.status, &body["code"]), (200, &"Ok".into()));
/// assert_eq!(body["routes"][0]["distance"], 111.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Service {
    /// The network.
    pub roads: Roads,
    /// The profile, customized for the network.
    pub metric: Metric,
    /// The limits of requests.
    pub limits: Limits,
}

/// Memory of answering, one for each thread, which is used again for the next request.
#[derive(Debug, Default)]
pub struct ServiceMemory {
    pub(super) nearest: Nearest,
    pub(super) legs: Memory,
    pub(super) tables: TableMemory,
}

/// A response.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// The HTTP status: 200, or 400 if the body holds a code and a message.
    pub status: u16,
    /// JSON.
    pub body: Vec<u8>,
}

impl Service {
    /// Answers the path and query of an address.
    pub fn answer(&self, target: &str, memory: &mut ServiceMemory) -> Answer {
        let body =
            Request::parse(target, &self.limits).and_then(|request| self.body(&request, memory));
        match body {
            Ok(body) => Answer { status: 200, body },
            Err(failure) => Answer {
                status: 400,
                body: failure.to_json(),
            },
        }
    }

    /// The answer to a request, as JSON.
    ///
    /// # Errors
    /// OSRM's code and message, if there is no answer.
    pub fn body(&self, request: &Request, memory: &mut ServiceMemory) -> Result<Vec<u8>, Failure> {
        match request {
            Request::Route(request) => self.route(request, memory),
            Request::Nearest(request) => self.nearest(request, memory),
            Request::Table(request) => self.table(request, memory),
        }
    }

    /// The positions of each of the places; in a component that contains them all, if there is one.
    pub(super) fn positions(
        &self,
        places: &RequestPlaces,
        memory: &mut Nearest,
    ) -> Result<Vec<Vec<Position>>, Failure> {
        let mut snaps = Vec::with_capacity(places.coordinates.len());
        for (i, (place, options)) in places.coordinates.iter().zip(&places.snap).enumerate() {
            let snap = Snap::new(&self.roads, &self.metric, *place, options, memory);
            if snap.nearest.is_empty() {
                let message = format!("Could not find a matching segment for coordinate {i}");
                return Err(Failure::new("NoSegment", message));
            }
            snaps.push(snap);
        }
        let small = Snap::small_suffices(&snaps, &self.metric);
        Ok(snaps
            .into_iter()
            .map(|snap| snap.into_positions(small))
            .collect())
    }

    /// A place on the network. The members that `more` writes come first.
    pub(super) fn waypoint(
        &self,
        json: &mut Json,
        at: &Position,
        hints: bool,
        more: impl FnOnce(&mut Json),
    ) {
        json.object(|json| {
            more(json);
            if hints {
                // Places are looked up again for each request, so a hint has no content.
                json.key("hint").string("AAAAAAAAAAA=");
            }
            json.key("location").place(at.place);
            json.key("name")
                .string(self.roads.network.name(at.edge).name);
            json.key("distance").decimal(at.away, 6);
        });
    }
}
