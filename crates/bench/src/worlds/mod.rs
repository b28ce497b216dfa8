//! Worlds: loading, preparation for runs, world folders.
//!
//! | module | content |
//! |---|---|
//! | `load` | [`load`]: from a [`WorldSource`](crate::WorldSource) to the world |
//! | `builtin` | [`builtin_suite`]: the built-in suites |
//! | `prepared` | [`Prepared`]: a suite with its world built and its doors looked up |
//! | `targets` | [`Target`]: the doors that an episode requests |
//! | `recipe` | [`Recipe`]: sources and parameters of a world |
//! | `public_map` | [`OnMap`]: the map that agents get, and how it differs from the world |
//! | [`hashes`] | [`Hashes`]: what a run was made in |
//! | `places` | real places whose maps the crate carries; [`split_of`] |
//! | `neighbourhoods` | [`neighbourhood_suite`]: suites of drawn neighbourhoods |
//! | `named` | [`suite_named`], [`suite_of_seed`]: the suite that a user names |
//! | `surroundings` | [`surroundings()`]: what a robot's sensors meet |
//! | [`folder`] | worlds as folders: recipe, maps, suite |

mod builtin;
pub mod folder;
pub mod hashes;
mod load;
mod named;
mod neighbourhoods;
mod places;
mod prepared;
mod public_map;
mod recipe;
mod surroundings;
mod targets;

pub use builtin::builtin_suite;
pub use hashes::Hashes;
pub use load::{load, load_with};
pub use named::{is_drawn_by_seed, is_name, source_named, suite_named, suite_of_seed};
pub use neighbourhoods::neighbourhood_suite;
pub use places::split_of;
pub use prepared::{Prepared, PreparedEpisode};
pub use public_map::{DrawnMap, OnMap};
pub use recipe::Recipe;
pub use surroundings::surroundings;
pub use targets::Target;
