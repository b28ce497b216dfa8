//! What a robot's sensors meet in a world under the conditions of a suite.

use openbench_core::MapPoint;
use openbench_osm::{OsmMap, Road};
use openbench_scene::World;
use openbench_sim::Surroundings;

use crate::suite::{Conditions, draw_lens};

/// Distance between street lamps along a road, metres.
const LAMP_SPACING_M: f64 = 30.0;
/// Distance of lamps from the middle of the road, metres.
const LAMP_OFFSET_M: f64 = 4.5;
/// Another lamp is not as near as this, metres: where roads meet.
const LEAST_SPACING_M: f64 = 15.0;
/// Most street lamps of a world.
const MOST_LAMPS: usize = 5000;
/// Values of `highway` of the streets that are lit, unless `lit=no`.
const LIT_STREETS: [&str; 9] = [
    "primary",
    "secondary",
    "tertiary",
    "unclassified",
    "residential",
    "living_street",
    "pedestrian",
    "service",
    "road",
];

/// What the sensors of a robot meet: it depends on the seed of the run alone.
pub fn surroundings(world: &World, conditions: &Conditions, seed: u64) -> Surroundings {
    let map = OsmMap::new(&world.map, world.georeference);
    let latitude = map.projection.to_lonlat(world.start.point()).lat;
    let light = conditions.light.draw(seed, latitude);
    let is_lit = light.is_some_and(|light| light.lamps);
    Surroundings {
        camera: conditions.camera,
        lens: draw_lens(&conditions.camera, conditions.weather.lens_drops(), seed),
        weather: conditions.weather,
        lidar: conditions.lidar,
        light,
        street_lamps: if is_lit {
            street_lamps(&map)
        } else {
            Vec::new()
        },
    }
}

/// Places for lamps along the streets of a map, on either side in turn, where no building is.
fn street_lamps(map: &OsmMap) -> Vec<MapPoint> {
    let mut lamps: Vec<MapPoint> = Vec::new();
    for road in map.roads.iter().filter(|road| is_lit(road)) {
        let mut left = LAMP_SPACING_M / 2.0;
        let mut side = 1.0;
        for pair in road.points.windows(2) {
            let (length, bearing) = (pair[0].distance(pair[1]), pair[0].bearing_to(pair[1]));
            let mut along = left;
            while along < length {
                let middle = pair[0].offset(bearing, along);
                let place =
                    middle.offset(bearing + side * std::f64::consts::FRAC_PI_2, LAMP_OFFSET_M);
                let is_free = map.buildings_within(place, 0.5).is_empty();
                let is_near = |lamp: &MapPoint| lamp.distance(place) < LEAST_SPACING_M;
                if is_free && !lamps.iter().any(is_near) {
                    lamps.push(place);
                }
                if lamps.len() == MOST_LAMPS {
                    return lamps;
                }
                side = -side;
                along += LAMP_SPACING_M;
            }
            left = along - length;
        }
    }
    lamps
}

fn is_lit(road: &Road) -> bool {
    let is_street = road
        .tags
        .get("highway")
        .is_some_and(|kind| LIT_STREETS.contains(&kind));
    is_street && road.tags.get("lit") != Some("no")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WorldSource;
    use crate::worlds::load;

    #[test]
    fn streets_are_lit_at_night_and_not_by_day() {
        let source = WorldSource::Builtin {
            name: "small".to_owned(),
            seed: 1,
        };
        let world = load(&source).unwrap();
        let at = |level: &str| {
            let mut conditions = Conditions::default();
            conditions.set("light", level).unwrap();
            surroundings(&world, &conditions, 3)
        };
        assert_eq!(at("noon"), Surroundings::default());
        assert!(at("day").street_lamps.is_empty());
        let night = at("night");
        // One every 30 m of a short street.
        assert!(
            night.street_lamps.len() >= 2,
            "{}",
            night.street_lamps.len()
        );
        assert_eq!(night, at("night"));
    }
}
