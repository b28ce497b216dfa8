//! The outlines of squares that are relations: rings joined from the ways of their members.

use std::collections::{HashMap, HashSet};

use openbench_osm::visitor::{Elements, Visitor, WayRef};
use openbench_osm::{ElementKind, OsmError};

use super::elements::{MOST_CORNERS, Square};

/// The most nodes that the outlines of all relations may have together. A million relations can
/// name the same outline.
const MOST_NODES: usize = 10_000_000;

/// Gives squares without rings the rings that their ways make. Squares whose outline is not
/// complete, or too long, stay without.
pub(super) fn read_outlines(
    source: &impl Elements,
    squares: &mut [Square],
) -> Result<(), OsmError> {
    let without_rings = squares.iter().filter(|square| square.rings.is_empty());
    let wanted: HashSet<i64> = without_rings
        .flat_map(|square| &square.outlines)
        .copied()
        .collect();
    if wanted.is_empty() {
        return Ok(());
    }
    let mut outlines = Outlines {
        wanted,
        lines: HashMap::new(),
    };
    source.visit(&mut outlines)?;
    let mut room = MOST_NODES;
    for square in squares.iter_mut().filter(|square| square.rings.is_empty()) {
        let Some(lines) = outlines.lines_of(square) else {
            continue;
        };
        let size: usize = lines.iter().map(|line| line.len()).sum();
        // Lines share their end nodes: lines of two nodes each have twice as many as their ring.
        if size > room.min(2 * MOST_CORNERS) {
            continue;
        }
        room -= size;
        // Roles of members are not needed: the largest ring is taken for the outline later.
        square.rings = joined(lines).unwrap_or_default();
    }
    Ok(())
}

/// The nodes of those ways that are wanted.
struct Outlines {
    wanted: HashSet<i64>,
    lines: HashMap<i64, Vec<i64>>,
}

impl Outlines {
    /// The lines of all ways of a square; `None` if one is missing.
    fn lines_of(&self, square: &Square) -> Option<Vec<&[i64]>> {
        square
            .outlines
            .iter()
            .map(|way| self.lines.get(way).map(Vec::as_slice))
            .collect()
    }
}

impl Visitor for Outlines {
    fn wants(&self, kind: ElementKind) -> bool {
        kind == ElementKind::Way
    }

    fn way(&mut self, way: WayRef<'_>) {
        // A closed line repeats its first node.
        let fits = (2..=MOST_CORNERS + 1).contains(&way.nodes.len());
        if fits && self.wanted.contains(&way.id) {
            self.lines.insert(way.id, way.nodes.to_vec());
        }
    }
}

/// Joins lines that share their ends into rings, the first node not repeated at the end; `None` if
/// an end is left over.
fn joined(mut lines: Vec<&[i64]>) -> Option<Vec<Vec<i64>>> {
    let mut rings = Vec::new();
    while let Some(line) = lines.pop() {
        let mut ring = line.to_vec();
        while let (Some(first), Some(last)) = (ring.first().copied(), ring.last().copied()) {
            if first == last {
                break;
            }
            // Ends after at most as many rounds as there are lines: each round takes one, and a
            // ring that finds none is given up.
            let touches = |line: &&[i64]| line.first() == Some(&last) || line.last() == Some(&last);
            let line = lines.swap_remove(lines.iter().position(touches)?);
            if line.first() == Some(&last) {
                ring.extend(&line[1..]);
            } else {
                ring.extend(line[..line.len() - 1].iter().rev());
            }
        }
        ring.pop();
        if ring.len() < 3 {
            return None;
        }
        rings.push(ring);
    }
    Some(rings)
}

#[cfg(test)]
mod tests {
    use super::joined;

    #[test]
    fn outlines_are_joined_end_to_end() {
        let ring = |lines: &[&[i64]]| joined(lines.to_vec());
        assert_eq!(ring(&[&[1, 2, 3, 1]]), Some(vec![vec![1, 2, 3]]));
        assert_eq!(
            ring(&[&[1, 2], &[4, 3, 2], &[4, 1]]),
            Some(vec![vec![4, 1, 2, 3]])
        );
        assert_eq!(
            ring(&[&[7, 8, 9, 7], &[1, 2, 3], &[1, 3]]).map(|rings| rings.len()),
            Some(2)
        );
        assert_eq!(ring(&[&[1, 2], &[2, 3]]), None);
        assert_eq!(ring(&[&[1, 2], &[2, 1]]), None);
    }
}
