//! What makes streets differ, in worlds that ask for it: varied ground, things in the way, steps,
//! kerbs and light wells.
//!
//! All of it is drawn by a seed of its own, apart from the world's: streets, houses and doors stay
//! where they are. Every way that a robot of the size of the benchmark's has without these things
//! stays open with them; `passage` says how.
//!
//! | file | contents |
//! |---|---|
//! | `streams` | the streams of random numbers |
//! | `grounds` | lots of gravel, paving, bare earth and meadow |
//! | `passage` | whether a thing leaves all ways around it open |
//! | `clutter` | where things stand: beside doors, at walls, on pavements |
//! | `kinds` | kinds of things, with their sizes |
//! | `things` | what they look like |
//! | `bars` | bars in any direction, and wheels |
//! | `site` | what things are placed in |
//! | `relief` | steps, ramps and wells, planned before anything is built |
//! | `planned` | that plan |
//! | `kerbs` | raised kerbs between dropped ones |
//! | `steps` | steps and ramps before doors |
//! | `wells` | light wells: places where the ground is missing |

mod bars;
pub(super) mod clutter;
pub(super) mod grounds;
pub(super) mod kerbs;
mod kinds;
mod passage;
pub(super) mod planned;
pub(super) mod relief;
pub(super) mod site;
pub(super) mod steps;
pub(super) mod streams;
mod things;
pub(super) mod wells;
