#![no_main]

use libfuzzer_sys::fuzz_target;
use openbench_fuzz::use_roads;
use openbench_osm::OsmData;
use openbench_routing::Roads;
use openbench_routing::partition::CellSizes;

fuzz_target!(|map: &[u8]| {
    let Ok(data) = OsmData::from_xml(map) else {
        return;
    };
    // Small cells, so that small maps have layers too.
    let sizes = CellSizes::new(&[3, 9]).expect("sizes that ascend");
    if let Ok(roads) = Roads::read(&data, &sizes) {
        use_roads(roads);
    }
});
