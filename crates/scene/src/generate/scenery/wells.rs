//! Light wells and basement areas beside houses: places where the ground is missing. Half of them
//! have a low rim; the others have none.

use openbench_geometry::{Segment, sides};
use openbench_osm::Building;

use super::kinds::Footprint;
use super::passage::stays_open;
use super::relief::{RIM_M, Well};
use super::site::{Site, keeps_off_gates, shifted};
use super::streams::{Purpose, stream};
use crate::generate::buildings::house::is_open_below;
use crate::generate::buildings::walls::walls;
use crate::generate::doors::entrances::is_home;
use crate::generate::ground::aprons::{WIDTH_M, is_in_town};
use crate::generate::ground::covers::is_covered;
use crate::generate::ground::pitted::{frame_of, lies_in};
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{
    BARRIER, BUILDING, DOOR, DRIVEWAY, OBJECT, PATH, PAVED, ROAD, START, WATER,
};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{between, chance, element_number, pick};
use crate::generate::shapes::{Block, at, cuboid, facet, wall};
use crate::material::SemanticClass;
use crate::scene::Layer;

/// Share of the houses with a well where there is most relief.
const SHARE: f64 = 0.7;
/// Wells of a world at most: each is a hole in one outline.
const MOST: usize = 60;
/// Distance of a well from its wall, metres.
const FROM_WALL_M: f64 = 0.03;
/// Distance of a well from the ends of its wall, metres.
const FROM_CORNER_M: f64 = 0.5;
/// Free ground around a well, metres.
const AROUND_M: f64 = 0.5;
/// Draws which houses have a well.
pub(super) fn plan(site: &Site, occupied: &mut Occupied) -> Vec<Well> {
    let mut wells: Vec<Well> = Vec::new();
    if site.has_sea {
        return wells;
    }
    for building in &site.map.buildings {
        let mut rng = stream(
            site.options.seed,
            Purpose::Well,
            element_number(building.element),
        );
        let is_wanted = chance(&mut rng, SHARE * site.options.amounts.relief);
        let wall = pick(&mut rng, &walls(building));
        let share = between(&mut rng, 0.15, 0.85);
        let half = between(&mut rng, 0.6, 1.5);
        let well = Well {
            pose: shifted(wall.facing_out(share), FROM_WALL_M, 0.0),
            half,
            width: between(&mut rng, 0.7, 1.0),
            depth: between(&mut rng, 0.5, 1.2),
            rim: pick(&mut rng, &[0.0, between_rims(share)]),
        };
        let along = wall.length() * share;
        let is_within = along.min(wall.length() - along) > half + FROM_CORNER_M;
        if !is_wanted
            || !is_within
            || !is_house(building)
            || wells.len() >= MOST
            || !has_room(site, &well)
        {
            continue;
        }
        let ground = well.footprint();
        let is_free = occupied.is_free(ground.axis, ground.radius, OBJECT)
            && can_be_cut_out(site, &well, &wells);
        if is_free && stays_open(occupied, ground.axis, ground.radius) {
            occupied.add(ground.axis, ground.radius);
            wells.push(well);
        }
    }
    wells
}

/// Whether a building may have a well: it stands on the ground, and is no shed or garage.
fn is_house(building: &Building) -> bool {
    is_home(building) && !is_open_below(&building.tags)
}

/// Whether the ground can be cut out at a well: its frame touches no other and is in the ground.
fn can_be_cut_out(site: &Site, well: &Well, wells: &[Well]) -> bool {
    let frame = frame_of(&well.ring());
    let mut others = wells.iter().map(|other| frame_of(&other.ring()));
    lies_in(frame, site.ground) && !others.any(|other| other.meets(frame, 0.0))
}

/// A height of a rim from 10 to 14 cm, by a share.
fn between_rims(share: f64) -> f64 {
    0.10 + 0.04 * share
}

fn has_room(site: &Site, well: &Well) -> bool {
    let Footprint { axis, radius } = well.footprint();
    // Beyond the half at the wall, which is a building itself.
    let outer = Segment::new(
        well.pose.transform(well.width, -well.half),
        well.pose.transform(well.width, well.half),
    );
    let in_the_way = BARRIER | ROAD | PATH | DOOR | START | PAVED | DRIVEWAY | WATER;
    let middle = axis.middle();
    let is_bare = site.map.areas.iter().all(|area| {
        let bounds = area.polygon.bounds();
        !bounds.holds(middle, radius + well.half) || !area.polygon.contains(middle)
    });
    let features = site.features.iter();
    let has_features = features
        .map(|feature| axis.distance_to_point(feature.position))
        .any(|distance| distance < radius + AROUND_M);
    is_bare
        && !has_features
        && site.clearance.is_free(axis, radius + AROUND_M, in_the_way)
        && site.clearance.is_free(outer, well.width * 0.8, BUILDING)
        && !is_paved_around(site, axis, radius)
        && !is_covered_at(site, well)
        && keeps_off_gates(site.gates, axis, radius)
}

/// Whether the paved ground around a building of a town reaches the ground of a well.
fn is_paved_around(site: &Site, axis: Segment, radius: f64) -> bool {
    let reach = WIDTH_M + axis.length() / 2.0 + radius;
    let near = site.map.buildings_within(axis.middle(), reach);
    let mut middles = near
        .into_iter()
        .map(|i| site.map.buildings[i].polygon.centroid());
    middles.any(|middle| is_in_town(site.map, middle))
}

/// Whether a side of a well lies in an area that covers the ground.
fn is_covered_at(site: &Site, well: &Well) -> bool {
    let ring = well.ring();
    let frame = frame_of(&ring);
    let covers = site.map.areas.iter().filter(|area| is_covered(&area.tags));
    let mut near = covers.filter(|area| area.polygon.bounds().meets(frame, 0.0));
    near.any(|area| {
        let polygon = &area.polygon;
        ring.iter().any(|corner| polygon.contains(*corner))
            || sides(&ring).any(|side| polygon.sides().any(|edge| edge.distance_to(side) < RIM_M))
    })
}

/// Builds the walls, floors and rims of the wells.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    let palette = &inputs.palette;
    for well in &inputs.relief.wells {
        out.scene.begin_object("light well", SemanticClass::Wall);
        let ring = well.ring();
        for i in 0..4 {
            // Seen from inside.
            let side = Segment::new(ring[(i + 1) % 4], ring[i]);
            let z = -well.depth..0.0;
            wall(&mut out.scene, Layer::Both, palette.quay, side, z);
        }
        let floor = ring.map(|p| at(p, -well.depth));
        facet(&mut out.scene, Layer::Both, palette.gravel, &floor);
        if well.rim > 0.0 {
            rim(inputs, out, well);
        }
        out.drawn_scenery.wells += 1;
    }
}

/// Stones on three sides.
fn rim(inputs: &Inputs, out: &mut Output, well: &Well) {
    let Well {
        half, width, rim, ..
    } = *well;
    let blocks = [
        Block {
            min: [0.0, -half - RIM_M, 0.0],
            max: [width + RIM_M, -half, rim],
        },
        Block {
            min: [0.0, half, 0.0],
            max: [width + RIM_M, half + RIM_M, rim],
        },
        Block {
            min: [width, -half, 0.0],
            max: [width + RIM_M, half, rim],
        },
    ];
    for block in blocks {
        let stone = inputs.palette.coping;
        cuboid(&mut out.scene, Layer::Both, stone, well.pose, block);
    }
}

#[cfg(test)]
mod tests {
    use openbench_geometry::signed_area;

    use openbench_core::{MapPoint, Pose2};

    use super::*;

    #[test]
    fn a_well_is_a_rectangle_outside_of_its_wall() {
        let well = Well {
            pose: Pose2::new(3.0, 4.0, 1.0),
            half: 0.8,
            width: 0.9,
            depth: 1.0,
            rim: 0.0,
        };
        assert!((signed_area(&well.ring()) - 1.6 * 0.9).abs() < 1e-9);
        let ground = well.footprint();
        let holds = |p: &MapPoint| ground.axis.distance_to_point(*p) < ground.radius;
        assert!(well.ring().iter().all(holds));
        for left in [-0.8 - RIM_M, 0.8 + RIM_M] {
            let corners = [0.0, 0.9 + RIM_M].map(|forward| well.pose.transform(forward, left));
            assert!(corners.iter().all(holds));
        }
    }
}
