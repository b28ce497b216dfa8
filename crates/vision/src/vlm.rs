//! Plate reading with a vision-language model behind any [`ChatModel`].
//!
//! The request contains the image as PNG and asks for a JSON object with a list of plates. Answers
//! may have a Markdown fence or prose around the JSON, or be a list without an object. A plate
//! without a valid box gets the whole image as its box. Models differ in the accuracy of boxes: do
//! not measure with them.

use std::io::Cursor;

use image::{ImageFormat, RgbImage};
use openbench_core::Image;
use openbench_core::registry::Entry;
use openbench_models::spec::{FORMS, Form};
use openbench_models::{ChatModel, ChatRequest, Message, Schema};
use serde_json::{Value, json};

use crate::error::{AnswerError, ReaderError};
use crate::part::{ReaderContext, ReaderPart};
use crate::reader::{PlateReader, PlateReading, check_image, sort_readings};

/// Maximum number of plates that are read from one answer.
const MAX_PLATES: usize = 64;
/// Maximum length of a plate's text, characters; longer texts are ignored.
const MAX_TEXT_CHARS: usize = 100;
/// Confidence of a plate for which the model states none.
const DEFAULT_CONFIDENCE: f32 = 0.8;
/// Maximum length of an answer, tokens. Reasoning models count their reasoning.
const MAX_TOKENS: u32 = 4096;
/// Length of the beginning of an answer in errors, characters.
const QUOTED_CHARS: usize = 200;

/// The instructions for the model.
const INSTRUCTIONS: &str = "\
You read door plates and house numbers in camera images of a delivery robot. Answer with \
one JSON object and nothing else: {\"plates\": [{\"text\": string, \"box\": [left, top, \
right, bottom], \"confidence\": number}]}. \"text\" is exactly what the plate says, letter \
by letter; \"box\" is in pixels from the image's top left corner; \"confidence\" is 0 to \
1. Leave out what you cannot read. Without any legible plate the list is empty.";

/// A [`PlateReader`] that uses a vision-language model.
#[derive(Debug)]
pub struct VlmReader<M> {
    model: M,
}

impl<M: ChatModel> VlmReader<M> {
    /// A reader with `model`, which must accept images.
    pub fn new(model: M) -> Self {
        Self { model }
    }
}

impl<M: ChatModel> PlateReader for VlmReader<M> {
    fn name(&self) -> &str {
        self.model.name()
    }

    fn computes_here(&self) -> bool {
        false
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        check_image(image)?;
        let question = format!(
            "The image has {} x {} pixels. Which plates do you read?",
            image.width, image.height
        );
        let messages = vec![
            Message::system(INSTRUCTIONS),
            Message::user(question).with_image(png(image)?),
        ];
        let request = ChatRequest {
            max_tokens: MAX_TOKENS,
            ..ChatRequest::new(messages)
        };
        let answer = self.model.chat(&request.as_schema(schema()))?.text;
        let mut readings = plates(&answer, image).map_err(|source| ReaderError::BadAnswer {
            model: self.model.name().to_owned(),
            source,
        })?;
        sort_readings(&mut readings);
        Ok(readings)
    }
}

/// The registrations of vision-language models, one for each form of their names.
pub fn entries() -> impl Iterator<Item = Entry<ReaderPart>> {
    FORMS
        .iter()
        .map(|form| Entry::new(form.name, form.about, part(form)))
}

fn part(form: &'static Form) -> ReaderPart {
    ReaderPart::new(|argument, context: &mut ReaderContext<'_>| {
        let model = (context.open_model)(&form.spec(argument))?;
        Ok(Box::new(VlmReader::new(model)))
    })
}

/// The schema of an answer.
fn schema() -> Schema {
    let plate = json!({
        "type": "object",
        "properties": {
            "text": { "type": "string" },
            "box": { "type": "array", "items": { "type": "number" } },
            "confidence": { "type": "number" },
        },
        "required": ["text", "box", "confidence"],
    });
    let plates = json!({ "type": "array", "items": plate });
    let answer =
        json!({ "type": "object", "properties": { "plates": plates }, "required": ["plates"] });
    Schema {
        name: "plates".to_owned(),
        text: answer.to_string(),
    }
}

/// The image as a PNG file.
fn png(image: &Image) -> Result<Vec<u8>, ReaderError> {
    let picture = RgbImage::from_raw(image.width, image.height, image.rgb.clone());
    let picture = picture.ok_or_else(|| ReaderError::BadImage {
        detail: "its bytes do not fit its size".into(),
    })?;
    let mut file = Cursor::new(Vec::new());
    picture.write_to(&mut file, ImageFormat::Png)?;
    Ok(file.into_inner())
}

fn plates(answer: &str, image: &Image) -> Result<Vec<PlateReading>, AnswerError> {
    let value = json_within(answer).ok_or_else(|| AnswerError::NoJson {
        quoted: quote(answer),
    })?;
    // Models without schemas may leave out the object around the list.
    let list = value.get("plates").unwrap_or(&value);
    let list = list.as_array().ok_or_else(|| AnswerError::NoList {
        quoted: quote(answer),
    })?;
    Ok(list
        .iter()
        .take(MAX_PLATES)
        .filter_map(|plate| reading(plate, image))
        .collect())
}

/// The JSON object or list in an answer, from its first bracket or brace on.
fn json_within(answer: &str) -> Option<Value> {
    // The deserializer stops behind the first value, so prose or a fence after it does no harm.
    let start = answer.find(['{', '['])?;
    let mut values = serde_json::Deserializer::from_str(&answer[start..]).into_iter();
    values.next()?.ok()
}

/// The reading of an entry; `None` if it has no text.
fn reading(plate: &Value, image: &Image) -> Option<PlateReading> {
    let text = plate["text"]
        .as_str()
        .map(str::trim)
        .filter(|text| !text.is_empty())?;
    // No plate is that long: the model describes the image instead of reading it.
    if text.chars().count() > MAX_TEXT_CHARS {
        return None;
    }
    let stated = plate["confidence"]
        .as_f64()
        .map_or(DEFAULT_CONFIDENCE, |confidence| confidence as f32);
    // A number may be finite as `f64` and infinite as `f32`, and `clamp` keeps NaN.
    let confidence = if stated.is_finite() {
        stated.clamp(0.0, 1.0)
    } else {
        DEFAULT_CONFIDENCE
    };
    Some(PlateReading {
        text: text.to_owned(),
        confidence,
        corners: corners(&plate["box"], image),
    })
}

fn corners(stated: &Value, image: &Image) -> [[f32; 2]; 4] {
    let (width, height) = (image.width as f32, image.height as f32);
    let [left, top, right, bottom] =
        sides(stated, width, height).unwrap_or([0.0, 0.0, width, height]);
    [[left, top], [right, top], [right, bottom], [left, bottom]]
}

/// Left, top, right and bottom of a box, clipped to the image; `None` if it is not a valid box.
fn sides(stated: &Value, width: f32, height: f32) -> Option<[f32; 4]> {
    let left = side(&stated[0], width)?;
    let top = side(&stated[1], height)?;
    let right = side(&stated[2], width)?;
    let bottom = side(&stated[3], height)?;
    // Also false for boxes that clipping has made empty, which lie outside the image.
    (left < right && top < bottom).then_some([left, top, right, bottom])
}

fn side(stated: &Value, limit: f32) -> Option<f32> {
    stated.as_f64().map(|side| (side as f32).clamp(0.0, limit))
}

fn quote(answer: &str) -> String {
    answer
        .chars()
        // Errors are printed in one line, and an answer must not control the terminal.
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(QUOTED_CHARS)
        .collect()
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;
    use proptest::prelude::*;

    use super::*;

    fn image() -> Image {
        Image {
            stamp: SimTime::default(),
            width: 8,
            height: 4,
            rgb: vec![7; 96],
        }
    }

    fn read(answer: &str) -> Result<Vec<PlateReading>, AnswerError> {
        plates(answer, &image())
    }

    const PLATE: &str =
        r#"{"plates": [{"text": " UNIT 1 ", "box": [1, 1, 3, 2], "confidence": 0.9}]}"#;

    #[test]
    fn fences_prose_and_lists_without_object_are_accepted() {
        let expected = read(PLATE).unwrap();
        assert_eq!(
            (expected[0].text.as_str(), expected[0].confidence),
            ("UNIT 1", 0.9)
        );
        assert_eq!(
            expected[0].corners,
            [[1.0, 1.0], [3.0, 1.0], [3.0, 2.0], [1.0, 2.0]]
        );
        assert_eq!(read(&format!("```json\n{PLATE}\n```")).unwrap(), expected);
        assert_eq!(
            read(&format!("Here you are: {PLATE} Anything else?")).unwrap(),
            expected
        );
        let list = &PLATE[PLATE.find('[').unwrap()..PLATE.len() - 1];
        assert_eq!(read(list).unwrap(), expected);
    }

    #[test]
    fn an_empty_list_is_valid_and_no_list_is_not() {
        assert!(read(r#"{"plates": []}"#).unwrap().is_empty());
        for bad in [
            "",
            "I see a door.",
            r#"{"plates": "none"}"#,
            r#"{"plates": [{"text": "UN"#,
            r#"{"text": "1"}"#,
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn invalid_boxes_are_the_whole_image_and_invalid_entries_are_ignored() {
        let whole = [[0.0, 0.0], [8.0, 0.0], [8.0, 4.0], [0.0, 4.0]];
        for invalid in [
            "null",
            "[3, 1, 1, 2]",
            "[1, 2]",
            "[\"a\", 0, 1, 1]",
            "[-9, -9, 999, 999]",
        ] {
            let readings = read(&format!(r#"[{{"text": "1", "box": {invalid}}}]"#)).unwrap();
            assert_eq!(
                (readings[0].corners, readings[0].confidence),
                (whole, DEFAULT_CONFIDENCE),
                "{invalid}"
            );
        }
        assert!(
            read(r#"[{"text": ""}, {"text": 7}, 3, null]"#)
                .unwrap()
                .is_empty()
        );
    }

    #[test]
    fn images_round_trip_as_png() {
        let back = image::load_from_memory(&png(&image()).unwrap())
            .unwrap()
            .to_rgb8();
        assert_eq!((back.dimensions(), back.into_raw()), ((8, 4), image().rgb));
    }

    proptest! {
        #[test]
        fn no_answer_panics(answer in "\\PC{0,200}") {
            let _ = read(&answer);
        }
    }
}
