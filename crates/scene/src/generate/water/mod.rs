//! Water, and the walls that keep a robot out of it.
//!
//! | file | contents |
//! |---|---|
//! | `coast` | the sea beside coastlines |
//! | `open_water` | which of the map's areas are open water |
//! | `quays` | low walls around water |

pub(super) mod coast;
pub(super) mod open_water;
pub(super) mod quays;
