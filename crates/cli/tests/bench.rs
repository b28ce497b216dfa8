//! `openbench bench`.

mod common;

use common::Place;

#[test]
fn the_simulators_speed_is_measured_and_dumped_for_peers() {
    let place = Place::new();
    let speed = place
        .openbench("bench sim small --pedestrians 5 --cars 1 --json --dump dump")
        .succeeded()
        .json();
    for field in [
        "lidar_mrays_per_core_second",
        "real_lidar_mrays_per_core_second",
        "cast_mrays_per_core_second",
        "camera_fps_per_core",
        "camera_day_fps_per_core",
        "camera_night_fps_per_core",
        "rtf_lidar",
        "rtf_camera",
        "load_seconds",
    ] {
        assert!(
            speed[field].as_f64().is_some_and(|v| v > 0.0),
            "{field}: {speed}"
        );
    }
    assert_eq!(
        (speed["pedestrians"].as_i64(), speed["cars"].as_i64()),
        (Some(5), Some(1))
    );
    let meta = place.json("dump/meta.json");
    let floats = |name: &str| {
        (std::fs::metadata(place.path("dump").join(name))
            .unwrap()
            .len()
            / 4) as i64
    };
    let rays = meta["rays"].as_i64().unwrap();
    assert_eq!(
        floats("triangles.f32"),
        9 * speed["triangles"].as_i64().unwrap()
    );
    assert_eq!(
        [
            floats("origins.f32"),
            floats("directions.f32"),
            floats("ranges.f32")
        ],
        [3 * rays, 3 * rays, rays]
    );
}

#[test]
fn a_world_that_is_not_there_is_refused() {
    Place::new()
        .openbench("bench sim nowhere")
        .refused_with(&["nowhere", "small, medium, large"]);
    Place::new()
        .openbench("bench sim --world a.world")
        .refused_with(&["--map"]);
}

#[test]
fn local_planners_are_compared_in_scenes_from_a_seed() {
    let place = Place::new();
    let all = place
        .openbench("bench motion --scenes 10 --seed 3 --json --pictures scenes")
        .succeeded()
        .json();
    for planner in ["teb", "follower", "mppi"] {
        let row = &all["planners"][planner];
        assert!(
            row["feasible"].as_i64().is_some_and(|n| n >= 5),
            "{planner}: {row}"
        );
        for field in ["reached", "collisions", "cycle_ms_p50", "cycle_ms_p99"] {
            assert!(
                row[field].as_f64().is_some_and(|v| v >= 0.0),
                "{planner}, {field}: {row}"
            );
        }
        let ratio = row["time_ratio_mean"].as_f64();
        assert_eq!(ratio.is_some(), row["reached"] != 0, "{planner}: {row}");
        assert!(ratio.is_none_or(|ratio| ratio >= 1.0), "{planner}: {row}");
    }
    let teb = &all["planners"]["teb"];
    assert_eq!(
        (&teb["reached"], teb["collisions"].as_i64()),
        (&teb["feasible"], Some(0)),
        "{all}"
    );
    assert_eq!(teb["refused"], teb["infeasible"], "{all}");
    assert!(place.read("scenes/00002_teb.svg").contains("</svg>"));
    // The same again on two threads: all but times of decisions.
    let again = place
        .openbench("bench motion --scenes 10 --seed 3 --json --planner teb --jobs 2")
        .succeeded()
        .json();
    for field in ["feasible", "reached", "swerves_mean"] {
        assert_eq!(again["planners"]["teb"][field], teb[field], "{field}");
    }
}

#[test]
fn planners_and_numbers_of_scenes_that_make_no_sense_are_refused() {
    Place::new()
        .openbench("bench motion --planner dwa")
        .refused_with(&["dwa", "teb, follower, mppi"]);
    Place::new()
        .openbench("bench people small --planner dwa")
        .refused_with(&["dwa", "teb, follower, mppi"]);
    Place::new()
        .openbench("bench health small --localizer stars")
        .refused_with(&["stars", "fused, lidar-inertial, dead-reckoning"]);
    Place::new()
        .openbench("bench localization small --level awful")
        .refused_with(&["--level", "awful", "exact, good, city, poor"]);
    Place::new()
        .openbench("bench localization small --start moon")
        .refused_with(&["--start", "moon", "block, map"]);
    Place::new()
        .openbench("bench localization small --start off --beside atlantis")
        .refused_with(&["--beside", "atlantis"]);
    Place::new()
        .openbench("bench localization small --drive 10")
        .refused_with(&["--drive", "60 to 20000"]);
    Place::new()
        .openbench("bench localization small --odometry-drift 2")
        .refused_with(&["--odometry-drift", "0 to 0.5"]);
    for share in ["1", "NaN", "half"] {
        Place::new()
            .openbench(&format!("bench localization small --missing {share}"))
            .refused_with(&["--missing", "0 to 0.9"]);
    }
    Place::new()
        .openbench("bench motion --scenes 0")
        .refused_with(&["0"]);
}

#[test]
fn metres_among_people_are_driven_alike_on_any_number_of_threads() {
    let place = Place::new();
    let drive = |jobs: u32| {
        let line = format!(
            "bench people small --pedestrians 0,15 --km 0.02 --seed 2 --json --jobs {jobs}"
        );
        place.openbench(&line).succeeded().json()
    };
    let rows = drive(1);
    assert_eq!(rows, drive(2));
    for (row, people) in rows.as_array().into_iter().flatten().zip([0, 15]) {
        assert_eq!(row["traffic"]["pedestrians"], people);
        let metres = row["metres"].as_f64().unwrap_or_default();
        assert!(
            (20.0..21.0).contains(&metres) && row["seconds"].as_f64() > Some(40.0),
            "{row}"
        );
        let collisions = row["collisions"]
            .as_object()
            .into_iter()
            .flat_map(|c| c.values());
        assert!(
            collisions
                .clone()
                .all(|c| c["driven_into"] == 0 && c["cut_off"] == 0),
            "{row}"
        );
    }
    assert_eq!(rows.as_array().map(Vec::len), Some(2));
    place
        .openbench("bench people small --km 0")
        .refused_with(&["kilometres", "0.001"]);
    place
        .openbench("bench people nowhere")
        .refused_with(&["nowhere"]);
}

fn keys(value: &serde_json::Value) -> Vec<String> {
    let object = value.as_object().into_iter().flatten();
    object.map(|(key, _)| key.clone()).collect()
}

fn has_the_fields_of_a_report(report: &serde_json::Value) {
    assert_eq!(keys(&report["recall"]), ["0m", "20m", "40m", "60m"]);
    assert_eq!(keys(&report["recall"]["60m"]), ["0.5", "1", "3", "5"]);
    assert_eq!(keys(&report["yaw"]), ["1", "2", "5"]);
    assert_eq!(keys(&report["wall_relative"]), ["0.3", "0.5"]);
    for field in ["accepted", "find_ms_p50", "find_ms_p99"] {
        assert!(report[field].as_f64().is_some(), "{field}");
    }
}

/// On the drives that a place keeps.
fn beside_the_map_it_is_rejected_and_anywhere_it_is_tried(place: &Place) {
    let beside = place
        .openbench(
            "bench localization small --start off --beside small-7 --poses 1 --json \
             --drives kept --peers",
        )
        .succeeded()
        .json();
    assert_eq!(beside["rejected_off_map"], 1.0);
    assert_eq!(keys(&beside["peers"]), ["icp", "odometry", "particles"]);
    assert_eq!(
        beside["peers"]["particles"]["rejected_off_map"],
        serde_json::Value::Null
    );
    let anywhere = place
        .openbench("bench localization small --start map --poses 1 --json --drives kept")
        .succeeded()
        .json();
    assert_eq!(
        (&anywhere["n"], &anywhere["start"]),
        (&1.into(), &"map".into())
    );
}

#[test]
fn a_robot_finds_itself_alike_on_any_number_of_threads_and_on_kept_drives() {
    let place = Place::new();
    let command = "bench localization small --start block --poses 1 --json";
    let first = place
        .openbench(&format!("{command} --drives kept"))
        .succeeded()
        .json();
    assert_eq!((&first["n"], &first["level"]), (&1.into(), &"good".into()));
    assert_eq!(first["worlds"]["small"]["recall"], first["recall"]);
    has_the_fields_of_a_report(&first);
    assert_eq!(first["wrong_5m"], 0);
    assert_eq!(first["rejected_off_map"], serde_json::Value::Null);
    for options in ["--drives kept", "--jobs 2"] {
        let again = place
            .openbench(&format!("{command} {options}"))
            .succeeded()
            .json();
        for field in ["recall", "fixes", "nees_mean", "wall_relative"] {
            assert_eq!(again[field], first[field], "{field} {options}");
        }
    }
    beside_the_map_it_is_rejected_and_anywhere_it_is_tried(&place);
    let truth = place
        .openbench(&format!(
            "{command} --drives kept --labels truth --without free-space --odometry-drift 0.01"
        ))
        .succeeded()
        .json();
    assert_eq!(
        (
            &truth["labels"],
            &truth["without"],
            &truth["odometry_drift"]
        ),
        (&"truth".into(), &"free-space".into(), &0.01.into())
    );
    assert!(truth["along"]["located"].as_f64().is_some());
    let table = place.openbench(
        "bench localization small --start block --poses 1 --drives kept --labels truth \
         --without free-space --odometry-drift 0.01 --missing 0.3",
    );
    let header = "map good, 30 % of the buildings missing, start block, true labels, \
                  without free space, 1 % of drift added\n";
    assert!(
        table.succeeded().stdout.starts_with(header),
        "{}",
        table.stdout
    );
    assert!(place.read("kept/small-truth-seed-1.json").starts_with("[{"));
    place
        .openbench(
            "bench localization small --poses 1 --drives kept --missing 0.3 --examples all.jsonl",
        )
        .succeeded();
    let examples = place.read("all.jsonl");
    assert!(
        examples.starts_with("[\"small\",\"good, 30 % of the buildings missing\",\"10m\",{"),
        "{examples:.80}"
    );
    place.file("kept/small-seed-1.json", "no drives");
    place
        .openbench("bench localization small --poses 1 --drives kept")
        .refused_with(&["kept/small-seed-1.json", "delete it"]);
}
