//! Polygons: areas in the plane.
//!
//! One algorithm a file. Rings are taken as they are; where a ring crosses itself, the even-odd
//! rule decides what is inside.
//!
//! | file | its one job |
//! |---|---|
//! | `shape` | [`Polygon`]: an outline with holes |
//! | `segment` | [`Segment`] and its point nearest to another |
//! | `bounds` | [`Bounds`]: axis-aligned boxes |
//! | `ring` | rings in a given orientation, without repeated points |
//! | `signed_area` | area and orientation of a ring |
//! | `area`, `perimeter`, `centroid` | measures of a polygon |
//! | `contains` | whether a point is inside |
//! | `nearest_boundary_point` | the nearest point of the boundary and its outward normal |
//! | `interior_point` | a point inside, away from the boundary |

mod area;
mod bounds;
mod centroid;
mod contains;
mod interior_point;
mod nearest_boundary_point;
mod perimeter;
mod ring;
mod segment;
mod shape;
mod signed_area;

pub use bounds::Bounds;
pub use nearest_boundary_point::BoundaryPoint;
pub use segment::{FootPoint, Segment};
pub use shape::Polygon;
