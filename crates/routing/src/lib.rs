#![doc = include_str!("../README.md")]
//! ## Modules
//!
//! | module | contents |
//! |---|---|
//! | `profile` | [`Profile`]: who may go where, how fast and at which cost |
//! | [`network`] | vertices and edges of a map, independent of profiles |
//! | [`partition`] | vertices in cells, and cells in larger cells |
//! | `roads` | [`Roads`]: a network in cells |
//! | [`overlay`] | layers of cells over a graph, and the paths through them |
//! | `costs` | costs of edges and vertices for a profile |
//! | `restrictions` | turns that are not allowed |
//! | `bearings` | the directions in which edges leave and reach vertices |
//! | `turns` | the graph of turns, for profiles to which turns matter |
//! | `components` | strongly connected components |
//! | `metric` | [`Metric`]: a profile customized for a network |
//! | [`search`] | searches over layers: a path, alternatives, tables |
//! | [`tree`], [`position`] | segments near a place, and the place's position on the network |
//! | [`leg`] | the route from one place to another |
//! | [`mod@through`] | the route through several places |
//! | `guidance` | turn-by-turn instructions |
//! | `router` | [`MapRouter`]: routes in the frame of a map |
//! | [`osrm`] | answers in the format of OSRM's HTTP API, version 1 |
//! | [`store`] | graph files |
//! | [`geo`] | places and distances |
//!
//! Agents use [`Router`].

mod bearings;
mod components;
mod costs;
pub mod geo;
mod guidance;
pub mod leg;
mod metric;
pub mod network;
pub mod osrm;
pub mod overlay;
pub mod partition;
pub mod position;
mod profile;
mod restrictions;
mod roads;
mod router;
pub mod search;
pub mod store;
pub mod through;
pub mod tree;
mod turns;

use openbench_core::{MapPoint, TravelTimes};

pub use metric::Metric;
pub use profile::{OutOfRange, Profile, ProfileError, Travel};
pub use roads::Roads;
pub use router::{MapRouter, PrepareError};
pub use turns::TooManyTurns;

/// A route over roads.
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
#[non_exhaustive]
pub enum RouteError {
    /// No road that the profile may use is nearby.
    #[error("no road for this profile within {limit:.0} m of {near}")]
    NoSegment {
        /// The place that was asked for.
        near: MapPoint,
        /// The radius in which roads were looked for, metres.
        limit: f64,
    },
    /// No route connects the two places.
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

/// Travel times for planning: over roads where there are some, on foot across open ground
/// elsewhere.
#[derive(Debug, Clone, Copy)]
pub struct RouterTimes<'a, R> {
    /// The router.
    pub router: &'a R,
    /// Speed off the network, m/s.
    pub off_road_speed: f64,
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
        let direct = a.distance(b) / self.off_road_speed;
        let Ok(route) = self.router.route(a, b) else {
            return direct;
        };
        let (Some(first), Some(last)) = (route.points.first(), route.points.last()) else {
            return direct;
        };
        let access = a.distance(*first) + b.distance(*last);
        // Places close to each other are reached across open ground.
        // All metres take the same speed, so the route counts by its length alone.
        direct.max(((access + route.distance) / self.off_road_speed).min(1.5 * direct))
    }
}
