//! Pictures of a scene by casting rays: sun, sky, haze, textures, and shadows where they are asked for.
//!
//! | module | its one job |
//! |---|---|
//! | `block` | pixels that are cast and coloured together |
//! | `shade` | the colour of what a ray hits |
//! | `texture` | textures at full, half, quarter … size |

mod block;
mod shade;
mod texture;

use openbench_core::Pose3;
use openbench_scene::bvh::{Beam, Kernel, LANES, Lane, MISS, PacketHits, widest};
use openbench_scene::{Movers, RayCaster, RayPacket, SemanticClass, Snapshot};

use crate::rounding::whole;
use block::{BLOCK, Block, PACKETS, PLACES, SIDE, pixel};
use shade::{Look, Shader};

/// How far off its surface a ray towards the sun begins, metres.
const OFF_SURFACE: f32 = 0.01;
/// What throws shadows, metres.
const SHADOW: f32 = 150.0;

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
    /// Whether things throw shadows, at the cost of a second ray for each pixel.
    pub shadows: bool,
    /// By how much the scene's light is multiplied before it is seen; 1 shows it as it is.
    pub exposure: f32,
}

/// What each pixel of a view shows, for training and scoring.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Distance along the optical axis, metres, rows from the top; infinite where nothing is seen.
    pub depth: Vec<f32>,
    /// What is seen; `None` for the sky.
    pub class: Vec<Option<SemanticClass>>,
    /// Number of the object that is seen, see [`Scene::object`](openbench_scene::Scene::object); 0 for the sky and what is no object. Movers have
    /// the numbers after those of the scene's objects.
    pub object: Vec<u32>,
}

/// Draws views of a scene.
#[derive(Debug)]
pub struct Renderer {
    caster: RayCaster,
    shader: Shader,
}

impl Renderer {
    /// Prepares a scene for drawing.
    pub fn new(caster: RayCaster) -> Self {
        Self {
            shader: Shader::new(&caster),
            caster,
        }
    }

    /// The view's pixels: RGB, rows from the top.
    pub fn render(&self, view: &View, movers: &Movers) -> Vec<u8> {
        let (width, height) = view.size;
        let mut rgb = vec![0; 3 * width as usize * height as usize];
        let seen = Snapshot {
            caster: &self.caster,
            movers,
        };
        widest(Picture {
            seen,
            shader: &self.shader,
            view,
            rgb: &mut rgb,
        });
        rgb
    }

    /// Depth, class and object of each of the view's pixels.
    pub fn labels(&self, view: &View, movers: &Movers) -> Labels {
        let (width, height) = view.size;
        let seen = Snapshot {
            caster: &self.caster,
            movers,
        };
        let pixels = width as usize * height as usize;
        let mut labels = Labels {
            size: view.size,
            depth: vec![f32::INFINITY; pixels],
            class: vec![None; pixels],
            object: vec![0; pixels],
        };
        let eye = Eye::new(view);
        for corner in blocks(view.size) {
            let block = eye.block(corner, view.range);
            let hits = seen.cast_block(&block.beam, &block.rays);
            for (row, column) in inside(corner, view.size) {
                let (at, pixel) = (index(corner, view.size.0, row, column), pixel(column, row));
                let (hits, lane) = (&hits[pixel / LANES], pixel % LANES);
                if hits.triangle[lane] != MISS {
                    // Rays reach one metre along the optical axis for each length of their direction.
                    labels.depth[at] = hits.distance[lane];
                    labels.class[at] = Some(self.caster.material(hits.triangle[lane]).class);
                    labels.object[at] = match hits.mover[lane] {
                        MISS => self.caster.scene().object_number(hits.triangle[lane]),
                        mover => self.caster.scene().objects.len() as u32 + 1 + mover,
                    };
                }
            }
        }
        labels
    }
}

/// Pictures are of one instant.
const NO_LAG: Lane = [0.0; LANES];

/// A picture being drawn.
struct Picture<'a> {
    seen: Snapshot<'a>,
    shader: &'a Shader,
    view: &'a View,
    rgb: &'a mut [u8],
}

impl Kernel for Picture<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            seen,
            shader,
            view,
            rgb,
        } = self;
        let eye = Eye::new(view);
        let look = Look {
            pixel_angle: eye.pixel_angle,
            haze: view.range,
        };
        // Colours go with the square root of the light.
        let gain = view.exposure.max(0.0).sqrt();
        for corner in blocks(view.size) {
            let block = eye.block(corner, view.range);
            let hits = seen.cast_block(&block.beam, &block.rays);
            let sunlit = if view.shadows {
                sunlit(seen, &block.rays, &hits)
            } else {
                [1.0; BLOCK]
            };
            let colors = shader.colors(seen, look, &block.directions, &hits, &sunlit);
            put(rgb, corner, view.size, &colors, gain);
        }
    }
}

/// Top left pixels of the blocks that cover a picture.
fn blocks((width, height): (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    (0..height)
        .step_by(SIDE)
        .flat_map(move |y| (0..width).step_by(SIDE).map(move |x| (x, y)))
}

/// Rows and columns of a block that lie inside the picture.
fn inside((x, y): (u32, u32), (width, height): (u32, u32)) -> impl Iterator<Item = (usize, usize)> {
    let (rows, columns) = (
        SIDE.min((height - y) as usize),
        SIDE.min((width - x) as usize),
    );
    (0..rows).flat_map(move |row| (0..columns).map(move |column| (row, column)))
}

/// Place in the picture of a block's pixel.
#[inline(always)]
fn index((x, y): (u32, u32), width: u32, row: usize, column: usize) -> usize {
    (y as usize + row) * width as usize + x as usize + column
}

/// For each pixel 1 if the sun shines on what was hit, 0 if something stands between.
fn sunlit(seen: Snapshot<'_>, rays: &[RayPacket; PACKETS], hits: &[PacketHits; PACKETS]) -> Block {
    let towards = seen.caster.scene().sun.direction.map(|c| -c);
    let mut sunlit = [0.0; BLOCK];
    for ((rays, hits), sunlit) in rays.iter().zip(hits).zip(sunlit.chunks_exact_mut(LANES)) {
        let mut back = RayPacket::idle();
        for lane in (0..LANES).filter(|&lane| hits.triangle[lane] != MISS) {
            let normal = seen.normal(hits, lane);
            let direction = [0, 1, 2].map(|axis| rays.direction[axis][lane]);
            let facing: f32 = (0..3).map(|axis| normal[axis] * direction[axis]).sum();
            let off = if facing > 0.0 {
                -OFF_SURFACE
            } else {
                OFF_SURFACE
            };
            let at = [0, 1, 2].map(|axis| {
                rays.origin[axis][lane] + hits.distance[lane] * direction[axis] + off * normal[axis]
            });
            back.set(lane, at, towards, SHADOW);
        }
        let between = seen.cast_packet(&back, &NO_LAG);
        for (sunlit, triangle) in sunlit.iter_mut().zip(&between.triangle) {
            *sunlit = if *triangle == MISS { 1.0 } else { 0.0 };
        }
    }
    sunlit
}

/// Writes a block's colours, 0 to 255, times `gain` into the picture; what lies beyond its edges is left out.
#[inline(always)]
fn put(
    rgb: &mut [u8],
    (x, y): (u32, u32),
    (width, height): (u32, u32),
    colors: &[Block; 3],
    gain: f32,
) {
    // Red, green and blue from the lowest byte up.
    let mut packed = [0_u32; BLOCK];
    for (channel, colors) in colors.iter().enumerate() {
        for (packed, color) in packed.iter_mut().zip(colors) {
            let value = color * gain + 0.5;
            let value = if value < 255.0 { value } else { 255.0 };
            *packed |= whole(value) << (8 * channel);
        }
    }
    let columns = SIDE.min((width - x) as usize);
    for row in 0..SIDE.min((height - y) as usize) {
        let mut bytes = [0; 3 * SIDE];
        for column in 0..SIDE {
            let [red, green, blue, _] = packed[pixel(column, row)].to_le_bytes();
            bytes[3 * column..3 * column + 3].copy_from_slice(&[red, green, blue]);
        }
        let at = 3 * index((x, y), width, row, 0);
        rgb[at..at + 3 * columns].copy_from_slice(&bytes[..3 * columns]);
    }
}

/// Where a view looks from, and along which ray each pixel looks.
struct Eye {
    origin: [f32; 3],
    corner: [f32; 3],
    right: [f32; 3],
    down: [f32; 3],
    pixel_angle: f32,
}

impl Eye {
    fn new(view: &View) -> Self {
        let axis = |v: nalgebra::Vector3<f64>| view.pose.rotation * v;
        let (forward, left, up) = (
            axis(nalgebra::Vector3::x()),
            axis(nalgebra::Vector3::y()),
            axis(nalgebra::Vector3::z()),
        );
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
        }
    }

    /// The rays through the block whose top left pixel this is.
    #[inline(always)]
    fn block(&self, (x, y): (u32, u32), limit: f32) -> Rays {
        let (x, y) = (x as f32, y as f32);
        let mut directions = [[0.0; BLOCK]; 3];
        for (axis, directions) in directions.iter_mut().enumerate() {
            for (i, direction) in directions.iter_mut().enumerate() {
                let (u, v) = (x + PLACES[0][i], y + PLACES[1][i]);
                *direction = self.corner[axis] + u * self.right[axis] + v * self.down[axis];
            }
        }
        let [ox, oy, oz] = self.origin;
        let mut rays = [const { RayPacket::idle() }; PACKETS];
        for (i, rays) in rays.iter_mut().enumerate() {
            rays.origin = [[ox; LANES], [oy; LANES], [oz; LANES]];
            rays.limit = [limit; LANES];
            for (packet, directions) in rays.direction.iter_mut().zip(&directions) {
                packet.copy_from_slice(&directions[i * LANES..][..LANES]);
            }
        }
        const END: usize = SIDE - 1;
        const CORNERS: [usize; 4] = [pixel(0, 0), pixel(END, 0), pixel(END, END), pixel(0, END)];
        let mut corners = [[0.0; 3]; 4];
        for (corner, i) in corners.iter_mut().zip(CORNERS) {
            *corner = [directions[0][i], directions[1][i], directions[2][i]];
        }
        Rays {
            directions,
            rays,
            beam: Beam::new(self.origin, &corners),
        }
    }
}

/// The rays of a block.
struct Rays {
    directions: [Block; 3],
    /// The same in packets.
    rays: [RayPacket; PACKETS],
    beam: Beam,
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
        builder.object("square", SemanticClass::Other);
        let (u, v) = (Vector3::y() * 2.0, Vector3::z() * 2.0);
        builder.rectangle(
            Layer::Visible,
            red,
            Point3::new(5.0, 0.0, 0.0),
            (u, v),
            [1.0; 2],
        );
        Renderer::new(RayCaster::new(Arc::new(builder.build())))
    }

    #[test]
    fn a_square_covers_the_pixels_that_the_pinhole_says() {
        let view = View {
            pose: Pose3::identity(),
            size: (200, 160),
            focal_length: 100.0,
            range: 200.0,
            shadows: false,
            exposure: 1.0,
        };
        let rgb = renderer().render(&view, &Movers::default());
        let is_red = |x: usize, y: usize| rgb[3 * (y * 200 + x)] > rgb[3 * (y * 200 + x) + 1];
        // Left edge at 100 - 100 * 2 / 5 = 60, right at 100; top at 80 - 40 = 40, bottom at 80.
        assert!(is_red(61, 41) && is_red(98, 78));
        assert!(!is_red(58, 60) && !is_red(102, 60) && !is_red(80, 38) && !is_red(80, 82));
    }

    #[test]
    fn pictures_of_any_size_show_the_same_and_none_panics() {
        let view = |size, focal_length| View {
            pose: Pose3::identity(),
            size,
            focal_length,
            range: 200.0,
            shadows: false,
            exposure: 1.0,
        };
        let draw = |size, f| renderer().render(&view(size, f), &Movers::default());
        // Cut off on the right and below, by pixels that shift the middle by whole ones.
        let (large, cut) = (draw((40, 40), 30.0), draw((38, 38), 30.0));
        for (x, y) in [(0, 0), (37, 0), (20, 19), (3, 37), (37, 37)] {
            let (l, c) = (3 * ((y + 1) * 40 + x + 1), 3 * (y * 38 + x));
            assert_eq!(large[l..l + 3], cut[c..c + 3], "{x}, {y}");
        }
        for size in [(0, 5), (5, 0), (1, 1), (9, 13)] {
            for f in [30.0, 0.0, f64::NAN, 1e-9, 1e9] {
                assert_eq!(draw(size, f).len(), 3 * (size.0 * size.1) as usize);
            }
        }
    }

    #[test]
    fn exposure_multiplies_light_and_its_root_what_is_seen() {
        let (pose, size) = (Pose3::identity(), (200, 160));
        let view = View {
            pose,
            size,
            focal_length: 100.0,
            range: 200.0,
            shadows: false,
            exposure: 1.0,
        };
        let seen = |exposure| renderer().render(&View { exposure, ..view }, &Movers::default());
        let (plain, dim, glaring) = (seen(1.0), seen(0.25), seen(1e9));
        assert!(
            plain
                .iter()
                .zip(&dim)
                .all(|(p, d)| (f32::from(*p) / 2.0 - f32::from(*d)).abs() <= 0.5)
        );
        assert!(plain.iter().zip(&glaring).all(|(p, g)| *g == 255 || *p < 1));
    }

    #[test]
    fn labels_say_what_is_seen_and_how_deep_it_lies() {
        let view = View {
            pose: Pose3::identity(),
            size: (202, 161),
            focal_length: 100.0,
            range: 200.0,
            shadows: false,
            exposure: 1.0,
        };
        let labels = renderer().labels(&view, &Movers::default());
        let at = |x: usize, y: usize| (labels.depth[y * 202 + x], labels.class[y * 202 + x]);
        for (x, y) in [(63, 43), (80, 60), (97, 77)] {
            let (depth, class) = at(x, y);
            assert!(
                (depth - 5.0).abs() < 1e-4 && class == Some(SemanticClass::Other),
                "{depth}"
            );
        }
        assert_eq!(at(201, 160), (f32::INFINITY, None));
        assert_eq!(
            (labels.object[60 * 202 + 80], labels.object[160 * 202 + 201]),
            (1, 0)
        );
    }

    #[test]
    fn a_roof_throws_its_shadow_on_the_ground() {
        let mut builder = SceneBuilder::new();
        let grey = builder.material(Material::plain(SemanticClass::Ground, [0.5; 3]));
        let (x, y) = (Vector3::x(), Vector3::y());
        builder.rectangle(
            Layer::Visible,
            grey,
            Point3::new(-50.0, -50.0, 0.0),
            (x * 100.0, y * 100.0),
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Visible,
            grey,
            Point3::new(5.0, -2.0, 5.0),
            (x * 4.0, y * 4.0),
            [1.0; 2],
        );
        builder.sun(openbench_scene::Sun {
            direction: [0.0, 0.0, -1.0],
            ..Default::default()
        });
        let renderer = Renderer::new(RayCaster::new(Arc::new(builder.build())));
        let pose = Pose3::translation(0.0, 0.0, 1.0);
        let view = View {
            pose,
            size: (200, 200),
            focal_length: 100.0,
            range: 200.0,
            shadows: true,
            exposure: 1.0,
        };
        let (shaded, lit) = [
            view,
            View {
                shadows: false,
                ..view
            },
        ]
        .map(|view| renderer.render(&view, &Movers::default()))
        .into();
        let at = |rgb: &[u8], x: usize, y: usize| rgb[3 * (y * 200 + x)];
        // The ground 7 m ahead lies 100 / 7 rows below the middle; beside the roof nothing changes.
        assert!(at(&shaded, 100, 114) < at(&lit, 100, 114));
        assert_eq!(at(&shaded, 20, 114), at(&lit, 20, 114));
    }
}
