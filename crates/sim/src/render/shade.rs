//! The colours of sixteen pixels, lane by lane as the rays are cast.
//!
//! Whatever is looked up for a lane (surface, material, texels) is put into arrays of sixteen first; all arithmetic is loops over those, which
//! become vector instructions.

use openbench_scene::bvh::{LANES, Lane, MISS, PacketHits};
use openbench_scene::{RayCaster, RayPacket, Snapshot, Sun};

use super::texture::{Mipmaps, Places, blend};

/// Sky at the horizon and at the zenith, sRGB, 0 to 255.
const HORIZON: [f32; 3] = [204.0, 222.0, 237.0];
const ZENITH: [f32; 3] = [107.0, 153.0, 219.0];

/// What colouring needs to know of a triangle.
#[derive(Debug, Clone, Copy)]
struct Facet {
    /// Texels a metre of its texture.
    density: f32,
    material: u32,
}

/// A material's colour, 0 to 255, and its texture.
#[derive(Debug, Clone, Copy)]
struct Ink {
    color: [f32; 3],
    texture: Option<u32>,
}

/// Colours what rays hit.
#[derive(Debug)]
pub(super) struct Shader {
    facets: Vec<Facet>,
    inks: Vec<Ink>,
    textures: Vec<Mipmaps>,
    sun: Sun,
}

/// How a view looks at a scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// Angle of a pixel, radians.
    pub(super) pixel_angle: f32,
    /// Distance at which half of a surface's colour has faded into the haze, metres.
    pub(super) haze: f32,
}

/// What sixteen rays hit.
struct Surfaces {
    normal: [Lane; 3],
    density: Lane,
    /// Colour of the material, 0 to 255.
    color: [Lane; 3],
    texture: [Option<u32>; LANES],
}

/// What becomes of a surface's own colour.
struct Light {
    /// By how much it is multiplied.
    strength: Lane,
    /// Texels of the full-size texture that the pixel covers.
    texels: Lane,
    /// Share of the haze.
    haze: Lane,
}

impl Shader {
    pub(super) fn new(caster: &RayCaster) -> Self {
        let scene = caster.scene();
        let facet = |i: usize| Facet {
            density: texel_density(caster, i as u32),
            material: scene.triangles[i].material.0,
        };
        let ink = |m: &openbench_scene::Material| Ink {
            color: m.color.map(|c| 255.0 * c),
            texture: m.texture.map(|t| t.0),
        };
        Self {
            facets: (0..scene.triangles.len()).map(facet).collect(),
            inks: scene.materials.iter().map(ink).collect(),
            textures: scene.textures.iter().map(Mipmaps::new).collect(),
            sun: scene.sun,
        }
    }

    /// Red, green and blue of each lane, 0 to 255. Lanes with `sunlit` 0 lie in shadow, with 1 in the sun.
    #[inline(always)]
    pub(super) fn colors(
        &self,
        seen: Snapshot<'_>,
        look: Look,
        rays: &RayPacket,
        hits: &PacketHits,
        sunlit: &Lane,
    ) -> [Lane; 3] {
        let [dx, dy, dz] = &rays.direction;
        let mut length = [0.0; LANES];
        for lane in 0..LANES {
            length[lane] = (dx[lane] * dx[lane] + dy[lane] * dy[lane] + dz[lane] * dz[lane]).sqrt();
        }
        let mut colors = sky(dz, &length);
        let Some(surfaces) = self.surfaces(seen, hits) else { return colors };
        let light = self.light(look, rays, hits, &length, &surfaces, sunlit);
        let texels = self.texels(seen.caster, hits, &surfaces.texture, &light.texels);
        for channel in 0..3 {
            for lane in 0..LANES {
                const WHOLE: f32 = 1.0 / 255.0;
                let own = surfaces.color[channel][lane] * texels[channel][lane] * WHOLE;
                let near = own * light.strength[lane];
                let far = near + light.haze[lane] * (HORIZON[channel] - near);
                let hit = hits.triangle[lane] != MISS;
                colors[channel][lane] = if hit { far } else { colors[channel][lane] };
            }
        }
        colors
    }

    /// `None` if no ray hit anything.
    #[inline(always)]
    fn surfaces(&self, seen: Snapshot<'_>, hits: &PacketHits) -> Option<Surfaces> {
        let mut surfaces = Surfaces {
            normal: [[0.0; LANES]; 3],
            density: [0.0; LANES],
            color: [[0.0; LANES]; 3],
            texture: [None; LANES],
        };
        let mut any = false;
        for lane in 0..LANES {
            if hits.triangle[lane] == MISS {
                continue;
            }
            any = true;
            let facet = &self.facets[hits.triangle[lane] as usize];
            let ink = &self.inks[facet.material as usize];
            let normal = seen.normal(hits, lane);
            for (axis, along) in normal.into_iter().enumerate() {
                surfaces.normal[axis][lane] = along;
                surfaces.color[axis][lane] = ink.color[axis];
            }
            surfaces.density[lane] = facet.density;
            surfaces.texture[lane] = ink.texture;
        }
        any.then_some(surfaces)
    }

    #[inline(always)]
    fn light(
        &self,
        look: Look,
        rays: &RayPacket,
        hits: &PacketHits,
        length: &Lane,
        surfaces: &Surfaces,
        sunlit: &Lane,
    ) -> Light {
        let mut light = Light { strength: [0.0; LANES], texels: [0.0; LANES], haze: [0.0; LANES] };
        let (sun, [nx, ny, nz]) = (self.sun.direction, &surfaces.normal);
        let [dx, dy, dz] = &rays.direction;
        for lane in 0..LANES {
            let facing = (nx[lane] * dx[lane] + ny[lane] * dy[lane] + nz[lane] * dz[lane]) / length[lane];
            let side = if facing > 0.0 { -1.0 } else { 1.0 };
            let lambert = -side * (nx[lane] * sun[0] + ny[lane] * sun[1] + nz[lane] * sun[2]);
            let lambert = if lambert > 0.0 { lambert } else { 0.0 };
            // A surface that looks up sees more of the sky.
            let from_sky = 0.75 + 0.25 * side * nz[lane];
            let linear = self.sun.ambient * from_sky + self.sun.diffuse * lambert * sunlit[lane];
            // Light adds up in linear units, colours are sRGB: their curve is near a square root.
            light.strength[lane] = linear.sqrt();
            let distance = hits.distance[lane] * length[lane];
            let slant = if facing.abs() > 0.15 { facing.abs() } else { 0.15 };
            light.texels[lane] = distance * look.pixel_angle / slant * surfaces.density[lane];
            light.haze[lane] = distance / (distance + look.haze);
        }
        light
    }

    /// Colours of the textures, 0 to 255; white without one.
    #[inline(always)]
    fn texels(
        &self,
        caster: &RayCaster,
        hits: &PacketHits,
        textures: &[Option<u32>; LANES],
        texels: &Lane,
    ) -> [Lane; 3] {
        let levels = super::texture::levels(texels);
        let mut places = Places::none();
        let mut images = [None; LANES];
        for lane in 0..LANES {
            let Some(texture) = textures[lane] else { continue };
            let image = self.textures[texture as usize].level(levels[lane]);
            let uv = caster.texture_coordinates(&hits.hit(lane));
            places.set(lane, uv, image.width, image.height);
            images[lane] = Some(image);
        }
        if images.iter().all(Option::is_none) {
            return [[255.0; LANES]; 3];
        }
        let corners = places.corners();
        let mut packed = [[u32::MAX; LANES]; 4];
        for lane in 0..LANES {
            let Some(image) = images[lane] else { continue };
            for (packed, index) in packed.iter_mut().zip(&corners.index) {
                packed[lane] = image.texel(index[lane]);
            }
        }
        blend(&packed, &corners)
    }
}

#[inline(always)]
fn sky(dz: &Lane, length: &Lane) -> [Lane; 3] {
    let mut colors = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let up = dz[lane] / length[lane];
        let t = if up > 0.0 { up.sqrt() } else { 0.0 };
        for channel in 0..3 {
            colors[channel][lane] = HORIZON[channel] + t * (ZENITH[channel] - HORIZON[channel]);
        }
    }
    colors
}

/// Texels that a metre on the triangle spans, the larger of the two directions not told apart.
fn texel_density(caster: &RayCaster, triangle: u32) -> f32 {
    let Some(texture) = caster.material(triangle).texture else { return 0.0 };
    let scene = caster.scene();
    let image = &scene.textures[texture.0 as usize];
    let [a, b, c] = scene.triangles[triangle as usize].corners.map(|i| scene.vertices[i as usize]);
    let edge = |p: [f32; 3], q: [f32; 3]| [0, 1, 2].map(|i| q[i] - p[i]);
    let (e1, e2) = (edge(a.position, b.position), edge(a.position, c.position));
    let cross = [e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]];
    let area = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt().max(1e-12);
    let (u1, v1, u2, v2) = (b.uv[0] - a.uv[0], b.uv[1] - a.uv[1], c.uv[0] - a.uv[0], c.uv[1] - a.uv[1]);
    let texels = (u1 * v2 - u2 * v1).abs() * image.width as f32 * image.height as f32;
    (texels / area).sqrt()
}
