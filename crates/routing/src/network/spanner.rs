//! Shortest paths over a few points, and the lines among them that are worth keeping.

/// How much longer a path may become when lines are left out, as a factor.
const MOST_DETOUR: f64 = 1.05;

/// No point.
const NONE: usize = usize::MAX;

/// Points with lines between them.
#[derive(Debug, Clone)]
pub(super) struct Lines {
    of: Vec<Vec<Line>>,
}

/// A line to another point.
#[derive(Debug, Clone, Copy)]
struct Line {
    to: usize,
    /// Metres.
    length: f64,
}

impl Lines {
    /// So many points and no lines.
    pub(super) fn new(points: usize) -> Self {
        Self {
            of: vec![Vec::new(); points],
        }
    }

    /// Adds a line between two points.
    pub(super) fn add(&mut self, a: usize, b: usize, length: f64) {
        self.of[a].push(Line { to: b, length });
        self.of[b].push(Line { to: a, length });
    }

    /// The shortest paths from a point: E. W. Dijkstra, *A note on two problems in connexion with
    /// graphs*, 1959, without a heap.
    pub(super) fn shortest(&self, from: usize) -> ShortestPaths {
        let mut length = vec![f64::INFINITY; self.of.len()];
        let mut before = vec![NONE; self.of.len()];
        let mut open: Vec<usize> = (0..self.of.len()).collect();
        length[from] = 0.0;
        // Each point is taken once, nearest first. Points that cannot be reached come last, and
        // their infinite length improves none.
        while let Some(nearest) = position_of_nearest(&open, &length) {
            let point = open.swap_remove(nearest);
            for line in &self.of[point] {
                if length[point] + line.length < length[line.to] {
                    length[line.to] = length[point] + line.length;
                    before[line.to] = point;
                }
            }
        }
        ShortestPaths { length, before }
    }
}

fn position_of_nearest(open: &[usize], length: &[f64]) -> Option<usize> {
    (0..open.len()).min_by(|a, b| length[open[*a]].total_cmp(&length[open[*b]]))
}

/// The shortest paths from one point to all others.
#[derive(Debug, Clone)]
pub(super) struct ShortestPaths {
    /// For each point its distance, metres.
    length: Vec<f64>,
    /// For each point the one before it.
    before: Vec<usize>,
}

impl ShortestPaths {
    /// The lines of the path to a point, from its end, as pairs of points in ascending order.
    pub(super) fn lines_to(&self, point: usize) -> impl Iterator<Item = [usize; 2]> {
        let mut at = point;
        std::iter::from_fn(move || {
            let before = self.before[at];
            let line = (before != NONE).then(|| [at.min(before), at.max(before)]);
            at = if before == NONE { at } else { before };
            line
        })
    }
}

/// Those of the lines without which a path would be more than 5 % longer: I. Althöfer et al.,
/// *On sparse spanners of weighted graphs*, 1993. Between a hundred entries there are thousands of
/// lines; a few hundred suffice.
pub(super) fn thinned(
    points: usize,
    lines: &[[usize; 2]],
    length: impl Fn([usize; 2]) -> f64,
) -> Vec<[usize; 2]> {
    let mut sorted: Vec<(f64, [usize; 2])> =
        lines.iter().map(|ends| (length(*ends), *ends)).collect();
    // The greedy spanner: from the shortest line on, one is kept only if those kept before are too
    // long a detour. Equal lengths are ordered by ends, so that the result is unique.
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut graph = Lines::new(points);
    let mut kept = Vec::new();
    for (length, [a, b]) in sorted {
        if graph.shortest(a).length[b] > length * MOST_DETOUR {
            graph.add(a, b, length);
            kept.push([a, b]);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle of 3, 4 and 5 m.
    fn triangle() -> Lines {
        let mut lines = Lines::new(3);
        lines.add(0, 1, 3.0);
        lines.add(1, 2, 4.0);
        lines.add(0, 2, 5.0);
        lines
    }

    #[test]
    fn the_shortest_path_is_found() {
        let paths = triangle().shortest(0);
        assert_eq!(paths.length, [0.0, 3.0, 5.0]);
        assert_eq!(paths.lines_to(2).collect::<Vec<_>>(), [[0, 2]]);
        assert_eq!(paths.lines_to(0).count(), 0);
    }

    #[test]
    fn lines_that_save_less_than_a_twentieth_are_left_out() {
        let length = |ends: [usize; 2]| match ends {
            [0, 1] | [1, 2] => 1.0,
            _ => 1.95,
        };
        assert_eq!(
            thinned(3, &[[0, 1], [0, 2], [1, 2]], length),
            [[0, 1], [1, 2]]
        );
    }
}
