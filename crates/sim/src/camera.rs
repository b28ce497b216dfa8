//! The robot's camera: an image only when it is asked for.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use openbench_core::{Camera, Image, Pose3, RobotDescription, SimTime};

use crate::render::{Renderer, View};

/// Simulated time between two images, nanoseconds.
const IMAGE_NS: u64 = 100_000_000;
/// Distance that the camera sees, metres.
const SIGHT: f32 = 200.0;

/// Renders only when asked, and not more often than the real one delivers.
pub(crate) struct SimCamera {
    renderer: Arc<Renderer>,
    mount: Pose3,
    size: (u32, u32),
    focal_length: f64,
    pose: Pose3,
    time: SimTime,
    last: Cell<Option<SimTime>>,
    image: RefCell<Option<Arc<Image>>>,
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
            time: SimTime::ZERO,
            last: Cell::new(None),
            image: RefCell::new(None),
        }
    }

    /// Puts the camera where the robot is now.
    pub(crate) fn move_to(&mut self, time: SimTime, base_link: Pose3) {
        self.time = time;
        self.pose = base_link * self.mount;
    }
}

impl Camera for SimCamera {
    fn image(&self) -> Option<Arc<Image>> {
        if self.last.get() == Some(self.time) {
            return self.image.borrow().clone();
        }
        if self.last.get().is_some_and(|last| self.time.0 - last.0 < IMAGE_NS) {
            return None;
        }
        let view = View {
            pose: self.pose,
            size: self.size,
            focal_length: self.focal_length,
            range: SIGHT,
            shadows: false,
        };
        let (width, height) = self.size;
        let image = Arc::new(Image { stamp: self.time, width, height, rgb: self.renderer.render(&view) });
        self.last.set(Some(self.time));
        *self.image.borrow_mut() = Some(image.clone());
        Some(image)
    }
}
