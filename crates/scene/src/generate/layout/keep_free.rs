//! What keeps its ground free: the map's own things, doors with their plates, and the start.

use openbench_core::MapPoint;
use openbench_geometry::{Polygon, Segment};
use openbench_osm::{OsmMap, Road};

use super::clearance::{
    BARRIER, BUILDING, Clearance, DOOR, DRIVEWAY, PATH, PAVED, ROAD, START, WATER,
};
use crate::generate::doors::doorway::Doorway;
use crate::generate::streets::profile::profile;
use crate::generate::water::open_water::is_water;

/// Half the width of what is kept free along a barrier, metres.
const BARRIER_RADIUS_M: f64 = 0.35;
/// Radius about the start in which nothing is placed, metres.
const START_RADIUS_M: f64 = 2.5;
/// Depth of the free space in front of a door and of a plate, metres.
const DOOR_DEPTH_M: f64 = 2.7;
/// Half the width of that space, metres.
const DOOR_HALF_WIDTH_M: f64 = 1.2;

/// What the map and the sea keep free.
pub(crate) fn of_map(map: &OsmMap, sea: &[Polygon]) -> Clearance {
    let mut clearance = Clearance::default();
    for building in &map.buildings {
        clearance.add_area(building.polygon.clone(), BUILDING);
    }
    for barrier in &map.barriers {
        clearance.add_line(&barrier.points, BARRIER_RADIUS_M, BARRIER);
    }
    for road in &map.roads {
        add_road(&mut clearance, road);
    }
    for area in &map.areas {
        if is_water(&area.tags) {
            clearance.add_area(area.polygon.clone(), PAVED | WATER);
        } else if area.tags.is("amenity", "parking") {
            clearance.add_area(area.polygon.clone(), PAVED);
        }
    }
    for water in sea {
        clearance.add_area(water.clone(), WATER);
    }
    clearance
}

fn add_road(clearance: &mut Clearance, road: &Road) {
    let Some(profile) = profile(&road.tags) else {
        return;
    };
    let kind = match road.tags.get("highway") {
        // Cars park at the kerb of a road, but never across a driveway.
        Some("service" | "track") => ROAD | DRIVEWAY,
        _ if profile.for_cars => ROAD,
        _ => PATH,
    };
    clearance.add_line(&road.points, profile.width / 2.0, kind);
    if profile.pavement > 0.0 {
        // The band covers the carriageway too, so PAVED alone keeps things off both.
        clearance.add_line(&road.points, profile.width / 2.0 + profile.pavement, PAVED);
    }
}

/// Keeps the ground in front of doors and plates free.
pub(crate) fn add_doorways(clearance: &mut Clearance, doorways: &[Doorway]) {
    for door in doorways {
        for p in [door.position, door.plate_point()] {
            // The capsule's round end adds its half width to this.
            let far = p.offset(door.facing, DOOR_DEPTH_M - DOOR_HALF_WIDTH_M);
            clearance.add(Segment::new(p, far), DOOR_HALF_WIDTH_M, DOOR);
        }
    }
}

/// Keeps the robot's start free.
pub(crate) fn add_start(clearance: &mut Clearance, start: MapPoint) {
    clearance.add_disc(start, START_RADIUS_M, START);
}
