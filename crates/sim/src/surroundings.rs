//! What a robot's sensors meet: faults of camera and LiDAR, light and weather.

use openbench_core::{CameraIntrinsics, MapPoint};
use openbench_scene::{Finish, RayCaster, SemanticClass, ground_height};

use crate::daylight::{Daylight, LampPlaces};
use crate::lidar::BeamErrors;
use crate::optics::{CameraErrors, LensBuild};
use crate::real_camera::RealCamera;
use crate::render::Illumination;
use crate::weather::Weather;

/// Height of a street lamp that the map does not have, metres.
const LAMP_HEIGHT_M: f64 = 5.5;

/// What a robot's sensors meet. By default nothing is out of the ordinary.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surroundings {
    /// What is wrong with the camera.
    pub camera: CameraErrors,
    /// Its lens.
    pub lens: LensBuild,
    /// The light; `None` for the scene's own, at noon.
    pub light: Option<Daylight>,
    /// Street lamps besides those of the scene.
    pub street_lamps: Vec<MapPoint>,
    /// Rain, fog, wet ground.
    pub weather: Weather,
    /// What is wrong with the LiDAR's beams.
    pub lidar: BeamErrors,
}

impl Surroundings {
    /// The camera in a scene; `None` if it takes the images that it always took.
    pub(crate) fn camera(
        &self,
        optics: &CameraIntrinsics,
        caster: &RayCaster,
        seed: u64,
    ) -> Option<RealCamera> {
        let is_dry = self.weather == Weather::DRY;
        if self.light.is_none() && self.camera == CameraErrors::PERFECT && is_dry {
            return None;
        }
        let (errors, lens) = (self.camera, self.lens.clone());
        let (light, rain) = (self.illumination(caster), self.weather.rain_mm_h);
        Some(RealCamera::new(optics, errors, lens, light, rain, seed))
    }

    /// The light on a scene.
    fn illumination(&self, caster: &RayCaster) -> Illumination {
        let mut light = self.dry_light(caster);
        self.weather.dim(&mut light);
        light
    }

    fn dry_light(&self, caster: &RayCaster) -> Illumination {
        let sun = &caster.scene().sun;
        let Some(light) = self.light else {
            return Illumination::of(sun);
        };
        let mut places = LampPlaces::default();
        if light.lamps {
            places = lamps_of(caster);
            let at = |place: &MapPoint| {
                let height = ground_height(caster, *place) + LAMP_HEIGHT_M;
                [place.x as f32, place.y as f32, height as f32]
            };
            places.street.extend(self.street_lamps.iter().map(at));
        }
        light.illumination(sun, &places)
    }
}

/// The lamps that a scene has: each run of triangles with a lamp's finish is one.
fn lamps_of(caster: &RayCaster) -> LampPlaces {
    let scene = caster.scene();
    let mut places = LampPlaces::default();
    let mut lamp = Corners::default();
    let standing = scene.standing().len();
    for (number, triangle) in scene.standing().iter().enumerate() {
        if caster.surface(number as u32).finish == Finish::Lamp {
            for corner in triangle.corners {
                lamp.add(scene.vertices[corner as usize].position);
            }
        }
        let goes_on = number + 1 < standing
            && caster.surface(number as u32 + 1).finish == Finish::Lamp
            && scene.object_numbers.get(number) == scene.object_numbers.get(number + 1);
        if goes_on {
            continue;
        }
        if let Some(middle) = lamp.middle() {
            // Lamp posts are furniture; lamps at doors are parts of houses.
            let object = scene.object(scene.object_number(number as u32));
            match object.map(|object| object.class) {
                Some(SemanticClass::Furniture) => places.street.push(middle),
                _ => places.door.push(middle),
            }
        }
        lamp = Corners::default();
    }
    places
}

/// Corners of one lamp.
#[derive(Default)]
struct Corners {
    sum: [f64; 3],
    count: usize,
}

impl Corners {
    fn add(&mut self, corner: [f32; 3]) {
        for (sum, along) in self.sum.iter_mut().zip(corner) {
            *sum += f64::from(along);
        }
        self.count += 1;
    }

    fn middle(&self) -> Option<[f32; 3]> {
        let count = self.count as f64;
        (self.count > 0).then(|| self.sum.map(|sum| (sum / count) as f32))
    }
}
