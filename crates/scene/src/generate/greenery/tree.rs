//! One tree: round, wide, slender, a birch or a conifer.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

use openbench_core::MapPoint;
use rand_pcg::Pcg64Mcg;

use super::ball::{Ball, ball};
use super::varied;
use crate::generate::inputs::Inputs;
use crate::generate::layout::occupied::Occupied;
use crate::generate::materials::palette::Crown;
use crate::generate::output::Output;
use crate::generate::seeds::{between, pick};
use crate::generate::shapes::{Frustum, Surface, at, frustum};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// Free radius that a tree needs, metres.
pub(super) const TREE_RADIUS_M: f64 = 0.35;

/// The form of a broadleaved tree.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    Round,
    /// Several crowns beside each other.
    Wide,
    Slender,
    Birch,
}

/// Sizes from which a form's are drawn, metres.
struct Sizes {
    trunk: f64,
    radius: Range<f64>,
    half_height: Range<f64>,
}

impl Form {
    fn sizes(self) -> Sizes {
        match self {
            Self::Round => Sizes {
                trunk: 2.2,
                radius: 1.4..2.3,
                half_height: 1.5..2.2,
            },
            Self::Wide => Sizes {
                trunk: 2.6,
                radius: 2.0..2.7,
                half_height: 1.5..1.9,
            },
            Self::Slender => Sizes {
                trunk: 1.5,
                radius: 0.8..1.1,
                half_height: 2.8..4.2,
            },
            Self::Birch => Sizes {
                trunk: 2.4,
                radius: 1.1..1.5,
                half_height: 1.9..2.6,
            },
        }
    }
}

/// Trunk and crown of a broadleaved tree, metres.
struct Broadleaf {
    bark: Surface,
    girth: f64,
    trunk: f64,
    radius: f64,
    half_height: f64,
    crown: Crown,
    /// Whether lobes stand around the crown.
    wide: bool,
}

/// Builds a tree that stands on `p`, and records its trunk.
pub(super) fn build(
    inputs: &Inputs,
    occupied: &mut Occupied,
    out: &mut Output,
    p: MapPoint,
    is_conifer: bool,
    rng: &mut Pcg64Mcg,
) {
    if out.is_full() {
        return;
    }
    out.scene.begin_object("tree", SemanticClass::Vegetation);
    let girth = between(rng, 0.11, 0.19);
    if let Some(mut own) = varied::stream_at(inputs, p) {
        // As without them, so that trees after this one stay as they are.
        let mut unseen = SceneBuilder::new();
        if is_conifer {
            conifer(inputs, &mut unseen, p, girth, rng);
        } else {
            broadleaf(inputs, girth, rng).build(&mut unseen, p, rng);
        }
        varied::build(inputs, &mut out.scene, p, girth, &mut own);
        out.drawn_scenery.trees += 1;
    } else if is_conifer {
        conifer(inputs, &mut out.scene, p, girth, rng);
    } else {
        broadleaf(inputs, girth, rng).build(&mut out.scene, p, rng);
    }
    // The trunk alone: crowns may touch, and cars park below them.
    occupied.add_disc(p, girth);
}

fn conifer(inputs: &Inputs, scene: &mut SceneBuilder, p: MapPoint, girth: f64, rng: &mut Pcg64Mcg) {
    let height = between(rng, 5.0, 9.5);
    let trunk = Frustum {
        center: p,
        sides: 6,
        z: 0.0..1.2,
        radii: [girth, girth * 0.9],
    };
    frustum(scene, Layer::Both, inputs.palette.bark, trunk);
    let needles = pick(rng, &inputs.palette.needles);
    let width = height * between(rng, 0.17, 0.25);
    let tiers = if inputs.detailed { 5 } else { 3 };
    for tier in 0..tiers {
        let share = f64::from(tier) / f64::from(tiers);
        // Each cone reaches half a tier into the next, so that no gap is seen between them.
        let reach = (share + 1.5 / f64::from(tiers)).min(1.0);
        let z = 0.9 + share * (height - 0.9) * 0.85..0.9 + reach * (height - 0.9);
        let radius = width * (1.0 - 0.78 * share) * between(rng, 0.88, 1.08);
        let cone = Frustum {
            center: p,
            sides: 8,
            z,
            radii: [radius, 0.0],
        };
        frustum(scene, Layer::Visible, needles, cone);
    }
}

fn broadleaf(inputs: &Inputs, girth: f64, rng: &mut Pcg64Mcg) -> Broadleaf {
    use Form::{Birch, Round, Slender, Wide};
    let palette = &inputs.palette;
    let form = pick(rng, &[Round, Round, Wide, Wide, Slender, Birch]);
    let Sizes {
        trunk,
        radius,
        half_height,
    } = form.sizes();
    let is_birch = form == Birch;
    Broadleaf {
        bark: if is_birch {
            palette.pale_bark
        } else {
            palette.bark
        },
        girth: if is_birch { girth * 0.75 } else { girth },
        radius: between(rng, radius.start, radius.end),
        half_height: between(rng, half_height.start, half_height.end),
        trunk: trunk + between(rng, -0.2, 0.4),
        crown: if is_birch {
            palette.crowns[2]
        } else {
            pick(rng, &palette.crowns)
        },
        // Four more balls a tree are too many for a town.
        wide: form == Wide && inputs.detailed,
    }
}

impl Broadleaf {
    fn build(&self, scene: &mut SceneBuilder, p: MapPoint, rng: &mut Pcg64Mcg) {
        let (radius, half_height) = (self.radius, self.half_height);
        let Crown { core, shell } = self.crown;
        let trunk = Frustum {
            center: p,
            sides: 6,
            // Half a metre into the crown, so that no gap is seen below it.
            z: 0.0..self.trunk + 0.5,
            radii: [self.girth, self.girth * 0.7],
        };
        frustum(scene, Layer::Both, self.bark, trunk);
        let center = at(p, self.trunk + half_height * 0.85);
        // An opaque core, and around it a shell of leaves with holes.
        let dense = Ball {
            center,
            radius: radius * 0.78,
            half_height: half_height * 0.8,
        };
        ball(scene, core, dense, 0, rng);
        if !self.wide {
            ball(
                scene,
                shell,
                Ball {
                    center,
                    radius,
                    half_height,
                },
                1,
                rng,
            );
            return;
        }
        let narrow = Ball {
            center,
            radius: radius * 0.75,
            half_height,
        };
        ball(scene, shell, narrow, 1, rng);
        let turn = between(rng, 0.0, TAU);
        for i in 0..4 {
            let direction = turn + FRAC_PI_2 * f64::from(i);
            let beside = p.offset(direction, radius * 0.58);
            let center = at(beside, center.z - half_height * between(rng, 0.05, 0.4));
            let size = between(rng, 0.5, 0.62);
            let (radius, half_height) = (radius * size, half_height * size * 1.1);
            ball(
                scene,
                core,
                Ball {
                    center,
                    radius,
                    half_height,
                },
                0,
                rng,
            );
        }
    }
}
