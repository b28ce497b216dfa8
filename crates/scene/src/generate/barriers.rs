//! Walls, fences, hedges and raised kerbs along `barrier=*` ways, open where a road or path goes through.

use openbench_core::{MapPoint, Pose2};
use openbench_osm::map::kerb_height;
use openbench_osm::{Barrier, OsmMap, Road, Tags};

use super::Site;
use super::lanes::{Lanes, ends};
use super::seeds::{Purpose, between, chance, pick, stream};
use super::shapes::{Surface, along, at, cuboid, facet};
use super::streets::{KERB, metres, profile};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};
use crate::triangulate::turn;

/// Free width beside a road that goes through, metres.
pub(super) const GATE_MARGIN: f64 = 0.8;

/// No kerb is built higher, metres.
const HIGHEST_KERB: f64 = 0.4;
/// Kerbs are drawn with short stretches just where paths cross them: what crosses one so far beyond its ends opens it too, metres.
const NEIGHBOURS: f64 = 8.0;

/// No wall goes on for longer without a corner, metres.
const LONGEST: f64 = 5_000.0;

/// What a barrier is built of.
#[derive(Debug, Clone, Copy)]
enum Build {
    /// Masonry with a coping; height and thickness, metres.
    Masonry(Surface, f64, f64),
    /// Posts with panels that are seen through.
    Panels(Surface, f64),
    /// A clipped hedge; height and thickness, metres.
    Hedge(f64, f64),
    /// Kerb stones; height, metres.
    Kerb(f64),
    /// Bollards and other things that stop no robot or that are not lines.
    Nothing,
}

impl Site {
    pub(super) fn barriers(&mut self) {
        let barriers = std::mem::take(&mut self.map.barriers);
        for barrier in &barriers {
            let build = self.build_of(barrier);
            let class = match build {
                Build::Hedge(..) => SemanticClass::Vegetation,
                Build::Kerb(_) => SemanticClass::Kerb,
                _ => SemanticClass::Wall,
            };
            self.builder.object(kind(&barrier.tags).to_owned(), class);
            for pair in barrier.points.windows(2) {
                if self.extent.holds(pair[0], super::GROUND_MARGIN) {
                    let parts = open(barrier, (&self.map.roads, &self.lanes), (pair[0], pair[1]));
                    for (a, b) in parts {
                        self.stretch(build, (a, b));
                    }
                }
            }
        }
        self.map.barriers = barriers;
    }

    fn build_of(&self, barrier: &Barrier) -> Build {
        let mut rng = stream(self.seed, Purpose::Barrier, barrier.way as u64);
        let tags = &barrier.tags;
        let height = |usual: f64| {
            metres(tags, "height")
                .filter(|h| (0.1..=12.0).contains(h))
                .unwrap_or(usual)
        };
        let palette = &self.palette;
        match kind(tags) {
            "wall" | "city_wall" | "retaining_wall" => Build::Masonry(
                pick(&mut rng, &palette.free_walls),
                height(between(&mut rng, 1.5, 2.0)),
                0.25,
            ),
            "hedge" => Build::Hedge(
                height(between(&mut rng, 1.0, 1.5)),
                between(&mut rng, 0.6, 0.8),
            ),
            "fence" | "handrail" | "guard_rail" => {
                let metal = tags
                    .get("fence_type")
                    .map_or(chance(&mut rng, 0.4), |t| t != "wood");
                let surface = if metal {
                    palette.railings
                } else {
                    pick(&mut rng, &palette.pickets)
                };
                Build::Panels(surface, height(between(&mut rng, 1.0, 1.3)))
            }
            "kerb" => Build::Kerb(kerb_height(tags).min(HIGHEST_KERB)),
            _ => Build::Nothing,
        }
    }

    fn stretch(&mut self, build: Build, (a, b): (MapPoint, MapPoint)) {
        if self.is_full() {
            return;
        }
        let length = a.distance(b);
        let pose = Pose2::new(a.x, a.y, a.bearing_to(b));
        let builder = &mut self.builder;
        match build {
            Build::Masonry(surface, height, thick) => {
                let half = thick / 2.0;
                cuboid(
                    builder,
                    Layer::Both,
                    surface,
                    pose,
                    ([-half, -half, 0.0], [length + half, half, height]),
                );
                let (out, top) = (half + 0.05, height + 0.08);
                let coping = ([-out, -out, height], [length + out, out, top]);
                cuboid(builder, Layer::Visible, self.palette.coping, pose, coping);
            }
            Build::Hedge(height, thick) => {
                self.hedge((a, b), (height, thick));
            }
            Build::Panels(surface, height) => {
                see_through(builder, surface, (a, b), (0.0, height));
                let corners = [at(a, 0.0), at(b, 0.0), at(b, height), at(a, height)];
                facet(builder, Layer::Solid, surface, &corners);
                let posts = ((length / 2.4) as usize).min(4_000) + 1;
                for i in 0..=posts {
                    let x = length * i as f64 / posts as f64;
                    let post = ([x - 0.05, -0.05, 0.0], [x + 0.05, 0.05, height + 0.06]);
                    cuboid(builder, Layer::Visible, self.palette.coping, pose, post);
                }
            }
            Build::Kerb(height) => {
                let half = KERB / 2.0;
                let stones = ([0.0, -half, 0.0], [length, half, height]);
                cuboid(builder, Layer::Both, self.palette.kerbstone, pose, stones);
            }
            Build::Nothing => {}
        }
    }
}

/// The parts of a stretch of a barrier that no road or gate opens.
fn open(
    barrier: &Barrier,
    roads: (&[Road], &Lanes),
    stretch: (MapPoint, MapPoint),
) -> Vec<(MapPoint, MapPoint)> {
    let beyond = if kind(&barrier.tags) == "kerb" {
        NEIGHBOURS
    } else {
        0.0
    };
    between_gates(roads, &barrier.gates, stretch, beyond)
}

/// The parts of a stretch of a wall that no road or gate opens; so far `beyond` its ends, in metres, they open it too.
pub(super) fn between_gates(
    (roads, lanes): (&[Road], &Lanes),
    gates: &[MapPoint],
    (a, b): (MapPoint, MapPoint),
    beyond: f64,
) -> Vec<(MapPoint, MapPoint)> {
    let length = a.distance(b);
    if length.is_nan() || length > LONGEST {
        return Vec::new();
    }
    let mut gaps: Vec<(f64, f64)> = Vec::new();
    // The stretch and what lies beyond its ends; along it lengths count from where it begins.
    let (far_a, far_b) = if beyond > 0.0 && length > 0.0 {
        (
            along(a, b, -beyond / length),
            along(a, b, 1.0 + beyond / length),
        )
    } else {
        (a, b)
    };
    let (before, whole) = (far_a.distance(a), far_a.distance(far_b));
    for gate in gates
        .iter()
        .filter(|g| super::clearance::point_distance(**g, (far_a, far_b)) < 0.1)
    {
        let at = far_a.distance(*gate) - before;
        gaps.push((at - 0.9, at + 0.9));
    }
    for segment in lanes.near(far_a, far_b, 0.1) {
        let Some(profile) = profile(&roads[segment.0 as usize].tags) else {
            continue;
        };
        if let Some((share, sine)) = crossing((far_a, far_b), ends(roads, segment)) {
            let half = (profile.width / 2.0 + profile.pavement + GATE_MARGIN) / sine.max(0.3);
            let at = share * whole - before;
            gaps.push((at - half, at + half));
        }
    }
    gaps.sort_by(|p, q| p.0.total_cmp(&q.0));
    let (mut kept, mut from) = (Vec::new(), 0.0);
    for (start, end) in gaps.into_iter().chain([(length, length)]) {
        if start - from > 0.3 {
            kept.push((
                along(a, b, from / length),
                along(a, b, start.min(length) / length),
            ));
        }
        from = f64::max(from, end);
    }
    kept
}

/// The stretches of all barriers that stop a robot.
pub(super) fn standing(map: &OsmMap, lanes: &Lanes) -> Vec<(MapPoint, MapPoint)> {
    const SOLID: [&str; 8] = [
        "wall",
        "city_wall",
        "retaining_wall",
        "hedge",
        "fence",
        "handrail",
        "guard_rail",
        "kerb",
    ];
    let solid = map
        .barriers
        .iter()
        .filter(|b| SOLID.contains(&kind(&b.tags)));
    solid
        .flat_map(|barrier| {
            barrier
                .points
                .windows(2)
                .map(move |pair| (barrier, (pair[0], pair[1])))
        })
        .flat_map(|(barrier, ends)| open(barrier, (&map.roads, lanes), ends))
        .collect()
}

fn kind(tags: &Tags) -> &str {
    if tags.is("natural", "hedge") || tags.is("landuse", "hedge") {
        return "hedge";
    }
    tags.get("barrier")
        .filter(|k| *k != "yes")
        .unwrap_or("wall")
}

/// A panel whose image is as high as the panel and repeats along it.
pub(super) fn see_through(
    builder: &mut SceneBuilder,
    surface: Surface,
    (a, b): (MapPoint, MapPoint),
    z: (f64, f64),
) {
    let u = (a.distance(b) / surface.tile) as f32;
    let corners = [
        (at(a, z.0), [0.0, 0.001]),
        (at(b, z.0), [u, 0.001]),
        (at(b, z.1), [u, 0.999]),
        (at(a, z.1), [0.0, 0.999]),
    ];
    builder.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &[[0, 1, 2], [0, 2, 3]],
    );
}

/// Where on a-b, as a share, c-d crosses or touches it, and the sine of the angle between them.
fn crossing((a, b): (MapPoint, MapPoint), (c, d): (MapPoint, MapPoint)) -> Option<(f64, f64)> {
    let (from, to) = (turn(c, d, a), turn(c, d, b));
    let touches = from * to <= 0.0 && turn(a, b, c) * turn(a, b, d) <= 0.0 && from != to;
    touches.then(|| {
        let sine = (from - to).abs() / (a.distance(b) * c.distance(d)).max(1e-9);
        (from / (from - to), sine)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_road_crosses_a_wall_where_it_does() {
        let p = |x, y| MapPoint::new(x, y);
        let (share, sine) =
            crossing((p(0.0, 0.0), p(10.0, 0.0)), (p(4.0, -1.0), p(4.0, 5.0))).unwrap();
        assert!((share - 0.4).abs() < 1e-12 && (sine - 1.0).abs() < 1e-12);
        assert_eq!(
            crossing((p(0.0, 0.0), p(10.0, 0.0)), (p(4.0, 1.0), p(4.0, 5.0))),
            None
        );
        assert_eq!(
            crossing((p(0.0, 0.0), p(10.0, 0.0)), (p(0.0, 1.0), p(10.0, 1.0))),
            None
        );
    }
}
