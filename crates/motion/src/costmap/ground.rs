//! The layer of the map: obstacles, and which kind of ground lies between them.

use openbench_core::MapPoint;
use openbench_geometry::Polygon;
use openbench_geometry::grid::GridGeometry;
use openbench_geometry::{Bounds, Segment};
use openbench_osm::{Area, Barrier, OsmMap, Road, Tags};

/// Half the width of the gap that a gate leaves in a barrier, metres.
const GATE_M: f64 = 1.0;
/// Roads are drawn in pieces no longer than this, metres: the box around a long diagonal one holds
/// many cells that it does not touch.
const PIECE_M: f64 = 5.0;
/// Widest plausible road, metres.
const WIDEST_M: f64 = 60.0;

/// The kind of ground of a cell by the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Surface {
    /// The map says nothing.
    #[default]
    Unknown,
    /// Grass, flower beds, woods.
    Green,
    /// Ground where cars drive or park.
    Road,
    /// Pavements, footways, squares.
    Pavement,
}

/// The obstacle in a cell by the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum MappedObstacle {
    /// None.
    #[default]
    No,
    /// A building, wall or fence: where a beam passes through, it is not there.
    Solid,
    /// Water: beams pass over it whether or not it is there.
    Water,
}

/// Cost of driving over each kind of ground, as a multiple of the cheapest: at least 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preferences {
    /// Pavements, footways, squares.
    pub pavement: f32,
    /// Ground of which the map says nothing.
    pub unknown: f32,
    /// Where cars drive or park.
    pub road: f32,
    /// Grass, flower beds, woods.
    pub green: f32,
}

impl Preferences {
    /// All ground costs the same.
    pub const NONE: Self = Self {
        pavement: 1.0,
        unknown: 1.0,
        road: 1.0,
        green: 1.0,
    };
    /// The most that any ground may cost.
    pub const DEAREST: f32 = 20.0;

    /// Cost of driving over a surface.
    pub(crate) fn of(&self, surface: Surface) -> f32 {
        match surface {
            Surface::Unknown => self.unknown,
            Surface::Green => self.green,
            Surface::Road => self.road,
            Surface::Pavement => self.pavement,
        }
    }

    /// Whether all are from 1 to [`Preferences::DEAREST`].
    pub fn is_sound(&self) -> bool {
        let all = [self.pavement, self.unknown, self.road, self.green];
        all.iter().all(|cost| (1.0..=Self::DEAREST).contains(cost))
    }
}

impl Default for Preferences {
    /// Worth a detour of a fifth to stay off a carriageway, of a tenth to be on a pavement.
    fn default() -> Self {
        Self {
            pavement: 1.0,
            unknown: 1.1,
            road: 1.2,
            green: 1.2,
        }
    }
}

/// What a map says about each cell of a grid.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    /// The obstacle in each cell.
    pub(crate) obstacles: Vec<MappedObstacle>,
    /// The kind of ground of each cell.
    pub(crate) surface: Vec<Surface>,
}

impl Ground {
    /// Ground of which the map says nothing.
    pub(crate) fn unknown(cells: usize) -> Self {
        Self {
            obstacles: vec![MappedObstacle::No; cells],
            surface: vec![Surface::Unknown; cells],
        }
    }

    /// The ground of a map over a grid.
    pub(crate) fn of(map: &OsmMap, grid: &GridGeometry) -> Self {
        let mut drawing = Drawing {
            grid,
            ground: Self::unknown(grid.len()),
        };
        drawing.surfaces(map);
        drawing.obstacles(map);
        drawing.ground
    }
}

/// A map being drawn onto a grid.
struct Drawing<'a> {
    grid: &'a GridGeometry,
    ground: Ground,
}

impl Drawing<'_> {
    fn surfaces(&mut self, map: &OsmMap) {
        // Later kinds overwrite earlier ones: a path through a park is no lawn, and a pavement
        // along a carriageway is no road.
        for wanted in [Surface::Green, Surface::Road, Surface::Pavement] {
            for area in map
                .areas
                .iter()
                .filter(|area| surface_of_area(&area.tags) == Some(wanted))
            {
                self.fill(&area.polygon, |ground, cell| ground.surface[cell] = wanted);
            }
            for road in map
                .roads
                .iter()
                .filter(|road| surface_of_road(&road.tags) == wanted)
            {
                self.pave(road, wanted);
            }
        }
    }

    fn pave(&mut self, road: &Road, surface: Surface) {
        let half = width(&road.tags) / 2.0;
        for pair in road.points.windows(2) {
            // A road whose axis runs beside the grid may still reach into it.
            let Some(stretch) = self.cut(Segment::new(pair[0], pair[1]), half) else {
                continue;
            };
            let pieces = (stretch.length() / PIECE_M).ceil().max(1.0) as usize;
            for i in 0..pieces {
                let begin = stretch.at(i as f64 / pieces as f64);
                let end = stretch.at((i + 1) as f64 / pieces as f64);
                self.pave_piece(begin, end, half, surface);
            }
        }
    }

    fn pave_piece(&mut self, from: MapPoint, to: MapPoint, half: f64, surface: Surface) {
        let low = MapPoint::new(from.x.min(to.x) - half, from.y.min(to.y) - half);
        let high = MapPoint::new(from.x.max(to.x) + half, from.y.max(to.y) + half);
        let axis = Segment::new(from, to);
        for cell in self.grid.cells_between(low, high) {
            let middle = self.grid.center(cell);
            if axis.nearest_point(middle).point.distance(middle) <= half {
                self.ground.surface[cell] = surface;
            }
        }
    }

    fn obstacles(&mut self, map: &OsmMap) {
        let (kerbs, walls): (Vec<_>, Vec<_>) = map
            .barriers
            .iter()
            .partition(|b| b.tags.is("barrier", "kerb"));
        // First of all: openings in kerbs would open walls too.
        self.barriers(&kerbs);
        if !kerbs.is_empty() {
            self.crossings(map, MappedObstacle::Solid);
        }
        // Without water nothing is to be opened, and the walk along all roads is saved.
        let mut is_wet = false;
        for area in map.areas.iter().filter(|area| is_water(&area.tags)) {
            self.fill(&area.polygon, |ground, cell| {
                ground.obstacles[cell] = MappedObstacle::Water
            });
            is_wet = true;
        }
        if is_wet {
            self.crossings(map, MappedObstacle::Water);
            self.decks(map);
        }
        // After the water, which would overwrite them.
        for building in &map.buildings {
            self.fill(&building.polygon, |ground, cell| {
                ground.obstacles[cell] = MappedObstacle::Solid
            });
        }
        self.barriers(&walls);
    }

    /// Shows `set` every cell whose middle lies in a polygon, row by row between the sides that
    /// cross it (scan-line fill).
    fn fill(&mut self, polygon: &Polygon, mut set: impl FnMut(&mut Ground, usize)) {
        let Bounds { low, high } = polygon.bounds();
        let Some((_, rows)) = self.grid.window(low, high) else {
            return;
        };
        let mut cuts = Vec::new();
        for row in rows.0..=rows.1 {
            let y = self.grid.origin.y + (row as f64 + 0.5) * self.grid.cell;
            cuts.clear();
            // Half-open: a corner on the scan line belongs to one of its sides only, so that cuts
            // come in pairs.
            let crossing = polygon
                .sides()
                .filter(|side| (side.start.y > y) != (side.end.y > y));
            cuts.extend(
                crossing.map(|Segment { start: a, end: b }| {
                    a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x)
                }),
            );
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.chunks_exact(2) {
                let first = self.columns_before(pair[0]).ceil().max(0.0) as usize;
                let end = (self.columns_before(pair[1]).floor() + 1.0)
                    .clamp(0.0, self.grid.width as f64) as usize;
                // A pair may lie wholly beside the grid; `first` is beyond `end` then.
                for cell in first..end.max(first) {
                    set(&mut self.ground, row as usize * self.grid.width + cell);
                }
            }
        }
    }

    /// How many columns have their middle west of `x`, with the share of the next one.
    fn columns_before(&self, x: f64) -> f64 {
        (x - self.grid.origin.x) / self.grid.cell - 0.5
    }

    fn barriers(&mut self, barriers: &[&Barrier]) {
        for barrier in barriers {
            for pair in barrier.points.windows(2) {
                self.line(pair[0], pair[1]);
            }
            for gate in &barrier.gates {
                self.open(*gate, GATE_M, MappedObstacle::Solid);
            }
        }
    }

    /// Opens obstacles where roads and paths cross them. A kerb is lowered there, whether or not
    /// the map says so, and over water there is a bridge; beside the water there is none.
    fn crossings(&mut self, map: &OsmMap, over: MappedObstacle) {
        // Found before any is opened: what one road opens would be missing where the next one
        // crosses.
        let mut places = Vec::new();
        for road in &map.roads {
            for pair in road.points.windows(2) {
                let Some(stretch) = self.cut(Segment::new(pair[0], pair[1]), 0.0) else {
                    continue;
                };
                // A bridge is as wide as the road on it; a kerb is opened like a gate.
                let half = if over == MappedObstacle::Water {
                    width(&road.tags) / 2.0
                } else {
                    GATE_M
                };
                let blocked = self
                    .points_along(stretch)
                    .filter(|place| self.obstacle_at(*place) == over);
                places.extend(blocked.map(|place| Opening {
                    place,
                    half_width: half.max(GATE_M),
                }));
            }
        }
        for Opening { place, half_width } in places {
            self.open(place, half_width, over);
        }
    }

    /// Paved areas over water lie on a bridge or pier.
    fn decks(&mut self, map: &OsmMap) {
        for area in map.areas.iter().filter(|area| is_deck(area)) {
            self.fill(&area.polygon, |ground, cell| {
                if ground.obstacles[cell] == MappedObstacle::Water {
                    ground.obstacles[cell] = MappedObstacle::No;
                }
            });
        }
    }

    fn obstacle_at(&self, place: MapPoint) -> MappedObstacle {
        self.grid
            .cell_at(place)
            .map_or(MappedObstacle::No, |cell| self.ground.obstacles[cell])
    }

    /// Removes obstacles of a kind within `around` metres of a place: the LiDAR will see whether it
    /// is open.
    fn open(&mut self, place: MapPoint, around: f64, what: MappedObstacle) {
        let low = MapPoint::new(place.x - around, place.y - around);
        let high = MapPoint::new(place.x + around, place.y + around);
        for cell in self.grid.cells_between(low, high) {
            let is_near = self.grid.center(cell).distance(place) <= around;
            if is_near && self.ground.obstacles[cell] == what {
                self.ground.obstacles[cell] = MappedObstacle::No;
            }
        }
    }

    fn line(&mut self, from: MapPoint, to: MapPoint) {
        let Some(stretch) = self.cut(Segment::new(from, to), self.grid.cell) else {
            return;
        };
        for place in self.points_along(stretch) {
            let cell = self.grid.cell_at(place);
            // A fence in the water does not remove the water.
            if let Some(cell) =
                cell.filter(|cell| self.ground.obstacles[*cell] != MappedObstacle::Water)
            {
                self.ground.obstacles[cell] = MappedObstacle::Solid;
            }
        }
    }

    /// The part of a segment that lies within `around` metres of the grid, if any (Liang and
    /// Barsky, *A New Concept and Method for Line Clipping*, 1984).
    fn cut(&self, segment: Segment, around: f64) -> Option<Segment> {
        let Segment {
            start: from,
            end: to,
        } = segment;
        let (grid, low) = (self.grid, self.grid.origin);
        let high = MapPoint::new(
            low.x + grid.width as f64 * grid.cell + around,
            low.y + grid.height as f64 * grid.cell + around,
        );
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        // For each border: how fast the segment runs towards it, and how far inside its start is.
        let bounds = [
            (-dx, from.x - low.x + around),
            (dx, high.x - from.x),
            (-dy, from.y - low.y + around),
            (dy, high.y - from.y),
        ];
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (toward, room) in bounds {
            // Parallel to the border, and outside.
            if toward == 0.0 && room < 0.0 {
                return None;
            }
            // Infinite or NaN for a parallel segment, which uses it nowhere.
            let at = room / toward;
            match toward {
                d if d < 0.0 => enter = enter.max(at),
                d if d > 0.0 => leave = leave.min(at),
                _ => {}
            }
        }
        (enter <= leave).then(|| Segment::new(segment.at(enter), segment.at(leave)))
    }

    /// Points along a segment, both ends included, so close that no cell on it is missed by more
    /// than a corner: two on each side of a cell.
    fn points_along(&self, segment: Segment) -> impl Iterator<Item = MapPoint> + use<> {
        let steps = (segment.length() / self.grid.cell * 2.0).ceil().max(1.0) as usize;
        (0..=steps).map(move |i| segment.at(i as f64 / steps as f64))
    }
}

/// A place at which an obstacle is opened.
struct Opening {
    place: MapPoint,
    /// Metres.
    half_width: f64,
}

/// Whether an area, where it lies over water, is a bridge or pier.
fn is_deck(area: &Area) -> bool {
    let surface = surface_of_area(&area.tags);
    matches!(surface, Some(Surface::Pavement | Surface::Road))
        || says(&area.tags, "man_made", &["pier", "bridge"])
}

/// Whether a tag has one of some values.
fn says(tags: &Tags, key: &str, words: &[&str]) -> bool {
    tags.get(key).is_some_and(|word| words.contains(&word))
}

/// Highways for pedestrians (OSM wiki, *Key:highway*).
const FOOT: [&str; 7] = [
    "footway",
    "pedestrian",
    "path",
    "steps",
    "corridor",
    "platform",
    "bridleway",
];
/// Values of `highway` on areas for pedestrians.
const SQUARES: [&str; 3] = ["pedestrian", "footway", "platform"];
/// Values of `landuse` that are green.
const GREEN_LAND: [&str; 12] = [
    "grass",
    "meadow",
    "forest",
    "village_green",
    "recreation_ground",
    "flowerbed",
    "orchard",
    "vineyard",
    "allotments",
    "cemetery",
    "farmland",
    "greenfield",
];
/// Values of `leisure` that are green.
const GREEN_LEISURE: [&str; 5] = ["park", "garden", "pitch", "golf_course", "nature_reserve"];
/// Values of `natural` that are green.
const GREEN_NATURE: [&str; 6] = ["grassland", "scrub", "wood", "heath", "shrubbery", "sand"];

/// The surface of a road.
fn surface_of_road(tags: &Tags) -> Surface {
    if says(tags, "highway", &FOOT) || tags.is("highway", "cycleway") {
        Surface::Pavement
    } else {
        Surface::Road
    }
}

/// The surface of an area, if it has one.
fn surface_of_area(tags: &Tags) -> Option<Surface> {
    if says(tags, "highway", &SQUARES)
        || says(tags, "area:highway", &FOOT)
        || tags.is("place", "square")
    {
        return Some(Surface::Pavement);
    }
    // Areas for pedestrians were sorted out above: the others with these keys are for vehicles.
    if tags.is("amenity", "parking") || tags.says("area:highway") || tags.says("highway") {
        return Some(Surface::Road);
    }
    let green = says(tags, "landuse", &GREEN_LAND)
        || says(tags, "leisure", &GREEN_LEISURE)
        || says(tags, "natural", &GREEN_NATURE);
    green.then_some(Surface::Green)
}

/// Whether an area is open water all year.
fn is_water(tags: &Tags) -> bool {
    let covered = tags.says("tunnel") || tags.says("covered") || tags.says("intermittent");
    let water = tags.is("natural", "water")
        || says(tags, "waterway", &["riverbank", "dock"])
        || says(tags, "landuse", &["basin", "reservoir"])
        || tags.is("leisure", "swimming_pool");
    // Basins that hold water only after rain are meadows.
    let dry = says(tags, "basin", &["detention", "infiltration"]);
    water && !covered && !dry
}

/// Width of a road, metres: as tagged, or as is usual for its kind.
fn width(tags: &Tags) -> f64 {
    let usual = || match tags.get("highway") {
        Some("motorway" | "trunk" | "primary") => 10.0,
        Some("secondary") => 8.0,
        Some("tertiary") => 7.0,
        Some("residential" | "unclassified") => 6.0,
        Some("pedestrian") => 5.0,
        Some("service" | "living_street" | "track" | "busway") => 4.0,
        _ => 2.0,
    };
    tags.metres("width")
        .filter(|width| (0.1..=WIDEST_M).contains(width))
        .unwrap_or_else(usual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::tests::empty_map;
    use openbench_osm::{Building, ElementId, ElementKind};
    use proptest::prelude::*;

    fn points(corners: &[(f64, f64)]) -> Vec<MapPoint> {
        corners.iter().map(|(x, y)| MapPoint::new(*x, *y)).collect()
    }

    fn grid() -> GridGeometry {
        GridGeometry::covering(
            MapPoint::new(-10.0, -10.0),
            MapPoint::new(10.0, 10.0),
            0.1,
            1000,
        )
    }

    fn area(corners: &[(f64, f64)], key: &str, value: &str) -> Area {
        let polygon = Polygon::new(points(corners), vec![]).unwrap();
        let element = ElementId {
            kind: ElementKind::Way,
            id: 1,
        };
        Area {
            element,
            polygon,
            tags: [(key, value)].into_iter().collect(),
        }
    }

    fn road(corners: &[(f64, f64)], kind: &str) -> Road {
        let tags = [("highway", kind)].into_iter().collect();
        Road {
            way: 1,
            nodes: vec![1, 2],
            points: points(corners),
            tags,
        }
    }

    fn at(ground: &Ground, x: f64, y: f64) -> (bool, Surface) {
        let cell = grid().cell_at(MapPoint::new(x, y)).unwrap();
        (
            ground.obstacles[cell] != MappedObstacle::No,
            ground.surface[cell],
        )
    }

    #[test]
    fn pavements_lie_over_roads_over_grass_and_water_blocks_except_at_bridges() {
        let mut map = empty_map();
        map.areas.push(area(
            &[(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)],
            "landuse",
            "grass",
        ));
        map.areas.push(area(
            &[(-9.0, 3.0), (9.0, 3.0), (9.0, 6.0), (-9.0, 6.0)],
            "natural",
            "water",
        ));
        map.roads
            .push(road(&[(-1e6, 0.0), (1e6, 0.0)], "residential"));
        map.roads.push(road(&[(5.0, -9.0), (5.0, 9.0)], "footway"));
        let ground = Ground::of(&map, &grid());
        assert_eq!(at(&ground, -5.0, -5.0), (false, Surface::Green));
        assert_eq!(at(&ground, -5.0, 2.9), (false, Surface::Road));
        assert_eq!(at(&ground, 5.5, 0.0), (false, Surface::Pavement));
        assert_eq!(at(&ground, 9.5, 9.5), (false, Surface::Unknown));
        assert!(at(&ground, 0.0, 4.0).0 && !at(&ground, 5.0, 4.0).0);
    }

    #[test]
    fn a_path_beside_water_opens_no_water_and_a_bridge_no_wall() {
        let mut map = empty_map();
        map.areas.push(area(
            &[(-9.0, 0.0), (9.0, 0.0), (9.0, 6.0), (-9.0, 6.0)],
            "natural",
            "water",
        ));
        map.roads
            .push(road(&[(-9.0, -0.5), (5.0, -0.5), (5.0, 9.0)], "footway"));
        let polygon = Polygon::new(
            points(&[(3.0, 2.0), (4.5, 2.0), (4.5, 4.0), (3.0, 4.0)]),
            vec![],
        )
        .unwrap();
        let element = ElementId {
            kind: ElementKind::Way,
            id: 1,
        };
        map.buildings.push(Building {
            element,
            name: None,
            polygon,
            tags: Tags::default(),
        });
        let ground = Ground::of(&map, &grid());
        let obstacle =
            |x: f64, y: f64| ground.obstacles[grid().cell_at(MapPoint::new(x, y)).unwrap()];
        assert_eq!(obstacle(-5.0, 0.3), MappedObstacle::Water);
        assert_eq!(
            (obstacle(5.0, 3.0), obstacle(5.9, 3.0), obstacle(6.2, 3.0)),
            (
                MappedObstacle::No,
                MappedObstacle::No,
                MappedObstacle::Water
            )
        );
        assert_eq!(obstacle(4.3, 3.0), MappedObstacle::Solid);
    }

    #[test]
    fn bridges_are_as_wide_as_the_roads_that_they_carry() {
        let mut map = empty_map();
        map.areas.push(area(
            &[(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)],
            "natural",
            "water",
        ));
        map.areas.push(area(
            &[(-8.0, 2.0), (-4.0, 2.0), (-4.0, 8.0), (-8.0, 8.0)],
            "highway",
            "pedestrian",
        ));
        map.areas.push(area(
            &[(-8.0, -8.0), (-4.0, -8.0), (-4.0, -2.0), (-8.0, -2.0)],
            "landuse",
            "grass",
        ));
        map.roads
            .push(road(&[(4.0, -12.0), (4.0, 12.0)], "residential"));
        let ground = Ground::of(&map, &grid());
        let obstacle =
            |x: f64, y: f64| ground.obstacles[grid().cell_at(MapPoint::new(x, y)).unwrap()];
        assert_eq!(
            [1.2, 6.8].map(|x| obstacle(x, 0.0)),
            [MappedObstacle::No; 2]
        );
        assert_eq!(
            [0.8, 7.2].map(|x| obstacle(x, 0.0)),
            [MappedObstacle::Water; 2]
        );
        assert_eq!(
            (obstacle(-6.0, 5.0), obstacle(-6.0, -5.0)),
            (MappedObstacle::No, MappedObstacle::Water)
        );
    }

    #[test]
    fn preferences_out_of_range_are_not_sound() {
        assert!(Preferences::default().is_sound() && Preferences::NONE.is_sound());
        assert!(
            !Preferences {
                road: 0.5,
                ..Preferences::NONE
            }
            .is_sound()
        );
        assert!(
            !Preferences {
                green: f32::NAN,
                ..Preferences::NONE
            }
            .is_sound()
        );
    }

    proptest! {
        #[test]
        fn filled_cells_are_those_that_a_polygon_contains(
            corners in prop::collection::vec((-14.0..14.0_f64, -14.0..14.0_f64), 3..9),
        ) {
            let Some(polygon) = Polygon::new(points(&corners), vec![]) else { return Ok(()) };
            let mut map = empty_map();
            let element = ElementId { kind: ElementKind::Way, id: 1 };
            let (name, tags) = (None, Tags::default());
            map.buildings.push(Building { element, name, polygon: polygon.clone(), tags });
            let (grid, ground) = (grid(), Ground::of(&map, &grid()));
            for cell in 0..grid.len() {
                let is_inside = polygon.contains(grid.center(cell));
                prop_assert_eq!(ground.obstacles[cell] == MappedObstacle::Solid, is_inside);
            }
        }

        #[test]
        fn segments_are_cut_at_the_grid(
            ax in -1e3..1e3_f64,
            ay in -1e3..1e3_f64,
            bx in -1e3..1e3_f64,
            by in -1e3..1e3_f64,
        ) {
            let grid = grid();
            let drawing = Drawing { grid: &grid, ground: Ground::unknown(0) };
            let segment = Segment::new(MapPoint::new(ax, ay), MapPoint::new(bx, by));
            let inside = |p: MapPoint| p.x.abs() <= 10.0 + 1e-6 && p.y.abs() <= 10.0 + 1e-6;
            let cut = drawing.cut(segment, 0.0);
            if let Some(part) = cut {
                prop_assert!(inside(part.start) && inside(part.end));
            }
            for i in 0..=500 {
                let p = segment.at(f64::from(i) / 500.0);
                if p.x.abs() < 10.0 && p.y.abs() < 10.0 {
                    prop_assert!(cut.unwrap().nearest_point(p).point.distance(p) < 1e-6);
                }
            }
        }
    }
}
