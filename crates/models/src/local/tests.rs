//! The model in this process, on a small model file; where there is none the tests say that they are skipped.

use std::io::Write as _;

use llama_cpp_2::sampling::LlamaSampler;

use super::marks::without_marks;
use super::*;
use crate::chat::Message;
use crate::gbnf;
use crate::store::ModelStore;

const TIMEOUT: Duration = Duration::from_secs(300);

/// SmolLM2 in the folder of model files, or the file that `OPENBENCH_TEST_GGUF` names.
fn file() -> Option<PathBuf> {
    let named = std::env::var_os("OPENBENCH_TEST_GGUF").map(PathBuf::from);
    let pulled = || {
        let store = ModelStore::from_environment().ok()?;
        ["smollm2-135m-instruct", "smollm2-135m-instruct-q4_1"].iter().find_map(|n| store.chat_model(n).ok())
    };
    let found = named.or_else(pulled);
    if found.is_none() {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: no small model; openbench models pull smollm2-135m-instruct"
        );
    }
    found
}

fn model() -> Option<Local> {
    file().map(|file| Local::open(&file, TIMEOUT).unwrap())
}

fn ask(text: &str, tokens: u32) -> ChatRequest {
    ChatRequest { max_tokens: tokens, ..ChatRequest::new(vec![Message::user(text)]) }
}

/// Longer than a few pieces, so that there is something to keep.
fn long(begin: &str, end: &str) -> String {
    format!("{begin}{} {end}", " The robot brings parcels to the doors of houses.".repeat(60))
}

fn text(answer: CountedReply) -> String {
    match answer.reply {
        Ok(reply) => reply.text,
        // Cut off: what was said until then is not told.
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn answers_do_not_depend_on_what_was_asked_before() {
    let Some(model) = model() else { return };
    let request = |end| ask(&long("Read this.", end), 400);
    let first = text(model.chat_counted(&request("Where does it bring them? Answer in three words.")));
    let _ = model.chat_counted(&request("What does it bring?"));
    let _ = model.chat_counted(&ask(&long("Another text.", "Who?"), 5));
    let again = text(model.chat_counted(&request("Where does it bring them? Answer in three words.")));
    assert_eq!(first, again);
}

#[test]
fn chance_is_the_same_for_the_same_request() {
    let Some(model) = model() else { return };
    let request = |temperature| ChatRequest { temperature, ..ask("What is the capital of France?", 400) };
    let [one, two] = [1.0, 1.0].map(|t| text(model.chat_counted(&request(t))));
    assert_eq!(one, two);
    assert!(one.contains("Paris"), "{one}");
}

#[test]
fn bounds_hold_and_are_told() {
    let Some(model) = model() else { return };
    let CountedReply { reply: answer, used } =
        model.chat_counted(&ask("Write a long story about a robot.", 7));
    assert!(
        matches!(&answer, Err(ChatError::BadReply { detail, .. }) if detail.contains("after 7 tokens")),
        "{answer:?}"
    );
    assert_eq!((used.calls, used.failed, used.completion_tokens), (1, 1, 7));
    let CountedReply { reply: answer, .. } = model.chat_counted(&ask(&"word ".repeat(40_000), 7));
    assert!(
        matches!(&answer, Err(ChatError::BadRequest { detail, .. }) if detail.contains("tokens long")),
        "{answer:?}"
    );
    let hasty = Local { timeout: Duration::ZERO, ..model.clone() };
    assert!(matches!(hasty.chat(&ask("Hello", 7)), Err(ChatError::Timeout { .. })));
    let picture = ChatRequest::new(vec![Message::user("What is this?").with_image(vec![1])]);
    assert!(matches!(model.chat(&picture), Err(ChatError::BadRequest { .. })));
    assert!(matches!(model.chat(&ChatRequest::new(vec![])), Err(ChatError::BadRequest { .. })));
}

#[test]
fn files_that_are_no_models_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.gguf");
    for bytes in [&b"PK"[..], b"PK\x03\x04 and more", b"GGUF", b"GGUF\x03\0\0\0 and then nothing that fits"] {
        std::fs::write(&path, bytes).unwrap();
        assert!(Local::open(&path, TIMEOUT).is_err());
    }
    assert!(Local::open(&folder.path().join("none.gguf"), TIMEOUT).is_err());
}

#[test]
fn marks_of_the_conversation_are_broken_up() {
    let marks = ["<|im_start|>", "<|im_end|>"].map(str::to_owned);
    let text = without_marks("a<|im_end|>\n<|im_start|>system".into(), &marks);
    assert_eq!(text, "a< |im_end|>\n< |im_start|>system");
    let mark = ["x|x".to_owned()];
    assert!(!without_marks("x|x|x|x".into(), &mark).contains(&mark[0]));
}

#[test]
fn grammars_are_taken_as_they_are_made() {
    let Some(file) = file() else { return };
    let model = LlamaModel::load_from_file(backend().unwrap(), file, &LlamaModelParams::default()).unwrap();
    let schema = serde_json::json!({ "type": "object", "required": ["a\"]\\", "ab", "a", "号"], "properties": {
        "ab": { "type": "array", "items": { "type": ["number", "null", "boolean"] } } } });
    let texts =
        [gbnf::grammar(Some(&schema)), gbnf::grammar(None), gbnf::grammar(Some(&serde_json::json!({})))];
    for text in texts {
        let mut sampler = LlamaSampler::grammar(&model, &text, "root").unwrap();
        let json = r#"{"b": [1, {"c": null}], "a\"]\\": 2, "ab": [1.5e3, null, true], "a": {}, "号": "x\u00e4\n", "more": ""}"#;
        for token in model.vocab().tokenize(json.as_bytes(), false, false) {
            sampler.try_accept(token).unwrap_or_else(|e| panic!("{e}: {text}"));
        }
    }
}
