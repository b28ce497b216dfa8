//! Import of Gazebo worlds: SDF 1.4 to 1.7 with the models that they refer to.
//!
//! Poses of the saved `<state>` take precedence over those of the models. Materials come from OGRE
//! scripts, meshes or Gazebo itself. Models `text_model1`, `text_model2`, … become plates of units
//! 1, 2, …, and thereby doors. Everything is static: joints, physics, sensors, plugins and actors
//! are left out. Visible things that are not supported are counted in [`World::warnings`].
//!
//! | module | contents |
//! |---|---|
//! | `xml`, `error`, `warnings` | reading with limits; errors; what is skipped |
//! | `sdf`, `read`, `frames`, `state`, `shape`, `sun` | the world as SDF has it |
//! | `search` | `model://` on the search path |
//! | `mesh` | COLLADA, OBJ, STL |
//! | `ogre`, `builtin`, `patterns`, `images`, `color`, `looks` | materials |
//! | `forms`, `relief`, `road`, `emit`, `classes` | triangles |
//! | `plates` | plates and doors |

mod builtin;
mod classes;
mod color;
mod emit;
mod error;
mod forms;
mod frames;
mod images;
mod looks;
mod mesh;
mod ogre;
mod patterns;
mod plates;
mod read;
mod relief;
mod road;
mod sdf;
mod search;
mod shape;
mod state;
mod sun;
mod warnings;
mod xml;

use std::path::PathBuf;

use nalgebra::{UnitQuaternion, Vector3};
use openbench_core::{Georeference, Pose2, Pose3};
use openbench_osm::{OsmData, OsmMap, default_georeference, renumbered, without_doors};

pub use error::{ImportError, ObjError};

use crate::world::MAX_FROM_ORIGIN_M;
use crate::{SceneBuilder, World};
use emit::Emitter;
use plates::{add_doors, plates_of, usual_start};
use read::SdfReader;
use search::SearchPath;
use warnings::Warnings;

/// A world to import.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportRequest {
    /// The `.world` file.
    pub world: PathBuf,
    /// The OSM map of the same place.
    pub map: PathBuf,
    /// Folders that are searched for `model://…`, in this order.
    pub models: Vec<PathBuf>,
    /// How the world lies on the Earth; by default from the middle of the map.
    pub georeference: Option<Georeference>,
    /// Start pose of robots, in the frame of the world file. By default its origin, or in front of
    /// the middle door if that is far from all doors.
    pub start: Option<Pose2>,
}

/// Imports a Gazebo world.
///
/// The world has its origin near the start. Where that is far from the origin of the file, as with
/// coordinates in raw UTM, [`World::georeference`] is the same projection with another offset, and
/// a warning says so.
///
/// # Errors
///
/// Files that are missing, broken or too large, and worlds without doors or a map; see
/// [`ImportError`].
pub fn import_world(request: &ImportRequest) -> Result<World, ImportError> {
    let data = OsmData::read(&request.map)?;
    let georeference = match request.georeference {
        Some(georeference) => georeference,
        None => default_georeference(&data).map_err(|source| ImportError::Georeference {
            path: request.map.clone(),
            source,
        })?,
    };
    let mut warnings = Warnings::default();
    data.report
        .notes()
        .into_iter()
        .for_each(|note| warnings.add(format!("{}: {note}", request.map.display())));
    let search = SearchPath::new(&request.models);
    let mut world = SdfReader {
        search: &search,
        warnings: &mut warnings,
        models: 0,
    }
    .world(&request.world)?;

    // In the frame of the file: start and origin depend on where the doors are.
    let mut plates = plates_of(&world.models);
    if plates.is_empty() {
        return Err(ImportError::NoDoors {
            path: request.world.clone(),
        });
    }
    let start = request.start.unwrap_or_else(|| usual_start(&plates));
    let local = georeference.near(start.point(), MAX_FROM_ORIGIN_M);
    if local != georeference {
        warnings.add(format!(
            "the origin of `{georeference}` is far from the start; coordinates of this world are \
             of `{local}`"
        ));
    }
    let map = OsmMap::new(&data, local);
    if map.buildings.is_empty() {
        return Err(ImportError::NoBuildings {
            path: request.map.clone(),
        });
    }

    let (from, to) = (georeference.offset(), local.offset());
    // In double precision, before triangles are made: in single precision, raw UTM coordinates have
    // steps of up to half a metre.
    let shift = Vector3::new(to.x - from.x, to.y - from.y, 0.0);
    let moved = Pose3::from_parts(shift.into(), UnitQuaternion::identity());
    world.roads.iter_mut().for_each(|road| road.shift(&shift));
    plates
        .iter_mut()
        .for_each(|plate| plate.pose = moved * plate.pose);
    let mut builder = SceneBuilder::new();
    let mut emitter = Emitter::new(&search, &request.world, &mut builder, &mut warnings);
    for model in &world.models {
        emitter.model(model, &moved, &Vector3::repeat(1.0))?;
    }
    // After the models, among which is the ground that roads lie on.
    emitter.roads(&world.roads)?;
    add_doors(&mut builder, &plates, &map, &mut warnings);
    if let Some(sun) = world.sun {
        builder.set_sun(sun);
    }
    Ok(World {
        doors: None,
        plates: None,
        scenery: None,
        name: request
            .world
            .file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
        scene: builder.build(),
        map: renumbered(&without_doors(&data)),
        georeference: local,
        start: Pose2::new(start.x + shift.x, start.y + shift.y, start.yaw),
        attribution: vec![
            "Gazebo models: Open Source Robotics Foundation, CC BY 3.0".to_owned(),
            "Map: © OpenStreetMap contributors, ODbL".to_owned(),
        ],
        warnings: warnings.into_lines(),
    })
}
