//! Polygons: areas in the plane.
//!
//! One algorithm a file. Rings are taken as they are; where a ring crosses itself, the even-odd
//! rule decides what is inside.
//!
//! | file | contents |
//! |---|---|
//! | `shape` | [`Polygon`]: an outline with holes |
//! | `ring` | rings in a given orientation, without repeated points |
//! | `signed_area` | [`signed_area`]: area and orientation of a ring |
//! | `area`, `bounds`, `perimeter`, `centroid` | measures of a polygon |
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
mod shape;
mod signed_area;

pub use nearest_boundary_point::BoundaryPoint;
pub use shape::Polygon;
pub use signed_area::signed_area;
