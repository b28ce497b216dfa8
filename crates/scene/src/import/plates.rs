//! Number plates. The published worlds mark doors with models `text_model1`, `text_model2`, …,
//! whose meshes were never published: a plate is drawn in their place. Its outward normal is the
//! model's +y, its text runs along x.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Vector2, Vector3};
use openbench_core::address::fold_name;
use openbench_core::{Address, MapPoint, Pose2, Pose3};
use openbench_osm::OsmMap;

use super::sdf::{Geometry, Model};
use super::search::model_of;
use super::warnings::Warnings;
use crate::plate::{USUAL_LETTERING, hang_plate, plate_material};
use crate::world::MAX_FROM_ORIGIN_M;
use crate::{Door, SceneBuilder, SemanticClass};

/// Distance of plates in front of their poses, metres: in the published worlds these lie up to 9 cm
/// behind the frames of their doors.
const STANDS_OUT_M: f64 = 0.10;

/// Distance of the default start in front of a door, metres.
const BEFORE_DOOR_M: f64 = 3.0;
/// Plates farther than this from every outline indicate that world and map do not match, metres.
const OFF_BUILDING_M: f64 = 5.0;

/// A plate whose door is not known yet.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlateAt {
    /// Number of the unit.
    pub(crate) unit: u32,
    /// Middle of the plate, in `map`.
    pub(crate) pose: Pose3,
}

impl PlateAt {
    fn point(&self) -> MapPoint {
        MapPoint::new(self.pose.translation.x, self.pose.translation.y)
    }

    /// Direction that it faces: radians, counter-clockwise from east.
    fn facing(&self) -> f64 {
        let normal = self.pose.rotation * Vector3::y();
        libm::atan2(normal.y, normal.x)
    }
}

/// The unit that a model called `text_model<N>` marks, perhaps with a suffix such as `_0`.
pub(crate) fn unit_of_name(name: &str) -> Option<u32> {
    let rest = name.strip_prefix("text_model")?;
    let end = rest
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(rest.len());
    // `text_model12b` is another name, `text_model12_0` a copy of number 12.
    let (number, suffix) = rest.split_at(end);
    if suffix.is_empty() || suffix.starts_with(['_', ' ', '-', '(']) {
        number.parse().ok()
    } else {
        None
    }
}

/// The plate that `model` represents, by the file of its mesh or else by its name. `pose` is the
/// pose of the model in `map`.
pub(crate) fn plate_of(model: &Model, pose: &Pose3) -> Option<PlateAt> {
    let shapes = model
        .links
        .iter()
        .flat_map(|l| l.shapes.iter().map(move |s| (l, s)));
    let mut with_unit = shapes.filter_map(|(link, shape)| match &shape.geometry {
        Geometry::Mesh(mesh) => Some((
            unit_of_name(model_of(&mesh.uri)?)?,
            pose * link.pose * shape.pose,
        )),
        _ => None,
    });
    // The mesh hangs where the plate is seen; the model's own pose may be elsewhere.
    let by_mesh = with_unit.next().map(|(unit, pose)| PlateAt { unit, pose });
    by_mesh.or_else(|| unit_of_name(&model.name).map(|unit| PlateAt { unit, pose: *pose }))
}

/// The plates of models and of models in them, in the order of the file.
pub(crate) fn plates_of(models: &[Model]) -> Vec<PlateAt> {
    fn collect(models: &[Model], parent: &Pose3, plates: &mut Vec<PlateAt>) {
        for model in models {
            let pose = parent * model.pose;
            match plate_of(model, &pose) {
                Some(plate) => plates.push(plate),
                None => collect(&model.models, &pose, plates),
            }
        }
    }
    let mut plates = Vec::new();
    collect(models, &Pose3::identity(), &mut plates);
    plates
}

/// The default start of robots: the origin, as in Gazebo; where that is far from all doors, in
/// front of the one nearest to the middle of all.
pub(crate) fn usual_start(plates: &[PlateAt]) -> Pose2 {
    let points = || {
        plates
            .iter()
            .map(|plate| plate.pose.translation.vector.xy())
    };
    if plates.is_empty() || points().any(|point| point.norm() < MAX_FROM_ORIGIN_M) {
        return Pose2::default();
    }
    let middle = points().sum::<Vector2<f64>>() / plates.len() as f64;
    let off = |plate: &&PlateAt| (plate.pose.translation.vector.xy() - middle).norm();
    let nearest = plates.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.map_or(Pose2::default(), |plate| {
        let out = plate.facing();
        let at = plate.point().offset(out, BEFORE_DOOR_M);
        Pose2::new(at.x, at.y, out)
    })
}

/// Adds the plates and their doors, each to the building whose outline is nearest.
pub(crate) fn add_doors(
    builder: &mut SceneBuilder,
    plates: &[PlateAt],
    map: &OsmMap,
    warnings: &mut Warnings,
) {
    let mut known = BTreeSet::new();
    let mut faces = BTreeMap::new();
    let mut strays = 0;
    for plate in plates {
        let point = plate.point();
        let Some(building) = map.nearest_building(point) else {
            continue;
        };
        // A stray plate becomes a door all the same; the warning tells that the map may be the
        // wrong one.
        strays += usize::from(map.distance_to_building(building, point) > OFF_BUILDING_M);
        let named = map.buildings.get(building).and_then(|b| b.name.clone());
        let building = named.unwrap_or_else(|| format!("building{}", building + 1));
        let address = Address::new(building, format!("unit{}", plate.unit));
        // Units are numbers here, so doors are the same if their buildings' names are.
        if !known.insert((fold_name(&address.building), plate.unit)) {
            warnings.add(format!("two doors have the address {address}"));
        }
        let text = format!("UNIT {}", plate.unit);
        let face = *faces
            .entry(plate.unit)
            .or_insert_with(|| plate_material(builder, &text));
        builder.begin_object(format!("plate of {address}"), SemanticClass::Plate);
        hang_plate(builder, face, &plate.pose, STANDS_OUT_M);
        let at = plate.pose.translation.vector.into();
        builder.door(Door {
            address,
            text,
            plate: at,
            facing: plate.facing(),
            lettering: USUAL_LETTERING,
            doorway: None,
        });
    }
    if strays > 0 {
        warnings.add(format!(
            "{strays} of {} plates hang more than {OFF_BUILDING_M} m from every building of the \
             map; is it the map of this world, and its georeference (--georef) right?",
            plates.len()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_names() {
        let expected = [
            ("text_model1", Some(1)),
            ("text_model12_0", Some(12)),
            ("text_model3_clone_2", Some(3)),
            ("text_model", None),
            ("text_model1x", None),
            ("my_text_model1", None),
            ("text_model99999999999", None),
        ];
        for (name, unit) in expected {
            assert_eq!(unit_of_name(name), unit, "{name}");
        }
    }
}
