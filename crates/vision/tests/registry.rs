//! Readers by name, and a reader that is added by another crate.

use openbench_core::{Image, SimTime};
use openbench_models::{ChatError, ChatModel, ChatReply, ChatRequest, ModelStore};
use openbench_vision::{
    PlateReader, PlateReading, ReaderContext, ReaderEntry, ReaderError, ReaderRegistry,
    RegistryError,
};

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

fn with_blind() -> ReaderRegistry {
    let entry = ReaderEntry::new("blind", "reads nothing", |_, _| Ok(Box::new(Blind)));
    ReaderRegistry::default().with(entry)
}

fn make(registry: &ReaderRegistry, list: &str) -> Result<Box<dyn PlateReader>, RegistryError> {
    let open = &mut |text: &str| Ok(Box::new(Named(text.to_owned())) as Box<dyn ChatModel>);
    let context = ReaderContext::new(open).with_store(ModelStore::new("/nonexistent"));
    registry.make(list, &mut { context })
}

#[test]
fn an_added_reader_is_made_by_its_name_and_listed() {
    let registry = with_blind();
    assert_eq!(make(&registry, "blind").unwrap().name(), "blind");
    let names: Vec<&str> = registry.entries().iter().map(ReaderEntry::name).collect();
    assert_eq!(names, ["ppocr-v4", "PROVIDER:MODEL", "blind"]);
    assert!(
        registry
            .entries()
            .iter()
            .all(|entry| !entry.description().is_empty())
    );
}

#[test]
fn chat_models_are_readers_by_their_own_names() {
    let reader = make(&ReaderRegistry::default(), "openai:m@http://h/v1").unwrap();
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
    let registry = with_blind();
    assert_eq!(
        registry.split("blind, openai:a,b ,ppocr-v4"),
        ["blind", "openai:a,b", "ppocr-v4"]
    );
    assert_eq!(
        registry.split("replay:a, b,ollama:m"),
        ["replay:a, b", "ollama:m"]
    );
    assert_eq!(registry.split(""), [""]);
}

#[test]
fn required_model_files_have_no_duplicates() {
    let registry = with_blind();
    assert_eq!(
        registry.model_files("ppocr-v4,blind,ppocr-v4"),
        ["ppocr-v4"]
    );
    assert!(registry.model_files("blind").is_empty());
}

#[test]
fn errors_name_the_reader() {
    let unknown = make(&with_blind(), "ppocr-v9").err().unwrap();
    assert!(matches!(unknown, RegistryError::Unknown { .. }));
    assert!(unknown.to_string().contains("blind"), "{unknown}");
    let absent = make(&with_blind(), "ppocr-v4").err().unwrap();
    assert!(
        absent
            .to_string()
            .contains("/nonexistent/ppocr-v4-det.onnx"),
        "{absent}"
    );
}

#[test]
fn a_later_reader_replaces_an_earlier_one_of_its_name() {
    let entry = ReaderEntry::new("ppocr-v4", "stands in", |_, _| Ok(Box::new(Blind)));
    let registry = ReaderRegistry::default().with(entry);
    assert_eq!(make(&registry, "ppocr-v4").unwrap().name(), "blind");
}
