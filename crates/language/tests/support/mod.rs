//! Small maps, flat or straight-line travel times and scripted chat models.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::sync::Mutex;

use openbench_core::{Georeference, LonLat, MapPoint, Plan, TravelTimes};
use openbench_language::{PlanError, PlanRequest, Planner};
use openbench_models::{ChatError, ChatModel, ChatReply, ChatRequest};
use openbench_osm::{OsmData, OsmMap};

/// A row of square houses along the equator, 22 m apart, the first about 22 m east of the origin:
/// one for each list of tags. `doors` puts entrances with a unit on the house of that index, up to
/// four.
pub fn map(houses: &[&[(&str, &str)]], doors: &[(usize, &str)]) -> OsmMap {
    let mut nodes = String::new();
    let mut ways = String::new();
    for (i, tags) in houses.iter().enumerate() {
        let west = (i as f64 + 1.0) * 2e-4;
        let id = |corner: usize| i * 10 + corner + 1;
        let units: Vec<&str> = doors
            .iter()
            .filter(|(house, _)| *house == i)
            .map(|(_, unit)| *unit)
            .collect();
        for (corner, (x, y)) in [(0.0, 0.0), (1e-4, 0.0), (1e-4, 1e-4), (0.0, 1e-4)]
            .into_iter()
            .enumerate()
        {
            let tags = |unit: &&str| {
                format!(r#"<tag k="entrance" v="yes"/><tag k="addr:unit" v="{unit}"/>"#)
            };
            let door = units.get(corner).map(tags).unwrap_or_default();
            nodes += &format!(
                r#"<node id="{}" lat="{y}" lon="{}">{door}</node>"#,
                id(corner),
                west + x
            );
        }
        let refs: String = [0, 1, 2, 3, 0]
            .iter()
            .map(|c| format!(r#"<nd ref="{}"/>"#, id(*c)))
            .collect();
        let tags: String = tags
            .iter()
            .map(|(k, v)| format!(r#"<tag k="{k}" v="{v}"/>"#))
            .collect();
        ways += &format!(
            r#"<way id="{}">{refs}<tag k="building" v="yes"/>{tags}</way>"#,
            i + 1
        );
    }
    let xml = format!(r#"<?xml version="1.0"?><osm version="0.6">{nodes}{ways}</osm>"#);
    let data = OsmData::from_xml(xml.as_bytes()).unwrap();
    OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)))
}

/// `building1` to `building<count>`.
pub fn numbered(count: usize) -> OsmMap {
    let names: Vec<String> = (1..=count).map(|n| format!("building{n}")).collect();
    let tags: Vec<[(&str, &str); 1]> = names.iter().map(|name| [("name", name.as_str())]).collect();
    let houses: Vec<&[(&str, &str)]> = tags.iter().map(|t| t.as_slice()).collect();
    map(&houses, &[])
}

/// `building1` to `building<count>`, each with `unit1` to `unit4`.
pub fn numbered_with_units(count: usize) -> OsmMap {
    let names: Vec<String> = (1..=count).map(|n| format!("building{n}")).collect();
    let tags: Vec<[(&str, &str); 1]> = names.iter().map(|name| [("name", name.as_str())]).collect();
    let houses: Vec<&[(&str, &str)]> = tags.iter().map(|t| t.as_slice()).collect();
    let units = ["unit1", "unit2", "unit3", "unit4"];
    let doors: Vec<(usize, &str)> = (0..count)
        .flat_map(|house| units.map(|unit| (house, unit)))
        .collect();
    map(&houses, &doors)
}

/// Houses with these names.
pub fn named(names: &[&str]) -> OsmMap {
    let tags: Vec<[(&str, &str); 1]> = names.iter().map(|name| [("name", *name)]).collect();
    let houses: Vec<&[(&str, &str)]> = tags.iter().map(|t| t.as_slice()).collect();
    map(&houses, &[])
}

/// The same time between all places.
pub struct Flat;

impl TravelTimes for Flat {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        vec![60.0; places.len() * places.len()]
    }
}

/// One metre a second in a straight line.
pub struct Straight;

impl TravelTimes for Straight {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        places
            .iter()
            .flat_map(|a| places.iter().map(|b| a.distance(*b)))
            .collect()
    }
}

/// Plans from the origin.
pub fn plan(
    planner: &dyn Planner,
    map: &OsmMap,
    times: &dyn TravelTimes,
    instruction: &str,
) -> Result<Plan, PlanError> {
    planner.plan(&PlanRequest {
        instruction,
        map,
        start: MapPoint::default(),
        times,
    })
}

/// `building3/unit1 building2`: what is delivered where, in driving order.
pub fn doors(plan: &Plan) -> String {
    let door = |d: &openbench_core::PlannedDelivery| match &d.unit {
        Some(unit) => format!("{}/{unit}", d.building),
        None => d.building.clone(),
    };
    plan.deliveries
        .iter()
        .map(door)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Compares what is read with what is wanted, and reports all cases that differ.
#[track_caller]
pub fn compare(cases: &[(&str, &str)], read: impl Fn(&str) -> String) {
    let wrong: Vec<String> = cases
        .iter()
        .map(|(instruction, wanted)| (instruction, wanted, read(instruction)))
        .filter(|(_, wanted, got)| got != *wanted)
        .map(|(instruction, wanted, got)| {
            format!("{instruction}\n  wanted {wanted}\n  got    {got}")
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A chat model that answers with its lines one after the other and records the requests.
pub struct Script {
    lines: Mutex<Vec<String>>,
    /// The last message of each request.
    pub asked: Mutex<Vec<String>>,
}

impl Script {
    pub fn new(lines: &[&str]) -> Self {
        let lines = lines.iter().rev().map(|l| (*l).to_owned()).collect();
        Self {
            lines: Mutex::new(lines),
            asked: Mutex::default(),
        }
    }

    pub fn asked(&self) -> Vec<String> {
        self.asked.lock().unwrap().clone()
    }
}

impl ChatModel for Script {
    fn name(&self) -> &str {
        "script"
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.asked
            .lock()
            .unwrap()
            .push(request.messages.last().unwrap().text.clone());
        match self.lines.lock().unwrap().pop() {
            Some(text) => Ok(ChatReply {
                text,
                prompt_tokens: 0,
                completion_tokens: 0,
            }),
            None => Err(ChatError::Timeout {
                endpoint: "script".into(),
                seconds: 1,
            }),
        }
    }
}
