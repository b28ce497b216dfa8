//! Why a world cannot be simulated.

use rapier3d_f64::parry::shape::TriMeshBuilderError;

/// Why a world cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// There is nothing to stand on.
    #[error(
        "the world has no solid surface, not even ground; add a ground plane with a collision shape"
    )]
    NothingSolid,
    /// The physics engine refuses the solid triangles.
    #[error("the world's solid triangles cannot be simulated")]
    Mesh(#[source] TriMeshBuilderError),
    /// More people or cars than the stage has figures for.
    #[error(
        "the stage has no figures for so many people and cars; make it with `Stage::with_figures`"
    )]
    NoFigures,
}
