//! The light that surfaces send to the camera, under any illumination.

use openbench_scene::Snapshot;
use openbench_scene::bvh::{LANES, MISS, PacketHits};

use super::block::{BLOCK, Block, PACKETS};
use super::illumination::{Faces, Illumination, Lamp, add_lamps};
use super::shade::{Glow, Look, Shader, Surfaces};

/// A scene under a light.
#[derive(Clone, Copy)]
pub(super) struct Lit<'a> {
    pub(super) seen: Snapshot<'a>,
    pub(super) light: &'a Illumination,
    /// The lamps that matter.
    pub(super) lamps: &'a [Lamp],
    pub(super) look: Look,
}

/// The rays of a block, and what they hit.
#[derive(Clone, Copy)]
pub(super) struct Sight<'a> {
    pub(super) origin: [f32; 3],
    pub(super) directions: &'a [Block; 3],
    pub(super) hits: &'a [PacketHits; PACKETS],
    /// 0 in the shadow and 1 in the sun.
    pub(super) sunlit: &'a Block,
}

impl Shader {
    /// Light of each pixel, by channel; 1 is that of white paper under the noon's sun.
    #[inline(always)]
    pub(super) fn radiance(&self, lit: Lit<'_>, sight: Sight<'_>) -> [Block; 3] {
        let [dx, dy, dz] = sight.directions;
        let mut length = [0.0; BLOCK];
        for i in 0..BLOCK {
            length[i] = (dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]).sqrt();
        }
        let mut colors = lit.light.sky(sight.directions, &length);
        if let Some(surfaces) = self.surfaces(lit.seen, sight.hits) {
            self.paint(lit, sight, &length, &surfaces, &mut colors);
        }
        // Colours are roots of light.
        for channel in &mut colors {
            for color in channel.iter_mut() {
                let root = *color * (1.0 / 255.0);
                *color = root * root;
            }
        }
        colors
    }

    /// Replaces the sky where a surface is hit.
    #[inline(always)]
    fn paint(
        &self,
        lit: Lit<'_>,
        sight: Sight<'_>,
        length: &Block,
        surfaces: &Surfaces,
        colors: &mut [Block; 3],
    ) {
        let directions = sight.directions;
        let (mut distance, mut facing) = ([0.0; BLOCK], [0.0; BLOCK]);
        let (mut texels, mut haze) = ([0.0; BLOCK], [0.0; BLOCK]);
        let mut faces = Faces {
            at: [[0.0; BLOCK]; 3],
            normal: [[0.0; BLOCK]; 3],
        };
        for i in 0..BLOCK {
            let [nx, ny, nz] = [0, 1, 2].map(|axis| surfaces.normal[axis][i]);
            let [dx, dy, dz] = [0, 1, 2].map(|axis| directions[axis][i]);
            facing[i] = (nx * dx + ny * dy + nz * dz) / length[i];
            distance[i] = surfaces.distance[i] * length[i];
            let slant = if facing[i].abs() > 0.15 {
                facing[i].abs()
            } else {
                0.15
            };
            texels[i] = distance[i] * lit.look.pixel_angle / slant * surfaces.density[i];
            haze[i] = distance[i] / (distance[i] + lit.look.haze);
        }
        for (axis, along) in directions.iter().enumerate() {
            for i in 0..BLOCK {
                // The normal that counts is the one towards the viewer.
                let side = if facing[i] > 0.0 { -1.0 } else { 1.0 };
                faces.normal[axis][i] = side * surfaces.normal[axis][i];
                faces.at[axis][i] = sight.origin[axis] + surfaces.distance[i] * along[i];
            }
        }
        let light = falling(lit, &faces, sight.sunlit);
        let glow = self.glow(lit, sight.hits);
        let texture = self.texels(surfaces, &texels);
        for channel in 0..3 {
            let horizon = lit.light.horizon[channel];
            for i in 0..BLOCK {
                const WHOLE: f32 = 1.0 / 255.0;
                let own = surfaces.color[channel][i] * texture[channel][i] * WHOLE;
                // Behind panes, which are dark by day, is a room; frames stay dark.
                let share = own * WHOLE;
                let clear = 1.0 - share * share;
                let clear = if clear > 0.0 { clear } else { 0.0 };
                let sent = share * share * light[channel][i] + clear * glow.behind[channel][i];
                let near = 255.0 * (sent + glow.own[channel][i]).sqrt();
                let far = near + haze[i] * (horizon - near);
                let sky = colors[channel][i];
                colors[channel][i] = if surfaces.hit[i] { far } else { sky };
            }
        }
    }

    /// What lamps and windows shine with.
    #[inline(always)]
    fn glow(&self, lit: Lit<'_>, hits: &[PacketHits; PACKETS]) -> Shine {
        let mut shine = Shine {
            own: [[0.0; BLOCK]; 3],
            behind: [[0.0; BLOCK]; 3],
        };
        let Illumination {
            lamp_glass,
            window,
            lit_windows,
            ..
        } = lit.light;
        if lamp_glass[0] <= 0.0 && *lit_windows <= 0.0 {
            return shine;
        }
        for i in 0..BLOCK {
            let triangle = hits[i / LANES].triangle[i % LANES];
            if triangle == MISS {
                continue;
            }
            let (plane, light) = match self.glow_of(triangle) {
                Glow::None => continue,
                Glow::Lamp => (&mut shine.own, lamp_glass),
                Glow::Window(drawn) if drawn < *lit_windows => (&mut shine.behind, window),
                Glow::Window(_) => continue,
            };
            for channel in 0..3 {
                plane[channel][i] = light[channel];
            }
        }
        shine
    }
}

/// Light that is not reflected.
struct Shine {
    /// From the surface itself.
    own: [Block; 3],
    /// From behind its dark parts.
    behind: [Block; 3],
}

/// The light that falls on surfaces.
#[inline(always)]
fn falling(lit: Lit<'_>, faces: &Faces, sunlit: &Block) -> [Block; 3] {
    let Illumination {
        towards_sun: [sx, sy, sz],
        sun,
        ambient,
        ..
    } = lit.light;
    let [nx, ny, nz] = &faces.normal;
    let (mut direct, mut from_sky) = ([0.0; BLOCK], [0.0; BLOCK]);
    for i in 0..BLOCK {
        let lambert = nx[i] * sx + ny[i] * sy + nz[i] * sz;
        let lambert = if lambert > 0.0 { lambert } else { 0.0 };
        direct[i] = lambert * sunlit[i];
        // A surface that faces up receives more light from the sky.
        from_sky[i] = 0.75 + 0.25 * nz[i];
    }
    let mut light = [[0.0; BLOCK]; 3];
    for channel in 0..3 {
        for i in 0..BLOCK {
            light[channel][i] = ambient[channel] * from_sky[i] + sun[channel] * direct[i];
        }
    }
    add_lamps(&mut light, lit.lamps, faces);
    light
}
