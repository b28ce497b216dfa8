//! Kinds of things in the way, with their sizes.

use openbench_core::Pose2;
use openbench_geometry::Segment;
use rand_pcg::Pcg64Mcg;

use crate::generate::seeds::{between, pick};

/// A kind of thing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Wheelie bins side by side.
    Bins,
    /// A bicycle that leans on a wall or stands at the kerb.
    Bicycle,
    /// Bicycles side by side in a rack.
    Rack,
    /// A box with a shrub.
    Planter,
    /// A pot with a plant as high as a door plate.
    TallPlant,
    Bench,
    /// A board with two legs.
    Board,
    /// A scooter for hire.
    Scooter,
    /// A stack of pallets.
    Pallets,
    /// A heap of building rubble.
    Rubble,
    /// Parcels and boxes.
    Boxes,
}

/// What stands beside doors, as frequent as it is here.
pub(super) const BESIDE_DOORS: [Kind; 9] = [
    Kind::Planter,
    Kind::Bicycle,
    Kind::TallPlant,
    Kind::Boxes,
    Kind::Bench,
    Kind::Planter,
    Kind::Bins,
    Kind::Scooter,
    Kind::Board,
];
/// What stands at walls.
pub(super) const AT_WALLS: [Kind; 9] = [
    Kind::Bins,
    Kind::Bicycle,
    Kind::Rack,
    Kind::Bench,
    Kind::Bins,
    Kind::Planter,
    Kind::Pallets,
    Kind::Rubble,
    Kind::Bicycle,
];
/// What stands on pavements, at the kerb.
pub(super) const ON_PAVEMENTS: [Kind; 8] = [
    Kind::Bins,
    Kind::Scooter,
    Kind::Bicycle,
    Kind::Board,
    Kind::Planter,
    Kind::Bins,
    Kind::Scooter,
    Kind::Rubble,
];

/// Radius of a capsule that holds the corners of a rectangle, in halves of its shorter side: the
/// root of two, and rounding.
const CORNERS: f64 = 1.4143;

/// Half the extent of a thing, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Half {
    /// Along the wall.
    pub along: f64,
    /// Out of the wall.
    pub out: f64,
}

/// A thing of a kind, with what is drawn about its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thing {
    pub kind: Kind,
    /// Pieces side by side.
    pub count: usize,
    /// Metres.
    pub height: f64,
    pub half: Half,
}

impl Kind {
    /// Its name, as in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bins => "bins",
            Self::Bicycle => "bicycle",
            Self::Rack => "bicycle rack",
            Self::Planter => "planter",
            Self::TallPlant => "tall plant",
            Self::Bench => "bench",
            Self::Board => "board",
            Self::Scooter => "scooter",
            Self::Pallets => "pallets",
            Self::Rubble => "rubble",
            Self::Boxes => "boxes",
        }
    }

    /// Draws a thing of this kind.
    pub fn draw(self, rng: &mut Pcg64Mcg) -> Thing {
        // Both are drawn for every kind, so that kinds have the same number of draws.
        let (most, size) = (pick(rng, &[2, 3, 3, 4]), between(rng, 0.0, 1.0));
        let half = |along, out| Half { along, out };
        let (count, height, half) = match self {
            Self::Bins => (most, 1.03, half(0.34 * most as f64, 0.36)),
            Self::Bicycle => (1, 1.0, half(0.88, 0.2)),
            Self::Rack => (most + 1, 1.0, half(0.28 * (most + 1) as f64, 0.9)),
            Self::Planter => (1, 0.45 + 0.3 * size, half(0.3 + 0.3 * size, 0.25)),
            Self::TallPlant => (1, 1.5 + 0.4 * size, half(0.28, 0.28)),
            Self::Bench => (1, 0.86, half(0.8, 0.3)),
            Self::Board => (1, 0.9 + 0.2 * size, half(0.3, 0.3)),
            Self::Scooter => (1, 1.15, half(0.58, 0.25)),
            Self::Pallets => (most, 0.144 * (most * 2) as f64, half(0.6, 0.4)),
            Self::Rubble => (most * 4, 0.3 + 0.3 * size, half(0.7, 0.5)),
            Self::Boxes => (most, 0.5, half(0.45, 0.3)),
        };
        Thing {
            kind: self,
            count,
            height,
            half,
        }
    }
}

/// The ground of a thing: what lies within `radius` metres of `axis`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Footprint {
    pub axis: Segment,
    pub radius: f64,
}

impl Thing {
    /// Half the extent of its ground along the wall, metres.
    pub fn reach_along(&self) -> f64 {
        let Half { along, out } = self.half;
        (along - out).max(0.0) + out.min(along) * CORNERS
    }

    /// Half the extent of its ground out of the wall, metres.
    pub fn reach_out(&self) -> f64 {
        let Half { along, out } = self.half;
        (out - along).max(0.0) + out.min(along) * CORNERS
    }

    /// The sides of its rectangle at a pose that faces out of the wall.
    pub fn outline(&self, pose: Pose2) -> [Segment; 4] {
        let Half { along, out } = self.half;
        let corners = [(-out, -along), (out, -along), (out, along), (-out, along)]
            .map(|(forward, left)| pose.transform(forward, left));
        [0, 1, 2, 3].map(|i| Segment::new(corners[i], corners[(i + 1) % 4]))
    }

    /// Its ground at a pose that faces out of the wall.
    pub fn footprint(&self, pose: Pose2) -> Footprint {
        let Half { along, out } = self.half;
        let radius = out.min(along) * CORNERS;
        let reach = (along - out).abs();
        let (forward, left) = if along >= out {
            (0.0, reach)
        } else {
            (reach, 0.0)
        };
        Footprint {
            axis: Segment::new(
                pose.transform(-forward, -left),
                pose.transform(forward, left),
            ),
            radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use openbench_osm::draws::stream;

    use super::*;

    #[test]
    fn footprints_hold_what_they_are_of() {
        for (i, kind) in AT_WALLS.iter().chain(&ON_PAVEMENTS).enumerate() {
            let thing = kind.draw(&mut stream(1, 1, i as u64));
            let ground = thing.footprint(Pose2::default());
            for side in thing.outline(Pose2::default()) {
                let distance = ground.axis.distance_to_point(side.start);
                assert!(distance <= ground.radius, "{kind:?} {distance}");
                let left = side.start.y.abs();
                assert!(left <= thing.reach_along(), "{kind:?} {left}");
                let out = side.start.x.abs();
                assert!(out <= thing.reach_out(), "{kind:?} {out}");
            }
        }
    }
}
