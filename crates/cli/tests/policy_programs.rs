//! `openbench run --agent program:COMMAND`: what a program's thinking costs.

mod common;

use common::{Place, Ran};
use serde_json::Value;

/// A policy without the package: it takes 70 ms for each of thirty decisions, then gives up.
const POLICY: &str = r#"
import struct, sys, time

def pack(value):
    if value is None:
        return b"\xc0"
    if isinstance(value, float):
        return b"\xcb" + struct.pack(">d", value)
    if isinstance(value, int):
        return bytes([value])
    if isinstance(value, str):
        return bytes([0xA0 + len(value)]) + value.encode()
    if isinstance(value, list):
        return bytes([0x90 + len(value)]) + b"".join(map(pack, value))
    pairs = [pack(key) + pack(item) for key, item in value.items()]
    return bytes([0x80 + len(pairs)]) + b"".join(pairs)

def say(message):
    body = pack(message)
    sys.stdout.buffer.write(len(body).to_bytes(4, "little") + body)
    sys.stdout.buffer.flush()

def hear():
    head = sys.stdin.buffer.read(4)
    return sys.stdin.buffer.read(int.from_bytes(head, "little")) if head else None

say({"hello": {"protocol": 1, "program": "slow"}})
decisions = 0
while (message := hear()) is not None:
    if b"begin" in message[:8]:
        decisions = 0
        say({"ready": {"reports": []}})
    elif b"finish" in message[:8]:
        say({"finished": {"map": None}})
    else:
        decisions += 1
        time.sleep(0.07)
        drive = {"drive": {"linear": 0.1, "angular": 0.0}}
        end = {"give_up": {"address": None, "cause": "door_not_found", "detail": "enough"}}
        say({"action": {"action": drive if decisions < 30 else end, "reports": []}})
"#;

/// One delivery in the smallest built-in world.
const SUITE: &str = "name = 'one'\n[world.builtin]\nname = 'small'\nseed = 1\n\
    [[episodes]]\ninstruction = 'Box to unit 1, building 3.'\n\
    [[episodes.deliveries]]\nbuilding = 'building3'\nunit = 'unit1'\n";

fn place() -> Place {
    let place = Place::new();
    place.file("one.toml", SUITE).file("policy.py", POLICY);
    place
}

fn run(place: &Place, more: &str) -> Ran {
    let agent = "program:python3 policy.py";
    let mut words = vec!["run", "one.toml", "--agent", agent, "--record", "none"];
    words.extend(more.split_whitespace());
    place.openbench_with(&words)
}

/// What computing cost in the only episode.
fn computing(place: &Place, out: &str) -> Value {
    let results = place.json(&format!("{out}/results.json"));
    results["episodes"][0]["computing"].clone()
}

#[test]
fn a_program_is_charged_by_the_clock_where_that_is_asked_for() {
    let place = place();
    for (out, more) in [("plain", ""), ("charged", "--condition compute=charged")] {
        let ran = run(&place, &format!("--realtime {more} --out {out}"));
        let said = &ran.succeeded().stdout;
        assert!(said.contains("by the clock of the machine"), "{said}");
        let cost = computing(&place, out);
        // Thirty times 70 ms, each of the newest observation.
        assert!(cost["by_clock_s"].as_f64().unwrap() >= 2.1, "{cost}");
        assert!(cost["latest_s"].as_f64().unwrap() >= 0.07, "{cost}");
        assert_eq!(cost["lost_observations"], 0);
        let provenance = &place.json(&format!("{out}/results.json"))["provenance"];
        let reason = provenance["cannot_repeat"].as_str().unwrap();
        assert!(reason.contains("charged by the clock"), "{reason}");
        let verified = place.openbench(&format!("verify {out}"));
        let said = &verified.succeeded().stdout;
        assert!(
            said.contains("who made the actions cannot be checked"),
            "{said}"
        );
        let again = place.openbench(&format!("verify {out} --agent"));
        again.refused_with(&["cannot be run again", "charged by the clock"]);
    }
}

#[test]
fn a_program_that_is_not_charged_says_so_and_repeats() {
    let place = place();
    let ran = run(&place, "--condition compute=charged --out charged");
    let said = &ran.succeeded().stdout;
    assert!(said.contains("computing was not charged"), "{said}");
    let cost = computing(&place, "charged");
    assert_eq!(
        (&cost["busy_s"], &cost["by_clock_s"]),
        (&0.0.into(), &Value::Null)
    );
    place.openbench("verify charged --agent").succeeded();
    run(&place, "--out free").succeeded();
    assert_eq!(computing(&place, "free"), Value::Null);
    let settings = &place.json("free/results.json")["settings"];
    assert_eq!(settings["thinking"], Value::Null);
}

#[test]
fn what_thinking_cannot_be_is_refused() {
    let place = place();
    run(&place, "--set thinking=slowly").refused_with(&["write free or charged"]);
}
