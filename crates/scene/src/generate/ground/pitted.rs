//! Level ground with pits, in triangles.
//!
//! Each pit lies in a frame: a rectangle along the axes that holds nothing else. The ground between
//! the frames is cut into rows of rectangles, and a frame without its pit into triangles about the
//! corners of the frame. Ear clipping would join each pit to the outline by a bridge of hundreds of
//! metres, which may cross other pits.

use openbench_core::MapPoint;
use openbench_geometry::{Bounds, signed_area, turn};

/// Frames lie on a lattice of this side, metres. Its points are exact in the numbers of a scene, so
/// borders of rectangles meet without a gap.
const LATTICE_M: f64 = 0.125;
/// Least distance of a pit from its frame, metres.
const AROUND_M: f64 = 0.02;
/// Least distance of a frame from the end of the ground, metres.
const FROM_END_M: f64 = 1.0;
/// Largest error of the area, m².
const AREA_TOLERANCE_M2: f64 = 1e-3;

type Triangle = [MapPoint; 3];

/// The frame of a pit.
pub(crate) fn frame_of(ring: &[MapPoint]) -> Bounds {
    let least = |of: fn(&MapPoint) -> f64| {
        let least = ring.iter().map(of).fold(f64::INFINITY, f64::min) - AROUND_M;
        (least / LATTICE_M).floor() * LATTICE_M
    };
    let most = |of: fn(&MapPoint) -> f64| {
        let most = ring.iter().map(of).fold(f64::NEG_INFINITY, f64::max) + AROUND_M;
        (most / LATTICE_M).ceil() * LATTICE_M
    };
    Bounds {
        low: MapPoint::new(least(|p| p.x), least(|p| p.y)),
        high: MapPoint::new(most(|p| p.x), most(|p| p.y)),
    }
}

/// Whether a frame lies in the ground.
pub(crate) fn lies_in(frame: Bounds, ground: Bounds) -> bool {
    ground.holds(frame.low, -FROM_END_M) && ground.holds(frame.high, -FROM_END_M)
}

/// Triangles of the ground without its pits, each counter-clockwise. The pits are convex, of either
/// direction. `None` if their frames meet or leave the ground, or if the areas do not add up.
pub(crate) fn pieces(ground: Bounds, pits: &[Vec<MapPoint>]) -> Option<Vec<Triangle>> {
    let frames: Vec<Bounds> = pits.iter().map(|pit| frame_of(pit)).collect();
    let mut triangles = between(ground, &frames);
    for (frame, pit) in frames.iter().zip(pits) {
        triangles.extend(around(*frame, pit));
    }
    let area = |[a, b, c]: &Triangle| turn(*a, *b, *c) / 2.0;
    let all_turn_left = triangles.iter().all(|t| area(t) > 0.0);
    let covered: f64 = triangles.iter().map(area).sum();
    let missing: f64 = pits.iter().map(|pit| signed_area(pit).abs()).sum();
    let left = signed_area(&ground.corners()) - missing;
    let apart = frames.iter().enumerate().all(|(i, frame)| {
        let others = &frames[i + 1..];
        lies_in(*frame, ground) && !others.iter().any(|other| frame.meets(*other, 0.0))
    });
    let is_whole = apart && all_turn_left && (covered - left).abs() < AREA_TOLERANCE_M2;
    is_whole.then_some(triangles)
}

/// The ground between the frames: rows from one border of a frame to the next.
fn between(ground: Bounds, frames: &[Bounds]) -> Vec<Triangle> {
    let mut borders = vec![ground.low.y, ground.high.y];
    borders.extend(frames.iter().flat_map(|frame| [frame.low.y, frame.high.y]));
    borders.sort_by(f64::total_cmp);
    borders.dedup();
    let mut triangles = Vec::new();
    for row in borders.windows(2) {
        let (south, north) = (row[0], row[1]);
        let mut in_row: Vec<&Bounds> = frames
            .iter()
            .filter(|frame| frame.low.y <= south && frame.high.y >= north)
            .collect();
        in_row.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
        let mut west = ground.low.x;
        let ends = in_row.iter().map(|frame| (frame.low.x, frame.high.x));
        for (east, next) in ends.chain([(ground.high.x, ground.high.x)]) {
            if east > west {
                triangles.extend(rectangle(Bounds {
                    low: MapPoint::new(west, south),
                    high: MapPoint::new(east, north),
                }));
            }
            west = next;
        }
    }
    triangles
}

fn rectangle(bounds: Bounds) -> [Triangle; 2] {
    let [a, b, c, d] = bounds.corners();
    [[a, b, c], [a, c, d]]
}

/// A frame without its pit. Between two of the outermost corners of the pit, say the southern and
/// the eastern one, all sides of the pit face the corner of the frame between them.
fn around(frame: Bounds, pit: &[MapPoint]) -> Vec<Triangle> {
    let mut ring = pit.to_vec();
    if signed_area(&ring) < 0.0 {
        ring.reverse();
    }
    // The outermost corners to the south, east, north and west, and their feet on the frame.
    let outermost = |of: fn(&MapPoint) -> f64| {
        (0..ring.len()).max_by(|a, b| of(&ring[*a]).total_cmp(&of(&ring[*b])))
    };
    let found = [
        outermost(|p| -p.y),
        outermost(|p| p.x),
        outermost(|p| p.y),
        outermost(|p| -p.x),
    ];
    let Some(outermost): Option<Vec<usize>> = found.into_iter().collect() else {
        return rectangle(frame).to_vec();
    };
    let feet = [
        MapPoint::new(ring[outermost[0]].x, frame.low.y),
        MapPoint::new(frame.high.x, ring[outermost[1]].y),
        MapPoint::new(ring[outermost[2]].x, frame.high.y),
        MapPoint::new(frame.low.x, ring[outermost[3]].y),
    ];
    let [south_west, south_east, north_east, north_west] = frame.corners();
    let corners = [south_east, north_east, north_west, south_west];
    let mut triangles = Vec::new();
    for (i, corner) in corners.into_iter().enumerate() {
        let next = (i + 1) % 4;
        let (mut at, end) = (outermost[i], outermost[next]);
        triangles.push([corner, ring[at], feet[i]]);
        while at != end {
            let after = (at + 1) % ring.len();
            triangles.push([corner, ring[after], ring[at]]);
            at = after;
        }
        triangles.push([corner, feet[next], ring[end]]);
    }
    triangles
}

#[cfg(test)]
mod tests {
    use openbench_core::Pose2;
    use openbench_osm::draws::stream;

    use super::*;
    use crate::generate::seeds::between as drawn;

    fn ground() -> Bounds {
        Bounds {
            low: MapPoint::new(-203.3, -150.7),
            high: MapPoint::new(310.1, 95.9),
        }
    }

    /// A rectangle that is turned.
    fn pit(x: f64, y: f64, yaw: f64) -> Vec<MapPoint> {
        let pose = Pose2::new(x, y, yaw);
        [(0.0, -0.9), (0.0, 0.9), (0.8, 0.9), (0.8, -0.9)]
            .map(|(forward, left)| pose.transform(forward, left))
            .to_vec()
    }

    /// Pits with frames apart from each other.
    fn pits(seed: u64) -> Vec<Vec<MapPoint>> {
        let rng = &mut stream(seed, 1, 1);
        let mut pits: Vec<Vec<MapPoint>> = Vec::new();
        for i in 0..60 {
            let (x, y) = (drawn(rng, -190.0, 300.0), drawn(rng, -140.0, 85.0));
            // Along the axes too: then two corners are outermost.
            let turns = drawn(rng, 0.0, 4.0);
            let turns = if i % 3 == 0 { turns.floor() } else { turns };
            let new = pit(x, y, turns * std::f64::consts::FRAC_PI_2);
            let frame = frame_of(&new);
            if !pits.iter().any(|p| frame_of(p).meets(frame, 0.0)) {
                pits.push(new);
            }
        }
        pits
    }

    /// How many triangles cover a point.
    fn layers(triangles: &[Triangle], p: MapPoint) -> usize {
        let covers = |[a, b, c]: &&Triangle| {
            turn(*a, *b, p) > 0.0 && turn(*b, *c, p) > 0.0 && turn(*c, *a, p) > 0.0
        };
        triangles.iter().filter(covers).count()
    }

    #[test]
    fn pits_are_open_and_all_else_is_covered_once() {
        for seed in 0..40 {
            let pits = pits(seed);
            assert!(pits.len() > 50);
            let triangles = pieces(ground(), &pits).unwrap();
            for pit in &pits {
                let middle =
                    MapPoint::new((pit[0].x + pit[2].x) / 2.0, (pit[0].y + pit[2].y) / 2.0);
                assert_eq!(layers(&triangles, middle), 0, "{seed} {middle:?}");
                for corner in pit {
                    let at = |share: f64| {
                        let along = |a: f64, b: f64| a + (b - a) * share;
                        MapPoint::new(along(middle.x, corner.x), along(middle.y, corner.y))
                    };
                    assert_eq!(layers(&triangles, at(0.99)), 0, "{seed} {corner:?}");
                    assert_eq!(layers(&triangles, at(1.01)), 1, "{seed} {corner:?}");
                }
            }
            let rng = &mut stream(seed, 2, 2);
            for _ in 0..200 {
                let p = MapPoint::new(drawn(rng, -203.0, 310.0), drawn(rng, -150.0, 95.0));
                assert!(layers(&triangles, p) <= 1, "{seed} {p:?}");
            }
        }
    }

    #[test]
    fn pits_that_meet_or_leave_the_ground_are_refused() {
        assert!(pieces(ground(), &[]).is_some());
        assert!(pieces(ground(), &[pit(0.0, 0.0, 0.3), pit(0.5, 0.5, 1.0)]).is_none());
        assert!(pieces(ground(), &[pit(309.9, 0.0, 0.3)]).is_none());
    }
}
