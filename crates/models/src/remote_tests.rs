//! Tests of the client with scripted servers on loopback.

use std::time::{Duration, Instant};

use serde_json::Value;

use super::*;
use crate::loopback::{Loopback, SILENCE, http};
use crate::open::Endpoint;
use crate::transport::Bounds;

const KEY: &str = "sk-top-secret-123";

fn ok(text: &str) -> String {
    let usage = json!({ "prompt_tokens": 12, "completion_tokens": 3 });
    http(
        "200 OK",
        &json!({ "choices": [{ "message": { "content": text } }], "usage": usage }).to_string(),
    )
}

fn bounds() -> Bounds {
    Bounds {
        timeout: Duration::from_millis(400),
        retries: 2,
        first_pause: Duration::from_millis(5),
        longest_pause: Duration::from_millis(50),
        max_reply_bytes: 2000,
    }
}

fn model_of(provider: Provider, base: &str) -> Remote {
    Endpoint::new(provider, Some(base), variable)
        .unwrap()
        .model("m", bounds())
}

/// The only environment variable of these tests.
fn variable(name: &str) -> Option<String> {
    (name == "OPENBENCH_API_KEY").then(|| KEY.to_owned())
}

fn model(base: &str) -> Remote {
    model_of(Provider::OpenAi, base)
}

/// A scripted server, and the address of its endpoint.
fn serve(script: Vec<String>) -> (String, Loopback) {
    let server = Loopback::serve(script);
    (format!("{}/v1", server.address), server)
}

fn hello() -> ChatRequest {
    ChatRequest::new(vec![Message::system("be brief"), Message::user("hello")])
}

/// The schema of a list of integers.
fn schema() -> Schema {
    let text = json!({
        "type": "object",
        "properties": { "order": { "type": "array", "items": { "type": "integer" } } },
        "required": ["order"],
    });
    Schema {
        name: "order".into(),
        text: text.to_string(),
    }
}

fn ask(script: Vec<String>) -> (Result<ChatReply, ChatError>, Vec<String>) {
    ask_for(Provider::OpenAi, &hello(), script)
}

fn ask_for(
    provider: Provider,
    request: &ChatRequest,
    script: Vec<String>,
) -> (Result<ChatReply, ChatError>, Vec<String>) {
    let (base, server) = serve(script);
    let answer = model_of(provider, &base).chat(request);
    let shown = format!(
        "{answer:?} {}",
        answer
            .as_ref()
            .map_or_else(ToString::to_string, |reply| reply.text.clone())
    );
    assert!(!shown.contains(KEY), "the key shows in {shown}");
    (answer, server.requests())
}

/// The JSON in a request.
fn sent(request: &str) -> Value {
    serde_json::from_str(request.split("\r\n\r\n").nth(1).unwrap()).unwrap()
}

/// The form that a request to OpenAI asks for.
fn form(request: &str) -> Option<String> {
    sent(request)["response_format"]["type"]
        .as_str()
        .map(str::to_owned)
}

fn costs(reply: &ChatReply) -> (&str, u32, u32) {
    (&reply.text, reply.prompt_tokens, reply.completion_tokens)
}

#[test]
fn openai_requests_and_answers() {
    let (answer, requests) = ask(vec![ok("hi")]);
    assert_eq!(costs(&answer.unwrap()), ("hi", 12, 3));
    assert!(requests[0].starts_with("POST /v1/chat/completions HTTP/1.1\r\n"));
    assert!(requests[0].contains(&format!("Bearer {KEY}")));
    let messages = json!([
        { "role": "system", "content": "be brief" },
        { "role": "user", "content": "hello" },
    ]);
    let wanted =
        json!({ "model": "m", "messages": messages, "max_tokens": 1024, "temperature": 0.0 });
    assert_eq!(sent(&requests[0]), wanted);
}

#[test]
fn anthropic_requests_and_answers() {
    let reply = json!({
        "id": "msg_1", "type": "message", "role": "assistant", "model": "m",
        "content": [{ "type": "text", "text": "hi" }],
        "stop_reason": "end_turn", "stop_sequence": null,
        "usage": { "input_tokens": 12, "output_tokens": 3 },
    });
    let request = hello().as_schema(schema());
    let (answer, requests) = ask_for(
        Provider::Anthropic,
        &request,
        vec![http("200 OK", &reply.to_string())],
    );
    assert_eq!(costs(&answer.unwrap()), ("hi", 12, 3));
    assert!(
        requests[0].starts_with("POST /v1/messages HTTP/1.1\r\n"),
        "{}",
        requests[0]
    );
    assert!(
        requests[0].contains(&format!("x-api-key: {KEY}"))
            && requests[0].contains("anthropic-version")
    );
    let sent = sent(&requests[0]);
    assert_eq!(sent["system"][0]["text"], "be brief");
    assert_eq!(sent["messages"][0]["content"][0]["text"], "hello");
    assert_eq!(
        sent["output_config"]["format"]["schema"]["properties"]["order"]["type"],
        "array"
    );
}

#[test]
fn gemini_requests_have_the_key_in_a_header() {
    let content = json!({ "parts": [{ "text": "hi" }], "role": "model" });
    let candidate = json!({ "content": content, "finishReason": "STOP" });
    let usage = json!({ "promptTokenCount": 12, "candidatesTokenCount": 3, "totalTokenCount": 15 });
    let reply = json!({ "candidates": [candidate], "usageMetadata": usage }).to_string();
    let request = ChatRequest {
        messages: vec![
            Message::system("be brief"),
            Message::user("see").with_image(vec![0x89, 1]),
        ],
        ..hello().as_schema(schema())
    };
    let (answer, requests) = ask_for(Provider::Gemini, &request, vec![http("200 OK", &reply)]);
    assert_eq!(costs(&answer.unwrap()), ("hi", 12, 3));
    let line = requests[0].lines().next().unwrap();
    assert_eq!(line, "POST /v1/v1beta/models/m:generateContent HTTP/1.1");
    assert!(requests[0].contains(&format!("x-goog-api-key: {KEY}")));
    let sent = sent(&requests[0]);
    assert_eq!(sent["systemInstruction"]["parts"][0]["text"], "be brief");
    assert_eq!(
        sent["contents"][0]["parts"][1]["inlineData"]["data"],
        "iQE="
    );
    assert_eq!(
        sent["generationConfig"]["responseJsonSchema"]["type"],
        "object"
    );
}

#[test]
fn images_are_data_urls_and_json_is_requested() {
    let request =
        ChatRequest::new(vec![Message::user("see").with_image(vec![0xff, 0xd8, 1])]).as_json();
    let (_, requests) = ask_for(Provider::OpenAi, &request, vec![ok("{}")]);
    let sent = sent(&requests[0]);
    assert_eq!(
        sent["messages"][0]["content"][1]["image_url"]["url"],
        "data:image/jpeg;base64,/9gB"
    );
    assert_eq!(sent["response_format"]["type"], "json_object");
}

#[test]
fn without_support_for_schemas_json_is_requested_then_text() {
    let (base, server) = serve(vec![
        http(
            "400 Bad Request",
            "{\"error\": {\"message\": \"response_format json_schema is unknown\"}}",
        ),
        http("400 Bad Request", ""),
        ok("{\"order\": [1]}"),
        ok("{\"order\": [1]}"),
    ]);
    let model = model(&base);
    let request = hello().as_schema(schema());
    assert_eq!(model.chat(&request).unwrap().text, "{\"order\": [1]}");
    assert!(model.chat(&request).is_ok());
    let forms: Vec<_> = server
        .requests()
        .iter()
        .map(|request| form(request))
        .collect();
    assert_eq!(
        forms,
        [
            Some("json_schema".into()),
            Some("json_object".into()),
            None,
            None
        ]
    );
}

#[test]
fn without_support_for_temperatures_none_is_sent() {
    let complaint =
        "{\"error\": {\"message\": \"Unsupported value: 'temperature' does not support 0\"}}";
    let (base, server) = serve(vec![http("400 Bad Request", complaint), ok("hi"), ok("hi")]);
    let model = model(&base);
    assert!(model.chat(&hello()).is_ok() && model.chat(&hello()).is_ok());
    let requests = server.requests();
    let has_one = requests
        .iter()
        .map(|request| sent(request).get("temperature").is_some());
    assert_eq!(has_one.collect::<Vec<_>>(), [true, false, false]);
}

#[test]
fn other_errors_of_a_request_are_not_retried() {
    let (base, server) = serve(vec![http(
        "400 Bad Request",
        "{\"error\": {\"message\": \"no such model\"}}",
    )]);
    let answer = model(&base).chat(&hello().as_schema(schema()));
    assert!(
        matches!(answer, Err(ChatError::Status { code: 400, .. })),
        "{answer:?}"
    );
    assert_eq!(server.requests().len(), 1);
}

#[test]
fn unusable_answers_are_counted() {
    let usage = json!({ "prompt_tokens": 12, "completion_tokens": 900 });
    let choice = json!({ "message": { "content": "[" }, "finish_reason": "length" });
    let cut = json!({ "choices": [choice], "usage": usage });
    let (base, _server) = serve(vec![http("200 OK", &cut.to_string())]);
    let CountedReply { reply, used } = model(&base).chat_counted(&hello());
    assert!(
        matches!(reply, Err(ChatError::BadReply { .. })),
        "{reply:?}"
    );
    assert_eq!(
        (
            used.calls,
            used.failed,
            used.prompt_tokens,
            used.completion_tokens
        ),
        (1, 1, 12, 900)
    );
}

#[test]
fn invalid_requests_are_errors() {
    let (answer, _) = ask(vec![http(
        "400 Bad Request",
        "{\"error\": {\"message\": \"no such model\"}}",
    )]);
    assert!(
        matches!(answer, Err(ChatError::Status { code: 400, .. })),
        "{answer:?}"
    );
    let nothing = model("http://127.0.0.1:9/v1").chat(&ChatRequest::new(vec![]));
    assert!(
        matches!(nothing, Err(ChatError::BadRequest { .. })),
        "{nothing:?}"
    );
    let bad = Schema {
        name: "x".into(),
        text: "{".into(),
    };
    let bad = model("http://127.0.0.1:9/v1").chat(&hello().as_schema(bad));
    assert!(matches!(bad, Err(ChatError::BadRequest { .. })), "{bad:?}");
}

#[test]
fn busy_and_broken_servers_are_retried() {
    let (answer, requests) = ask(vec![
        http("429 Too Many Requests", ""),
        http("503 Busy", ""),
        ok("late"),
    ]);
    assert_eq!(answer.unwrap().text, "late");
    assert_eq!(requests.len(), 3);
    let (answer, _) = ask(vec![String::new(), ok("second")]);
    assert_eq!(answer.unwrap().text, "second");
}

#[test]
fn the_number_of_attempts_is_limited() {
    let (answer, _) = ask(vec![http("500 Oops", "x"); 3]);
    assert!(
        matches!(answer, Err(ChatError::Status { code: 500, .. })),
        "{answer:?}"
    );
}

#[test]
fn retry_after_is_respected_up_to_a_limit() {
    let busy =
        "HTTP/1.1 429 Busy\r\nretry-after: 3600\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
            .to_owned();
    let start = Instant::now();
    assert!(ask(vec![busy, ok("x")]).0.is_ok());
    assert!((Duration::from_millis(50)..Duration::from_secs(5)).contains(&start.elapsed()));
}

#[test]
fn refusals_are_final_and_their_message_has_no_key() {
    let complaint = json!({ "error": { "message": format!("bad key {KEY}") } }).to_string();
    let (answer, _) = ask(vec![http("401 Unauthorized", &complaint)]);
    let Err(ChatError::Status {
        code: 401, detail, ..
    }) = answer
    else {
        panic!("{answer:?}")
    };
    assert_eq!(detail, "bad key [key]");
}

#[test]
fn a_key_in_an_answer_is_removed() {
    assert_eq!(
        ask(vec![ok(&format!("you sent {KEY}"))]).0.unwrap().text,
        "you sent [key]"
    );
}

#[test]
fn redirects_are_not_followed() {
    let moved = "HTTP/1.1 307 Moved\r\nlocation: http://127.0.0.1:9/\r\ncontent-length: 0\r\n\
                 connection: close\r\n\r\n";
    let (answer, _) = ask(vec![moved.into()]);
    assert!(
        matches!(answer, Err(ChatError::Status { code: 307, .. })),
        "{answer:?}"
    );
}

#[test]
fn malformed_answers_are_errors() {
    let half = http("200 OK", "{\"choices\": [{\"message\": {\"con");
    let cut =
        json!({ "choices": [{ "message": { "content": "[1," }, "finish_reason": "length" }] })
            .to_string();
    let choice = json!({ "message": { "content": null }, "finish_reason": "content_filter" });
    let null = json!({ "choices": [choice] }).to_string();
    let long = http("200 OK", &"x".repeat(2001));
    for bad in [
        half,
        http("200 OK", "<html>"),
        http("200 OK", "[]"),
        http("200 OK", &cut),
        http("200 OK", &null),
        long,
    ] {
        let (answer, _) = ask(vec![bad.clone()]);
        assert!(
            matches!(answer, Err(ChatError::BadReply { .. })),
            "{bad}: {answer:?}"
        );
    }
}

#[test]
fn slow_servers_are_not_retried() {
    let start = Instant::now();
    let (answer, _) = ask(vec![SILENCE.into()]);
    assert!(
        matches!(answer, Err(ChatError::Timeout { seconds: 1, .. })),
        "{answer:?}"
    );
    assert!(start.elapsed() < Duration::from_secs(3));
}

#[test]
fn servers_without_http_are_unreachable() {
    let (answer, _) = ask(vec!["garbage\r\n\r\n".into(); 3]);
    assert!(
        matches!(answer, Err(ChatError::Unreachable { .. })),
        "{answer:?}"
    );
    let nobody = model("http://127.0.0.1:9/v1").chat(&hello());
    assert!(
        matches!(nobody, Err(ChatError::Unreachable { .. })),
        "{nobody:?}"
    );
}

#[test]
fn debug_output_has_no_key() {
    assert!(!format!("{:?}", model("http://127.0.0.1:9/v1")).contains(KEY));
}
