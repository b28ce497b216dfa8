//! Routes in the frame of a map: the multi-level router as agents use it.

use std::sync::{Mutex, PoisonError};

use openbench_core::MapPoint;
use openbench_osm::visitor::Elements;
use openbench_osm::{OsmError, Projection};

use crate::costs::UNITS_PER_SECOND;
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
const SNAP_LIMIT_M: f64 = 1000.0;

/// Why a map cannot be routed on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// The map cannot be read.
    #[error(transparent)]
    Map(#[from] OsmError),
    /// Its junctions have too many turns.
    #[error(transparent)]
    Turns(#[from] TooManyTurns),
}

/// Multi-level routes between points of a map.
///
/// ```
/// use openbench_core::{Georeference, LonLat};
/// use openbench_osm::{OsmData, Projection};
/// use openbench_routing::{MapRouter, Profile, Router};
///
/// // 222 m of a street along the equator.
/// let map = OsmData::from_xml(
///     br#"<osm version="0.6"><node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.002"/>
///         <way id="7"><nd ref="1"/><nd ref="2"/><tag k="highway" v="footway"/>
///         <tag k="name" v="Elm Path"/></way></osm>"#,
/// )?;
/// let projection = Projection::new(Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
/// let [door, shop] = [LonLat::new(0.0005, 0.0), LonLat::new(0.0015, 0.0)].map(|position| {
///     projection.to_map(position)
/// });
/// let router = MapRouter::new(&map, projection, Profile::delivery())?;
/// let route = router.route(door, shop)?;
/// assert!((route.distance - 111.3).abs() < 0.1);
/// // The robot drives 0.5 m/s on footways.
/// assert!((route.duration - 222.6).abs() < 0.1);
/// assert_eq!(route.names, ["Elm Path"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MapRouter {
    roads: Roads,
    metric: Metric,
    projection: Projection,
    memory: Mutex<RouterMemory>,
}

/// Memory of searches, which is used again for the next one.
#[derive(Debug, Default)]
struct RouterMemory {
    nearest: Nearest,
    legs: Memory,
}

impl MapRouter {
    /// Prepares a map for a profile.
    ///
    /// # Errors
    /// If the map is malformed, or its junctions have too many roads.
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

    /// Closes the stretch of road nearest to a place, from junction to junction, because it proved
    /// blocked. Returns whether a road was within `limit` metres.
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
        let snap = Snap::new(
            &self.roads,
            &self.metric,
            place,
            &options,
            &mut memory.nearest,
        );
        // The nearest road itself is blocked, also if it is in a small component.
        let edges: Vec<u32> = snap.nearest.iter().map(|position| position.edge).collect();
        self.metric.set_closed(&self.roads, &edges, true);
        !edges.is_empty()
    }

    /// The positions on the network that may stand for a point.
    fn snap(&self, near: MapPoint, memory: &mut Nearest) -> Result<Snap, RouteError> {
        let options = SnapOptions {
            radius: SNAP_LIMIT_M,
            ..SnapOptions::default()
        };
        let place = Place::new(self.projection.to_lonlat(near));
        let snap = place.map(|p| Snap::new(&self.roads, &self.metric, p, &options, memory));
        snap.filter(|snap| !snap.nearest.is_empty())
            .ok_or(RouteError::NoSegment {
                near,
                limit: SNAP_LIMIT_M,
            })
    }

    /// A leg in the frame of the map.
    fn route_of(&self, leg: &Leg) -> Route {
        let takes = leg.length_and_duration(&self.roads, &self.metric);
        let line = leg.line(&self.roads);
        let points = line
            .points
            .iter()
            .map(|place| self.projection.to_map(place.position()));
        let network = &self.roads.network;
        let names = leg
            .edges
            .iter()
            .map(|directed| network.name(directed / 2).name);
        let mut names: Vec<String> = names
            .filter(|name| !name.is_empty())
            .map(str::to_owned)
            .collect();
        // A road is many edges. It is named again if the route comes back to it.
        names.dedup();
        Route {
            points: points.collect(),
            distance: takes.length,
            duration: f64::from(takes.duration) / UNITS_PER_SECOND,
            names,
        }
    }
}

impl Router for MapRouter {
    fn route(&self, from: MapPoint, to: MapPoint) -> Result<Route, RouteError> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let RouterMemory { nearest, legs } = &mut *memory;
        let ends = [self.snap(from, nearest)?, self.snap(to, nearest)?];
        // Ends in small components move to large ones, unless one small component holds both.
        let small = Snap::small_suffices(&ends, &self.metric);
        let [a, b] = ends.each_ref().map(|end| end.positions(small));
        let leg = Leg::find(&self.roads, &self.metric, a, b, legs);
        leg.map(|leg| self.route_of(&leg))
            .ok_or(RouteError::NoRoute { from, to })
    }
}
