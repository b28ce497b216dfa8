//! Searches over layers of cells.
//!
//! Near its ends a route is searched for among states, further away among the borders of ever larger cells: a state takes part in the
//! highest layer in which it is in another cell than all of the ends. In a layer a search goes from a cell's entry straight to its
//! exits, and from an exit along the arcs that leave the cell. Two ways through one cell are never put together: there is none shorter
//! than the one that is known.
//!
//! What is settled is a *label*: a state in its layer. Labels of layer 0 are the states, those of layer 1 follow, and so forth.
//!
//! | module | its one job |
//! |---|---|
//! | `graph` | what is searched, and the ends of a search |
//! | `side` | one direction of a search: labels, and what is reached from them |
//! | `table` | from many places to many |
//! | `values` | what ways take, beside what they weigh |
//! | `path` | from both directions to a row of states |

mod graph;
mod path;
mod side;
mod table;
mod values;

use std::collections::HashSet;

use crate::overlay::FAR;
use graph::Ends;
pub use graph::{End, Searched};
pub use path::Path;
use side::{Side, Tables};
pub use table::{Found, TableMemory, ValuedEnd};
pub use values::{Value, Values};

/// Memory of searches, which is used again for the next one.
#[derive(Debug, Default)]
pub struct Workspace {
    sides: [Side; 2],
    ends: Ends,
}

impl Workspace {
    /// The lightest way from one of `sources` to one of `targets`; its states are put into `path`. `None` if there is none.
    pub fn route(
        &mut self,
        graph: Searched<'_>,
        sources: &[End],
        targets: &[End],
        path: &mut Path,
    ) -> Option<u32> {
        let states = sources.iter().chain(targets).map(|end| end.state);
        self.ends.set(graph.overlay, states);
        let labels = self.ends.labels();
        for (side, ends) in self.sides.iter_mut().zip([sources, targets]) {
            side.begin(labels, ends);
        }
        let met = self.meet(graph, 1.0);
        if let Some((_, label)) = met {
            path.unpack(graph, &self.ends, &self.sides, label);
        }
        self.sides.iter_mut().for_each(Side::clear);
        met.map(|(weight, _)| weight)
    }

    /// The lightest way and other ways: through each place that both sides reach, as long as the way is at most `stretch` times as heavy as
    /// the lightest one, `most` in all. Each goes through a state that those before it do not; nothing else is said of them.
    pub fn ways(
        &mut self,
        graph: Searched<'_>,
        sources: &[End],
        targets: &[End],
        stretch: f64,
        most: usize,
    ) -> Vec<(u32, Vec<u32>)> {
        self.ends.set(
            graph.overlay,
            sources.iter().chain(targets).map(|end| end.state),
        );
        let labels = self.ends.labels();
        for (side, ends) in self.sides.iter_mut().zip([sources, targets]) {
            side.begin(labels, ends);
        }
        let mut ways: Vec<(u32, Vec<u32>)> = Vec::new();
        let (mut path, mut seen) = (Path::default(), HashSet::new());
        for (weight, label) in self.meetings(graph, stretch) {
            let state = self.ends.state(graph.overlay, label);
            if ways.len() == most {
                break;
            }
            if seen.contains(&state) {
                continue;
            }
            path.unpack(graph, &self.ends, &self.sides, label);
            seen.extend(path.states.iter().copied());
            ways.push((weight, path.states.clone()));
        }
        self.sides.iter_mut().for_each(Side::clear);
        ways
    }

    /// All meetings that are light enough, the lightest first.
    fn meetings(&mut self, graph: Searched<'_>, stretch: f64) -> Vec<(u32, u32)> {
        let Some((best, _)) = self.meet(graph, stretch) else {
            return Vec::new();
        };
        let limit = ((f64::from(best) * stretch) as u32).min(FAR - 1);
        let [forward, backward] = &self.sides;
        let both = forward
            .reached()
            .map(|label| (forward.weight(label) + backward.weight(label), label));
        let mut meetings: Vec<_> = both.filter(|(weight, _)| *weight <= limit).collect();
        meetings.sort_unstable();
        meetings
    }

    /// Both sides in turn until no meeting is possible that is better, or that is at most `stretch` times as heavy as the best one.
    fn meet(&mut self, graph: Searched<'_>, stretch: f64) -> Option<(u32, u32)> {
        let [forward, backward] = &mut self.sides;
        let tables = [Tables::forward(graph), Tables::backward(graph)];
        let mut best = (FAR, 0);
        for end in &forward.begun {
            best = best.min((forward.weight(*end) + backward.weight(*end), *end));
        }
        loop {
            let (a, b) = (forward.next(), backward.next());
            let limit = ((f64::from(best.0) * stretch) as u32).min(FAR);
            if a + b >= limit {
                break;
            }
            let (this, other, tables) = if a <= b {
                (&mut *forward, &*backward, &tables[0])
            } else {
                (&mut *backward, &*forward, &tables[1])
            };
            let Some((label, weight)) = this.pop() else {
                break;
            };
            this.go_on(tables, &self.ends, label, weight, limit, |to, reached| {
                best = best.min((reached + other.weight(to), to));
            });
        }
        (best.0 < FAR).then_some(best)
    }
}
