//! Axis-aligned boxes in space.

/// An axis-aligned box in space, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds3 {
    /// Lowest coordinates.
    pub min: [f32; 3],
    /// Highest coordinates.
    pub max: [f32; 3],
}

impl Bounds3 {
    /// The smallest box that holds both.
    pub(super) fn union(self, other: Self) -> Self {
        Self {
            min: [0, 1, 2].map(|i| self.min[i].min(other.min[i])),
            max: [0, 1, 2].map(|i| self.max[i].max(other.max[i])),
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.min.iter().chain(&self.max).all(|c| c.is_finite())
    }

    /// Twice the coordinate of the middle along an axis.
    pub(super) fn doubled_middle(&self, axis: usize) -> f32 {
        self.min[axis] + self.max[axis]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_union_holds_both_boxes() {
        let a = Bounds3 {
            min: [0.0, -1.0, 2.0],
            max: [1.0, 1.0, 3.0],
        };
        let b = Bounds3 {
            min: [-2.0, 0.0, 2.5],
            max: [0.5, 4.0, 2.6],
        };
        let both = a.union(b);
        assert_eq!((both.min, both.max), ([-2.0, -1.0, 2.0], [1.0, 4.0, 3.0]));
        assert_eq!(both.doubled_middle(1), 3.0);
    }
}
