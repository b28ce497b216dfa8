//! A world prepared for simulation.

use std::sync::Arc;

use openbench_geometry::Bounds;
use openbench_scene::{Movers, RayCaster, Scene, Snapshot};

use crate::bounds::bounds_of;
use crate::error::SimError;
use crate::render::Renderer;
use crate::solids::Solids;
use crate::traffic::{Gallery, TrafficPlan};

/// A world prepared for simulation. All episodes in the world share it: a clone is cheap.
#[derive(Debug, Clone)]
pub struct Stage {
    caster: RayCaster,
    pub(crate) renderer: Arc<Renderer>,
    pub(crate) solids: Solids,
    pub(crate) gallery: Arc<Gallery>,
    pub(crate) bounds: Bounds,
}

impl Stage {
    /// Prepares a scene without people and cars.
    ///
    /// # Errors
    /// [`SimError::NothingSolid`] or [`SimError::Mesh`] if nothing can stand in the scene.
    pub fn new(caster: RayCaster) -> Result<Self, SimError> {
        let solids = Solids::new(caster.scene())?;
        Ok(Self {
            renderer: Arc::new(Renderer::new(caster.clone())),
            bounds: bounds_of(caster.scene()),
            solids,
            caster,
            gallery: Arc::default(),
        })
    }

    /// Prepares a scene in which up to as many people and cars as in `plan` will move.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_figures(mut scene: Scene, plan: TrafficPlan) -> Result<Self, SimError> {
        // Figures are triangles of the scene, so they are added before its trees are built.
        let gallery = Arc::new(Gallery::add(&mut scene, plan));
        Ok(Self {
            gallery,
            ..Self::new(RayCaster::new(Arc::new(scene)))?
        })
    }

    /// Casts rays into the scene.
    pub fn caster(&self) -> &RayCaster {
        &self.caster
    }

    /// The scene with `movers` at their present places.
    pub fn snapshot<'a>(&'a self, movers: &'a Movers) -> Snapshot<'a> {
        Snapshot {
            caster: &self.caster,
            movers,
        }
    }

    /// Draws the scene.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }
}
