//! Pictures of a scene by casting rays: sun, sky, textures with mipmaps.

use openbench_core::Pose3;
use openbench_scene::bvh::LANES;
use openbench_scene::{Hit, RayCaster, RayPacket, Texture};

/// Side of the square of pixels that one packet covers.
const TILE: u32 = 4;
/// Sky at the horizon and at the zenith, sRGB.
const HORIZON: [f32; 3] = [0.80, 0.87, 0.93];
const ZENITH: [f32; 3] = [0.42, 0.60, 0.86];

/// A pinhole camera: x forward, y left, z up, as `camera_link`.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Pose in `map`.
    pub pose: Pose3,
    /// Columns and rows.
    pub size: (u32, u32),
    /// Focal length, pixels.
    pub focal_length: f64,
    /// Distance beyond which nothing is seen, metres. At it, half of a surface's colour has faded into the haze.
    pub range: f32,
}

/// Draws views of a scene.
#[derive(Debug)]
pub struct Renderer {
    caster: RayCaster,
    textures: Vec<Mipmaps>,
    /// For each triangle: texels a metre of its texture.
    density: Vec<f32>,
}

impl Renderer {
    /// Prepares a scene for drawing.
    pub fn new(caster: RayCaster) -> Self {
        let scene = caster.scene().clone();
        let textures = scene.textures.iter().map(Mipmaps::new).collect();
        let count = scene.triangles.len() as u32;
        let density = (0..count).map(|t| texel_density(&caster, t)).collect();
        Self { caster, textures, density }
    }

    /// The view's pixels: RGB, rows from the top.
    pub fn render(&self, view: &View) -> Vec<u8> {
        let (width, height) = view.size;
        let mut rgb = vec![0; 3 * (width * height) as usize];
        let eye = Eye::new(view);
        let mut hits: [Option<Hit>; LANES] = [None; LANES];
        for y in (0..height).step_by(TILE as usize) {
            for x in (0..width).step_by(TILE as usize) {
                let pixel = |lane: usize| (x + lane as u32 % TILE, y + lane as u32 / TILE);
                let mut packet = RayPacket::idle();
                for lane in 0..LANES {
                    let (u, v) = pixel(lane);
                    packet.set(lane, eye.origin, eye.direction(u, v), view.range);
                }
                self.caster.cast_packet(&packet, &mut hits);
                for (lane, hit) in hits.iter().enumerate() {
                    let (u, v) = pixel(lane);
                    if u < width && v < height {
                        let color = self.shade(&eye, eye.direction(u, v), hit.as_ref());
                        let at = 3 * (v * width + u) as usize;
                        rgb[at..at + 3]
                            .copy_from_slice(&color.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8));
                    }
                }
            }
        }
        rgb
    }

    fn shade(&self, eye: &Eye, direction: [f32; 3], hit: Option<&Hit>) -> [f32; 3] {
        let length =
            (direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]).sqrt();
        let sky = sky(direction[2] / length);
        let Some(hit) = hit else { return sky };
        let normal = self.caster.surface(hit.triangle).normal;
        let facing =
            (normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2]) / length;
        let towards_eye = if facing > 0.0 { -1.0 } else { 1.0 };
        let sun = self.caster.scene().sun;
        let lambert = -towards_eye * (0..3).map(|i| normal[i] * sun.direction[i]).sum::<f32>();
        // A surface that looks up sees more of the sky.
        let from_sky = 0.75 + 0.25 * towards_eye * normal[2];
        let light = sun.ambient * from_sky + sun.diffuse * lambert.max(0.0);
        let base = self.albedo(eye, hit, length, facing.abs());
        let distance = hit.distance * length;
        let haze = distance / (distance + eye.range);
        [0, 1, 2].map(|i| base[i] * light * (1.0 - haze) + HORIZON[i] * haze)
    }

    fn albedo(&self, eye: &Eye, hit: &Hit, length: f32, facing: f32) -> [f32; 3] {
        let material = self.caster.material(hit.triangle);
        let Some(texture) = material.texture else { return material.color };
        let footprint = hit.distance * length * eye.pixel_angle / facing.max(0.15);
        let texels = footprint * self.density[hit.triangle as usize];
        let texel = self.textures[texture.0 as usize].sample(self.caster.texture_coordinates(hit), texels);
        [0, 1, 2].map(|i| material.color[i] * texel[i])
    }
}

fn sky(up: f32) -> [f32; 3] {
    let t = up.clamp(0.0, 1.0).sqrt();
    [0, 1, 2].map(|i| HORIZON[i] + t * (ZENITH[i] - HORIZON[i]))
}

/// Where a view looks from, and along which ray each pixel looks.
struct Eye {
    origin: [f32; 3],
    corner: [f32; 3],
    right: [f32; 3],
    down: [f32; 3],
    pixel_angle: f32,
    range: f32,
}

impl Eye {
    fn new(view: &View) -> Self {
        let axis = |v: nalgebra::Vector3<f64>| view.pose.rotation * v;
        let (forward, left, up) =
            (axis(nalgebra::Vector3::x()), axis(nalgebra::Vector3::y()), axis(nalgebra::Vector3::z()));
        let f = view.focal_length;
        let (w, h) = (f64::from(view.size.0), f64::from(view.size.1));
        // The middle of the top left pixel.
        let corner = forward + left * ((w - 1.0) / 2.0 / f) + up * ((h - 1.0) / 2.0 / f);
        let plain = |v: nalgebra::Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        Self {
            origin: plain(view.pose.translation.vector),
            corner: plain(corner),
            right: plain(-left / f),
            down: plain(-up / f),
            pixel_angle: (1.0 / f) as f32,
            range: view.range,
        }
    }

    fn direction(&self, u: u32, v: u32) -> [f32; 3] {
        [0, 1, 2].map(|i| self.corner[i] + u as f32 * self.right[i] + v as f32 * self.down[i])
    }
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

/// A texture at full, half, quarter … size.
#[derive(Debug)]
struct Mipmaps {
    levels: Vec<Texture>,
}

impl Mipmaps {
    fn new(texture: &Texture) -> Self {
        let mut levels = vec![texture.clone()];
        while let Some(last) = levels.last().filter(|t| t.width > 1 && t.height > 1) {
            levels.push(halved(last));
        }
        Self { levels }
    }

    /// Colour at `uv` for a pixel that covers `texels` texels of the full size, bilinear.
    fn sample(&self, uv: [f32; 2], texels: f32) -> [f32; 3] {
        let (mut level, mut covered) = (0, texels);
        while covered > 1.5 && level + 1 < self.levels.len() {
            covered /= 2.0;
            level += 1;
        }
        bilinear(&self.levels[level], uv)
    }
}

fn halved(image: &Texture) -> Texture {
    let (width, height) = (image.width / 2, image.height / 2);
    let texel = |x: u32, y: u32, c: u32| u32::from(image.rgba[(4 * (y * image.width + x) + c) as usize]);
    let mut rgba = Vec::with_capacity(4 * (width * height) as usize);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        for c in 0..4 {
            let sum = texel(2 * x, 2 * y, c) + texel(2 * x + 1, 2 * y, c);
            let sum = sum + texel(2 * x, 2 * y + 1, c) + texel(2 * x + 1, 2 * y + 1, c);
            rgba.push(((sum + 2) / 4) as u8);
        }
    }
    Texture { width, height, rgba: rgba.into() }
}

fn bilinear(image: &Texture, uv: [f32; 2]) -> [f32; 3] {
    let (w, h) = (image.width as f32, image.height as f32);
    let x = (uv[0] - uv[0].floor()) * w - 0.5;
    let y = (1.0 - (uv[1] - uv[1].floor())) * h - 0.5;
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let (x0, y0) = (x.floor() as i64, y.floor() as i64);
    let texel = |x: i64, y: i64, c: usize| {
        let (x, y) = (x.rem_euclid(i64::from(image.width)), y.rem_euclid(i64::from(image.height)));
        f32::from(image.rgba[4 * (y * i64::from(image.width) + x) as usize + c])
    };
    [0, 1, 2].map(|c| {
        let top = texel(x0, y0, c) * (1.0 - fx) + texel(x0 + 1, y0, c) * fx;
        let bottom = texel(x0, y0 + 1, c) * (1.0 - fx) + texel(x0 + 1, y0 + 1, c) * fx;
        (top * (1.0 - fy) + bottom * fy) / 255.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};
    use openbench_scene::scene::Layer;
    use openbench_scene::{Material, SceneBuilder, SemanticClass};
    use std::sync::Arc;

    /// A red square of 2 m, 5 m ahead, 1 m to the left and 1 m up.
    fn renderer() -> Renderer {
        let mut builder = SceneBuilder::new();
        let red = builder.material(Material::plain(SemanticClass::Other, [1.0, 0.0, 0.0]));
        let (u, v) = (Vector3::y() * 2.0, Vector3::z() * 2.0);
        builder.rectangle(Layer::Visible, red, Point3::new(5.0, 0.0, 0.0), (u, v), [1.0; 2]);
        Renderer::new(RayCaster::new(Arc::new(builder.build())))
    }

    #[test]
    fn a_square_covers_the_pixels_that_the_pinhole_says() {
        let view = View { pose: Pose3::identity(), size: (200, 160), focal_length: 100.0, range: 200.0 };
        let rgb = renderer().render(&view);
        let is_red = |x: usize, y: usize| rgb[3 * (y * 200 + x)] > rgb[3 * (y * 200 + x) + 1];
        // Left edge at 100 - 100 * 2 / 5 = 60, right at 100; top at 80 - 40 = 40, bottom at 80.
        assert!(is_red(61, 41) && is_red(98, 78));
        assert!(!is_red(58, 60) && !is_red(102, 60) && !is_red(80, 38) && !is_red(80, 82));
    }

    #[test]
    fn mipmaps_keep_the_mean() {
        let rgba: Vec<u8> =
            (0..8 * 8).flat_map(|i| if (i + i / 8) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }).collect();
        let maps = Mipmaps::new(&Texture { width: 8, height: 8, rgba: rgba.into() });
        let far = maps.sample([0.3, 0.7], 8.0);
        assert!((far[0] - 0.5).abs() < 0.01, "{far:?}");
    }
}
