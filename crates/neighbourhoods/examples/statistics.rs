//! Prints statistics of maps side by side: real extracts, and drawn neighbourhoods.
//!
//! Arguments: `NAME=FILE@LON,LAT` for a window of 400 m by 400 m of a real map.
#![allow(clippy::print_stdout)]

use std::collections::BTreeMap;
use std::path::Path;

use openbench_core::{LonLat, MapPoint};
use openbench_geometry::{Bounds, segments};
use openbench_neighbourhoods::{Kind, Style, draw};
use openbench_osm::{Building, OsmData, OsmMap, Window, cut_out, default_georeference};

/// Half the side of a window, metres.
const HALF_WINDOW_M: f64 = 200.0;
/// A smaller building is no home, m².
const SMALLEST_HOME_M2: f64 = 30.0;

/// Ground this near to a building belongs to a drawn neighbourhood, metres.
const AROUND_M: f64 = 15.0;
/// Side of the cells in which that ground is counted, metres.
const CELL_M: f64 = 4.0;
/// Seeds of the drawn neighbourhoods.
const DRAWN: std::ops::Range<u64> = 0..100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut columns = Vec::new();
    for argument in std::env::args().skip(1) {
        columns.push(of_window(&argument)?);
    }
    columns.extend(Style::ALL.map(of_style));
    print_table(&columns);
    Ok(())
}

/// The statistics of large neighbourhoods of one style.
fn of_style(style: Style) -> Column {
    let (mut maps, mut area_m2) = (Vec::new(), 0.0);
    for seed in DRAWN {
        let here = draw(Kind::Large, seed);
        if here.style != style {
            continue;
        }
        let map = OsmMap::new(&here.map, here.georeference);
        area_m2 += ground(&map);
        maps.push(map);
    }
    statistics(style.name(), &maps, area_m2)
}

/// Ground within some metres of the buildings, m².
fn ground(map: &OsmMap) -> f64 {
    let boxes = map.buildings.iter().map(|b| b.polygon.bounds());
    let Some(around) = boxes.reduce(Bounds::union).map(|b| b.grown(AROUND_M)) else {
        return 0.0;
    };
    let near = |p: MapPoint| !map.buildings_within(p, AROUND_M).is_empty();
    let (wide, high) = (around.high.x - around.low.x, around.high.y - around.low.y);
    let mut cells = 0;
    for i in 0..(wide / CELL_M) as usize {
        for j in 0..(high / CELL_M) as usize {
            let (x, y) = ((i as f64 + 0.5) * CELL_M, (j as f64 + 0.5) * CELL_M);
            cells += usize::from(near(MapPoint::new(around.low.x + x, around.low.y + y)));
        }
    }
    cells as f64 * CELL_M * CELL_M
}

/// The statistics of one map or of several alike.
struct Column {
    name: String,
    /// By name of the row.
    rows: Vec<(&'static str, String)>,
}

fn of_window(argument: &str) -> Result<Column, Box<dyn std::error::Error>> {
    let bad = || format!("`{argument}` is no NAME=FILE@LON,LAT");
    let (name, rest) = argument.split_once('=').ok_or_else(bad)?;
    let (file, at) = rest.rsplit_once('@').ok_or_else(bad)?;
    let (lon, lat) = at.split_once(',').ok_or_else(bad)?;
    let middle = LonLat::new(lon.parse()?, lat.parse()?);
    let whole = OsmData::read(Path::new(file))?;
    let data = cut_out(&whole, &Window::around(middle, HALF_WINDOW_M)?);
    let map = OsmMap::new(&data, default_georeference(&data)?);
    let area_m2 = 4.0 * HALF_WINDOW_M * HALF_WINDOW_M;
    Ok(statistics(name, &[map], area_m2))
}

/// The statistics of maps that cover so many square metres together.
fn statistics(name: &str, maps: &[OsmMap], area_m2: f64) -> Column {
    let mut of = Samples::default();
    for map in maps {
        of.add(map);
    }
    let homes = of.areas.len() as f64;
    let percent = |count: usize| share(count as f64, homes);
    let degrees: usize = of.degrees.values().sum();
    let degree = |d: usize| {
        let count = of.degrees.get(&d).copied().unwrap_or(0);
        format!("{:.0} %", 100.0 * count as f64 / degrees.max(1) as f64)
    };
    let rows = vec![
        ("homes", format!("{}", of.areas.len())),
        ("homes per hectare", format!("{:.1}", homes / area_m2 * 1e4)),
        (
            "ground covered by homes",
            share(of.areas.iter().sum::<f64>(), area_m2),
        ),
        (
            "outbuildings per home",
            ratio(of.outbuildings as f64, homes),
        ),
        ("footprint (m²)", quantiles(&of.areas)),
        ("longest wall (m)", quantiles(&of.longest)),
        ("corners", quantiles(&of.corners)),
        ("to the middle of a street (m)", quantiles(&of.to_street)),
        ("to the next home (m)", quantiles(&of.gaps)),
        ("homes that touch another", percent(of.touching)),
        ("levels", quantiles(&of.levels)),
        ("street between junctions (m)", quantiles(&of.streets)),
        ("junctions of 3", degree(3)),
        ("junctions of 4", degree(4)),
        ("dead ends", degree(1)),
        ("street and number", percent(of.numbered)),
        ("name of its own", percent(of.named)),
        ("homes with mapped doors", percent(of.doors.len())),
        (
            "doors of such a home",
            ratio(of.doors.iter().sum(), of.doors.len() as f64),
        ),
        (
            "path (m per hectare)",
            format!("{:.0}", of.paths_m / area_m2 * 1e4),
        ),
        (
            "barriers (m per hectare)",
            format!("{:.0}", of.barriers_m / area_m2 * 1e4),
        ),
    ];
    Column {
        name: name.to_owned(),
        rows,
    }
}

#[derive(Default)]
struct Samples {
    areas: Vec<f64>,
    longest: Vec<f64>,
    corners: Vec<f64>,
    to_street: Vec<f64>,
    gaps: Vec<f64>,
    levels: Vec<f64>,
    streets: Vec<f64>,
    doors: Vec<f64>,
    degrees: BTreeMap<usize, usize>,
    outbuildings: usize,
    touching: usize,
    numbered: usize,
    named: usize,
    paths_m: f64,
    barriers_m: f64,
}

impl Samples {
    fn add(&mut self, map: &OsmMap) {
        let homes: Vec<usize> = (0..map.buildings.len())
            .filter(|i| is_home(&map.buildings[*i]))
            .collect();
        self.outbuildings += map.buildings.len() - homes.len();
        let mut doors = BTreeMap::<usize, usize>::new();
        for building in map.entrances.iter().filter_map(|e| e.building) {
            *doors.entry(building).or_default() += 1;
        }
        for i in &homes {
            let home = &map.buildings[*i];
            self.areas.push(home.polygon.area());
            let sides = home.polygon.sides().map(|side| side.length());
            self.longest.push(sides.fold(0.0, f64::max));
            self.corners.push(home.polygon.outer.len() as f64);
            self.to_street.extend(to_street(map, home));
            let others = homes.iter().filter(|other| *other != i);
            let gap = others
                .map(|other| between(home, &map.buildings[*other]))
                .fold(f64::INFINITY, f64::min);
            self.touching += usize::from(gap < 0.1);
            self.gaps.extend(Some(gap).filter(|gap| gap.is_finite()));
            let levels = home.tags.get("building:levels");
            self.levels
                .extend(levels.and_then(|l| l.parse::<f64>().ok()));
            let has = |key| home.tags.has(key);
            self.numbered += usize::from(has("addr:street") && has("addr:housenumber"));
            self.named += usize::from(has("name"));
            self.doors.extend(doors.get(i).map(|n| *n as f64));
        }
        self.add_streets(map);
        for road in map.roads.iter().filter(|road| is_path(&road.tags)) {
            self.paths_m += openbench_geometry::line::length(&road.points);
        }
        for barrier in &map.barriers {
            self.barriers_m += openbench_geometry::line::length(&barrier.points);
        }
    }

    fn add_streets(&mut self, map: &OsmMap) {
        let streets = || map.roads.iter().filter(|road| is_street(&road.tags));
        let mut degrees = BTreeMap::<i64, usize>::new();
        for road in streets() {
            let last = road.nodes.len() - 1;
            for (i, node) in road.nodes.iter().enumerate() {
                *degrees.entry(*node).or_default() += if i == 0 || i == last { 1 } else { 2 };
            }
        }
        for degree in degrees.values().filter(|d| **d != 2) {
            *self.degrees.entry(*degree).or_default() += 1;
        }
        for road in streets() {
            let mut run = 0.0;
            for (i, segment) in segments(&road.points).enumerate() {
                run += segment.length();
                if degrees.get(&road.nodes[i + 1]) != Some(&2) {
                    self.streets.push(run);
                    run = 0.0;
                }
            }
        }
    }
}

fn is_home(building: &Building) -> bool {
    const OTHER: [&str; 8] = [
        "garage",
        "garages",
        "shed",
        "roof",
        "carport",
        "hut",
        "greenhouse",
        "service",
    ];
    let kind = building.tags.get("building").unwrap_or_default();
    !OTHER.contains(&kind) && building.polygon.area() >= SMALLEST_HOME_M2
}

fn is_street(tags: &openbench_osm::Tags) -> bool {
    const KINDS: [&str; 7] = [
        "residential",
        "living_street",
        "tertiary",
        "secondary",
        "primary",
        "unclassified",
        "pedestrian",
    ];
    tags.get("highway")
        .is_some_and(|kind| KINDS.contains(&kind))
}

fn is_path(tags: &openbench_osm::Tags) -> bool {
    tags.get("highway")
        .is_some_and(|kind| ["footway", "path", "steps", "cycleway"].contains(&kind))
}

fn to_street(map: &OsmMap, home: &Building) -> Option<f64> {
    let streets = map.roads.iter().filter(|road| is_street(&road.tags));
    let stretches = streets.flat_map(|road| segments(&road.points));
    let nearest = stretches
        .map(|stretch| {
            let sides = home.polygon.sides();
            sides
                .map(|side| side.distance_to(stretch))
                .fold(f64::INFINITY, f64::min)
        })
        .fold(f64::INFINITY, f64::min);
    Some(nearest).filter(|d| d.is_finite())
}

fn between(a: &Building, b: &Building) -> f64 {
    let near = a.polygon.bounds().meets(b.polygon.bounds(), 60.0);
    if !near {
        return f64::INFINITY;
    }
    let corner = |p: &MapPoint, of: &Building| of.polygon.distance_to_boundary(*p);
    let from_a = a.polygon.outer.iter().map(|p| corner(p, b));
    let from_b = b.polygon.outer.iter().map(|p| corner(p, a));
    from_a.chain(from_b).fold(f64::INFINITY, f64::min)
}

fn share(part: f64, whole: f64) -> String {
    if whole > 0.0 {
        format!("{:.0} %", 100.0 * part / whole)
    } else {
        "-".to_owned()
    }
}

fn ratio(part: f64, whole: f64) -> String {
    if whole > 0.0 {
        format!("{:.2}", part / whole)
    } else {
        "-".to_owned()
    }
}

/// The 10, 50 and 90 % quantiles.
fn quantiles(values: &[f64]) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return "-".to_owned();
    };
    let at = |share: f64| sorted[(share * last as f64).round() as usize];
    format!("{:.0} / {:.0} / {:.0}", at(0.1), at(0.5), at(0.9))
}

fn print_table(columns: &[Column]) {
    let Some(first) = columns.first() else {
        return;
    };
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    println!("| | {} |", names.join(" | "));
    println!("|---|{}", "---|".repeat(columns.len()));
    for (i, (row, _)) in first.rows.iter().enumerate() {
        let cells: Vec<&str> = columns.iter().map(|c| c.rows[i].1.as_str()).collect();
        println!("| {row} | {} |", cells.join(" | "));
    }
}
