//! Connected sets of points.

use openbench_core::MapPoint;

use crate::vector::Vector2;

/// Points nearer to each other than this belong to one cluster, metres.
pub(super) const TOGETHER_M: f64 = 0.25;
/// Side of the cells of which one point each is kept, metres.
const THIN_M: f64 = 0.04;
/// More points than this are not of people: the estimate of the robot's pose has jumped, and all
/// walls with it.
const MOST_POINTS: usize = 2000;

/// One point of each small cell: clusters stay connected, and many points of one body cost no more
/// than few.
pub(super) fn thinned(points: &[MapPoint]) -> Vec<MapPoint> {
    let mut kept = points.to_vec();
    // The sort is stable: each cell keeps the point that came first.
    kept.sort_by_key(cell_of);
    kept.dedup_by_key(|point| cell_of(point));
    kept
}

/// Row and column of the small cell that holds a point.
fn cell_of(point: &MapPoint) -> [i64; 2] {
    [point.y, point.x].map(|at| (at / THIN_M).floor() as i64)
}

/// Sets of points each of which is near another of its set; none if there are too many points.
pub(super) fn clusters(points: &[MapPoint]) -> Vec<Vec<MapPoint>> {
    // The search below compares all pairs.
    if points.len() > MOST_POINTS {
        return Vec::new();
    }
    let mut rest = points.to_vec();
    let mut found = Vec::new();
    while let Some(first) = rest.pop() {
        found.push(grown(first, &mut rest));
    }
    found
}

/// The cluster of a point, taken out of the other points.
fn grown(first: MapPoint, rest: &mut Vec<MapPoint>) -> Vec<MapPoint> {
    let mut cluster = vec![first];
    // Points before `looked` have no neighbours left in `rest`.
    let mut looked = 0;
    while looked < cluster.len() {
        let at = cluster[looked];
        looked += 1;
        let mut k = 0;
        while k < rest.len() {
            if rest[k].distance(at) < TOGETHER_M {
                cluster.push(rest.swap_remove(k));
            } else {
                k += 1;
            }
        }
    }
    cluster
}

/// Twice the distance from the mean to the furthest point, metres.
pub(super) fn width(points: &[MapPoint]) -> f64 {
    let middle = mean(points);
    2.0 * points
        .iter()
        .map(|p| apart(Vector2::to(*p), middle))
        .fold(0.0, f64::max)
}

/// The mean of some points, one at least.
pub(super) fn mean(points: &[MapPoint]) -> Vector2 {
    let n = points.len() as f64;
    points.iter().fold(Vector2::ZERO, |m, p| {
        Vector2::new(m.x + p.x / n, m.y + p.y / n)
    })
}

/// The points within a distance of a place, metres.
pub(super) fn points_within(
    points: &[MapPoint],
    place: Vector2,
    distance: f64,
) -> impl Iterator<Item = MapPoint> {
    let near = points
        .iter()
        .filter(move |p| apart(Vector2::to(**p), place) < distance);
    near.copied()
}

/// How far two places are apart, metres, or how much two velocities differ, m/s.
pub(super) fn apart(a: Vector2, b: Vector2) -> f64 {
    (a - b).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `n` by `n` points over a square.
    fn dense(n: u32, side: f64) -> Vec<MapPoint> {
        let at = |i: u32| side * f64::from(i) / f64::from(n);
        (0..n)
            .flat_map(|i| (0..n).map(move |k| MapPoint::new(at(i), at(k))))
            .collect()
    }

    #[test]
    fn many_points_of_a_body_are_one_cluster_of_few() {
        let found = clusters(&thinned(&dense(100, 0.3)));
        assert!(found.len() == 1 && found[0].len() < 100, "{}", found.len());
    }

    #[test]
    fn too_many_points_are_nobody() {
        // Islands 0.6 m apart, as when all walls have jumped.
        let island = |p: &MapPoint| {
            (-5..=5)
                .map(|i| p.offset(0.25 * f64::from(i), 0.1))
                .collect::<Vec<_>>()
        };
        let flood: Vec<MapPoint> = dense(30, 18.0).iter().flat_map(island).collect();
        let found = |points: &[MapPoint]| clusters(&thinned(points)).len();
        assert!(found(&flood[..100]) > 5 && found(&flood) == 0);
    }
}
