//! The service *nearest*: roads near a place.

use super::failure::Failure;
use super::json::Json;
use super::request::NearestRequest;
use super::service::{Service, ServiceMemory};
use crate::position::{Position, several};

impl Service {
    /// Answers *nearest*.
    ///
    /// # Errors
    /// If a place is far from all roads.
    pub fn nearest(
        &self,
        request: &NearestRequest,
        memory: &mut ServiceMemory,
    ) -> Result<Vec<u8>, Failure> {
        let mut found = Vec::new();
        for (place, options) in request.places.coordinates.iter().zip(&request.places.snap) {
            let number = request.number;
            let near = several(
                &self.roads,
                &self.metric,
                *place,
                number,
                options,
                &mut memory.nearest,
            );
            if near.is_empty() {
                return Err(Failure::new(
                    "NoSegment",
                    "Could not find a matching segment for coordinate",
                ));
            }
            found.push(near);
        }
        let mut json = Json::default();
        json.object(|json| {
            json.key("code").string("Ok");
            // As OSRM: a flat array for one coordinate, an array of arrays for several.
            json.key("waypoints").array(|json| match &found[..] {
                [one] => self.near(json, request, one),
                all => all
                    .iter()
                    .for_each(|near| json.array(|json| self.near(json, request, near))),
            });
        });
        Ok(json.into_bytes())
    }

    fn near(&self, json: &mut Json, request: &NearestRequest, near: &[Position]) {
        for at in near {
            let nodes = self.roads.network.edge_nodes(at.edge);
            let segment = at.segment as usize;
            self.waypoint(json, at, request.places.hints, |json| {
                json.key("nodes").array(|json| {
                    nodes
                        .part(segment, segment + 2)
                        .for_each(|node| json.whole(node));
                });
            });
        }
    }
}
