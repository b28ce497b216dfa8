#![no_main]

use libfuzzer_sys::fuzz_target;
use openbench_osm::OsmData;
use openbench_routing::{Metric, Profile, Roads};

const MAP: &str = r#"<osm version="0.6"><node id="1" lat="0" lon="3"/><node id="2" lat="0" lon="3.1"><tag k="barrier" v="gate"/></node><node id="3" lat="0.1" lon="3.1"/>
  <way id="1"><nd ref="1"/><nd ref="2"/><nd ref="3"/><tag k="highway" v="residential"/><tag k="maxspeed" v="50"/></way></osm>"#;

fuzz_target!(|text: &str| {
    let Ok(profile) = Profile::from_toml("fuzzed", text) else {
        return;
    };
    let data = OsmData::from_xml(MAP.as_bytes()).expect("a good map");
    let roads = Roads::read(&data, &Default::default()).expect("a good map");
    Metric::new(&roads, profile).expect("few roads at a junction");
});
