//! Windows with sills and shutters, balconies, and the shops on ground floors.

use std::ops::Range;

use openbench_core::Pose2;
use openbench_geometry::{Segment, segments};
use rand_pcg::Pcg64Mcg;

use super::house::{House, RELIEF_M, Shops};
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{PATH, PAVED, ROAD};
use crate::generate::materials::openings::SHUTTERED_WIDTHS;
use crate::generate::output::Output;
use crate::generate::seeds::{chance, pick};
use crate::generate::shapes::{Block, Surface, at, cuboid, facet, panel, see_through, wall};
use crate::scene::{Layer, SceneBuilder};

/// Windows in one wall and floor at most: a wall is not longer than a street.
const MAX_COLUMNS: usize = 200;
/// Shops look to a road or path that is this near, metres.
const SHOPPING_M: f64 = 7.0;
/// Height of a shop window's sill, metres.
const SHOP_SILL_M: f64 = 0.4;
/// Height of a shop window's head, metres.
const SHOP_HEAD_M: f64 = 2.25;
/// Lowest storey with shops, metres.
const SHOP_STOREY_M: f64 = 2.6;
/// Depth of a balcony, metres.
const BALCONY_DEPTH_M: f64 = 1.1;
/// Half the width of a balcony, metres.
const BALCONY_HALF_WIDTH_M: f64 = 1.35;
/// Wall between a window and a door or plate, metres.
const DOOR_MARGIN_M: f64 = 0.12;
/// From the ground only the underside of what is higher than this can be seen, metres.
const EYE_HEIGHT_M: f64 = 1.5;

/// Where a window goes, metres.
#[derive(Debug, Clone, Copy)]
struct Opening {
    /// In the middle of the window, facing out of the wall.
    pose: Pose2,
    /// Half the width.
    half: f64,
    /// Height of the lower edge.
    sill: f64,
    /// Height of the upper edge.
    head: f64,
}

/// The windows of a wall above `hidden` metres, beside `doors` (spans along the wall).
pub(super) fn build(
    inputs: &Inputs,
    out: &mut Output,
    house: &House,
    line: Segment,
    doors: &[Range<f64>],
    hidden: f64,
    rng: &mut Pcg64Mcg,
) {
    let length = line.length();
    let columns = (((length - 0.6) / house.spacing) as usize).clamp(1, MAX_COLUMNS);
    let column_width = length / columns as f64;
    // Some wall is left at both ends, and between two windows.
    let half = house.window_width.min(length - 0.5).min(column_width - 0.3) / 2.0;
    let storey = house.storey();
    let has_room = storey > SHOP_STOREY_M && length > 4.0;
    // A shop looks onto a road, a path or paved ground.
    let shops = house
        .shops
        .filter(|_| has_room && looks_to_street(inputs, line));
    // A wall has its balconies one above the other.
    let balconies: Vec<bool> = (0..columns)
        .map(|i| house.balconies && length > 6.0 && i % 3 == 1 && chance(rng, 0.8))
        .collect();
    for (column, has_balcony) in balconies.into_iter().enumerate() {
        let middle = length * (column as f64 + 0.5) / columns as f64;
        let pose = line.facing_out(middle / length);
        for level in 0..house.levels {
            // Drawn for every place, so that a door does not change the windows after it.
            let look = pick(rng, &[0, 1]);
            let floor = house.foot + level as f64 * storey;
            let is_ground = level == 0 && house.foot == 0.0;
            let is_shop = is_ground && shops.is_some();
            // Shop windows leave only narrow pillars between them.
            let half = if is_shop { column_width * 0.43 } else { half };
            let in_door = |door: &Range<f64>| {
                middle + half + DOOR_MARGIN_M > door.start
                    && middle - half - DOOR_MARGIN_M < door.end
            };
            // Another part of the building hides more than the lowest half metre of this storey.
            if floor + 0.5 < hidden || is_ground && doors.iter().any(in_door) {
                continue;
            }
            let scene = &mut out.scene;
            if let Some(shops) = shops.filter(|_| is_ground) {
                shop(scene, shops, pose, half, look);
            } else if !is_ground && has_balcony {
                let railing = inputs.palette.balcony_railings;
                balcony(scene, house, pose, floor, look);
                balcony_railing(scene, railing, pose, floor);
            } else {
                let sill = floor + if is_ground { 1.0 } else { 0.85 };
                let head = (sill + house.window_height).min(floor + storey - 0.2);
                window(
                    scene,
                    house,
                    Opening {
                        pose,
                        half,
                        sill,
                        head,
                    },
                    look,
                );
            }
        }
    }
}

fn looks_to_street(inputs: &Inputs, line: Segment) -> bool {
    let before = line.middle().offset(line.outward(), 1.0);
    let street = ROAD | PATH | PAVED;
    inputs.clearance.distance(before, street, SHOPPING_M) < SHOPPING_M
}

fn shop(scene: &mut SceneBuilder, shops: Shops, pose: Pose2, half: f64, look: usize) {
    let line = |out: f64| Segment::across(pose, out, half);
    let visible = Layer::Visible;
    let window = SHOP_SILL_M..SHOP_HEAD_M;
    panel(
        scene,
        visible,
        shops.windows[look],
        line(RELIEF_M + 0.01),
        window,
    );
    let sign = SHOP_HEAD_M + 0.06..SHOP_HEAD_M + 0.42;
    wall(scene, visible, shops.sign, line(RELIEF_M + 0.04), sign);
    if let Some(cloth) = shops.awning {
        let (back, front) = (line(0.05), line(0.95));
        let (low, high) = (SHOP_HEAD_M - 0.12, SHOP_HEAD_M + 0.3);
        let slope = [
            at(front.start, low),
            at(front.end, low),
            at(back.end, high),
            at(back.start, high),
        ];
        facet(scene, visible, cloth, &slope);
        wall(scene, visible, cloth, front, SHOP_HEAD_M - 0.3..low);
    }
}

fn window(scene: &mut SceneBuilder, house: &House, opening: Opening, look: usize) {
    let Opening {
        pose,
        half,
        sill,
        head,
    } = opening;
    let wide = if house.shuttered {
        half * SHUTTERED_WIDTHS
    } else {
        half
    };
    let line = Segment::across(pose, RELIEF_M, wide);
    panel(scene, Layer::Visible, house.windows[look], line, sill..head);
    if !house.detailed {
        return;
    }
    let side = half + 0.08;
    let board = Block {
        min: [0.0, -half - 0.08, sill - 0.08],
        max: [0.14, side, sill],
    };
    ledge(scene, house, pose, board);
    if !house.shuttered {
        let lintel = Block {
            min: [0.0, -half - 0.08, head],
            max: [0.06, side, head + 0.12],
        };
        ledge(scene, house, pose, lintel);
    }
}

/// Front and top of a board on the wall: four triangles where a box takes ten.
fn ledge(scene: &mut SceneBuilder, house: &House, pose: Pose2, Block { min, max }: Block) {
    let line = Segment::new(
        pose.transform(max[0], min[1]),
        pose.transform(max[0], max[1]),
    );
    wall(scene, Layer::Visible, house.trim, line, min[2]..max[2]);
    // Either its underside or its top is seen from the ground, never both.
    let z = if min[2] > EYE_HEIGHT_M {
        min[2]
    } else {
        max[2]
    };
    let corners = [
        [max[0], min[1]],
        [max[0], max[1]],
        [min[0], max[1]],
        [min[0], min[1]],
    ];
    let corners = corners.map(|[x, y]| at(pose.transform(x, y), z));
    facet(scene, Layer::Visible, house.trim, &corners);
}

/// A balcony's door and slab.
fn balcony(scene: &mut SceneBuilder, house: &House, pose: Pose2, floor: f64, look: usize) {
    let line = Segment::across(pose, RELIEF_M, 0.75);
    panel(
        scene,
        Layer::Visible,
        house.windows[look],
        line,
        floor + 0.1..floor + 2.25,
    );
    let slab = Block {
        min: [0.0, -BALCONY_HALF_WIDTH_M, floor - 0.08],
        max: [BALCONY_DEPTH_M, BALCONY_HALF_WIDTH_M, floor + 0.06],
    };
    cuboid(scene, Layer::Visible, house.trim, pose, slab);
}

fn balcony_railing(scene: &mut SceneBuilder, railing: Surface, pose: Pose2, floor: f64) {
    let (depth, half) = (BALCONY_DEPTH_M, BALCONY_HALF_WIDTH_M);
    let corners = [[0.0, -half], [depth, -half], [depth, half], [0.0, half]];
    let corners = corners.map(|[x, y]| pose.transform(x, y));
    for line in segments(&corners) {
        see_through(scene, railing, line, floor + 0.06..floor + 1.06);
    }
}
