//! Street furniture.
//!
//! | file | contents |
//! |---|---|
//! | `mapped` | furniture at the map's nodes: lamps, benches, hydrants |
//! | `bins` | wheelie bins at the walls of houses |

pub(super) mod bins;
pub(super) mod mapped;
pub(super) mod signs;
