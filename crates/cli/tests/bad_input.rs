//! Bad input ends with exit code 2 and a message that says what, where and what to do; never with a
//! panic.

mod common;

use common::endpoint::babbler;
use common::town::{HERE, NOBODY, deliver, map, prison, town, world};
use common::{Place, Ran};

/// Delivers in the town after `spoil` was written over one of its files.
fn spoilt(file: &str, content: impl AsRef<[u8]>) -> Ran {
    let place = town();
    place.file(file, content);
    deliver(&place, "--deliveries one.txt --targets planner")
}

#[test]
fn a_truncated_world_is_refused_with_its_line() {
    let whole = world("");
    spoilt("town.world", &whole[..whole.len() / 2]).refused_with(&["town.world:", "openbench: "]);
}

#[test]
fn a_world_cut_anywhere_is_refused() {
    let whole = world("");
    for tenth in 0..10 {
        spoilt("town.world", &whole[..whole.len() * tenth / 10]).refused_with(&["town.world"]);
    }
}

#[test]
fn a_world_that_is_no_text_is_refused() {
    spoilt("town.world", [0xff, 0xfe, 0, 1, 2]).refused_with(&["town.world"]);
}

#[test]
fn a_world_without_doors_says_what_marks_a_door() {
    let bare = "<sdf version='1.7'><world name='bare'></world></sdf>";
    spoilt("town.world", bare).refused_with(&["town.world", "no doors", "text_model1"]);
}

#[test]
fn a_world_without_anything_solid_says_what_to_add() {
    let plates = world("")
        .replace("<collision", "<other")
        .replace("</collision", "</other");
    spoilt("town.world", plates).refused_with(&["solid", "ground plane"]);
}

#[test]
fn a_missing_mesh_names_the_model_the_mesh_and_the_option() {
    let cow = "<model name='cow_1'><link name='l'><visual name='v'><geometry>\
        <mesh><uri>model://cow/cow.dae</uri></mesh></geometry></visual></link></model>";
    spoilt("town.world", world(cow)).refused_with(&["cow_1", "model://cow/cow.dae", "--models"]);
}

#[test]
fn a_map_without_buildings_is_refused() {
    let bare = "<osm version='0.6'><node id='1' lat='0' lon='3'/></osm>";
    spoilt("town.osm", bare).refused_with(&["town.osm", "no buildings", "building=*"]);
}

#[test]
fn a_broken_map_is_refused_with_its_line() {
    let whole = map();
    spoilt("town.osm", &whole[..whole.len() / 2]).refused_with(&["town.osm:"]);
}

#[test]
fn what_is_left_out_of_a_map_is_said() {
    let place = town();
    place.file(
        "town.osm",
        map().replace("<node id='5' lat='", "<node id='5' lat='north"),
    );
    let ran = deliver(
        &place,
        &format!(
            "--deliveries one.txt --targets planner --set reader={}",
            babbler()
        ),
    );
    assert!(
        ran.succeeded().stderr.contains("town.osm: 1 element"),
        "{}",
        ran.stderr
    );
}

#[test]
fn an_empty_file_of_deliveries_is_refused() {
    spoilt("one.txt", "\n \n").refused_with(&["one.txt", "one instruction per line"]);
}

#[test]
fn instructions_without_a_truth_are_refused_unless_a_planner_is_asked_for() {
    let ran = deliver(&town(), "--deliveries one.txt");
    ran.refused_with(&["one.txt", "--truth", "JSONL", "--targets planner"]);
    let place = town();
    place.file("truth.txt", "(8.2, 0.0)\n");
    deliver(
        &place,
        "--deliveries one.txt --truth truth.txt --targets planner",
    )
    .refused_with(&["--targets", "--truth"]);
    place.file(
        "one.jsonl",
        "{\"instruction\": \"Hello\", \"deliveries\": []}\n",
    );
    deliver(&place, "--deliveries one.jsonl").refused_with(&["one.jsonl", "line 1", "no door"]);
}

#[test]
fn an_instruction_that_names_no_door_needs_a_truth() {
    spoilt("one.txt", "The weather is fine today.\n").refused_with(&["one.txt", "--truth"]);
}

#[test]
fn a_door_that_the_world_lacks_is_named_with_those_it_has() {
    let place = town();
    place.file("one.txt", "Bring this to unit7, building1.");
    let ran = deliver(
        &place,
        &format!(
            "--deliveries one.txt --targets planner --set reader={}",
            babbler()
        ),
    );
    let said = &ran.succeeded().stderr;
    assert!(
        said.contains("unit7") && said.contains("unit1, building1"),
        "{said}"
    );
}

/// Delivers to `unit1, building1` with these true positions.
fn with_truth(truth: &str) -> Ran {
    let place = town();
    place.file("truth.txt", truth);
    deliver(&place, "--deliveries one.txt --truth truth.txt")
}

#[test]
fn a_truth_with_too_many_lines_is_refused() {
    with_truth("(8.2, 0.0)\n(0.0, 12.2)\n").refused_with(&["truth.txt", "2 lines", "1 line"]);
}

#[test]
fn a_truth_with_other_doors_than_the_annotation_is_refused() {
    let place = town();
    let door = r#"{"building": "building1", "unit": "unit1"}"#;
    let line = format!(r#"{{"instruction": "x", "deliveries": [{door}]}}"#);
    place
        .file("one.jsonl", line)
        .file("truth.txt", "(8.2, 0.0) (0.0, 12.2)\n");
    deliver(&place, "--deliveries one.jsonl --truth truth.txt").refused_with(&[
        "truth.txt",
        "line 1",
        "2 true positions",
        "unit1, building1",
    ]);
}

#[test]
fn a_truth_that_is_no_door_is_refused_with_the_nearest() {
    with_truth("(8.2, 3.0)\n").refused_with(&[
        "truth.txt:1",
        "no door",
        "unit1, building1",
        "3.00 m",
    ]);
}

#[test]
fn a_truth_that_is_no_position_is_refused_with_its_line() {
    with_truth("(8.2, zero)\n").refused_with(&["truth.txt", "1"]);
}

#[test]
fn unknown_names_are_answered_with_the_known_ones() {
    let place = town();
    place
        .openbench("run atlantis")
        .refused_with(&["atlantis", "small, medium, large"]);
    deliver(
        &place,
        "--deliveries one.txt --targets planner --agent bond",
    )
    .refused_with(&["bond", "open"]);
    deliver(
        &place,
        "--deliveries one.txt --targets planner --set colour=red",
    )
    .refused_with(&["colour", "planner, reader, localizer, fixes"]);
    place
        .openbench("route --map town.osm --profile sledge 3,0 3.0001,0")
        .refused_with(&["sledge", "delivery"]);
}

#[test]
fn values_of_settings_that_mean_nothing_are_refused() {
    let place = town();
    for setting in [
        "planner=oracle",
        "reader=eyes",
        "localizer=stars",
        "fixes=stars",
        "fixes=disturbed-truth:1,7,9",
        "motion=nothing",
    ] {
        // The last `reader` counts, so that no model file is asked for.
        let words =
            format!("--deliveries one.txt --targets planner --set reader={NOBODY} --set {setting}");
        deliver(&place, &words).refused_with(&[setting]);
        // No folder of results, and above all no log that was begun.
        assert!(!place.path("runs").exists(), "{setting}");
    }
}

#[test]
fn files_that_are_not_there_are_named() {
    let place = town();
    let here = |world: &str, map: &str, more: &str| {
        place.openbench(&format!(
            "run --world {world} --map {map} --georef tangent:3,0 {more}"
        ))
    };
    here(
        "no.world",
        "town.osm",
        "--deliveries one.txt --targets planner",
    )
    .refused_with(&["no.world", "No such file"]);
    here(
        "town.world",
        "no.osm",
        "--deliveries one.txt --targets planner",
    )
    .refused_with(&["no.osm", "No such file"]);
    here("town.world", "town.osm", "--deliveries no.txt").refused_with(&["no.txt", "No such file"]);
    here(
        "town.world",
        "town.osm",
        "--deliveries one.txt --truth no_gt.txt",
    )
    .refused_with(&["no_gt.txt", "No such file"]);
    place
        .openbench("run no.toml")
        .refused_with(&["no.toml", "No such file"]);
    place
        .openbench("verify no_run")
        .refused_with(&["no_run", "No such file"]);
    place
        .openbench("evaluate --log no.csv --truth one.txt")
        .refused_with(&["no.csv", "No such file"]);
    place
        .openbench_with(&["plan", "--map", "no.osm", "To unit1, building1"])
        .refused_with(&["no.osm", "No such file"]);
}

#[test]
fn folders_in_place_of_files_are_named() {
    let place = town();
    std::fs::create_dir(place.path("folder.osm")).unwrap();
    place
        .openbench("route --map folder.osm 3,0 3.0001,0")
        .refused_with(&["folder.osm"]);
    place
        .openbench("evaluate --log folder.osm --truth one.txt")
        .refused_with(&["folder.osm"]);
}

#[test]
fn a_georeference_that_is_none_is_quoted() {
    let place = town();
    for georef in [
        "utm:61N,0,0",
        "utm:50N,0",
        "mars",
        "tangent:3,91",
        "utm:N,0,0",
        "utm:é,0,0",
    ] {
        let words = format!(
            "run --world town.world --map town.osm --deliveries one.txt --targets planner \
             --georef {georef}"
        );
        place.openbench(&words).refused_with(&[georef, "utm:"]);
    }
}

#[test]
fn bad_usage_is_refused() {
    let place = town();
    for (more, part) in [
        ("--deliveries one.txt --targets planner --jobs 0", "--jobs"),
        (
            "--deliveries one.txt --targets planner --jobs 1000",
            "--jobs",
        ),
        (
            "--deliveries one.txt --targets planner --seed minus",
            "--seed",
        ),
        (
            "--deliveries one.txt --targets planner --record everything",
            "none, thin or full",
        ),
        (
            "--deliveries one.txt --targets planner --set planner",
            "KEY=VALUE",
        ),
        ("", "--deliveries"),
        ("small", "--world"),
    ] {
        place
            .openbench(&format!("{HERE} {more}"))
            .refused_with(&[part]);
    }
    place.openbench("").refused_with(&["Usage"]);
    place
        .openbench("route --map town.osm 3,0")
        .refused_with(&["LON,LAT"]);
    place
        .openbench("route --map town.osm 3,0 3,95")
        .refused_with(&["3,95", "LON,LAT"]);
}

#[test]
fn a_suite_file_that_is_none_is_refused_with_its_line() {
    let place = Place::new();
    place
        .file("bad.toml", "name = \"bad\"\nepisodes = 3\n")
        .openbench("run bad.toml")
        .refused_with(&["bad.toml", "line 2"]);
    place
        .file("cut.toml", "name = \"b")
        .openbench("run cut.toml")
        .refused_with(&["cut.toml", "line 1"]);
}

#[test]
fn an_out_folder_that_is_a_file_is_named() {
    let place = town();
    let words =
        format!("--deliveries one.txt --targets planner --out one.txt --set reader={NOBODY}");
    deliver(&place, &words).refused_with(&["one.txt"]);
}

#[test]
fn nothing_that_a_run_reads_is_removed_by_it() {
    let place = town();
    let deliveries = place.read("one.txt");
    std::fs::create_dir_all(place.path("q/episodes")).unwrap();
    std::fs::create_dir_all(place.path("mine/unfinished")).unwrap();
    for (file, out) in [
        ("q/episodes/000.models.jsonl", "q"),
        ("mine/unfinished/deliveries.txt", "mine"),
    ] {
        place.file(file, &deliveries);
        let words = format!("--deliveries {file} --targets planner --out {out}");
        let words = format!("{words} --set reader={NOBODY}");
        deliver(&place, &words).refused_with(&[file]);
        assert_eq!(place.read(file), deliveries);
    }
    // Nor what lies beside it.
    let words = format!("--deliveries one.txt --targets planner --out mine --set reader={NOBODY}");
    deliver(&place, &words).refused_with(&["deliveries.txt", "no run has written it"]);
    let map = place.read("town.osm");
    for words in ["plan --map town.osm x", "srtp --data town.osm"] {
        place
            .openbench(&format!("{words} --planner {NOBODY} --exchanges town.osm"))
            .refused_with(&["town.osm would overwrite town.osm"]);
    }
    assert_eq!(place.read("town.osm"), map);
    place
        .file("g.g2o", "VERTEX_SE2 0 0 0 0\n")
        .file("town.yaml", &map)
        .file("pairs.csv", "3,0,3.0001,0\n");
    for (words, file) in [
        ("bench posegraph g.g2o --out g.g2o", "g.g2o"),
        ("costmap --map town.yaml --out town.yaml", "town.yaml"),
        (
            "bench routing --map town.osm --pairs pairs.csv --answers pairs.csv",
            "pairs.csv",
        ),
    ] {
        let before = place.read(file);
        place.openbench(words).refused_with(&["would overwrite"]);
        assert_eq!(place.read(file), before);
    }
}

#[test]
fn a_memory_that_is_no_map_is_refused() {
    let place = town();
    place
        .file("memory.osm", "<osm")
        .file("walled.world", world(&prison()));
    let words =
        format!("--deliveries one.txt --targets planner --memory memory.osm --set reader={NOBODY}");
    deliver(&place, &words).refused_with(&["memory.osm"]);
}

#[test]
fn a_memory_that_cannot_be_written_is_refused_before_anything_is_driven() {
    let place = town();
    let words = format!(
        "--deliveries one.txt --targets planner --memory nowhere/memory.osm --set reader={NOBODY}"
    );
    deliver(&place, &words).refused_with(&["nowhere/memory.osm"]);
    assert!(!place.path("runs").exists());
}
