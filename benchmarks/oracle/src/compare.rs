//! Our pictures against the rasterizer's, pixel by pixel.

use openbench_scene::{Movers, RayCaster, SemanticClass};
use openbench_sim::{ImageSize, Renderer, View};

use crate::exact;
use crate::rasterizer::{Lens, Rasterizer, Sight};

/// Depths that differ by a larger share are those of two surfaces.
const SAME_SURFACE: f32 = 0.01;
/// Two surfaces whose depths differ by no larger share lie in one place: either may be seen.
const ONE_PLACE: f32 = 2e-6;
/// Rasterizers round corners to 1/256 pixel. Where the pictures differ, the pixel is drawn again through a lens this much longer.
const LONGER: f64 = 64.0;
/// Differences that are described, for each frame.
const DESCRIBED: usize = 8;

/// What a pixel shows: class and depth, `None` for the sky.
type Pixel = Option<(SemanticClass, f32)>;

/// How a frame compares.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    /// Pixels that see something, by our account.
    pub covered: usize,
    /// Pixels that differ between the two pictures, two surfaces in one place left out.
    pub at_once: usize,
    /// Of those, pixels that still differ when the rasterizer draws them through a longer lens.
    pub differing: usize,
    /// Of those, pixels in which we are wrong by double precision.
    pub wrong: usize,
    /// Pixels that see two surfaces in one place, which are of different classes.
    pub ties: usize,
    /// Largest share by which the depths of pixels that agree differ.
    pub depth: f32,
    /// Where and how they differ.
    pub described: Vec<String>,
}

/// A scene seen by both.
pub struct Both {
    caster: RayCaster,
    renderer: Renderer,
    rasterizer: Rasterizer,
}

impl Both {
    /// Prepares a scene; `None` if there is no driver.
    pub fn new(caster: RayCaster) -> Option<Self> {
        let rasterizer = Rasterizer::new(caster.scene())?;
        Some(Self {
            renderer: Renderer::new(caster.clone()),
            caster,
            rasterizer,
        })
    }

    /// The driver that draws.
    pub fn driver(&self) -> &str {
        self.rasterizer.name()
    }

    /// Draws a view twice.
    pub fn compare(&self, view: &View) -> Comparison {
        self.compare_with(view, &lens(view))
    }

    fn compare_with(&self, view: &View, lens: &Lens) -> Comparison {
        let labels = self.renderer.labels(view, &Movers::default());
        let ours = labels
            .class
            .iter()
            .zip(&labels.depth)
            .map(|(class, depth)| class.map(|c| (c, *depth)));
        let theirs = self.rasterizer.draw(self.caster.scene(), lens);
        let mut result = Comparison::default();
        for (i, (ours, theirs)) in (0..).zip(ours.zip(theirs)) {
            result.covered += usize::from(ours.is_some());
            let place = (i % view.size.width, i / view.size.width);
            match Verdict::of(ours, self.pixel(theirs)) {
                Verdict::Same(share) => result.depth = result.depth.max(share),
                Verdict::Tie => result.ties += 1,
                Verdict::Different => {
                    result.at_once += 1;
                    self.look_closely(view, place, ours, &mut result);
                }
            }
        }
        result
    }

    fn look_closely(&self, view: &View, place: (u32, u32), ours: Pixel, result: &mut Comparison) {
        let scene = self.caster.scene();
        let theirs = self.rasterizer.draw(scene, &at_pixel(view, place))[0];
        if !matches!(Verdict::of(ours, self.pixel(theirs)), Verdict::Different) {
            return;
        }
        result.differing += 1;
        let exact = exact::sight(scene, view, place);
        let wrong = matches!(Verdict::of(ours, self.pixel(exact)), Verdict::Different);
        result.wrong += usize::from(wrong);
        if result.described.len() < DESCRIBED {
            let words = |p: Pixel| {
                p.map_or("sky".into(), |(class, depth)| {
                    format!("{} at {depth:.3} m", class.name())
                })
            };
            let [theirs, exact] = [theirs, exact].map(|s| words(self.pixel(s)));
            let (u, v) = place;
            result.described.push(format!(
                "column {u}, row {v}: ours {}, theirs {theirs}, double precision {exact}",
                words(ours)
            ));
        }
    }

    fn pixel(&self, sight: Option<Sight>) -> Pixel {
        sight.map(|s| (self.caster.material(s.triangle).class, s.depth))
    }
}

/// How a pixel of one picture compares with that of another.
enum Verdict {
    /// The same class, with depths that differ by this share.
    Same(f32),
    /// Two surfaces in one place.
    Tie,
    /// Another class, or another depth.
    Different,
}

impl Verdict {
    fn of(a: Pixel, b: Pixel) -> Self {
        let share = share(a, b);
        match a.map(|p| p.0) == b.map(|p| p.0) {
            true if share < SAME_SURFACE => Self::Same(share),
            false if a.is_some() && b.is_some() && share < ONE_PLACE => Self::Tie,
            _ => Self::Different,
        }
    }
}

/// By what share of the lesser the depths differ.
fn share(a: Pixel, b: Pixel) -> f32 {
    match (a, b) {
        (Some((_, a)), Some((_, b))) => (a - b).abs() / a.min(b),
        _ => 0.0,
    }
}

fn lens(view: &View) -> Lens {
    let axis = [view.size.width, view.size.height].map(|size| (f64::from(size) - 1.0) / 2.0);
    let range = f64::from(view.range);
    Lens {
        pose: view.pose,
        size: (view.size.width, view.size.height),
        focal_length: view.focal_length,
        axis,
        range,
    }
}

/// One pixel of a view, through a longer lens.
fn at_pixel(view: &View, (u, v): (u32, u32)) -> Lens {
    let whole = lens(view);
    let axis = [
        (whole.axis[0] - f64::from(u)) * LONGER,
        (whole.axis[1] - f64::from(v)) * LONGER,
    ];
    Lens {
        size: (1, 1),
        focal_length: view.focal_length * LONGER,
        axis,
        ..whole
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Point3, Vector3};
    use openbench_core::Pose3;
    use openbench_scene::{Layer, Material, SceneBuilder, Texture};

    use super::*;

    fn view() -> View {
        View {
            pose: Pose3::identity(),
            size: ImageSize::new(64, 48),
            focal_length: 40.0,
            range: 20.0,
            shadows: false,
            exposure: 1.0,
        }
    }

    /// A wall with a fence of eight posts before it.
    fn both() -> Option<Both> {
        let mut builder = SceneBuilder::new();
        let (u, v) = (Vector3::y() * 4.0, Vector3::z() * 3.0);
        let wall = builder.material(Material::plain(SemanticClass::Building, [1.0; 3]));
        builder.rectangle(
            Layer::Visible,
            wall,
            Point3::new(8.0, -2.03, -1.51),
            u,
            v,
            [1.0; 2],
        );
        let texels = [[90, 90, 90, 255], [0, 0, 0, 0]].concat();
        let texture = builder.texture(Texture {
            width: 2,
            height: 1,
            rgba: texels.into(),
        });
        let fence = Material::plain(SemanticClass::Wall, [1.0; 3]).with_texture(texture);
        let fence = builder.material(Material {
            cutout: true,
            ..fence
        });
        builder.rectangle(
            Layer::Visible,
            fence,
            Point3::new(4.0, -1.52, -0.77),
            u / 2.0,
            v / 3.0,
            [8.0, 1.0],
        );
        let both = Both::new(RayCaster::new(Arc::new(builder.build())));
        if both.is_none() {
            eprintln!("skipped: no Vulkan driver that draws on the processor");
        }
        both
    }

    #[test]
    fn both_see_a_wall_through_a_fence() {
        let Some(both) = both() else { return };
        let frame = both.compare(&view());
        assert!(
            frame.covered > 300 && frame.at_once == 0 && frame.ties == 0,
            "{frame:?}"
        );
    }

    #[test]
    fn a_camera_that_looks_half_a_pixel_aside_is_noticed() {
        let Some(both) = both() else { return };
        let mut aside = lens(&view());
        aside.axis[0] += 0.5;
        let frame = both.compare_with(&view(), &aside);
        assert!(frame.at_once > 20, "{frame:?}");
        // Through the lens, which looks straight, nothing is wrong.
        assert_eq!(frame.differing, 0, "{frame:?}");
    }
}
