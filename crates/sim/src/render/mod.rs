//! Images of a scene by ray casting: sun, sky, haze, textures, and shadows on request.
//!
//! | module | job |
//! |---|---|
//! | `view` | the camera whose image is drawn |
//! | `eye` | the rays through its pixels |
//! | `block` | pixels that are cast and coloured together |
//! | `shade` | the colour of what a ray hits |
//! | `shadows` | whether the sun shines on it |
//! | `illumination` | the light of any hour and weather: sun, sky, lamps |
//! | `radiance` | the light that surfaces send to the camera under it |
//! | `lens` | where the pixels of a lens with distortion look |
//! | `photo` | the light of a picture, row by row as a shutter rolls |
//! | `planes` | that light |
//! | `drops` | drops on the lens |
//! | `rain` | streaks of rain |
//! | `develop` | from that light to bytes: motion blur, noise, the tone curve |
//! | `texture` | textures at full, half, quarter … size |

mod block;
mod develop;
mod drops;
mod eye;
mod illumination;
mod lens;
mod photo;
mod planes;
mod radiance;
mod rain;
mod shade;
mod shadows;
mod texture;
mod view;

use openbench_scene::bvh::{Kernel, LANES, MISS, PacketHits, widest};
use openbench_scene::{Movers, RayCaster, SemanticClass, Snapshot};

use crate::rounding::whole;
use block::{BLOCK, Block, Corner, SIDE, pixel};
use eye::Eye;
use photo::Taking;
use shade::{Look, Shader, Surfaces};
use shadows::{Cast, sunlit};

pub(crate) use develop::{Development, Movement, develop};
pub(crate) use drops::smear;
pub(crate) use illumination::{Illumination, Lamp};
pub(crate) use lens::Lens;
pub(crate) use photo::{Moment, Shot};
pub(crate) use planes::LightPlanes;
pub(crate) use rain::{Streaks, rain};
pub use view::{ImageSize, View};

/// What each pixel of a view shows, for training and scoring. Pixels are in rows from the top.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Labels {
    /// Size of the image.
    pub size: ImageSize,
    /// Distance along the optical axis, metres; infinite where nothing is seen.
    pub depth: Vec<f32>,
    /// Class of what is seen; `None` for the sky.
    pub class: Vec<Option<SemanticClass>>,
    /// Number of the object that is seen, see [`Scene::object`](openbench_scene::Scene::object).
    /// 0 stands for the sky and for surfaces of no object. Movers have the numbers after those of
    /// the scene's objects.
    pub object: Vec<u32>,
}

/// Draws views of a scene.
///
/// A square metre of wall, 5 m ahead of a camera with a focal length of 100 pixels, has a side of
/// 20 pixels:
///
/// ```
/// use std::sync::Arc;
///
/// use nalgebra::{Point3, Vector3};
/// use openbench_core::Pose3;
/// use openbench_scene::Layer;
/// use openbench_scene::{Material, Movers, RayCaster, SceneBuilder, SemanticClass};
/// use openbench_sim::{ImageSize, Renderer, View};
///
/// let mut builder = SceneBuilder::new();
/// let wall = builder.material(Material::plain(SemanticClass::Wall, [0.6; 3]));
/// let corner = Point3::new(5.0, -0.5, -0.5);
/// builder.rectangle(Layer::Visible, wall, corner, Vector3::y(), Vector3::z(), [1.0; 2]);
/// let renderer = Renderer::new(RayCaster::new(Arc::new(builder.build())));
///
/// let view = View {
///     pose: Pose3::identity(),
///     size: ImageSize::new(64, 48),
///     focal_length: 100.0,
///     range: 200.0,
///     shadows: false,
///     exposure: 1.0,
/// };
/// let labels = renderer.labels(&view, &Movers::default());
/// let seen = labels.class.iter().filter(|class| **class == Some(SemanticClass::Wall));
/// assert_eq!(seen.count(), 20 * 20);
/// assert_eq!(renderer.render(&view, &Movers::default()).len(), 3 * view.size.pixels());
/// ```
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
        let mut rgb = vec![0; 3 * view.size.pixels()];
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

    /// The light that reaches each pixel of a camera.
    pub(crate) fn photograph(&self, shot: &Shot<'_>, movers: &Movers) -> LightPlanes {
        let mut planes = LightPlanes::new(shot.lens.size);
        let seen = Snapshot {
            caster: &self.caster,
            movers,
        };
        widest(Taking {
            seen,
            shader: &self.shader,
            shot: *shot,
            planes: &mut planes,
        });
        planes
    }

    /// Depth, class and object of each of the view's pixels.
    pub fn labels(&self, view: &View, movers: &Movers) -> Labels {
        let seen = Snapshot {
            caster: &self.caster,
            movers,
        };
        let mut labels = Labels {
            size: view.size,
            depth: vec![f32::INFINITY; view.size.pixels()],
            class: vec![None; view.size.pixels()],
            object: vec![0; view.size.pixels()],
        };
        let eye = Eye::new(view);
        for corner in Corner::covering(view.size) {
            let block = eye.block(corner, view.range);
            let hits = seen.cast_block(&block.beam, &block.packets);
            for row in 0..corner.rows(view.size) {
                for column in 0..corner.columns(view.size) {
                    let at = corner.index(view.size, column, row);
                    let pixel = pixel(column, row);
                    self.label(&mut labels, at, &hits[pixel / LANES], pixel % LANES);
                }
            }
        }
        labels
    }

    /// Writes the labels of the pixel at index `at` if its ray hit anything.
    fn label(&self, labels: &mut Labels, at: usize, hits: &PacketHits, lane: usize) {
        let triangle = hits.triangle[lane];
        if triangle == MISS {
            return;
        }
        // Directions have length 1 along the optical axis, so a hit's distance is its depth.
        labels.depth[at] = hits.distance[lane];
        labels.class[at] = Some(self.caster.material(triangle).class);
        labels.object[at] = match hits.mover[lane] {
            MISS => self.caster.scene().object_number(triangle),
            mover => self.caster.scene().objects.len() as u32 + 1 + mover,
        };
    }
}

/// An image that is being drawn.
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
        // Colour values grow with the square root of the light.
        let gain = view.exposure.max(0.0).sqrt();
        let mut surfaces = Surfaces::NONE;
        for corner in Corner::covering(view.size) {
            let block = eye.block(corner, view.range);
            let hits = seen.cast_block(&block.beam, &block.packets);
            let sunlit = if view.shadows {
                let towards = seen.caster.scene().sun.direction.map(|c| -c);
                let cast = Cast {
                    seen,
                    rays: &block.packets,
                    hits: &hits,
                    lag: 0.0,
                };
                sunlit(cast, towards)
            } else {
                [1.0; BLOCK]
            };
            let colors =
                shader.colors(&mut surfaces, seen, look, &block.directions, &hits, &sunlit);
            put(rgb, corner, view.size, &colors, gain);
        }
    }
}

/// Writes a block's colours, 0 to 255, times `gain` into the image. Pixels beyond its edges are
/// left out.
#[inline(always)]
fn put(rgb: &mut [u8], corner: Corner, size: ImageSize, colors: &[Block; 3], gain: f32) {
    // Red, green and blue from the lowest byte up.
    let mut packed = [0_u32; BLOCK];
    for (channel, colors) in colors.iter().enumerate() {
        for (packed, color) in packed.iter_mut().zip(colors) {
            // A half is added since `whole` rounds down.
            let value = color * gain + 0.5;
            let value = if value < 255.0 { value } else { 255.0 };
            *packed |= whole(value) << (8 * channel);
        }
    }
    let columns = corner.columns(size);
    for row in 0..corner.rows(size) {
        // A whole row is packed at a constant length; only what lies inside the image is copied.
        let mut bytes = [0; 3 * SIDE];
        for column in 0..SIDE {
            let [red, green, blue, _] = packed[pixel(column, row)].to_le_bytes();
            bytes[3 * column..3 * column + 3].copy_from_slice(&[red, green, blue]);
        }
        let at = 3 * corner.index(size, 0, row);
        rgb[at..at + 3 * columns].copy_from_slice(&bytes[..3 * columns]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};
    use openbench_core::Pose3;
    use openbench_scene::{Layer, Material, SceneBuilder, SemanticClass};
    use std::sync::Arc;

    /// A red square of 2 m, 5 m ahead, 1 m to the left and 1 m up.
    fn renderer() -> Renderer {
        let mut builder = SceneBuilder::new();
        let red = builder.material(Material::plain(SemanticClass::Other, [1.0, 0.0, 0.0]));
        builder.begin_object("square", SemanticClass::Other);
        let (u, v) = (Vector3::y() * 2.0, Vector3::z() * 2.0);
        builder.rectangle(
            Layer::Visible,
            red,
            Point3::new(5.0, 0.0, 0.0),
            u,
            v,
            [1.0; 2],
        );
        Renderer::new(RayCaster::new(Arc::new(builder.build())))
    }

    #[test]
    fn a_square_covers_the_pixels_of_its_pinhole_projection() {
        let view = View {
            pose: Pose3::identity(),
            size: ImageSize::new(200, 160),
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
    fn images_of_any_size_show_the_same_and_none_panics() {
        let view = |size, focal_length| View {
            pose: Pose3::identity(),
            size,
            focal_length,
            range: 200.0,
            shadows: false,
            exposure: 1.0,
        };
        let draw = |size, f| renderer().render(&view(size, f), &Movers::default());
        // The smaller image is the middle of the larger one: they differ by one pixel on each side.
        let (large, cut) = (
            draw(ImageSize::new(40, 40), 30.0),
            draw(ImageSize::new(38, 38), 30.0),
        );
        for (x, y) in [(0, 0), (37, 0), (20, 19), (3, 37), (37, 37)] {
            let (l, c) = (3 * ((y + 1) * 40 + x + 1), 3 * (y * 38 + x));
            assert_eq!(large[l..l + 3], cut[c..c + 3], "{x}, {y}");
        }
        for (width, height) in [(0, 5), (5, 0), (1, 1), (9, 13)] {
            let size = ImageSize::new(width, height);
            for f in [30.0, 0.0, f64::NAN, 1e-9, 1e9] {
                assert_eq!(draw(size, f).len(), 3 * size.pixels());
            }
        }
    }

    #[test]
    fn exposure_multiplies_light_and_its_root_multiplies_colours() {
        let (pose, size) = (Pose3::identity(), ImageSize::new(200, 160));
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
    fn labels_hold_class_object_and_depth() {
        let view = View {
            pose: Pose3::identity(),
            size: ImageSize::new(202, 161),
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
    fn a_photograph_in_the_scenes_own_light_shows_what_is_drawn() {
        let renderer = renderer();
        let optics = openbench_core::RobotDescription::sentry().camera_intrinsics;
        let view = View {
            pose: Pose3::translation(0.1, -0.2, 0.3),
            size: ImageSize::new(optics.width, optics.height),
            focal_length: optics.focal_length(),
            range: 200.0,
            shadows: false,
            exposure: 1.3,
        };
        let lens = Lens::new(&optics, 1.0, openbench_core::Distortion::default());
        let moment = Moment {
            pose: view.pose,
            lag: 0.0,
        };
        let shot = Shot {
            lens: &lens,
            moments: &[moment],
            light: &Illumination::of(&renderer.caster.scene().sun),
            lamps: &[],
            range: view.range,
        };
        let planes = renderer.photograph(&shot, &Movers::default());
        let development = Development {
            lens: &lens,
            movement: Movement::default(),
            factor: view.exposure,
            shot: 0.0,
            read: 0.0,
            vignetting: 0.0,
            key: [0, 0],
        };
        let (photo, drawn) = (
            develop(&planes, development),
            renderer.render(&view, &Movers::default()),
        );
        let differing = photo
            .iter()
            .zip(&drawn)
            .filter(|(a, b)| a.abs_diff(**b) > 1);
        // The square's edge may cross a pixel's middle.
        assert!(differing.count() < 100);
    }

    #[test]
    fn a_roof_casts_its_shadow_on_the_ground() {
        let mut builder = SceneBuilder::new();
        let grey = builder.material(Material::plain(SemanticClass::Ground, [0.5; 3]));
        let (x, y) = (Vector3::x(), Vector3::y());
        builder.rectangle(
            Layer::Visible,
            grey,
            Point3::new(-50.0, -50.0, 0.0),
            x * 100.0,
            y * 100.0,
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Visible,
            grey,
            Point3::new(5.0, -2.0, 5.0),
            x * 4.0,
            y * 4.0,
            [1.0; 2],
        );
        builder.set_sun(openbench_scene::Sun {
            direction: [0.0, 0.0, -1.0],
            ..Default::default()
        });
        let renderer = Renderer::new(RayCaster::new(Arc::new(builder.build())));
        let pose = Pose3::translation(0.0, 0.0, 1.0);
        let view = View {
            pose,
            size: ImageSize::new(200, 200),
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
