//! How wrong the public map is.

use openbench_osm::disturb::MapErrors;

use super::level::Condition;

impl Condition for MapErrors {
    const KEY: &'static str = "map";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("exact", Self::EXACT),
        ("good", Self::GOOD),
        ("city", Self::CITY),
        ("poor", Self::POOR),
    ];

    fn check(&self) -> Result<(), String> {
        self.check().map_err(|error| error.to_string())
    }

    fn is_off(&self) -> bool {
        self.is_exact()
    }
}
