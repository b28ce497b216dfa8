//! Rays against triangles: a bounding volume hierarchy built by `obvhs`, traversed here in packets of sixteen.
//!
//! One ray and sixteen rays do the same arithmetic lane by lane, so both give the same bits. The loops over lanes are
//! plain arrays that the compiler turns into vector instructions of the target's baseline; none is fused, so results
//! are the same on every machine. Intersection after Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle
//! Intersection*, 1997; both sides of a triangle are hit.

use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;

/// Rays in a packet.
pub const LANES: usize = 16;

/// Marks a ray that hit nothing.
pub const MISS: u32 = u32::MAX;

/// Depth that the packet traversal's stack has room for: each level leaves one sibling behind.
const PACKET_STACK: usize = 192;

type Lane = [f32; LANES];

/// Sixteen rays. Directions need not have unit length: distances count in their lengths.
#[derive(Debug, Clone)]
pub struct RayPacket {
    /// Origins: x, y, z.
    pub origin: [Lane; 3],
    /// Directions: x, y, z.
    pub direction: [Lane; 3],
    /// Distance beyond which nothing is hit; a lane with a negative one is idle.
    pub limit: Lane,
}

impl RayPacket {
    /// Sixteen idle rays.
    pub fn idle() -> Self {
        Self { origin: [[0.0; LANES]; 3], direction: [[1.0; LANES]; 3], limit: [-1.0; LANES] }
    }

    /// Sets one ray.
    pub fn set(&mut self, lane: usize, origin: [f32; 3], direction: [f32; 3], limit: f32) {
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis];
            self.direction[axis][lane] = direction[axis];
        }
        self.limit[lane] = limit;
    }
}

/// What sixteen rays hit first.
#[derive(Debug, Clone)]
pub struct PacketHits {
    /// Distances in lengths of the directions; the limit where nothing was hit.
    pub distance: Lane,
    /// Indices of the triangles, or [`MISS`].
    pub triangle: [u32; LANES],
    /// Weight of the triangle's second corner at the hit.
    pub u: Lane,
    /// Weight of the triangle's third corner at the hit.
    pub v: Lane,
}

/// What one ray hit first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the direction.
    pub distance: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Weight of the triangle's second corner at the hit.
    pub u: f32,
    /// Weight of the triangle's third corner at the hit.
    pub v: f32,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    min: [f32; 3],
    /// First child (its sibling follows) or first triangle.
    first: u32,
    max: [f32; 3],
    /// Triangles in a leaf; zero for an inner node.
    count: u32,
}

#[derive(Debug, Clone, Copy)]
struct LeafTriangle {
    corner: [f32; 3],
    edge1: [f32; 3],
    edge2: [f32; 3],
    index: u32,
    /// Whether the triangle may have holes, for the caller to say.
    masked: bool,
}

/// Triangles in a tree.
#[derive(Debug, Clone)]
pub struct TriangleBvh {
    nodes: Vec<Node>,
    triangles: Vec<LeafTriangle>,
    depth: usize,
}

impl TriangleBvh {
    /// Builds the tree over the triangles that `corners` yields, three positions each, in metres.
    pub fn new(corners: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        Self::masked(corners, |_| false)
    }

    /// The same; `masked` says of which triangles (by index) casts with a filter must ask whether a hit goes through a hole.
    pub fn masked(corners: impl Iterator<Item = [[f32; 3]; 3]>, masked: impl Fn(u32) -> bool) -> Self {
        let soup: Vec<obvhs::triangle::Triangle> = corners
            .map(|[a, b, c]| obvhs::triangle::Triangle { v0: a.into(), v1: b.into(), v2: c.into() })
            .collect();
        if soup.is_empty() {
            return Self { nodes: Vec::new(), triangles: Vec::new(), depth: 0 };
        }
        let mut elapsed = std::time::Duration::ZERO;
        let tree = build_bvh2_from_tris(&soup, BvhBuildParams::medium_build(), &mut elapsed);
        let nodes = tree.nodes.iter().map(|n| Node {
            min: n.aabb.min.into(),
            first: n.first_index,
            max: n.aabb.max.into(),
            count: n.prim_count,
        });
        let triangles =
            tree.primitive_indices.iter().map(|&i| leaf_triangle(&soup[i as usize], i, masked(i)));
        Self { nodes: nodes.collect(), triangles: triangles.collect(), depth: tree.max_depth.max(96) }
    }

    /// Lowest and highest corner of the box around everything, metres; `None` if there is nothing.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        self.nodes.first().map(|root| (root.min, root.max))
    }

    /// What a ray from `origin` along `direction` hits first within `limit` lengths of `direction`.
    pub fn cast(&self, origin: [f32; 3], direction: [f32; 3], limit: f32) -> Option<Hit> {
        self.cast_filtered(origin, direction, limit, |_| true)
    }

    /// The same, hits of masked triangles only where `opaque` says so.
    pub fn cast_filtered(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        limit: f32,
        opaque: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let inverse = direction.map(reciprocal);
        let mut best = Hit { distance: limit, triangle: MISS, u: 0.0, v: 0.0 };
        let mut stack = Stack::new();
        if !self.nodes.is_empty() {
            stack.push((0, 0.0));
        }
        while let Some((index, entry)) = stack.pop() {
            if entry > best.distance {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for triangle in self.leaf(node) {
                    let mut hit = best;
                    if intersect_one(triangle, origin, direction, &mut hit)
                        && (!triangle.masked || opaque(&hit))
                    {
                        best = hit;
                    }
                }
                continue;
            }
            let enter =
                |i: u32| slab_one(&self.nodes[i as usize], origin, inverse, best.distance).map(|t| (i, t));
            match (enter(node.first), enter(node.first + 1)) {
                (Some(a), Some(b)) => {
                    let (near, far) = if a.1 <= b.1 { (a, b) } else { (b, a) };
                    stack.push(far);
                    stack.push(near);
                }
                (Some(one), None) | (None, Some(one)) => stack.push(one),
                (None, None) => {}
            }
        }
        (best.triangle != MISS).then_some(best)
    }

    /// What each of sixteen rays hits first. Fastest when the rays are close to each other.
    pub fn cast_packet(&self, rays: &RayPacket) -> PacketHits {
        self.cast_packet_filtered(rays, |_| true)
    }

    /// The same, hits of masked triangles only where `opaque` says so.
    pub fn cast_packet_filtered(&self, rays: &RayPacket, opaque: impl Fn(&Hit) -> bool) -> PacketHits {
        let mut hits =
            PacketHits { distance: rays.limit, triangle: [MISS; LANES], u: [0.0; LANES], v: [0.0; LANES] };
        if self.nodes.is_empty() {
            return hits;
        }
        if self.depth >= PACKET_STACK {
            return self.cast_each(rays, opaque);
        }
        let inverse = rays.direction.map(|axis| axis.map(reciprocal));
        let mut stack = [(0_u32, 0.0_f32); PACKET_STACK + 1];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (index, entry) = stack[top];
            if hits.distance.iter().fold(0, |any, &d| any | mask(d >= entry)) == 0 {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for triangle in self.leaf(node) {
                    if triangle.masked {
                        intersect_masked(triangle, rays, &mut hits, &opaque);
                    } else {
                        intersect_packet(triangle, rays, &mut hits);
                    }
                }
                continue;
            }
            let near = slab_packet(&self.nodes[node.first as usize], rays, &inverse, &hits.distance);
            let far = slab_packet(&self.nodes[node.first as usize + 1], rays, &inverse, &hits.distance);
            let mut push = |entry: (u32, f32)| {
                if entry.1 < f32::INFINITY {
                    stack[top] = entry;
                    top += 1;
                }
            };
            let (a, b) = ((node.first, near), (node.first + 1, far));
            let (first, second) = if near <= far { (b, a) } else { (a, b) };
            push(first);
            push(second);
        }
        hits
    }

    /// For trees deeper than the packet's stack, which only degenerate scenes have.
    fn cast_each(&self, rays: &RayPacket, opaque: impl Fn(&Hit) -> bool) -> PacketHits {
        let mut hits =
            PacketHits { distance: rays.limit, triangle: [MISS; LANES], u: [0.0; LANES], v: [0.0; LANES] };
        for lane in 0..LANES {
            let at = |v: &[Lane; 3]| [v[0][lane], v[1][lane], v[2][lane]];
            let (origin, direction) = (at(&rays.origin), at(&rays.direction));
            if let Some(hit) = self.cast_filtered(origin, direction, rays.limit[lane], &opaque) {
                hits.distance[lane] = hit.distance;
                hits.triangle[lane] = hit.triangle;
                (hits.u[lane], hits.v[lane]) = (hit.u, hit.v);
            }
        }
        hits
    }

    fn leaf(&self, node: &Node) -> &[LeafTriangle] {
        &self.triangles[node.first as usize..(node.first + node.count) as usize]
    }
}

/// Nodes still to be visited with the distances at which they are entered: an array, and a vector for degenerate trees.
struct Stack {
    shallow: [(u32, f32); 64],
    count: usize,
    deep: Vec<(u32, f32)>,
}

impl Stack {
    fn new() -> Self {
        Self { shallow: [(0, 0.0); 64], count: 0, deep: Vec::new() }
    }

    #[inline(always)]
    fn push(&mut self, entry: (u32, f32)) {
        match self.shallow.get_mut(self.count) {
            Some(slot) => {
                *slot = entry;
                self.count += 1;
            }
            None => self.deep.push(entry),
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<(u32, f32)> {
        if let Some(entry) = self.deep.pop() {
            return Some(entry);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.shallow[self.count])
    }
}

fn leaf_triangle(t: &obvhs::triangle::Triangle, index: u32, masked: bool) -> LeafTriangle {
    LeafTriangle {
        corner: t.v0.into(),
        edge1: (t.v1 - t.v0).into(),
        edge2: (t.v2 - t.v0).into(),
        index,
        masked,
    }
}

/// One over `component`, kept finite so that no slab test multiplies zero by infinity.
#[inline(always)]
fn reciprocal(component: f32) -> f32 {
    1.0 / if component.abs() < 1e-18 { 1e-18 } else { component }
}

#[inline(always)]
fn lower(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn upper(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Distance at which the ray enters the box, if it does before `limit`.
#[inline(always)]
fn slab(node: &Node, origin: [f32; 3], inverse: [f32; 3], limit: f32) -> (f32, f32) {
    let (mut enter, mut leave) = (0.0_f32, limit);
    for axis in 0..3 {
        let a = (node.min[axis] - origin[axis]) * inverse[axis];
        let b = (node.max[axis] - origin[axis]) * inverse[axis];
        enter = upper(lower(a, b), enter);
        leave = lower(upper(a, b), leave);
    }
    (enter, leave)
}

#[inline(always)]
fn slab_one(node: &Node, origin: [f32; 3], inverse: [f32; 3], limit: f32) -> Option<f32> {
    let (enter, leave) = slab(node, origin, inverse, limit);
    (enter <= leave).then_some(enter)
}

/// Smallest distance at which one of the rays enters the box; infinite if none does.
#[inline(always)]
fn slab_packet(node: &Node, rays: &RayPacket, inverse: &[Lane; 3], limit: &Lane) -> f32 {
    let mut entries = [0.0; LANES];
    for lane in 0..LANES {
        let at = |v: &[Lane; 3]| [v[0][lane], v[1][lane], v[2][lane]];
        let (enter, leave) = slab(node, at(&rays.origin), at(inverse), limit[lane]);
        entries[lane] = select(mask(enter <= leave), enter, f32::INFINITY);
    }
    least(entries)
}

/// The least of sixteen numbers, half against half: a running minimum would be one long chain.
#[inline(always)]
fn least(mut values: Lane) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            values[i] = lower(values[i], values[i + half]);
        }
        half /= 2;
    }
    values[0]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Distance and corner weights of the hit, and a mask of ones if there is one before `limit`.
#[inline(always)]
fn moeller_trumbore(
    t: &LeafTriangle,
    origin: [f32; 3],
    direction: [f32; 3],
    limit: f32,
) -> (f32, f32, f32, u32) {
    let p = cross(direction, t.edge2);
    let inverse = 1.0 / dot(t.edge1, p);
    let s = [origin[0] - t.corner[0], origin[1] - t.corner[1], origin[2] - t.corner[2]];
    let u = dot(s, p) * inverse;
    let q = cross(s, t.edge1);
    let v = dot(direction, q) * inverse;
    let distance = dot(t.edge2, q) * inverse;
    // A ray in the triangle's plane gives NaN or infinity, and no comparison holds. Masks rather than `&&`: a branch for
    // each lane would keep the compiler from using vectors.
    let hit =
        mask(u >= 0.0) & mask(v >= 0.0) & mask(u + v <= 1.0) & mask(distance > 1e-5) & mask(distance < limit);
    (distance, u, v, hit)
}

#[inline(always)]
fn mask(holds: bool) -> u32 {
    u32::from(holds).wrapping_neg()
}

#[inline(always)]
fn select(mask: u32, yes: f32, no: f32) -> f32 {
    f32::from_bits((yes.to_bits() & mask) | (no.to_bits() & !mask))
}

#[inline(always)]
fn intersect_one(triangle: &LeafTriangle, origin: [f32; 3], direction: [f32; 3], best: &mut Hit) -> bool {
    let (distance, u, v, hit) = moeller_trumbore(triangle, origin, direction, best.distance);
    if hit != 0 {
        *best = Hit { distance, triangle: triangle.index, u, v };
    }
    hit != 0
}

/// As [`intersect_packet`], but asks for each hit whether it goes through a hole.
#[inline(always)]
fn intersect_masked(
    triangle: &LeafTriangle,
    rays: &RayPacket,
    hits: &mut PacketHits,
    opaque: &impl Fn(&Hit) -> bool,
) {
    let mut candidates =
        PacketHits { distance: hits.distance, triangle: [MISS; LANES], u: [0.0; LANES], v: [0.0; LANES] };
    intersect_packet(triangle, rays, &mut candidates);
    for lane in (0..LANES).filter(|&lane| candidates.triangle[lane] != MISS) {
        let (distance, u, v) = (candidates.distance[lane], candidates.u[lane], candidates.v[lane]);
        if opaque(&Hit { distance, triangle: triangle.index, u, v }) {
            hits.distance[lane] = distance;
            hits.triangle[lane] = triangle.index;
            (hits.u[lane], hits.v[lane]) = (u, v);
        }
    }
}

#[inline(always)]
fn intersect_packet(triangle: &LeafTriangle, rays: &RayPacket, hits: &mut PacketHits) {
    let triangle = *triangle;
    for lane in 0..LANES {
        let at = |v: &[Lane; 3]| [v[0][lane], v[1][lane], v[2][lane]];
        let (distance, u, v, hit) =
            moeller_trumbore(&triangle, at(&rays.origin), at(&rays.direction), hits.distance[lane]);
        hits.distance[lane] = select(hit, distance, hits.distance[lane]);
        hits.triangle[lane] = (triangle.index & hit) | (hits.triangle[lane] & !hit);
        hits.u[lane] = select(hit, u, hits.u[lane]);
        hits.v[lane] = select(hit, v, hits.v[lane]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn coordinate() -> impl Strategy<Value = f32> {
        -10.0_f32..10.0
    }

    fn triangle() -> impl Strategy<Value = [[f32; 3]; 3]> {
        prop::array::uniform3(prop::array::uniform3(coordinate()))
    }

    fn brute_force(soup: &[[[f32; 3]; 3]], origin: [f32; 3], direction: [f32; 3]) -> Option<f32> {
        let mut best = Hit { distance: 100.0, triangle: MISS, u: 0.0, v: 0.0 };
        for (i, [a, b, c]) in soup.iter().enumerate() {
            let t = obvhs::triangle::Triangle { v0: (*a).into(), v1: (*b).into(), v2: (*c).into() };
            intersect_one(&leaf_triangle(&t, i as u32, false), origin, direction, &mut best);
        }
        (best.triangle != MISS).then_some(best.distance)
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_a_loop_over_all_triangles_finds(
            soup in prop::collection::vec(triangle(), 1..60),
            rays in prop::collection::vec((prop::array::uniform3(coordinate()), prop::array::uniform3(coordinate())), LANES),
        ) {
            let tree = TriangleBvh::new(soup.iter().copied());
            let mut packet = RayPacket::idle();
            for (lane, (origin, direction)) in rays.iter().enumerate() {
                packet.set(lane, *origin, *direction, 100.0);
            }
            let together = tree.cast_packet(&packet);
            for (lane, (origin, direction)) in rays.iter().enumerate() {
                let alone = tree.cast(*origin, *direction, 100.0);
                prop_assert_eq!(alone.map(|h| h.distance), brute_force(&soup, *origin, *direction));
                let from_packet = (together.triangle[lane] != MISS).then_some(together.distance[lane]);
                prop_assert_eq!(alone.map(|h| h.distance), from_packet);
            }
        }
    }

    #[test]
    fn an_empty_tree_is_missed() {
        let tree = TriangleBvh::new(std::iter::empty());
        assert_eq!(tree.cast([0.0; 3], [1.0, 0.0, 0.0], 10.0), None);
        assert_eq!(tree.cast_packet(&RayPacket::idle()).triangle, [MISS; LANES]);
    }

    #[test]
    fn axis_parallel_rays_hit_a_floor() {
        let floor = [[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]];
        let tree = TriangleBvh::new(floor.into_iter());
        let hit = tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 10.0).unwrap();
        assert_eq!(hit.distance, 2.0);
        assert_eq!(tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 1.9), None);
        assert_eq!(tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, 1.0], 10.0), None);
    }
}
