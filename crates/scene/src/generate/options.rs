//! Settings of world generation.

use openbench_core::Pose2;

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
    /// Licences and authors of the map, copied to the world.
    pub attribution: Vec<String>,
}

impl Default for GenerateOptions {
    fn default() -> Self {
        Self {
            name: "generated".into(),
            start: None,
            parked_cars: 0.6,
            planting: 0.5,
            invent_doors: true,
            attribution: Vec::new(),
        }
    }
}
