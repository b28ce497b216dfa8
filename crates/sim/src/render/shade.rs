//! The colours of sixteen pixels, lane by lane as the rays are cast.

use openbench_scene::bvh::{LANES, MISS, PacketHits};
use openbench_scene::{RayCaster, RayPacket, Sun};

use super::texture::Mipmaps;

/// Sky at the horizon and at the zenith, sRGB, 0 to 255.
const HORIZON: [f32; 3] = [204.0, 222.0, 237.0];
const ZENITH: [f32; 3] = [107.0, 153.0, 219.0];

type Lane = [f32; LANES];

/// What colouring needs to know of a triangle.
#[derive(Debug, Clone, Copy)]
struct Facet {
    normal: [f32; 3],
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

impl Shader {
    pub(super) fn new(caster: &RayCaster) -> Self {
        let scene = caster.scene();
        let facet = |i: usize| Facet {
            normal: caster.surface(i as u32).normal,
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
    pub(super) fn colors(
        &self,
        caster: &RayCaster,
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
        let facets = self.facets_of(hits);
        let (light, footprint, haze) = self.light(look, rays, hits, &length, &facets, sunlit);
        let mut colors = sky(dz, &length);
        for lane in (0..LANES).filter(|&lane| hits.triangle[lane] != MISS) {
            let base = self.albedo(caster, hits, lane, &facets[lane], footprint[lane]);
            for channel in 0..3 {
                let near = base[channel] * light[lane];
                colors[channel][lane] = near + haze[lane] * (HORIZON[channel] - near);
            }
        }
        colors
    }

    fn facets_of(&self, hits: &PacketHits) -> [Facet; LANES] {
        let mut facets = [Facet { normal: [0.0; 3], density: 0.0, material: 0 }; LANES];
        for (facet, &triangle) in facets.iter_mut().zip(&hits.triangle) {
            if triangle != MISS {
                *facet = self.facets[triangle as usize];
            }
        }
        facets
    }

    /// For each lane: by how much its colour is multiplied, texels that its pixel covers, and the share of haze.
    fn light(
        &self,
        look: Look,
        rays: &RayPacket,
        hits: &PacketHits,
        length: &Lane,
        facets: &[Facet; LANES],
        sunlit: &Lane,
    ) -> (Lane, Lane, Lane) {
        let (mut light, mut footprint, mut haze) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let sun = self.sun.direction;
        for lane in 0..LANES {
            let n = facets[lane].normal;
            let [dx, dy, dz] = [0, 1, 2].map(|axis| rays.direction[axis][lane]);
            let facing = (n[0] * dx + n[1] * dy + n[2] * dz) / length[lane];
            let side = if facing > 0.0 { -1.0 } else { 1.0 };
            let lambert = -side * (n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]);
            let lambert = if lambert > 0.0 { lambert } else { 0.0 };
            // A surface that looks up sees more of the sky.
            let from_sky = 0.75 + 0.25 * side * n[2];
            let linear = self.sun.ambient * from_sky + self.sun.diffuse * lambert * sunlit[lane];
            // Light adds up in linear units, colours are sRGB: their curve is near a square root.
            light[lane] = linear.sqrt();
            let distance = hits.distance[lane] * length[lane];
            let slant = if facing.abs() > 0.15 { facing.abs() } else { 0.15 };
            footprint[lane] = distance * look.pixel_angle / slant * facets[lane].density;
            haze[lane] = distance / (distance + look.haze);
        }
        (light, footprint, haze)
    }

    #[inline]
    fn albedo(
        &self,
        caster: &RayCaster,
        hits: &PacketHits,
        lane: usize,
        facet: &Facet,
        texels: f32,
    ) -> [f32; 3] {
        let ink = &self.inks[facet.material as usize];
        let Some(texture) = ink.texture else { return ink.color };
        let uv = caster.texture_coordinates(&hits.hit(lane));
        let texel = self.textures[texture as usize].sample(uv, texels);
        const WHOLE: f32 = 1.0 / 255.0;
        [ink.color[0] * texel[0] * WHOLE, ink.color[1] * texel[1] * WHOLE, ink.color[2] * texel[2] * WHOLE]
    }
}

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
