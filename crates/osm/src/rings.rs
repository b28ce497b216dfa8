//! Closed rings from the ways of a multipolygon, each of which may be only a piece of a ring.
//!
//! Pieces are joined where they share an end node. Roles are trusted: members with role `inner` are
//! holes, all others are outlines.

use std::collections::BTreeMap;

/// Rings made of pieces.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Assembled {
    /// Closed rings as lists of node numbers, the first node not repeated.
    pub(crate) rings: Vec<Vec<i64>>,
    /// How many chains could not be closed.
    pub(crate) open: usize,
}

/// Joins pieces, which are lists of node numbers, into closed rings.
pub(crate) fn assemble(pieces: &[&[i64]]) -> Assembled {
    let mut loose = Loose::new(pieces);
    let (mut rings, mut open) = (Vec::new(), 0);
    for start in 0..pieces.len() {
        let Some(mut chain) = loose.take(start) else {
            continue;
        };
        // Each piece is taken once, so this takes no more rounds than there are pieces.
        while chain.first() != chain.last() {
            let Some(next) = chain.last().and_then(|end| loose.take_at(*end)) else {
                break;
            };
            chain.extend_from_slice(&next[1..]);
        }
        // A triangle has four nodes with the first one repeated.
        if chain.len() > 3 && chain.first() == chain.last() {
            chain.pop();
            rings.push(chain);
        } else {
            open += 1;
        }
    }
    Assembled { rings, open }
}

/// Pieces that are in no ring yet, indexed by their ends.
struct Loose<'a> {
    pieces: Vec<Option<&'a [i64]>>,
    by_end: BTreeMap<i64, Vec<usize>>,
}

impl<'a> Loose<'a> {
    fn new(pieces: &[&'a [i64]]) -> Self {
        let mut by_end: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        // In reverse, since the last of each list is taken first.
        for (i, piece) in pieces.iter().enumerate().rev() {
            for end in [piece.first(), piece.last()].into_iter().flatten() {
                by_end.entry(*end).or_default().push(i);
            }
        }
        Self {
            pieces: pieces
                .iter()
                .map(|piece| (!piece.is_empty()).then_some(*piece))
                .collect(),
            by_end,
        }
    }

    fn take(&mut self, index: usize) -> Option<Vec<i64>> {
        self.pieces[index].take().map(<[i64]>::to_vec)
    }

    /// The first loose piece with an end at `node`, reversed if necessary so that it begins there.
    fn take_at(&mut self, node: i64) -> Option<Vec<i64>> {
        let candidates = self.by_end.get_mut(&node)?;
        // Pieces that were taken by their other end are still listed, and are passed over.
        while let Some(index) = candidates.pop() {
            if let Some(piece) = self.pieces[index].take() {
                let mut piece = piece.to_vec();
                if piece[0] != node {
                    piece.reverse();
                }
                return Some(piece);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_of_any_direction_are_joined() {
        let Assembled { rings, open } = assemble(&[&[1, 2, 3], &[5, 4, 3], &[5, 1], &[7, 8, 9, 7]]);
        assert_eq!(rings, [vec![1, 2, 3, 4, 5], vec![7, 8, 9]]);
        assert_eq!(open, 0);
    }

    #[test]
    fn chains_that_do_not_close_are_counted() {
        let Assembled { rings, open } = assemble(&[&[1, 2, 3], &[3, 4], &[], &[6, 7, 6], &[9]]);
        assert!(rings.is_empty());
        assert_eq!(open, 3);
    }
}
