//! `openbench record` and `openbench odometry`.

mod common;

use common::Place;

/// Half a minute in a built-in world.
fn recorded() -> Place {
    let place = Place::new();
    place
        .openbench("record small --minutes 0.5 --seed 4 --out log.mcap")
        .succeeded();
    place
}

#[test]
fn a_recorded_drive_is_found_again_and_told_as_well_as_it_is_known() {
    let place = recorded();
    let said = place
        .openbench("odometry log.mcap --out way.tum --truth truth.tum --json")
        .succeeded()
        .json();
    assert!(
        said["scans"].as_u64().is_some_and(|n| n > 280) && said["coasting"] == 0,
        "{said}"
    );
    assert_eq!(said["disputed"], 0, "{said}");
    let nees = said["nees"]["end"].as_f64().unwrap();
    assert!(nees > 0.0 && nees < 60.0, "{said}");
    let last = |name: &str| -> Vec<f64> {
        let text = place.read(name);
        text.lines()
            .last()
            .unwrap()
            .split(' ')
            .map(|word| word.parse().unwrap())
            .collect()
    };
    let first: Vec<f64> = place
        .read("truth.tum")
        .lines()
        .next()
        .unwrap()
        .split(' ')
        .map(|word| word.parse().unwrap())
        .collect();
    let (way, truth) = (last("way.tum"), last("truth.tum"));
    let driven = |a: &[f64], b: &[f64]| ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt();
    assert!(
        (driven(&truth, &first) - driven(&way, &[0.0; 8])).abs() < 0.05,
        "{way:?} {truth:?}"
    );

    // A folder of a bag that was split is the same as the whole.
    std::fs::create_dir(place.path("bag")).unwrap();
    std::fs::copy(place.path("log.mcap"), place.path("bag/bag_0.mcap")).unwrap();
    place.openbench("odometry bag --out again.tum").succeeded();
    assert_eq!(place.read("again.tum"), place.read("way.tum"));

    // Sensors that sit elsewhere give another way; a topic that is not there gives none.
    place.file(
        "robot.toml",
        "imu = { xyz = [0.0, 0.0, 0.2] }\nlidar = { xyz = [0.0, 0.0, 0.25] }",
    );
    place
        .openbench("odometry log.mcap --robot robot.toml --out other.tum")
        .succeeded();
    assert_ne!(place.read("other.tum"), place.read("way.tum"));
    // A LiDAR that is turned by more than it is said to be is noticed.
    place.file(
        "robot.toml",
        "lidar = { xyz = [0.12, 0.0, 0.235], rpy = [0.0, 0.2, 0.0] }",
    );
    place
        .openbench("record small --minutes 0.5 --out turns.mcap")
        .succeeded();
    let turned = place.openbench("odometry turns.mcap --robot robot.toml --out turned.tum");
    assert!(
        turned.succeeded().stderr.contains("do not trust"),
        "{}",
        turned.stderr
    );
    place.file("robot.toml", "lidar_topic = \"/os_cloud_node/points\"");
    let said = place
        .openbench("odometry log.mcap --robot robot.toml --out none.tum --json")
        .succeeded()
        .json();
    assert!(
        said["coasting"].as_u64() == said["scans"].as_u64(),
        "{said}"
    );

    // A log that was cut off is used as far as it goes.
    let bytes = std::fs::read(place.path("log.mcap")).unwrap();
    place.file("cut.mcap", &bytes[..bytes.len() / 2]);
    place
        .openbench("odometry cut.mcap --out cut.tum")
        .succeeded()
        .stderr
        .contains("cut.mcap")
        .then_some(())
        .unwrap();
    let lines = place.read("cut.tum").lines().count();
    assert!((100..200).contains(&lines), "{lines}");
}

#[test]
fn what_is_no_log_and_no_robot_is_refused() {
    let place = Place::new();
    place
        .file("note.txt", "not a log")
        .file("robot.toml", "lidar = 3");
    place
        .openbench("odometry note.txt --out way.tum")
        .refused_with(&["MCAP"]);
    std::fs::create_dir(place.path("empty")).unwrap();
    place
        .openbench("odometry empty --out way.tum")
        .refused_with(&["empty", "no .mcap"]);
    place
        .openbench("odometry note.txt --robot robot.toml --out way.tum")
        .refused_with(&["robot.toml", "lidar"]);
    place
        .openbench("odometry none.mcap --out way.tum")
        .refused_with(&["none.mcap"]);
    assert!(!place.path("way.tum").exists());
}
