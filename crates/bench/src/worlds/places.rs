//! Real places whose maps the crate carries: cut from OpenStreetMap, so that tuning, validation and
//! tests need nothing fetched.

use openbench_osm::{OsmData, default_georeference};
use openbench_scene::World;
use openbench_scene::generate::{Alterations, GenerateOptions, generate};

use crate::BenchError;
use crate::suite::WorldSource;
use crate::suite::split::Split;

/// A square of a few streets.
pub(crate) struct Place {
    /// Its name, and that of its suite.
    pub(crate) name: &'static str,
    /// What it may be used for.
    pub(crate) split: Split,
    xml: &'static str,
}

/// All places.
pub(crate) const PLACES: [Place; 5] = [
    Place {
        name: "krems",
        split: Split::Train,
        xml: include_str!("../../data/places/krems.osm"),
    },
    Place {
        name: "heidelberg",
        split: Split::Train,
        xml: include_str!("../../data/places/heidelberg.osm"),
    },
    Place {
        name: "campus",
        split: Split::Validation,
        xml: include_str!("../../data/places/campus.osm"),
    },
    Place {
        name: "bayreuth",
        split: Split::Validation,
        xml: include_str!("../../data/places/bayreuth.osm"),
    },
    Place {
        name: "monaco",
        split: Split::Test,
        xml: include_str!("../../data/places/monaco.osm"),
    },
];

impl Place {
    /// The place of a name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        PLACES.iter().find(|place| place.name == name)
    }

    /// Its world. The map has hardly any doors; the rest is drawn from the seed.
    ///
    /// # Errors
    /// [`BenchError::World`] if the world cannot be built.
    pub(crate) fn world(&self, seed: u64, by: Alterations) -> Result<World, BenchError> {
        let data = OsmData::from_xml(self.xml.as_bytes()).map_err(BenchError::world)?;
        let georeference = default_georeference(&data).map_err(BenchError::world)?;
        let options = GenerateOptions {
            name: self.name.to_owned(),
            attribution: vec![format!(
                "Map `{}`: © OpenStreetMap contributors, ODbL 1.0",
                self.name
            )],
            ..GenerateOptions::default()
        }
        .altered(by);
        generate(&data, georeference, seed, &options).map_err(BenchError::world)
    }
}

/// What a world may be used for; `None` for worlds from files, which nobody has assigned.
///
/// ```
/// use openbench_bench::WorldSource;
/// use openbench_bench::suite::split::Split;
/// use openbench_bench::worlds::split_of;
///
/// let monaco = WorldSource::Builtin { name: "monaco".into(), seed: 1 };
/// assert_eq!(split_of(&monaco), Some(Split::Test));
/// let drawn = WorldSource::Drawn { kind: "medium".into(), seed: 10_007 };
/// assert_eq!(split_of(&drawn), Some(Split::Validation));
/// ```
pub fn split_of(world: &WorldSource) -> Option<Split> {
    match world {
        WorldSource::Builtin { name, .. } => {
            Some(Place::named(name).map_or(Split::Train, |place| place.split))
        }
        WorldSource::Drawn { seed, .. } => Split::of_seed(*seed),
        WorldSource::Imported { .. } | WorldSource::Folder { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::{Prepared, builtin_suite};

    #[test]
    fn every_place_has_deliveries_to_doors_that_can_be_reached() {
        for place in &PLACES {
            let prepared = Prepared::new(builtin_suite(place.name).unwrap(), None).unwrap();
            let singles = prepared.episodes.iter().filter(|e| e.targets.len() == 1);
            assert_eq!(singles.count(), 10, "{}", place.name);
            for target in prepared.episodes.iter().flat_map(|e| &e.targets) {
                let reached = target.door.and_then(|door| prepared.approach[door]);
                assert!(reached.is_some(), "{}: {}", place.name, target.address);
            }
        }
    }
}
