//! Maps that are wrong as real ones are: displaced, incomplete, outdated.
//!
//! [`disturb`] makes a wrong map of a right one. What it draws for one building or road depends on
//! the seed and that element alone, so that one more kind of error changes nothing about the
//! others. Only which number is wrong, and where invented buildings stand, depends on the rest of
//! the map.
//!
//! | module | content |
//! |---|---|
//! | `errors` | [`MapErrors`]: how wrong a map is |
//! | `building_error` | [`BuildingError`]: what is wrong with a building |
//! | `purpose` | what random numbers are drawn for |
//! | `footprint` | what belongs to each building |
//! | `outline` | outlines that were drawn carelessly |
//! | `numbers` | wrong and missing numbers |
//! | `inventions` | buildings that are not there |
//! | `drift` | roads that are displaced |
//! | `draft` | the map while it is being changed |

mod building_error;
mod draft;
mod drift;
mod errors;
mod footprint;
mod inventions;
mod numbers;
mod outline;
mod purpose;

use std::collections::{BTreeMap, BTreeSet};

use openbench_core::{Georeference, MapPoint, Pose2};
use openbench_geometry::Polygon;
use rand_pcg::Pcg64Mcg;

use crate::data::OsmData;
use crate::draws::{chance, element_number, normal, stream};
use crate::element::ElementId;
use crate::map::OsmMap;

use draft::Draft;
use drift::Drift;
use footprint::{Footprint, footprints};
use inventions::{inventions, middle};
use outline::Swelling;
use purpose::Purpose;

pub use building_error::{BuildingError, MapState};
pub use errors::{MapErrors, MapErrorsError};

/// A wrong map, and what is wrong with it.
#[derive(Debug, Clone)]
pub struct Disturbed {
    /// The wrong map. Its elements are numbered anew and do not tell what was done to them.
    pub map: OsmData,
    /// The true `map` frame in that of the wrong map: [`Pose2::transform`] of a true position gives
    /// the position on a map that is wrong in nothing but its place.
    pub frame: Pose2,
    /// The buildings of the right map, by their numbers there.
    pub buildings: BTreeMap<ElementId, BuildingError>,
    /// The outlines of buildings that are not there, in the frame of the wrong map.
    pub invented: Vec<Polygon>,
    /// Number of roads and paths that are missing.
    pub missing_roads: usize,
}

impl Disturbed {
    /// Where a position at or on a building is on the wrong map, metres in its `map` frame.
    pub fn beside(&self, building: Option<ElementId>, at: MapPoint) -> MapPoint {
        let own = building.and_then(|building| self.buildings.get(&building));
        let shift = own.map_or(MapPoint::default(), |error| error.shift);
        self.frame.transform(at.x + shift.x, at.y + shift.y)
    }
}

/// Why a map cannot be disturbed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DisturbError {
    /// A number is out of its range.
    #[error(transparent)]
    Errors(#[from] MapErrorsError),
    /// No building would be left.
    #[error(
        "missing = {missing}: none of the map's {buildings} buildings is left; give a smaller share"
    )]
    NothingLeft {
        /// Share of the missing buildings.
        missing: f64,
        /// Number of buildings of the right map.
        buildings: usize,
    },
}

/// Makes a wrong map of a right one. `ordered` are the buildings that get a delivery.
///
/// A town of one house, which the map shows half a metre from where it stands:
///
/// ```
/// use openbench_core::{Georeference, MapPoint};
/// use openbench_osm::disturb::{MapErrors, disturb};
/// use openbench_osm::{ElementId, OsmData, OsmMap};
///
/// let xml = r#"<osm version="0.6">
///   <node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.0001"/>
///   <node id="3" lat="0.0001" lon="0.0001"/><node id="4" lat="0.0001" lon="0"/>
///   <way id="9"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
///     <tag k="building" v="yes"/></way></osm>"#;
/// let right = OsmData::from_xml(xml.as_bytes())?;
/// let place: Georeference = "utm:31N,0,0".parse()?;
/// let wrong = disturb(&right, place, &MapErrors::GOOD, &Default::default(), 7)?;
/// let corner = |data: &OsmData| OsmMap::new(data, place).buildings[0].polygon.outer[0];
/// let expected = wrong.beside(Some(ElementId::way(9)), corner(&right));
/// assert!(corner(&wrong.map).distance(expected) < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Numbers out of their ranges, or a map of which no building would be left.
pub fn disturb(
    data: &OsmData,
    georeference: Georeference,
    errors: &MapErrors,
    ordered: &BTreeSet<ElementId>,
    seed: u64,
) -> Result<Disturbed, DisturbError> {
    errors.check()?;
    let map = OsmMap::new(data, georeference);
    let footprints = footprints(data, &map);
    let spared = |element: &ElementId| errors.spares_ordered && ordered.contains(element);
    let mut buildings: BTreeMap<ElementId, BuildingError> = footprints
        .keys()
        .map(|element| {
            (
                *element,
                building_error(errors, *element, spared(element), seed),
            )
        })
        .collect();
    let is_left = |error: &BuildingError| error.state != MapState::Missing;
    if !buildings.is_empty() && !buildings.values().any(is_left) {
        return Err(DisturbError::NothingLeft {
            missing: errors.missing,
            buildings: buildings.len(),
        });
    }
    let frame = frame(errors, middle(&map), seed);
    let mut draft = Draft::new(data, &map, &footprints);
    draft.rename(&mut buildings, &footprints, seed);
    let missing_roads = draft.remove_roads(|way| {
        let mut draws = stream(seed, Purpose::MissingRoads as u64, way as u64);
        chance(&mut draws, errors.missing_roads)
    });
    let drift = Drift::new(errors.road_shift_m, seed);
    draft.move_roads(|at| drift.apply(at));
    for (element, footprint) in &footprints {
        let error = buildings.entry(*element).or_default();
        if error.state == MapState::Missing {
            error.is_simplified = false;
            draft.remove(footprint);
        } else {
            let swelling = swelling(errors, *element, footprint, seed);
            error.is_simplified = draft.change(*element, footprint, error, swelling);
        }
    }
    let count = libm::round(errors.invented * buildings.len() as f64) as usize;
    let outlines = inventions(&map, count, seed);
    let invented = outlines
        .iter()
        .map(|outline| moved(outline, frame))
        .collect();
    draft.invent(outlines);
    Ok(Disturbed {
        map: draft.finish(frame, seed),
        frame,
        buildings,
        invented,
        missing_roads,
    })
}

/// An outline in the frame of the wrong map.
fn moved(outline: &Polygon, frame: Pose2) -> Polygon {
    let corners = |ring: &Vec<MapPoint>| -> Vec<MapPoint> {
        let corners = ring.iter();
        corners.map(|at| frame.transform(at.x, at.y)).collect()
    };
    Polygon {
        outer: corners(&outline.outer),
        holes: outline.holes.iter().map(corners).collect(),
    }
}

/// The true `map` frame in that of the wrong map.
fn frame(errors: &MapErrors, middle: MapPoint, seed: u64) -> Pose2 {
    let mut draws = stream(seed, Purpose::Whole as u64, 0);
    let shift = shift(&mut draws, errors.shift_m);
    // Added to zero, since a rotation by -0 would be printed with its sign.
    let yaw = 0.0 + (errors.rotation_deg * normal(&mut draws)).to_radians();
    // The middle turns about itself: whatever is far from it moves.
    let turned = Pose2::new(0.0, 0.0, yaw).transform(middle.x, middle.y);
    Pose2::new(
        middle.x - turned.x + shift.x,
        middle.y - turned.y + shift.y,
        yaw,
    )
}

/// A shift with a standard deviation along each axis.
fn shift(draws: &mut Pcg64Mcg, deviation_m: f64) -> MapPoint {
    let east = deviation_m * normal(draws);
    MapPoint::new(east, deviation_m * normal(draws))
}

/// What is wrong with a building. Its name may turn out to have no number that could be wrong.
fn building_error(
    errors: &MapErrors,
    element: ElementId,
    spared: bool,
    seed: u64,
) -> BuildingError {
    let draws = |purpose: Purpose| stream(seed, purpose as u64, element_number(element));
    let is_drawn = |purpose, share| chance(&mut draws(purpose), share);
    let state = if spared {
        MapState::Right
    } else if is_drawn(Purpose::Missing, errors.missing) {
        MapState::Missing
    } else if is_drawn(Purpose::Name, errors.unnamed) {
        MapState::Unnamed
    } else if is_drawn(Purpose::Number, errors.wrong_numbers) {
        MapState::WrongNumber
    } else {
        MapState::Right
    };
    BuildingError {
        shift: shift(&mut draws(Purpose::BuildingShift), errors.building_shift_m),
        state,
        is_simplified: is_drawn(Purpose::Simplified, errors.simplified),
    }
}

fn swelling(errors: &MapErrors, element: ElementId, footprint: &Footprint, seed: u64) -> Swelling {
    let mut draws = stream(seed, Purpose::Swelling as u64, element_number(element));
    Swelling::new(&footprint.polygon, errors.swelling_m * normal(&mut draws))
}

#[cfg(test)]
mod tests;
