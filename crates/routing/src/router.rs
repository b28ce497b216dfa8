//! Routes in the frame of a map: the multi-level router as agents know it.

use std::sync::{Mutex, PoisonError};

use openbench_core::MapPoint;
use openbench_osm::stream::Elements;
use openbench_osm::{OsmError, Projection};

use crate::geo::Place;
use crate::leg::{Leg, Memory};
use crate::metric::Metric;
use crate::partition::CellSizes;
use crate::position::{Snap, SnapOptions};
use crate::profile::Profile;
use crate::roads::Roads;
use crate::tree::Nearest;
use crate::turns::TooManyTurns;
use crate::{Route, RouteError, Router};

/// How far from a place a road may be, metres.
const SNAP_LIMIT: f64 = 1000.0;

/// Why a map cannot be routed on.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// The map cannot be read.
    #[error(transparent)]
    Map(#[from] OsmError),
    /// Its junctions have too many turns.
    #[error(transparent)]
    Turns(#[from] TooManyTurns),
}

/// Multi-level routes between points of a map.
#[derive(Debug)]
pub struct MapRouter {
    roads: Roads,
    metric: Metric,
    projection: Projection,
    memory: Mutex<(Nearest, Memory)>,
}

impl MapRouter {
    /// Prepares a map for a profile.
    pub fn new(
        map: &impl Elements,
        projection: Projection,
        profile: Profile,
    ) -> Result<Self, PrepareError> {
        let roads = Roads::read(map, &CellSizes::default())?;
        let metric = Metric::new(&roads, profile)?;
        Ok(Self {
            roads,
            metric,
            projection,
            memory: Mutex::default(),
        })
    }

    /// Closes the stretch of road nearest to a place, from junction to junction, as one that proved blocked; whether a
    /// road was within `limit` metres.
    pub fn close(&mut self, near: MapPoint, limit: f64) -> bool {
        let memory = self
            .memory
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        let Some(place) = Place::new(self.projection.to_lonlat(near)) else {
            return false;
        };
        let options = SnapOptions {
            radius: limit,
            ..SnapOptions::default()
        };
        let snap = Snap::new(&self.roads, &self.metric, place, &options, &mut memory.0);
        let edges: Vec<u32> = snap.nearest.iter().map(|position| position.edge).collect();
        self.metric.set_closed(&self.roads, &edges, true);
        !edges.is_empty()
    }

    fn route_from(&self, leg: &Leg) -> Route {
        let (distance, duration) = leg.length_and_duration(&self.roads, &self.metric);
        let points = leg
            .line(&self.roads)
            .points
            .into_iter()
            .map(|place| self.projection.to_map(place.position()));
        let network = &self.roads.network;
        let names = leg
            .edges
            .iter()
            .map(|directed| network.name(directed / 2).name)
            .filter(|name| !name.is_empty());
        let mut names: Vec<String> = names.map(str::to_owned).collect();
        names.dedup();
        Route {
            points: points.collect(),
            distance,
            duration: f64::from(duration) / crate::metric::UNITS,
            names,
        }
    }
}

impl Router for MapRouter {
    fn route(&self, from: MapPoint, to: MapPoint) -> Result<Route, RouteError> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let (nearest, memory) = &mut *memory;
        let near_by = SnapOptions {
            radius: SNAP_LIMIT,
            ..SnapOptions::default()
        };
        let mut snap = |near: MapPoint| {
            let place = Place::new(self.projection.to_lonlat(near));
            let snap = place.map(|p| Snap::new(&self.roads, &self.metric, p, &near_by, nearest));
            snap.filter(|s| !s.nearest.is_empty())
                .ok_or(RouteError::NoSegment {
                    near,
                    limit: SNAP_LIMIT,
                })
        };
        let ends = [snap(from)?, snap(to)?];
        let small = Snap::small_will_do(&ends, &self.metric);
        let [a, b] = ends.each_ref().map(|end| end.positions(small));
        let leg = Leg::find(&self.roads, &self.metric, a, b, memory);
        leg.map(|leg| self.route_from(&leg))
            .ok_or(RouteError::NoRoute { from, to })
    }
}
