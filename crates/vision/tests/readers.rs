//! Readers by name, and a reader that is added by another crate.

use openbench_core::{Image, SimTime, with_causes};
use openbench_models::{ChatError, ChatModel, ChatReply, ChatRequest, ModelStore};
use openbench_vision::readers::{self, MakeReaderError, Readers, built_in, model_files};
use openbench_vision::{PlateReader, PlateReading, ReaderContext, ReaderError, ReaderPart};

/// A reader without readings.
struct Blind;

impl PlateReader for Blind {
    fn name(&self) -> &str {
        "blind"
    }

    fn read(&mut self, _: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        Ok(Vec::new())
    }
}

/// A chat model with this name that does not answer.
struct Named(String);

impl ChatModel for Named {
    fn name(&self) -> &str {
        &self.0
    }

    fn chat(&self, _: &ChatRequest) -> Result<ChatReply, ChatError> {
        Err(ChatError::Timeout {
            endpoint: "e".into(),
            seconds: 1,
        })
    }
}

fn with_blind() -> Readers {
    let part = ReaderPart::new(|_, _| Ok(Box::new(Blind)));
    built_in().with("blind", "reads nothing", part)
}

fn make(readers: &Readers, list: &str) -> Result<Box<dyn PlateReader>, MakeReaderError> {
    let open = &mut |text: &str| Ok(Box::new(Named(text.to_owned())) as Box<dyn ChatModel>);
    let context = ReaderContext::new(open).with_store(ModelStore::new("/nonexistent"));
    readers::make(readers, list, &mut { context })
}

#[test]
fn an_added_reader_is_made_by_its_name_and_listed() {
    let readers = with_blind();
    assert_eq!(make(&readers, "blind").unwrap().name(), "blind");
    let names: Vec<&str> = readers.names().collect();
    assert_eq!((names[0], names[names.len() - 1]), ("ppocr-v4", "blind"));
    assert!(readers.entries().all(|entry| !entry.about.is_empty()));
}

#[test]
fn chat_models_are_readers_by_their_own_names() {
    let reader = make(&built_in(), "openai:m@http://h/v1").unwrap();
    assert_eq!(reader.name(), "openai:m@http://h/v1");
}

#[test]
fn the_next_reader_of_a_list_reads_where_one_fails() {
    let mut reader = make(&with_blind(), "openai:m, blind").unwrap();
    assert_eq!(reader.name(), "openai:m, else blind");
    let image = Image {
        stamp: SimTime::ZERO,
        width: 1,
        height: 1,
        rgb: vec![0; 3],
    };
    assert_eq!(reader.read(&image).unwrap(), []);
}

#[test]
fn commas_inside_names_are_not_separators() {
    let readers = with_blind();
    assert_eq!(
        readers.split("blind, openai:a,b ,ppocr-v4"),
        ["blind", "openai:a,b", "ppocr-v4"]
    );
    assert_eq!(
        readers.split("replay:a, b,ollama:m"),
        ["replay:a, b", "ollama:m"]
    );
    assert_eq!(readers.split(""), [""]);
}

#[test]
fn required_model_files_have_no_duplicates() {
    let readers = with_blind();
    assert_eq!(
        model_files(&readers, "ppocr-v4,blind,ppocr-v4"),
        ["ppocr-v4"]
    );
    assert!(model_files(&readers, "blind").is_empty());
}

#[test]
fn errors_name_the_reader() {
    let unknown = make(&with_blind(), "ppocr-v9").err().unwrap();
    assert!(matches!(unknown, MakeReaderError::Unknown(_)));
    assert!(unknown.to_string().contains("blind"), "{unknown}");
    let absent = make(&with_blind(), "ppocr-v4").err().unwrap();
    let absent = with_causes(&absent);
    assert!(
        absent.contains("ppocr-v4") && absent.contains("/nonexistent/ppocr-v4-det.onnx"),
        "{absent}"
    );
}
