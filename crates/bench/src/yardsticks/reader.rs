//! The plates in view, as a reader.

use std::f64::consts::FRAC_PI_2;
use std::str::FromStr;

use nalgebra::{Point3, Vector3};
use openbench_core::{Image, Pose3, RobotDescription};
use openbench_scene::{Door, RayPacket};
use openbench_sim::Stage;
use openbench_vision::{PlateReader, PlateReading, ReaderError};

use crate::run::TruthHandle;
use crate::run::truth::{Instant, Truth};

/// Rays to a plate end so far in front of its door, metres: the plate does not hide itself. Plates
/// of imported worlds hang 10 cm in front of their doors, others less.
const IN_FRONT_M: f64 = 0.12;

/// The least height of capitals that are read, pixels.
///
/// ```
/// use openbench_bench::yardsticks::LetterHeight;
///
/// assert_eq!("12.5".parse(), Ok(LetterHeight(12.5)));
/// assert!("-1".parse::<LetterHeight>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LetterHeight(pub f64);

impl Default for LetterHeight {
    /// Ten pixels: the robot's camera sees the capitals of a plate so high from 9.5 m.
    fn default() -> Self {
        Self(10.0)
    }
}

/// A text that is no height of letters.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no height of letters; write pixels above 0, such as reader=truth:10")]
pub struct LetterHeightError(pub String);

impl FromStr for LetterHeight {
    type Err = LetterHeightError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let pixels = text
            .parse()
            .ok()
            .filter(|p: &f64| p.is_finite() && *p > 0.0);
        pixels.map(Self).ok_or(LetterHeightError(text.to_owned()))
    }
}

/// A reader that returns what is written on the plates in view, without looking at the image.
///
/// A plate is in view if its whole text is inside the image, nothing hides one of the text's
/// corners or its middle, and its capitals are high enough. Seen from the side they count as lower
/// by the cosine of the angle, since letters become narrower.
#[derive(Clone)]
pub struct TruthReader {
    handle: TruthHandle,
    stage: Stage,
    robot: RobotDescription,
    least: LetterHeight,
}

impl TruthReader {
    /// A reader for an episode.
    pub fn new(truth: &Truth<'_>) -> Self {
        Self {
            handle: truth.handle.clone(),
            stage: truth.prepared.stage.clone(),
            robot: RobotDescription {
                // Where the camera is, and not where it is described to be.
                camera: truth
                    .prepared
                    .defects
                    .camera
                    .of(truth.prepared.robot.camera),
                // Likewise for its lens.
                camera_intrinsics: truth
                    .prepared
                    .surroundings
                    .lens
                    .of(truth.prepared.robot.camera_intrinsics),
                ..truth.prepared.robot.clone()
            },
            least: LetterHeight::default(),
        }
    }

    /// The same reader, which reads letters from this height on.
    #[must_use]
    pub fn with_least(self, least: LetterHeight) -> Self {
        Self { least, ..self }
    }

    fn reading(&self, door: &Door, instant: &Instant) -> Option<PlateReading> {
        // A door without a plate.
        if door.text.is_empty() {
            return None;
        }
        let camera = instant.base_link * self.robot.camera;
        let text = Text::of(door);
        if text.letter_height(&camera, self.focal_length())? < self.least.0 {
            return None;
        }
        let [a, b, c, d] = text.corners.map(|corner| self.pixel(&camera, corner));
        let corners = [a?, b?, c?, d?];
        self.is_unhidden(&camera, &text, instant)
            .then(|| PlateReading {
                text: door.text.clone(),
                confidence: 1.0,
                corners,
            })
    }

    fn focal_length(&self) -> f64 {
        self.robot.camera_intrinsics.focal_length()
    }

    /// Where the camera sees a point; `None` outside the image.
    fn pixel(&self, camera: &Pose3, point: Point3<f64>) -> Option<[f32; 2]> {
        let at = camera.inverse() * point;
        let seen = self.robot.camera_intrinsics.project(at.coords.into());
        seen.map(|(u, v)| [u as f32, v as f32])
    }

    /// Whether nothing is between the camera and the text.
    fn is_unhidden(&self, camera: &Pose3, text: &Text, instant: &Instant) -> bool {
        let eye = Point3::from(camera.translation.vector);
        let mut rays = RayPacket::idle();
        let mut limits = Vec::new();
        for (lane, point) in text.corners.iter().chain([&text.middle]).enumerate() {
            let to = point + text.normal * IN_FRONT_M - eye;
            let limit = to.norm() as f32;
            let direction = to.normalize().cast::<f32>();
            rays.set(lane, eye.cast::<f32>().into(), direction.into(), limit);
            limits.push(limit);
        }
        let snapshot = self.stage.snapshot(&instant.movers);
        let hits = snapshot.cast_packet(&rays, &[0.0; _]);
        // The distance is the limit where nothing was hit.
        limits
            .iter()
            .zip(hits.distance)
            .all(|(limit, hit)| hit >= *limit)
    }
}

impl PlateReader for TruthReader {
    fn name(&self) -> &str {
        "truth"
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        // An image of a time that is forgotten by now shows nothing.
        let Some(instant) = self.handle.instant(image.stamp) else {
            return Ok(Vec::new());
        };
        let doors = &self.stage.caster().scene().doors;
        Ok(doors
            .iter()
            .filter_map(|door| self.reading(door, &instant))
            .collect())
    }
}

/// The text of a plate in space.
struct Text {
    middle: Point3<f64>,
    /// Height of its capitals, metres.
    capital_m: f64,
    /// Clockwise from the top left, as seen from in front of it.
    corners: [Point3<f64>; 4],
    /// Direction that it faces; unit length.
    normal: Vector3<f64>,
}

impl Text {
    fn of(door: &Door) -> Self {
        let middle = Point3::from(door.plate);
        let (sin, cos) = libm::sincos(door.facing);
        // Who looks at the plate has its left end to the left.
        let (along_sin, along_cos) = libm::sincos(door.facing + FRAC_PI_2);
        let right = Vector3::new(along_cos, along_sin, 0.0) * (door.lettering.width_m / 2.0);
        let up = Vector3::z() * (door.lettering.height_m / 2.0);
        Self {
            middle,
            capital_m: door.lettering.height_m,
            corners: [
                middle - right + up,
                middle + right + up,
                middle + right - up,
                middle - right - up,
            ],
            normal: Vector3::new(cos, sin, 0.0),
        }
    }

    /// Height of the capitals in the image, pixels, times the cosine of the angle from which they
    /// are seen; `None` from behind.
    fn letter_height(&self, camera: &Pose3, focal_length: f64) -> Option<f64> {
        let to_camera = camera.translation.vector - self.middle.coords;
        let cosine = to_camera.normalize().dot(&self.normal);
        let depth = (camera.inverse() * self.middle).x;
        (cosine > 0.0 && depth > 0.0).then(|| cosine * focal_length * self.capital_m / depth)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use openbench_core::{MapPoint, Pose2, SimTime};
    use openbench_scene::{MaterialId, RayCaster, Scene, Triangle, Vertex};

    use super::super::scenery::{PEOPLED, truth_with};
    use super::*;

    /// A place `ahead` metres in front of a plate and `aside` metres to its side.
    fn place(door: &Door, ahead: f64, aside: f64) -> MapPoint {
        let place = door.point().offset(door.facing, ahead);
        place.offset(door.facing + FRAC_PI_2, aside)
    }

    /// The reader of a robot that looks at a plate from a place.
    fn reader(door: &Door, from: MapPoint, person: Option<MapPoint>) -> TruthReader {
        let yaw = from.bearing_to(door.point());
        TruthReader::new(&truth_with(Pose2::new(from.x, from.y, yaw), person))
    }

    fn read(mut reader: TruthReader) -> Vec<PlateReading> {
        let image = Image {
            stamp: SimTime::ZERO,
            width: 1,
            height: 1,
            rgb: vec![0; 3],
        };
        reader.read(&image).unwrap()
    }

    fn sees(reader: TruthReader, door: &Door) -> bool {
        read(reader).iter().any(|reading| reading.text == door.text)
    }

    /// The scene with a wall of 2 by 2 metres across a way from a plate.
    fn walled(scene: &Scene, door: &Door, ahead: f64) -> Scene {
        let mut scene = Scene {
            figures: Vec::new(),
            triangles: scene.standing().to_vec(),
            ..scene.clone()
        };
        let first = scene.vertices.len() as u32;
        for (aside, height) in [(-1.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-1.0, 2.0)] {
            let at = place(door, ahead, aside);
            let up = PEOPLED.free_space.ground() + height;
            scene.vertices.push(Vertex {
                position: [at.x as f32, at.y as f32, up as f32],
                uv: [0.0; 2],
            });
        }
        for corners in [[0, 1, 2], [0, 2, 3]] {
            scene.triangles.push(Triangle {
                corners: corners.map(|corner| first + corner),
                material: MaterialId(0),
            });
        }
        scene
    }

    #[test]
    fn plates_are_read_from_the_front_and_near_enough() {
        let door = &PEOPLED.world.scene.doors[0];
        let is_read = |ahead, aside, least| {
            let reader = reader(door, place(door, ahead, aside), None);
            sees(reader.with_least(LetterHeight(least)), door)
        };
        assert!(is_read(4.0, 0.0, 10.0));
        // Too far for letters of that height, too oblique, and from behind the wall.
        assert!(!is_read(4.0, 0.0, 40.0));
        assert!(!is_read(1.0, 8.0, 10.0));
        assert!(!is_read(-4.0, 0.0, 1.0));
    }

    #[test]
    fn whoever_stands_in_front_of_a_plate_hides_it() {
        let door = &PEOPLED.world.scene.doors[0];
        let is_read = |ahead, aside| {
            let person = Some(place(door, ahead, aside));
            sees(reader(door, place(door, 4.0, 0.0), person), door)
        };
        assert!(!is_read(2.0, 0.0));
        assert!(is_read(2.0, 2.0), "beside the line of sight");
        assert!(is_read(6.0, 0.0), "behind the robot");
    }

    #[test]
    fn a_wall_hides_a_plate() {
        let door = &PEOPLED.world.scene.doors[0];
        let is_read = |wall| {
            let scene = walled(&PEOPLED.world.scene, door, wall);
            let stage = Stage::new(RayCaster::new(Arc::new(scene))).unwrap();
            let reader = reader(door, place(door, 4.0, 0.0), None);
            sees(TruthReader { stage, ..reader }, door)
        };
        assert!(!is_read(2.0));
        assert!(is_read(6.0), "behind the robot");
    }

    #[test]
    fn the_corners_surround_the_middle_of_the_image() {
        let door = &PEOPLED.world.scene.doors[0];
        let readings = read(reader(door, place(door, 4.0, 0.0), None));
        let reading = readings.iter().find(|r| r.text == door.text).unwrap();
        let optics = PEOPLED.robot.camera_intrinsics;
        let [u, _] = reading.centre();
        assert!(
            (f64::from(u) - f64::from(optics.width) / 2.0).abs() < 1.0,
            "{u}"
        );
        let [[left, top], [right, _], [_, bottom], _] = reading.corners;
        assert!(left < right && top < bottom);
    }
}
