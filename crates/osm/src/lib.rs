#![doc = include_str!("../README.md")]
//! ## Modules
//!
//! | module | contents |
//! |---|---|
//! | `element` | nodes, ways and relations |
//! | `tags` | [`Tags`]: the tags of an element |
//! | `data` | [`OsmData`]: a map in memory, as it stands in a file |
//! | [`visitor`] | [`visitor::Visitor`]: receives the elements of a map one by one |
//! | `xml`, `pbf` | the two formats that are read |
//! | `read` | reads a map from a file or from bytes |
//! | [`stream`] | [`stream::Source`]: a large file, visited without keeping it |
//! | `write` | OSM XML, osmChange, and atomic replacement of files |
//! | [`error`] | [`OsmError`]: why a file could not be read, and where in it |
//! | `projection` | [`Projection`]: degrees to metres of the `map` frame and back |
//! | `rings` | closed rings from the ways of a multipolygon |
//! | `areas` | polygons from closed ways and multipolygons |
//! | `spatial` | the nearest of many boxes |
//! | [`map`] | [`OsmMap`]: buildings, roads, barriers, areas and entrances in metres |
//! | [`names`] | which tags name a building or a unit, and when two names are equal |
//! | `name_index` | buildings by their names |
//! | [`hierarchy`] | streets, quarters and towns above a building |
//! | `address` | [`locate`]: the location query, from unit up to building |
//! | `cutout` | [`cut_out`]: a neighbourhood out of a larger map |
//! | `edit` | entrances added, merged and removed |
//! | [`disturb`] | maps that are wrong as real ones are |
//! | [`draws`] | random numbers, a stream for each purpose and element |
//! | [`houses`] | doors, units and house numbers of houses of which no map says them |
//! | `renumber` | [`renumbered`]: new numbers that tell nothing about removed elements |

mod address;
mod areas;
mod cutout;
mod data;
pub mod disturb;
pub mod draws;
mod edit;
mod element;
pub mod error;
pub mod hierarchy;
pub mod houses;
pub mod map;
mod name_index;
pub mod names;
mod pbf;
mod projection;
mod read;
mod renumber;
mod rings;
mod spatial;
pub mod stream;
mod tags;
pub mod visitor;
mod write;
mod xml;

pub use address::{Location, locate};
pub use cutout::{Window, WindowError, cut_out};
pub use data::{OsmData, ReadReport};
pub use edit::{
    EditError, NewEntrance, add_entrance, lost_in_merge, merge_entrances, without_doors,
};
pub use element::{ElementId, ElementKind, Member, Node, Relation, Way};
pub use error::OsmError;
pub use map::{Area, Barrier, Building, Entrance, MapReport, OsmMap, Road};
pub use projection::{Projection, ProjectionError, default_georeference};
pub use renumber::renumbered;
pub use tags::Tags;
pub use write::{changes, is_staging_of, write_atomically};
