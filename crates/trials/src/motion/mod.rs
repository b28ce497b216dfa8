//! How well local planners drive: scenes from seeds, what could be done in each, and what the planners do.
//!
//! | module | its one job |
//! |---|---|
//! | [`scene`] | scenes of ten kinds |
//! | [`best`] | the fastest motion that a long search finds, or a proof that there is none |
//! | [`retime`] | the same way as fast as a robot can |
//! | [`drive`] | a drive through a scene |
//! | [`picture`] | a drive as a picture |
//! | [`trial`] | many scenes, several planners, and the table |
//! | [`people`] | kilometres among people, in the simulator |

pub mod best;
pub mod drive;
pub mod people;
pub mod picture;
pub mod retime;
pub mod scene;
pub mod trial;
