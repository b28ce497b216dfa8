//! Clipped hedges: never quite straight.

use nalgebra::Point3;
use openbench_core::{MapPoint, Pose2};
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::seeds::{Purpose, between, stream};
use super::shapes::{Corner, Surface, at, cuboid};
use crate::scene::{Layer, SceneBuilder};

/// Distance between the cross sections of a hedge, metres, where there are few and where there are many.
const SECTION: (f64, f64) = (1.2, 4.0);
/// Sections of one stretch at most.
const MAX_SECTIONS: usize = 1_000;
/// The cross section: share of half the thickness, share of the height.
const PROFILE: [(f64, f64); 6] = [
    (-0.86, 0.0),
    (-1.0, 0.55),
    (-0.82, 0.96),
    (0.82, 0.96),
    (1.0, 0.55),
    (0.86, 0.0),
];
/// How far a corner is off its place, metres.
const DENT: f64 = 0.05;

impl Site {
    /// A hedge from `a` to `b`; height and thickness in metres. What a robot touches is a box.
    pub(super) fn hedge(&mut self, (a, b): (MapPoint, MapPoint), (height, thick): (f64, f64)) {
        let (pose, length) = (Pose2::new(a.x, a.y, a.bearing_to(b)), a.distance(b));
        let surface = self.palette.hedge;
        let half = thick / 2.0;
        cuboid(
            &mut self.builder,
            Layer::Solid,
            surface,
            pose,
            ([0.0, -half, 0.0], [length, half, height]),
        );
        let spacing = if self.detailed { SECTION.0 } else { SECTION.1 };
        let count = ((length / spacing) as usize).clamp(1, MAX_SECTIONS);
        let place = (a.x * 10.0) as i64 ^ ((a.y * 10.0) as i64) << 24;
        let mut rng = stream(self.seed, Purpose::Barrier, place as u64 | 1 << 63);
        let sections: Vec<[Point3<f64>; 6]> = (0..=count)
            .map(|i| {
                section(
                    pose,
                    length * i as f64 / count as f64,
                    (half, height),
                    &mut rng,
                )
            })
            .collect();
        for (i, pair) in sections.windows(2).enumerate() {
            let (from, to) = (
                length * i as f64 / count as f64,
                length * (i + 1) as f64 / count as f64,
            );
            ribs(&mut self.builder, surface, (&pair[0], from), (&pair[1], to));
        }
        end(&mut self.builder, surface, &sections[0], true);
        end(&mut self.builder, surface, &sections[count], false);
    }
}

fn section(
    pose: Pose2,
    x: f64,
    (half, height): (f64, f64),
    rng: &mut Pcg64Mcg,
) -> [Point3<f64>; 6] {
    PROFILE.map(|(side, up)| {
        let dent = |rng: &mut Pcg64Mcg| between(rng, -DENT, DENT);
        let p = pose.transform(x, side * half + dent(rng));
        at(
            p,
            if up > 0.0 {
                up * height + dent(rng)
            } else {
                0.0
            },
        )
    })
}

/// The surface between two cross sections that are `from` and `to` metres along the hedge.
fn ribs(
    builder: &mut SceneBuilder,
    surface: Surface,
    (first, from): (&[Point3<f64>; 6], f64),
    (second, to): (&[Point3<f64>; 6], f64),
) {
    let tile = |v: f64| (v / surface.tile) as f32;
    let mut round = 0.0;
    let mut corners: Vec<Corner> = Vec::with_capacity(12);
    for k in 0..6 {
        round += if k > 0 {
            (first[k] - first[k - 1]).norm()
        } else {
            0.0
        };
        corners.push((first[k], [tile(from), tile(round)]));
        corners.push((second[k], [tile(to), tile(round)]));
    }
    let faces: Vec<[u32; 3]> = (0..5)
        .flat_map(|k| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]])
        .collect();
    builder.mesh(Layer::Visible, surface.material, &corners, &faces);
}

fn end(builder: &mut SceneBuilder, surface: Surface, section: &[Point3<f64>; 6], is_first: bool) {
    let uv = |p: &Point3<f64>| {
        let run = ((p.x - section[0].x).powi(2) + (p.y - section[0].y).powi(2)).sqrt();
        [(run / surface.tile) as f32, (p.z / surface.tile) as f32]
    };
    let corners: Vec<Corner> = section.iter().map(|p| (*p, uv(p))).collect();
    let fan = (2..6).map(|i| {
        if is_first {
            [0, i - 1, i]
        } else {
            [0, i, i - 1]
        }
    });
    builder.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &fan.collect::<Vec<_>>(),
    );
}
