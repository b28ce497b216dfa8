//! The ways, nodes and squares that a network is built from, as they come out of a map.

use super::graph::Restriction;
use super::tag_sets::{Classes, Names};
use crate::geo::Place;

/// Areas with more corners than this are walked around, not crossed.
pub(super) const MOST_CORNERS: usize = 400;

/// Ways that a profile may be asked about, by number.
#[derive(Debug)]
pub(super) struct Ways {
    pub(super) classes: Classes,
    pub(super) names: Names,
    pub(super) ways: Vec<Way>,
    /// The nodes of all ways, one way after another.
    pub(super) references: Vec<i64>,
    /// How many ways have tags that hold at some times only.
    pub(super) conditional: usize,
    pub(super) restrictions: Vec<Restriction>,
    /// The ways in between of all restrictions.
    pub(super) via_ways: Vec<i64>,
    pub(super) restriction_sets: Classes,
    /// How many turn restrictions are not understood.
    pub(super) odd_restrictions: usize,
    pub(super) squares: Vec<Square>,
    /// The nodes of all squares.
    pub(super) corners: Vec<i64>,
    /// How many squares have an outline that is incomplete or too long.
    pub(super) squares_without_outline: usize,
}

/// A way of the network.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) id: i64,
    /// Its first node among the references, and how many it has.
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) class: u32,
    pub(super) name: u32,
    /// Seconds that a ferry takes, if its tags say so.
    pub(super) seconds: Option<f64>,
}

/// A pedestrian area, which can be crossed.
#[derive(Debug, Clone)]
pub(super) struct Square {
    /// The way or relation.
    pub(super) id: i64,
    pub(super) is_relation: bool,
    /// The ways that its outline and its holes are made of.
    pub(super) outlines: Vec<i64>,
    /// The nodes of the outline and of the holes, the first node not repeated at the end.
    pub(super) rings: Vec<Vec<i64>>,
    pub(super) class: u32,
    pub(super) name: u32,
}

/// The nodes of the network, by number.
#[derive(Debug)]
pub(super) struct Nodes {
    pub(super) ids: Vec<i64>,
    /// `None` for nodes that the map lacks.
    pub(super) places: Vec<Option<Place>>,
    pub(super) classes: Vec<u32>,
    /// The sets of tags of nodes.
    pub(super) sets: Classes,
}

impl Ways {
    /// No ways.
    pub(super) fn new() -> Self {
        Self {
            classes: Classes::new(),
            names: Names::new(),
            ways: Vec::new(),
            references: Vec::new(),
            conditional: 0,
            restrictions: Vec::new(),
            via_ways: Vec::new(),
            restriction_sets: Classes::new(),
            odd_restrictions: 0,
            squares: Vec::new(),
            corners: Vec::new(),
            squares_without_outline: 0,
        }
    }

    /// The nodes of a way.
    pub(super) fn nodes(&self, way: &Way) -> &[i64] {
        &self.references[way.first..way.first + way.count]
    }
}

impl Nodes {
    /// The index of a node.
    #[inline]
    pub(super) fn index(&self, id: i64) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    /// The index of a node whose place is known.
    #[inline]
    pub(super) fn known(&self, id: i64) -> Option<usize> {
        self.index(id).filter(|index| self.places[*index].is_some())
    }
}
