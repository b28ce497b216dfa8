//! What stands along an edge: something at each end, and what lies between. Ends are kept with their vertices, once for all edges that meet there.

/// A row of things along an edge, from vertex to vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chain<'a, T> {
    first: T,
    between: &'a [T],
    last: T,
}

impl<'a, T: Copy> Chain<'a, T> {
    /// What is at the first vertex, between them, and at the last one.
    pub fn new(first: T, between: &'a [T], last: T) -> Self {
        Self {
            first,
            between,
            last,
        }
    }

    /// How many there are: two at least.
    #[expect(clippy::len_without_is_empty, reason = "there are two at least")]
    pub fn len(&self) -> usize {
        self.between.len() + 2
    }

    /// Number `i`; whatever is behind the end is the last one.
    #[inline]
    pub fn at(&self, i: usize) -> T {
        match i.checked_sub(1) {
            None => self.first,
            Some(i) => self.between.get(i).copied().unwrap_or(self.last),
        }
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = T> + Clone + 'a {
        let (first, last) = (std::iter::once(self.first), std::iter::once(self.last));
        first.chain(self.between.iter().copied()).chain(last)
    }

    /// Those from number `begin` up to `end`, without it.
    pub fn part(
        &self,
        begin: usize,
        end: usize,
    ) -> impl DoubleEndedIterator<Item = T> + Clone + use<'_, 'a, T> {
        (begin..end.min(self.len())).map(|i| self.at(i))
    }

    /// Neighbours, in order.
    pub fn pairs(&self) -> impl Iterator<Item = [T; 2]> + 'a {
        self.iter().zip(self.iter().skip(1)).map(|(a, b)| [a, b])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_what_is_between_stand_in_a_row() {
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
