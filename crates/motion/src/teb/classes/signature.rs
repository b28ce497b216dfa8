//! The class of a path: how it winds about clusters of obstacles.

use openbench_core::MapPoint;

use crate::shape::{Obstacle, moving};
use crate::vector::Vector2;

/// Clusters that are distinguished, those nearest to the straight line; further ones are not.
pub(super) const MOST_CLUSTERS: usize = 24;
/// Moving obstacles that are distinguished, the nearest.
const MOST_MOVING: usize = 8;
/// Bits of a signature for each cluster.
const BITS: usize = 4;

/// How a path winds about the clusters of one [`Clusters`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Signature(u128);

impl Signature {
    /// Counts a step from `a` to `b` if it crosses the ray north from the cluster of a number.
    pub(super) fn wound(self, number: usize, cluster: MapPoint, a: MapPoint, b: MapPoint) -> Self {
        // Half-open: a corner of the path on the ray counts for one of its two steps only.
        if (a.x < cluster.x) == (b.x < cluster.x) {
            return self;
        }
        let share = (cluster.x - a.x) / (b.x - a.x);
        // South of the cluster there is no ray.
        if a.y + share * (b.y - a.y) <= cluster.y {
            return self;
        }
        // 24 + 8 fields of 4 bits fill the number. Counts are modulo 16; the mask below keeps a
        // carry out of the next field.
        let one = 1u128 << (BITS * number);
        let field = 0xf_u128 << (BITS * number);
        let turned = if a.x < b.x {
            self.0.wrapping_add(one)
        } else {
            self.0.wrapping_sub(one)
        };
        Self((self.0 & !field) | (turned & field))
    }
}

/// A point, and when it is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// Where, in `map`.
    pub point: MapPoint,
    /// When, seconds from now.
    pub time: f64,
}

/// An obstacle that moves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moving {
    middle: MapPoint,
    velocity: Vector2,
}

impl Moving {
    /// A point as it is seen by somebody who moves along: it moves back instead.
    fn as_seen(&self, passing: Passing) -> MapPoint {
        let Passing { point: p, time: t } = passing;
        MapPoint::new(p.x - self.velocity.x * t, p.y - self.velocity.y * t)
    }
}

/// What paths wind about: a point in each cluster of standing obstacles, and moving obstacles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clusters {
    pub(super) standing: Vec<MapPoint>,
    moving: Vec<Moving>,
}

impl Clusters {
    /// Distinguishes paths by moving obstacles, too: one that passes before a person winds
    /// otherwise about them than one that passes behind.
    pub(crate) fn set_moving(&mut self, obstacles: &[Obstacle], robot: MapPoint) {
        self.moving.clear();
        self.moving.extend(moving(obstacles).map(|o| Moving {
            middle: o.middle(),
            velocity: o.velocity(),
        }));
        keep_nearest(&mut self.moving, MOST_MOVING, |moving| {
            moving.middle.distance(robot)
        });
    }

    /// The signature of a path through points at times.
    pub fn signature(&self, points: impl Iterator<Item = Passing>) -> Signature {
        let mut signature = Signature::default();
        let mut before: Option<Passing> = None;
        for now in points {
            if let Some(before) = before {
                signature = self.after(signature, before.point, now.point);
                for (i, moving) in self.moving.iter().enumerate() {
                    let (a, b) = (moving.as_seen(before), moving.as_seen(now));
                    signature = signature.wound(MOST_CLUSTERS + i, moving.middle, a, b);
                }
            }
            before = Some(now);
        }
        signature
    }

    /// The signature after a straight step, by what stands.
    fn after(&self, signature: Signature, a: MapPoint, b: MapPoint) -> Signature {
        let clusters = self.standing.iter().enumerate();
        clusters.fold(signature, |signature, (i, cluster)| {
            signature.wound(i, *cluster, a, b)
        })
    }
}

/// Leaves the nearest, in the order of their distances; few enough stay as they are.
pub(super) fn keep_nearest<T>(all: &mut Vec<T>, most: usize, distance: impl Fn(&T) -> f64) {
    if all.len() > most {
        all.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        all.truncate(most);
    }
}
