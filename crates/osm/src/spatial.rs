//! Finds the nearest of many boxes: a tree of bounding boxes, split at the median. Built once, in memory that grows with the
//! number of boxes only, however far apart they lie.

use openbench_core::MapPoint;

#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: MapPoint,
    high: MapPoint,
}

impl Bounds {
    fn around(self, other: Self) -> Self {
        Self {
            low: MapPoint::new(self.low.x.min(other.low.x), self.low.y.min(other.low.y)),
            high: MapPoint::new(self.high.x.max(other.high.x), self.high.y.max(other.high.y)),
        }
    }

    /// Metres from `p`; 0 inside.
    fn distance(&self, p: MapPoint) -> f64 {
        let dx = (self.low.x - p.x).max(p.x - self.high.x).max(0.0);
        let dy = (self.low.y - p.y).max(p.y - self.high.y).max(0.0);
        (dx * dx + dy * dy).sqrt()
    }
}

/// Boxes to search among.
#[derive(Debug, Clone, Default)]
pub(crate) struct BoxTree {
    root: Option<Box<Branch>>,
}

#[derive(Debug, Clone)]
enum Branch {
    Leaf(Bounds, usize),
    Fork(Bounds, Box<Branch>, Box<Branch>),
}

impl BoxTree {
    /// A tree over boxes given by their south-west and north-east corners.
    pub(crate) fn new(boxes: impl Iterator<Item = (MapPoint, MapPoint)>) -> Self {
        let mut items: Vec<_> = boxes
            .map(|(low, high)| Bounds { low, high })
            .enumerate()
            .collect();
        Self {
            root: (!items.is_empty()).then(|| Box::new(branch(&mut items))),
        }
    }

    /// The item for which `distance` is least, and that distance. `distance` must not be less than the distance to the item's
    /// box. Of several equally near the one with the lowest index.
    pub(crate) fn nearest(
        &self,
        point: MapPoint,
        distance: impl Fn(usize) -> f64,
    ) -> Option<(usize, f64)> {
        let mut best = None;
        if let Some(root) = &self.root {
            root.nearest(point, &distance, &mut best);
        }
        best
    }

    /// The items whose boxes lie within `radius` of `point`, lowest index first.
    pub(crate) fn within(&self, point: MapPoint, radius: f64) -> Vec<usize> {
        let mut found = Vec::new();
        if let Some(root) = &self.root {
            root.within(point, radius, &mut found);
        }
        found.sort_unstable();
        found
    }
}

fn branch(items: &mut [(usize, Bounds)]) -> Branch {
    if let [(index, bounds)] = items {
        return Branch::Leaf(*bounds, *index);
    }
    let all = items.iter().map(|(_, b)| *b).reduce(Bounds::around);
    let all = all.unwrap_or(Bounds {
        low: MapPoint::default(),
        high: MapPoint::default(),
    });
    let wide = all.high.x - all.low.x > all.high.y - all.low.y;
    let key = |(_, b): &(usize, Bounds)| {
        if wide {
            b.low.x + b.high.x
        } else {
            b.low.y + b.high.y
        }
    };
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.0.cmp(&b.0)));
    let (left, right) = items.split_at_mut(middle);
    Branch::Fork(all, Box::new(branch(left)), Box::new(branch(right)))
}

impl Branch {
    fn bounds(&self) -> &Bounds {
        match self {
            Self::Leaf(bounds, _) | Self::Fork(bounds, ..) => bounds,
        }
    }

    fn nearest(
        &self,
        point: MapPoint,
        distance: &impl Fn(usize) -> f64,
        best: &mut Option<(usize, f64)>,
    ) {
        if best.is_some_and(|(_, least)| self.bounds().distance(point) > least) {
            return;
        }
        match self {
            Self::Leaf(_, index) => {
                let d = distance(*index);
                if best.is_none_or(|(i, least)| d < least || d == least && *index < i) {
                    *best = Some((*index, d));
                }
            }
            Self::Fork(_, a, b) => {
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
            Self::Leaf(_, index) => found.push(*index),
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
        fn the_tree_finds_what_a_plain_search_finds(
            points in prop::collection::vec((-50i32..50, -50i32..50), 0..60), x in -60i32..60, y in -60i32..60,
        ) {
            let points: Vec<_> = points.iter().map(|(x, y)| MapPoint::new(f64::from(*x), f64::from(*y))).collect();
            let p = MapPoint::new(f64::from(x), f64::from(y));
            let tree = BoxTree::new(points.iter().map(|q| (*q, *q)));
            let plain = (0..points.len()).min_by(|a, b| points[*a].distance(p).total_cmp(&points[*b].distance(p)));
            prop_assert_eq!(tree.nearest(p, |i| points[i].distance(p)).map(|(i, _)| i), plain);
            let near: Vec<_> = (0..points.len()).filter(|i| points[*i].distance(p) <= 9.0).collect();
            prop_assert_eq!(tree.within(p, 9.0), near);
        }
    }
}
