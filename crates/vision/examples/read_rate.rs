//! Rates of correct readings by distance and angle, and time per image.
//!
//! ```text
//! cargo run --release -p openbench-vision --example read_rate -- \
//!     DETECTION.onnx RECOGNITION.onnx [KEYS.txt]
//! ```

#![allow(clippy::print_stdout)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::path::Path;
use std::time::Instant;

use openbench_vision::{PlateReader, PpOcr, PpOcrSettings, parse_unit};
use support::{Plate, picture, view};

const TEXTS: [&str; 8] = [
    "UNIT 1", "UNIT 2", "UNIT 3", "UNIT 12", "UNIT 11", "unit1", "UNIT 7", "unit2",
];
const DISTANCES: [f64; 7] = [3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0];
const ANGLES: [f64; 6] = [0.0, 15.0, -30.0, 40.0, -50.0, 60.0];

/// Numbers of correct, wrong and missing readings.
type Counts = [u32; 3];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (detection, recognition, keys) = match &args[..] {
        [detection, recognition] => (detection, recognition, None),
        [detection, recognition, keys] => (detection, recognition, Some(Path::new(keys))),
        _ => return Err("give DETECTION.onnx RECOGNITION.onnx [KEYS.txt]".into()),
    };
    let settings = PpOcrSettings {
        upper_part: 0.6,
        ..PpOcrSettings::default()
    };
    let mut reader =
        PpOcr::load(Path::new(detection), Path::new(recognition), keys)?.with_settings(settings);
    println!("blank wall: {:.1} ms", blank_ms(&mut reader)?);
    println!(
        "right/wrong/missing of {} at angles {ANGLES:?}, by distance",
        2 * TEXTS.len()
    );
    let mut seconds = 0.0;
    for distance in DISTANCES {
        let mut row = String::new();
        for angle in ANGLES {
            let [right, wrong, missing] = cell(&mut reader, distance, angle, &mut seconds)?;
            row += &format!("  {right:2}/{wrong}/{missing}");
        }
        println!("{distance:4} m{row}");
    }
    let images = 2 * TEXTS.len() * DISTANCES.len() * ANGLES.len();
    println!("with plate: {:.1} ms", 1000.0 * seconds / images as f64);
    Ok(())
}

fn blank_ms(reader: &mut PpOcr) -> Result<f64, Box<dyn std::error::Error>> {
    let image = picture(None, &view(5.0, 0.0, 1, 1));
    let start = Instant::now();
    for _ in 0..10 {
        reader.read(&image)?;
    }
    Ok(100.0 * start.elapsed().as_secs_f64())
}

fn cell(
    reader: &mut PpOcr,
    distance: f64,
    angle: f64,
    seconds: &mut f64,
) -> Result<Counts, Box<dyn std::error::Error>> {
    let mut counts = Counts::default();
    for (index, text) in TEXTS.iter().enumerate() {
        for rays in [1, 2] {
            let seed = index as u64 + 100 * distance as u64 + 7 * angle.abs() as u64;
            let image = picture(Some(&Plate::new(text)), &view(distance, angle, rays, seed));
            let start = Instant::now();
            let readings = reader.read(&image)?;
            *seconds += start.elapsed().as_secs_f64();
            let units = readings
                .iter()
                .filter_map(|reading| parse_unit(&reading.text));
            let found = units.max_by(|a, b| a.score.total_cmp(&b.score));
            let found = found.map(|found| found.unit);
            let right = found.is_some() && found == parse_unit(text).map(|expected| expected.unit);
            counts[if found.is_none() {
                2
            } else {
                usize::from(!right)
            }] += 1;
        }
    }
    Ok(counts)
}
