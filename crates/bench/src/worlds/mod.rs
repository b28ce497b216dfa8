//! Worlds: loading, preparation for runs, world folders.
//!
//! | module | content |
//! |---|---|
//! | [`mod@load`] | from a [`WorldSource`](crate::WorldSource) to the world |
//! | [`builtin`] | the built-in suites |
//! | [`prepared`] | [`Prepared`]: a suite with its world built and its doors looked up |
//! | [`targets`] | [`Target`]: the doors that an episode requests |
//! | [`recipe`] | [`Recipe`]: sources and parameters of a world |
//! | [`folder`] | worlds as folders: recipe, maps, suite |

pub mod builtin;
pub mod folder;
pub mod load;
pub mod prepared;
pub mod recipe;
pub mod targets;

pub use builtin::builtin_suite;
pub use load::load;
pub use prepared::{Prepared, PreparedEpisode};
pub use recipe::Recipe;
pub use targets::Target;
