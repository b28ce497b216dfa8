//! Triangles in a tree of boxes: how it is built, and what a single ray hits in it.

use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;

use super::bounds::Bounds3;
use super::node::{Node, reciprocal, slab_one};
use super::triangle::{Hit, LeafTriangle, MISS, intersect_one, leaf_triangle};

/// Triangles in a tree.
///
/// # Example
///
/// A ray down from 2 m above the ground:
///
/// ```
/// use openbench_scene::TriangleBvh;
///
/// let ground = [[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [0.0, 5.0, 0.0]];
/// let tree = TriangleBvh::new(std::iter::once(ground));
/// let hit = tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 10.0).expect("ground is below");
/// assert_eq!((hit.triangle, hit.distance), (0, 2.0));
/// // Nothing within 1.5 m.
/// assert_eq!(tree.cast([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 1.5), None);
/// ```
#[derive(Debug, Clone)]
pub struct TriangleBvh {
    pub(super) nodes: Vec<Node>,
    pub(super) triangles: Vec<LeafTriangle>,
    pub(super) depth: usize,
}

impl TriangleBvh {
    /// Builds the tree over the triangles that `corners` yields, three positions each, in metres.
    pub fn new(corners: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        Self::masked(corners, |_| false)
    }

    /// The same. `masked` tells for each triangle (by index) whether it may have holes, so that
    /// casts with a filter must test its hits.
    pub(crate) fn masked(
        corners: impl Iterator<Item = [[f32; 3]; 3]>,
        masked: impl Fn(u32) -> bool,
    ) -> Self {
        Self::numbered(corners, 0, masked)
    }

    /// The same, with the triangles numbered from `first`.
    pub(crate) fn numbered(
        corners: impl Iterator<Item = [[f32; 3]; 3]>,
        first: u32,
        masked: impl Fn(u32) -> bool,
    ) -> Self {
        let soup: Vec<obvhs::triangle::Triangle> = corners
            .map(|[a, b, c]| obvhs::triangle::Triangle {
                v0: a.into(),
                v1: b.into(),
                v2: c.into(),
            })
            .collect();
        let mut laid = Self {
            nodes: Vec::new(),
            triangles: Vec::with_capacity(soup.len()),
            depth: 0,
        };
        if !soup.is_empty() {
            let mut elapsed = std::time::Duration::ZERO;
            // Worlds are built once and cast into millions of times.
            let tree = build_bvh2_from_tris(&soup, BvhBuildParams::slow_build(), &mut elapsed);
            laid.lay_out(&tree, |i| {
                leaf_triangle(&soup[i as usize], first + i, masked(first + i))
            });
        }
        laid
    }

    /// Copies nodes and triangles in the order in which a traversal meets them, siblings in pairs.
    fn lay_out(&mut self, tree: &Bvh2, triangle: impl Fn(u32) -> LeafTriangle) {
        // The root has no sibling. An empty place beside it lets every pair begin at an even index.
        self.nodes = vec![node(tree, 0); 2];
        let mut todo = vec![Copying {
            from: 0,
            to: 0,
            depth: 1,
        }];
        while let Some(Copying { from, to, depth }) = todo.pop() {
            self.depth = self.depth.max(depth);
            let source = &tree.nodes[from as usize];
            if source.prim_count == 0 {
                let first = self.nodes.len();
                self.nodes[to].first = first as u32;
                self.nodes
                    .extend([source.first_index, source.first_index + 1].map(|i| node(tree, i)));
                // The first of the two is popped first.
                for i in [1, 0] {
                    todo.push(Copying {
                        from: source.first_index + i,
                        to: first + i as usize,
                        depth: depth + 1,
                    });
                }
            } else {
                self.nodes[to].first = self.triangles.len() as u32;
                let primitives = source.first_index..source.first_index + source.prim_count;
                let indices = primitives.map(|i| tree.primitive_indices[i as usize]);
                self.triangles.extend(indices.map(&triangle));
            }
        }
    }

    /// The box around all triangles; `None` if there are none.
    pub fn bounds(&self) -> Option<Bounds3> {
        self.nodes.first().map(|root| Bounds3 {
            min: root.min,
            max: root.max,
        })
    }

    /// The first hit of a ray from `origin` along `direction`, within `limit` lengths of
    /// `direction`.
    pub fn cast(&self, origin: [f32; 3], direction: [f32; 3], limit: f32) -> Option<Hit> {
        self.cast_filtered(origin, direction, limit, |_| true)
    }

    /// The same; hits of masked triangles count only where `opaque` is true.
    pub(crate) fn cast_filtered(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        limit: f32,
        opaque: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let inverse = direction.map(reciprocal);
        let mut best = Hit {
            distance: limit,
            triangle: MISS,
            u: 0.0,
            v: 0.0,
        };
        let mut stack = Stack::new();
        if !self.nodes.is_empty() {
            stack.push(Entry {
                node: 0,
                distance: 0.0,
            });
        }
        while let Some(entry) = stack.pop() {
            // A hit that was found meanwhile is nearer than the whole box.
            if entry.distance > best.distance {
                continue;
            }
            let node = &self.nodes[entry.node as usize];
            if node.is_leaf() {
                for triangle in self.leaf(node) {
                    // A copy, since the filter may still refuse the hit.
                    let mut hit = best;
                    if intersect_one(triangle, origin, direction, &mut hit)
                        && (!triangle.masked || opaque(&hit))
                    {
                        best = hit;
                    }
                }
                continue;
            }
            let enter = |node: u32| {
                let box_of_node = &self.nodes[node as usize];
                slab_one(box_of_node, origin, inverse, best.distance)
                    .map(|distance| Entry { node, distance })
            };
            match (enter(node.first), enter(node.first + 1)) {
                (Some(a), Some(b)) => {
                    let (near, far) = if a.distance <= b.distance {
                        (a, b)
                    } else {
                        (b, a)
                    };
                    stack.push(far);
                    stack.push(near);
                }
                (Some(one), None) | (None, Some(one)) => stack.push(one),
                (None, None) => {}
            }
        }
        (best.triangle != MISS).then_some(best)
    }

    #[inline(always)]
    pub(super) fn leaf(&self, node: &Node) -> &[LeafTriangle] {
        &self.triangles[node.first as usize..(node.first + node.kind / 8) as usize]
    }
}

/// A node of the builder's tree; its `first` is still that of the builder.
fn node(tree: &Bvh2, index: u32) -> Node {
    let source = &tree.nodes[index as usize];
    let kind = match source.prim_count {
        0 => {
            let [a, b] = [0, 1].map(|i| &tree.nodes[source.first_index as usize + i].aabb);
            // The axis along which the children's middles are farthest apart tells best which of
            // them a ray meets first.
            let apart: [f32; 3] = ((b.min + b.max) - (a.min + a.max)).into();
            let axis = (0..3).fold(0, |best, i| {
                if apart[i].abs() > apart[best].abs() {
                    i
                } else {
                    best
                }
            });
            2 * axis as u32 + u32::from(apart[axis] < 0.0)
        }
        count => 8 * count,
    };
    Node {
        min: source.aabb.min.into(),
        first: source.first_index,
        max: source.aabb.max.into(),
        kind,
    }
}

/// A node of the builder's tree that is still to be copied.
struct Copying {
    /// Its number there.
    from: u32,
    /// Its number here.
    to: usize,
    /// Nodes from the root to it, both included.
    depth: usize,
}

/// A node that is still to be visited.
#[derive(Clone, Copy)]
struct Entry {
    node: u32,
    /// Where the ray enters its box, in lengths of the direction.
    distance: f32,
}

/// Nodes that are still to be visited: an array, and a vector for degenerate trees. A binary tree
/// of four thousand million triangles fits the array if it is balanced.
struct Stack {
    shallow: [Entry; SHALLOW],
    count: usize,
    deep: Vec<Entry>,
}

/// Entries that need no allocation.
const SHALLOW: usize = 64;

impl Stack {
    fn new() -> Self {
        Self {
            shallow: [Entry {
                node: 0,
                distance: 0.0,
            }; SHALLOW],
            count: 0,
            deep: Vec::new(),
        }
    }

    #[inline(always)]
    fn push(&mut self, entry: Entry) {
        match self.shallow.get_mut(self.count) {
            Some(slot) => {
                *slot = entry;
                self.count += 1;
            }
            None => self.deep.push(entry),
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entry> {
        // What was pushed last is there, if anything is.
        if let Some(entry) = self.deep.pop() {
            return Some(entry);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.shallow[self.count])
    }
}
