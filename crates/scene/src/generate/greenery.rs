//! Trees of the map, and trees and shrubs that the seed adds where they stand in nobody's way.

use openbench_core::MapPoint;
use openbench_osm::Area;
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::clearance::{BARRIER, BUILDING, DOOR, EVERYTHING, OBJECT, PATH, PAVED, ROAD, START, WATER};
use super::entrances::walls;
use super::seeds::{Purpose, between, chance, pick, stream};
use super::shapes::{along, at, prism};
use super::trees::blob;
use crate::material::SemanticClass;
use crate::scene::Layer;

/// One tree that the seed may add for so many square metres.
const AREA_OF_TREE: f64 = 220.0;
/// Trees that the seed adds at most.
const MAX_ADDED: usize = 3_000;
/// In woods one for so many, and at most so many tries in all.
const AREA_OF_WOOD_TREE: f64 = 70.0;
const MAX_IN_WOODS: usize = 20_000;
/// Distance between the trees of a row, metres.
const ROW_SPACING: f64 = 8.0;
/// Distance between the trees on the horizon, metres.
const SPACING: f64 = 5.0;
/// How far beyond the buildings trees are added, metres.
const BACKDROP: f64 = 32.0;

impl Site {
    pub(super) fn mapped_trees(&mut self) {
        let features = std::mem::take(&mut self.features);
        let mut in_the_way = 0;
        for tree in features.iter().filter(|f| f.tags.is("natural", "tree")) {
            let p = tree.position;
            if !self.extent.holds(p, super::GROUND_MARGIN) {
                continue;
            }
            if !self.clearance.is_free(p, p, 0.35, BUILDING | DOOR | START | OBJECT) {
                in_the_way += 1;
                continue;
            }
            let mut rng = stream(self.seed, Purpose::Tree, tree.node as u64);
            let conifer = tree.tags.get("leaf_type").map_or(chance(&mut rng, 0.15), |t| t == "needleleaved");
            self.tree(p, conifer, &mut rng);
        }
        if in_the_way > 0 {
            self.warnings.push(format!(
                "{in_the_way} trees stand in buildings or in front of doors and were left out"
            ));
        }
        self.features = features;
    }

    /// Trees along `natural=tree_row`.
    pub(super) fn tree_rows(&mut self) {
        let rows = std::mem::take(&mut self.tree_rows);
        for (way, line) in &rows {
            let mut rng = stream(self.seed, Purpose::Tree, *way as u64 | 1 << 62);
            let conifer = chance(&mut rng, 0.1);
            for pair in line.windows(2) {
                let length = pair[0].distance(pair[1]);
                let count = ((length / ROW_SPACING).ceil() as usize).min(500);
                for i in 0..count {
                    let p = along(pair[0], pair[1], (i as f64 + 0.5) / count as f64);
                    self.tree_if(p, BUILDING | DOOR | START | OBJECT | ROAD, (conifer, &mut rng));
                }
            }
        }
        self.tree_rows = rows;
    }

    /// Trees in woods and orchards, thin enough to drive between them.
    pub(super) fn woods(&mut self) {
        let areas = std::mem::take(&mut self.map.areas);
        let is_wood = |a: &&Area| {
            ["natural=wood", "landuse=forest", "landuse=orchard"]
                .iter()
                .filter_map(|words| words.split_once('='))
                .any(|(key, value)| a.tags.is(key, value))
        };
        let mut left = MAX_IN_WOODS;
        let extent = self.extent;
        for area in areas.iter().filter(is_wood).filter(|a| extent.meets(&a.polygon, BACKDROP)) {
            let mut rng = stream(self.seed, Purpose::Tree, super::element_number(area.element) | 1 << 63);
            let conifers = if area.tags.is("leaf_type", "needleleaved") { 0.9 } else { 0.2 };
            let bounds = area.polygon.bounds();
            let (low, high) = (self.nearby(bounds.low), self.nearby(bounds.high));
            let wanted = ((high.x - low.x) * (high.y - low.y) / AREA_OF_WOOD_TREE) as usize;
            for _ in 0..wanted.min(left) {
                let p = MapPoint::new(between(&mut rng, low.x, high.x), between(&mut rng, low.y, high.y));
                if area.polygon.contains(p) && self.clearance.is_free(p, p, 1.2, EVERYTHING) {
                    let conifer = chance(&mut rng, conifers);
                    self.tree(p, conifer, &mut rng);
                }
            }
            left -= wanted.min(left);
        }
        self.map.areas = areas;
    }

    /// The point of the ground where trees grow that is nearest to `p`.
    fn nearby(&self, p: MapPoint) -> MapPoint {
        let around = self.extent.grown(BACKDROP);
        MapPoint::new(p.x.clamp(around.min.x, around.max.x), p.y.clamp(around.min.y, around.max.y))
    }

    fn tree_if(&mut self, p: MapPoint, in_the_way: u16, (conifer, rng): (bool, &mut Pcg64Mcg)) {
        let near = self.extent.holds(p, super::GROUND_MARGIN);
        if near && self.clearance.is_free(p, p, 0.35, in_the_way) {
            self.tree(p, conifer, rng);
        }
    }

    pub(super) fn added_greenery(&mut self) {
        self.shrubs();
        self.backdrop();
        let (min, max) = (self.extent.min, self.extent.max);
        let (width, depth) = (max.x - min.x + 2.0 * BACKDROP, max.y - min.y + 2.0 * BACKDROP);
        let wanted = (width * depth / AREA_OF_TREE * self.options.planting.clamp(0.0, 1.0)) as usize;
        let mut rng = stream(self.seed, Purpose::Planting, 0);
        for i in 0..wanted.min(MAX_ADDED) {
            let x = between(&mut rng, min.x - BACKDROP, max.x + BACKDROP);
            let p = MapPoint::new(x, between(&mut rng, min.y - BACKDROP, max.y + BACKDROP));
            let free = self.clearance.is_free(p, p, 2.6, BUILDING | OBJECT)
                && self.clearance.is_free(p, p, 1.0, EVERYTHING);
            if free {
                let mut own = stream(self.seed, Purpose::Planting, 1 + i as u64);
                let conifer = chance(&mut own, 0.2);
                self.tree(p, conifer, &mut own);
            }
        }
    }

    /// A belt of trees on the horizon, seen only: nobody gets there, and the free space need not reach so far.
    fn backdrop(&mut self) {
        let (min, max) = (self.extent.min, self.extent.max);
        let out = super::GROUND_MARGIN * 0.8;
        let corners = [
            (min.x - out, min.y - out),
            (max.x + out, min.y - out),
            (max.x + out, max.y + out),
            (min.x - out, max.y + out),
        ]
        .map(|(x, y)| MapPoint::new(x, y));
        let mut rng = stream(self.seed, Purpose::Planting, 1 << 41);
        for i in 0..4 {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            let count = ((a.distance(b) / SPACING) as usize).min(500);
            for k in 0..count {
                let p = along(a, b, (k as f64 + between(&mut rng, 0.0, 1.0)) / count as f64);
                let p = p.offset(between(&mut rng, 0.0, std::f64::consts::TAU), between(&mut rng, 0.0, 10.0));
                let (radius, half) = (between(&mut rng, 2.5, 4.5), between(&mut rng, 3.0, 5.0));
                let (core, _) = pick(&mut rng, &self.palette.crowns);
                if !self.is_full() && self.clearance.is_free(p, p, radius, ROAD | BUILDING | WATER) {
                    self.builder.object("tree", SemanticClass::Vegetation);
                    blob(
                        &mut self.builder,
                        (core, Layer::Visible),
                        (at(p, half * 0.85), radius, half),
                        0,
                        &mut rng,
                    );
                }
            }
        }
    }

    /// Rounded bushes along the walls of houses, away from doors and ways.
    fn shrubs(&mut self) {
        let buildings = std::mem::take(&mut self.map.buildings);
        let in_the_way = DOOR | PATH | ROAD | PAVED | START | BARRIER;
        for (index, building) in buildings.iter().enumerate() {
            if self.is_full() {
                break;
            }
            let mut rng = stream(self.seed, Purpose::Planting, (1 << 40) + index as u64);
            for (a, b) in walls(building) {
                let length = a.distance(b);
                let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
                for i in 0..((length / 1.6) as usize).min(100) {
                    let foot = along(a, b, (i as f64 + between(&mut rng, 0.3, 0.7)) * 1.6 / length);
                    let (radius, wanted) =
                        (between(&mut rng, 0.3, 0.45), chance(&mut rng, 0.45 * self.options.planting));
                    let p = foot.offset(out, radius + 0.08);
                    let passage = foot.offset(out, 2.2);
                    let free = wanted
                        && self.clearance.is_free(p, p, radius + 0.3, in_the_way)
                        && self.clearance.is_free(passage, passage, 1.1, BUILDING | BARRIER);
                    if free {
                        self.shrub(p, radius, &mut rng);
                    }
                }
            }
        }
        self.map.buildings = buildings;
    }

    fn shrub(&mut self, p: MapPoint, radius: f64, rng: &mut Pcg64Mcg) {
        let surface = match between(rng, 0.0, 1.0) {
            kind if kind < 0.25 => pick(rng, &self.palette.needles),
            kind if kind < 0.55 => pick(rng, &self.palette.flowers),
            _ => self.palette.hedge,
        };
        self.builder.object("shrub", SemanticClass::Vegetation);
        let height = radius * between(rng, 1.4, 2.2);
        let center = at(p, height * 0.45);
        blob(&mut self.builder, (surface, Layer::Visible), (center, radius, height * 0.55), 0, rng);
        let trunk = ((0.0, height * 0.8), (radius * 0.8, radius * 0.7));
        prism(&mut self.builder, Layer::Solid, surface, (p, 6), trunk);
        self.clearance.add(p, p, radius, OBJECT);
    }
}
