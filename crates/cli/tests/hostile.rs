//! Inputs that once ended badly: files lost, runs without an end, secrets and megabytes on the
//! screen. Hundreds of others are in `benchmarks/hostile`.

mod common;

use common::Place;
use common::endpoint::babbler;
use common::town::{HERE, deliver, map, town};

const DELIVER: &str = "--deliveries one.txt --targets planner";

#[test]
fn a_world_never_replaces_the_map_it_is_made_from() {
    let place = town();
    std::fs::create_dir(place.path("mine")).unwrap();
    place.file("mine/map.osm", map());
    place
        .openbench("world generate --map mine/map.osm --out mine")
        .refused_with(&["mine/map.osm", "--out"]);
    assert_eq!(place.read("mine/map.osm"), map());
    place
        .openbench("world import --world town.world --map mine/map.osm --out mine")
        .refused_with(&["mine/map.osm", "--out"]);
    assert_eq!(place.read("mine/map.osm"), map());
}

#[test]
fn a_suite_cannot_ask_for_a_billion_people() {
    let place = Place::new();
    let suite = "name = 'a'\n[world.builtin]\nname = 'small'\nseed = 1\n\
                 [[episodes]]\ninstruction = 'x'\ndeliveries = []\n[traffic]\n";
    for kind in ["pedestrians", "cars"] {
        place
            .file("suite.toml", format!("{suite}{kind} = 1000000000\n"))
            .openbench("run suite.toml")
            .refused_with(&["suite.toml", "[traffic]", "10000"]);
    }
    place
        .file("suite.toml", suite.replace("[traffic]", "[trafic]"))
        .openbench("run suite.toml")
        .refused_with(&["suite.toml", "trafic"]);
}

#[test]
fn an_endpoint_without_a_scheme_is_not_taken_for_a_model() {
    let place = town();
    for setting in ["planner", "reader"] {
        let words = format!("{DELIVER} --set {setting}=openai:x@127.0.0.1:5091");
        deliver(&place, &words).refused_with(&["x@127.0.0.1:5091", "http://"]);
    }
}

#[test]
fn a_password_in_an_address_is_not_shown() {
    let place = town();
    let endpoint = "openai:m@http://user:hunter2@127.0.0.1:9/v1";
    let runs = [
        format!("{HERE} {DELIVER} --set planner={endpoint}"),
        format!("{HERE} {DELIVER} --set reader={endpoint}"),
        format!("{HERE} {DELIVER} --set budget={endpoint}"),
        format!("plan --map town.osm --planner {endpoint} hello"),
        format!("run --{endpoint}"),
    ];
    for words in runs {
        let ran = place.openbench(&words);
        assert_eq!(ran.code, 2, "{words}: {}", ran.stderr);
        let said = ran.stdout + &ran.stderr;
        assert!(!said.contains("hunter2"), "{words}: {said}");
    }
    assert!(!place.path("runs/latest/unfinished").exists());
}

#[test]
fn fixes_of_a_receiver_need_one() {
    deliver(&town(), &format!("{DELIVER} --set fixes=gnss")).refused_with(&[
        "fixes=gnss",
        "receiver",
        "[sensors]",
    ]);
}

#[test]
fn a_command_does_not_overwrite_what_it_reads() {
    let place = town();
    place
        .openbench("prepare --map town.osm --out town.osm")
        .refused_with(&["town.osm", "overwrite"]);
    place
        .openbench("prepare --map town.osm --out ./town.osm")
        .refused_with(&["town.osm", "overwrite"]);
    assert_eq!(place.read("town.osm"), map());
    place.file("log.mcap", "a log");
    place
        .openbench("odometry log.mcap --out log.mcap")
        .refused_with(&["log.mcap", "overwrite"]);
    place
        .openbench("odometry log.mcap --out a.txt --truth a.txt")
        .refused_with(&["a.txt", "overwrite"]);
    assert_eq!(place.read("log.mcap"), "a log");
}

#[test]
fn a_log_without_an_imu_gives_no_empty_trajectory() {
    let place = town();
    // A thin log has scans, but no IMU.
    deliver(
        &place,
        &format!("{DELIVER} --out run --set reader={}", babbler()),
    )
    .succeeded();
    place
        .openbench("odometry run/episodes/000.mcap --out path.txt")
        .refused_with(&["000.mcap", "0 IMU samples", "--robot"]);
    assert!(!place.path("path.txt").exists());
}

#[test]
fn errors_of_logs_name_the_file() {
    let place = Place::new();
    for content in ["", "no log at all", "\u{89}MCAP0\r\nand then nothing"] {
        place
            .file("broken.mcap", content)
            .openbench("odometry broken.mcap --out path.txt")
            .refused_with(&["broken.mcap"]);
    }
}

#[test]
fn megabytes_are_not_echoed() {
    let place = town();
    let long = "9".repeat(3_000_000);
    place.file("truth.txt", format!("({long}, x)\n"));
    place.file("suite.toml", format!("name = {long}"));
    place.file("long.txt", &long);
    let runs = [
        format!("{HERE} --deliveries one.txt --truth truth.txt"),
        "run suite.toml".to_owned(),
        format!("{HERE} --deliveries long.txt --targets planner"),
        format!("{HERE} {DELIVER} --georef {}", &long[..100_000]),
        format!("{HERE} {DELIVER} --set {}=1", &long[..100_000]),
        format!("run {}", &long[..100_000]),
    ];
    for words in runs {
        let ran = place.openbench(&words);
        let begin = words.chars().take(60).collect::<String>();
        assert_eq!(ran.code, 2, "{begin}");
        assert!(ran.stderr.len() < 20_000, "{begin}: {}", ran.stderr.len());
    }
}

#[test]
#[cfg(unix)]
fn devices_and_pipes_are_refused_at_once() {
    let place = town();
    let made = std::process::Command::new("mkfifo")
        .arg(place.path("pipe"))
        .status();
    assert!(made.unwrap().success());
    for file in ["/dev/zero", "pipe"] {
        for words in [
            format!("route --map {file} 3,0 3.0001,0"),
            format!("prepare --map {file} --out graph"),
            format!("plan --map {file} hello"),
            format!("world generate --map {file} --out w"),
            format!("run --world {file} --map town.osm {DELIVER}"),
            format!("run --world town.world --map {file} {DELIVER}"),
            format!("{HERE} --deliveries {file} --targets planner"),
            format!("{HERE} --deliveries one.txt --truth {file}"),
            format!("{HERE} {DELIVER} --memory {file}"),
            format!("{HERE} {DELIVER} --set reader=replay:{file}"),
            format!("route --map town.osm --profile {file} 3,0 3.0001,0"),
            format!("odometry {file} --out path.txt"),
            format!("evaluate --log {file} --truth one.txt"),
        ] {
            let ran = place.openbench(&words);
            assert_eq!(ran.code, 2, "{words}: {}", ran.stderr);
            assert!(ran.stderr.contains(file), "{words}: {}", ran.stderr);
        }
    }
}

#[test]
fn a_view_from_outside_of_the_world_is_refused() {
    Place::new()
        .openbench("world show small --from 5000,5000,0 --out view.png")
        .refused_with(&["5000,5000", "there is nothing"]);
}
