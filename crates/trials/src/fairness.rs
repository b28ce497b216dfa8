//! Whether plates as in streets can be read: each legible Latin plate is shown to a reader frontal,
//! at noon, with letters 40 pixels high.
//!
//! A condition that no reader could meet would measure nothing. What is read is compared without
//! regard to case, spaces, punctuation and accents.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Point3, UnitQuaternion, Vector3};
use openbench_core::{Image, Pose3, RobotDescription};
use openbench_scene::plates::{Make, SampledPlate, sampled_plates};
use openbench_scene::{
    Layer, Material, Movers, RayCaster, Scene, SceneBuilder, SemanticClass, Texture,
};
use openbench_sim::{ImageSize, Renderer, View};
use openbench_vision::{PlateReader, PlateReading, ReaderError};

/// Whether a reading says what a plate says. Tolerated are case, punctuation, spaces, accents, ß as
/// `b` or `SS`, the small o of `N.º` as a zero or a large one, and on bells the names that follow.
fn is_read(says: &str, read: &str, may_go_on: bool) -> bool {
    let read = if says.to_uppercase().contains("N.º") {
        read.replacen("N.0", "N.", 1).replacen("N.O", "N.", 1)
    } else {
        read.to_owned()
    };
    let found = folded(&read);
    let forms = [folded(says), folded(&says.replace('ß', "SS"))];
    // A name begins with a letter: `12` is no reading of `1`.
    let goes_on = |rest: &str| rest.starts_with(char::is_alphabetic);
    let is_form = |form: &String| {
        found == *form || may_go_on && found.strip_prefix(form.as_str()).is_some_and(goes_on)
    };
    forms.iter().any(is_form)
}

/// Height of the capitals in the images, pixels.
const LETTERS_PX: f64 = 40.0;
/// Lines whose middles are nearer to each other are one, pixels.
const ONE_LINE_PX: f32 = 14.0;
/// Height of the camera and of the middle of the text, metres.
const EYE_M: f64 = 1.5;

/// A plate that was not read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missed {
    /// What it says.
    pub says: String,
    /// What was read.
    pub read: String,
    /// What it is made of, and its typeface.
    pub design: String,
}

/// How many plates were read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Fairness {
    /// Legible Latin plates that were shown.
    pub shown: usize,
    /// Those that were not read as what they say.
    pub missed: Vec<Missed>,
}

impl Fairness {
    /// Share of the plates that were read.
    pub fn share(&self) -> f64 {
        1.0 - self.missed.len() as f64 / self.shown.max(1) as f64
    }
}

/// Shows the legible Latin plates of some seeds to a reader, `each` plates drawn for each seed.
///
/// # Errors
/// Those of the reader.
pub fn plates_that_are_read(
    reader: &mut dyn PlateReader,
    seeds: Range<u64>,
    each: usize,
) -> Result<Fairness, ReaderError> {
    let mut fairness = Fairness::default();
    for plate in seeds.flat_map(|seed| sampled_plates(seed, each)) {
        if !plate.is_latin() || !plate.wear.is_slight() {
            continue;
        }
        fairness.shown += 1;
        let says = plate.lines.join(" ");
        let read = in_order(reader.read(&picture(&plate))?);
        let may_go_on = plate.design.make == Make::Bells;
        if !is_read(&says, &read, may_go_on) {
            fairness.missed.push(Missed {
                says,
                read,
                design: format!("{}, {}", plate.design.make.name(), plate.design.typeface()),
            });
        }
    }
    Ok(fairness)
}

/// A plate on its wall as the robot's camera sees it from in front.
pub fn picture(plate: &SampledPlate) -> Image {
    let optics = RobotDescription::sentry().camera_intrinsics;
    let distance = optics.focal_length() * plate.face.text.height_m / LETTERS_PX;
    let size = ImageSize::new(optics.width, optics.height);
    // The sun shines towards -x: the wall faces +x, and the camera looks at it.
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
    let eye = Vector3::new(distance, 0.0, EYE_M);
    let view = View {
        pose: Pose3::from_parts(eye.into(), turn),
        size,
        focal_length: optics.focal_length(),
        range: 50.0,
        shadows: false,
        exposure: 1.0,
    };
    let renderer = Renderer::new(RayCaster::new(Arc::new(scene(plate))));
    Image {
        stamp: Default::default(),
        width: size.width,
        height: size.height,
        rgb: renderer.render(&view, &Movers::default()),
    }
}

fn scene(plate: &SampledPlate) -> Scene {
    let mut builder = SceneBuilder::new();
    let grey = [1.0, 0.95, 0.88].map(|tint: f32| tint * plate.wall);
    let wall = builder.material(Material::plain(SemanticClass::Building, grey));
    let (north, up) = (Vector3::y(), Vector3::z());
    let corner = Point3::new(0.0, -5.0, 0.0);
    builder.rectangle(
        Layer::Visible,
        wall,
        corner,
        north * 10.0,
        up * 6.0,
        [1.0; 2],
    );
    let face = &plate.face;
    let image: Texture = face.texture.clone();
    let texture = builder.texture(image);
    let mut material = Material::plain(SemanticClass::Plate, [1.0; 3]).with_texture(texture);
    material.cutout = face.has_holes;
    let material = builder.material(material);
    let (width, height) = (face.size.width_m, face.size.height_m);
    let corner = Point3::new(0.01, -width / 2.0, EYE_M - face.text_above_m - height / 2.0);
    builder.rectangle(
        Layer::Visible,
        material,
        corner,
        north * width,
        up * height,
        [1.0; 2],
    );
    builder.build()
}

/// Readings as one text: from top to bottom, and from left to right in a line.
fn in_order(mut readings: Vec<PlateReading>) -> String {
    readings.sort_by(|a, b| a.centre()[1].total_cmp(&b.centre()[1]));
    let mut lines: Vec<Vec<PlateReading>> = Vec::new();
    for reading in readings {
        let of_last = lines
            .last_mut()
            .filter(|line| reading.centre()[1] - line[0].centre()[1] < ONE_LINE_PX);
        match of_last {
            Some(line) => line.push(reading),
            None => lines.push(vec![reading]),
        }
    }
    for line in &mut lines {
        line.sort_by(|a, b| a.centre()[0].total_cmp(&b.centre()[0]));
    }
    let texts = lines.into_iter().flatten().map(|reading| reading.text);
    texts.collect::<Vec<_>>().join(" ")
}

/// Letters and digits alone, in lower case and without accents.
fn folded(text: &str) -> String {
    let plain = |c: char| match c {
        'ä' | 'à' | 'á' | 'â' => Some('a'),
        'ö' | 'ò' | 'ó' | 'ô' => Some('o'),
        'ü' | 'ù' | 'ú' | 'û' => Some('u'),
        'è' | 'é' | 'ê' => Some('e'),
        // PP-OCR has no ß and reads it as one of these.
        'ß' | 'β' => Some('b'),
        // Of `N°` and `N.º`, in which readers see a small o or a zero.
        '°' | 'º' => None,
        c => c.is_alphanumeric().then_some(c),
    };
    text.to_lowercase().chars().filter_map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_may_differ_in_what_readers_cannot_tell_apart() {
        assert!(is_read("N.º 118", "N.O118", false) && is_read("N.º 1", "N.0 1", false));
        assert!(is_read("Ringstraße 12a", "RINGSTRASSE 12A", false));
        assert!(is_read("Interno 1", "Interno 1 Rossi", true));
        assert!(!is_read("Interno 1", "Interno 1 Rossi", false));
        assert!(!is_read("Interno 1", "Intern0 1", false) && !is_read("7", "", true));
        assert!(!is_read("N.º 18", "N.º 10", false));
    }

    #[test]
    fn texts_are_compared_without_case_marks_and_accents() {
        assert_eq!(folded("Tür 7-2"), folded("TUR 72"));
        assert_ne!(folded("Unit 1"), folded("Unit 7"));
    }
}
