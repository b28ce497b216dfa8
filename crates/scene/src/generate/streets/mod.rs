//! Streets and paths, and what is on them.
//!
//! | file | contents |
//! |---|---|
//! | `profile` | the cross section of a road, from its tags |
//! | `roads` | carriageways, pavements, paths |
//! | `wear` | mended places, manholes, drains |
//! | `markings` | dashed middle lines, zebra crossings |
//! | `stripes` | painted rectangles |
//! | `parked_cars` | parked cars |
//! | `car` | one car |

pub(super) mod car;
mod car_shapes;
pub(super) mod markings;
pub(super) mod parked_cars;
pub(super) mod profile;
pub(super) mod roads;
pub(super) mod stripes;
pub(super) mod wear;
