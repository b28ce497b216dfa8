#![no_main]

use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use openbench_osm::OsmData;
use openbench_routing::osrm::{Limits, Service, ServiceMemory};
use openbench_routing::{Metric, Profile, Roads};

/// A street and a square.
const MAP: &str = r#"<osm version="0.6"><node id="1" lat="0" lon="3"/><node id="2" lat="0" lon="3.001"/><node id="3" lat="0.001" lon="3.001"/>
  <node id="4" lat="0.001" lon="3"/><way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/><tag k="name" v="Street"/></way>
  <way id="2"><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/><tag k="highway" v="footway"/></way></osm>"#;

fuzz_target!(|target: &str| {
    static SERVICE: OnceLock<Service> = OnceLock::new();
    let service = SERVICE.get_or_init(|| {
        let data = OsmData::from_xml(MAP.as_bytes()).expect("a good map");
        let roads = Roads::read(&data, &Default::default()).expect("a good map");
        let metric = Metric::new(&roads, Profile::delivery()).expect("few roads at a junction");
        Service {
            roads,
            metric,
            limits: Limits::default(),
        }
    });
    let answer = service.answer(target, &mut ServiceMemory::default());
    let json: serde_json::Value = serde_json::from_slice(&answer.body).expect("JSON");
    assert_eq!(json["code"] == "Ok", answer.status == 200);
});
