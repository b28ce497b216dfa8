//! Finds the nearest of many boxes with a tree of bounding boxes, split at the median.
//!
//! The tree is built once. Its memory grows with the number of boxes only, however far apart they
//! are.

use openbench_core::MapPoint;

use openbench_geometry::Bounds;

/// Boxes to search.
#[derive(Debug, Clone, Default)]
pub(crate) struct BoxTree {
    root: Option<Box<Branch>>,
}

/// A box and its number among those that the tree was made from.
#[derive(Debug, Clone, Copy)]
struct Item {
    index: usize,
    bounds: Bounds,
}

/// The item nearest so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    pub(crate) index: usize,
    /// Metres.
    pub(crate) distance: f64,
}

#[derive(Debug, Clone)]
enum Branch {
    Leaf(Item),
    Fork(Bounds, Box<Branch>, Box<Branch>),
}

impl BoxTree {
    /// A tree over boxes.
    pub(crate) fn new(boxes: impl Iterator<Item = Bounds>) -> Self {
        let mut items: Vec<Item> = boxes
            .enumerate()
            .map(|(index, bounds)| Item { index, bounds })
            .collect();
        Self {
            root: (!items.is_empty()).then(|| Box::new(branch(&mut items))),
        }
    }

    /// The item with the least `distance`. `distance` must not be less than the distance to the
    /// item's box. Of several equally near items the one with the lowest index.
    pub(crate) fn nearest(
        &self,
        point: MapPoint,
        distance: impl Fn(usize) -> f64,
    ) -> Option<Nearest> {
        let mut best = None;
        if let Some(root) = &self.root {
            root.nearest(point, &distance, &mut best);
        }
        best
    }

    /// The items whose boxes are within `radius` of `point`, lowest index first.
    pub(crate) fn within(&self, point: MapPoint, radius: f64) -> Vec<usize> {
        let mut found = Vec::new();
        if let Some(root) = &self.root {
            root.within(point, radius, &mut found);
        }
        found.sort_unstable();
        found
    }
}

/// A tree over one item or more.
fn branch(items: &mut [Item]) -> Branch {
    if let [item] = items {
        return Branch::Leaf(*item);
    }
    let bounds = items
        .iter()
        .map(|item| item.bounds)
        .reduce(Bounds::union)
        .unwrap_or_default();
    // Split across the longer side, so that boxes stay compact.
    let is_wide = bounds.high.x - bounds.low.x > bounds.high.y - bounds.low.y;
    // Halves by number, so the recursion is only as deep as the logarithm of it, wherever the boxes
    // are.
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        let (left, right) = (twice_the_centre(a, is_wide), twice_the_centre(b, is_wide));
        left.total_cmp(&right).then(a.index.cmp(&b.index))
    });
    let (left, right) = items.split_at_mut(middle);
    Branch::Fork(bounds, Box::new(branch(left)), Box::new(branch(right)))
}

/// Twice the centre of a box along one axis: x if the boxes lie in a wide area, else y.
fn twice_the_centre(item: &Item, is_wide: bool) -> f64 {
    let Bounds { low, high } = item.bounds;
    if is_wide {
        low.x + high.x
    } else {
        low.y + high.y
    }
}

impl Nearest {
    /// Whether it is nearer, or as near with a lower index.
    fn is_before(self, other: Self) -> bool {
        self.distance < other.distance
            || self.distance == other.distance && self.index < other.index
    }
}

impl Branch {
    fn bounds(&self) -> &Bounds {
        match self {
            Self::Leaf(Item { bounds, .. }) | Self::Fork(bounds, ..) => bounds,
        }
    }

    fn nearest(
        &self,
        point: MapPoint,
        distance: &impl Fn(usize) -> f64,
        best: &mut Option<Nearest>,
    ) {
        // Not `>=`: an equally near item of a lower index may be inside.
        if best.is_some_and(|best| self.bounds().distance(point) > best.distance) {
            return;
        }
        match self {
            Self::Leaf(Item { index, .. }) => {
                let found = Nearest {
                    index: *index,
                    distance: distance(*index),
                };
                if best.is_none_or(|best| found.is_before(best)) {
                    *best = Some(found);
                }
            }
            Self::Fork(_, a, b) => {
                // The nearer half first: what it finds often rules the other half out.
                let a_first = a.bounds().distance(point) <= b.bounds().distance(point);
                let (first, second) = if a_first { (a, b) } else { (b, a) };
                first.nearest(point, distance, best);
                second.nearest(point, distance, best);
            }
        }
    }

    fn within(&self, point: MapPoint, radius: f64, found: &mut Vec<usize>) {
        if self.bounds().distance(point) > radius {
            return;
        }
        match self {
            Self::Leaf(Item { index, .. }) => found.push(*index),
            Self::Fork(_, a, b) => {
                a.within(point, radius, found);
                b.within(point, radius, found);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_tree_agrees_with_a_linear_search(
            points in prop::collection::vec((-50i32..50, -50i32..50), 0..60),
            x in -60i32..60,
            y in -60i32..60,
        ) {
            let points: Vec<MapPoint> = points.into_iter().map(|(x, y)| whole(x, y)).collect();
            let p = whole(x, y);
            let tree = BoxTree::new(points.iter().map(|point| Bounds::of_point(*point)));
            let distance = |i: usize| points[i].distance(p);
            let all = 0..points.len();
            let nearest = all.clone().min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
            prop_assert_eq!(tree.nearest(p, distance).map(|nearest| nearest.index), nearest);
            let near: Vec<usize> = all.filter(|i| distance(*i) <= 9.0).collect();
            prop_assert_eq!(tree.within(p, 9.0), near);
        }
    }

    fn whole(x: i32, y: i32) -> MapPoint {
        MapPoint::new(f64::from(x), f64::from(y))
    }
}
