//! The light that surfaces send to the camera, under any illumination.

use openbench_scene::Snapshot;
use openbench_scene::bvh::{LANES, MISS, PacketHits};

use super::block::{BLOCK, Block, PACKETS};
use super::illumination::{Faces, Illumination, Lamp, add_lamps};
use super::shade::{Glow, Look, Shader, Surfaces, is_uniform};
use super::shadows::sunlit_by_samples;

/// Share of its own light that wet stone loses.
const WET_DARKENING: f32 = 0.55;
/// Share of the mirrored light that a rough, wet road keeps together.
const MIRROR: f32 = 0.5;
/// Share of the light that water mirrors at a right angle.
const WATER_FRESNEL: f32 = 0.02;
/// The same of a pane, whose faces mirror 4 % each.
const PANE_FRESNEL: f32 = 0.08;

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
    /// Time of the rays relative to the instant of the movers, seconds.
    pub(super) lag: f32,
}

impl Shader {
    /// Light of each pixel, by channel; 1 is that of white paper under the noon's sun. `surfaces`
    /// are room to work in.
    #[inline(always)]
    pub(super) fn radiance(
        &self,
        surfaces: &mut Surfaces,
        lit: Lit<'_>,
        sight: Sight<'_>,
    ) -> [Block; 3] {
        let [dx, dy, dz] = sight.directions;
        let mut length = [0.0; BLOCK];
        for i in 0..BLOCK {
            length[i] = (dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]).sqrt();
        }
        let mut colors = lit.light.sky(sight.directions, &length);
        if self.look_up(surfaces, lit.seen, sight.hits) {
            self.paint(lit, sight, &length, surfaces, &mut colors);
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
            // What air leaves of the light, by the series of the exponential function.
            let way = lit.light.extinction * distance[i];
            let series = 1.0 + way * (1.0 + way * (0.5 + way * (1.0 / 6.0 + way / 24.0)));
            haze[i] = 1.0 - lit.look.haze / ((distance[i] + lit.look.haze) * series);
        }
        for (axis, along) in directions.iter().enumerate() {
            for i in 0..BLOCK {
                // The normal that counts is the one towards the viewer.
                let side = if facing[i] > 0.0 { -1.0 } else { 1.0 };
                faces.normal[axis][i] = side * surfaces.normal[axis][i];
                faces.at[axis][i] = sight.origin[axis] + surfaces.distance[i] * along[i];
            }
        }
        let sunlit = if lit.light.shadows {
            sunlit_by_samples(lit.seen, sight.lag, &faces, lit.light.towards_sun)
        } else {
            [1.0; BLOCK]
        };
        let mut uniform = [false; PACKETS];
        for (uniform, hits) in uniform.iter_mut().zip(sight.hits) {
            *uniform = is_uniform(hits);
        }
        let light = falling(lit, &faces, &sunlit, &uniform);
        let glow = self.glow(lit, sight.hits);
        let texture = self.texels(surfaces, &texels);
        let mirror = self.mirror(lit, sight, length, surfaces, &faces, &facing);
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
                // Wet stone is darker, and mirrors the sky.
                let sent = sent * (1.0 - WET_DARKENING * mirror.water[i]);
                let share = mirror.share[i] * (1.0 - mirror.pane[i] * (1.0 - clear));
                let sent = sent + share * (mirror.sky[channel][i] - sent);
                let near = 255.0 * (sent + glow.own[channel][i]).sqrt();
                let far = near + haze[i] * (horizon - near);
                let sky = colors[channel][i];
                colors[channel][i] = if surfaces.hit[i] { far } else { sky };
            }
        }
    }

    /// Wet paved ground and panes, which mirror the sky: after Fresnel, in Schlick's form (1994).
    /// Houses are not mirrored.
    #[inline(always)]
    fn mirror(
        &self,
        lit: Lit<'_>,
        sight: Sight<'_>,
        length: &Block,
        surfaces: &Surfaces,
        faces: &Faces,
        facing: &Block,
    ) -> Mirror {
        let mut mirror = Mirror {
            water: [0.0; BLOCK],
            pane: [0.0; BLOCK],
            share: [0.0; BLOCK],
            sky: [[0.0; BLOCK]; 3],
        };
        let is_wet = lit.light.wetness > 0.0;
        if !is_wet && !surfaces.any_pane {
            return mirror;
        }
        if is_wet {
            for i in 0..BLOCK {
                let triangle = sight.hits[i / LANES].triangle[i % LANES];
                let is_level = faces.normal[2][i] > 0.7;
                if triangle != MISS && is_level && self.is_paved(triangle) {
                    mirror.water[i] = lit.light.wetness;
                }
            }
        }
        let mut mirrored = *sight.directions;
        for i in 0..BLOCK {
            let pane = if surfaces.pane[i] { 1.0 } else { 0.0 };
            mirror.pane[i] = pane;
            // Water is level, whatever the ground under it.
            let normal = [
                pane * faces.normal[0][i],
                pane * faces.normal[1][i],
                pane * faces.normal[2][i] + (1.0 - pane),
            ];
            let along = mirrored[0][i] * normal[0]
                + mirrored[1][i] * normal[1]
                + mirrored[2][i] * normal[2];
            for axis in 0..3 {
                mirrored[axis][i] -= 2.0 * along * normal[axis];
            }
            let graze = 1.0 - facing[i].abs();
            let square = graze * graze;
            let steep = WATER_FRESNEL + pane * (PANE_FRESNEL - WATER_FRESNEL);
            let fresnel = steep + (1.0 - steep) * square * square * graze;
            mirror.share[i] = fresnel * (pane + (1.0 - pane) * MIRROR * mirror.water[i]);
        }
        mirror.sky = lit.light.sky(&mirrored, length);
        for channel in &mut mirror.sky {
            for color in channel.iter_mut() {
                let root = *color * (1.0 / 255.0);
                *color = root * root;
            }
        }
        mirror
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

/// What the surfaces of a block mirror.
struct Mirror {
    /// Water on it; 0 where it is dry.
    water: Block,
    /// 1 where it is a pane, of which only what is dark is glass, else 0.
    pane: Block,
    /// Share of the light that it mirrors.
    share: Block,
    /// The light of the sky that it mirrors.
    sky: [Block; 3],
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
fn falling(lit: Lit<'_>, faces: &Faces, sunlit: &Block, uniform: &[bool; PACKETS]) -> [Block; 3] {
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
    add_lamps(&mut light, lit.lamps, faces, uniform);
    light
}
