//! Answers to requests.

use super::failure::Failure;
use super::json::Json;
use super::request::{Limits, Places, Request};
use crate::leg::Memory;
use crate::metric::Metric;
use crate::position::{Position, Snap};
use crate::roads::Roads;
use crate::search::TableMemory;
use crate::tree::Nearest;

/// A network and a profile that answer requests.
#[derive(Debug)]
pub struct Service {
    /// The network.
    pub roads: Roads,
    /// The profile's weights.
    pub metric: Metric,
    /// How much may be asked for at once.
    pub limits: Limits,
}

/// Memory of answering, used again for the next request; one for each thread.
#[derive(Debug, Default)]
pub struct ServiceMemory {
    pub(super) nearest: Nearest,
    pub(super) legs: Memory,
    pub(super) tables: TableMemory,
}

/// What is sent back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// HTTP's status: 200, or 400 where the body holds a code and a message.
    pub status: u16,
    /// JSON.
    pub body: Vec<u8>,
}

impl Service {
    /// Answers an address's path and query.
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
    pub fn body(&self, request: &Request, memory: &mut ServiceMemory) -> Result<Vec<u8>, Failure> {
        match request {
            Request::Route(request) => self.route(request, memory),
            Request::Nearest(request) => self.nearest(request, memory),
            Request::Table(request) => self.table(request, memory),
        }
    }

    /// Where each of the places is on the network; in a component that all are in, if there is one.
    pub(super) fn positions(
        &self,
        places: &Places,
        memory: &mut Nearest,
    ) -> Result<Vec<Vec<Position>>, Failure> {
        let mut snaps = Vec::with_capacity(places.places.len());
        for (i, (place, options)) in places.places.iter().zip(&places.snap).enumerate() {
            let snap = Snap::new(&self.roads, &self.metric, *place, options, memory);
            if snap.nearest.is_empty() {
                let message = format!("Could not find a matching segment for coordinate {i}");
                return Err(Failure::new("NoSegment", message));
            }
            snaps.push(snap);
        }
        let small = Snap::small_will_do(&snaps, &self.metric);
        Ok(snaps
            .into_iter()
            .map(|snap| snap.into_positions(small))
            .collect())
    }

    /// A place on the network; `more` are members that stand first.
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
                // Places are looked up again each time; a hint says nothing.
                json.key("hint").string("AAAAAAAAAAA=");
            }
            json.key("location").place(at.place);
            json.key("name")
                .string(self.roads.network.name(at.edge).name);
            json.key("distance").decimal(at.away, 6);
        });
    }
}
