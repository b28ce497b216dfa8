//! Doors: anywhere in the walls that a robot reaches, so that no rule finds them.

use std::f64::consts::{FRAC_PI_2, PI};

use openbench_core::MapPoint;
use openbench_core::frames::wrap_angle;
use openbench_geometry::{Segment, sides};
use openbench_osm::draws::{between, chance, pick};
use rand_pcg::Pcg64Mcg;

use crate::plan::{Door, Home, HomeKind};
use crate::purpose::{Purpose, Seed, whole};
use crate::reach::Reach;

/// Distance of a door's middle from the ends of its wall, metres.
const FROM_CORNER_M: f64 = 0.9;
/// Distance between the places for doors in a wall, metres.
const STEP_M: f64 = 0.25;
/// Distance between the doors of one building, metres.
const APART_M: f64 = 2.4;
/// Where in front of a door a robot must be able to stand, metres.
const BEFORE_M: [f64; 2] = [1.1, 1.6];
/// Free space to each side of the line in front of a door, metres.
const HALF_WIDTH_M: f64 = 0.5;
/// Weights of walls: towards the street, at the sides, at the back.
const WEIGHTS: [f64; 3] = [0.42, 0.36, 0.22];

/// The side of a house in which a wall is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Face {
    Front,
    Flank,
    Back,
}

impl Face {
    const ALL: [Self; 3] = [Self::Front, Self::Flank, Self::Back];
}

/// A place where a door may be.
#[derive(Debug, Clone, Copy)]
struct Place {
    wall: Segment,
    at: MapPoint,
    face: Face,
    /// Metres along the outline.
    around: f64,
}

/// The walls of all homes, in their order.
pub(crate) fn walls_of(homes: &[Home]) -> Vec<Segment> {
    let rings = homes.iter().flat_map(|home| {
        let court = home.court.iter().map(Vec::as_slice);
        std::iter::once(home.outer.as_slice()).chain(court)
    });
    rings.flat_map(sides).collect()
}

/// Draws the doors of a home.
pub(crate) fn place(seed: Seed, home: &Home, reach: &Reach, walls: &[Segment]) -> Vec<Door> {
    let mut draws = seed.stream(Purpose::Doors, home.stream);
    let mut places = places(home, reach, walls);
    let weights = weights(home, &mut draws);
    let mut chosen: Vec<Place> = Vec::new();
    while chosen.len() < home.wanted_doors {
        let Some(place) = choose(&places, weights, &mut draws) else {
            break;
        };
        places.retain(|other| other.at.distance(place.at) > APART_M);
        chosen.push(place);
    }
    if chosen.len() > 1 {
        chosen.sort_by(|a, b| a.around.total_cmp(&b.around));
        let first = whole(&mut draws, 0, chosen.len() as u32 - 1);
        chosen.rotate_left(first as usize);
        if chance(&mut draws, 0.5) {
            chosen.reverse();
        }
    }
    let units = units(chosen.len(), &mut draws);
    let main = whole(&mut draws, 0, chosen.len().max(1) as u32 - 1) as usize;
    let numbered = chosen.into_iter().zip(units).enumerate();
    numbered
        .map(|(i, (place, unit))| Door {
            wall: place.wall,
            at: place.at,
            unit,
            main: i == main,
        })
        .collect()
}

/// How likely each face is, in the order of [`Face::ALL`].
fn weights(home: &Home, draws: &mut Pcg64Mcg) -> [f64; 3] {
    // The staircases of a slab are on one of its long sides.
    let is_front = chance(draws, 0.5);
    match home.kind {
        HomeKind::Slab if is_front => [0.8, 0.1, 0.1],
        HomeKind::Slab => [0.1, 0.1, 0.8],
        HomeKind::Terraced | HomeKind::Row => [0.75, 0.1, 0.15],
        _ => WEIGHTS,
    }
}

fn choose(places: &[Place], weights: [f64; 3], draws: &mut Pcg64Mcg) -> Option<Place> {
    let of = |face: Face| places.iter().filter(move |place| place.face == face);
    let weight = |face: Face| {
        let is_there = of(face).next().is_some();
        if is_there {
            weights[face as usize]
        } else {
            0.0
        }
    };
    let sum: f64 = Face::ALL.into_iter().map(weight).sum();
    let mut left = between(draws, 0.0, sum);
    let drawn = Face::ALL.into_iter().find(|face| {
        left -= weight(*face);
        left < 0.0
    });
    let face = drawn.or_else(|| places.last().map(|place| place.face))?;
    let candidates: Vec<Place> = of(face).copied().collect();
    (!candidates.is_empty()).then(|| pick(draws, &candidates))
}

/// All places in the outline where a door may be.
fn places(home: &Home, reach: &Reach, walls: &[Segment]) -> Vec<Place> {
    let (mut found, mut around) = (Vec::new(), 0.0);
    for wall in sides(&home.outer) {
        let length = wall.length();
        let steps = ((length - 2.0 * FROM_CORNER_M) / STEP_M).floor();
        if steps >= 0.0 {
            for i in 0..=steps as usize {
                let along = FROM_CORNER_M + i as f64 * STEP_M;
                let at = wall.at(along / length);
                if is_free(wall, at, reach, walls) {
                    found.push(Place {
                        wall,
                        at,
                        face: face(home, wall),
                        around: around + along,
                    });
                }
            }
        }
        around += length;
    }
    found
}

fn is_free(wall: Segment, at: MapPoint, reach: &Reach, walls: &[Segment]) -> bool {
    let out = wall.outward();
    let front = Segment::new(
        at.offset(out, HALF_WIDTH_M + 0.05),
        at.offset(out, BEFORE_M[1]),
    );
    BEFORE_M.iter().all(|d| reach.holds(at.offset(out, *d)))
        && walls
            .iter()
            .all(|other| front.distance_to(*other) > HALF_WIDTH_M)
}

fn face(home: &Home, wall: Segment) -> Face {
    // Away from the front, which faces against the y axis of the home.
    let off = wrap_angle(wall.outward() - home.pose.yaw + FRAC_PI_2).abs();
    if off < 0.3 * PI {
        Face::Front
    } else if off > 0.7 * PI {
        Face::Back
    } else {
        Face::Flank
    }
}

/// The units of so many doors.
fn units(count: usize, draws: &mut Pcg64Mcg) -> Vec<String> {
    let share = between(draws, 0.0, 1.0);
    // One number may be left out, as where two flats were joined.
    let gap = (chance(draws, 0.1) && count > 2).then(|| whole(draws, 2, count as u32));
    let number = |i: usize| {
        let plain = i as u32 + 1;
        plain + u32::from(gap.is_some_and(|gap| plain >= gap))
    };
    (0..count)
        .map(|i| {
            let letter = char::from(b'A' + (i % 26) as u8);
            match share {
                share if share < 0.12 && count > 1 => letter.to_string(),
                share if share < 0.18 && count > 2 => (100 + number(i)).to_string(),
                _ => number(i).to_string(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;

    #[test]
    fn the_units_of_a_building_are_different() {
        for seed in 0..200 {
            let mut draws = Seed::new(Kind::Small, seed).stream(Purpose::Doors, 0);
            let mut names = units(20, &mut draws);
            names.sort();
            names.dedup();
            assert_eq!(names.len(), 20);
        }
    }
}
