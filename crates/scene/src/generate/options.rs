//! Settings of world generation.

use openbench_core::Pose2;

use crate::plates::StreetPlates;
use crate::scenery::Scenery;

/// What a map leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct GenerateOptions {
    /// Name of the world, as in results.
    pub name: String,
    /// Start pose of robots, in the frame of the requested georeference. By default a clear place
    /// on a pavement or path in the middle of the doors, from which most of them are reached.
    pub start: Option<Pose2>,
    /// Share of the parking places with a car in them, 0 to 1.
    pub parked_cars: f64,
    /// Amount of greenery that is added to the map's own, 0 to 1.
    pub planting: f64,
    /// Whether a building without a mapped entrance gets a door towards the street.
    pub invent_doors: bool,
    /// Seed by which the doors of those buildings are drawn in any of their walls, with their
    /// numbers, in place of that one door; `None` draws none. It is apart from the world's own: the
    /// same streets can get other doors.
    pub drawn_doors: Option<u64>,
    /// What door plates are like.
    pub plates: PlateOptions,
    /// What makes streets differ.
    pub scenery: SceneryOptions,
    /// Licences and authors of the map, copied to the world.
    pub attribution: Vec<String>,
}

/// What the conditions of a run change about a world; by default nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Alterations {
    /// What door plates are like.
    pub plates: PlateOptions,
    /// See [`GenerateOptions::drawn_doors`].
    pub drawn_doors: Option<u64>,
    /// What makes streets differ.
    pub scenery: SceneryOptions,
}

impl GenerateOptions {
    /// The same options in a world that is altered.
    #[must_use]
    pub fn altered(self, by: Alterations) -> Self {
        Self {
            plates: by.plates,
            drawn_doors: by.drawn_doors,
            scenery: by.scenery,
            ..self
        }
    }
}

impl Default for GenerateOptions {
    fn default() -> Self {
        Self {
            name: "generated".into(),
            start: None,
            parked_cars: 0.6,
            planting: 0.5,
            invent_doors: true,
            drawn_doors: None,
            plates: PlateOptions::default(),
            scenery: SceneryOptions::default(),
            attribution: Vec::new(),
        }
    }
}

/// What makes streets differ; by default nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SceneryOptions {
    /// How much of it there is.
    pub amounts: Scenery,
    /// Seed of all that is drawn for it, apart from the world's own: the same houses and doors can
    /// stand in other streets.
    pub seed: u64,
}

/// What door plates are like; by default as in the published worlds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlateOptions {
    /// Their shares.
    pub shares: StreetPlates,
    /// Seed of all that is drawn for them, apart from the world's own: the same streets can get
    /// other plates. It also decides which typefaces are used, see
    /// [`TypefaceSet`](crate::plates::TypefaceSet::of_seed).
    pub seed: u64,
}
