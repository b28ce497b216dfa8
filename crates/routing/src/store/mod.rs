//! Graph files: a network in its cells, ready to be routed on.
//!
//! A file holds what follows from the map alone. Layers and a profile's weights follow from that in some hundredths of a second for a
//! city, and are worked out anew, so that a profile can change without the file.
//!
//! Layout, numbers little-endian: 8 bytes `OBROADS` and a zero; version, `u32`; number of sections, `u32`; length of the file, `u64`; 8 bytes of
//! zeros; BLAKE3 of everything behind this header, 32 bytes. Then for each section its number, where it begins, and its bytes, `u64` each; then the sections,
//! aligned to 64 bytes. Sections are rows of the types of [`Network`](crate::network::Network) and of the tree of segments; words are UTF-8, and where each set of them ends.
//!
//! | module | its one job |
//! |---|---|
//! | `column` | [`Column`]: rows of numbers, in memory or in a mapped file |
//! | `map` | mapping a file |
//! | `file` | reading and writing |
//! | `check` | whether what a file says can be true |

mod check;
mod column;
mod file;
mod map;

pub use column::Column;
pub use file::{GraphFileError, is_graph_file, read, write};
