//! Parked cars: along the kerb where the map allows it, and in car parks; never on a pavement, a path or before a door.

use openbench_core::{MapPoint, Pose2};
use openbench_osm::polygon::Segment;
use openbench_osm::{Polygon, Road, Tags};
use rand_pcg::Pcg64Mcg;

use super::clearance::{BARRIER, BUILDING, DOOR, DRIVEWAY, OBJECT, PATH, ROAD, START};
use super::palette::PAINTS;
use super::seeds::{Purpose, chance, pick, stream};
use super::shapes::{Corner, Surface, along, cuboid, facet, signed_area};
use super::streets::profile;
use super::{Site, element_number};
use crate::material::{Material, SemanticClass};
use crate::scene::{Layer, Scene, SceneBuilder};
use crate::triangulate::triangulate;

/// Length of a place along the kerb, metres.
const KERB_PLACE: f64 = 6.0;
/// Width and length of a place in a car park, and width of the aisle between rows, metres.
const PARK_PLACE: (f64, f64) = (2.6, 5.0);
const AISLE: f64 = 6.0;
/// No car this near to the end of a way: there may be a junction, metres.
const CORNER: f64 = 8.0;
/// Half length and half width of a car, metres.
const HALF: (f64, f64) = (2.2, 0.87);

/// Height of the lamps, metres.
const LAMPS: f64 = 0.68;

/// A car seen from its left: outline (forward, up), the segments of it that are glass, and a side window.
struct Shape {
    outline: &'static [(f64, f64)],
    glass: &'static [usize],
    window: &'static [(f64, f64)],
    /// Heights between which the sides lean in.
    waist: (f64, f64),
}

impl Shape {
    /// How far forward the outline reaches at a height, and how far back, metres.
    fn ends(&self, height: f64) -> (f64, f64) {
        let next = self.outline.iter().cycle().skip(1);
        let sides = self.outline.iter().zip(next).filter(|(p, q)| (p.1 > height) != (q.1 > height));
        let at = sides.map(|(p, q)| p.0 + (q.0 - p.0) * (height - p.1) / (q.1 - p.1));
        at.fold((f64::NEG_INFINITY, f64::INFINITY), |(front, back), x| (x.max(front), x.min(back)))
    }
}

const SALOON: Shape = Shape {
    outline: &[
        (-2.10, 0.18),
        (2.12, 0.18),
        (2.20, 0.52),
        (2.12, 0.76),
        (1.20, 0.92),
        (0.50, 1.38),
        (-0.80, 1.42),
        (-1.50, 1.00),
        (-2.12, 0.94),
        (-2.20, 0.56),
    ],
    glass: &[4, 6],
    window: &[(1.02, 0.97), (0.46, 1.33), (-0.76, 1.36), (-1.28, 1.02)],
    waist: (0.92, 1.42),
};
const HATCHBACK: Shape = Shape {
    outline: &[
        (-1.92, 0.18),
        (1.92, 0.18),
        (2.00, 0.54),
        (1.92, 0.80),
        (1.15, 0.96),
        (0.42, 1.46),
        (-1.20, 1.50),
        (-1.86, 1.02),
        (-1.98, 0.60),
    ],
    glass: &[4, 6],
    window: &[(0.98, 1.02), (0.38, 1.40), (-1.14, 1.43), (-1.60, 1.06)],
    waist: (0.96, 1.50),
};
const VAN: Shape = Shape {
    outline: &[
        (-2.20, 0.20),
        (2.16, 0.20),
        (2.22, 0.60),
        (2.14, 0.90),
        (1.62, 1.10),
        (0.95, 1.82),
        (0.70, 1.90),
        (-2.14, 1.90),
        (-2.22, 1.00),
    ],
    glass: &[4],
    window: &[(1.40, 1.14), (0.86, 1.74), (0.10, 1.76), (0.10, 1.14)],
    waist: (1.10, 2.60),
};

impl Site {
    pub(super) fn parked_cars(&mut self) {
        let roads = std::mem::take(&mut self.map.roads);
        for road in &roads {
            let mut rng = stream(self.seed, Purpose::Cars, road.way as u64);
            self.along_kerbs(road, &mut rng);
        }
        self.map.roads = roads;
        let areas = std::mem::take(&mut self.map.areas);
        for area in
            areas.iter().filter(|a| a.tags.is("amenity", "parking") && !a.tags.is("parking", "underground"))
        {
            let mut rng = stream(self.seed, Purpose::Cars, element_number(area.element) | 1 << 63);
            self.car_park(&area.polygon, &mut rng);
        }
        self.map.areas = areas;
    }

    fn along_kerbs(&mut self, road: &Road, rng: &mut Pcg64Mcg) {
        let Some(profile) = profile(&road.tags).filter(|p| p.for_cars && p.width >= 5.0) else { return };
        let shares = kerb_shares(&road.tags);
        let count = road.points.len();
        for (i, pair) in road.points.windows(2).enumerate() {
            let length = pair[0].distance(pair[1]);
            let (first, last) =
                (if i == 0 { CORNER } else { 3.0 }, if i + 2 == count { CORNER } else { 3.0 });
            let places = ((length - first - last) / KERB_PLACE).clamp(0.0, 1_000.0) as usize;
            for (side, share) in [(1.0, shares[0]), (-1.0, shares[1])] {
                for place in 0..places {
                    let share = share * self.options.parked_cars.clamp(0.0, 1.0);
                    let taken = chance(rng, share);
                    let run = first + (place as f64 + 0.5) * KERB_PLACE;
                    let p = along(pair[0], pair[1], run / length);
                    // Right-hand traffic: cars on the left of the way look back along it.
                    let yaw = pair[0].bearing_to(pair[1]);
                    let spot = Pose2::new(p.x, p.y, yaw)
                        .transform(0.0, side * (profile.width / 2.0 - HALF.1 - 0.13));
                    let yaw = if side > 0.0 { yaw + std::f64::consts::PI } else { yaw };
                    let kinds = PATH | DOOR | OBJECT | START | BARRIER | BUILDING | DRIVEWAY;
                    self.car_if(taken, Pose2::new(spot.x, spot.y, yaw), kinds, rng);
                }
            }
        }
    }

    fn car_park(&mut self, polygon: &Polygon, rng: &mut Pcg64Mcg) {
        let longest = polygon.sides().max_by(|s, t| s.length().total_cmp(&t.length()));
        let Some(Segment { start: a, end: b }) = longest else { return };
        let origin = Pose2::new(a.x, a.y, a.bearing_to(b));
        let reach =
            polygon.outer.iter().map(|p| origin.inverse_transform(*p).1).fold(0.0, f64::max).min(500.0);
        let columns = ((a.distance(b) - 0.4) / PARK_PLACE.0).min(200.0) as usize;
        let mut from = 0.1;
        let mut row = 0;
        while from + PARK_PLACE.1 < reach {
            for column in 0..columns {
                let place = ((column as f64 + 0.5) * PARK_PLACE.0 + 0.2, from + PARK_PLACE.1 / 2.0);
                let p = origin.transform(place.0, place.1);
                let yaw =
                    origin.yaw + if chance(rng, 0.5) { 1.0 } else { -1.0 } * std::f64::consts::FRAC_PI_2;
                let taken = chance(rng, self.options.parked_cars.clamp(0.0, 1.0));
                let pose = Pose2::new(p.x, p.y, yaw);
                if is_inside(polygon, pose) && self.clearance.is_free(p, p, 1.2, ROAD | PATH | BUILDING) {
                    self.place_lines(pose);
                    self.car_if(taken, pose, ROAD | PATH | DOOR | OBJECT | START | BARRIER | BUILDING, rng);
                }
            }
            // Row, aisle, row, row back to back, aisle, …
            from += PARK_PLACE.1 + if row % 2 == 0 { AISLE } else { 0.1 };
            row += 1;
        }
    }

    fn place_lines(&mut self, pose: Pose2) {
        self.builder.object("parking place", SemanticClass::Road);
        for side in [-1.0, 1.0] {
            let p = pose.transform(0.0, side * PARK_PLACE.0 / 2.0);
            self.stripe(Pose2::new(p.x, p.y, pose.yaw), PARK_PLACE.1 - 0.4, 0.1);
        }
    }

    fn car_if(&mut self, taken: bool, pose: Pose2, kinds: u16, rng: &mut Pcg64Mcg) {
        let (front, back) = (pose.transform(HALF.0 - HALF.1, 0.0), pose.transform(HALF.1 - HALF.0, 0.0));
        let near = self.extent.holds(pose.point(), super::GROUND_MARGIN / 2.0) && !self.is_full();
        if taken && near && self.clearance.is_free(front, back, HALF.1 + 0.02, kinds) {
            self.car(pose, rng);
            self.clearance.add(front, back, HALF.1, OBJECT);
        }
    }

    fn car(&mut self, pose: Pose2, rng: &mut Pcg64Mcg) {
        let shape = pick(rng, &[&SALOON, &HATCHBACK, &SALOON, &HATCHBACK, &VAN]);
        let paint = pick(rng, &self.palette.car_paints);
        self.builder.object("car", SemanticClass::Vehicle);
        let palette = &self.palette;
        let (glass, tyre, rim, lights) = (palette.car_glass, palette.tyre, palette.rim, palette.car_lights);
        Car { shape, paint, glass, tyre, rim, lights }.build(&mut self.builder, pose);
    }
}

/// A car at the origin that looks along x, its wheels on z = 0: number `look` of the shapes and paints of parked cars, which repeat.
pub fn car_figure(look: u32) -> Scene {
    let shapes = [&SALOON, &HATCHBACK, &SALOON, &HATCHBACK, &VAN];
    let mut builder = SceneBuilder::new();
    let mut surface = |color: [f32; 3], reflectivity: Option<u8>| {
        let plain = Material::plain(SemanticClass::Vehicle, color);
        let reflectivity = reflectivity.unwrap_or(plain.reflectivity);
        Surface { material: builder.material(Material { reflectivity, ..plain }), tile: 1.0 }
    };
    let car = Car {
        shape: shapes[look as usize % shapes.len()],
        paint: surface(PAINTS[(look as usize * 3 + 1) % PAINTS.len()], None),
        glass: surface([0.10, 0.13, 0.16], Some(8)),
        tyre: surface([0.07; 3], Some(8)),
        rim: surface([0.58, 0.60, 0.62], None),
        lights: [surface([0.94, 0.94, 0.90], Some(200)), surface([0.60, 0.06, 0.06], Some(200))],
    };
    car.build(&mut builder, Pose2::default());
    builder.build()
}

/// What a car is made of. Body and tyres are solid as they are drawn, so that a robot meets a car where its sensors see one.
struct Car {
    shape: &'static Shape,
    paint: Surface,
    glass: Surface,
    tyre: Surface,
    rim: Surface,
    lights: [Surface; 2],
}

impl Car {
    fn build(&self, builder: &mut SceneBuilder, pose: Pose2) {
        let (shape, paint, glass) = (self.shape, self.paint, self.glass);
        let lean =
            |z: f64| HALF.1 - 0.2 * ((z - shape.waist.0) / (shape.waist.1 - shape.waist.0)).clamp(0.0, 1.0);
        let place = |(x, z): (f64, f64), side: f64, out: f64| {
            super::shapes::at(pose.transform(x, side * (lean(z) + out)), z)
        };
        let n = shape.outline.len();
        for i in 0..n {
            let (p, q) = (shape.outline[i], shape.outline[(i + 1) % n]);
            let surface = if shape.glass.contains(&i) { glass } else { paint };
            let quad = [place(p, -1.0, 0.0), place(q, -1.0, 0.0), place(q, 1.0, 0.0), place(p, 1.0, 0.0)];
            facet(builder, Layer::Both, surface, &quad);
        }
        for side in [-1.0, 1.0] {
            car_side(builder, Layer::Both, (paint, side), shape.outline, |p| place(p, side, 0.0));
            car_side(builder, Layer::Visible, (glass, side), shape.window, |p| place(p, side, 0.012));
        }
        self.wheels_and_lights(builder, pose);
    }

    fn wheels_and_lights(&self, builder: &mut SceneBuilder, pose: Pose2) {
        let (tyre, rim) = (self.tyre, self.rim);
        for (x, side) in [(1.3, -1.0), (1.3, 1.0), (-1.3, -1.0), (-1.3, 1.0)] {
            wheel(builder, pose, (x, side, 0.31), tyre, 0.0);
            wheel(builder, pose, (x, side, 0.17), rim, 0.006);
        }
        let [white, red] = self.lights;
        let (front, back) = self.shape.ends(LAMPS);
        for side in [-0.62, 0.62] {
            let lamp =
                |x: f64| ([x - 0.015, side - 0.16, LAMPS - 0.06], [x + 0.015, side + 0.16, LAMPS + 0.06]);
            cuboid(builder, Layer::Visible, white, pose, lamp(front));
            cuboid(builder, Layer::Visible, red, pose, lamp(back));
        }
    }
}

fn car_side(
    builder: &mut SceneBuilder,
    layer: Layer,
    (surface, side): (Surface, f64),
    outline: &[(f64, f64)],
    place: impl Fn((f64, f64)) -> nalgebra::Point3<f64>,
) {
    let mut flat: Vec<MapPoint> = outline.iter().map(|(x, z)| MapPoint::new(*x, *z)).collect();
    if signed_area(&flat) < 0.0 {
        flat.reverse();
    }
    for [a, b, c] in triangulate(&flat, &[]) {
        let order = if side < 0.0 { [a, b, c] } else { [a, c, b] };
        let corners: [Corner; 3] = order.map(|p| (place((p.x, p.y)), [0.0, 0.0]));
        builder.mesh(layer, surface.material, &corners, &[[0, 1, 2]]);
    }
}

/// A disc at the side of the car; with a tread if it is a tyre.
fn wheel(
    builder: &mut SceneBuilder,
    pose: Pose2,
    (x, side, radius): (f64, f64, f64),
    surface: Surface,
    out: f64,
) {
    const CORNERS: usize = 10;
    let rim = |i: usize, depth: f64| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / CORNERS as f64);
        let p = pose.transform(x + radius * cos, side * (HALF.1 + 0.015 + out - depth));
        super::shapes::at(p, 0.31 + radius * sin)
    };
    let order = |i: usize| if side < 0.0 { i } else { CORNERS - i };
    let disc: Vec<_> = (0..CORNERS).map(|i| rim(order(i), 0.0)).collect();
    let is_tyre = out == 0.0;
    let layer = if is_tyre { Layer::Both } else { Layer::Visible };
    facet(builder, layer, surface, &disc);
    if is_tyre {
        for i in 0..CORNERS {
            let quad =
                [rim(order(i + 1), 0.0), rim(order(i), 0.0), rim(order(i), 0.2), rim(order(i + 1), 0.2)];
            facet(builder, layer, surface, &quad);
        }
    }
}

/// How likely a place on the left and on the right is meant for parking.
fn kerb_shares(tags: &Tags) -> [f64; 2] {
    let allowed = |side: &str| {
        let keys = [
            format!("parking:{side}"),
            "parking:both".into(),
            format!("parking:lane:{side}"),
            "parking:lane:both".into(),
        ];
        keys.iter().find_map(|k| tags.get(k)).map(|v| !v.starts_with("no") && v != "separate")
    };
    let untold =
        if ["residential", "living_street"].iter().any(|k| tags.is("highway", k)) { 0.2 } else { 0.0 };
    let told = ["left", "right"].map(allowed);
    match told {
        // Without a word cars stand on one side only, so that one can still drive by.
        [None, None] => [0.0, untold],
        _ => told.map(|t| if t == Some(true) { 1.0 } else { 0.0 }),
    }
}

fn is_inside(polygon: &Polygon, pose: Pose2) -> bool {
    let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    corners.iter().all(|(x, y)| polygon.contains(pose.transform(x * (HALF.0 + 0.1), y * (HALF.1 + 0.1))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_stand_in_the_body() {
        for shape in [&SALOON, &HATCHBACK, &VAN] {
            let (front, back) = shape.ends(LAMPS);
            assert!((1.9..2.2).contains(&front) && (-2.22..-1.9).contains(&back), "{front} {back}");
        }
    }

    #[test]
    fn the_map_says_where_cars_stand() {
        assert_eq!(kerb_shares(&Tags::from([("parking:left", "lane"), ("parking:right", "no")])), [1.0, 0.0]);
        assert_eq!(kerb_shares(&Tags::from([("parking:both", "no")])), [0.0, 0.0]);
        assert!(kerb_shares(&Tags::from([("highway", "residential")]))[1] > 0.0);
        assert_eq!(kerb_shares(&Tags::from([("highway", "primary")])), [0.0, 0.0]);
    }
}
