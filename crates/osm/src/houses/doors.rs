//! Doors: anywhere in the walls that are free, so that no rule finds them.

use std::f64::consts::PI;

use openbench_core::MapPoint;
use openbench_core::frames::wrap_angle;
use openbench_geometry::Segment;
use rand_pcg::Pcg64Mcg;

use super::units::units;
use crate::draws::{between, chance, pick, whole};

/// Distance of a door's middle from the ends of its wall, metres.
const FROM_CORNER_M: f64 = 0.9;
/// Distance between the places for doors in a wall, metres.
const STEP_M: f64 = 0.25;
/// Distance between the doors of one building, metres.
const APART_M: f64 = 2.4;

/// The side of a house in which a wall is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Face {
    /// Towards the street.
    Front,
    /// At the left or right.
    Flank,
    /// Away from the street.
    Back,
}

impl Face {
    /// All of them, in the order of [`FaceWeights`].
    pub const ALL: [Self; 3] = [Self::Front, Self::Flank, Self::Back];

    /// The side of a wall, of a house whose front faces the direction `front`, radians.
    pub fn of(wall: Segment, front: f64) -> Self {
        let off = wrap_angle(wall.outward() - front).abs();
        if off < 0.3 * PI {
            Self::Front
        } else if off > 0.7 * PI {
            Self::Back
        } else {
            Self::Flank
        }
    }
}

/// How often a door is on each side of a house where all of them are free; the sum is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceWeights {
    /// Towards the street.
    pub front: f64,
    /// At the left and right.
    pub flank: f64,
    /// Away from the street.
    pub back: f64,
}

impl FaceWeights {
    /// Of most houses.
    pub const USUAL: Self = Self {
        front: 0.42,
        flank: 0.36,
        back: 0.22,
    };
    /// Of houses in rows.
    pub const IN_ROW: Self = Self {
        front: 0.75,
        flank: 0.1,
        back: 0.15,
    };

    /// Of a slab, whose staircases are along one of its long sides: the front, or the back.
    pub const fn of_slab(is_front: bool) -> Self {
        let (front, back) = if is_front { (0.8, 0.1) } else { (0.1, 0.8) };
        Self {
            front,
            flank: 0.1,
            back,
        }
    }

    fn of(self, face: Face) -> f64 {
        match face {
            Face::Front => self.front,
            Face::Flank => self.flank,
            Face::Back => self.back,
        }
    }
}

/// Which doors a house shall have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoorWish {
    /// How many, if there is room for them.
    pub count: usize,
    /// The direction that the front faces, radians.
    pub front: f64,
    /// How often each side has one.
    pub weights: FaceWeights,
}

/// A door that was drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnDoor {
    /// The wall that it is in, the house on the left.
    pub wall: Segment,
    /// Its foot, in the wall.
    pub at: MapPoint,
    /// The side of the house.
    pub face: Face,
    /// Its unit, which no other door of the house has.
    pub unit: String,
    /// Whether it is the main door; one of them is.
    pub main: bool,
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

/// Draws the doors of a house in its walls, at places that are free; in an order in which the
/// units go around the house. There are fewer than wished where there is no room.
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_geometry::sides;
/// use openbench_osm::draws::stream;
/// use openbench_osm::houses::{DoorWish, FaceWeights, draw_doors};
///
/// let corners = [(0.0, 0.0), (12.0, 0.0), (12.0, 9.0), (0.0, 9.0)];
/// let corners = corners.map(|(x, y)| MapPoint::new(x, y));
/// let wish = DoorWish {
///     count: 2,
///     front: -std::f64::consts::FRAC_PI_2,
///     weights: FaceWeights::USUAL,
/// };
/// let doors = draw_doors(sides(&corners), wish, |_, _| true, &mut stream(7, 1, 42));
/// assert_eq!(doors.len(), 2);
/// assert!(doors[0].at.distance(doors[1].at) > 2.4);
/// ```
pub fn draw_doors(
    walls: impl Iterator<Item = Segment>,
    wish: DoorWish,
    is_free: impl Fn(Segment, MapPoint) -> bool,
    draws: &mut Pcg64Mcg,
) -> Vec<DrawnDoor> {
    let mut places = places(walls, wish.front, is_free);
    let mut chosen: Vec<Place> = Vec::new();
    while chosen.len() < wish.count {
        let Some(place) = choose(&places, wish.weights, draws) else {
            break;
        };
        places.retain(|other| other.at.distance(place.at) > APART_M);
        chosen.push(place);
    }
    if chosen.len() > 1 {
        chosen.sort_by(|a, b| a.around.total_cmp(&b.around));
        let first = whole(draws, 0, chosen.len() as u32 - 1);
        chosen.rotate_left(first as usize);
        if chance(draws, 0.5) {
            chosen.reverse();
        }
    }
    let units = units(chosen.len(), draws);
    let main = whole(draws, 0, chosen.len().max(1) as u32 - 1) as usize;
    let numbered = chosen.into_iter().zip(units).enumerate();
    numbered
        .map(|(i, (place, unit))| DrawnDoor {
            wall: place.wall,
            at: place.at,
            face: place.face,
            unit,
            main: i == main,
        })
        .collect()
}

fn choose(places: &[Place], weights: FaceWeights, draws: &mut Pcg64Mcg) -> Option<Place> {
    let of = |face: Face| places.iter().filter(move |place| place.face == face);
    let weight = |face: Face| {
        let is_there = of(face).next().is_some();
        if is_there { weights.of(face) } else { 0.0 }
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

/// All places in the walls where a door may be.
fn places(
    walls: impl Iterator<Item = Segment>,
    front: f64,
    is_free: impl Fn(Segment, MapPoint) -> bool,
) -> Vec<Place> {
    let (mut found, mut around) = (Vec::new(), 0.0);
    for wall in walls {
        let length = wall.length();
        let steps = ((length - 2.0 * FROM_CORNER_M) / STEP_M).floor();
        if steps >= 0.0 {
            for i in 0..=steps as usize {
                let along = FROM_CORNER_M + i as f64 * STEP_M;
                let at = wall.at(along / length);
                if is_free(wall, at) {
                    found.push(Place {
                        wall,
                        at,
                        face: Face::of(wall, front),
                        around: around + along,
                    });
                }
            }
        }
        around += length;
    }
    found
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use openbench_geometry::sides;

    use super::*;
    use crate::draws::stream;

    fn doors(seed: u64, count: usize, is_free: fn(Segment, MapPoint) -> bool) -> Vec<DrawnDoor> {
        let corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)];
        let corners = corners.map(|(x, y)| MapPoint::new(x, y));
        let wish = DoorWish {
            count,
            front: -FRAC_PI_2,
            weights: FaceWeights::USUAL,
        };
        draw_doors(sides(&corners), wish, is_free, &mut stream(seed, 1, 0))
    }

    #[test]
    fn every_side_has_its_share_of_the_doors() {
        let drawn: Vec<DrawnDoor> = (0..2000)
            .flat_map(|seed| doors(seed, 1, |_, _| true))
            .collect();
        for (face, expected) in Face::ALL.into_iter().zip([0.42, 0.36, 0.22]) {
            let there = drawn.iter().filter(|door| door.face == face).count();
            let share = there as f64 / drawn.len() as f64;
            assert!((share - expected).abs() < 0.04, "{face:?}: {share}");
        }
        // South is the front.
        let front = |door: &&DrawnDoor| door.face == Face::Front;
        assert!(drawn.iter().filter(front).all(|door| door.at.y == 0.0));
    }

    #[test]
    fn doors_are_at_free_places_apart_from_each_other() {
        for seed in 0..50 {
            let drawn = doors(seed, 30, |wall, at| {
                wall.start.y == wall.end.y && at.x < 12.0
            });
            assert!((4..=10).contains(&drawn.len()), "{}", drawn.len());
            assert_eq!(drawn.iter().filter(|door| door.main).count(), 1);
            for (i, door) in drawn.iter().enumerate() {
                assert!(door.at.x < 12.0);
                let others = &drawn[..i];
                assert!(
                    others
                        .iter()
                        .all(|other| other.at.distance(door.at) > APART_M)
                );
            }
        }
        assert!(doors(1, 3, |_, _| false).is_empty());
    }
}
