#![no_main]

use libfuzzer_sys::fuzz_target;
use openbench_fuzz::use_map;
use openbench_osm::OsmData;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(data) = OsmData::from_pbf(bytes) {
        use_map(&data);
    }
});
