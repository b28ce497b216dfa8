//! Doors: where they are, their addresses, and how they look.
//!
//! | file | contents |
//! |---|---|
//! | `doorway` | a door in a wall |
//! | `entrances` | places of the doors |
//! | `drawn` | doors drawn by a seed where the map has none |
//! | `naming` | names of their buildings |
//! | `numbering` | house numbers drawn by a seed |
//! | `door` | builds one door with its plate |
//! | `street_plate` | plates as in streets |
//! | `neighbourhood` | what those depend on beyond the door |

pub(super) mod door;
pub(super) mod doorway;
pub(super) mod drawn;
pub(super) mod entrances;
pub(super) mod naming;
pub(super) mod neighbourhood;
mod numbering;
pub(super) mod street_plate;
