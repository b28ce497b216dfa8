//! Items along an edge: one at each end, and those in between.
//!
//! The items at the ends are stored with the vertices, once for all edges that meet there.

/// A row of items along an edge, from vertex to vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Chain<'a, T> {
    first: T,
    between: &'a [T],
    last: T,
}

impl<'a, T: Copy> Chain<'a, T> {
    /// The items at the first vertex, in between, and at the last vertex.
    pub(crate) fn new(first: T, between: &'a [T], last: T) -> Self {
        Self {
            first,
            between,
            last,
        }
    }

    /// The number of items: two or more.
    pub(crate) fn len(&self) -> usize {
        self.between.len() + 2
    }

    /// Item `i`; the last one, if there are fewer.
    #[inline]
    pub(crate) fn at(&self, i: usize) -> T {
        match i.checked_sub(1) {
            None => self.first,
            // Index `i - 1` is past the end of `between` exactly for the last item.
            Some(i) => self.between.get(i).copied().unwrap_or(self.last),
        }
    }

    /// All items, in order.
    pub(crate) fn iter(&self) -> impl DoubleEndedIterator<Item = T> + Clone + 'a {
        let (first, last) = (std::iter::once(self.first), std::iter::once(self.last));
        first.chain(self.between.iter().copied()).chain(last)
    }

    /// Items `begin` to `end`, without the latter.
    pub(crate) fn part(
        &self,
        begin: usize,
        end: usize,
    ) -> impl DoubleEndedIterator<Item = T> + Clone + use<'_, 'a, T> {
        (begin..end.min(self.len())).map(|i| self.at(i))
    }

    /// Neighbouring items, in order.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = [T; 2]> + 'a {
        self.iter().zip(self.iter().skip(1)).map(|(a, b)| [a, b])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_those_of_the_ends_and_in_between() {
        for between in [&[][..], &[2], &[2, 3, 4]] {
            let chain = Chain::new(1, between, 9);
            let all = [&[1], between, &[9]].concat();
            assert_eq!(chain.iter().collect::<Vec<_>>(), all);
            assert_eq!(
                (0..chain.len()).map(|i| chain.at(i)).collect::<Vec<_>>(),
                all
            );
            assert_eq!(chain.part(1, 99).collect::<Vec<_>>(), all[1..]);
            assert_eq!(chain.pairs().count(), all.len() - 1);
            assert_eq!(chain.iter().next_back(), Some(9));
        }
    }
}
