//! Where barriers are open: at gates, and where a road or path goes through.

use std::ops::Range;

use openbench_core::MapPoint;
use openbench_geometry::Segment;
use openbench_osm::Road;

use crate::generate::layout::lanes::Lanes;
use crate::generate::streets::profile::profile;

/// Free width on each side of a road that goes through, metres.
pub(crate) const GATE_MARGIN_M: f64 = 0.8;
/// Half the width of a gate, metres.
const GATE_HALF_WIDTH_M: f64 = 0.9;
/// A gate or road this near to a wall opens it, metres.
const AT_WALL_M: f64 = 0.1;
/// Roads at smaller angles open a wall as wide as at this one; sine of the angle.
const LEAST_SINE: f64 = 0.3;
/// A shorter piece between two openings is left out, metres.
const SHORTEST_M: f64 = 0.3;
/// A longer stretch between two corners of a wall is invalid data and is left out, metres.
const LONGEST_M: f64 = 5_000.0;

/// The parts of a stretch of a wall that no road or gate opens. What crosses the wall's line up to
/// `beyond` metres beyond its ends opens it too.
pub(crate) fn between_gates(
    roads: &[Road],
    lanes: &Lanes,
    gates: &[MapPoint],
    stretch: Segment,
    beyond: f64,
) -> Vec<Segment> {
    let length = stretch.length();
    if length.is_nan() || length > LONGEST_M {
        return Vec::new();
    }
    // Along it lengths count from where the stretch begins.
    let line = if beyond > 0.0 && length > 0.0 {
        stretch.part(-beyond / length, 1.0 + beyond / length)
    } else {
        stretch
    };
    let (before, whole) = (line.start.distance(stretch.start), line.length());
    let mut gaps: Vec<Range<f64>> = Vec::new();
    for gate in gates
        .iter()
        .filter(|gate| line.distance_to_point(**gate) < AT_WALL_M)
    {
        let at = line.start.distance(*gate) - before;
        gaps.push(at - GATE_HALF_WIDTH_M..at + GATE_HALF_WIDTH_M);
    }
    for lane in lanes.near(line.start, line.end, AT_WALL_M) {
        let Some(profile) = profile(&roads[lane.road as usize].tags) else {
            continue;
        };
        if let Some(crossing) = line.crossing(lane.ends(roads)) {
            // Half of the road with its pavement, measured across it; along the wall the gap is
            // wider.
            let across = profile.width / 2.0 + profile.pavement + GATE_MARGIN_M;
            // A road nearly along the wall would open all of it.
            let half = across / crossing.sine.max(LEAST_SINE);
            let at = crossing.share * whole - before;
            gaps.push(at - half..at + half);
        }
    }
    without(stretch, gaps)
}

/// What the gaps, in metres from its beginning, leave of a stretch.
fn without(stretch: Segment, mut gaps: Vec<Range<f64>>) -> Vec<Segment> {
    let length = stretch.length();
    gaps.sort_by(|p, q| p.start.total_cmp(&q.start));
    // An empty gap at the end closes the last piece.
    gaps.push(length..length);
    let (mut kept, mut from) = (Vec::new(), 0.0);
    for gap in gaps {
        if gap.start - from > SHORTEST_M {
            kept.push(stretch.part(from / length, gap.start.min(length) / length));
        }
        // Gaps may overlap, and a wide one may hold a narrow one.
        from = f64::max(from, gap.end);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_that_overlap_open_a_wall_once() {
        let wall = Segment::new(MapPoint::new(0.0, 0.0), MapPoint::new(10.0, 0.0));
        let kept = without(wall, vec![5.0..7.0, 2.0..4.0, 3.0..6.0, 9.9..12.0]);
        let ends: Vec<[f64; 2]> = kept.iter().map(|part| [part.start.x, part.end.x]).collect();
        assert_eq!(ends, [[0.0, 2.0], [7.0, 9.9]]);
    }
}
