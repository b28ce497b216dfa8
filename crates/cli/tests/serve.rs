//! `openbench serve`: OSRM's HTTP API over a socket.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use common::Place;
use common::town::town;
use serde_json::Value;

struct Server {
    process: Child,
    address: String,
    /// Holds the map.
    _place: Place,
}

impl Server {
    fn start(words: &str) -> Self {
        let place = town();
        let mut command = Command::new(env!("CARGO_BIN_EXE_openbench"));
        command
            .args(["serve", "--map"])
            .arg(place.path("town.osm"))
            .args(["--listen", "127.0.0.1:0"]);
        let mut process = command
            .args(words.split_whitespace())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stderr.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        let address = line
            .trim()
            .rsplit_once("http://")
            .unwrap_or_else(|| panic!("{line}"))
            .1
            .to_owned();
        Self {
            process,
            address,
            _place: place,
        }
    }

    /// Status, head and body of an answer.
    fn send(&self, method: &str, target: &str) -> (u16, String, String) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        write!(
            stream,
            "{method} {target} HTTP/1.1\r\nHost: test\r\nConnection: close\r\n\r\n"
        )
        .unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, head.to_lowercase(), body.to_owned())
    }

    fn get(&self, target: &str) -> (u16, Value) {
        let (status, _, body) = self.send("GET", target);
        (
            status,
            serde_json::from_str(&body).unwrap_or_else(|error| panic!("{target}: {error}: {body}")),
        )
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

const PLACES: &str = "3.0,-0.0001;3.0002,0.00001";

#[test]
fn the_three_services_answer() {
    let server = Server::start("--profile foot");
    let (status, route) = server.get(&format!(
        "/route/v1/foot/{PLACES}?steps=true&annotations=true&overview=full"
    ));
    assert_eq!(
        (status, route["code"].as_str()),
        (200, Some("Ok")),
        "{route}"
    );
    let leg = &route["routes"][0]["legs"][0];
    assert!(
        route["routes"][0]["geometry"].is_string() && leg["steps"].as_array().unwrap().len() >= 2
    );
    let annotation = &leg["annotation"];
    let segments = annotation["distance"].as_array().unwrap().len();
    assert_eq!(
        annotation["nodes"].as_array().unwrap().len(),
        segments + 1,
        "{annotation}"
    );
    let (_, nearest) = server.get("/nearest/v1/foot/3.0001,0.00001?number=2");
    assert_eq!(
        nearest["waypoints"][0]["nodes"].as_array().unwrap().len(),
        2,
        "{nearest}"
    );
    let (_, table) = server.get(&format!(
        "/table/v1/foot/{PLACES};3.0001,0?annotations=duration,distance&sources=0;1"
    ));
    assert_eq!(table["durations"].as_array().unwrap().len(), 2, "{table}");
    assert_eq!(
        (&table["durations"][0][0], &table["distances"][1][1]),
        (&0.into(), &0.into())
    );
    let duration = &table["durations"][0][1];
    assert_eq!(duration, &route["routes"][0]["duration"]);
    let (_, route) = server.get("/route/v1/any/polyline(%7C%7CR_cbQ%7C%40o%40)?overview=false");
    assert!(route["code"].is_string());
}

/// What `benchmarks/routing/osrm.md` found OSRM to answer.
#[test]
fn what_cannot_be_answered_is_said_in_osrms_words() {
    let server = Server::start("");
    let many = vec!["3,0"; 501].join(";");
    for (target, code, message) in [
        ("/", "InvalidUrl", "URL string malformed"),
        (
            "/fly/v1/foot/3,0;3,0",
            "InvalidService",
            "Service fly not found!",
        ),
        (
            "/route/v2/foot/3,0;3,0",
            "InvalidVersion",
            "Service route not found!",
        ),
        (
            "/route/v1/foot/3,0;3",
            "InvalidQuery",
            "Query string malformed close to position",
        ),
        (
            "/route/v1/foot/3,0;3,0?steps=True",
            "InvalidQuery",
            "close to position 23",
        ),
        (
            "/route/v1/foot/3,0;3,0?speed=9",
            "InvalidQuery",
            "Query string malformed",
        ),
        (
            "/route/v1/foot/3,0",
            "InvalidOptions",
            "Number of coordinates needs to be at least two.",
        ),
        (
            "/route/v1/foot/3,0;3,0?radiuses=5",
            "InvalidOptions",
            "Number of elements in radiuses size 1 does not match",
        ),
        (
            "/route/v1/foot/3,0;3,95",
            "InvalidValue",
            "Invalid coordinate value.",
        ),
        (
            "/route/v1/foot/3,0;3,0;3,0?waypoints=0;1",
            "InvalidValue",
            "First and last coordinates",
        ),
        (
            "/route/v1/foot/3,0;3,0?exclude=ferry",
            "InvalidValue",
            "Exclude flag combination is not supported.",
        ),
        (
            "/route/v1/foot/3,0;9,9?radiuses=unlimited;10",
            "NoSegment",
            "Could not find a matching segment for coordinate 1",
        ),
        (
            "/route/v1/foot/3,-0.0001;3.0045,0.0045?radiuses=50;50",
            "NoRoute",
            "Impossible route between points",
        ),
        (
            &format!("/route/v1/foot/{many}"),
            "TooBig",
            "Number of entries 501 is higher than current maximum (500)",
        ),
        (
            &format!("/table/v1/foot/{many}"),
            "TooBig",
            "Too many table coordinates",
        ),
        (
            "/nearest/v1/foot/3,0?number=101",
            "TooBig",
            "Number of results 101 is higher",
        ),
        ("/nearest/v1/foot/3,0?number=0", "InvalidOptions", ""),
        (
            "/route/v1/foot/3,0;3,0?alternatives=9",
            "TooBig",
            "Requested number of alternatives is higher",
        ),
        (
            "/table/v1/foot/3,0;3,0?fallback_speed=0",
            "InvalidOptions",
            "fallback_speed must be > 0",
        ),
        ("/table/v1/foot/3,0;3,0?sources=7", "InvalidOptions", ""),
    ] {
        let (status, answer) = server.get(target);
        let (found, said) = (
            answer["code"].as_str().unwrap(),
            answer["message"].as_str().unwrap(),
        );
        assert_eq!((status, found), (400, code), "{target}: {answer}");
        assert!(said.contains(message), "{target}: {said}");
    }
}

#[test]
fn browsers_may_ask_and_others_are_refused() {
    let server = Server::start("");
    let (status, head, body) = server.send("HEAD", &format!("/route/v1/foot/{PLACES}"));
    assert!(
        status == 200 && body.is_empty() && head.contains("access-control-allow-origin: *"),
        "{head}"
    );
    assert_eq!(server.send("OPTIONS", "/route/v1/foot/3,0;3,0").0, 204);
    assert_eq!(
        server.send("DELETE", &format!("/route/v1/foot/{PLACES}")).0,
        405
    );
    // 10,000 places are more than an address may hold.
    let long = vec!["3.0001,0.0001"; 10_000].join(";");
    let mut stream = TcpStream::connect(&server.address).unwrap();
    let _ = write!(
        stream,
        "GET /route/v1/foot/{long} HTTP/1.1\r\nHost: test\r\n\r\n"
    );
    let mut answer = String::new();
    let _ = BufReader::new(stream).read_line(&mut answer);
    assert!(
        answer.is_empty() || answer.contains(" 414 ") || answer.contains(" 431 "),
        "{answer}"
    );
    assert_eq!(
        server.get(&format!("/route/v1/foot/{PLACES}")).0,
        200,
        "and the server goes on"
    );
}

#[test]
fn it_stops_when_it_is_told_to() {
    let mut server = Server::start("--threads 1");
    // A connection that is open and idle does not keep it.
    let idle = TcpStream::connect(&server.address).unwrap();
    let pid = server.process.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-TERM", &pid])
            .status()
            .unwrap()
            .success()
    );
    assert!(server.process.wait().unwrap().success());
    drop(idle);
}
