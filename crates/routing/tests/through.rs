//! Routes through places in between, with and without U-turns there.

use openbench_core::LonLat;
use openbench_osm::OsmData;
use openbench_routing::geo::Place;
use openbench_routing::leg::Memory;
use openbench_routing::osrm::{Limits, Service, ServiceMemory};
use openbench_routing::position::{Snap, SnapOptions};
use openbench_routing::through::through;
use openbench_routing::tree::Nearest;
use openbench_routing::{Metric, Profile, Roads};
use serde_json::Value;

/// A block of 100 m by 100 m, and a dead end to the south of its south-east corner.
const TOWN: &str = r#"<osm version="0.6">
  <node id="1" lat="0" lon="0.000"/><node id="2" lat="0" lon="0.001"/>
  <node id="3" lat="0.001" lon="0.001"/>
  <node id="4" lat="0.001" lon="0.000"/><node id="5" lat="-0.001" lon="0.001"/>
  <way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/>
  <tag k="name" v="South Street"/></way>
  <way id="2"><nd ref="2"/><nd ref="3"/><tag k="highway" v="residential"/>
  <tag k="name" v="East Street"/></way>
  <way id="3"><nd ref="3"/><nd ref="4"/><nd ref="1"/><tag k="highway" v="residential"/>
  <tag k="name" v="North Street"/></way>
  <way id="4"><nd ref="2"/><nd ref="5"/><tag k="highway" v="residential"/>
  <tag k="name" v="Dead End"/></way>
</osm>"#;

/// A street that can only be left.
const WAY_OUT: &str = r#"<node id="6" lat="0.01" lon="0"/>
  <way id="5"><nd ref="6"/><nd ref="4"/><tag k="highway" v="residential"/>
  <tag k="oneway" v="yes"/></way></osm>"#;

fn roads() -> Roads {
    let town = TOWN.replace("</osm>", WAY_OUT);
    Roads::read(
        &OsmData::from_xml(town.as_bytes()).unwrap(),
        &Default::default(),
    )
    .unwrap()
}

/// The length of a route, in units of 100 m, and the answer.
fn route(profile: &str, places: &str, options: &str) -> (f64, Value) {
    let roads = roads();
    let metric = Metric::new(&roads, Profile::named(profile).unwrap()).unwrap();
    let service = Service {
        roads,
        metric,
        limits: Limits::default(),
    };
    let answer = service.answer(
        &format!("/route/v1/x/{places}?{options}"),
        &mut ServiceMemory::default(),
    );
    let answer: Value = serde_json::from_slice(&answer.body).unwrap();
    let metres = answer["routes"][0]["distance"].as_f64().unwrap_or_default();
    ((metres / 11.13).round() / 10.0, answer)
}

#[test]
fn routes_make_u_turns_in_between_or_go_on() {
    // From the south side to the middle of the east side and back.
    let there_and_back = "0.0002,0;0.001,0.0005;0.0002,0";
    assert_eq!(route("foot", there_and_back, "").0, 2.6);
    // Without turn costs the next corner does not remember where the route came from.
    assert_eq!(
        route("foot", there_and_back, "continue_straight=true").0,
        3.6
    );
    assert_eq!(
        route("delivery", there_and_back, "continue_straight=default").0,
        2.6
    );
    assert_eq!(route("car", there_and_back, "").0, 4.0);
    assert_eq!(
        route("car", there_and_back, "continue_straight=true").0,
        4.0
    );
}

#[test]
fn routes_that_go_on_do_not_turn_back_at_a_corner() {
    let to_the_corner_and_back = "0.0002,0;0.001,0;0.0002,0";
    assert_eq!(route("foot", to_the_corner_and_back, "").0, 1.6);
    // Into the dead end and out again, or around the block.
    assert_eq!(
        route("foot", to_the_corner_and_back, "continue_straight=true").0,
        3.6
    );
    assert_eq!(
        route("car", to_the_corner_and_back, "continue_straight=true").0,
        4.0
    );
}

#[test]
fn in_a_dead_end_routes_make_a_u_turn() {
    let into_it_and_back = "0.0002,0;0.001,-0.001;0.0002,0";
    for profile in Profile::NAMES {
        assert_eq!(
            route(profile, into_it_and_back, "continue_straight=true").0,
            3.6,
            "{profile}"
        );
    }
}

#[test]
fn a_route_that_begins_at_a_corner_begins_without_a_turn() {
    let (length, answer) = route("foot", "0.001,0;0.001,0.0005", "steps=true");
    let steps = answer["routes"][0]["legs"][0]["steps"].as_array().unwrap();
    let kinds: Vec<&str> = steps
        .iter()
        .filter_map(|step| step["maneuver"]["type"].as_str())
        .collect();
    assert_eq!((length, kinds), (0.5, vec!["depart", "arrive"]));
    assert_eq!(steps[0]["name"], "East Street");
    // The arrival at a corner is on the road that was travelled, from its direction.
    let (_, answer) = route("foot", "0.001,0.0005;0.001,0", "steps=true");
    let arrive = &answer["routes"][0]["legs"][0]["steps"][1];
    assert_eq!(
        (&arrive["maneuver"]["bearing_before"], &arrive["name"]),
        (&180.into(), &"East Street".into())
    );
    for step in answer["routes"][0]["legs"][0]["steps"].as_array().unwrap() {
        assert!(
            step["distance"].as_f64().unwrap() > 0.0 || step["maneuver"]["type"] == "arrive",
            "{step}"
        );
    }
}

/// Found by fuzzing.
#[test]
fn there_is_no_route_through_an_unreachable_place() {
    let roads = roads();
    let metric = Metric::new(&roads, Profile::named("car").unwrap()).unwrap();
    let near = |(lon, lat): (f64, f64)| {
        let place = Place::new(LonLat::new(lon, lat)).unwrap();
        Snap::new(
            &roads,
            &metric,
            place,
            &SnapOptions::default(),
            &mut Nearest::default(),
        )
        .nearest
    };
    let places = [(0.0002, 0.0), (0.0, 0.005), (0.001, 0.0005)].map(near);
    let town = [places[0].clone(), places[2].clone(), places[0].clone()];
    for straight in [false, true] {
        let memory = &mut Memory::default();
        assert_eq!(through(&roads, &metric, &places, straight, memory), None);
        assert_eq!(
            through(&roads, &metric, &town, straight, memory).map(|legs| legs.len()),
            Some(2)
        );
    }
}
