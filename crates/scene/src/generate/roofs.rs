//! Roofs: flat with parapet, gabled, hipped, and a mansard that fits over any outline.

use nalgebra::Point3;
use openbench_core::{MapPoint, Pose2};
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::buildings::{House, Roof};
use super::facades::PARAPET;
use super::seeds::{between, chance};
use super::shapes::{along, at, cuboid, facet, floor, inset, signed_area};
use crate::scene::Layer;

/// How far a pitched roof reaches over its walls, metres.
const OVERHANG: f64 = 0.4;
/// Height of the boards along its edges, metres.
const FASCIA: f64 = 0.18;

/// The rectangle that a gabled or hipped roof covers: its corners counter-clockwise, the eaves along 0-1 and 2-3.
struct Span {
    corners: [MapPoint; 4],
    half_width: f64,
    eaves: f64,
    slope: f64,
}

impl Span {
    fn of(ring: &[MapPoint], eaves: f64, slope: f64) -> Self {
        let long_first = ring[0].distance(ring[1]) >= ring[1].distance(ring[2]);
        let first = if long_first { 0 } else { 1 };
        let corners = [0, 1, 2, 3].map(|i| ring[(i + first) % 4]);
        Self {
            half_width: corners[1].distance(corners[2]) / 2.0,
            corners,
            eaves,
            slope,
        }
    }

    /// The rectangle grown by the overhang, at the height of the roof there.
    fn edge(&self, over_gables: f64) -> [Point3<f64>; 4] {
        let [a, b, c, d] = self.corners;
        let grow = |p: MapPoint, along: MapPoint, across: MapPoint| {
            let q = away(away(p, along, over_gables), across, OVERHANG);
            at(q, self.eaves - OVERHANG * self.slope)
        };
        [grow(a, b, d), grow(b, a, c), grow(c, d, b), grow(d, c, a)]
    }

    /// Both ends of the ridge, `by` metres inside the gables (outside if negative).
    fn ridge(&self, by: f64) -> [Point3<f64>; 2] {
        let [a, b, c, d] = self.corners;
        let (first, last) = (along(a, d, 0.5), along(b, c, 0.5));
        let z = self.eaves + self.half_width * self.slope;
        [at(away(first, last, -by), z), at(away(last, first, -by), z)]
    }
}

/// `p` moved away from `other` by `metres`.
fn away(p: MapPoint, other: MapPoint, metres: f64) -> MapPoint {
    along(p, other, -metres / p.distance(other).max(1e-9))
}

impl Site {
    pub(super) fn roof(&mut self, house: &House, rng: &mut Pcg64Mcg) {
        match house.roof {
            Roof::Gabled(slope) => self.gabled(house, slope, rng),
            Roof::Hipped(slope) => self.hipped(house, slope, rng),
            Roof::Mansard => self.mansard(house, rng),
            Roof::Flat => self.flat(house, rng),
            Roof::Tent(rise) => self.tent(house, rise),
            Roof::Terrace => self.cover(house),
        }
    }

    fn tent(&mut self, house: &House, rise: f64) {
        let ring = &house.rings[0];
        let middle = openbench_osm::Polygon::new(ring.clone(), Vec::new()).map(|p| p.centroid());
        let Some(tip) = middle.map(|p| at(p, house.eaves + rise)) else {
            return;
        };
        for i in 0..ring.len() {
            let (a, b) = (
                at(ring[i], house.eaves),
                at(ring[(i + 1) % ring.len()], house.eaves),
            );
            facet(
                &mut self.builder,
                Layer::Visible,
                house.roofing,
                &[a, b, tip],
            );
        }
    }

    fn cover(&mut self, house: &House) {
        floor(
            &mut self.builder,
            house.roofing,
            (&house.rings[0], &house.rings[1..]),
            house.eaves,
        );
    }

    /// A roof on posts, nothing below it.
    pub(super) fn shelter(&mut self, house: &House) {
        floor(
            &mut self.builder,
            house.roofing,
            (&house.rings[0], &house.rings[1..]),
            house.eaves.max(2.4),
        );
    }

    fn gabled(&mut self, house: &House, slope: f64, rng: &mut Pcg64Mcg) {
        let span = Span::of(&house.rings[0], house.eaves, slope);
        let ([e0, e1, e2, e3], [r0, r1]) = (span.edge(OVERHANG * 0.7), span.ridge(-OVERHANG * 0.7));
        facet(
            &mut self.builder,
            Layer::Visible,
            house.roofing,
            &[e0, e1, r1, r0],
        );
        facet(
            &mut self.builder,
            Layer::Visible,
            house.roofing,
            &[e2, e3, r0, r1],
        );
        let [top0, top1] = span.ridge(0.0);
        let [a, b, c, d] = span.corners.map(|p| at(p, house.eaves));
        facet(
            &mut self.builder,
            Layer::Visible,
            house.facade,
            &[b, c, top1],
        );
        facet(
            &mut self.builder,
            Layer::Visible,
            house.facade,
            &[d, a, top0],
        );
        for edge in [(e0, e1), (e2, e3), (e1, r1), (r1, e2), (e3, r0), (r0, e0)] {
            self.fascia(house, edge);
        }
        if !house.plain && !self.is_full() {
            self.gable_window(
                house,
                (span.corners[1], span.corners[2]),
                span.half_width * slope,
            );
            self.gable_window(
                house,
                (span.corners[3], span.corners[0]),
                span.half_width * slope,
            );
            if span.half_width * slope > 2.4 && house.detailed && chance(rng, 0.45) {
                self.dormers(house, &span, rng);
            } else {
                self.roof_windows(house, [e0, e1, r1, r0], rng);
            }
            self.chimney(house, [top0, top1], rng);
        }
    }

    fn hipped(&mut self, house: &House, slope: f64, rng: &mut Pcg64Mcg) {
        let span = Span::of(&house.rings[0], house.eaves, slope);
        let length = span.corners[0].distance(span.corners[1]);
        let ([e0, e1, e2, e3], [r0, r1]) = (
            span.edge(OVERHANG),
            span.ridge(span.half_width.min(length / 2.0 - 0.05)),
        );
        facet(
            &mut self.builder,
            Layer::Visible,
            house.roofing,
            &[e0, e1, r1, r0],
        );
        facet(
            &mut self.builder,
            Layer::Visible,
            house.roofing,
            &[e2, e3, r0, r1],
        );
        facet(
            &mut self.builder,
            Layer::Visible,
            house.roofing,
            &[e1, e2, r1],
        );
        facet(
            &mut self.builder,
            Layer::Visible,
            house.roofing,
            &[e3, e0, r0],
        );
        for edge in [(e0, e1), (e1, e2), (e2, e3), (e3, e0)] {
            self.fascia(house, edge);
        }
        if !house.plain {
            self.chimney(house, [r0, r1], rng);
        }
    }

    fn mansard(&mut self, house: &House, rng: &mut Pcg64Mcg) {
        let (run, rise) = (between(rng, 0.9, 1.4), between(rng, 1.4, 2.0));
        let ring_of = |offset: f64| {
            house
                .rings
                .iter()
                .map(|r| inset(r, offset))
                .collect::<Option<Vec<_>>>()
        };
        let inner =
            ring_of(run).filter(|rings| rings.iter().map(|r| signed_area(r)).sum::<f64>() > 4.0);
        let (Some(inner), Some(outer)) = (inner, ring_of(-0.25)) else {
            self.flat(house, rng);
            return;
        };
        let (low, high) = (house.eaves - 0.1, house.eaves + rise);
        for (below, above) in outer.iter().zip(&inner) {
            for i in 0..below.len() {
                let j = (i + 1) % below.len();
                let slope = [
                    at(below[i], low),
                    at(below[j], low),
                    at(above[j], high),
                    at(above[i], high),
                ];
                facet(&mut self.builder, Layer::Visible, house.roofing, &slope);
                self.fascia(house, (slope[0], slope[1]));
            }
        }
        let surface = self.palette.flat_roof;
        floor(&mut self.builder, surface, (&inner[0], &inner[1..]), high);
    }

    fn flat(&mut self, house: &House, rng: &mut Pcg64Mcg) {
        self.cover(house);
        if house.roof != Roof::Flat || self.is_full() {
            return;
        }
        let top = house.eaves + PARAPET;
        for ring in &house.rings {
            for i in 0..ring.len() {
                let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                let pose = Pose2::new(a.x, a.y, a.bearing_to(b));
                let box_ = (
                    [-0.06, -0.06, top - 0.02],
                    [a.distance(b) + 0.06, 0.28, top + 0.08],
                );
                cuboid(&mut self.builder, Layer::Visible, house.trim, pose, box_);
            }
        }
        if house.levels >= 3 {
            self.stair_head(house, rng);
        }
    }

    /// The hut over a staircase, and a ventilator.
    fn stair_head(&mut self, house: &House, rng: &mut Pcg64Mcg) {
        let Some(polygon) =
            openbench_osm::Polygon::new(house.rings[0].clone(), house.rings[1..].to_vec())
        else {
            return;
        };
        let p = polygon.interior_point();
        if polygon.distance_to_boundary(p) < 2.6 {
            return;
        }
        let pose = Pose2::new(p.x, p.y, house.rings[0][0].bearing_to(house.rings[0][1]));
        let z = house.eaves;
        let hut = ([-1.6, -1.2, z], [1.6, 1.2, z + between(rng, 1.8, 2.4)]);
        cuboid(&mut self.builder, Layer::Visible, house.facade, pose, hut);
        let metal = house.trim;
        cuboid(
            &mut self.builder,
            Layer::Visible,
            metal,
            pose,
            ([1.8, -0.5, z], [2.5, 0.4, z + 0.8]),
        );
    }

    fn fascia(&mut self, house: &House, (a, b): (Point3<f64>, Point3<f64>)) {
        let down = nalgebra::Vector3::z() * FASCIA;
        facet(
            &mut self.builder,
            Layer::Visible,
            house.trim,
            &[a - down, b - down, b, a],
        );
    }

    fn gable_window(&mut self, house: &House, (a, b): (MapPoint, MapPoint), rise: f64) {
        if rise < 2.0 {
            return;
        }
        let pose = super::facades::facing_out(a, b, 0.5);
        let line = (pose.transform(0.03, -0.4), pose.transform(0.03, 0.4));
        let z = (house.eaves + 0.2, house.eaves + 1.2);
        super::shapes::panel(&mut self.builder, Layer::Visible, house.windows[0], line, z);
    }

    fn roof_windows(
        &mut self,
        house: &House,
        [e0, e1, r1, r0]: [Point3<f64>; 4],
        rng: &mut Pcg64Mcg,
    ) {
        let count = between(rng, 0.0, 3.9) as usize;
        let normal = (e1 - e0).cross(&(r0 - e0)).normalize() * 0.05;
        for i in 0..count {
            let share = (i as f64 + 1.0) / (count as f64 + 1.0);
            let (low, high) = (e0 + (e1 - e0) * share, r0 + (r1 - r0) * share);
            let (side, up) = ((e1 - e0).normalize() * 0.4, high - low);
            let (bottom, top) = (low + up * 0.4 + normal, low + up * 0.62 + normal);
            let corners = [bottom - side, bottom + side, top + side, top - side];
            let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let corners: Vec<_> = corners.into_iter().zip(uv).collect();
            self.builder.mesh(
                Layer::Visible,
                house.windows[0],
                &corners,
                &[[0, 1, 2], [0, 2, 3]],
            );
        }
    }

    /// Small gabled windows that stand in the slope over the wall 0-1.
    fn dormers(&mut self, house: &House, span: &Span, rng: &mut Pcg64Mcg) {
        let (a, b) = (span.corners[0], span.corners[1]);
        let count = ((a.distance(b) / 3.6) as usize).clamp(1, 8);
        let (wide, tall) = (0.75, 1.25);
        let back = between(rng, 0.5, 0.9);
        for i in 0..count {
            let pose = super::facades::facing_out(a, b, (i as f64 + 0.5) / count as f64);
            // Where the slope is as high as the dormer's sill, eaves and ridge.
            let sill = house.eaves + back * span.slope;
            let depth = |z: f64| -(z - house.eaves) / span.slope;
            let (eaves, ridge) = (sill + tall, sill + tall + 0.55);
            let p = |x: f64, y: f64, z: f64| at(pose.transform(x, y), z);
            let front = depth(sill);
            let line = (pose.transform(front, -wide), pose.transform(front, wide));
            let image = house.windows[i % 2];
            super::shapes::panel(
                &mut self.builder,
                Layer::Visible,
                image,
                line,
                (sill, eaves),
            );
            let builder = &mut self.builder;
            let gable = [
                p(front, -wide, eaves),
                p(front, wide, eaves),
                p(front, 0.0, ridge),
            ];
            facet(builder, Layer::Visible, house.trim, &gable);
            for side in [-1.0, 1.0] {
                let y = side * wide;
                let cheek = [
                    p(front, y, sill),
                    p(front, y, eaves),
                    p(depth(eaves), y, eaves),
                ];
                facet(builder, Layer::Visible, house.facade, &cheek);
                let over = y * 1.2;
                let slope = [
                    p(front + 0.2, over, eaves - 0.1),
                    p(front + 0.2, 0.0, ridge),
                    p(depth(ridge), 0.0, ridge),
                    p(depth(eaves - 0.1), over, eaves - 0.1),
                ];
                facet(builder, Layer::Visible, house.roofing, &slope);
            }
        }
    }

    fn chimney(&mut self, house: &House, [r0, r1]: [Point3<f64>; 2], rng: &mut Pcg64Mcg) {
        if !chance(rng, 0.75) {
            return;
        }
        let p = r0 + (r1 - r0) * between(rng, 0.15, 0.85);
        let pose = Pose2::new(
            p.x,
            p.y,
            MapPoint::new(r0.x, r0.y).bearing_to(MapPoint::new(r1.x, r1.y)),
        );
        let stack = ([-0.35, -0.3, p.z - 0.7], [0.35, 0.3, p.z + 0.8]);
        let surface = self.palette.facades[0];
        cuboid(&mut self.builder, Layer::Visible, surface, pose, stack);
        let cap = ([-0.42, -0.37, p.z + 0.8], [0.42, 0.37, p.z + 0.9]);
        cuboid(&mut self.builder, Layer::Visible, house.plinth, pose, cap);
    }
}
