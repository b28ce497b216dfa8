//! `openbench route`: answers as OSRM gives them; exit code 1 where there is no way.

mod common;

use common::Ran;
use common::town::town;
use serde_json::{Value, json};

fn route(words: &str) -> Ran {
    town().openbench(&format!("route --map town.osm {words}"))
}

/// Code, number of points and metres of a route over a published map.
fn over(map: &str, words: &str) -> Option<Value> {
    let map = common::shared_data(map)?;
    let ran = town().openbench(&format!("route --map {} {words}", map.display()));
    Some(ran.succeeded().json())
}

#[test]
fn a_route_follows_the_street_round_its_corner() {
    let answer = route("3.0,-0.0001 3.0002,0.00001").succeeded().json();
    let leg =
        json!({ "distance": 33.3, "duration": 66.7, "weight": 73.3, "summary": "", "steps": [] });
    let line = json!({ "type": "LineString", "coordinates": [[3, -0.0001], [3, 0], [3.0002, 0]] });
    let expected = json!({
        "code": "Ok",
        "routes": [{
            "distance": 33.3, "duration": 66.7, "weight": 73.3, "weight_name": "duration",
            "geometry": line, "legs": [leg]
        }],
        "waypoints": [
            { "name": "Long Lane", "location": [3, -0.0001], "distance": 0 },
            { "name": "Long Lane", "location": [3.0002, 0],
            "distance": answer["waypoints"][1]["distance"] }
        ]
    });
    assert_eq!(answer, expected);
    let away = answer["waypoints"][1]["distance"].as_f64().unwrap();
    assert!((away - 1.1).abs() < 0.01, "{away}");
}

#[test]
fn steps_say_where_to_turn() {
    let answer = route("--steps 3.0,-0.0001 3.0002,0.00001")
        .succeeded()
        .json();
    let steps = answer["routes"][0]["legs"][0]["steps"]
        .as_array()
        .unwrap()
        .clone();
    let kinds: Vec<&str> = steps
        .iter()
        .map(|step| step["maneuver"]["type"].as_str().unwrap())
        .collect();
    assert!(
        kinds.starts_with(&["depart"]) && kinds.ends_with(&["arrive"]),
        "{kinds:?}"
    );
    let total: f64 = steps
        .iter()
        .map(|step| step["distance"].as_f64().unwrap())
        .sum();
    assert!((total - 33.3).abs() < 0.2, "{total}");
}

#[test]
fn each_two_places_have_a_leg_between_them() {
    let answer = route("3.0,-0.0001 3.0002,0 3.0,0").succeeded().json();
    assert_eq!(answer["routes"][0]["legs"].as_array().unwrap().len(), 2);
    assert_eq!(answer["waypoints"].as_array().unwrap().len(), 3);
}

#[test]
fn a_place_is_no_distance_from_itself() {
    let answer = route("3.0,0 3.0,0").succeeded().json();
    assert_eq!(answer["routes"][0]["distance"], 0);
}

#[test]
fn profiles_have_their_own_speed() {
    let duration = |profile: &str| {
        let answer = route(&format!("--profile {profile} 3.0,-0.0001 3.0002,0"))
            .succeeded()
            .json();
        answer["routes"][0]["duration"].as_f64().unwrap()
    };
    assert!(duration("car") < duration("foot") && duration("foot") < duration("delivery"));
}

#[test]
fn streets_that_do_not_hang_together_have_no_route() {
    let ran = route("3.0,-0.0001 3.0045,0.0045");
    assert_eq!((ran.code, &ran.json()["code"]), (1, &"NoRoute".into()));
}

#[test]
fn a_profile_of_ones_own_is_read_and_its_faults_are_named() {
    let place = town();
    let foot = openbench_profile("foot");
    place.file("slow.toml", foot.replace("= 5\n", "= 2.5\n"));
    let duration = |profile: &str| {
        let ran = place.openbench(&format!(
            "route --map town.osm --profile {profile} 3.0,-0.0001 3.0002,0"
        ));
        ran.succeeded().json()["routes"][0]["duration"]
            .as_f64()
            .unwrap()
    };
    assert!((duration("slow.toml") - 2.0 * duration("foot")).abs() < 0.3);
    place.file("wrong.toml", foot.replace("[ways.limit]", "[ways.limits]"));
    let ran = place.openbench("route --map town.osm --profile wrong.toml 3,0 3.0002,0");
    assert_eq!(ran.code, 2);
    assert!(
        ran.stderr.contains("wrong.toml") && ran.stderr.contains("limits"),
        "{}",
        ran.stderr
    );
    let ran = place.openbench("route --map town.osm --profile hovercraft 3,0 3.0002,0");
    assert!(
        ran.code == 2 && ran.stderr.contains("delivery, foot, car"),
        "{}",
        ran.stderr
    );
}

/// The text of a built-in profile.
fn openbench_profile(name: &str) -> String {
    let path = format!(
        "{}/../routing/profiles/{name}.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn a_prepared_map_gives_the_same_answers() {
    let place = town();
    let said = place
        .openbench("prepare --map town.osm --out town.graph")
        .succeeded()
        .stdout
        .clone();
    assert!(said.contains("vertices"), "{said}");
    let from = |map: &str| {
        place
            .openbench(&format!("route --map {map} 3.0,-0.0001 3.0002,0"))
            .succeeded()
            .stdout
            .clone()
    };
    assert_eq!(from("town.osm"), from("town.graph"));
    let bytes = std::fs::read(place.path("town.graph")).unwrap();
    place.file("cut.graph", &bytes[..bytes.len() / 2]);
    let ran = place.openbench("route --map cut.graph 3.0,-0.0001 3.0002,0");
    assert!(
        ran.code == 2 && ran.stderr.contains("cut.graph") && ran.stderr.contains("prepare"),
        "{}",
        ran.stderr
    );
}

#[test]
fn a_place_without_streets_has_no_segment() {
    let ran = route("3.0,0 4,4");
    assert_eq!((ran.code, &ran.json()["code"]), (1, &"NoSegment".into()));
}

#[test]
fn places_west_and_south_are_places_too() {
    let ran = route("-3.0,-0.5 -3.001,-0.5");
    assert_eq!(
        (ran.code, &ran.json()["code"]),
        (1, &"NoSegment".into()),
        "{}",
        ran.stderr
    );
}

#[test]
fn a_map_without_streets_has_no_segment() {
    let place = town();
    place.file(
        "town.osm",
        place.read("town.osm").replace("highway", "waterway"),
    );
    let ran = place.openbench("route --map town.osm 3,0 3.0001,0");
    assert_eq!((ran.code, &ran.json()["code"]), (1, &"NoSegment".into()));
}

#[test]
fn monaco_is_crossed() {
    let Some(answer) = over("osm/monaco.osm.pbf", "7.4197,43.7314 7.4246,43.7387") else {
        return;
    };
    let distance = answer["routes"][0]["distance"].as_f64().unwrap();
    assert!((900.0..4000.0).contains(&distance), "{distance}");
}

#[test]
fn porto_west_of_greenwich_is_crossed() {
    let Some(answer) = over(
        "osm/porto_portugal.osm.pbf",
        "-8.6291,41.1579 -8.6110,41.1496",
    ) else {
        return;
    };
    let distance = answer["routes"][0]["distance"].as_f64().unwrap();
    assert!((1700.0..5000.0).contains(&distance), "{distance}");
}

#[test]
fn a_campus_is_crossed() {
    let Some(answer) = over("osm/ajou_campus.osm", "127.0437,37.2800 127.0465,37.2835") else {
        return;
    };
    let distance = answer["routes"][0]["distance"].as_f64().unwrap();
    assert!((400.0..2000.0).contains(&distance), "{distance}");
}
