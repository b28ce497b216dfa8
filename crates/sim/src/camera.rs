//! The robot's camera: an image only when it is asked for.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use openbench_core::{Camera, Image, Pose3, RobotDescription, SimTime};

use openbench_scene::Movers;

use crate::exposure::AutoExposure;
use crate::render::{Renderer, View};

/// Simulated time between two images, nanoseconds.
const IMAGE_NS: u64 = 100_000_000;
/// Distance that the camera sees, metres.
const SIGHT: f32 = 200.0;
/// A camera goes on adjusting its exposure when nobody takes its images. After so long without one, nanoseconds, it is
/// measured on a small view instead of the last image.
const FORGOTTEN_NS: u64 = 1_000_000_000;
/// How much smaller that view is, each way: 1/256 of an image's rays.
const SMALLER: u32 = 16;

/// Renders only when asked, and not more often than the real one delivers.
pub(crate) struct SimCamera {
    renderer: Arc<Renderer>,
    mount: Pose3,
    size: (u32, u32),
    focal_length: f64,
    pose: Pose3,
    movers: Arc<Movers>,
    time: SimTime,
    last: Cell<Option<SimTime>>,
    image: RefCell<Option<Arc<Image>>>,
    exposure: Cell<AutoExposure>,
}

impl SimCamera {
    pub(crate) fn new(renderer: Arc<Renderer>, robot: &RobotDescription) -> Self {
        let optics = robot.camera_intrinsics;
        Self {
            renderer,
            mount: robot.camera,
            size: (optics.width, optics.height),
            focal_length: optics.focal_length(),
            pose: Pose3::identity(),
            movers: Arc::default(),
            time: SimTime::ZERO,
            last: Cell::new(None),
            image: RefCell::new(None),
            exposure: Cell::default(),
        }
    }

    /// Puts the camera where the robot is now, and the movers where they are.
    pub(crate) fn move_to(&mut self, time: SimTime, base_link: Pose3, movers: Arc<Movers>) {
        self.movers = movers;
        self.time = time;
        self.pose = base_link * self.mount;
    }

    /// Takes an image with the exposure that the last one asked for.
    fn expose(&self) -> Image {
        let (width, height) = self.size;
        let exposure = self.adjusted();
        let rgb = self.render(&self.view(1, exposure.factor()));
        self.exposure.set(exposure);
        Image {
            stamp: self.time,
            width,
            height,
            rgb,
        }
    }

    fn render(&self, view: &View) -> Vec<u8> {
        self.renderer.render(view, &self.movers)
    }

    fn adjusted(&self) -> AutoExposure {
        let mut exposure = self.exposure.get();
        let since = self
            .last
            .get()
            .map(|last| self.time.0 - last.0)
            .filter(|since| *since < FORGOTTEN_NS);
        match (since, &*self.image.borrow()) {
            (Some(since), Some(last)) => {
                exposure.learn(&last.rgb, since as f64 * 1e-9);
                exposure
            }
            _ => AutoExposure::settled(&self.render(&self.view(SMALLER, 1.0))),
        }
    }

    /// What is seen now, in an image that many times smaller.
    fn view(&self, smaller: u32, exposure: f32) -> View {
        View {
            pose: self.pose,
            size: (self.size.0.div_ceil(smaller), self.size.1.div_ceil(smaller)),
            focal_length: self.focal_length / f64::from(smaller),
            range: SIGHT,
            shadows: false,
            exposure,
        }
    }
}

impl Camera for SimCamera {
    fn image(&self) -> Option<Arc<Image>> {
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
