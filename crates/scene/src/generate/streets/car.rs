//! One car: a saloon, a hatchback or a van, in one of the usual paints.

use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::Point3;
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::signed_area;
use rand_pcg::Pcg64Mcg;

use crate::generate::materials::palette::{PAINTS, Palette};
use crate::generate::seeds::pick;
use crate::generate::shapes::{Block, Surface, at, cuboid, facet};
use crate::material::{Finish, Material, SemanticClass};
use crate::scene::{Corner, Layer, Scene, SceneBuilder};
use crate::triangulate::triangulate;

/// Half the length of a car, metres.
pub(super) const HALF_LENGTH_M: f64 = 2.2;
/// Half the width of a car, metres.
pub(super) const HALF_WIDTH_M: f64 = 0.87;
/// Height of the lamps, metres.
const LAMP_HEIGHT_M: f64 = 0.68;
/// By how much the roof is narrower than the body on each side, metres.
const LEAN_M: f64 = 0.2;
/// Distance of the side windows in front of the body, metres.
const GLASS_RELIEF_M: f64 = 0.012;
/// Distance of the axles of most cars from the middle, metres.
const AXLE_M: f64 = 1.3;
/// Height of the axles, metres.
const AXLE_HEIGHT_M: f64 = 0.31;
/// Width of a tyre, metres.
const TYRE_WIDTH_M: f64 = 0.2;

/// A point of a car seen from its side, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct SidePoint {
    pub forward: f64,
    pub up: f64,
}

pub(super) const fn p(forward: f64, up: f64) -> SidePoint {
    SidePoint { forward, up }
}

/// A car seen from its left.
pub(super) struct Shape {
    pub outline: &'static [SidePoint],
    /// The segments of the outline that are glass.
    pub glass: &'static [usize],
    /// The side window.
    pub window: &'static [SidePoint],
    /// Heights between which the sides lean in, metres.
    pub waist: Range<f64>,
    /// Distance of the axles from the middle, metres.
    pub axle: f64,
}

/// How far the outline of a car reaches at some height, metres forward.
struct Ends {
    front: f64,
    back: f64,
}

impl Shape {
    fn ends(&self, height: f64) -> Ends {
        // The height crosses the outline once in front and once at the back.
        let next = self.outline.iter().cycle().skip(1);
        let sides = self.outline.iter().zip(next);
        let crossing = sides.filter(|(p, q)| (p.up > height) != (q.up > height));
        let at = crossing
            .map(|(p, q)| p.forward + (q.forward - p.forward) * (height - p.up) / (q.up - p.up));
        let none = Ends {
            front: f64::NEG_INFINITY,
            back: f64::INFINITY,
        };
        at.fold(none, |ends, x| Ends {
            front: x.max(ends.front),
            back: x.min(ends.back),
        })
    }

    /// Half the width of the car at a height, metres.
    fn half_width(&self, z: f64) -> f64 {
        let share = (z - self.waist.start) / (self.waist.end - self.waist.start);
        HALF_WIDTH_M - LEAN_M * share.clamp(0.0, 1.0)
    }
}

static SALOON: Shape = Shape {
    outline: &[
        p(-2.10, 0.18),
        p(2.12, 0.18),
        p(2.20, 0.52),
        p(2.12, 0.76),
        p(1.20, 0.92),
        p(0.50, 1.38),
        p(-0.80, 1.42),
        p(-1.50, 1.00),
        p(-2.12, 0.94),
        p(-2.20, 0.56),
    ],
    glass: &[4, 6],
    window: &[p(1.02, 0.97), p(0.46, 1.33), p(-0.76, 1.36), p(-1.28, 1.02)],
    waist: 0.92..1.42,
    axle: AXLE_M,
};
static HATCHBACK: Shape = Shape {
    outline: &[
        p(-1.92, 0.18),
        p(1.92, 0.18),
        p(2.00, 0.54),
        p(1.92, 0.80),
        p(1.15, 0.96),
        p(0.42, 1.46),
        p(-1.20, 1.50),
        p(-1.86, 1.02),
        p(-1.98, 0.60),
    ],
    glass: &[4, 6],
    window: &[p(0.98, 1.02), p(0.38, 1.40), p(-1.14, 1.43), p(-1.60, 1.06)],
    waist: 0.96..1.50,
    axle: AXLE_M,
};
static VAN: Shape = Shape {
    outline: &[
        p(-2.20, 0.20),
        p(2.16, 0.20),
        p(2.22, 0.60),
        p(2.14, 0.90),
        p(1.62, 1.10),
        p(0.95, 1.82),
        p(0.70, 1.90),
        p(-2.14, 1.90),
        p(-2.22, 1.00),
    ],
    glass: &[4],
    window: &[p(1.40, 1.14), p(0.86, 1.74), p(0.10, 1.76), p(0.10, 1.14)],
    // The upper end lies above the roof: the sides of a van lean in by half as much.
    waist: 1.10..2.60,
    axle: AXLE_M,
};
/// Shapes as frequent as they are here.
static SHAPES: [&Shape; 5] = [&SALOON, &HATCHBACK, &SALOON, &HATCHBACK, &VAN];

/// Shape and surfaces of a car. Body and tyres are solid as they are drawn, so that a robot meets a
/// car where its sensors see one.
pub(super) struct Car {
    shape: &'static Shape,
    paint: Surface,
    glass: Surface,
    tyre: Surface,
    rim: Surface,
    /// White in front, red at the back.
    lights: [Surface; 2],
}

/// A car of random shape and paint.
pub(super) fn draw(palette: &Palette, rng: &mut Pcg64Mcg) -> Car {
    Car {
        shape: pick(rng, &SHAPES),
        paint: pick(rng, &palette.car_paints),
        glass: palette.car_glass,
        tyre: palette.tyre,
        rim: palette.rim,
        lights: palette.car_lights,
    }
}

/// A car at the origin that faces along x, its wheels on z = 0: number `look` of the shapes and
/// paints of parked cars, which repeat.
pub fn car_figure(look: u32) -> Scene {
    let look = look as usize;
    let mut scene = SceneBuilder::new();
    let mut surface = |color: [f32; 3], reflectivity: Option<u8>, finish: Finish| {
        let plain = Material::plain(SemanticClass::Vehicle, color);
        let reflectivity = reflectivity.unwrap_or(plain.reflectivity);
        let material = scene.material(Material {
            reflectivity,
            finish,
            ..plain
        });
        Surface {
            material,
            tile: 1.0,
        }
    };
    let car = Car {
        shape: SHAPES[look % SHAPES.len()],
        // 3 and the number of paints have no common divisor, so all of them come in turn.
        paint: surface(PAINTS[(look * 3 + 1) % PAINTS.len()], None, Finish::Matt),
        glass: surface([0.10, 0.13, 0.16], Some(8), Finish::Glass),
        tyre: surface([0.07; 3], Some(8), Finish::Matt),
        rim: surface([0.58, 0.60, 0.62], None, Finish::Matt),
        lights: [
            surface([0.94, 0.94, 0.90], Some(200), Finish::Matt),
            surface([0.60, 0.06, 0.06], Some(200), Finish::Matt),
        ],
    };
    car.build(&mut scene, Pose2::default());
    scene.build()
}

impl Car {
    /// The same car in another shape.
    pub fn shaped(self, shape: &'static Shape) -> Self {
        Self { shape, ..self }
    }

    /// Where the car ends behind and in front at a height, metres from its middle.
    pub fn ends(&self, up: f64) -> [f64; 2] {
        let outline = self.shape.outline;
        let crossings = (0..outline.len()).filter_map(|i| {
            let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
            let crosses = (p.up <= up) != (q.up <= up);
            crosses.then(|| p.forward + (q.forward - p.forward) * (up - p.up) / (q.up - p.up))
        });
        crossings.fold([0.0, 0.0], |[back, front], at| {
            [back.min(at), front.max(at)]
        })
    }

    /// Builds the car on a pose.
    pub fn build(&self, scene: &mut SceneBuilder, pose: Pose2) {
        let shape = self.shape;
        let place = |p: SidePoint, side: f64, out: f64| {
            at(
                pose.transform(p.forward, side * (shape.half_width(p.up) + out)),
                p.up,
            )
        };
        let n = shape.outline.len();
        for i in 0..n {
            let (p, q) = (shape.outline[i], shape.outline[(i + 1) % n]);
            let surface = if shape.glass.contains(&i) {
                self.glass
            } else {
                self.paint
            };
            let left = 1.0;
            // A face from side to side over each segment of the outline; the flanks close it.
            let quad = [
                place(p, -left, 0.0),
                place(q, -left, 0.0),
                place(q, left, 0.0),
                place(p, left, 0.0),
            ];
            facet(scene, Layer::Both, surface, &quad);
        }
        for side in [-1.0, 1.0] {
            let body = |p| place(p, side, 0.0);
            flank(scene, Layer::Both, self.paint, side, shape.outline, body);
            let window = |p| place(p, side, GLASS_RELIEF_M);
            flank(
                scene,
                Layer::Visible,
                self.glass,
                side,
                shape.window,
                window,
            );
        }
        self.wheels(scene, pose);
        self.lamps(scene, pose);
    }

    fn wheels(&self, scene: &mut SceneBuilder, pose: Pose2) {
        for x in [self.shape.axle, -self.shape.axle] {
            for side in [-1.0, 1.0] {
                let wheel = Wheel {
                    x,
                    side,
                    radius: 0.31,
                    out: 0.0,
                };
                tyre(scene, pose, &wheel, self.tyre);
                let rim = Wheel {
                    x,
                    side,
                    radius: 0.17,
                    out: 0.006,
                };
                facet(scene, Layer::Visible, self.rim, &rim.disc(pose));
            }
        }
    }

    fn lamps(&self, scene: &mut SceneBuilder, pose: Pose2) {
        let [white, red] = self.lights;
        let Ends { front, back } = self.shape.ends(LAMP_HEIGHT_M);
        for side in [-0.62, 0.62] {
            let lamp = |x: f64| Block {
                min: [x - 0.015, side - 0.16, LAMP_HEIGHT_M - 0.06],
                max: [x + 0.015, side + 0.16, LAMP_HEIGHT_M + 0.06],
            };
            cuboid(scene, Layer::Visible, white, pose, lamp(front));
            cuboid(scene, Layer::Visible, red, pose, lamp(back));
        }
    }
}

/// A filled outline on the left (`side` 1) or the right (-1) of a car.
fn flank(
    scene: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    side: f64,
    outline: &[SidePoint],
    place: impl Fn(SidePoint) -> Point3<f64>,
) {
    let mut flat: Vec<MapPoint> = outline
        .iter()
        .map(|p| MapPoint::new(p.forward, p.up))
        .collect();
    if signed_area(&flat) < 0.0 {
        flat.reverse();
    }
    for [a, b, c] in triangulate(&flat, &[]) {
        // Seen from the right, the outline runs counter-clockwise; from the left, the other way
        // round.
        let order = if side < 0.0 { [a, b, c] } else { [a, c, b] };
        let corners = order.map(|q| Corner::new(place(p(q.x, q.y)), [0.0, 0.0]));
        scene.mesh(layer, surface.material, &corners, &[[0, 1, 2]]);
    }
}

/// A wheel, metres.
struct Wheel {
    /// Forward of the middle of the car.
    x: f64,
    /// On the left 1, on the right -1.
    side: f64,
    radius: f64,
    /// How far it stands out.
    out: f64,
}

/// Corners of a wheel.
const WHEEL_CORNERS: usize = 10;

impl Wheel {
    /// A corner, `depth` metres inside.
    fn corner(&self, pose: Pose2, i: usize, depth: f64) -> Point3<f64> {
        // Reversed on the left, so that both discs face outwards.
        let i = if self.side < 0.0 {
            i
        } else {
            WHEEL_CORNERS - i
        };
        let (sin, cos) = libm::sincos(TAU * i as f64 / WHEEL_CORNERS as f64);
        let left = self.side * (HALF_WIDTH_M + 0.015 + self.out - depth);
        let p = pose.transform(self.x + self.radius * cos, left);
        at(p, AXLE_HEIGHT_M + self.radius * sin)
    }

    fn disc(&self, pose: Pose2) -> Vec<Point3<f64>> {
        (0..WHEEL_CORNERS)
            .map(|i| self.corner(pose, i, 0.0))
            .collect()
    }
}

/// A disc with a tread.
fn tyre(scene: &mut SceneBuilder, pose: Pose2, wheel: &Wheel, surface: Surface) {
    facet(scene, Layer::Both, surface, &wheel.disc(pose));
    for i in 0..WHEEL_CORNERS {
        let tread = [
            wheel.corner(pose, i + 1, 0.0),
            wheel.corner(pose, i, 0.0),
            wheel.corner(pose, i, TYRE_WIDTH_M),
            wheel.corner(pose, i + 1, TYRE_WIDTH_M),
        ];
        facet(scene, Layer::Both, surface, &tread);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_stand_in_the_body() {
        for shape in SHAPES {
            let Ends { front, back } = shape.ends(LAMP_HEIGHT_M);
            assert!((1.9..2.2).contains(&front), "{front}");
            assert!((-2.22..-1.9).contains(&back), "{back}");
        }
    }
}
