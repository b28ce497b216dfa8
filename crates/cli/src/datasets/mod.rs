//! Published data that commands name and this repository does not hold: downloaded, checked against
//! pinned SHA-256 sums, stored.
//!
//! | module | contents |
//! |---|---|
//! | [`manifest`] | [`Dataset`]: which files a set holds, and where they come from |
//! | [`download`] | a set's files from its source into a folder |

pub mod download;
pub mod manifest;

pub use download::{DatasetError, pull};
pub use manifest::{Dataset, Source, datasets};
