//! Policy servers that answer wrongly, late, too much or not at all: each is an error with a name.
//!
//! The servers are scripted, on loopback, with the WebSocket of another side: a client's mistakes
//! are not repeated by its test.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use openbench_agents::remote::Patience;
use openbench_agents::served::arrays::{Keys, entry, from_bytes, text, to_bytes};
use openbench_agents::served::depth::DepthImage;
use openbench_agents::served::{
    Answer, Episode, NAVDP, NavDp, OPENPI, OpenPi, Protocol, Question, Server, ServerError,
    Settings, Turns, VLA_EVAL, VlaEval,
};
use openbench_core::{Image, MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use rmpv::Value;
use tungstenite::{Message, WebSocket};

/// Long enough for loopback on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);
/// For servers that never answer.
const IMPATIENCE: Duration = Duration::from_millis(300);

/// What a scripted WebSocket server does on a connection.
type Play = fn(&mut WebSocket<TcpStream>);

/// Serves one connection as the script says; returns the address.
fn serve(
    play: impl FnOnce(&mut WebSocket<TcpStream>) + Send + 'static,
) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("ws://{}", listener.local_addr().unwrap());
    let thread = std::thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        let mut socket = tungstenite::accept(stream).unwrap();
        play(&mut socket);
        // Until the client is gone, so that nothing but the script ends the connection.
        while socket.read().is_ok() {}
    });
    (address, thread)
}

fn settings(act: Duration) -> Settings {
    settings_of(&OPENPI, act)
}

fn settings_of(protocol: &Protocol, act: Duration) -> Settings {
    let mut settings = Settings::of(protocol, &Default::default()).unwrap();
    // The first question has the longer time of both.
    settings.patience = Patience { begin: act, act };
    settings
}

fn episode(has_point: bool) -> Episode {
    Episode {
        words: "box to unit 1".into(),
        has_point,
        robot: RobotDescription::sentry(),
        seed: 7,
    }
}

fn question() -> Question {
    let image = Image {
        stamp: SimTime::ZERO,
        width: 640,
        height: 480,
        rgb: [10, 20, 30].repeat(640 * 480),
    };
    Question {
        image: Arc::new(image),
        words: "box to unit 1".into(),
        goal: Some(MapPoint::new(3.0, -1.0)),
        pose: Pose2::new(1.0, 2.0, 0.5),
        velocity: Velocity::new(0.25, 0.0),
        number: 0,
        depth: Some(DepthImage {
            width: 2,
            height: 1,
            metres: vec![1.5, 0.0],
        }),
    }
}

fn map<const N: usize>(entries: [(&str, Value); N]) -> Value {
    let entries = entries.into_iter();
    Value::Map(
        entries
            .map(|(key, value)| (Value::from(key), value))
            .collect(),
    )
}

fn say(socket: &mut WebSocket<TcpStream>, value: &Value) {
    socket.send(Message::binary(to_bytes(value))).unwrap();
}

fn hear(socket: &mut WebSocket<TcpStream>) -> Value {
    from_bytes(&socket.read().unwrap().into_data()).unwrap()
}

fn velocities(keys: Keys, linear: f64) -> Value {
    map([("actions", keys.floats(&[linear, 0.5]))])
}

/// Asks an openpi server, which has sent its metadata, once.
fn ask_openpi(play: Play, act: Duration) -> Result<Answer, ServerError> {
    let (address, thread) = serve(move |socket| {
        say(socket, &map([]));
        play(socket);
    });
    let mut server = OpenPi::new(&address, settings(act)).unwrap();
    let begun = server.begin(&episode(false));
    let answer = begun.and_then(|()| server.ask(&question()));
    server.end();
    thread.join().unwrap();
    answer
}

/// Asks a vla-eval server once.
fn ask_vla_eval(play: Play) -> Result<Answer, ServerError> {
    let (address, thread) = serve(play);
    let mut server = VlaEval::new(&address, settings_of(&VLA_EVAL, PATIENCE)).unwrap();
    let begun = server.begin(&episode(false));
    let answer = begun.and_then(|()| server.ask(&question()));
    server.end();
    thread.join().unwrap();
    answer
}

#[test]
fn an_openpi_server_gets_image_state_goal_and_prompt() {
    let answer = ask_openpi(
        |socket| {
            let observation = hear(socket);
            let shape = |key: &str| {
                let array = entry(&observation, key).unwrap();
                let shape = entry(array, "shape").and_then(Value::as_array).unwrap();
                shape.iter().filter_map(Value::as_u64).collect::<Vec<_>>()
            };
            assert_eq!(shape("observation/image"), [224, 224, 3]);
            assert_eq!(shape("observation/state"), [5]);
            assert_eq!(shape("observation/goal"), [2]);
            assert_eq!(
                entry(&observation, "prompt").and_then(text),
                Some("box to unit 1")
            );
            // A ping comes in between, as from servers that keep connections alive.
            socket.send(Message::Ping(Vec::new().into())).unwrap();
            say(socket, &velocities(Keys::Bytes, 0.25));
        },
        PATIENCE,
    );
    let Ok(Answer::Velocities { steps, .. }) = answer else {
        panic!("{answer:?}");
    };
    assert_eq!(steps.len(), 1);
    assert_eq!(steps[0].velocity, Velocity::new(0.25, 0.5));
}

#[test]
fn what_an_openpi_server_does_wrong_has_a_name() {
    let cases: [(Play, Duration, &str); 9] = [
        (|_| {}, IMPATIENCE, "did not answer within"),
        (
            |socket| {
                socket
                    .send(Message::text("Traceback: KeyError: 'image'"))
                    .unwrap()
            },
            PATIENCE,
            "reports an error: Traceback: KeyError: 'image'",
        ),
        (
            |socket| socket.close(None).unwrap(),
            PATIENCE,
            "closed the connection",
        ),
        (
            |socket| socket.send(Message::binary(vec![0x92, 1])).unwrap(),
            PATIENCE,
            "it is no MessagePack",
        ),
        (
            |socket| say(socket, &map([("velocity", Value::from(1.0))])),
            PATIENCE,
            "it lacks `actions`",
        ),
        (
            |socket| say(socket, &velocities(Keys::Bytes, f64::NAN)),
            PATIENCE,
            "contains NaN or infinity in row 0",
        ),
        (
            |socket| say(socket, &velocities(Keys::Bytes, f64::INFINITY)),
            PATIENCE,
            "contains NaN or infinity in row 0",
        ),
        (
            |socket| {
                let zeros = Keys::Bytes.floats(&[0.0; 65]);
                say(socket, &map([("actions", zeros)]));
            },
            PATIENCE,
            "longer than 4 MiB or 4096 rows",
        ),
        (
            |socket| {
                let huge = Message::binary(vec![0; (4 << 20) + 1]);
                // The client hangs up before it is through.
                let _ = socket.send(huge);
            },
            PATIENCE,
            "longer than 4 MiB",
        ),
    ];
    for (play, act, expected) in cases {
        let error = ask_openpi(play, act).unwrap_err().to_string();
        assert!(error.contains(expected), "{error} instead of {expected}");
    }
}

#[test]
fn an_answer_that_trickles_in_is_too_late_nevertheless() {
    let (address, thread) = serve(|socket| {
        say(socket, &map([]));
        hear(socket);
        // A frame of 100 bytes, of which one comes every 50 ms: each is within the time.
        let mut stream = socket.get_ref();
        let mut frame = vec![0x82, 100];
        frame.extend([0; 100]);
        for byte in frame {
            if stream.write_all(&[byte]).is_err() {
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    });
    let mut server = OpenPi::new(&address, settings(IMPATIENCE)).unwrap();
    server.begin(&episode(false)).unwrap();
    let began = Instant::now();
    let error = server.ask(&question()).unwrap_err();
    assert_eq!(error, ServerError::Silent { within: IMPATIENCE });
    assert!(began.elapsed() < Duration::from_secs(3));
    server.end();
    thread.join().unwrap();
}

#[test]
fn where_nobody_listens_or_no_websocket_is_there_is_nothing_to_begin() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("ws://{}", free.local_addr().unwrap());
    drop(free);
    let mut server = OpenPi::new(&address, settings(PATIENCE)).unwrap();
    let error = server.reach().unwrap_err();
    assert!(matches!(error, ServerError::Unreachable { .. }), "{error}");

    let (address, thread) = http(vec![
        "HTTP/1.1 404 Not Found\r\ncontent-length: 0\r\n\r\n".into(),
    ]);
    let mut server = OpenPi::new(&address.replace("http", "ws"), settings(PATIENCE)).unwrap();
    let error = server.reach().unwrap_err();
    assert!(error.to_string().contains("404"), "{error}");
    thread.join().unwrap();
}

/// Answers the greeting, and takes the start of the episode; returns the number of the question
/// that follows.
fn greet(socket: &mut WebSocket<TcpStream>) -> u64 {
    let seq = |frame: &Value| entry(frame, "seq").and_then(Value::as_u64).unwrap();
    let hello = hear(socket);
    assert_eq!(entry(&hello, "type").and_then(text), Some("hello"));
    say(socket, &frame("hello", map([]), seq(&hello)));
    let start = hear(socket);
    assert_eq!(entry(&start, "type").and_then(text), Some("episode_start"));
    let observation = hear(socket);
    let payload = entry(&observation, "payload").unwrap();
    assert!(entry(entry(payload, "images").unwrap(), "camera").is_some());
    seq(&observation)
}

fn frame(kind: &str, payload: Value, seq: u64) -> Value {
    map([
        ("type", Value::from(kind)),
        ("payload", payload),
        ("seq", Value::from(seq)),
        ("timestamp", Value::from(0.0)),
    ])
}

#[test]
fn a_vla_eval_server_is_greeted_and_told_of_episodes() {
    let answer = ask_vla_eval(|socket| {
        let seq = greet(socket);
        say(socket, &frame("action", velocities(Keys::Text, 0.5), seq));
        let end = hear(socket);
        assert_eq!(entry(&end, "type").and_then(text), Some("episode_end"));
    });
    let Ok(Answer::Velocities { steps, .. }) = answer else {
        panic!("{answer:?}");
    };
    assert_eq!(steps[0].velocity.linear, 0.5);
}

#[test]
fn what_a_vla_eval_server_does_wrong_has_a_name() {
    let cases: [(Play, &str); 4] = [
        (
            |socket| {
                let seq = greet(socket);
                let error = map([("error", Value::from("observation_failed: ValueError"))]);
                say(socket, &frame("error", error, seq));
            },
            "reports an error: observation_failed: ValueError",
        ),
        (
            |socket| {
                let seq = greet(socket);
                say(
                    socket,
                    &frame("action", velocities(Keys::Text, 0.5), seq - 1),
                );
            },
            "answers another question",
        ),
        (
            |socket| {
                let seq = greet(socket);
                say(socket, &frame("hello", map([]), seq));
            },
            "its type is `hello` instead of `action`",
        ),
        (
            // As the package's server does with frames that it cannot read.
            |socket| {
                greet(socket);
                socket.close(None).unwrap();
            },
            "closed the connection",
        ),
    ];
    for (play, expected) in cases {
        let error = ask_vla_eval(play).unwrap_err().to_string();
        assert!(error.contains(expected), "{error} instead of {expected}");
    }
}

/// An HTTP server that answers each connection with the next text, and returns the requests.
fn http(answers: Vec<String>) -> (String, JoinHandle<Vec<String>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    let thread = std::thread::spawn(move || {
        let exchange = |answer: &String| {
            let (mut stream, _) = listener.accept().unwrap();
            let request = read_request(&stream);
            stream.write_all(answer.as_bytes()).unwrap();
            request
        };
        answers.iter().map(exchange).collect()
    });
    (address, thread)
}

fn read_request(stream: &TcpStream) -> String {
    let mut reader = BufReader::new(stream);
    let (mut head, mut length) = (String::new(), 0);
    while !head.ends_with("\r\n\r\n") {
        let start = head.len();
        reader.read_line(&mut head).unwrap();
        if let Some(value) = head[start..].to_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).unwrap();
    head + &String::from_utf8_lossy(&body)
}

fn ok(body: &str) -> String {
    let length = body.len();
    format!("HTTP/1.1 200 OK\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n{body}")
}

#[test]
fn a_navdp_server_gets_the_goal_from_the_camera_and_answers_from_it() {
    let trajectory = r#"{"trajectory": [[[0.25, 0.0, 0.0], [0.5, 0.1, 0.0]]]}"#;
    let (address, thread) = http(vec![ok(r#"{"algo": "navdp"}"#), ok(trajectory)]);
    let mut server = NavDp::new(&address, settings_of(&NAVDP, PATIENCE), Turns::default()).unwrap();
    server.begin(&episode(true)).unwrap();
    let answer = server.ask(&question()).unwrap();
    // The camera is 15 cm before `base_link`.
    let points = vec![MapPoint::new(0.4, 0.0), MapPoint::new(0.65, 0.1)];
    assert_eq!(
        answer,
        Answer::Path {
            points,
            lasts_s: None
        }
    );
    let requests = thread.join().unwrap();
    assert!(
        requests[0].starts_with("POST /navigator_reset "),
        "{}",
        requests[0]
    );
    assert!(requests[0].contains(r#""batch_size":1"#), "{}", requests[0]);
    assert!(requests[1].starts_with("POST /pointgoal_step "));
    for part in [
        "name=\"image\"; filename=\"image.jpg\"",
        "name=\"depth\"; filename=\"depth.png\"",
        r#"{"goal_x":[2.85],"goal_y":[-1.0]}"#,
    ] {
        assert!(requests[1].contains(part), "{part}");
    }
}

#[test]
fn a_navdp_server_that_answers_to_stay_lets_the_robot_stand() {
    let trajectory = r#"{"trajectory": [[[0.0, 0.0, 0.0], [0.01, -0.01, 0.0]]]}"#;
    let (address, thread) = http(vec![ok("{}"), ok(trajectory)]);
    let base = format!("{address}/policy");
    let mut server = NavDp::new(&base, settings_of(&NAVDP, PATIENCE), Turns::default()).unwrap();
    server.begin(&episode(true)).unwrap();
    let answer = server.ask(&question()).unwrap();
    let stands = Answer::Path {
        points: Vec::new(),
        lasts_s: None,
    };
    assert_eq!(answer, stands);
    let requests = thread.join().unwrap();
    assert!(requests[1].starts_with("POST /policy/pointgoal_step "));
}

#[test]
fn what_a_navdp_server_does_wrong_has_a_name() {
    let failure = "HTTP/1.1 500 Internal Server Error\r\ncontent-length: 9\r\n\
                   connection: close\r\n\r\n<b>no</b>";
    let many = format!(r#"{{"trajectory": [[{}[0, 0]]]}}"#, "[0, 0],".repeat(4096));
    for (answer, expected) in [
        (failure.to_owned(), "reports an error: 500"),
        (ok("<html>"), "cannot be read"),
        (ok(r#"{"trajectory": [[[NaN, 0.0, 0.0]]]}"#), "contains NaN"),
        (ok(&many), "longer than"),
        (String::new(), "no policy server can be reached"),
    ] {
        let (address, thread) = http(vec![ok("{}"), answer]);
        let mut server =
            NavDp::new(&address, settings_of(&NAVDP, PATIENCE), Turns::default()).unwrap();
        server.begin(&episode(true)).unwrap();
        let error = server.ask(&question()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error} instead of {expected}");
        thread.join().unwrap();
    }
}

#[test]
fn a_navdp_server_takes_points_only() {
    let mut server = NavDp::new(
        "http://127.0.0.1:9",
        settings_of(&NAVDP, PATIENCE),
        Turns::default(),
    )
    .unwrap();
    let error = server.begin(&episode(false)).unwrap_err();
    assert!(matches!(error, ServerError::Goal { .. }), "{error}");
}
