//! Rigid figures that are placed anew for each instant, in a small tree over their boxes.
//!
//! The trees of the figures never change: rays are transformed into the axes of a figure. A moving
//! figure therefore costs a ray no more than a standing one, and a step costs only the sort of as
//! many boxes as there are figures.

use nalgebra::Vector3;
use openbench_core::Pose3;

use super::bounds::Bounds3;
use super::dispatch::Kernel;
use super::node::Node;
use super::packet::{
    Cast, LANES, Lane, PACKET_STACK, PacketHits, RayPacket, Traversal, Visit, traverse,
};
use super::tree::TriangleBvh;
use super::triangle::{Hit, MISS};

/// Longest time before the instant at which a ray may be cast, seconds: the duration of a LiDAR
/// scan.
pub const SWEEP_S: f32 = 0.1;

/// Margin of the box around a figure, metres, so that rounding loses no hit. In single precision
/// coordinates of a few kilometres have steps of 0.2 mm.
const SLACK_M: f32 = 1e-3;

/// A figure at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Index of the figure.
    pub figure: usize,
    /// Pose of its origin in `map`.
    pub pose: Pose3,
    /// Velocity in `map`, m/s: rays that were cast before the instant see the figure where it was
    /// then.
    pub velocity: [f32; 3],
}

/// Figures as they are placed at an instant.
#[derive(Debug, Clone, Default)]
pub struct Movers {
    nodes: Vec<Node>,
    frames: Vec<Frame>,
}

/// A placed figure as rays need it.
#[derive(Debug, Clone, Copy)]
struct Frame {
    figure: u32,
    /// The figure's axes in `map`.
    axes: [[f32; 3]; 3],
    origin: [f32; 3],
    velocity: [f32; 3],
}

/// A figure and the box around it.
#[derive(Debug, Clone, Copy)]
struct Boxed {
    mover: u32,
    bounds: Bounds3,
}

impl Movers {
    /// Whether there are no figures.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Places figures instead of those placed before. The number of a mover is its index in
    /// `placed`. No ray sees figures without finite numbers, without triangles or with an unknown
    /// index.
    pub fn place(&mut self, figures: &[TriangleBvh], placed: impl Iterator<Item = Placed>) {
        self.nodes.clear();
        self.frames.clear();
        let mut boxes = Vec::new();
        for place in placed {
            let frame = Frame::new(&place);
            let bounds = figures.get(place.figure).and_then(TriangleBvh::bounds);
            let swept = bounds.map(|bounds| frame.sweep(bounds));
            if let Some(bounds) = swept.filter(Bounds3::is_finite) {
                let mover = self.frames.len() as u32;
                boxes.push(Boxed { mover, bounds });
            }
            // Also without a box, so that a mover's number is its index.
            self.frames.push(frame);
        }
        if let Some(root) = around(&boxes) {
            // As in the trees of triangles, the root has no sibling.
            self.nodes.resize(2, node_over(root));
            self.split(0, &mut boxes);
        }
    }

    /// A direction in the axes of a mover's figure, transformed to `map`.
    #[inline]
    pub(crate) fn turn(&self, mover: u32, v: [f32; 3]) -> [f32; 3] {
        let Some(frame) = self.frames.get(mover as usize) else {
            return v;
        };
        let [x, y, z] = frame.axes;
        [0, 1, 2].map(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
    }

    /// Makes the node `at` over these boxes: halves along the axis in which their middles spread
    /// most.
    fn split(&mut self, at: usize, boxes: &mut [Boxed]) {
        // A leaf is a mover: `kind` says that it holds one, see `Node`.
        if let [Boxed { mover, bounds }] = boxes {
            self.nodes[at] = Node {
                first: *mover,
                kind: 8,
                ..node_over(*bounds)
            };
            return;
        }
        let axis = (0..3).fold(0, |best, axis| {
            if spread(boxes, axis) > spread(boxes, best) {
                axis
            } else {
                best
            }
        });
        // Ties go by number, so that the tree does not depend on how a sort treats equals.
        boxes.sort_by(|a, b| {
            let [p, q] = [a, b].map(|boxed| boxed.bounds.doubled_middle(axis));
            p.total_cmp(&q).then(a.mover.cmp(&b.mover))
        });
        let (low, high) = boxes.split_at_mut(boxes.len() / 2);
        let first = self.nodes.len();
        // Both children before either is split, so that siblings stand side by side.
        for half in [&*low, &*high] {
            self.nodes.extend(around(half).map(node_over));
        }
        (self.nodes[at].first, self.nodes[at].kind) = (first as u32, 2 * axis as u32);
        self.split(first, low);
        self.split(first + 1, high);
    }
}

impl Frame {
    fn new(place: &Placed) -> Self {
        let axis = |v: Vector3<f64>| (place.pose.rotation * v).cast::<f32>().into();
        Self {
            figure: place.figure as u32,
            axes: [axis(Vector3::x()), axis(Vector3::y()), axis(Vector3::z())],
            origin: place.pose.translation.vector.cast::<f32>().into(),
            velocity: place.velocity,
        }
    }

    /// The box in `map` around the figure at the instant and during [`SWEEP_S`] before it.
    fn sweep(&self, figure: Bounds3) -> Bounds3 {
        let mut bounds = Bounds3 {
            min: self.origin,
            max: self.origin,
        };
        for i in 0..3 {
            for (axis, (low, high)) in self.axes.iter().zip(figure.min.iter().zip(&figure.max)) {
                // The box of a rotated box, axis by axis: each product contributes its lower end to
                // the minimum and its upper end to the maximum.
                let (a, b) = (axis[i] * low, axis[i] * high);
                bounds.min[i] += a.min(b);
                bounds.max[i] += a.max(b);
            }
            let before = -self.velocity[i] * SWEEP_S;
            bounds.min[i] += before.min(0.0) - SLACK_M;
            bounds.max[i] += before.max(0.0) + SLACK_M;
        }
        bounds
    }

    /// The rays in the figure's axes, up to their hits so far. `lags` are the times at which they
    /// were cast, seconds relative to the instant, negative.
    #[inline(always)]
    fn transformed(&self, rays: &RayPacket, lags: &Lane, limit: &Lane) -> RayPacket {
        let mut taken = RayPacket {
            limit: *limit,
            ..RayPacket::idle()
        };
        for (lane, lag) in lags.iter().enumerate() {
            let (mut from, mut along) = ([0.0; 3], [0.0; 3]);
            for i in 0..3 {
                // To where the figure was when the ray was cast. Its heading is that of the
                // instant.
                from[i] = rays.origin[i][lane] - (self.origin[i] + lag * self.velocity[i]);
                along[i] = rays.direction[i][lane];
            }
            // The axes are orthonormal, so these products are the inverse rotation. It keeps
            // lengths: distances in the figure's axes are those in `map`.
            for (i, axis) in self.axes.iter().enumerate() {
                taken.origin[i][lane] = axis[0] * from[0] + axis[1] * from[1] + axis[2] * from[2];
                taken.direction[i][lane] =
                    axis[0] * along[0] + axis[1] * along[1] + axis[2] * along[2];
            }
        }
        taken
    }
}

/// A node with this box. It leads nowhere yet.
fn node_over(bounds: Bounds3) -> Node {
    Node {
        min: bounds.min,
        first: 0,
        max: bounds.max,
        kind: 0,
    }
}

/// How far the middles of the boxes lie apart along an axis, doubled.
fn spread(boxes: &[Boxed], axis: usize) -> f32 {
    let middles = boxes.iter().map(|b| b.bounds.doubled_middle(axis));
    let (low, high) = middles.fold((f32::MAX, f32::MIN), |(l, h), m| (l.min(m), h.max(m)));
    high - low
}

/// The box around all boxes.
fn around(boxes: &[Boxed]) -> Option<Bounds3> {
    boxes.iter().map(|b| b.bounds).reduce(Bounds3::union)
}

/// Finds the movers that the rays hit before their hits so far.
pub(crate) struct CastAmong<'a, F> {
    pub(crate) movers: &'a Movers,
    pub(crate) figures: &'a [TriangleBvh],
    pub(crate) rays: &'a RayPacket,
    pub(crate) lags: &'a Lane,
    pub(crate) opaque: &'a F,
    pub(crate) hits: &'a mut PacketHits,
}

impl<F: Fn(&Hit) -> bool> Kernel for CastAmong<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            movers,
            figures,
            rays,
            lags,
            opaque,
            hits,
        } = self;
        let boxes = Boxes {
            movers,
            figures,
            rays,
            lags,
            opaque,
        };
        // The tree halves its boxes at each level, so it is never deeper than the stack.
        traverse(&movers.nodes, &Traversal::new(rays), hits, boxes);
    }
}

/// Casts the rays into the figures of leaves.
struct Boxes<'a, F> {
    movers: &'a Movers,
    figures: &'a [TriangleBvh],
    rays: &'a RayPacket,
    lags: &'a Lane,
    opaque: &'a F,
}

impl<F: Fn(&Hit) -> bool> Visit for Boxes<'_, F> {
    #[inline(always)]
    fn leaf(&mut self, node: &Node, hits: &mut PacketHits) {
        let frame = &self.movers.frames[node.first as usize];
        let tree = &self.figures[frame.figure as usize];
        // Limited by what the rays hit so far: only nearer hits are found.
        let taken = frame.transformed(self.rays, self.lags, &hits.distance);
        let mut found = PacketHits::none(&taken);
        if tree.depth >= PACKET_STACK {
            tree.cast_each(&taken, self.opaque, &mut found);
        } else {
            Cast {
                tree,
                rays: &taken,
                opaque: self.opaque,
                hits: &mut found,
            }
            .run();
        }
        merge(hits, &found, node.first);
    }
}

/// Copies the hits that were found. Their distances were limited by those of `hits`, so they are
/// nearer.
#[inline(always)]
fn merge(hits: &mut PacketHits, found: &PacketHits, mover: u32) {
    for lane in 0..LANES {
        let new = found.triangle[lane] != MISS;
        hits.distance[lane] = found.distance[lane];
        hits.triangle[lane] = if new {
            found.triangle[lane]
        } else {
            hits.triangle[lane]
        };
        hits.u[lane] = if new { found.u[lane] } else { hits.u[lane] };
        hits.v[lane] = if new { found.v[lane] } else { hits.v[lane] };
        hits.mover[lane] = if new { mover } else { hits.mover[lane] };
    }
}

#[cfg(test)]
mod tests {
    use super::super::dispatch::{Vectors, widest};
    use super::*;
    use nalgebra::{Point3, Translation3, UnitQuaternion};
    use proptest::prelude::*;

    type Corners = [[f32; 3]; 3];

    fn within(half: f32) -> impl Strategy<Value = [f32; 3]> {
        prop::array::uniform3(-half..half)
    }

    fn triangle() -> impl Strategy<Value = Corners> {
        prop::array::uniform3(within(1.0))
    }

    fn placed() -> impl Strategy<Value = Placed> {
        (0_usize..2, within(8.0), within(3.0), within(3.0)).prop_map(
            |(figure, at, angles, velocity)| {
                let [x, y, z] = at.map(f64::from);
                let [roll, pitch, yaw] = angles.map(f64::from);
                let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
                Placed {
                    figure,
                    pose: Pose3::from_parts(Translation3::new(x, y, z), turn),
                    velocity,
                }
            },
        )
    }

    /// The triangles of a placed figure in `map`, a lag after the instant.
    fn moved(figure: &[Corners], place: &Placed, lag: f32) -> Vec<Corners> {
        let corner = |p: [f32; 3]| {
            let at = place.pose * Point3::from(p.map(f64::from));
            [0, 1, 2].map(|i| at[i] as f32 + lag * place.velocity[i])
        };
        figure.iter().map(|t| t.map(corner)).collect()
    }

    fn packet(rays: &[([f32; 3], [f32; 3])]) -> RayPacket {
        let mut packet = RayPacket::idle();
        for (lane, (origin, direction)) in rays.iter().enumerate() {
            packet.set(lane, *origin, *direction, 100.0);
        }
        packet
    }

    fn among(movers: &Movers, figures: &[TriangleBvh], rays: &RayPacket, lag: f32) -> PacketHits {
        let mut hits = PacketHits::none(rays);
        let (opaque, lags) = (|_: &Hit| true, [lag; LANES]);
        widest(CastAmong {
            movers,
            figures,
            rays,
            lags: &lags,
            opaque: &opaque,
            hits: &mut hits,
        });
        hits
    }

    proptest! {
        #[test]
        fn movers_are_hit_where_their_triangles_are_at_the_rays_instant(
            soups in prop::array::uniform2(prop::collection::vec(triangle(), 1..12)),
            places in prop::collection::vec(placed(), 1..12),
            rays in prop::collection::vec((within(10.0), within(1.0)), LANES),
            lag in -SWEEP_S..0.0,
        ) {
            let second = soups[0].len() as u32;
            let figures = [
                TriangleBvh::new(soups[0].iter().copied()),
                TriangleBvh::numbered(soups[1].iter().copied(), second, |_| false),
            ];
            let mut movers = Movers::default();
            movers.place(&figures, places.iter().copied());
            let rays = packet(&rays);
            let found = among(&movers, &figures, &rays, lag);
            let all = places.iter().flat_map(|place| moved(&soups[place.figure], place, lag));
            let standing = TriangleBvh::new(all).cast_packet(&rays);
            // Rounding decides at edges, so a lane may differ; most agree in every case.
            let near = |lane: usize| {
                let expected = standing.distance[lane];
                (found.distance[lane] - expected).abs() < 1e-3 * expected
            };
            let differing = (0..LANES).filter(|&lane| !near(lane)).count();
            let distances = (found.distance, standing.distance);
            prop_assert!(differing <= 1, "{differing} lanes: {distances:?}");
            for lane in (0..LANES).filter(|&lane| found.triangle[lane] != MISS) {
                let figure = places[found.mover[lane] as usize].figure;
                prop_assert_eq!(u32::from(found.triangle[lane] >= second), figure as u32);
            }
        }

        #[test]
        fn every_instruction_set_sees_the_same_movers(
            soup in prop::collection::vec(triangle(), 1..12),
            places in prop::collection::vec(placed(), 1..12),
            rays in prop::collection::vec((within(10.0), within(1.0)), LANES),
        ) {
            let figure = || TriangleBvh::new(soup.iter().copied());
            let figures = [figure(), figure()];
            let mut movers = Movers::default();
            movers.place(&figures, places.iter().copied());
            let rays = packet(&rays);
            let mut seen = Vec::new();
            for vectors in Vectors::available() {
                let mut hits = PacketHits::none(&rays);
                let (opaque, lags) = (|hit: &Hit| hit.u < 0.7, [-0.03; LANES]);
                vectors.run(CastAmong {
                    movers: &movers,
                    figures: &figures,
                    rays: &rays,
                    lags: &lags,
                    opaque: &opaque,
                    hits: &mut hits,
                });
                seen.push((hits.distance.map(f32::to_bits), hits.triangle, hits.mover));
            }
            prop_assert!(seen.windows(2).all(|w| w[0] == w[1]));
        }
    }

    #[test]
    fn standing_triangles_in_front_hide_movers_and_those_behind_do_not() {
        let wall = |x: f32| [[x, -5.0, -5.0], [x, 5.0, -5.0], [x, 0.0, 9.0]];
        let figures = [TriangleBvh::new([wall(0.0)].into_iter())];
        let mut movers = Movers::default();
        let pose = Pose3::translation(4.0, 0.0, 0.0);
        movers.place(
            &figures,
            [Placed {
                figure: 0,
                pose,
                velocity: [0.0; 3],
            }]
            .into_iter(),
        );
        let rays = packet(&[([0.0; 3], [1.0, 0.0, 0.0]); LANES]);
        for (stands, seen) in [(3.0, (3.0, MISS)), (5.0, (4.0, 0))] {
            let mut hits = TriangleBvh::new([wall(stands)].into_iter()).cast_packet(&rays);
            let (opaque, lags) = (|_: &Hit| true, [0.0; LANES]);
            widest(CastAmong {
                movers: &movers,
                figures: &figures,
                rays: &rays,
                lags: &lags,
                opaque: &opaque,
                hits: &mut hits,
            });
            assert_eq!((hits.distance[7], hits.mover[7]), seen);
        }
    }

    #[test]
    fn figures_without_numbers_triangles_or_index_are_not_seen() {
        let figures = [TriangleBvh::new(std::iter::empty())];
        let place = |figure: usize, x: f64| Placed {
            figure,
            pose: Pose3::translation(x, 0.0, 0.0),
            velocity: [f32::INFINITY; 3],
        };
        let mut movers = Movers::default();
        movers.place(
            &figures,
            [place(0, 0.0), place(7, 1.0), place(usize::MAX, f64::NAN)].into_iter(),
        );
        let hits = among(
            &movers,
            &figures,
            &packet(&[([0.0; 3], [1.0, 0.0, 0.0]); LANES]),
            0.0,
        );
        assert_eq!(hits.triangle, [MISS; LANES]);
        movers.place(&figures, std::iter::empty());
        assert!(movers.is_empty());
    }
}
