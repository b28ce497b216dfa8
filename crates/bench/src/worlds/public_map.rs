//! The map that agents get, and how it differs from the world.

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Georeference, MapPoint, Pose2, Start};
use openbench_geometry::{Bounds, Polygon};
use openbench_osm::disturb::{BuildingError, Disturbed, MapErrors, MapState, disturb};
use openbench_osm::{ElementId, OsmData, OsmMap};
use openbench_scene::{Door, World};
use openbench_sim::noise::Noise;
use serde::{Deserialize, Serialize};

use crate::BenchError;
use crate::plural::count;

/// A door farther than this from every building belongs to none, metres: plates hang in recesses
/// and under canopies.
const DOOR_REACH_M: f64 = 5.0;

/// Stream of random numbers, distinct from those of other conditions, sensors and traffic.
const ORIGIN_STREAM: u64 = 37;
/// Largest distance along each axis of a drawn origin from the middle of the buildings, metres.
const ORIGIN_REACH_M: f64 = 400.0;

/// The public map of a suite where it is not simply the map of the world: it has errors, or a
/// `map` frame of its own, or both.
///
/// The origin of a world's frame is at the start of its robot, or near it. Agents that have to find
/// out where they start, or how far their map is off, must not read that from an origin.
#[derive(Debug, Clone)]
pub(super) struct OtherMap {
    /// In the projection of the world, with the false origin of the world.
    disturbed: Option<Disturbed>,
    /// In the frame that agents get.
    map: OsmMap,
    /// Coordinates of the frame that agents get less those of the world's, metres.
    shift: MapPoint,
}

impl OtherMap {
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
        let disturbed = if errors.is_exact() {
            None
        } else {
            let disturbed = disturb(&world.map, place, errors, ordered, seed);
            Some(disturbed.map_err(|error| BenchError::world(format!("[map] {error}")))?)
        };
        if let Georeference::TangentPlane { .. } = place {
            return Err(BenchError::world(
                "map, start: the point of tangency of the world's georeference tells agents where \
                 its origin is; give the world a UTM georeference (--georef utm:33N,0,0)",
            ));
        }
        let data = disturbed.as_ref().map_or(&world.map, |wrong| &wrong.map);
        let shift = drawn_shift(data, place);
        let offset = place.offset();
        let offset = MapPoint::new(offset.x + shift.x, offset.y + shift.y);
        let map = OsmMap::new(data, place.with_offset(offset));
        Ok(Self {
            disturbed,
            map,
            shift,
        })
    }

    /// The data of the map; `None` if they are those of the world.
    pub(super) fn data(&self) -> Option<&OsmData> {
        self.disturbed.as_ref().map(|wrong| &wrong.map)
    }

    pub(super) fn map(&self) -> &OsmMap {
        &self.map
    }

    fn outwards(&self, at: MapPoint) -> MapPoint {
        MapPoint::new(at.x + self.shift.x, at.y + self.shift.y)
    }
}

/// How much the frame of `place` has to be shifted to have its origin at a random place near the
/// middle of the buildings: whole metres.
// Drawn from the public map itself, which agents have anyway: neither the world nor the seed of the
// run can be inferred from it.
fn drawn_shift(data: &OsmData, place: Georeference) -> MapPoint {
    let hash = blake3::hash(&data.to_xml());
    let seed = u64::from_le_bytes(std::array::from_fn(|i| hash.as_bytes()[i]));
    let mut noise = Noise::new(seed, ORIGIN_STREAM);
    let map = OsmMap::new(data, place);
    let corners = map.buildings.iter().flat_map(|b| &b.polygon.outer);
    let bounds = corners.map(|corner| Bounds::of_point(*corner));
    let bounds = bounds.reduce(|a, b| a.union(b));
    let middle = bounds.map_or(MapPoint::default(), |bounds| bounds.middle());
    let mut draw = |middle: f64| {
        let away = ORIGIN_REACH_M * (2.0 * noise.uniform() - 1.0);
        libm::round(away - middle)
    };
    MapPoint::new(draw(middle.x), draw(middle.y))
}

/// Where things of the world are on the public map.
#[derive(Debug, Clone, Copy)]
pub struct OnMap<'a> {
    other: Option<&'a OtherMap>,
}

impl<'a> OnMap<'a> {
    pub(super) fn of(other: Option<&'a OtherMap>) -> Self {
        Self { other }
    }

    /// The `map` frame of the world in that of the public map; `None` if they are the same.
    pub fn frame(&self) -> Option<Pose2> {
        let other = self.other?;
        let wrong = other.disturbed.as_ref();
        let Pose2 { x, y, yaw } = wrong.map_or(Pose2::default(), |wrong| wrong.frame);
        let origin = other.outwards(MapPoint::new(x, y));
        Some(Pose2::new(origin.x, origin.y, yaw))
    }

    /// Coordinates of the public map's frame less those of the world's frame, for one place on the
    /// Earth, metres: what satellite fixes differ by.
    pub fn shift(&self) -> MapPoint {
        self.other.map_or(MapPoint::default(), |other| other.shift)
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
        match self.wrong() {
            None => self.point(at),
            Some(wrong) => {
                let beside = wrong.beside(building, at);
                self.other.map_or(beside, |other| other.outwards(beside))
            }
        }
    }

    fn wrong(&self) -> Option<&'a Disturbed> {
        self.other.and_then(|other| other.disturbed.as_ref())
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
        let errors = self.wrong().map(|wrong| &wrong.buildings);
        let error = errors
            .zip(building)
            .and_then(|(errors, id)| errors.get(&id));
        error.map_or(MapState::Right, |error| error.state)
    }

    /// The outlines of buildings that are in the map, but not there: in the world's frame.
    pub fn invented(&self) -> &'a [Polygon] {
        self.wrong().map_or(&[], |wrong| &wrong.invented)
    }

    /// What was drawn; `None` if the map is right.
    pub fn drawn(&self) -> Option<DrawnMap> {
        self.wrong().map(DrawnMap::of)
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
    /// Where the map has the origin and the axes of the world's `map` frame: metres and radians.
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
