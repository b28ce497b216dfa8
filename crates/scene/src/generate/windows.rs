//! Windows with sills and shutters, balconies, and the shops on ground floors.

use openbench_core::{MapPoint, Pose2};
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::buildings::House;
use super::clearance::{PATH, PAVED, ROAD};
use super::facades::{RELIEF, facing_out};
use super::seeds::{chance, pick};
use super::shapes::{Surface, along, at, cuboid, facet, panel, wall};
use crate::material::MaterialId;
use crate::scene::Layer;

/// Windows in one wall and floor at most: a wall is not longer than a street.
const MAX_COLUMNS: usize = 200;
/// Width of a window with its shutters, in widths of the window.
pub(super) const SHUTTERED: f64 = 1.8;
/// Shops look to a road or path that is so near, metres.
const SHOPPING: f64 = 7.0;
/// Height of a shop window's sill and of its head, metres.
const SHOP: (f64, f64) = (0.4, 2.25);

/// What the shops of a building have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shops {
    pub windows: [MaterialId; 2],
    pub sign: Surface,
    pub awning: Option<Surface>,
}

/// Where a window goes: the wall's direction there, and what the window leaves to both sides and below and above, metres.
#[derive(Debug, Clone, Copy)]
struct Opening {
    pose: Pose2,
    half: f64,
    sill: f64,
    head: f64,
}

impl Site {
    /// The windows of a wall above `hidden` metres, beside `doors` (from and to along the wall).
    pub(super) fn windows(
        &mut self,
        house: &House,
        (a, b): (MapPoint, MapPoint),
        (doors, hidden): (&[(f64, f64)], f64),
        rng: &mut Pcg64Mcg,
    ) {
        let length = a.distance(b);
        let columns = (((length - 0.6) / house.spacing) as usize).clamp(1, MAX_COLUMNS);
        let half = house
            .window_size
            .0
            .min(length - 0.5)
            .min(length / columns as f64 - 0.3)
            / 2.0;
        let storey = (house.eaves - house.foot) / house.levels as f64;
        let shops = house
            .shops
            .filter(|_| storey > 2.6 && length > 4.0 && self.looks_to_a_street(a, b));
        // A wall has its balconies one above the other.
        let balconies: Vec<bool> = (0..columns)
            .map(|i| house.balconies && length > 6.0 && i % 3 == 1 && chance(rng, 0.8))
            .collect();
        for (column, has_balcony) in balconies.into_iter().enumerate() {
            let middle = length * (column as f64 + 0.5) / columns as f64;
            let pose = facing_out(a, b, middle / length);
            for level in 0..house.levels {
                let curtains = pick(rng, &[0, 1]);
                let floor = house.foot + level as f64 * storey;
                let is_ground = level == 0 && house.foot == 0.0;
                let half = if is_ground && shops.is_some() {
                    length / columns as f64 * 0.43
                } else {
                    half
                };
                let in_door =
                    |d: &(f64, f64)| middle + half + 0.12 > d.0 && middle - half - 0.12 < d.1;
                if floor + 0.5 < hidden || is_ground && doors.iter().any(in_door) {
                    continue;
                }
                if let Some(shops) = shops.filter(|_| is_ground) {
                    self.shop(shops, pose, (half, curtains));
                } else if !is_ground && has_balcony {
                    self.balcony(house, pose, floor, curtains);
                } else {
                    let sill = floor + if is_ground { 1.0 } else { 0.85 };
                    let head = (sill + house.window_size.1).min(floor + storey - 0.2);
                    self.window(
                        house,
                        Opening {
                            pose,
                            half,
                            sill,
                            head,
                        },
                        curtains,
                    );
                }
            }
        }
    }

    fn looks_to_a_street(&self, a: MapPoint, b: MapPoint) -> bool {
        let before = along(a, b, 0.5).offset(a.bearing_to(b) - std::f64::consts::FRAC_PI_2, 1.0);
        self.clearance
            .distance(before, ROAD | PATH | PAVED, SHOPPING)
            < SHOPPING
    }

    fn shop(&mut self, shops: Shops, pose: Pose2, (half, look): (f64, usize)) {
        let builder = &mut self.builder;
        let line = |out: f64| (pose.transform(out, -half), pose.transform(out, half));
        panel(
            builder,
            Layer::Visible,
            shops.windows[look],
            line(RELIEF + 0.01),
            SHOP,
        );
        wall(
            builder,
            Layer::Visible,
            shops.sign,
            line(RELIEF + 0.04),
            (SHOP.1 + 0.06, SHOP.1 + 0.42),
        );
        if let Some(cloth) = shops.awning {
            let ((c, d), (a, b)) = (line(0.05), line(0.95));
            let slope = [
                at(a, SHOP.1 - 0.12),
                at(b, SHOP.1 - 0.12),
                at(d, SHOP.1 + 0.3),
                at(c, SHOP.1 + 0.3),
            ];
            facet(builder, Layer::Visible, cloth, &slope);
            wall(
                builder,
                Layer::Visible,
                cloth,
                (a, b),
                (SHOP.1 - 0.3, SHOP.1 - 0.12),
            );
        }
    }

    fn window(&mut self, house: &House, opening: Opening, curtains: usize) {
        let Opening {
            pose,
            half,
            sill,
            head,
        } = opening;
        let wide = if house.shuttered {
            half * SHUTTERED
        } else {
            half
        };
        let line = (pose.transform(RELIEF, -wide), pose.transform(RELIEF, wide));
        panel(
            &mut self.builder,
            Layer::Visible,
            house.windows[curtains],
            line,
            (sill, head),
        );
        if house.detailed {
            let board = ([0.0, -half - 0.08, sill - 0.08], [0.14, half + 0.08, sill]);
            self.ledge(house, pose, board);
            if !house.shuttered {
                let lintel = ([0.0, -half - 0.08, head], [0.06, half + 0.08, head + 0.12]);
                self.ledge(house, pose, lintel);
            }
        }
    }

    /// Front and top of a board on the wall: four triangles where a box takes ten.
    fn ledge(&mut self, house: &House, pose: Pose2, (min, max): ([f64; 3], [f64; 3])) {
        let line = (
            pose.transform(max[0], min[1]),
            pose.transform(max[0], max[1]),
        );
        wall(
            &mut self.builder,
            Layer::Visible,
            house.trim,
            line,
            (min[2], max[2]),
        );
        let corners = [
            (max[0], min[1]),
            (max[0], max[1]),
            (min[0], max[1]),
            (min[0], min[1]),
        ];
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
        panel(
            &mut self.builder,
            Layer::Visible,
            house.windows[curtains],
            line,
            (floor + 0.1, floor + 2.25),
        );
        let slab = ([0.0, -half, floor - 0.08], [depth, half, floor + 0.06]);
        cuboid(&mut self.builder, Layer::Visible, house.trim, pose, slab);
        let rail = self.palette.balcony_railings;
        let corners = [(0.0, -half), (depth, -half), (depth, half), (0.0, half)]
            .map(|(x, y)| pose.transform(x, y));
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
