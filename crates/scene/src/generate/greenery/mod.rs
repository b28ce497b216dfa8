//! Trees, shrubs and hedges.
//!
//! | file | contents |
//! |---|---|
//! | `tree` | one tree |
//! | `ball` | dented balls: crowns and shrubs |
//! | `mapped_trees` | trees that the map has as nodes |
//! | `tree_rows` | trees along `natural=tree_row` |
//! | `woods` | trees in woods and orchards |
//! | `shrubs` | bushes along the walls of houses |
//! | `backdrop` | trees on the horizon |
//! | `planting` | trees that the seed adds |
//! | `varied` | trees of more forms, where streets differ |
//! | `hedges` | clipped hedges, for the barriers |

pub(super) mod backdrop;
pub(super) mod ball;
pub(super) mod hedges;
pub(super) mod mapped_trees;
pub(super) mod planting;
pub(super) mod shrubs;
pub(super) mod tree;
pub(super) mod tree_rows;
mod varied;
pub(super) mod woods;
