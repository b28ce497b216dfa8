//! Distances and angles at which plates are read, on drawn images with bricks, windows and doors.

#![allow(clippy::print_stderr)]

#[path = "../../skips.rs"]
mod skips;
mod support;

use openbench_vision::{PlateReader, PpOcr, parse_unit};
use skips::skipped;
use support::{Plate, picture, view};

const TEXTS: [&str; 5] = ["UNIT 1", "UNIT 2", "UNIT 3", "UNIT 12", "UNIT 11"];

/// The unit that the reader reads in an image, the one with the highest score if there are several.
fn unit_read(
    reader: &mut PpOcr,
    text: &str,
    distance: f64,
    angle: f64,
    seed: u64,
) -> Option<String> {
    let image = picture(Some(&Plate::new(text)), &view(distance, angle, 1, seed));
    let readings = reader.read(&image).unwrap();
    let units = readings
        .iter()
        .filter_map(|reading| parse_unit(&reading.text));
    units
        .max_by(|a, b| a.score.total_cmp(&b.score))
        .map(|found| found.unit)
}

/// Counts of readings.
struct Tally {
    right: usize,
    wrong: usize,
    all: usize,
}

/// Reads each text at these distances, metres, and angles, degrees.
fn tally(reader: &mut PpOcr, distances: &[f64], angles: &[f64]) -> Tally {
    let mut tally = Tally {
        right: 0,
        wrong: 0,
        all: 0,
    };
    for (index, text) in TEXTS.iter().enumerate() {
        let expected = parse_unit(text).unwrap().unit;
        for (distance, angle) in distances
            .iter()
            .flat_map(|d| angles.iter().map(move |a| (*d, *a)))
        {
            let found = unit_read(
                reader,
                text,
                distance,
                angle,
                index as u64 + 10 * distance as u64,
            );
            tally.all += 1;
            tally.right += usize::from(found.as_ref() == Some(&expected));
            tally.wrong += usize::from(found.is_some_and(|found| found != expected));
        }
    }
    tally
}

#[test]
fn plates_are_read_up_to_6_5_m() {
    let Some(mut reader) = support::ppocr() else {
        skipped(support::NO_PPOCR);
        return;
    };
    let Tally { right, wrong, all } = tally(&mut reader, &[3.5, 5.0, 6.5], &[0.0, -30.0, 40.0]);
    // A box without the last stroke makes UNIT 11 a UNIT 1: a single reading is no proof.
    assert!(
        right * 100 >= all * 95 && wrong * 100 <= all * 3,
        "{right} right, {wrong} wrong of {all}"
    );
}

#[test]
fn a_wall_without_plate_has_no_unit() {
    let Some(mut reader) = support::ppocr() else {
        skipped(support::NO_PPOCR);
        return;
    };
    for seed in 0..6 {
        let image = picture(
            None,
            &view(3.0 + seed as f64, 20.0 * seed as f64 - 50.0, 1, seed),
        );
        let readings = reader.read(&image).unwrap();
        let named = |text: &str| parse_unit(text).is_some_and(|found| found.worded);
        assert!(
            !readings.iter().any(|reading| named(&reading.text)),
            "{readings:?}"
        );
    }
}
