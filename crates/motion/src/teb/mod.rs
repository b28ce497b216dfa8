//! The Timed Elastic Band: a trajectory optimized for time, length, limits of the robot and
//! distance to obstacles at once.
//!
//! C. Roesmann, W. Feiten, T. Woesch, F. Hoffmann, T. Bertram, *Trajectory modification considering
//! dynamic constraints of autonomous robots*, ROBOTIK 2012, and *Efficient trajectory optimization
//! using a sparse model*, ECMR 2013; several bands at once after C. Roesmann, F. Hoffmann, T.
//! Bertram, *Integrated online trajectory planning and optimization in distinctive topologies*,
//! Robotics and Autonomous Systems 88, 2017.
//!
//! A band B is poses s₀ … sₙ, sᵢ = (xᵢ, yᵢ, θᵢ), and the times between them ΔT₀ … ΔTₙ₋₁. It
//! minimizes a weighted sum of squares, V(B) = Σ γₖ fₖ(B)², each of few neighbouring poses, so that
//! the normal equations are banded and their solution takes time in proportion to n. With dᵢ =
//! (xᵢ₊₁ - xᵢ, yᵢ₊₁ - yᵢ) and θ̄ᵢ the mean of both headings,
//!
//! vᵢ = dᵢ · (cos θ̄ᵢ, sin θ̄ᵢ) / ΔTᵢ, ωᵢ = (θᵢ₊₁ - θᵢ) / ΔTᵢ, and u = v ± b ω for the rims:
//!
//! | objective | residual, where it is not zero |
//! |---|---|
//! | time | ΔTᵢ |
//! | length | sᵢ₊₁ - sᵢ |
//! | speed | vᵢ - v_max, -vᵢ - v_back |
//! | turn rate | abs(ωᵢ) - ω_max |
//! | acceleration of both rims | abs(2 (uᵢ₊₁ - uᵢ) / (ΔTᵢ + ΔTᵢ₊₁)) - a_max |
//! | non-holonomic kinematics | dᵢ × (cos θ̄ᵢ, sin θ̄ᵢ) |
//! | forward drive | -vᵢ |
//! | obstacles (2012, equation 8) | least - dist(footprint at sᵢ, obstacle at tᵢ) |
//! | comfort | comfort - dist(footprint at sᵢ, obstacle at tᵢ) |
//! | via points (2012, equation 7) | sₖ - via |
//! | preferred side | ∓ωᵢ at the beginning |
//!
//! Distances are between outlines of the footprint and of standing and moving obstacles.
//! Limits are penalties as in 2012, equation 6, of the second order and without a margin before
//! them.
//!
//! Unlike in the papers, tᵢ = Σ ΔTₖ is the variable instead of ΔTᵢ: all terms stay local, and the
//! term of a moving obstacle gets its true derivative by time. Steps are taken in the robot's own
//! coordinates ([`Optimizer`]): straight steps of all variables violate the non-holonomic
//! constraint, and would have to be tiny.
//!
//! | module | contents |
//! |---|---|
//! | `terms` | what is minimized, with derivatives |
//! | `normal` | banded normal equations |
//! | `optimize` | the Levenberg-Marquardt method |
//! | `classes` | homotopy classes and the cheapest path of each |
//! | `candidate` | bands that compete, one of each class |
//! | `planner` | several bands from cycle to cycle, the best one driven |
//! | `settings` | weights, margins, and how the planner works |

mod candidate;
mod classes;
mod normal;
mod optimize;
mod planner;
mod settings;
mod terms;

pub use candidate::Candidate;
pub use classes::{ClassPath, Clusters, Explorer, Exploring, Passing, Signature};
pub use optimize::{Effort, Optimizer};
pub use planner::{Teb, TebError, entry, entry_with};
pub use settings::{Margins, Settings, TebSettings, Weights};
pub use terms::Problem;
