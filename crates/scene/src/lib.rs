#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | module | contents |
//! |---|---|
//! | `scene` | [`Scene`] and [`SceneBuilder`]: triangles with materials, solid surfaces, doors |
//! | `material` | [`Material`], [`Texture`], [`SemanticClass`] |
//! | [`bvh`] | [`TriangleBvh`]: rays against triangles, one or sixteen at a time |
//! | `raycast` | [`RayCaster`]: what rays hit in a scene |
//! | `free_space` | [`FreeSpace`]: where a footprint fits, and distances for it |
//! | `import` | [`import_world`]: Gazebo worlds and their meshes |
//! | [`generate`](mod@generate) | worlds from an OSM file and a seed |
//! | [`plate`] | number plates of published worlds |
//! | [`plates`] | door plates of real streets |
//! | [`scenery`] | how much streets differ |
//! | `drawn_doors` | [`DrawnDoors`]: what was drawn for doors, counted |
//! | `world` | [`World`]: a scene with its public map, georeference and start |
//! | `beyond` | ground around the drawn ground |
//! | `triangulate` | triangulation of an outline with holes |

mod beyond;
pub mod bvh;
mod drawn_doors;
mod free_space;
pub mod generate;
mod import;
mod material;
pub mod plate;
pub mod plates;
mod raycast;
mod scene;
pub mod scenery;
mod triangulate;
mod world;

pub use bvh::{Hit, Movers, Placed, RayPacket, TriangleBvh};
pub use drawn_doors::DrawnDoors;
pub use free_space::{FreeSpace, ground_height};
pub use import::{ImportError, ImportRequest, ObjError, import_world};
pub use material::{Finish, Material, MaterialId, SemanticClass, Texture, TextureId};
pub use raycast::{RayCaster, Snapshot, Surface, nearest_texel};
pub use scene::{
    Corner, Door, Layer, Object, Scene, SceneBuilder, SolidMesh, Sun, Triangle, Vertex,
};
pub use world::World;
