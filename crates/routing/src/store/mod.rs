//! Graph files: a network in its cells, ready for routing.
//!
//! A file holds what follows from the map alone. Layers and a profile's weights follow from that in
//! some hundredths of a second for a city. They are computed again, so that a profile can change
//! without the file.
//!
//! Numbers are little-endian. The header holds 8 bytes `OBROADS` and a zero, version and number of
//! sections (`u32`), and the length of the file (`u64`). 8 bytes of zeros and the BLAKE3 of
//! everything after the header (32 bytes) complete it. A table follows with the number, the begin
//! and the length in bytes of each section (`u64`). The sections come last, aligned to 64 bytes.
//! Sections are rows of the types of [`Network`](crate::network::Network) and of the tree of
//! segments. Tags are UTF-8, followed by the end of each set of tags.
//!
//! | module | contents |
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
