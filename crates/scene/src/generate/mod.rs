//! Worlds from an OSM file and a seed.
//!
//! What the map has is built as it is mapped: outlines, levels, roofs, entrances, roads, barriers,
//! trees, furniture. What it leaves open is drawn from the seed: colours, windows, parked cars,
//! shrubs. Every element draws from a stream of its own, so that one more tree in the map does not
//! repaint the houses. The same map, seed and options give the same bytes on every machine.
//!
//! The ground is level: slopes, bridges and tunnels are left out, and kerbs are raised where the
//! map has them as lines of their own (`barrier=kerb`), and where the scenery has them. A robot
//! cannot get into water: a low wall goes around it.
//!
//! A world is generated in three stages. `Inputs` are computed of the map and then immutable.
//! Generators, which are functions of them, build an `Output`. Scene and public map become a
//! [`World`]. Generators depend on each other in one way only: objects give way to those that were
//! placed before, which are recorded in `Occupied`.
//!
//! A new kind of thing is a new file in the folder in which a reader looks for it, and a line in
//! the list `FIXED` or `PLACED`. If it draws random numbers, it also gets a `Purpose` in `seeds`.
//!
//! | module | contents |
//! |---|---|
//! | `options`, `error`, `builtin` | settings; why there is no world; the worlds of the crate |
//! | `inputs`, `output` | what generators read, and what they build |
//! | `hung` | plates and signs on walls, poles and cars |
//! | `seeds` | streams of random numbers |
//! | `layout` | where things are: extent, roads by place, free ground, the start |
//! | `materials`, `shapes` | materials and textures; boxes, bands, outlines |
//! | `ground`, `water` | the ground, areas on it, the horizon; the sea, lakes, quays |
//! | `streets` | roads and paths, their wear and markings, parked cars |
//! | `buildings`, `doors` | walls, windows, roofs; doors with addresses and plates |
//! | `barriers` | walls, fences, kerbs, and gates in them |
//! | `furniture`, `greenery` | lamps, benches, bins; trees, shrubs, hedges |
//! | `scenery` | what makes streets differ: varied ground, things in the way, steps, kerbs |

mod barriers;
mod buildings;
mod builtin;
mod doors;
mod error;
mod furniture;
mod greenery;
mod ground;
mod hung;
mod inputs;
mod layout;
mod materials;
mod options;
mod output;
mod scenery;
mod seeds;
mod shapes;
mod streets;
mod water;

use openbench_core::{Georeference, MapPoint, Pose2};
use openbench_geometry::Segment;
use openbench_osm::{OsmData, OsmMap, renumbered, without_doors};

pub use builtin::{builtin, builtin_georeference, builtin_names, builtin_with};
pub use error::GenerateError;
pub use options::{Alterations, GenerateOptions, PlateOptions, SceneryOptions};
pub use streets::car::car_figure;

use crate::scene::SceneBuilder;
use crate::world::{MAX_FROM_ORIGIN_M, World};
use doors::drawn::Draw;
use doors::entrances;
use doors::neighbourhood::Neighbourhood;
use inputs::Inputs;
use layout::extent::{GROUND_MARGIN_M, extent_of};
use layout::lanes::Lanes;
use layout::occupied::Occupied;
use layout::{features, keep_free, start};
use materials::palette::Palette;
use output::{Limits, Output};
use scenery::planned;
use scenery::site::Site;
use water::{coast, quays};

/// Above so many buildings windows lose their sills and hedges their dents: a town has a hundred
/// thousand of them.
const MOST_DETAILED: usize = 400;

/// Things that are built where the map has them, in this order, even if they overlap. Triangles and
/// the numbers of objects follow this order, so another order makes another world.
const FIXED: [fn(&Inputs, &mut Output); 13] = [
    ground::terrain::build,
    ground::horizon::build,
    scenery::grounds::build,
    scenery::wells::build,
    scenery::steps::build,
    ground::aprons::build,
    ground::covers::build,
    streets::roads::build,
    streets::wear::build,
    streets::markings::build,
    water::quays::build,
    buildings::build,
    barriers::build,
];

/// Things that give way to what the map keeps free and to objects that were placed before; in this
/// order. Mapped things come first: what the seed adds gives way to them.
const PLACED: [fn(&Inputs, &mut Occupied, &mut Output); 12] = [
    furniture::mapped::build,
    greenery::mapped_trees::build,
    greenery::tree_rows::build,
    streets::parked_cars::build,
    greenery::woods::build,
    furniture::bins::build,
    greenery::shrubs::build,
    greenery::backdrop::build,
    greenery::planting::build,
    // Late, so that no other thing moves where a world gets signs, or things in the way.
    furniture::signs::build,
    scenery::kerbs::build,
    scenery::clutter::build,
];

/// Generates a world of a map: scene, doors, public map without doors, start.
///
/// The world has its origin near the start. Where `georeference` has it elsewhere,
/// [`World::georeference`] is the same projection with another offset, and a warning says so. The
/// same map, seed and options therefore give the same world wherever the false origin lies.
///
/// # Example
///
/// A house of 11 m by 8 m in a street of Krems an der Donau, without a mapped entrance:
///
/// ```
/// use openbench_osm::OsmData;
/// use openbench_scene::generate::{GenerateOptions, generate};
///
/// let xml = r#"<osm version="0.6">
///   <node id="1" lat="48.41100" lon="15.60300"/><node id="2" lat="48.41100" lon="15.60315"/>
///   <node id="3" lat="48.41107" lon="15.60315"/><node id="4" lat="48.41107" lon="15.60300"/>
///   <node id="5" lat="48.41090" lon="15.60200"/><node id="6" lat="48.41090" lon="15.60400"/>
///   <way id="10"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
///     <tag k="building" v="house"/><tag k="building:levels" v="2"/></way>
///   <way id="11"><nd ref="5"/><nd ref="6"/>
///     <tag k="highway" v="residential"/><tag k="name" v="Ringstraße"/></way>
/// </osm>"#;
/// let data = OsmData::from_xml(xml.as_bytes())?;
/// let georeference = openbench_osm::default_georeference(&data)?;
/// let world = generate(&data, georeference, 1, &GenerateOptions::default())?;
///
/// // The house gets a door towards the street, and a number in it.
/// assert_eq!(world.scene.doors.len(), 1);
/// assert!(world.scene.doors[0].address.building.starts_with("Ringstraße "));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Maps without buildings, maps that are too large or lie where the georeference distorts lengths,
/// and maps without a clear place to start at; see [`GenerateError`].
pub fn generate(
    data: &OsmData,
    georeference: Georeference,
    seed: u64,
    options: &GenerateOptions,
) -> Result<World, GenerateError> {
    let anchor = match options.start {
        Some(start) => start.point(),
        None => extent_of(&OsmMap::new(data, georeference), georeference)?.middle(),
    };
    // Where the robot starts is known only afterwards. If that is far from the anchor, the world is
    // generated again about the start: moving finished triangles would round them once more.
    let mut world = generate_about(anchor, data, georeference, seed, options)?;
    if world.start.point().distance(MapPoint::default()) > MAX_FROM_ORIGIN_M {
        let from = world.georeference.offset();
        let start = moved(world.start, from, georeference.offset()).point();
        world = generate_about(start, data, georeference, seed, options)?;
    }
    if world.georeference != georeference {
        world.warnings.push(format!(
            "the origin of `{georeference}` is far from the start; coordinates of this world are \
             of `{}`",
            world.georeference
        ));
    }
    Ok(world)
}

/// The world with its origin near `anchor`, which is a point of the frame of `georeference`.
fn generate_about(
    anchor: MapPoint,
    data: &OsmData,
    georeference: Georeference,
    seed: u64,
    options: &GenerateOptions,
) -> Result<World, GenerateError> {
    // The lattice of false origins depends on the place alone, so any georeference leads to the
    // same world.
    let local = georeference.near(anchor, MAX_FROM_ORIGIN_M);
    let (from, to) = (georeference.offset(), local.offset());
    let start = options.start.map(|start| moved(start, from, to));
    let options = GenerateOptions {
        start,
        ..options.clone()
    };
    generate_within(Limits::USUAL, data, local, seed, &options)
}

/// A pose of the frame whose false origin is `from`, in the frame whose false origin is `to`.
fn moved(pose: Pose2, from: MapPoint, to: MapPoint) -> Pose2 {
    Pose2::new(pose.x - from.x + to.x, pose.y - from.y + to.y, pose.yaw)
}

/// The world in the frame of `georeference`, with at most so many triangles.
fn generate_within(
    limits: Limits,
    data: &OsmData,
    georeference: Georeference,
    seed: u64,
    options: &GenerateOptions,
) -> Result<World, GenerateError> {
    let map = OsmMap::new(data, georeference);
    let extent = extent_of(&map, georeference)?;
    let sea = coast::sea(data, &map, extent.grown(GROUND_MARGIN_M));
    // What is computed first restricts what follows: doors look for walls that the map leaves free,
    // walls around water avoid nothing, and the start avoids all of them.
    let mut clearance = keep_free::of_map(&map, &sea);
    let lanes = Lanes::new(&map.roads, |_| true);
    let quays = quays::lines(&map, &lanes, &sea, &clearance, extent);
    let mut public = without_doors(data);
    let seed_of_doors = options.drawn_doors.filter(|_| options.invent_doors);
    let draw = seed_of_doors.map(|seed| Draw {
        seed,
        reach: start::reach_of_streets(&map, extent, walls_of(&map, &lanes, &quays).into_iter()),
    });
    // The public map loses its doors and gets the names of buildings by which doors are ordered.
    let placed = entrances::place(&map, &mut public, seed, options, &clearance, draw.as_ref());
    let doorways = placed.doorways;
    keep_free::add_doorways(&mut clearance, &doorways);
    let start = match options.start {
        // A start that is asked for is taken as it is, free or not.
        Some(start) => start,
        None => {
            let walls = walls_of(&map, &lanes, &quays);
            start::choose(&map, &clearance, extent, &doorways, walls.into_iter())?
        }
    };
    keep_free::add_start(&mut clearance, start.point());
    let features = features::features(data, &map);
    let relief = planned::plan(&Site {
        map: &map,
        clearance: &clearance,
        doorways: &doorways,
        ground: ground::terrain::rim_of(extent),
        gates: &scenery::site::gates(&map),
        features: &features,
        options: &options.scenery,
        has_sea: !sea.is_empty(),
    });
    relief.keep_free(&mut clearance);
    let mut scene = SceneBuilder::new();
    let inputs = Inputs {
        neighbourhood: Neighbourhood::of(&map, &doorways),
        features,
        tree_rows: features::tree_rows(data, &map),
        palette: Palette::new(&mut scene, seed),
        detailed: map.buildings.len() <= MOST_DETAILED,
        map: &map,
        sea,
        quays,
        doorways,
        lanes,
        extent,
        clearance,
        relief,
        seed,
        options,
    };
    let warnings = [placed.warnings, report(&map)].concat();
    let mut out = Output::new(scene, warnings, limits);
    for build in FIXED {
        build(&inputs, &mut out);
    }
    // From here on each thing records its ground, and later ones keep off it.
    let mut occupied = Occupied::new(&inputs.clearance);
    inputs.relief.occupy(&mut occupied);
    for build in PLACED {
        build(&inputs, &mut occupied, &mut out);
    }
    let finished = out.finish();
    Ok(World {
        name: options.name.clone(),
        scene: finished.scene,
        // Agents get the map without its doors: those are what they have to find.
        map: renumbered(&public),
        georeference,
        start,
        attribution: options.attribution.clone(),
        doors: placed.drawn,
        plates: finished.plates.filter(|_| options.plates.shares.real),
        scenery: Some(finished.scenery).filter(|_| !options.scenery.amounts.is_plain()),
        warnings: finished.warnings,
    })
}

/// What stops a robot: walls of buildings, barriers, and walls around water.
fn walls_of(map: &OsmMap, lanes: &Lanes, quays: &[Segment]) -> Vec<Segment> {
    let sides = map.buildings.iter().flat_map(|b| b.polygon.sides());
    let standing = barriers::standing(map, lanes);
    sides.chain(standing).chain(quays.iter().copied()).collect()
}

/// Descriptions of what is broken in the map itself.
fn report(map: &OsmMap) -> Vec<String> {
    let counts = [
        (
            map.report.broken_buildings,
            "buildings without a closed outline were left out",
        ),
        (
            map.report.broken_areas,
            "areas without a closed outline were left out",
        ),
        (
            map.report.long_lines,
            "roads and barriers have too many nodes and were left out",
        ),
        (
            map.report.open_rings,
            "rings of multipolygons do not close and were left out",
        ),
        (
            map.report.stray_entrances,
            "entrances are near no building and got no door",
        ),
    ];
    counts
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, words)| format!("{n} {words}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::builtin::builtin_map;
    use super::*;

    #[test]
    fn a_world_that_would_be_too_large_is_bounded_and_warns() {
        let data = builtin_map("large").unwrap().unwrap();
        let options = GenerateOptions {
            start: Some(Pose2::default()),
            ..GenerateOptions::default()
        };
        let within = |ornate, bare| {
            let limits = Limits { ornate, bare };
            generate_within(limits, &data, builtin_georeference(), 1, &options).unwrap()
        };
        let whole = within(Limits::USUAL.ornate, Limits::USUAL.bare);
        assert!(whole.warnings.is_empty(), "{:?}", whole.warnings);
        // No more ornaments than the limit has room for, but every door and its plate.
        let plain = within(5_000, 1_000_000);
        let triangles = plain.scene.triangles.len();
        assert!(triangles < whole.scene.triangles.len() / 3, "{triangles}");
        assert_eq!(plain.scene.doors.len(), whole.scene.doors.len());
        let warns = plain.warnings.iter().any(|w| w.contains("5000 triangles"));
        assert!(warns, "{:?}", plain.warnings);
        // What is beyond the second limit is counted.
        let cut = within(2_000, 4_000);
        assert!(
            cut.scene.triangles.len() < 8_000,
            "{}",
            cut.scene.triangles.len()
        );
        let left_out = "buildings and streets are beyond 4000";
        let warning = cut.warnings.iter().find(|w| w.contains(left_out));
        assert!(
            warning.is_some_and(|w| !w.starts_with("0 ")),
            "{:?}",
            cut.warnings
        );
    }
}
