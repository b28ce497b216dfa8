//! Routes on the OpenStreetMap road network: multi-level Dijkstra, embedded, from any extract.
//!
//! After D. Delling, A. Goldberg, T. Pajor, R. Werneck, *Customizable Route Planning in Road Networks*, Transportation Science 2017: what takes long is done
//! once for a map, what a profile asks for in some hundredths of a second for a city, and a road that closes in less. Contraction hierarchies answer
//! two to four times faster (`benchmarks/routing`), and are not the aim: they need their preparation again when weights change, or know no turns.
//!
//! ```no_run
//! use openbench_core::LonLat;
//! use openbench_osm::stream::Source;
//! use openbench_routing::osrm::{Limits, Request, Service, ServiceMemory};
//! use openbench_routing::{Metric, Profile, Roads};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let map = Source::open("city.osm.pbf".as_ref())?;
//! let roads = Roads::read(&map, &Default::default())?;
//! let metric = Metric::new(&roads, Profile::open("delivery")?)?;
//! let service = Service { roads, metric, limits: Limits::default() };
//! let answer = service.answer("/route/v1/any/7.4197,43.7314;7.4246,43.7387?steps=true", &mut ServiceMemory::default());
//! println!("{}", String::from_utf8_lossy(&answer.body));
//! # Ok(())
//! # }
//! ```
//!
//! | module | its one job |
//! |---|---|
//! | [`profile`] | [`Profile`]: who may go where, how fast and how gladly |
//! | [`network`] | vertices and edges of a map, whoever travels |
//! | [`partition`] | vertices in cells, and these in larger cells |
//! | [`roads`] | [`Roads`]: a network in cells |
//! | [`overlay`] | layers of cells over a graph, and the ways through them |
//! | [`metric`] | [`Metric`]: what travelling counts as for a profile |
//! | [`turns`] | the graph of turns, for profiles to whom they matter |
//! | `restrictions` | turns that are not allowed |
//! | [`search`] | searches over layers: a way, other ways, tables |
//! | [`tree`], [`position`] | segments near a place, and where it is on the network |
//! | [`components`] | what hangs together |
//! | [`leg`] | the way from one place to another |
//! | [`mod@through`] | the way through several places |
//! | [`guidance`] | where to turn |
//! | [`router`] | [`MapRouter`]: routes in the frame of a map |
//! | [`osrm`] | answers in the words of OSRM's HTTP API, version 1 |
//! | [`store`] | graph files |
//! | [`geo`] | places and distances |
//!
//! [`Router`] is the seam to agents.

pub mod bearings;
pub mod components;
pub mod costs;
pub mod geo;
pub mod guidance;
pub mod leg;
pub mod metric;
pub mod network;
pub mod osrm;
pub mod overlay;
pub mod partition;
pub mod position;
pub mod profile;
mod restrictions;
pub mod roads;
pub mod router;
pub mod search;
pub mod store;
pub mod through;
pub mod tree;
pub mod turns;

use openbench_core::{MapPoint, TravelTimes};

pub use metric::Metric;
pub use profile::{Profile, ProfileError};
pub use roads::Roads;
pub use router::{MapRouter, PrepareError};

/// A way over roads.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// From the place on the network nearest to the start to the one nearest to the goal.
    pub points: Vec<MapPoint>,
    /// Length over roads, metres.
    pub distance: f64,
    /// Time over roads, seconds.
    pub duration: f64,
    /// Names of the roads, in order, without repetition; unnamed ones are left out.
    pub names: Vec<String>,
}

/// Why there is no route.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RouteError {
    /// No road that the profile may use is near.
    #[error("no road for this profile within {limit:.0} m of {near}")]
    NoSegment {
        /// The place that was asked for.
        near: MapPoint,
        /// How far roads were looked for, metres.
        limit: f64,
    },
    /// The two places do not hang together.
    #[error("no route from {from} to {to}")]
    NoRoute {
        /// Start.
        from: MapPoint,
        /// Goal.
        to: MapPoint,
    },
}

/// Finds routes.
pub trait Router {
    /// The fastest route between the places on the network nearest to `from` and `to`.
    fn route(&self, from: MapPoint, to: MapPoint) -> Result<Route, RouteError>;
}

/// Travel times for planning: over roads where there are some, on foot across open ground for the rest.
#[derive(Debug, Clone, Copy)]
pub struct RouterTimes<'a, R> {
    /// The router.
    pub router: &'a R,
    /// Speed off the network, m/s.
    pub speed: f64,
}

impl<R: Router> TravelTimes for RouterTimes<'_, R> {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        let pairs = places
            .iter()
            .flat_map(|a| places.iter().map(move |b| (*a, *b)));
        pairs.map(|(a, b)| self.between(a, b)).collect()
    }
}

impl<R: Router> RouterTimes<'_, R> {
    fn between(&self, a: MapPoint, b: MapPoint) -> f64 {
        let direct = a.distance(b) / self.speed;
        let Ok(route) = self.router.route(a, b) else {
            return direct;
        };
        let (Some(first), Some(last)) = (route.points.first(), route.points.last()) else {
            return direct;
        };
        let access = a.distance(*first) + b.distance(*last);
        // Near places are reached across open ground.
        direct.max(((access + route.distance) / self.speed).min(1.5 * direct))
    }
}
