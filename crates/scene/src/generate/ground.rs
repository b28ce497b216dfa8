//! The ground, cut out where the sea is, and the hills or the sea on the horizon.

use nalgebra::Point3;
use openbench_core::MapPoint;

use super::clearance::WATER;
use super::seeds::{Purpose, between, stream};
use super::shapes::{Corner, Surface, along, at, floor, signed_area};
use super::{GROUND_MARGIN, Site};
use crate::beyond::{Rectangle, beyond};
use crate::material::SemanticClass;
use crate::scene::Layer;
use crate::triangulate::{triangulate, turn};

/// Height of the sea, metres; just above the ground where the ground could not be cut out.
pub(super) const SEA_LEVEL: f64 = -0.5;
const Z_SEA: f64 = 0.001;
/// Ground beyond the sea's edge, metres, so that the sea is a hole in it.
const RIM: f64 = 0.05;
/// How far beyond the ground each row of hills is, and how high they are there, metres.
const HILLS: [(f64, (f64, f64)); 4] = [
    (0.0, (-0.3, -0.3)),
    (60.0, (0.5, 6.0)),
    (150.0, (4.0, 22.0)),
    (320.0, (10.0, 48.0)),
];
/// Distance between the columns of hills along the edge of the ground, metres, and how many there are on one side at most.
const HILL_SPACING: f64 = 45.0;
const MAX_HILLS: usize = 60;

impl Site {
    pub(super) fn ground(&mut self) {
        let rim = self.extent.grown(GROUND_MARGIN + RIM);
        let (min, max) = (rim.min, rim.max);
        let outline = [
            min,
            MapPoint::new(max.x, min.y),
            max,
            MapPoint::new(min.x, max.y),
        ];
        let grass = self.palette.grass;
        self.builder.object("ground", SemanticClass::Ground);
        let sides = (
            nalgebra::Vector3::x() * (max.x - min.x),
            nalgebra::Vector3::y() * (max.y - min.y),
        );
        let repeat = [
            (sides.0.x / grass.tile) as f32,
            (sides.1.y / grass.tile) as f32,
        ];
        // A robot finds ground everywhere; what keeps it out of the sea are the kerbs.
        let layer = if self.sea.is_empty() {
            Layer::Both
        } else {
            Layer::Solid
        };
        self.builder
            .rectangle(layer, grass.material, at(min, 0.0), sides, repeat);
        self.builder.extent(min, max);
        for Rectangle { low, high } in beyond(Rectangle {
            low: [min.x, min.y],
            high: [max.x, max.y],
        }) {
            let [x, y] = [nalgebra::Vector3::x(), nalgebra::Vector3::y()];
            let sides = (x * (high[0] - low[0]), y * (high[1] - low[1]));
            let corner = Point3::new(low[0], low[1], 0.0);
            self.builder
                .rectangle(Layer::Solid, grass.material, corner, sides, [1.0; 2]);
        }
        if self.sea.is_empty() {
            return;
        }
        let sea = std::mem::take(&mut self.sea);
        let water = self.palette.water;
        let level = if self.land(&outline, &sea) {
            SEA_LEVEL
        } else {
            Z_SEA
        };
        if level == Z_SEA {
            self.builder
                .rectangle(Layer::Visible, grass.material, at(min, 0.0), sides, repeat);
        }
        self.builder.object("sea", SemanticClass::Ground);
        for part in &sea {
            floor(&mut self.builder, water, (&part.outer, &part.holes), level);
            for island in part.holes.iter().filter(|_| level == SEA_LEVEL) {
                let ring: Vec<MapPoint> = island.iter().rev().copied().collect();
                floor(&mut self.builder, grass, (&ring, &[]), 0.0);
            }
        }
        self.sea = sea;
    }

    /// The visible land around the sea: two long faces on one another would show through each other from afar. Whether it could be
    /// made; where coasts cross each other it cannot.
    fn land(&mut self, outline: &[MapPoint; 4], sea: &[openbench_osm::Polygon]) -> bool {
        let holes: Vec<Vec<MapPoint>> = sea
            .iter()
            .map(|part| part.outer.iter().rev().copied().collect())
            .collect();
        let covered: f64 = triangulate(outline, &holes)
            .iter()
            .map(|[a, b, c]| turn(*a, *b, *c).abs() / 2.0)
            .sum();
        let wet: f64 = sea.iter().map(|part| signed_area(&part.outer)).sum();
        let good = (covered - (signed_area(outline) - wet)).abs() < 1e-3 * signed_area(outline);
        if good {
            floor(
                &mut self.builder,
                self.palette.grass,
                (outline, &holes),
                0.0,
            );
        }
        good
    }

    /// What one sees far beyond the map: hills, or the sea where it goes on. Nobody gets there.
    pub(super) fn horizon(&mut self) {
        let edge = self.extent.grown(GROUND_MARGIN - RIM);
        let rim = self.extent.grown(GROUND_MARGIN);
        let corners = |e: super::Extent| {
            [
                e.min,
                MapPoint::new(e.max.x, e.min.y),
                e.max,
                MapPoint::new(e.min.x, e.max.y),
            ]
        };
        let (inner, outer) = (corners(edge), corners(rim));
        self.builder.object("horizon", SemanticClass::Ground);
        let mut rng = stream(self.seed, Purpose::Horizon, 0);
        let middle = self.extent.middle();
        let mut columns: Vec<(bool, [Point3<f64>; 4])> = Vec::new();
        for i in 0..4 {
            let (a, b) = (outer[i], outer[(i + 1) % 4]);
            let count = ((a.distance(b) / HILL_SPACING) as usize).clamp(2, MAX_HILLS);
            for k in 0..count {
                let share = k as f64 / count as f64;
                let (foot, inside) = (
                    along(a, b, share),
                    along(inner[i], inner[(i + 1) % 4], share),
                );
                let is_sea = !self.clearance.is_free(inside, inside, 0.0, WATER);
                let away = middle.bearing_to(foot);
                let rows = HILLS.map(|(out, (low, high))| {
                    at(foot.offset(away, out), between(&mut rng, low, high))
                });
                columns.push((is_sea, rows));
            }
        }
        narrow_is_sea(&mut columns);
        for i in 0..columns.len() {
            let (this, next) = (&columns[i], &columns[(i + 1) % columns.len()]);
            let surface = if this.0 && next.0 {
                self.palette.water
            } else {
                self.palette.hills
            };
            for row in 0..HILLS.len() - 1 {
                self.slope(
                    surface,
                    [this.1[row], next.1[row], next.1[row + 1], this.1[row + 1]],
                );
            }
        }
    }

    /// Two triangles, seen from above.
    fn slope(&mut self, surface: Surface, corners: [Point3<f64>; 4]) {
        let uv = |p: Point3<f64>| [(p.x / surface.tile) as f32, (p.y / surface.tile) as f32];
        let corners: Vec<Corner> = corners.iter().map(|p| (*p, uv(*p))).collect();
        self.builder.mesh(
            Layer::Visible,
            surface.material,
            &corners,
            &[[0, 2, 1], [0, 3, 2]],
        );
    }
}

/// Levels the columns in the sea, and those on land that is no wider than a mole: there are no hills on moles.
fn narrow_is_sea(columns: &mut [(bool, [Point3<f64>; 4])]) {
    let n = columns.len();
    let sea: Vec<bool> = columns.iter().map(|column| column.0).collect();
    for (i, (is_sea, rows)) in columns.iter_mut().enumerate() {
        *is_sea = sea[i] || sea[(i + n - 1) % n] || sea[(i + 1) % n];
        if *is_sea {
            rows.iter_mut().for_each(|p| p.z = SEA_LEVEL - 0.02);
        }
    }
}
