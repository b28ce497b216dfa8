//! What several targets share.

use std::path::PathBuf;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use openbench_osm::{OsmData, OsmMap, default_georeference};
use openbench_routing::osrm::{Limits, Service, ServiceMemory};
use openbench_routing::{Metric, Profile, Roads};
use openbench_scene::{ImportError, ImportRequest, World, import_world};
use tempfile::TempDir;

/// One house at longitude 3 on the equator.
const MAP: &str = r#"<osm version="0.6">
  <node id="1" lat="-0.00005" lon="3.00005"/><node id="2" lat="-0.00005" lon="3.00015"/>
  <node id="3" lat="0.00005" lon="3.00015"/><node id="4" lat="0.00005" lon="3.00005"/>
  <way id="1"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/><tag k="building" v="yes"/></way>
</osm>"#;

/// A number of up to this size, or now and then any.
pub fn number(input: &mut Unstructured<'_>, size: f64) -> Result<f64> {
    let small = f64::from(input.arbitrary::<i16>()?) / f64::from(i16::MAX) * size;
    if input.ratio(1, 200)? {
        input.arbitrary()
    } else {
        Ok(small)
    }
}

/// Lays data flat and writes it again, as every command that is given a map does.
pub fn use_map(data: &OsmData) {
    if let Ok(georeference) = default_georeference(data) {
        let map = OsmMap::new(data, georeference);
        let _ = map.nearest_building(Default::default());
    }
    let written = data.to_xml();
    assert!(
        OsmData::from_xml(&written).is_ok(),
        "what was written cannot be read"
    );
}

/// Asks for routes, with every profile.
pub fn use_roads(roads: Roads) {
    let places: Vec<String> = roads
        .network
        .vertices
        .iter()
        .take(4)
        .map(|place| {
            let at = place.position();
            format!(
                "{},{}",
                at.lon.clamp(-180.0, 180.0),
                at.lat.clamp(-90.0, 90.0)
            )
        })
        .collect();
    let places = places.join(";");
    let mut roads = Some(roads);
    for name in Profile::NAMES {
        let Some(known) = roads.take() else { return };
        let profile = Profile::named(name).expect("a built-in profile");
        let Ok(metric) = Metric::new(&known, profile) else {
            return;
        };
        let service = Service {
            roads: known,
            metric,
            limits: Limits::default(),
        };
        let mut memory = ServiceMemory::default();
        for target in [
            format!("/route/v1/any/{places}?steps=true&annotations=true&overview=full"),
            format!("/route/v1/any/{places}?alternatives=3"),
            format!("/table/v1/any/{places}?annotations=duration,distance"),
            format!("/nearest/v1/any/{places}?number=5"),
        ] {
            service.answer(&target, &mut memory);
        }
        roads = Some(service.roads);
    }
}

/// A folder with a map and whatever a target puts beside it.
pub struct Folder(TempDir);

impl Folder {
    /// An own folder, with the map in it.
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder for temporary files"));
        folder.put("map.osm", MAP.as_bytes());
        folder
    }

    /// Writes a file.
    pub fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a file lies in a folder"))
            .expect("room for a folder");
        std::fs::write(&path, bytes).expect("room for a file");
        path
    }

    /// Imports a world.
    pub fn import(&self, world: &[u8]) -> Result<World, ImportError> {
        import_world(&ImportRequest {
            world: self.put("test.world", world),
            map: self.0.path().join("map.osm"),
            models: vec![self.0.path().to_owned()],
            georeference: None,
            start: None,
        })
    }
}

impl Default for Folder {
    fn default() -> Self {
        Self::new()
    }
}
