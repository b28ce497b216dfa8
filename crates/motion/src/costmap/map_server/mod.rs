//! Grids as ROS's map server keeps them: an image (`.pgm`, or `.png`) and a `.yaml` file that says
//! where it lies and what its grey levels mean.
//!
//! After the descriptions of `map_server` in the ROS wiki and of `nav2_map_server`. A pixel of
//! lightness x gives the probability p that its cell is occupied: (255 - x) / 255, or x / 255 with
//! `negate`. `mode` says how p is read:
//!
//! - `trinary`: occupied above `occupied_thresh`, free below `free_thresh`, unknown between.
//! - `scale`: the same, but graded in proportion between; a pixel that is not opaque is unknown.
//! - `raw`: x itself, where it is 100 at most.
//!
//! The first row of the image is the northernmost.
//!
//! | module | contents |
//! |---|---|
//! | `occupancy` | [`Occupancy`]: the grid |
//! | `description` | [`Description`]: the `.yaml` file |
//! | `pixels` | [`decode`]: the image |
//! | `files` | [`read`] and [`write()`] |
//! | `error` | [`MapServerError`] |

mod description;
mod error;
mod files;
mod occupancy;
mod pixels;

pub use description::{Description, Mode, describe};
pub use error::MapServerError;
pub use files::{read, write};
pub use occupancy::Occupancy;
pub use pixels::decode;
