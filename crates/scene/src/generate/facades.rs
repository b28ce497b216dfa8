//! Walls of buildings: plinth, windows with sills, string courses, balconies.

use openbench_core::{MapPoint, Pose2};
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::buildings::{House, Roof};
use super::clearance::BUILDING;
use super::entrances::Doorway;
use super::seeds::{chance, pick};
use super::shapes::{along, at, cuboid, facet, panel, wall};
use crate::scene::Layer;

/// Height of the plinth, metres.
const PLINTH: f64 = 0.5;
/// How far plinths and window frames stand out of the wall, metres.
const RELIEF: f64 = 0.03;
/// Height of a parapet, metres.
pub(super) const PARAPET: f64 = 0.5;
/// Windows in one wall and floor at most: a wall is not longer than a street.
const MAX_COLUMNS: usize = 200;

impl Site {
    /// The wall from `a` to `b`, the building on its left.
    pub(super) fn facade(
        &mut self,
        house: &House,
        (a, b): (MapPoint, MapPoint),
        doors: &[Doorway],
        rng: &mut Pcg64Mcg,
    ) {
        let top = house.eaves + if house.roof == Roof::Flat { PARAPET } else { 0.0 };
        wall(&mut self.builder, Layer::Both, house.facade, (a, b), (0.0, top));
        let length = a.distance(b);
        let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
        // Longer by as much as it stands out, so that it closes round the corners.
        let over = RELIEF / length.max(RELIEF);
        let raised = (along(a, b, -over).offset(out, RELIEF), along(a, b, 1.0 + over).offset(out, RELIEF));
        wall(&mut self.builder, Layer::Visible, house.plinth, raised, (0.0, PLINTH.min(house.eaves / 4.0)));
        let full = self.builder.triangles() >= super::MAX_TRIANGLES;
        if house.plain || full || length < 1.6 || self.is_party_wall(a, b, out) {
            return;
        }
        if house.string_courses && house.levels > 1 {
            let z = house.eaves / house.levels as f64;
            wall(&mut self.builder, Layer::Visible, house.trim, raised, (z - 0.1, z + 0.08));
        }
        let spans: Vec<(f64, f64)> = doors.iter().filter_map(|d| d.span_on((a, b))).collect();
        self.windows(house, (a, b), &spans, rng);
    }

    fn is_party_wall(&self, a: MapPoint, b: MapPoint, out: f64) -> bool {
        let middle = along(a, b, 0.5);
        !self.clearance.is_free(middle.offset(out, 0.4), middle.offset(out, 0.8), 0.2, BUILDING)
    }

    fn windows(
        &mut self,
        house: &House,
        (a, b): (MapPoint, MapPoint),
        doors: &[(f64, f64)],
        rng: &mut Pcg64Mcg,
    ) {
        let length = a.distance(b);
        let columns = (((length - 0.6) / house.spacing) as usize).clamp(1, MAX_COLUMNS);
        let half = house.window_size.0.min(length - 0.5) / 2.0;
        let storey = house.eaves / house.levels as f64;
        // A wall has its balconies one above the other.
        let balcony_columns: Vec<bool> =
            (0..columns).map(|i| house.balconies && length > 6.0 && i % 3 == 1 && chance(rng, 0.8)).collect();
        for (column, has_balcony) in balcony_columns.into_iter().enumerate() {
            let middle = length * (column as f64 + 0.5) / columns as f64;
            let pose = facing_out(a, b, middle / length);
            for level in 0..house.levels {
                let curtains = pick(rng, &[0, 1]);
                let in_door = |d: &&(f64, f64)| middle + half + 0.12 > d.0 && middle - half - 0.12 < d.1;
                if level == 0 && doors.iter().any(|d| in_door(&d)) {
                    continue;
                }
                let floor = level as f64 * storey;
                if level > 0 && has_balcony {
                    self.balcony(house, pose, floor, curtains);
                    continue;
                }
                let sill = floor + if level == 0 { 1.0 } else { 0.85 };
                let head = (sill + house.window_size.1).min(floor + storey - 0.2);
                self.window(house, pose, (half, sill, head), curtains);
            }
        }
    }

    fn window(&mut self, house: &House, pose: Pose2, (half, sill, head): (f64, f64, f64), curtains: usize) {
        let line = (pose.transform(RELIEF, -half), pose.transform(RELIEF, half));
        panel(&mut self.builder, Layer::Visible, house.windows[curtains], line, (sill, head));
        if house.detailed {
            let board = ([0.0, -half - 0.08, sill - 0.08], [0.14, half + 0.08, sill]);
            self.ledge(house, pose, board);
            let lintel = ([0.0, -half - 0.08, head], [0.06, half + 0.08, head + 0.12]);
            self.ledge(house, pose, lintel);
        }
    }

    /// Front and top of a board on the wall: four triangles where a box takes ten.
    fn ledge(&mut self, house: &House, pose: Pose2, (min, max): ([f64; 3], [f64; 3])) {
        let line = (pose.transform(max[0], min[1]), pose.transform(max[0], max[1]));
        wall(&mut self.builder, Layer::Visible, house.trim, line, (min[2], max[2]));
        let corners = [(max[0], min[1]), (max[0], max[1]), (min[0], max[1]), (min[0], min[1])];
        // From the ground only the underside of what is high up can be seen.
        let z = if min[2] > 1.5 { min[2] } else { max[2] };
        facet(
            &mut self.builder,
            Layer::Visible,
            house.trim,
            &corners.map(|(x, y)| at(pose.transform(x, y), z)),
        );
    }

    fn balcony(&mut self, house: &House, pose: Pose2, floor: f64, curtains: usize) {
        let (depth, half) = (1.1, 1.35);
        let line = (pose.transform(RELIEF, -0.75), pose.transform(RELIEF, 0.75));
        panel(&mut self.builder, Layer::Visible, house.windows[curtains], line, (floor + 0.1, floor + 2.25));
        let slab = ([0.0, -half, floor - 0.08], [depth, half, floor + 0.06]);
        cuboid(&mut self.builder, Layer::Visible, house.trim, pose, slab);
        let rail = self.palette.balcony_railings;
        let corners =
            [(0.0, -half), (depth, -half), (depth, half), (0.0, half)].map(|(x, y)| pose.transform(x, y));
        for pair in corners.windows(2) {
            super::barriers::see_through(
                &mut self.builder,
                rail,
                (pair[0], pair[1]),
                (floor + 0.06, floor + 1.06),
            );
        }
    }
}

/// At a share of the wall from `a` to `b`, facing away from the building on its left.
pub(super) fn facing_out(a: MapPoint, b: MapPoint, share: f64) -> Pose2 {
    let p = along(a, b, share);
    Pose2::new(p.x, p.y, a.bearing_to(b) - std::f64::consts::FRAC_PI_2)
}
