//! The contract of `PlateReader`, checked for each implementation.

#![allow(clippy::print_stderr)]

#[path = "../../skips.rs"]
mod skips;
mod support;

use openbench_core::{Image, SimTime};
use openbench_models::{ChatError, ChatModel, ChatReply, ChatRequest, Format, ModelStore};
use openbench_vision::{PlateReader, PlateReading, PpOcr, ReaderError, VlmReader};
use skips::skipped;
use support::{Plate, picture, view};

/// Checks the contract of [`PlateReader`] with an image of the plate "UNIT 2".
fn conforms(reader: &mut dyn PlateReader) {
    assert!(!reader.name().is_empty());
    let image = picture(Some(&Plate::new("UNIT 2")), &view(5.0, 0.0, 2, 1));
    let readings = reader.read(&image).unwrap();
    assert_eq!(readings[0].text.replace(' ', ""), "UNIT2", "{readings:?}");
    readings
        .iter()
        .for_each(|reading| well_formed(reading, &image));
    assert!(readings.is_sorted_by(|a, b| a.confidence >= b.confidence));
    refuses_broken_images(reader);
    assert_eq!(
        reader.read(&image).unwrap(),
        readings,
        "equal images have equal readings"
    );
}

fn well_formed(reading: &PlateReading, image: &Image) {
    assert_eq!(reading.text, reading.text.trim());
    assert!(
        !reading.text.is_empty() && (0.0..=1.0).contains(&reading.confidence),
        "{reading:?}"
    );
    let [a, b, c, d] = reading.corners;
    assert!(
        a[0] < b[0] && d[0] < c[0] && a[1] < d[1] && b[1] < c[1],
        "clockwise from the top left: {reading:?}"
    );
    let [x, y] = reading.centre();
    assert!(
        x > 0.0 && y > 0.0 && x < image.width as f32 && y < image.height as f32,
        "{reading:?}"
    );
}

fn refuses_broken_images(reader: &mut dyn PlateReader) {
    for (width, height, bytes) in [(0, 0, 0), (4, 4, 47), (9000, 1, 27000)] {
        let broken = Image {
            stamp: SimTime::default(),
            width,
            height,
            rgb: vec![0; bytes],
        };
        assert!(
            matches!(reader.read(&broken), Err(ReaderError::BadImage { .. })),
            "{width} x {height}, {bytes} bytes"
        );
    }
    let dot = Image {
        stamp: SimTime::default(),
        width: 1,
        height: 1,
        rgb: vec![0; 3],
    };
    assert!(reader.read(&dot).is_ok());
}

/// A chat model that reads the same plate in each image.
struct Scripted;

impl ChatModel for Scripted {
    fn name(&self) -> &str {
        "scripted"
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        assert!(
            matches!(request.format, Format::Schema(_))
                && request
                    .messages
                    .iter()
                    .any(|message| message.images.len() == 1)
        );
        let text = r#"{"plates": [{"text": "no parking", "box": [9, 9, 40, 20], "confidence": 0.3},
            {"text": "UNIT 2", "box": [300, 40, 360, 70], "confidence": 0.9}]}"#;
        Ok(ChatReply {
            text: text.into(),
            prompt_tokens: 0,
            completion_tokens: 0,
        })
    }
}

/// A chat model that does not answer.
struct Down;

impl ChatModel for Down {
    fn name(&self) -> &str {
        "down"
    }

    fn chat(&self, _: &ChatRequest) -> Result<ChatReply, ChatError> {
        Err(ChatError::Timeout {
            endpoint: "e".into(),
            seconds: 1,
        })
    }
}

#[test]
fn vlm_reader_conforms() {
    conforms(&mut VlmReader::new(Scripted));
    conforms(&mut (Box::new(VlmReader::new(Scripted)) as Box<dyn PlateReader>));
}

#[test]
fn vlm_reader_reports_a_model_that_does_not_answer() {
    let image = Image {
        stamp: SimTime::default(),
        width: 1,
        height: 1,
        rgb: vec![0; 3],
    };
    assert!(matches!(
        VlmReader::new(Down).read(&image),
        Err(ReaderError::Chat(ChatError::Timeout { .. }))
    ));
}

#[test]
fn ppocr_conforms() {
    match support::ppocr() {
        Some(mut reader) => conforms(&mut reader),
        None => skipped(support::NO_PPOCR),
    }
}

#[test]
fn errors_name_missing_and_damaged_model_files() {
    let store = ModelStore::new("/nonexistent");
    let error = PpOcr::from_store(&store).err().unwrap().to_string();
    assert!(
        error.contains("/nonexistent/ppocr-v4-det.onnx") && error.contains("models pull"),
        "{error}"
    );
    let this = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    assert!(matches!(
        PpOcr::load(&this, &this, None),
        Err(ReaderError::Model { .. })
    ));
}
