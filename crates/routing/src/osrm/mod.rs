//! OSRM's HTTP API, version 1: the services *route*, *nearest* and *table*.
//!
//! Addresses, options, codes, members and numbers follow OSRM 26.10 as `benchmarks/routing/osrm.md`
//! describes it.
//!
//! | module | contents |
//! |---|---|
//! | `request` | parses requests |
//! | `query` | the texts of a request: coordinates and options |
//! | `service` | answers requests |
//! | `route`, `nearest`, `table` | the answers of the three services |
//! | `segments` | what each segment takes, for annotations |
//! | `step` | turn-by-turn instructions as JSON |
//! | `simplify` | lines with as few points as the overview needs |
//! | `polyline` | lines as text |
//! | `failure` | error responses |
//! | `json` | JSON as OSRM writes it |

mod failure;
mod json;
mod nearest;
mod polyline;
mod query;
mod request;
mod route;
mod segments;
mod service;
mod simplify;
mod step;
mod table;

pub use failure::Failure;
pub use request::{
    Annotations, Geometries, Limits, NearestRequest, Overview, Request, RequestPlaces,
    RouteRequest, TableRequest,
};
pub use service::{Answer, Service, ServiceMemory};
