//! The shapes that things are built of, with texture coordinates in metres.
//!
//! | file | contents |
//! |---|---|
//! | `surface` | surfaces of materials, and points at a height |
//! | `upright` | vertical rectangles over a line: walls, fitted images, fences |
//! | `solids` | planar polygons in space, boxes, frustums |
//! | `level` | level rectangles, filled outlines, bands along lines |
//! | `rings` | rings moved inwards, and the area of a ring |

mod level;
pub(super) mod rings;
mod solids;
mod surface;
mod upright;

pub(super) use level::{band, floor, level_rectangle, level_uv};
pub(super) use solids::{Block, Frustum, cuboid, facet, frustum};
pub(super) use surface::{Surface, at};
pub(super) use upright::{panel, see_through, wall};
