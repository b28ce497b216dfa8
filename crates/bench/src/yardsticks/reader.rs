//! The plates in view, as a reader.

use std::f64::consts::FRAC_PI_2;
use std::str::FromStr;

use nalgebra::{Point3, Vector3};
use openbench_core::{Image, Pose3, RobotDescription};
use openbench_scene::plate::{CAPITAL_HEIGHT_M, PLATE_WIDTH_M};
use openbench_scene::{Door, RayPacket};
use openbench_sim::Stage;
use openbench_vision::{PlateReader, PlateReading, ReaderError};

use crate::run::TruthHandle;
use crate::run::truth::{Instant, Truth};

/// Width of the text of a plate, metres: the plate without its margins.
const TEXT_WIDTH_M: f64 = PLATE_WIDTH_M - 0.1;
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
            robot: truth.prepared.robot.clone(),
            least: LetterHeight::default(),
        }
    }

    /// The same reader, which reads letters from this height on.
    #[must_use]
    pub fn with_least(self, least: LetterHeight) -> Self {
        Self { least, ..self }
    }

    fn reading(&self, door: &Door, instant: &Instant) -> Option<PlateReading> {
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
        let optics = self.robot.camera_intrinsics;
        let at = camera.inverse() * point;
        if at.x <= 0.0 {
            return None;
        }
        let f = self.focal_length();
        let (width, height) = (f64::from(optics.width), f64::from(optics.height));
        let u = width / 2.0 - f * at.y / at.x;
        let v = height / 2.0 - f * at.z / at.x;
        let is_inside = (0.0..width).contains(&u) && (0.0..height).contains(&v);
        is_inside.then_some([u as f32, v as f32])
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
        let right = Vector3::new(along_cos, along_sin, 0.0) * (TEXT_WIDTH_M / 2.0);
        let up = Vector3::z() * (CAPITAL_HEIGHT_M / 2.0);
        Self {
            middle,
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
        (cosine > 0.0 && depth > 0.0).then(|| cosine * focal_length * CAPITAL_HEIGHT_M / depth)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use openbench_core::{Pose2, SimTime};

    use super::*;
    use crate::Prepared;
    use crate::worlds::builtin_suite;

    static SMALL: LazyLock<Prepared> =
        LazyLock::new(|| Prepared::new(builtin_suite("small").unwrap(), None).unwrap());

    /// What is read from a place `ahead` metres in front of a plate, `aside` metres to its side,
    /// by a robot that looks at it.
    fn read(door: &Door, ahead: f64, aside: f64, least: f64) -> Vec<PlateReading> {
        let handle = TruthHandle::default();
        let truth = Truth {
            handle: handle.clone(),
            prepared: &SMALL,
            episode: 0,
        };
        let place = door.point().offset(door.facing, ahead);
        let place = place.offset(door.facing + FRAC_PI_2, aside);
        let yaw = place.bearing_to(door.point());
        handle.set(Instant {
            time: SimTime::ZERO,
            base_link: Pose2::new(place.x, place.y, yaw).to_pose3(0.0),
            ..Instant::default()
        });
        let image = Image {
            stamp: SimTime::ZERO,
            width: 1,
            height: 1,
            rgb: vec![0; 3],
        };
        TruthReader::new(&truth)
            .with_least(LetterHeight(least))
            .read(&image)
            .unwrap()
    }

    #[test]
    fn plates_are_read_from_the_front_and_near_enough() {
        let door = &SMALL.world.scene.doors[0];
        let texts = |ahead, aside, least| -> Vec<String> {
            let readings = read(door, ahead, aside, least).into_iter();
            readings.map(|reading| reading.text).collect()
        };
        assert!(texts(4.0, 0.0, 10.0).contains(&door.text));
        // Too far for letters of that height, too oblique, and from behind the wall.
        assert!(!texts(4.0, 0.0, 40.0).contains(&door.text));
        assert!(!texts(1.0, 8.0, 10.0).contains(&door.text));
        assert!(!texts(-4.0, 0.0, 1.0).contains(&door.text));
    }

    #[test]
    fn the_corners_surround_the_middle_of_the_image() {
        let door = &SMALL.world.scene.doors[0];
        let readings = read(door, 4.0, 0.0, 10.0);
        let reading = readings.iter().find(|r| r.text == door.text).unwrap();
        let optics = SMALL.robot.camera_intrinsics;
        let [u, _] = reading.centre();
        assert!(
            (f64::from(u) - f64::from(optics.width) / 2.0).abs() < 1.0,
            "{u}"
        );
        let [[left, top], [right, _], [_, bottom], _] = reading.corners;
        assert!(left < right && top < bottom);
    }
}
