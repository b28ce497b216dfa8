//! The road network of a map, independent of any profile.
//!
//! Vertices are nodes where ways meet, end, or that have tags of their own (a barrier, a crossing).
//! Edges are the pieces of ways between them. Tags that a profile may ask for are kept, each set of
//! tags once, so that a profile can be changed without the map.
//!
//! | module | contents |
//! |---|---|
//! | `graph` | [`Network`]: the rows of a network |
//! | `chain` | `Chain`: items along an edge |
//! | `tag_sets` | sets of tags and names, each kept once |
//! | `elements` | the ways, nodes and squares that a network is built from |
//! | `read` | reads these elements, out of all that a map holds |
//! | `outlines` | the outlines of squares that are relations |
//! | `timetable` | how long a ferry takes |
//! | `squares` | lines across pedestrian areas |
//! | `visibility` | which corners of an area see each other |
//! | `spanner` | shortest paths over a few points, and the lines worth keeping |
//! | `build` | vertices and edges from ways and nodes |

mod build;
mod chain;
mod elements;
mod graph;
mod outlines;
mod read;
mod spanner;
mod squares;
mod tag_sets;
mod timetable;
mod visibility;

pub use graph::{Edge, Network, NetworkReport, Restriction};
pub(crate) use graph::{MOST_VIA_WAYS, Rows};
pub use tag_sets::{RoadName, RoadNames};
pub(crate) use tag_sets::{TagSets, Texts};
