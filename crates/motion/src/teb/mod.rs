//! The Timed Elastic Band: a way that knows its times, shaped by all that a robot has to keep to at once.
//!
//! C. Roesmann, W. Feiten, T. Woesch, F. Hoffmann, T. Bertram, *Trajectory modification considering dynamic constraints of autonomous robots*, ROBOTIK 2012, and *Efficient trajectory optimization
//! using a sparse model*, ECMR 2013; several bands at once after C. Roesmann, F. Hoffmann, T. Bertram, *Integrated online trajectory planning and optimization in distinctive topologies*, Robotics and
//! Autonomous Systems 88, 2017.
//!
//! A band B is poses s₀ … sₙ, sᵢ = (xᵢ, yᵢ, θᵢ), and the times between them ΔT₀ … ΔTₙ₋₁. It minimizes a weighted sum of squares, V(B) = Σ γₖ fₖ(B)², each of few neighbouring poses, so that the normal equations are
//! banded and their solution takes time in proportion to n:
//!
//! | objective | residual, where it is not zero | module |
//! |---|---|---|
//! | time | ΔTᵢ | [`terms`] |
//! | shortest way | sᵢ₊₁ - sᵢ | |
//! | speed and turn rate | vᵢ - v_max, -vᵢ - v_back, |ωᵢ| - ω_max with vᵢ = dᵢ · (cos θ̄ᵢ, sin θ̄ᵢ) / ΔTᵢ, ωᵢ = (θᵢ₊₁ - θᵢ) / ΔTᵢ, θ̄ᵢ the mean of both headings | |
//! | acceleration of both rims | |2 (uᵢ₊₁ - uᵢ) / (ΔTᵢ + ΔTᵢ₊₁)| - a_max with u = v ± b ω | |
//! | non-holonomic kinematics | dᵢ × (cos θ̄ᵢ, sin θ̄ᵢ) | |
//! | forward drive | -vᵢ | |
//! | obstacles, standing and moving (2012, equation 8) | least - dist(footprint at sᵢ, obstacle at tᵢ), comfort - dist(…) | [`crate::shape`] |
//! | via points (2012, equation 7) | sₖ - via | |
//! | preferred side | ∓ωᵢ at the beginning | |
//!
//! Limits are penalties as in 2012, equation 6, of the second order and without a margin before them.
//!
//! Other than in the papers tᵢ = Σ ΔTₖ is the variable instead of ΔTᵢ: all terms stay local, and the term of a moving obstacle gets its true derivative by time. Steps are taken in the robot's own coordinates (`optimize`), since straight steps of all
//! variables leave the curved ground on which nothing drives sideways and would have to be tiny.
//!
//! | module | its one job |
//! |---|---|
//! | [`terms`] | what is minimized, with derivatives |
//! | [`normal`] | banded normal equations |
//! | [`optimize`] | Levenberg and Marquardt |
//! | [`classes`] | homotopy classes and the cheapest way of each |
//! | [`planner`] | several bands from cycle to cycle, the best one driven |
//! | [`settings`] | weights, margins |

pub mod classes;
pub mod normal;
pub mod optimize;
pub mod planner;
pub mod settings;
pub mod terms;

pub use planner::{entry, entry_with};
