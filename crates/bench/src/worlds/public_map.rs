//! The map that agents get, and how it differs from the world.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{MapPoint, Pose2, Start};
use openbench_geometry::Polygon;
use openbench_osm::disturb::{BuildingError, Disturbed, MapErrors, MapState, disturb};
use openbench_osm::{ElementId, OsmData, OsmMap};
use openbench_scene::{Door, World};
use serde::{Deserialize, Serialize};

use crate::BenchError;
use crate::plural::count;

/// A door farther than this from every building belongs to none, metres: plates hang in recesses
/// and under canopies.
const DOOR_REACH_M: f64 = 5.0;

/// The public map of a suite whose map is wrong.
#[derive(Debug, Clone)]
pub(super) struct WrongMap {
    disturbed: Disturbed,
    map: OsmMap,
}

impl WrongMap {
    /// Draws the map of a world. `ordered` are the buildings that get a delivery.
    ///
    /// # Errors
    /// [`BenchError::World`] if no building would be left.
    pub(super) fn new(
        world: &World,
        errors: &MapErrors,
        ordered: &BTreeSet<ElementId>,
        seed: u64,
    ) -> Result<Self, BenchError> {
        let place = world.georeference;
        let disturbed = disturb(&world.map, place, errors, ordered, seed);
        let disturbed = disturbed.map_err(|error| BenchError::world(format!("[map] {error}")))?;
        let map = OsmMap::new(&disturbed.map, place);
        Ok(Self { disturbed, map })
    }

    pub(super) fn data(&self) -> &OsmData {
        &self.disturbed.map
    }

    pub(super) fn map(&self) -> &OsmMap {
        &self.map
    }
}

/// Where things of the world are on the public map.
#[derive(Debug, Clone, Copy)]
pub struct OnMap<'a> {
    wrong: Option<&'a WrongMap>,
}

impl<'a> OnMap<'a> {
    pub(super) fn of(wrong: Option<&'a WrongMap>) -> Self {
        Self { wrong }
    }

    /// The `map` frame of the world in that of the public map; `None` if they are the same.
    pub fn frame(&self) -> Option<Pose2> {
        self.wrong.map(|wrong| wrong.disturbed.frame)
    }

    /// A position of the world in the frame of the public map, metres.
    pub fn point(&self, at: MapPoint) -> MapPoint {
        // Exactly the same without errors, whatever the rounding of a transform.
        self.frame().map_or(at, |frame| frame.transform(at.x, at.y))
    }

    /// A pose of the world in the frame of the public map.
    pub fn pose(&self, pose: Pose2) -> Pose2 {
        self.frame().map_or(pose, |frame| frame.compose(pose))
    }

    /// A position at a building of the world where the public map has that building.
    pub fn beside(&self, building: Option<ElementId>, at: MapPoint) -> MapPoint {
        match self.wrong {
            None => at,
            Some(wrong) => wrong.disturbed.beside(building, at),
        }
    }

    /// What is known about a start, in the frame of the public map.
    pub fn start(&self, start: Start) -> Start {
        let yaw = self.frame().map_or(0.0, |frame| frame.yaw);
        match start {
            Start::Pose { pose, covariance } => Start::Pose {
                pose: self.pose(pose),
                covariance: turned(covariance, yaw),
            },
            Start::Area { centre, radius_m } => Start::Area {
                centre: self.point(centre),
                radius_m,
            },
            Start::Anywhere => Start::Anywhere,
        }
    }

    /// Whether the public map has a building of the world; always without errors of the map.
    pub fn state(&self, building: Option<ElementId>) -> MapState {
        let errors = self.wrong.map(|wrong| &wrong.disturbed.buildings);
        let error = errors
            .zip(building)
            .and_then(|(errors, id)| errors.get(&id));
        error.map_or(MapState::Right, |error| error.state)
    }

    /// The outlines of buildings that are in the map, but not there.
    pub fn invented(&self) -> &'a [Polygon] {
        self.wrong.map_or(&[], |wrong| &wrong.disturbed.invented)
    }

    /// What was drawn; `None` if the map is right.
    pub fn drawn(&self) -> Option<DrawnMap> {
        self.wrong.map(|wrong| DrawnMap::of(&wrong.disturbed))
    }
}

/// The covariance of x, y and yaw in a frame that is turned by `yaw` radians.
fn turned(covariance: [[f64; 3]; 3], yaw: f64) -> [[f64; 3]; 3] {
    if yaw == 0.0 {
        return covariance;
    }
    let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), yaw);
    let turn = turn.matrix();
    let covariance = nalgebra::Matrix3::from_fn(|row, column| covariance[row][column]);
    let turned = turn * covariance * turn.transpose();
    std::array::from_fn(|row| std::array::from_fn(|column| turned[(row, column)]))
}

/// What was drawn for a public map.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct DrawnMap {
    /// The `map` frame of the world in that of the public map: metres and radians.
    pub frame: Pose2,
    /// Root mean square of the distances by which buildings are shifted on top of that, metres.
    pub building_shift_m: f64,
    /// Buildings of the world.
    pub buildings: usize,
    /// Those of them that the map lacks.
    pub missing: usize,
    /// Those with a wrong number.
    pub wrong_numbers: usize,
    /// Those without a name.
    pub unnamed: usize,
    /// Those that are drawn as a rectangle.
    pub simplified: usize,
    /// Buildings in the map that are not there.
    pub invented: usize,
    /// Roads and paths that the map lacks.
    pub missing_roads: usize,
}

impl DrawnMap {
    /// What is wrong with the map, in words.
    pub fn describe(&self) -> String {
        let Pose2 { x, y, yaw } = self.frame;
        let parts = [
            (self.missing, "missing"),
            (self.wrong_numbers, "with a wrong number"),
            (self.unnamed, "without a name"),
            (self.simplified, "drawn as a rectangle"),
            (self.invented, "invented"),
        ];
        let parts: Vec<String> = parts
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!(", {count} {what}"))
            .collect();
        let roads = match self.missing_roads {
            0 => String::new(),
            roads => format!("; {} missing", count(roads, "road", "roads")),
        };
        format!(
            "the public map is moved by ({x:.2}, {y:.2}) m and turned by {:.2} degrees; of {}, \
             moved by {:.2} m more (root mean square){}{roads}",
            yaw.to_degrees(),
            count(self.buildings, "building", "buildings"),
            self.building_shift_m,
            parts.concat(),
        )
    }

    fn of(disturbed: &Disturbed) -> Self {
        let buildings = &disturbed.buildings;
        let in_state = |state| buildings.values().filter(|e| e.state == state).count();
        Self {
            frame: disturbed.frame,
            building_shift_m: building_shift(buildings),
            buildings: buildings.len(),
            missing: in_state(MapState::Missing),
            wrong_numbers: in_state(MapState::WrongNumber),
            unnamed: in_state(MapState::Unnamed),
            simplified: buildings.values().filter(|e| e.is_simplified).count(),
            invented: disturbed.invented.len(),
            missing_roads: disturbed.missing_roads,
        }
    }
}

fn building_shift(buildings: &BTreeMap<ElementId, BuildingError>) -> f64 {
    let squares = buildings
        .values()
        .map(|e| e.shift.x * e.shift.x + e.shift.y * e.shift.y);
    // At least one, for the mean of none.
    (squares.sum::<f64>() / buildings.len().max(1) as f64).sqrt()
}

/// The building of a map to which a door of the world belongs: the nearest one.
pub(super) fn building_of(map: &OsmMap, door: &Door) -> Option<ElementId> {
    let at = door.entrance().point();
    let nearest = map.nearest_building(at)?;
    let is_near = map.distance_to_building(nearest, at) <= DOOR_REACH_M;
    is_near.then(|| map.buildings[nearest].element)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_turn_with_the_map() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let covariance = [[4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.1]];
        let turned = turned(covariance, quarter);
        assert!((turned[0][0] - 1.0).abs() < 1e-12);
        assert!((turned[1][1] - 4.0).abs() < 1e-12);
        assert!((turned[2][2] - 0.1).abs() < 1e-12);
    }

    #[test]
    fn on_a_right_map_everything_is_where_it_is() {
        let on_map = OnMap::of(None);
        let pose = Pose2::new(1.0, 2.0, 3.0);
        assert_eq!(on_map.pose(pose), pose);
        assert_eq!(on_map.start(Start::exact(pose)), Start::exact(pose));
        assert_eq!(on_map.beside(None, pose.point()), pose.point());
        assert_eq!(
            (on_map.state(None), on_map.drawn()),
            (MapState::Right, None)
        );
    }
}
