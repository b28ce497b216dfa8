//! The ground, and the view beyond it.
//!
//! | file | contents |
//! |---|---|
//! | `terrain` | the ground, cut out where the sea is |
//! | `pitted` | level ground with pits, in triangles |
//! | `horizon` | hills or the sea far beyond the map |
//! | `aprons` | paved ground around buildings |
//! | `covers` | ground covers that the map has as areas |
//! | `levels` | heights of ground covers |

pub(super) mod aprons;
pub(super) mod covers;
pub(super) mod horizon;
pub(super) mod levels;
pub(super) mod pitted;
pub(super) mod terrain;
