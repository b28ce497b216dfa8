//! Turns that are not allowed, and what a traveller must remember to know it.
//!
//! Most turn restrictions are about two roads: coming `from` one, a traveller must not turn `to`
//! the other, or to no other. Some have ways in between. Whether one may turn off the last of these
//! depends on the roads before it. A state of a search is then not just an edge, but an edge
//! *together with* the edges before it: a *prefix* of a restriction, two edges or more. A traveller
//! is always in the longest prefix that ends with the edges travelled last, as in A. Aho, M.
//! Corasick, *Efficient string matching*, 1975.

use std::cmp::Reverse;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use crate::network::{Network, Restriction};
use crate::overlay::NONE;
use crate::profile::{Profile, RestrictionKind};

/// The most edges that the ways in between may consist of, and the most pairs of edges that one
/// restriction may be about.
const MOST_EDGES: usize = 64;
/// The most edges that are examined for all restrictions by ways together: a hundred each, on a map
/// with a hundred thousand of them.
const MOST_WORK: usize = 10_000_000;

/// What may not be travelled one after another.
#[derive(Debug, Clone, Default)]
pub(crate) struct Restrictions {
    /// By the last edge of what must have been travelled.
    rules: HashMap<u32, Vec<Rule>>,
    /// Prefixes of two edges or more, in order.
    prefixes: Vec<Vec<u32>>,
    /// By their last edges: the numbers of prefixes, the longest first.
    ending: HashMap<u32, Vec<u32>>,
    /// Restrictions for which no edges of the network were found, or too many.
    pub(crate) odd: usize,
}

/// The consequence of having travelled certain edges.
#[derive(Debug, Clone)]
struct Rule {
    /// The directed edges that were travelled last.
    travelled: Vec<u32>,
    /// Directed edges that follow.
    to: Vec<u32>,
    /// Whether these are forbidden, or all others.
    kind: RestrictionKind,
}

impl Rule {
    fn forbids(&self, to: u32) -> bool {
        let is_named = self.to.contains(&to);
        match self.kind {
            RestrictionKind::Forbidden => is_named,
            // U-turns are not what such restrictions are about.
            RestrictionKind::Only => !is_named && Some(&(to ^ 1)) != self.travelled.last(),
        }
    }
}

impl Restrictions {
    /// The restrictions of a network that bind a profile. `is_open` says which directed edges the
    /// profile may use.
    pub(crate) fn new(network: &Network, profile: &Profile, is_open: &dyn Fn(u32) -> bool) -> Self {
        let mut finder = Finder::new(network, is_open);
        let mut found: BTreeMap<(Vec<u32>, RestrictionKind), Vec<u32>> = BTreeMap::new();
        let mut odd = 0;
        let mut via_ways: &[i64] = &network.via_ways;
        for restriction in network.restrictions.iter() {
            // Restrictions take their ways off the column in order, those that do not bind the
            // profile too.
            let count = (restriction.ways as usize).min(via_ways.len());
            let (ways, rest) = via_ways.split_at(count);
            via_ways = rest;
            let tags = network.restriction_tags.get(restriction.tags);
            let Some(kind) = profile.restricts(&tags) else {
                continue;
            };
            let turns = finder.turns(restriction, ways);
            odd += usize::from(turns.is_none());
            // Relations about the same travelled edges are merged: two `only_` restrictions allow
            // both of their turns.
            for Turn { travelled, to } in turns.into_iter().flatten() {
                found.entry((travelled, kind)).or_default().push(to);
            }
        }
        let mut all = Self {
            odd,
            ..Self::default()
        };
        for ((travelled, kind), to) in found {
            // A prefix of one edge is the edge's own state.
            let prefixes = (2..=travelled.len()).map(|length| travelled[..length].to_vec());
            all.prefixes.extend(prefixes);
            let rules = all.rules.entry(last_of(&travelled)).or_default();
            rules.push(Rule {
                travelled,
                to,
                kind,
            });
        }
        all.number_prefixes();
        all
    }

    /// Sorts the prefixes, and finds those that end with each edge.
    fn number_prefixes(&mut self) {
        // Restrictions may share a prefix, which must have one number.
        self.prefixes.sort_unstable();
        self.prefixes.dedup();
        for (number, prefix) in (0..).zip(&self.prefixes) {
            self.ending.entry(last_of(prefix)).or_default().push(number);
        }
        for numbers in self.ending.values_mut() {
            numbers.sort_by_key(|number| Reverse(self.prefixes[*number as usize].len()));
        }
    }

    /// The numbers of the prefixes that end with a directed edge, the longest first.
    pub(crate) fn ending(&self, directed: u32) -> &[u32] {
        self.ending.get(&directed).map_or(&[], Vec::as_slice)
    }

    /// The directed edges of a prefix.
    pub(crate) fn prefix(&self, number: u32) -> &[u32] {
        &self.prefixes[number as usize]
    }

    /// Whether a traveller who has come along some directed edges may not continue along another.
    pub(crate) fn forbid(&self, travelled: &[u32], to: u32) -> bool {
        let rules = self
            .rules
            .get(&last_of(travelled))
            .map_or(&[][..], Vec::as_slice);
        let mut matching = rules
            .iter()
            // The state holds the longest prefix, so all shorter rules that apply are its endings.
            .filter(|rule| travelled.ends_with(&rule.travelled));
        matching.any(|rule| rule.forbids(to))
    }

    /// The number of a traveller's prefix after some directed edges and then another; [`NONE`] if
    /// no prefix of two edges or more matches.
    pub(crate) fn next(&self, travelled: &[u32], to: u32) -> u32 {
        let fits = |number: &&u32| {
            let prefix = self.prefix(**number);
            // The prefix ends with `to`, and the rest of it was travelled before.
            travelled.ends_with(&prefix[..prefix.len() - 1])
        };
        self.ending(to).iter().find(fits).copied().unwrap_or(NONE)
    }
}

/// The last of one directed edge or more.
fn last_of(edges: &[u32]) -> u32 {
    edges[edges.len() - 1]
}

/// A turn that a restriction is about.
#[derive(Debug, Clone)]
struct Turn {
    /// The directed edges that are travelled before.
    travelled: Vec<u32>,
    /// The directed edge after the turn.
    to: u32,
}

/// A directed edge of a way at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct EdgeAtNode {
    way: i64,
    node: i64,
    directed: u32,
}

/// Finds the edges of the ways that restrictions are about.
struct Finder<'a> {
    network: &'a Network,
    /// Edges of the first and the last ways, at the nodes where they end. Sorted.
    reaching: Vec<EdgeAtNode>,
    /// Open edges of the ways in between, at the nodes where they begin. Sorted.
    leaving: Vec<EdgeAtNode>,
    /// How many edges may still be examined.
    work: usize,
}

impl<'a> Finder<'a> {
    fn new(network: &'a Network, is_open: &dyn Fn(u32) -> bool) -> Self {
        // Only ways that restrictions name are indexed, of all the network's edges.
        let ends: HashSet<i64> = network
            .restrictions
            .iter()
            .flat_map(|r| [r.from, r.to])
            .collect();
        let between: HashSet<i64> = network.via_ways.iter().copied().collect();
        let (mut reaching, mut leaving) = (Vec::new(), Vec::new());
        for (edge, &way) in (0..).zip(network.ways.iter()) {
            for directed in [2 * edge, 2 * edge + 1] {
                let vertices = network.ends(directed);
                let [from, to] = vertices.map(|vertex| network.vertex_nodes[vertex as usize]);
                if ends.contains(&way) {
                    reaching.push(EdgeAtNode {
                        way,
                        node: to,
                        directed,
                    });
                }
                // A route through closed edges cannot be travelled, so nothing is forbidden behind
                // it.
                if between.contains(&way) && is_open(directed) {
                    leaving.push(EdgeAtNode {
                        way,
                        node: from,
                        directed,
                    });
                }
            }
        }
        reaching.sort_unstable();
        leaving.sort_unstable();
        Self {
            network,
            reaching,
            leaving,
            work: MOST_WORK,
        }
    }

    /// The turns that a restriction is about; `None` if there are none, or too many.
    fn turns(&mut self, restriction: &Restriction, ways: &[i64]) -> Option<Vec<Turn>> {
        let turns = if ways.is_empty() {
            self.turns_at_node(restriction)?
        } else {
            self.turns_after_ways(restriction, ways)?
        };
        Some(turns).filter(|turns| !turns.is_empty())
    }

    fn turns_at_node(&self, restriction: &Restriction) -> Option<Vec<Turn>> {
        let mut turns = Vec::new();
        for from in edges_at(&self.reaching, restriction.from, restriction.via) {
            let into = self
                .edges_into(restriction.to, restriction.via)
                .take(MOST_EDGES);
            turns.extend(into.map(|to| Turn {
                travelled: vec![from],
                to,
            }));
            if turns.len() >= MOST_EDGES {
                return None;
            }
        }
        Some(turns)
    }

    fn turns_after_ways(&mut self, restriction: &Restriction, ways: &[i64]) -> Option<Vec<Turn>> {
        let mut turns = Vec::new();
        // The relation does not say at which node the first way meets those in between. Each end of
        // each of its edges is tried.
        let first = self
            .reaching
            .partition_point(|edge| edge.way < restriction.from);
        for i in first..self.reaching.len() {
            let from = self.reaching[i];
            if from.way != restriction.from {
                break;
            }
            self.work = self.work.checked_sub(ways.len())?;
            self.turns_through(restriction, ways, from, &mut turns)?;
        }
        Some(turns)
    }

    /// Directed edges of a way that leave a node.
    fn edges_into(&self, way: i64, node: i64) -> impl Iterator<Item = u32> + '_ {
        // `reaching` has both directions of each edge. The opposite of one that reaches the node
        // leaves it.
        edges_at(&self.reaching, way, node).map(|directed| directed ^ 1)
    }

    /// Adds the turns after the shortest paths from an edge through the ways in between; `None` if
    /// these ways consist of too many edges.
    fn turns_through(
        &mut self,
        restriction: &Restriction,
        ways: &[i64],
        from: EdgeAtNode,
        turns: &mut Vec<Turn>,
    ) -> Option<()> {
        let EdgeAtNode {
            node,
            directed: from,
            ..
        } = from;
        // Breadth first, so each node is reached by fewest edges. No node is reached twice, which
        // ends the search on loops of ways.
        let mut reached: HashMap<i64, Option<Step>> = HashMap::from([(node, None)]);
        let mut waiting = VecDeque::from([node]);
        while let Some(node) = waiting.pop_front() {
            let mut travelled = path_to(&reached, node);
            if let Some(&last) = travelled.last() {
                travelled.insert(0, from);
                // All beginnings of the path will be kept.
                self.work = self.work.checked_sub(travelled.len() * travelled.len())?;
                let into = self
                    .edges_into(restriction.to, node)
                    .filter(|to| *to != last ^ 1);
                let into = into.take(MOST_EDGES);
                turns.extend(into.map(|to| Turn {
                    travelled: travelled.clone(),
                    to,
                }));
            }
            let onwards = ways
                .iter()
                .flat_map(|way| edges_at(&self.leaving, *way, node));
            for directed in onwards.filter(|directed| *directed != from ^ 1) {
                self.work = self.work.checked_sub(1)?;
                let end = self.network.vertex_nodes[self.network.ends(directed)[1] as usize];
                if let Entry::Vacant(entry) = reached.entry(end) {
                    entry.insert(Some(Step {
                        directed,
                        before: node,
                    }));
                    waiting.push_back(end);
                }
            }
            if reached.len() > MOST_EDGES || turns.len() > MOST_EDGES {
                return None;
            }
        }
        Some(())
    }
}

/// How a node was reached.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// Along this directed edge.
    directed: u32,
    /// From this node.
    before: i64,
}

/// The directed edges along which a node was reached, in order.
fn path_to(reached: &HashMap<i64, Option<Step>>, node: i64) -> Vec<u32> {
    let steps = std::iter::successors(reached[&node], |step| reached[&step.before]);
    let mut path: Vec<u32> = steps.map(|step| step.directed).collect();
    path.reverse();
    path
}

/// The directed edges of a way at a node.
fn edges_at(edges: &[EdgeAtNode], way: i64, node: i64) -> impl Iterator<Item = u32> {
    let first = edges.partition_point(|edge| (edge.way, edge.node) < (way, node));
    let matching = edges[first..]
        .iter()
        .take_while(move |e| (e.way, e.node) == (way, node));
    matching.map(|edge| edge.directed)
}
