//! The colours of a block of pixels.
//!
//! Surface, material and texels of each pixel are looked up into arrays first. All arithmetic is in
//! loops over those arrays, which become vector instructions. The compiler unrolls loops over
//! sixteen or fewer before it looks for vectors, and then it misses many: hence blocks of
//! [`BLOCK`].

use std::ops::Range;

use openbench_scene::bvh::{LANES, MISS, PacketHits};
use openbench_scene::{Finish, RayCaster, SemanticClass, Snapshot, Sun, Triangle};

use super::block::{BLOCK, Block, PACKETS};
use super::texture::{Mipmaps, blend, corners};

/// Colours of the sky at the horizon and at the zenith, sRGB, 0 to 255.
pub(super) const HORIZON: [f32; 3] = [204.0, 222.0, 237.0];
pub(super) const ZENITH: [f32; 3] = [107.0, 153.0, 219.0];

/// The properties of a triangle that its colour depends on.
#[derive(Debug, Clone, Copy)]
struct Facet {
    /// Texels of its texture per metre.
    density: f32,
    material: u32,
    /// Whether it is a pane, which mirrors.
    pane: bool,
}

/// A material's colour, 0 to 255, and its texture.
#[derive(Debug, Clone, Copy)]
struct Ink {
    color: [f32; 3],
    texture: Option<u32>,
}

/// Colours the surfaces that rays hit.
#[derive(Debug)]
pub(super) struct Shader {
    facets: Vec<Facet>,
    inks: Vec<Ink>,
    textures: Vec<Mipmaps>,
    glows: Vec<Glow>,
    /// Whether water stands on the triangle when it rains.
    paved: Vec<bool>,
    sun: Sun,
}

/// How a triangle shines where lamps are lit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Glow {
    None,
    Lamp,
    /// With a number from 0 to 1 that both triangles of a window share.
    Window(f32),
}

/// The properties of a view that colours depend on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// Angle of a pixel, radians.
    pub(super) pixel_angle: f32,
    /// Distance at which half of a surface's colour has faded into the haze, metres.
    pub(super) haze: f32,
}

/// The surfaces that the rays of a block hit. Pixels without one have no normal and no texture;
/// their other numbers are left from another block.
pub(super) struct Surfaces {
    pub(super) normal: [Block; 3],
    /// Texels of the texture per metre.
    pub(super) density: Block,
    /// Colour of the material, 0 to 255.
    pub(super) color: [Block; 3],
    texture: [Option<u32>; BLOCK],
    /// Coordinates in the texture.
    uv: [Block; 2],
    /// Distance in lengths of the direction.
    pub(super) distance: Block,
    pub(super) hit: [bool; BLOCK],
    /// Whether it is a pane.
    pub(super) pane: [bool; BLOCK],
    pub(super) any_pane: bool,
}

impl Surfaces {
    pub(super) const NONE: Self = Self {
        normal: [[0.0; BLOCK]; 3],
        density: [0.0; BLOCK],
        color: [[0.0; BLOCK]; 3],
        texture: [None; BLOCK],
        uv: [[0.0; BLOCK]; 2],
        distance: [0.0; BLOCK],
        hit: [false; BLOCK],
        pane: [false; BLOCK],
        any_pane: false,
    };

    /// Forgets what these pixels showed.
    #[inline(always)]
    fn clear(&mut self, pixels: Range<usize>) {
        for along in &mut self.normal {
            along[pixels.clone()].fill(0.0);
        }
        self.texture[pixels.clone()].fill(None);
        self.hit[pixels].fill(false);
    }
}

/// The changes to a surface's own colour.
struct Light {
    /// Factor on it.
    strength: Block,
    /// Texels of the full-size texture that the pixel covers.
    texels: Block,
    /// Share of the haze's colour, 0 to 1.
    haze: Block,
}

impl Shader {
    pub(super) fn new(caster: &RayCaster) -> Self {
        let scene = caster.scene();
        let facet = |i: usize| Facet {
            density: texel_density(caster, i as u32),
            material: scene.triangles[i].material.0,
            pane: caster.surface(i as u32).finish == Finish::Glass,
        };
        let ink = |m: &openbench_scene::Material| Ink {
            color: m.color.map(|c| 255.0 * c),
            texture: m.texture.map(|t| t.0),
        };
        Self {
            facets: (0..scene.triangles.len()).map(facet).collect(),
            inks: scene.materials.iter().map(ink).collect(),
            textures: scene.textures.iter().map(Mipmaps::new).collect(),
            glows: glows(caster),
            paved: scene
                .triangles
                .iter()
                .map(|t| is_paved(caster, t))
                .collect(),
            sun: scene.sun,
        }
    }

    /// Red, green and blue of each pixel, 0 to 255. `sunlit` is 0 in the shadow and 1 in the sun;
    /// `surfaces` are room to work in.
    #[inline(always)]
    pub(super) fn colors(
        &self,
        surfaces: &mut Surfaces,
        seen: Snapshot<'_>,
        look: Look,
        directions: &[Block; 3],
        hits: &[PacketHits; PACKETS],
        sunlit: &Block,
    ) -> [Block; 3] {
        let [dx, dy, dz] = directions;
        let mut length = [0.0; BLOCK];
        for i in 0..BLOCK {
            length[i] = (dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]).sqrt();
        }
        let mut colors = sky(dz, &length);
        // Blocks of sky alone need no lighting.
        if !self.look_up(surfaces, seen, hits) {
            return colors;
        }
        let light = self.light(look, directions, &length, surfaces, sunlit);
        let texels = self.texels(surfaces, &light.texels);
        for channel in 0..3 {
            for i in 0..BLOCK {
                const WHOLE: f32 = 1.0 / 255.0;
                let own = surfaces.color[channel][i] * texels[channel][i] * WHOLE;
                let near = own * light.strength[i];
                let far = near + light.haze[i] * (HORIZON[channel] - near);
                colors[channel][i] = if surfaces.hit[i] {
                    far
                } else {
                    colors[channel][i]
                };
            }
        }
        colors
    }

    /// Looks up the surfaces of a block; whether any ray hit one. They are not returned, since they
    /// are 3 kB, and copies of them show in the time of an image.
    #[inline(always)]
    pub(super) fn look_up(
        &self,
        surfaces: &mut Surfaces,
        seen: Snapshot<'_>,
        hits: &[PacketHits; PACKETS],
    ) -> bool {
        surfaces.any_pane = false;
        let mut any = false;
        for (packet, hits) in hits.iter().enumerate() {
            any |= if is_uniform(hits) {
                self.fill(surfaces, seen, hits, packet)
            } else {
                self.gather(surfaces, seen, hits, packet)
            };
        }
        any
    }

    /// Looks up what each lane of a packet hit; whether any did.
    #[inline(always)]
    fn gather(
        &self,
        surfaces: &mut Surfaces,
        seen: Snapshot<'_>,
        hits: &PacketHits,
        packet: usize,
    ) -> bool {
        let mut any = false;
        for lane in 0..LANES {
            let (i, triangle) = (packet * LANES + lane, hits.triangle[lane]);
            if triangle == MISS {
                surfaces.clear(i..i + 1);
                continue;
            }
            any = true;
            let facet = &self.facets[triangle as usize];
            let ink = &self.inks[facet.material as usize];
            let normal = seen.normal(hits, lane);
            for (axis, along) in normal.into_iter().enumerate() {
                surfaces.normal[axis][i] = along;
                surfaces.color[axis][i] = ink.color[axis];
            }
            surfaces.density[i] = facet.density;
            surfaces.texture[i] = ink.texture;
            [surfaces.uv[0][i], surfaces.uv[1][i]] =
                seen.caster.texture_coordinates(&hits.hit(lane));
            surfaces.distance[i] = hits.distance[lane];
            surfaces.hit[i] = true;
            surfaces.pane[i] = facet.pane;
            surfaces.any_pane |= facet.pane;
        }
        any
    }

    /// The same where all lanes hit one triangle, as in most packets: one look-up is enough.
    #[inline(always)]
    fn fill(
        &self,
        surfaces: &mut Surfaces,
        seen: Snapshot<'_>,
        hits: &PacketHits,
        packet: usize,
    ) -> bool {
        let (triangle, first) = (hits.triangle[0], packet * LANES);
        let lanes = first..first + LANES;
        if triangle == MISS {
            surfaces.clear(lanes);
            return false;
        }
        let facet = &self.facets[triangle as usize];
        let ink = &self.inks[facet.material as usize];
        let normal = seen.normal(hits, 0);
        for (axis, along) in normal.into_iter().enumerate() {
            surfaces.normal[axis][lanes.clone()].fill(along);
            surfaces.color[axis][lanes.clone()].fill(ink.color[axis]);
        }
        surfaces.density[lanes.clone()].fill(facet.density);
        surfaces.texture[lanes.clone()].fill(ink.texture);
        surfaces.distance[lanes.clone()].copy_from_slice(&hits.distance);
        surfaces.hit[lanes.clone()].fill(true);
        surfaces.pane[lanes].fill(facet.pane);
        surfaces.any_pane |= facet.pane;
        let [a, b, c] = seen.caster.texture_corners(triangle);
        for (axis, uv) in surfaces.uv.iter_mut().enumerate() {
            for lane in 0..LANES {
                let (u, v) = (hits.u[lane], hits.v[lane]);
                uv[first + lane] = (1.0 - u - v) * a[axis] + u * b[axis] + v * c[axis];
            }
        }
        true
    }

    /// How a triangle shines where lamps are lit.
    #[inline(always)]
    pub(super) fn glow_of(&self, triangle: u32) -> Glow {
        self.glows[triangle as usize]
    }

    /// Whether water stands on a triangle when it rains.
    #[inline(always)]
    pub(super) fn is_paved(&self, triangle: u32) -> bool {
        self.paved[triangle as usize]
    }

    #[inline(always)]
    fn light(
        &self,
        look: Look,
        directions: &[Block; 3],
        length: &Block,
        surfaces: &Surfaces,
        sunlit: &Block,
    ) -> Light {
        let mut light = Light {
            strength: [0.0; BLOCK],
            texels: [0.0; BLOCK],
            haze: [0.0; BLOCK],
        };
        let (sun, [nx, ny, nz]) = (self.sun.direction, &surfaces.normal);
        let [dx, dy, dz] = directions;
        for i in 0..BLOCK {
            let facing = (nx[i] * dx[i] + ny[i] * dy[i] + nz[i] * dz[i]) / length[i];
            // The normal that counts is the one towards the viewer: triangles have two sides.
            let side = if facing > 0.0 { -1.0 } else { 1.0 };
            let lambert = -side * (nx[i] * sun[0] + ny[i] * sun[1] + nz[i] * sun[2]);
            let lambert = if lambert > 0.0 { lambert } else { 0.0 };
            // A surface that faces up receives more light from the sky.
            let from_sky = 0.75 + 0.25 * side * nz[i];
            let linear = self.sun.ambient * from_sky + self.sun.diffuse * lambert * sunlit[i];
            // Light adds up linearly. Colours are sRGB, whose curve is near a square root.
            light.strength[i] = linear.sqrt();
            let distance = surfaces.distance[i] * length[i];
            // A floor under the cosine: at grazing angles a pixel would cover texels without bound.
            let slant = if facing.abs() > 0.15 {
                facing.abs()
            } else {
                0.15
            };
            light.texels[i] = distance * look.pixel_angle / slant * surfaces.density[i];
            light.haze[i] = distance / (distance + look.haze);
        }
        light
    }

    /// Colours of the textures, 0 to 255; white without a texture.
    #[inline(always)]
    pub(super) fn texels(&self, surfaces: &Surfaces, texels: &Block) -> [Block; 3] {
        let levels = super::texture::levels(texels);
        let mut images = [None; BLOCK];
        let mut size = [[1; BLOCK]; 2];
        let mut any = false;
        for i in 0..BLOCK {
            let Some(texture) = surfaces.texture[i] else {
                continue;
            };
            let image = self.textures[texture as usize].level(levels[i]);
            (size[0][i], size[1][i]) = (image.width, image.height);
            images[i] = Some(image);
            any = true;
        }
        if !any {
            return [[255.0; BLOCK]; 3];
        }
        let corners = corners(&surfaces.uv, &size);
        // White in all channels: pixels without a texture keep their material's colour.
        let mut packed = [[u32::MAX; BLOCK]; 4];
        for i in 0..BLOCK {
            let Some(image) = images[i] else { continue };
            for (packed, index) in packed.iter_mut().zip(&corners.index) {
                packed[i] = image.texel(index[i]);
            }
        }
        blend(&packed, &corners)
    }
}

/// Whether all lanes hit one triangle of one mover, or none hit any.
#[inline(always)]
pub(super) fn is_uniform(hits: &PacketHits) -> bool {
    let mut differing = 0;
    for lane in 0..LANES {
        differing |= hits.triangle[lane] ^ hits.triangle[0];
        differing |= hits.mover[lane] ^ hits.mover[0];
    }
    differing == 0
}

/// How each triangle shines where lamps are lit.
fn glows(caster: &RayCaster) -> Vec<Glow> {
    let scene = caster.scene();
    let mut glows: Vec<Glow> = Vec::with_capacity(scene.triangles.len());
    for (number, triangle) in scene.triangles.iter().enumerate() {
        let material = &scene.materials[triangle.material.0 as usize];
        let glow = match material.finish {
            Finish::Lamp => Glow::Lamp,
            // Rooms are behind the panes of houses, not of cars.
            Finish::Glass if material.class == SemanticClass::Building => {
                let before = number.checked_sub(1).map(|before| &scene.triangles[before]);
                match (before, glows.last()) {
                    (Some(before), Some(glow @ Glow::Window(_))) if adjoin(before, triangle) => {
                        *glow
                    }
                    _ => Glow::Window(drawn(number as u32)),
                }
            }
            Finish::Glass | Finish::Matt => Glow::None,
        };
        glows.push(glow);
    }
    glows
}

fn is_paved(caster: &RayCaster, triangle: &Triangle) -> bool {
    let class = caster.scene().materials[triangle.material.0 as usize].class;
    matches!(
        class,
        SemanticClass::Road | SemanticClass::Pavement | SemanticClass::Kerb
    )
}

/// Whether two triangles have an edge in common.
fn adjoin(a: &Triangle, b: &Triangle) -> bool {
    let shared = a.corners.iter().filter(|corner| b.corners.contains(corner));
    shared.count() >= 2
}

/// A number from 0 to 1 for a triangle.
fn drawn(number: u32) -> f32 {
    // The golden section of 2^32 spreads neighbouring numbers evenly.
    (number.wrapping_mul(0x9e37_79b9) >> 8) as f32 / 16_777_216.0
}

#[inline(always)]
fn sky(dz: &Block, length: &Block) -> [Block; 3] {
    let mut colors = [[0.0; BLOCK]; 3];
    let mut t = [0.0; BLOCK];
    for i in 0..BLOCK {
        let up = dz[i] / length[i];
        t[i] = (if up > 0.0 { up } else { 0.0 }).sqrt();
    }
    for channel in 0..3 {
        for i in 0..BLOCK {
            colors[channel][i] = HORIZON[channel] + t[i] * (ZENITH[channel] - HORIZON[channel]);
        }
    }
    colors
}

/// Texels of a triangle's texture per metre: the geometric mean over both directions.
fn texel_density(caster: &RayCaster, triangle: u32) -> f32 {
    let Some(texture) = caster.material(triangle).texture else {
        return 0.0;
    };
    let scene = caster.scene();
    let image = &scene.textures[texture.0 as usize];
    let [a, b, c] = scene.triangles[triangle as usize]
        .corners
        .map(|i| scene.vertices[i as usize]);
    let edge = |p: [f32; 3], q: [f32; 3]| [0, 1, 2].map(|i| q[i] - p[i]);
    let (e1, e2) = (edge(a.position, b.position), edge(a.position, c.position));
    let cross = [
        e1[1] * e2[2] - e1[2] * e2[1],
        e1[2] * e2[0] - e1[0] * e2[2],
        e1[0] * e2[1] - e1[1] * e2[0],
    ];
    // Twice the triangle's area, as is the determinant of the texture coordinates below: the
    // factors cancel. A triangle without area must not divide by zero.
    let area = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2])
        .sqrt()
        .max(1e-12);
    let (u1, v1, u2, v2) = (
        b.uv[0] - a.uv[0],
        b.uv[1] - a.uv[1],
        c.uv[0] - a.uv[0],
        c.uv[1] - a.uv[1],
    );
    let texels = (u1 * v2 - u2 * v1).abs() * image.width as f32 * image.height as f32;
    (texels / area).sqrt()
}
