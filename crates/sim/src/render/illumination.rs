//! The light on a scene: sun, sky, lamps, lit windows, haze.

use openbench_core::Pose3;
use openbench_scene::Sun;
use openbench_scene::bvh::{LANES, Lane};

use super::block::{BLOCK, Block, PACKETS, TILE};
use super::shade::{HORIZON, ZENITH};

/// Most lamps that light an image: the nearest ones.
pub(crate) const MOST_LAMPS: usize = 30;
/// Lamps farther than this from the camera light nothing that it sees well, metres.
const LAMP_RANGE_M: f64 = 60.0;
/// A surface is never nearer to a lamp than this, metres squared: light grows without bound there.
const NEAREST_SQUARE: f32 = 0.04;

/// The light on a scene. Light is linear, and 1 is that on a surface which faces the noon's sun.
/// Colours of the sky are roots of light, 255 for 1, as those of images are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Illumination {
    /// Direction towards the sun; unit length.
    pub(crate) towards_sun: [f32; 3],
    /// Light of the sun on a surface that faces it, by channel; zero without a sun.
    pub(crate) sun: [f32; 3],
    /// Light of the sky on a surface that faces up, by channel.
    pub(crate) ambient: [f32; 3],
    /// Colour of the sky at the horizon.
    pub(crate) horizon: [f32; 3],
    /// Colour of the sky at the zenith.
    pub(crate) zenith: [f32; 3],
    /// Colour that is added around the sun.
    pub(crate) glow: [f32; 3],
    /// Whether objects cast shadows.
    pub(crate) shadows: bool,
    /// Lamps that shine.
    pub(crate) lamps: Vec<Lamp>,
    /// Light from the glass of lamps, by channel.
    pub(crate) lamp_glass: [f32; 3],
    /// Share of the windows that are lit.
    pub(crate) lit_windows: f32,
    /// Light from lit windows, by channel.
    pub(crate) window: [f32; 3],
    /// Share of the light that is lost on each metre through the air, for short ways.
    pub(crate) extinction: f32,
    /// How far wet roads and pavements are mirrors, 0 to 1.
    pub(crate) wetness: f32,
}

/// A lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lamp {
    /// Position in `map`, metres.
    pub(crate) at: [f32; 3],
    /// Direction in which it shines most; unit length.
    pub(crate) axis: [f32; 3],
    /// Light at a distance of 1 m along the axis, by channel.
    pub(crate) strength: [f32; 3],
    /// Cosine of the angle from the axis at which the cone of light ends.
    pub(crate) edge: f32,
    /// Growth of the light with the cosine, from that edge inwards, until it is whole.
    pub(crate) sharpness: f32,
}

impl Illumination {
    /// That of a scene as it is without any condition, apart from shadows.
    pub(crate) fn of(sun: &Sun) -> Self {
        Self {
            towards_sun: sun.direction.map(|c| -c),
            sun: [sun.diffuse; 3],
            ambient: [sun.ambient; 3],
            horizon: HORIZON,
            zenith: ZENITH,
            glow: [0.0; 3],
            shadows: false,
            lamps: Vec::new(),
            lamp_glass: [0.0; 3],
            lit_windows: 0.0,
            window: [0.0; 3],
            extinction: 0.0,
            wetness: 0.0,
        }
    }

    /// The lamps that light what a camera at `pose` sees, the nearest first.
    pub(crate) fn lamps_near(&self, pose: &Pose3) -> Vec<Lamp> {
        let eye = pose.translation.vector;
        let square = |lamp: &Lamp| {
            let at = nalgebra::Vector3::from(lamp.at.map(f64::from));
            (at - eye).norm_squared()
        };
        let within = |lamp: &&Lamp| square(lamp) <= LAMP_RANGE_M * LAMP_RANGE_M;
        let mut near: Vec<Lamp> = self.lamps.iter().filter(within).copied().collect();
        // A stable sort: lamps at equal distances keep their order.
        near.sort_by(|a, b| square(a).total_cmp(&square(b)));
        near.truncate(MOST_LAMPS);
        near
    }

    /// Colours of the sky in these directions.
    #[inline(always)]
    pub(super) fn sky(&self, directions: &[Block; 3], length: &Block) -> [Block; 3] {
        let [dx, dy, dz] = directions;
        let [sx, sy, sz] = self.towards_sun;
        let (mut height, mut near_sun) = ([0.0; BLOCK], [0.0; BLOCK]);
        for i in 0..BLOCK {
            let up = dz[i] / length[i];
            height[i] = (if up > 0.0 { up } else { 0.0 }).sqrt();
            let cosine = (dx[i] * sx + dy[i] * sy + dz[i] * sz) / length[i];
            let cosine = if cosine > 0.0 { cosine } else { 0.0 };
            let fourth = cosine * cosine * cosine * cosine;
            // Near the sun, and near the horizon, where the light's way through air is long.
            near_sun[i] = fourth * fourth * (1.0 - 0.7 * height[i]);
        }
        let mut colors = [[0.0; BLOCK]; 3];
        for (channel, colors) in colors.iter_mut().enumerate() {
            let (low, glow) = (self.horizon[channel], self.glow[channel]);
            let rise = self.zenith[channel] - low;
            for i in 0..BLOCK {
                colors[i] = low + height[i] * rise + near_sun[i] * glow;
            }
        }
        colors
    }
}

/// Points and normals of the surfaces that a block shows; normals towards the viewer.
pub(super) struct Faces {
    pub(super) at: [Block; 3],
    pub(super) normal: [Block; 3],
}

/// Corners of a packet's tile: upper left, upper right, lower left, lower right.
const CORNERS: [usize; 4] = [0, TILE - 1, LANES - TILE, LANES - 1];

/// The largest square of the distance between opposite corners of a tile whose light is
/// interpolated, metres squared. Farther apart there may be a pool of light between them.
const INTERPOLATED_SQUARE: f32 = 0.25;

/// Adds the light of lamps, which falls with the square of the distance. Where a packet shows one
/// triangle, as `uniform` says, and little of it, it is computed at the corners of the tile and
/// interpolated.
#[inline(always)]
pub(super) fn add_lamps(
    light: &mut [Block; 3],
    lamps: &[Lamp],
    faces: &Faces,
    uniform: &[bool; PACKETS],
) {
    if lamps.is_empty() {
        return;
    }
    let mut even = *uniform;
    for (packet, even) in even.iter_mut().enumerate() {
        *even &= is_small(faces, packet);
    }
    if even.contains(&true) {
        let corner = |lane: usize| LANES * (lane / 4) + CORNERS[lane % 4];
        let sum = lamplight(lamps, &Places::at(faces, corner));
        for packet in (0..PACKETS).filter(|packet| even[*packet]) {
            for (light, sum) in light.iter_mut().zip(&sum) {
                let first = 4 * packet;
                let corners = [sum[first], sum[first + 1], sum[first + 2], sum[first + 3]];
                add_between(&mut light[LANES * packet..][..LANES], corners);
            }
        }
    }
    for packet in (0..PACKETS).filter(|packet| !even[*packet]) {
        let sum = lamplight(lamps, &Places::at(faces, |lane| LANES * packet + lane));
        for (light, sum) in light.iter_mut().zip(&sum) {
            for (light, sum) in light[LANES * packet..][..LANES].iter_mut().zip(sum) {
                *light += sum;
            }
        }
    }
}

/// Whether the corners of a tile are near to each other on the surface.
#[inline(always)]
fn is_small(faces: &Faces, packet: usize) -> bool {
    let (mut falling, mut rising) = (0.0, 0.0);
    for at in &faces.at {
        let [a, b, c, d] = [
            at[LANES * packet + CORNERS[0]],
            at[LANES * packet + CORNERS[1]],
            at[LANES * packet + CORNERS[2]],
            at[LANES * packet + CORNERS[3]],
        ];
        falling += (a - d) * (a - d);
        rising += (b - c) * (b - c);
    }
    falling < INTERPOLATED_SQUARE && rising < INTERPOLATED_SQUARE
}

/// Adds to the pixels of a tile what lies between the values at its corners.
#[inline(always)]
fn add_between(tile: &mut [f32], [a, b, c, d]: [f32; 4]) {
    const STEP: f32 = 1.0 / (TILE - 1) as f32;
    for (lane, value) in tile.iter_mut().enumerate() {
        let (u, v) = ((lane % TILE) as f32 * STEP, (lane / TILE) as f32 * STEP);
        let upper = a + u * (b - a);
        let lower = c + u * (d - c);
        *value += upper + v * (lower - upper);
    }
}

/// Places on surfaces, one in each lane.
struct Places {
    at: [Lane; 3],
    normal: [Lane; 3],
}

impl Places {
    #[inline(always)]
    fn at(faces: &Faces, pixel: impl Fn(usize) -> usize) -> Self {
        let mut places = Self {
            at: [[0.0; LANES]; 3],
            normal: [[0.0; LANES]; 3],
        };
        for axis in 0..3 {
            for lane in 0..LANES {
                places.at[axis][lane] = faces.at[axis][pixel(lane)];
                places.normal[axis][lane] = faces.normal[axis][pixel(lane)];
            }
        }
        places
    }
}

/// The light of lamps at places, by channel.
#[inline(always)]
fn lamplight(lamps: &[Lamp], places: &Places) -> [Lane; 3] {
    let ([px, py, pz], [nx, ny, nz]) = (&places.at, &places.normal);
    let mut light = [[0.0; LANES]; 3];
    for lamp in lamps {
        let mut share = [0.0; LANES];
        let ([lx, ly, lz], [ax, ay, az]) = (lamp.at, lamp.axis);
        for i in 0..LANES {
            let (x, y, z) = (lx - px[i], ly - py[i], lz - pz[i]);
            let square = x * x + y * y + z * z;
            let square = if square > NEAREST_SQUARE {
                square
            } else {
                NEAREST_SQUARE
            };
            let inverse = 1.0 / square.sqrt();
            let facing = (x * nx[i] + y * ny[i] + z * nz[i]) * inverse;
            let facing = if facing > 0.0 { facing } else { 0.0 };
            let inside = (-(x * ax + y * ay + z * az) * inverse - lamp.edge) * lamp.sharpness;
            let inside = if inside > 0.0 { inside } else { 0.0 };
            let inside = if inside < 1.0 { inside } else { 1.0 };
            share[i] = facing * inside * inverse * inverse;
        }
        for (light, strength) in light.iter_mut().zip(lamp.strength) {
            for i in 0..LANES {
                light[i] += strength * share[i];
            }
        }
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(at: [f32; 3]) -> Lamp {
        Lamp {
            at,
            axis: [0.0, 0.0, -1.0],
            strength: [100.0; 3],
            edge: 0.0,
            sharpness: 1.0,
        }
    }

    #[test]
    fn light_falls_with_the_square_of_the_distance() {
        let below = |height: f32| {
            let mut light = [[0.0; BLOCK]; 3];
            let mut faces = Faces {
                at: [[0.0; BLOCK]; 3],
                normal: [[0.0; BLOCK]; 3],
            };
            faces.normal[2] = [1.0; BLOCK];
            let lamps = [lamp([0.0, 0.0, height])];
            add_lamps(&mut light, &lamps, &faces, &[true, false, true, false]);
            assert_eq!(light[0][5], light[0][LANES]);
            light[0][5]
        };
        assert!((below(5.0) - 4.0).abs() < 1e-3 && (below(10.0) - 1.0).abs() < 1e-3);
        // Nothing shines upwards, and a surface at the lamp itself is lit finitely.
        assert_eq!(below(-5.0), 0.0);
        assert!(below(0.0).is_finite());
    }

    #[test]
    fn light_between_the_corners_of_tiles_is_nearly_that_of_each_pixel() {
        use super::super::block::PLACES;

        let plane = |step: f32| {
            let mut faces = Faces {
                at: [[0.0; BLOCK]; 3],
                normal: [[0.0; BLOCK]; 3],
            };
            faces.at[0] = PLACES[0].map(|column| step * column);
            faces.at[1] = PLACES[1].map(|row| 2.0 - 0.5 * step * row);
            faces.normal[2] = [1.0; BLOCK];
            faces
        };
        let lamps = [lamp([0.3, 1.0, 3.0]), lamp([-2.0, 2.5, 4.0])];
        let lit = |step: f32, uniform: bool| {
            let mut light = [[0.0; BLOCK]; 3];
            add_lamps(&mut light, &lamps, &plane(step), &[uniform; PACKETS]);
            light[1]
        };
        let (between, each) = (lit(0.05, true), lit(0.05, false));
        assert_ne!(between, each);
        for (between, each) in between.iter().zip(&each) {
            assert!((between / each - 1.0).abs() < 2e-3, "{between} {each}");
        }
        assert!(each[0] != each[BLOCK - 1] && each[1] != each[TILE]);
        // Tiles that show much of a surface are not interpolated.
        assert_eq!(lit(1.0, true), lit(1.0, false));
    }

    #[test]
    fn only_the_nearest_lamps_light_an_image() {
        let mut light = Illumination::of(&Sun::default());
        light.lamps = (0..100).map(|i| lamp([i as f32, 0.0, 5.0])).collect();
        let near = light.lamps_near(&Pose3::translation(20.0, 0.0, 0.0));
        assert_eq!(near.len(), MOST_LAMPS);
        assert_eq!(near[0].at[0], 20.0);
        assert!(near.iter().all(|lamp| (lamp.at[0] - 20.0).abs() <= 15.0));
    }
}
