//! The robot's camera: it renders an image only on request.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use openbench_core::{Camera, CameraIntrinsics, Image, Pose3, SimTime};
use openbench_scene::Movers;

use crate::exposure::AutoExposure;
use crate::real_camera::RealCamera;
use crate::render::{ImageSize, Renderer, View};

/// Least simulated time between two images, nanoseconds.
const IMAGE_NS: u64 = 100_000_000;
/// Range of the camera, metres.
const RANGE_M: f32 = 200.0;
/// A real camera keeps adjusting its exposure while its images are not used. When the last image
/// is older than this, in nanoseconds, exposure is measured on a small view instead of it.
const STALE_NS: u64 = 1_000_000_000;
/// Factor between the sides of an image and of that small view, which costs 1/256 of the rays.
const SMALL_VIEW_FACTOR: u32 = 16;

/// A camera that renders only on request, and no more often than the real one delivers.
pub(crate) struct SimCamera {
    renderer: Arc<Renderer>,
    mount: Pose3,
    size: ImageSize,
    focal_length: f64,
    pose: Pose3,
    movers: Arc<Movers>,
    time: SimTime,
    // Cells, since an agent asks for an image through a shared reference.
    last: Cell<Option<SimTime>>,
    image: RefCell<Option<Arc<Image>>>,
    exposure: Cell<AutoExposure>,
    /// A camera with faults or in another light, which takes the images instead.
    real: Option<RealCamera>,
}

impl SimCamera {
    pub(crate) fn new(renderer: Arc<Renderer>, optics: CameraIntrinsics, mount: Pose3) -> Self {
        Self {
            renderer,
            mount,
            size: ImageSize::new(optics.width, optics.height),
            focal_length: optics.focal_length(),
            pose: Pose3::identity(),
            movers: Arc::default(),
            time: SimTime::ZERO,
            last: Cell::new(None),
            image: RefCell::new(None),
            exposure: Cell::default(),
            real: None,
        }
    }

    /// Takes the images with a camera that has faults, or in another light.
    pub(crate) fn replace(&mut self, real: RealCamera) {
        self.real = Some(real);
    }

    /// Notes where the robot is between two observations.
    pub(crate) fn pass(&mut self, time: SimTime, base_link: Pose3) {
        if let Some(real) = &mut self.real {
            real.pass(time, base_link * self.mount);
        }
    }

    /// Moves the camera with the robot, and the movers in its scene, to their places at `time`.
    pub(crate) fn move_to(&mut self, time: SimTime, base_link: Pose3, movers: Arc<Movers>) {
        self.movers = movers;
        self.time = time;
        self.pose = base_link * self.mount;
        if let Some(real) = &mut self.real {
            real.pass(time, self.pose);
            real.measure(&self.renderer, &self.movers, time);
        }
    }

    /// Takes an image, exposed by what the camera measured last.
    fn expose(&self) -> Image {
        let rgb = match &self.real {
            Some(real) => real.expose(&self.renderer, &self.movers, self.time),
            None => self.picture(),
        };
        Image {
            stamp: self.time,
            width: self.size.width,
            height: self.size.height,
            rgb,
        }
    }

    fn picture(&self) -> Vec<u8> {
        let exposure = self.adjusted_exposure();
        let rgb = self.render(&self.view(1, exposure.factor()));
        self.exposure.set(exposure);
        rgb
    }

    fn render(&self, view: &View) -> Vec<u8> {
        self.renderer.render(view, &self.movers)
    }

    fn adjusted_exposure(&self) -> AutoExposure {
        let age = self
            .last
            .get()
            .map(|last| self.time.0 - last.0)
            .filter(|age| *age < STALE_NS);
        match (age, &*self.image.borrow()) {
            (Some(age), Some(last)) => {
                let mut exposure = self.exposure.get();
                exposure.learn(&last.rgb, age as f64 * 1e-9);
                exposure
            }
            _ => AutoExposure::settled(&self.render(&self.view(SMALL_VIEW_FACTOR, 1.0))),
        }
    }

    /// The camera's view now, in an image whose sides are smaller by `factor`.
    fn view(&self, factor: u32, exposure: f32) -> View {
        // Size and focal length shrink alike, so the small view has the same field of view.
        let (width, height) = (
            self.size.width.div_ceil(factor),
            self.size.height.div_ceil(factor),
        );
        View {
            pose: self.pose,
            size: ImageSize::new(width, height),
            focal_length: self.focal_length / f64::from(factor),
            range: RANGE_M,
            // Shadows cost a second ray for each pixel.
            shadows: false,
            exposure,
        }
    }
}

impl Camera for SimCamera {
    fn image(&self) -> Option<Arc<Image>> {
        // A second request at the same instant gives the same image, and the exposure is adjusted
        // once.
        if self.last.get() == Some(self.time) {
            return self.image.borrow().clone();
        }
        if self
            .last
            .get()
            .is_some_and(|last| self.time.0 - last.0 < IMAGE_NS)
        {
            return None;
        }
        let image = Arc::new(self.expose());
        self.last.set(Some(self.time));
        *self.image.borrow_mut() = Some(image.clone());
        Some(image)
    }
}
