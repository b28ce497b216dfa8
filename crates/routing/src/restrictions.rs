//! Turns that are not allowed, and what must be remembered to know it.
//!
//! Most restrictions are about two roads: who comes `from` one must not turn `to` the other, or to no other. Some have ways in between. Whether one
//! may turn off the last of these depends on where one came from, so that a traveller is not just on an edge, but on an edge *and* behind others: a
//! *row* of edges with which a restriction begins. A traveller is always in the longest such row that ends with the edges travelled last, as in
//! A. Aho, M. Corasick, *Efficient string matching*, 1975.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use crate::network::{Network, Restriction};
use crate::overlay::NONE;
use crate::profile::Profile;

/// Edges that the ways in between may be made of, and pairs of edges that one restriction may be about.
const MOST: usize = 64;
/// Edges that are looked at for all restrictions by ways together: a hundred each, on a map of a hundred thousand of them.
const WORK: usize = 10_000_000;

/// What may not be travelled one after another.
#[derive(Debug, Clone, Default)]
pub(crate) struct Restrictions {
    /// By the last edge of their rows.
    rules: HashMap<u32, Vec<Rule>>,
    /// Rows of two edges and more, in order.
    rows: Vec<Vec<u32>>,
    /// By their last edges: the numbers of rows, the longest first.
    ending: HashMap<u32, Vec<u32>>,
    /// Restrictions that no edges of the network were found for, or too many.
    pub(crate) odd: usize,
}

#[derive(Debug, Clone)]
struct Rule {
    /// Whoever has travelled these directed edges
    row: Vec<u32>,
    /// must not go on along one of these, or if `only`, along no other.
    to: Vec<u32>,
    only: bool,
}

impl Restrictions {
    /// What the restrictions of a network say to a profile, to which some directed edges are open.
    pub(crate) fn new(network: &Network, profile: &Profile, open: &dyn Fn(u32) -> bool) -> Self {
        let mut finder = Finder::new(network, open);
        let (mut found, mut odd) = (BTreeMap::<(Vec<u32>, bool), Vec<u32>>::new(), 0);
        let mut via_ways: &[i64] = &network.via_ways;
        for restriction in network.restrictions.iter() {
            let (ways, rest) = via_ways.split_at((restriction.ways as usize).min(via_ways.len()));
            via_ways = rest;
            let words = network.restriction_words.get(restriction.words);
            let Some(only) = profile.restricts(&words) else {
                continue;
            };
            let rows = finder.rows(restriction, ways);
            odd += usize::from(rows.is_none());
            for (row, to) in rows.into_iter().flatten() {
                found.entry((row, only)).or_default().push(to);
            }
        }
        let mut all = Self {
            odd,
            ..Self::default()
        };
        let mut rows = Vec::new();
        for ((row, only), to) in found {
            rows.extend((2..=row.len()).map(|length| row[..length].to_vec()));
            all.rules
                .entry(row[row.len() - 1])
                .or_default()
                .push(Rule { row, to, only });
        }
        rows.sort_unstable();
        rows.dedup();
        for (number, row) in (0..).zip(&rows) {
            all.ending
                .entry(row[row.len() - 1])
                .or_default()
                .push(number);
        }
        for numbers in all.ending.values_mut() {
            numbers.sort_by_key(|number| std::cmp::Reverse(rows[*number as usize].len()));
        }
        Self { rows, ..all }
    }

    /// The rows that end with a directed edge, the longest first.
    pub(crate) fn ending(&self, directed: u32) -> &[u32] {
        self.ending.get(&directed).map_or(&[], Vec::as_slice)
    }

    /// The directed edges of a row.
    pub(crate) fn row(&self, number: u32) -> &[u32] {
        &self.rows[number as usize]
    }

    /// Whether one who has travelled a row of directed edges may not go on along another.
    pub(crate) fn forbid(&self, travelled: &[u32], to: u32) -> bool {
        let last = travelled[travelled.len() - 1];
        let rules = self.rules.get(&last).map_or(&[][..], Vec::as_slice);
        rules
            .iter()
            .filter(|rule| travelled.ends_with(&rule.row))
            .any(|rule| {
                let named = rule.to.contains(&to);
                if rule.only {
                    !named && to != last ^ 1
                } else {
                    named
                }
            })
    }

    /// The row that one is in who has travelled a row of directed edges and goes on along another; [`NONE`] if in none of two or more.
    pub(crate) fn next(&self, travelled: &[u32], to: u32) -> u32 {
        let fits = |number: &&u32| {
            let row = self.row(**number);
            travelled.ends_with(&row[..row.len() - 1])
        };
        self.ending(to).iter().find(fits).copied().unwrap_or(NONE)
    }
}

/// Finds the edges of ways that restrictions are about.
struct Finder<'a> {
    network: &'a Network,
    /// Way, the node at the end of one of its directed edges, and that edge.
    reaching: Vec<(i64, i64, u32)>,
    /// The same by the node at the beginning, for ways in between.
    leaving: Vec<(i64, i64, u32)>,
    /// How much may still be looked at.
    work: usize,
}

impl<'a> Finder<'a> {
    fn new(network: &'a Network, open: &dyn Fn(u32) -> bool) -> Self {
        let ends: HashSet<i64> = network
            .restrictions
            .iter()
            .flat_map(|r| [r.from, r.to])
            .collect();
        let between: HashSet<i64> = network.via_ways.iter().copied().collect();
        let (mut reaching, mut leaving) = (Vec::new(), Vec::new());
        for (edge, way) in (0..).zip(network.ways.iter()) {
            let directed = [2 * edge, 2 * edge + 1];
            let nodes = directed.map(|d| network.ends(d).map(|v| network.vertex_nodes[v as usize]));
            for (directed, [from, to]) in directed.into_iter().zip(nodes) {
                if ends.contains(way) {
                    reaching.push((*way, to, directed));
                }
                if between.contains(way) && open(directed) {
                    leaving.push((*way, from, directed));
                }
            }
        }
        reaching.sort_unstable();
        leaving.sort_unstable();
        Self {
            network,
            reaching,
            leaving,
            work: WORK,
        }
    }

    /// Rows of directed edges and the edge that a restriction says something about behind each; `None` if there are none, or too many.
    fn rows(&mut self, restriction: &Restriction, ways: &[i64]) -> Option<Vec<(Vec<u32>, u32)>> {
        let mut rows = Vec::new();
        if ways.is_empty() {
            for from in at(&self.reaching, restriction.from, restriction.via) {
                rows.extend(
                    self.turns_into(restriction.to, restriction.via)
                        .map(|to| (vec![from], to))
                        .take(MOST),
                );
                if rows.len() >= MOST {
                    return None;
                }
            }
        } else {
            let first = self
                .reaching
                .partition_point(|(way, ..)| *way < restriction.from);
            for i in first..self.reaching.len() {
                let (way, node, from) = self.reaching[i];
                if way != restriction.from {
                    break;
                }
                self.work = self.work.checked_sub(ways.len())?;
                self.through(restriction, ways, node, from, &mut rows)?;
            }
        }
        Some(rows).filter(|rows| !rows.is_empty())
    }

    /// Directed edges of a way that leave a node.
    fn turns_into(&self, way: i64, node: i64) -> impl Iterator<Item = u32> + '_ {
        at(&self.reaching, way, node).map(|directed| directed ^ 1)
    }

    /// The rows from an edge that reaches `node` through the ways in between, the shortest ones; `None` if these ways are too many edges.
    fn through(
        &mut self,
        restriction: &Restriction,
        ways: &[i64],
        node: i64,
        from: u32,
        rows: &mut Vec<(Vec<u32>, u32)>,
    ) -> Option<()> {
        // Nodes with the edge that each is reached along and the node before it.
        let mut reached = HashMap::from([(node, None)]);
        let mut waiting = VecDeque::from([node]);
        while let Some(node) = waiting.pop_front() {
            let mut row: Vec<u32> =
                std::iter::successors(reached[&node], |(_, before)| reached[before])
                    .map(|(directed, _)| directed)
                    .collect();
            if let Some(&last) = row.first() {
                row.push(from);
                row.reverse();
                // All beginnings of the row will be kept.
                self.work = self.work.checked_sub(row.len() * row.len())?;
                let turns = self
                    .turns_into(restriction.to, node)
                    .filter(|to| *to != last ^ 1);
                rows.extend(turns.take(MOST).map(|to| (row.clone(), to)));
            }
            for directed in ways
                .iter()
                .flat_map(|way| at(&self.leaving, *way, node))
                .filter(|d| *d != from ^ 1)
            {
                self.work = self.work.checked_sub(1)?;
                let end = self.network.vertex_nodes[self.network.ends(directed)[1] as usize];
                if let std::collections::hash_map::Entry::Vacant(entry) = reached.entry(end) {
                    entry.insert(Some((directed, node)));
                    waiting.push_back(end);
                }
            }
            if reached.len() > MOST || rows.len() > MOST {
                return None;
            }
        }
        Some(())
    }
}

/// The directed edges of a way at a node.
fn at(edges: &[(i64, i64, u32)], way: i64, node: i64) -> impl Iterator<Item = u32> {
    let first = edges.partition_point(|(w, n, _)| (*w, *n) < (way, node));
    edges[first..]
        .iter()
        .take_while(move |(w, n, _)| (*w, *n) == (way, node))
        .map(|(.., directed)| *directed)
}
