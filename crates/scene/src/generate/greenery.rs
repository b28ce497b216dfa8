//! Trees of the map, and trees and shrubs that the seed adds where they stand in nobody's way.

use nalgebra::{Point3, Vector3};
use openbench_core::MapPoint;
use openbench_osm::Area;
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::clearance::{BARRIER, BUILDING, DOOR, EVERYTHING, OBJECT, PATH, PAVED, ROAD, START, WATER};
use super::entrances::walls;
use super::seeds::{Purpose, between, chance, pick, stream};
use super::shapes::{Corner, Surface, along, at, prism};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

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
            let (low, high) = area.polygon.bounds();
            let (low, high) = (self.nearby(low), self.nearby(high));
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
                if self.clearance.is_free(p, p, radius, ROAD | BUILDING | WATER) {
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
        let surface = if chance(rng, 0.25) { pick(rng, &self.palette.needles) } else { self.palette.hedge };
        self.builder.object("shrub", SemanticClass::Vegetation);
        let height = radius * between(rng, 1.4, 2.2);
        let center = at(p, height * 0.45);
        blob(&mut self.builder, (surface, Layer::Visible), (center, radius, height * 0.55), 0, rng);
        let trunk = ((0.0, height * 0.8), (radius * 0.8, radius * 0.7));
        prism(&mut self.builder, Layer::Solid, surface, (p, 6), trunk);
        self.clearance.add(p, p, radius, OBJECT);
    }

    fn tree(&mut self, p: MapPoint, conifer: bool, rng: &mut Pcg64Mcg) {
        if self.builder.triangles() >= super::MAX_TRIANGLES {
            return;
        }
        self.builder.object("tree", SemanticClass::Vegetation);
        let bark = self.palette.bark;
        let girth = between(rng, 0.11, 0.19);
        if conifer {
            let height = between(rng, 5.0, 9.0);
            prism(&mut self.builder, Layer::Both, bark, (p, 6), ((0.0, 1.2), (girth, girth * 0.9)));
            let needles = pick(rng, &self.palette.needles);
            let width = height * between(rng, 0.17, 0.23);
            for tier in 0..3 {
                let share = f64::from(tier) / 3.0;
                let z = (0.9 + share * (height - 0.9) * 0.85, 0.9 + (share + 0.5).min(1.0) * (height - 0.9));
                prism(
                    &mut self.builder,
                    Layer::Visible,
                    needles,
                    (p, 8),
                    (z, (width * (1.0 - 0.72 * share), 0.0)),
                );
            }
        } else {
            let trunk = between(rng, 2.0, 2.7);
            prism(&mut self.builder, Layer::Both, bark, (p, 6), ((0.0, trunk + 0.5), (girth, girth * 0.7)));
            let (core, shell) = pick(rng, &self.palette.crowns);
            let (radius, half) = (between(rng, 1.4, 2.3), between(rng, 1.5, 2.2));
            let center = at(p, trunk + half * 0.85);
            blob(&mut self.builder, (core, Layer::Visible), (center, radius * 0.78, half * 0.8), 0, rng);
            blob(&mut self.builder, (shell, Layer::Visible), (center, radius, half), 1, rng);
        }
        self.clearance.add(p, p, girth, OBJECT);
    }
}

/// A dented ball: an icosahedron, its faces divided in four `divisions` times.
fn blob(
    builder: &mut SceneBuilder,
    (surface, layer): (Surface, Layer),
    (center, radius, half_height): (Point3<f64>, f64, f64),
    divisions: usize,
    rng: &mut Pcg64Mcg,
) {
    let (mut points, mut faces) = icosahedron();
    for _ in 0..divisions {
        (points, faces) = divided(&points, &faces);
    }
    let spin = between(rng, 0.0, std::f64::consts::TAU);
    let (sin, cos) = libm::sincos(spin);
    let corners: Vec<Corner> = points
        .iter()
        .map(|d| {
            let dent = between(rng, 0.82, 1.12);
            let (x, y) = (cos * d.x - sin * d.y, sin * d.x + cos * d.y);
            let p = center + Vector3::new(x * radius * dent, y * radius * dent, d.z * half_height * dent);
            // Texture from the side that the surface looks to; stretched leaves are leaves.
            let around = libm::atan2(y, x) * radius;
            (p, [(around / surface.tile) as f32, ((p.z + 0.3 * x) / surface.tile) as f32])
        })
        .collect();
    builder.mesh(layer, surface.material, &corners, &faces);
}

fn icosahedron() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    // Two poles and two rings of five.
    let mut points = vec![Vector3::z(), -Vector3::z()];
    let (z, r) = (1.0 / 5.0_f64.sqrt(), 2.0 / 5.0_f64.sqrt());
    for i in 0..10 {
        let (sin, cos) = libm::sincos(std::f64::consts::PI * f64::from(i) / 5.0);
        points.push(Vector3::new(r * cos, r * sin, if i % 2 == 0 { z } else { -z }));
    }
    let ring = |i: u32| 2 + i % 10;
    let mut faces = Vec::new();
    for i in 0..5 {
        let k = 2 * i;
        faces.push([0, ring(k), ring(k + 2)]);
        faces.push([1, ring(k + 3), ring(k + 1)]);
        faces.push([ring(k), ring(k + 1), ring(k + 2)]);
        faces.push([ring(k + 1), ring(k + 3), ring(k + 2)]);
    }
    (points, faces)
}

fn divided(points: &[Vector3<f64>], faces: &[[u32; 3]]) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let mut points = points.to_vec();
    let mut middles = std::collections::BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let split = |[a, b, c]: &[u32; 3]| {
        let (ab, bc, ca) = (middle(*a, *b), middle(*b, *c), middle(*c, *a));
        [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
    };
    let faces = faces.iter().flat_map(split).collect();
    (points, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_are_closed_and_face_outwards() {
        let (points, faces) = icosahedron();
        let (points, faces) = divided(&points, &faces);
        assert_eq!((points.len(), faces.len()), (42, 80));
        let mut edges = std::collections::BTreeSet::new();
        for [a, b, c] in faces {
            let [p, q, r] = [a, b, c].map(|i| points[i as usize]);
            assert!((q - p).cross(&(r - p)).dot(&p) > 0.0);
            edges.extend([(a, b), (b, c), (c, a)]);
        }
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
    }
}
