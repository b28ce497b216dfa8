//! Doors: where they are, their addresses, and how they look.
//!
//! | file | contents |
//! |---|---|
//! | `doorway` | a door in a wall |
//! | `entrances` | places of the doors |
//! | `naming` | names of their buildings |
//! | `door` | builds one door with its plate |

pub(super) mod door;
pub(super) mod doorway;
pub(super) mod entrances;
pub(super) mod naming;
