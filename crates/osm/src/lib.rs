//! OpenStreetMap data: read, look up, edit, write.
//!
//! | module | its one concept |
//! |---|---|
//! | [`data`] | [`OsmData`]: nodes, ways and relations as they stand in a file, and what was survived while reading |
//! | [`tags`] | [`Tags`]: the words on an element |
//! | [`error`] | [`OsmError`]: why a file could not be read, and where in it |
//! | `xml`, `pbf` | the two formats that are read |
//! | [`stream`] | elements one after another, for those who keep little of a large file |
//! | [`write`](mod@write) | OSM XML, osmChange, and files that are replaced whole or not at all |
//! | [`projection`] | [`Projection`]: degrees to metres of the `map` frame and back |
//! | [`polygon`] | [`Polygon`]: an outline with holes, its boundary and its normals |
//! | `rings` | closed rings from the ways of a multipolygon |
//! | `spatial` | the nearest of many boxes |
//! | [`map`] | [`OsmMap`]: buildings, roads, barriers, areas and entrances in metres |
//! | `areas` | polygons from closed ways and multipolygons |
//! | [`names`] | which tags name a building or a unit, and when two names are the same |
//! | [`address`] | [`locate`]: the location query, from unit up to building |
//! | [`cutout`] | [`cut_out`]: a neighbourhood out of a larger map |
//! | [`edit`] | entrances added, merged and taken away |

pub mod address;
mod areas;
pub mod cutout;
pub mod data;
pub mod edit;
pub mod element;
pub mod error;
pub mod hierarchy;
pub mod map;
mod name_index;
pub mod names;
mod pbf;
pub mod polygon;
pub mod projection;
mod read;
mod rings;
mod spatial;
pub mod stream;
pub mod tags;
pub mod visitor;
pub mod write;
mod xml;

pub use address::{Location, locate};
pub use cutout::{Window, WindowError, cut_out};
pub use data::{OsmData, ReadReport};
pub use edit::{EditError, NewEntrance, add_entrance, merge_entrances, without_doors};
pub use element::{ElementId, ElementKind, Member, Node, Relation, Way};
pub use error::OsmError;
pub use map::{Area, Barrier, Building, Entrance, MapReport, OsmMap, Road};
pub use polygon::Polygon;
pub use projection::{Projection, ProjectionError, default_georeference};
pub use tags::Tags;
pub use write::{changes, write_atomically};
