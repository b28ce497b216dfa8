//! OSRM's HTTP API, version 1: the services *route*, *nearest* and *table*.
//!
//! What `benchmarks/routing/osrm.md` found out about OSRM 26.10 is kept to: its addresses, options, codes, members and numbers.
//!
//! | module | its one job |
//! |---|---|
//! | `request` | what an address asks for |
//! | `service` | the answer to a request |
//! | `route`, `nearest`, `table` | the answers of the three services |
//! | `segments` | what each segment takes, for annotations |
//! | `step` | what to do on the way, as JSON |
//! | `simplify` | as many points of a line as can be seen |
//! | `polyline` | lines as text |
//! | `failure` | what is said when there is no answer |
//! | `json` | JSON as OSRM writes it |

mod failure;
mod json;
mod nearest;
mod polyline;
mod request;
mod route;
mod segments;
mod service;
mod simplify;
mod step;
mod table;

pub use failure::Failure;
pub use request::{
    Annotations, Geometries, Limits, NearestRequest, Overview, Places, Request, RouteRequest,
    TableRequest,
};
pub use service::{Answer, Service, ServiceMemory};
