//! Searches over layers of cells.
//!
//! Near its ends a search settles states, farther away the borders of ever larger cells: a state
//! takes part in the highest layer in which its cell contains none of the ends. Within a layer a
//! search goes from a cell's entry straight to its exits, and from an exit along the arcs that
//! leave the cell. Two paths through one cell are never joined: the direct one is at least as
//! short.
//!
//! What is settled is a *label*: a state in its layer. Labels of layer 0 are the states, those of
//! layer 1 follow, and so on.
//!
//! | module | contents |
//! |---|---|
//! | `graph` | the graph that is searched, and the ends of a search |
//! | `side` | one direction of a search |
//! | `table` | paths from many places to many |
//! | `values` | durations and lengths of paths, beside their weights |
//! | `path` | the states of a path, from the labels of both directions |

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

/// A label that both sides of a search have reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Meeting {
    /// Of the whole path through the label.
    weight: u32,
    label: u32,
}

/// Which candidates for alternatives are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidates {
    /// How much heavier than the lightest path they may be, as a factor.
    pub stretch: f64,
    /// How many at most.
    pub most: usize,
}

/// A path that may be an alternative.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// Its weight.
    pub weight: u32,
    /// Its states, in order.
    pub states: Vec<u32>,
}

/// Memory of searches, which is used again for the next one.
#[derive(Debug, Default)]
pub struct Workspace {
    sides: [Side; 2],
    ends: Ends,
}

impl Workspace {
    /// The lightest path from one of `sources` to one of `targets`. Its states are put into `path`.
    /// Returns its weight; `None` if there is no path.
    pub fn route(
        &mut self,
        graph: Searched<'_>,
        sources: &[End],
        targets: &[End],
        path: &mut Path,
    ) -> Option<u32> {
        self.begin(graph, sources, targets);
        let met = self.meet(graph, 1.0);
        if let Some(Meeting { label, .. }) = met {
            path.unpack(graph, &self.ends, &self.sides, label);
        }
        self.sides.iter_mut().for_each(Side::clear);
        met.map(|meeting| meeting.weight)
    }

    /// The lightest path and candidates for alternatives: paths through each state that both sides
    /// reach, the lightest first. Each goes through a state that those before it do not; nothing
    /// else is guaranteed.
    pub fn candidates(
        &mut self,
        graph: Searched<'_>,
        sources: &[End],
        targets: &[End],
        wanted: Candidates,
    ) -> Vec<Candidate> {
        self.begin(graph, sources, targets);
        let mut candidates: Vec<Candidate> = Vec::new();
        let (mut path, mut seen) = (Path::default(), HashSet::new());
        for Meeting { weight, label } in self.meetings(graph, wanted.stretch) {
            let state = self.ends.state(graph.overlay, label);
            if candidates.len() == wanted.most {
                break;
            }
            // The path through a state of an earlier path is most often that path again.
            if seen.contains(&state) {
                continue;
            }
            path.unpack(graph, &self.ends, &self.sides, label);
            seen.extend(path.states.iter().copied());
            candidates.push(Candidate {
                weight,
                states: path.states.clone(),
            });
        }
        self.sides.iter_mut().for_each(Side::clear);
        candidates
    }

    /// Puts the ends of a search into its two sides.
    fn begin(&mut self, graph: Searched<'_>, sources: &[End], targets: &[End]) {
        self.ends.set(
            graph.overlay,
            sources.iter().chain(targets).map(|end| end.state),
        );
        let labels = self.ends.labels();
        for (side, ends) in self.sides.iter_mut().zip([sources, targets]) {
            side.begin(labels, ends);
        }
    }

    /// All meetings that are light enough, the lightest first.
    fn meetings(&mut self, graph: Searched<'_>, stretch: f64) -> Vec<Meeting> {
        let Some(best) = self.meet(graph, stretch) else {
            return Vec::new();
        };
        // Labels that only one side has reached sum to `FAR` or more, and are filtered out.
        let limit = ((f64::from(best.weight) * stretch) as u32).min(FAR - 1);
        let [forward, backward] = &self.sides;
        let both = forward.reached().map(|label| Meeting {
            weight: forward.weight(label) + backward.weight(label),
            label,
        });
        let mut meetings: Vec<_> = both.filter(|meeting| meeting.weight <= limit).collect();
        meetings.sort_unstable();
        meetings
    }

    /// Advances both sides in turn until no meeting is possible that is better, or that is at most
    /// `stretch` times as heavy as the best one.
    fn meet(&mut self, graph: Searched<'_>, stretch: f64) -> Option<Meeting> {
        let [forward, backward] = &mut self.sides;
        let tables = [Tables::forward(graph), Tables::backward(graph)];
        let mut best = Meeting {
            weight: FAR,
            label: 0,
        };
        // A label at which both sides begin is a meeting that no step will show.
        for label in &forward.begun {
            let weight = forward.weight(*label) + backward.weight(*label);
            best = best.min(Meeting {
                weight,
                label: *label,
            });
        }
        loop {
            let (a, b) = (forward.next(), backward.next());
            let limit = ((f64::from(best.weight) * stretch) as u32).min(FAR);
            // A path lighter than `a + b` has an arc from a label that one side has settled to one
            // that the other has settled. It was seen when that arc was followed.
            if a + b >= limit {
                break;
            }
            // The nearer side advances, so that both grow equally far.
            let (this, other, tables) = if a <= b {
                (&mut *forward, &*backward, &tables[0])
            } else {
                (&mut *backward, &*forward, &tables[1])
            };
            let Some((label, weight)) = this.pop() else {
                break;
            };
            this.go_on(
                tables,
                &self.ends,
                label,
                weight,
                limit,
                |label, reached| {
                    best = best.min(Meeting {
                        weight: reached + other.weight(label),
                        label,
                    });
                },
            );
        }
        (best.weight < FAR).then_some(best)
    }
}
