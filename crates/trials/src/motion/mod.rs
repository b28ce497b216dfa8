//! Comparison of local planners: random scenes, a reference motion for each, and the planners'
//! drives.
//!
//! | module | content |
//! |---|---|
//! | [`scene`] | scenes of ten kinds |
//! | [`mod@reference`] | the reference motion: the fastest that a long search finds, or a proof that there is none |
//! | `retime` | time-optimal path parametrization |
//! | [`drive`] | a drive through a scene |
//! | [`picture`] | a drive as an SVG picture |
//! | [`comparison`] | many scenes and several planners, with statistics |
//! | [`people`] | long drives among people, in the simulator |

pub mod comparison;
pub mod drive;
pub mod people;
pub mod picture;
pub mod reference;
mod retime;
pub mod scene;
