//! Nodes of a tree of boxes, and the slab test of one ray against a box.

use super::branchless::{lower, upper};

/// A box. Two siblings share a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct Node {
    pub(super) min: [f32; 3],
    /// First child (its sibling follows) or first triangle.
    pub(super) first: u32,
    pub(super) max: [f32; 3],
    /// Number of triangles in a leaf, times 8. In an inner node: twice the axis along which its
    /// children lie apart, plus one if the first child is the upper one.
    pub(super) kind: u32,
}

/// The children of an inner node, in the order in which rays meet them.
pub(super) struct Children {
    pub(super) near: u32,
    pub(super) far: u32,
}

impl Node {
    #[inline(always)]
    pub(super) fn is_leaf(&self) -> bool {
        self.kind >= 8
    }

    #[inline(always)]
    fn axis(&self) -> usize {
        (self.kind >> 1 & 3) as usize
    }

    #[inline(always)]
    fn flipped(&self) -> u32 {
        self.kind & 1
    }

    /// The children of an inner node for rays that run against the axes with a 1.
    #[inline(always)]
    pub(super) fn ordered(&self, against: &[u32; 3]) -> Children {
        // Rays along the axis meet the lower child first, rays against it the upper one.
        let second_first = against[self.axis()] ^ self.flipped();
        Children {
            near: self.first + second_first,
            far: self.first + 1 - second_first,
        }
    }
}

/// One over `component`, kept finite so that no slab test multiplies zero by infinity.
#[inline(always)]
pub(super) fn reciprocal(component: f32) -> f32 {
    // Its inverse times the largest world is still finite in single precision.
    1.0 / if component.abs() < 1e-18 {
        1e-18
    } else {
        component
    }
}

/// Distance at which the ray enters the box, if it does before `limit`.
#[inline(always)]
pub(super) fn slab_one(
    node: &Node,
    origin: [f32; 3],
    inverse: [f32; 3],
    limit: f32,
) -> Option<f32> {
    let (mut enter, mut leave) = (0.0_f32, limit);
    for axis in 0..3 {
        let a = (node.min[axis] - origin[axis]) * inverse[axis];
        let b = (node.max[axis] - origin[axis]) * inverse[axis];
        enter = upper(lower(a, b), enter);
        leave = lower(upper(a, b), leave);
    }
    // Idle rays have a negative limit: they enter nothing.
    (enter <= leave).then_some(enter)
}
