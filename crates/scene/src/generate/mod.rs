//! Worlds from an OSM file and a seed.
//!
//! What the map says is built as it says (outlines, levels, roofs, entrances, roads, barriers, trees, furniture); what it
//! leaves open (colours, windows, parked cars, shrubs) is drawn from the seed. Every element draws from a stream of its
//! own, so that one more tree in the map does not repaint the houses. The same map, seed and options give the same bytes
//! on every machine. The ground is level: slopes, bridges and tunnels are left out, and kerbs are raised where the map has them as
//! lines of their own (`barrier=kerb`). A robot cannot
//! get into water: a low wall goes round it.
//!
//! | module | its one job |
//! |---|---|
//! | `builtin` | the three worlds that the crate carries |
//! | `images`, `openings` | procedural textures: walls and grounds; windows, doors, leaves |
//! | `palette` | the materials of a world |
//! | `shapes` | boxes, prisms, strips, filled outlines |
//! | `clearance` | what must stay free, and whether a thing would stand in the way |
//! | `streets`, `markings`, `wear` | carriageways, pavements, paths; lines on them; mended places and drains |
//! | `ground` | the ground, and the hills on the horizon |
//! | `coast`, `water` | the sea; what keeps a robot out of it |
//! | `lanes` | the roads' segments by place |
//! | `entrances`, `naming` | where the doors are; what their buildings are called |
//! | `buildings`, `parts` | houses, and those whose parts are mapped |
//! | `facades`, `windows`, `roofs`, `doorways` | their walls, windows and shops, roofs and doors |
//! | `barriers`, `hedges`, `greenery`, `trees`, `furniture`, `cars` | what stands between them |
//! | `start`, `reach` | where the robot starts; which ground hangs together |

mod barriers;
mod buildings;
mod builtin;
mod cars;
mod clearance;
mod coast;
mod doorways;
mod entrances;
mod facades;
mod furniture;
mod greenery;
mod ground;
mod hedges;
mod images;
mod lanes;
mod markings;
mod naming;
mod openings;
mod palette;
mod parts;
mod reach;
mod roofs;
mod seeds;
mod shapes;
mod start;
mod streets;
mod trees;
mod water;
mod wear;
mod windows;

use std::collections::BTreeMap;

use openbench_core::{Georeference, MapPoint, Pose2};
use openbench_osm::polygon::Bounds;
use openbench_osm::{ElementKind, OsmData, OsmMap, Polygon, Tags, without_doors};

pub use builtin::{builtin, builtin_georeference, builtin_map, builtin_names};
pub use cars::car_figure;

use crate::material::MaterialId;
use crate::scene::SceneBuilder;
use crate::world::MAX_FROM_ORIGIN_M;
use crate::world::World;
use clearance::Clearance;
use entrances::Doorway;
use lanes::Lanes;
use palette::Palette;

/// Largest extent of a map that is built, metres.
const MAX_EXTENT: f64 = 20_000.0;
/// Farther than this from UTM's central meridian lengths are half a percent too long, metres.
const MAX_FROM_MERIDIAN_M: f64 = 640_000.0;
/// Farther than this from the point at which a plane touches the Earth lengths are half a percent too short, metres.
const MAX_FROM_TOUCH_M: f64 = 640_000.0;
/// Most buildings in a world.
const MAX_BUILDINGS: usize = 30_000;
/// Above so many buildings windows lose their sills and hedges their dents: a town has a hundred thousand of them.
const DETAILED: usize = 400;
/// Ground beyond the outermost mapped thing, metres.
const GROUND_MARGIN: f64 = 80.0;

/// What a map leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct GenerateOptions {
    /// Name of the world, as in results.
    pub name: String,
    /// Where robots start, in the frame of the requested georeference; by default a clear place on a pavement or path, in the middle of the doors, from
    /// which most of them are reached.
    pub start: Option<Pose2>,
    /// Share of the parking places with a car in them, 0 to 1.
    pub parked_cars: f64,
    /// How much greenery is added to the map's own, 0 to 1.
    pub planting: f64,
    /// Whether a building without a mapped entrance gets a door towards the street.
    pub invent_doors: bool,
    /// Licences and authors of the map, handed on to the world.
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

/// Why no world could be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GenerateError {
    /// Nothing to deliver to.
    #[error(
        "the map has no usable building ({broken} have broken outlines); give a map with `building=*` outlines"
    )]
    NoBuildings {
        /// Buildings without a closed outline.
        broken: usize,
    },
    /// The map is no neighbourhood.
    #[error("the map is {metres:.0} m across, more than {MAX_EXTENT:.0} m; cut out a neighbourhood")]
    TooLarge {
        /// Its longer side.
        metres: f64,
    },
    /// The map is a whole town.
    #[error("the map has {buildings} buildings, more than {MAX_BUILDINGS}; cut out a neighbourhood")]
    TooMany {
        /// How many.
        buildings: usize,
    },
    /// The georeference belongs to another place: its projection distorts lengths here.
    #[error(
        "the map lies {metres:.0} m from where `{georeference}` keeps lengths; give the UTM zone of this map, or a \
         tangent plane that touches the Earth near it"
    )]
    Distorted {
        /// Distance of the middle of the map from the central meridian or the point of touch.
        metres: f64,
        /// What was given.
        georeference: String,
    },
    /// No place for the robot.
    #[error("no clear place to start at was found near a road or path; give a start")]
    NoStart,
    /// A map that the crate carries is broken.
    #[error("built-in world `{name}`: {problem}")]
    Builtin {
        /// Which.
        name: String,
        /// What is wrong with it.
        problem: String,
    },
}

/// How many visible triangles a world may have: about 150 bytes of memory each, with all that is made of them.
#[derive(Debug, Clone, Copy)]
struct Limits {
    /// From so many on it gets no more windows, lines, fences, trees and cars: walls, roofs, doors and streets only.
    ornate: usize,
    /// From so many on it gets nothing more at all.
    bare: usize,
}

impl Limits {
    const USUAL: Self = Self { ornate: 8_000_000, bare: 10_000_000 };
}

/// A rectangle along the axes of the `map` frame.
#[derive(Debug, Clone, Copy)]
struct Extent {
    min: MapPoint,
    max: MapPoint,
}

/// A world under construction.
struct Site {
    map: OsmMap,
    /// Tagged nodes that stand for things: trees, lamps, crossings.
    features: Vec<Feature>,
    /// Lines of trees, by number of the way.
    tree_rows: Vec<(i64, Vec<MapPoint>)>,
    sea: Vec<Polygon>,
    /// Lines of the low walls round water.
    kerbs: Vec<(MapPoint, MapPoint)>,
    doorways: Vec<Doorway>,
    extent: Extent,
    seed: u64,
    options: GenerateOptions,
    builder: SceneBuilder,
    palette: Palette,
    /// Materials of plates by text.
    plates: BTreeMap<String, MaterialId>,
    clearance: Clearance,
    /// Every road's segments.
    lanes: Lanes,
    start: Pose2,
    warnings: Vec<String>,
    limits: Limits,
    /// Whether there are so few buildings that each is worth more triangles.
    detailed: bool,
    /// Buildings and streets beyond the limit.
    left_out: usize,
}

/// A node with tags.
struct Feature {
    node: i64,
    position: MapPoint,
    tags: Tags,
}

/// Makes a world of a map: scene, doors, public map without doors, start.
///
/// The world has its origin near the start. Where `georeference` has it elsewhere, [`World::georeference`] is the same
/// projection with another offset, and a warning says so. The same map, seed and options therefore give the same
/// world wherever the false origin lies.
pub fn generate(
    data: &OsmData,
    georeference: Georeference,
    seed: u64,
    options: &GenerateOptions,
) -> Result<World, GenerateError> {
    let anchor = match options.start {
        Some(start) => start.point(),
        None => extent(&OsmMap::new(data, georeference), georeference)?.middle(),
    };
    let mut world = generate_about(anchor, data, georeference, (seed, options))?;
    if world.start.point().distance(MapPoint::default()) > MAX_FROM_ORIGIN_M {
        let from = world.georeference.offset();
        let start = moved(world.start, from, georeference.offset()).point();
        world = generate_about(start, data, georeference, (seed, options))?;
    }
    if world.georeference != georeference {
        world.warnings.push(format!(
            "the origin of `{georeference}` is far from the start; coordinates of this world are of `{}`",
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
    (seed, options): (u64, &GenerateOptions),
) -> Result<World, GenerateError> {
    let local = georeference.near(anchor, MAX_FROM_ORIGIN_M);
    let (from, to) = (georeference.offset(), local.offset());
    let start = options.start.map(|start| moved(start, from, to));
    generate_within(Limits::USUAL, data, local, (seed, &GenerateOptions { start, ..options.clone() }))
}

/// A pose of the frame whose false origin is `from`, in the frame whose false origin is `to`.
fn moved(pose: Pose2, from: MapPoint, to: MapPoint) -> Pose2 {
    Pose2::new(pose.x - from.x + to.x, pose.y - from.y + to.y, pose.yaw)
}

fn generate_within(
    limits: Limits,
    data: &OsmData,
    georeference: Georeference,
    (seed, options): (u64, &GenerateOptions),
) -> Result<World, GenerateError> {
    let map = OsmMap::new(data, georeference);
    let extent = extent(&map, georeference)?;
    let mut public = without_doors(data);
    let features = features(data, &map);
    let mut clearance = Clearance::of_map(&map);
    let sea = coast::sea(data, &map, extent.grown(GROUND_MARGIN));
    sea.iter().for_each(|water| clearance.add_area(water.clone(), clearance::WATER));
    let (doorways, mut warnings) = entrances::place(&map, &mut public, (seed, options), &clearance);
    clearance.add_doorways(&doorways);
    let lanes = Lanes::new(&map.roads, |_| true);
    let kerbs = water::kerbs((&map, &lanes), &sea, (&clearance, extent));
    let standing = barriers::standing(&map, &lanes).into_iter().chain(kerbs.iter().copied());
    let walls = map.buildings.iter().flat_map(|b| b.polygon.sides());
    let walls = walls.map(|wall| (wall.start, wall.end)).chain(standing);
    let start = start::choose(&map, (&clearance, extent), (&doorways, walls), options)?;
    clearance.add_start(start.point());
    warnings.extend(report(&map));
    let mut builder = SceneBuilder::new();
    let palette = Palette::new(&mut builder, seed);
    let options = options.clone();
    let tree_rows = tree_rows(data, &map);
    let mut site = Site {
        detailed: map.buildings.len() <= DETAILED,
        limits,
        left_out: 0,
        map,
        features,
        tree_rows,
        sea,
        kerbs,
        doorways,
        extent,
        seed,
        options,
        builder,
        palette,
        plates: BTreeMap::new(),
        clearance,
        lanes,
        start,
        warnings,
    };
    site.build();
    Ok(World {
        name: site.options.name,
        scene: site.builder.build(),
        map: public,
        georeference,
        start: site.start,
        attribution: site.options.attribution,
        warnings: site.warnings,
    })
}

impl Site {
    fn build(&mut self) {
        self.ground();
        self.horizon();
        self.streets();
        self.kerbs();
        self.buildings();
        self.barriers();
        // Mapped things first: what the seed adds gives way to them.
        self.furniture();
        self.mapped_trees();
        self.tree_rows();
        self.parked_cars();
        self.woods();
        self.bins();
        self.added_greenery();
        if self.is_full() {
            self.warnings.push(format!(
                "the map is more than {} triangles; windows, fences, trees and cars beyond that were left out",
                self.limits.ornate
            ));
        }
        if self.left_out > 0 {
            self.warnings.push(format!(
                "{} buildings and streets are beyond {} triangles and were left out; cut out a neighbourhood",
                self.left_out, self.limits.bare
            ));
        }
    }

    /// Whether there is no room for more than walls, roofs, doors and streets.
    fn is_full(&self) -> bool {
        self.builder.triangles() >= self.limits.ornate
    }
}

fn extent(map: &OsmMap, georeference: Georeference) -> Result<Extent, GenerateError> {
    if map.buildings.is_empty() {
        return Err(GenerateError::NoBuildings { broken: map.report.broken_buildings });
    }
    if map.buildings.len() > MAX_BUILDINGS {
        return Err(GenerateError::TooMany { buildings: map.buildings.len() });
    }
    // Roads and areas may reach far out of a cut-out; the buildings say where the neighbourhood is.
    let mut extent = Extent {
        min: MapPoint::new(f64::INFINITY, f64::INFINITY),
        max: MapPoint::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };
    for p in map.buildings.iter().flat_map(|b| &b.polygon.outer) {
        extent.min = MapPoint::new(extent.min.x.min(p.x), extent.min.y.min(p.y));
        extent.max = MapPoint::new(extent.max.x.max(p.x), extent.max.y.max(p.y));
    }
    let metres = (extent.max.x - extent.min.x).max(extent.max.y - extent.min.y);
    if metres > MAX_EXTENT {
        return Err(GenerateError::TooLarge { metres });
    }
    let metres = georeference.distance_from_true_scale(extent.middle());
    let limit = match georeference {
        Georeference::Utm { .. } => MAX_FROM_MERIDIAN_M,
        Georeference::TangentPlane { .. } => MAX_FROM_TOUCH_M,
    };
    if metres.is_nan() || metres > limit {
        return Err(GenerateError::Distorted { metres, georeference: georeference.to_string() });
    }
    Ok(extent)
}

impl Extent {
    fn middle(self) -> MapPoint {
        MapPoint::new((self.min.x + self.max.x) / 2.0, (self.min.y + self.max.y) / 2.0)
    }

    fn grown(self, margin: f64) -> Self {
        let (min, max) = (self.min, self.max);
        Self {
            min: MapPoint::new(min.x - margin, min.y - margin),
            max: MapPoint::new(max.x + margin, max.y + margin),
        }
    }

    /// Whether a polygon may have something in common with the rectangle grown by `margin` metres.
    fn meets(self, polygon: &Polygon, margin: f64) -> bool {
        let Bounds { low, high } = polygon.bounds();
        let (min, max) = (self.min, self.max);
        low.x <= max.x + margin
            && high.x >= min.x - margin
            && low.y <= max.y + margin
            && high.y >= min.y - margin
    }

    /// Whether `point` is inside the rectangle grown by `margin` metres.
    fn holds(self, point: MapPoint, margin: f64) -> bool {
        let inside = |v: f64, low: f64, high: f64| v >= low - margin && v <= high + margin;
        inside(point.x, self.min.x, self.max.x) && inside(point.y, self.min.y, self.max.y)
    }
}

fn features(data: &OsmData, map: &OsmMap) -> Vec<Feature> {
    let kinds = ["natural", "highway", "amenity", "emergency", "barrier", "power", "leisure"];
    let tagged = data.nodes.values().filter(|n| kinds.iter().any(|k| n.tags.says(k)));
    tagged
        .map(|n| Feature { node: n.id, position: map.projection.to_map(n.position), tags: n.tags.clone() })
        .collect()
}

fn tree_rows(data: &OsmData, map: &OsmMap) -> Vec<(i64, Vec<MapPoint>)> {
    let point = |n: &i64| data.nodes.get(n).map(|n| map.projection.to_map(n.position));
    let rows = data.ways.values().filter(|way| way.tags.is("natural", "tree_row"));
    rows.map(|way| (way.id, way.nodes.iter().filter_map(point).collect())).collect()
}

fn report(map: &OsmMap) -> Vec<String> {
    let counts = [
        (map.report.broken_buildings, "buildings without a closed outline were left out"),
        (map.report.broken_areas, "areas without a closed outline were left out"),
        (map.report.open_rings, "rings of multipolygons do not close and were left out"),
        (map.report.stray_entrances, "entrances are near no building and got no door"),
    ];
    counts.iter().filter(|(n, _)| *n > 0).map(|(n, words)| format!("{n} {words}")).collect()
}

/// A number for an element, so that a way and a relation with one number draw different streams.
fn element_number(element: openbench_osm::ElementId) -> u64 {
    let kind = match element.kind {
        ElementKind::Node => 0,
        ElementKind::Way => 1,
        ElementKind::Relation => 2,
    };
    (element.id as u64).wrapping_mul(3).wrapping_add(kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_that_would_be_too_large_is_bounded_and_says_so() {
        let data = builtin_map("large").unwrap().unwrap();
        let options = GenerateOptions { start: Some(Pose2::default()), ..GenerateOptions::default() };
        let within = |ornate, bare| {
            generate_within(Limits { ornate, bare }, &data, builtin_georeference(), (1, &options)).unwrap()
        };
        let whole = within(Limits::USUAL.ornate, Limits::USUAL.bare);
        assert!(whole.warnings.is_empty(), "{:?}", whole.warnings);
        // No more ornaments than the limit has room for, but every door and its plate.
        let plain = within(5_000, 1_000_000);
        assert!(
            plain.scene.triangles.len() < whole.scene.triangles.len() / 3,
            "{}",
            plain.scene.triangles.len()
        );
        assert_eq!(plain.scene.doors.len(), whole.scene.doors.len());
        assert!(plain.warnings.iter().any(|w| w.contains("5000 triangles")), "{:?}", plain.warnings);
        // What is beyond the second is counted.
        let cut = within(2_000, 4_000);
        assert!(cut.scene.triangles.len() < 8_000, "{}", cut.scene.triangles.len());
        let said = cut.warnings.iter().find(|w| w.contains("buildings and streets are beyond 4000"));
        assert!(said.is_some_and(|w| !w.starts_with("0 ")), "{:?}", cut.warnings);
    }
}
