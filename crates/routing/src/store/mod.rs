//! Graph files: a network in its cells, ready for routing.
//!
//! A file holds what follows from the map alone. Layers and a profile's weights follow from that in
//! some hundredths of a second for a city. They are computed again, so that a profile can change
//! without the file.
//!
//! Layout, with little-endian numbers: 8 bytes `OBROADS` and a zero; version, `u32`; number of
//! sections, `u32`; length of the file, `u64`; 8 bytes of zeros; BLAKE3 of everything after this
//! header, 32 bytes. Then for each section its number, its begin and its length in bytes, `u64`
//! each; then the sections, aligned to 64 bytes. Sections are rows of the types of
//! [`Network`](crate::network::Network) and of the tree of segments. Tags are UTF-8, followed by
//! the end of each set of tags.
//!
//! | module | its one job |
//! |---|---|
//! | `column` | [`Column`]: rows of numbers, in memory or in a mapped file |
//! | `map` | memory mapping |
//! | `file` | reading and writing |
//! | `check` | checks the content of files |

mod check;
mod column;
mod file;
mod map;

pub use column::Column;
pub use file::{GraphFileError, is_graph_file, read, write};
