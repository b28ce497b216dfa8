//! Trees of more forms, where streets differ: columns, cones, several stems, umbrellas, pollards
//! and trees that have just been planted.

use std::f64::consts::TAU;

use openbench_core::MapPoint;
use rand_pcg::Pcg64Mcg;

use super::ball::{Ball, ball};
use crate::generate::inputs::Inputs;
use crate::generate::materials::palette::Crown;
use crate::generate::scenery::streams::{Purpose, place_number, stream};
use crate::generate::seeds::{between, chance, pick};
use crate::generate::shapes::{Frustum, Surface, at, frustum};
use crate::scene::{Layer, SceneBuilder};

/// The form of a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// A poplar, a yew.
    Column,
    /// A hornbeam, a lime.
    Cone,
    /// A serviceberry, a magnolia.
    Stems,
    /// A pine, a plane.
    Umbrella,
    /// A willow that is cut each year.
    Pollard,
    /// Just planted, with a stake.
    Young,
}

/// Forms as frequent as they are here.
const FORMS: [Form; 8] = [
    Form::Column,
    Form::Cone,
    Form::Cone,
    Form::Stems,
    Form::Umbrella,
    Form::Umbrella,
    Form::Pollard,
    Form::Young,
];

/// The stream of a tree at `p`, if it is of one of these forms.
pub(super) fn stream_at(inputs: &Inputs, p: MapPoint) -> Option<Pcg64Mcg> {
    let scenery = &inputs.options.scenery;
    let share = scenery.amounts.shapes;
    let mut rng = stream(scenery.seed, Purpose::Tree, place_number(p));
    (share > 0.0 && chance(&mut rng, share)).then_some(rng)
}

/// A tree under construction.
struct Tree<'a> {
    scene: &'a mut SceneBuilder,
    foot: MapPoint,
    /// Radius of the trunk at its foot, metres.
    girth: f64,
    bark: Surface,
    crown: Crown,
    rng: &'a mut Pcg64Mcg,
}

/// Builds a tree that stands on `p`, its trunk no thicker than `girth` metres.
pub(super) fn build(
    inputs: &Inputs,
    scene: &mut SceneBuilder,
    p: MapPoint,
    girth: f64,
    rng: &mut Pcg64Mcg,
) {
    let palette = &inputs.palette;
    let form = pick(rng, &FORMS);
    let crown = pick(rng, &palette.crowns);
    let mut tree = Tree {
        scene,
        foot: p,
        girth,
        bark: pick(rng, &[palette.bark, palette.bark, palette.pale_bark]),
        crown,
        rng,
    };
    match form {
        Form::Column => tree.column(),
        Form::Cone => tree.cone(),
        Form::Stems => tree.stems(),
        Form::Umbrella => tree.umbrella(),
        Form::Pollard => tree.pollard(),
        Form::Young => tree.young(palette.wood),
    }
}

impl Tree<'_> {
    fn trunk(&mut self, height: f64, radii: [f64; 2]) {
        let trunk = Frustum {
            center: self.foot,
            sides: 6,
            z: 0.0..height,
            radii,
        };
        frustum(self.scene, Layer::Both, self.bark, trunk);
    }

    /// A ball of leaves, so far from the trunk in a direction.
    fn leaves(&mut self, [direction, away]: [f64; 2], up: f64, [radius, half_height]: [f64; 2]) {
        let center = at(self.foot.offset(direction, away), up);
        // An opaque core in a shell with holes.
        let core = Ball {
            center,
            radius: radius * 0.8,
            half_height: half_height * 0.82,
        };
        ball(self.scene, self.crown.core, core, 0, self.rng);
        let shell = Ball {
            center,
            radius,
            half_height,
        };
        ball(self.scene, self.crown.shell, shell, 1, self.rng);
    }

    fn column(&mut self) {
        let height = between(self.rng, 6.0, 11.0);
        let radius = between(self.rng, 0.55, 0.8);
        self.trunk(1.2, [self.girth, self.girth * 0.9]);
        self.leaves([0.0, 0.0], height / 2.0 + 0.3, [radius, height / 2.0]);
    }

    fn cone(&mut self) {
        let height = between(self.rng, 5.0, 8.5);
        let width = height * between(self.rng, 0.16, 0.24);
        self.trunk(1.9, [self.girth, self.girth * 0.8]);
        // Three balls, narrower from the lowest on.
        for (share, size) in [(0.0, 1.0), (0.36, 0.72), (0.68, 0.42)] {
            let up = 1.7 + width * 0.8 + share * (height - 2.0);
            self.leaves([0.0, 0.0], up, [width * size, height * 0.24]);
        }
    }

    fn stems(&mut self) {
        let height = between(self.rng, 3.2, 5.0);
        let turn = between(self.rng, 0.0, TAU);
        for i in 0..3 {
            let direction = turn + TAU * f64::from(i) / 3.0;
            // Within the ground that the trunk keeps.
            let foot = self.foot.offset(direction, self.girth * 0.5);
            let stem = Frustum {
                center: foot,
                sides: 5,
                z: 0.0..height * 0.6,
                radii: [self.girth * 0.5, self.girth * 0.3],
            };
            frustum(self.scene, Layer::Both, self.bark, stem);
            let radius = between(self.rng, 0.8, 1.2);
            let up = height * between(self.rng, 0.55, 0.75);
            self.leaves([direction, 0.7], up, [radius, height * 0.26]);
        }
    }

    fn umbrella(&mut self) {
        let height = between(self.rng, 5.0, 7.5);
        let radius = between(self.rng, 2.4, 3.2);
        self.trunk(height - 0.4, [self.girth, self.girth * 0.75]);
        let turn = between(self.rng, 0.0, TAU);
        for i in 0..4 {
            let direction = turn + TAU * f64::from(i) / 4.0;
            let up = height + between(self.rng, -0.3, 0.3);
            self.leaves([direction, radius * 0.5], up, [radius * 0.6, 0.9]);
        }
    }

    fn pollard(&mut self) {
        let height = between(self.rng, 2.0, 2.8);
        self.trunk(height, [self.girth, self.girth * 1.0]);
        let radius = between(self.rng, 0.7, 1.1);
        self.leaves([0.0, 0.0], height + radius * 0.7, [radius, radius]);
    }

    fn young(&mut self, stake_of: Surface) {
        let height = between(self.rng, 2.2, 3.2);
        let thin = self.girth * 0.35;
        self.trunk(height, [thin, thin * 0.7]);
        let stake = Frustum {
            center: self.foot.offset(0.0, self.girth * 0.7),
            sides: 5,
            z: 0.0..1.6,
            radii: [0.035, 0.03],
        };
        frustum(self.scene, Layer::Both, stake_of, stake);
        self.leaves([0.0, 0.0], height + 0.2, [0.6, 0.8]);
    }
}
