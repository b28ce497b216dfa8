//! House numbers along a street: odd and even sides, or up one side and down the other; with gaps,
//! houses of two numbers and houses between two others here and there.

use rand_pcg::Pcg64Mcg;

use crate::draws::{chance, whole};

/// Share of the houses before which a number is left out.
pub const GAPS: f64 = 0.12;
/// Share of the numbers left out that the house before has too: `14-16`.
const RANGES: f64 = 0.3;
/// Share of the houses that were built between two others: `12a`.
const INSERTED: f64 = 0.07;

/// What a house that was built between two others has behind the number of the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inserted {
    /// A letter: `12a`.
    Letter,
    /// As in France: `12 bis`.
    Bis,
}

/// A house with its number.
struct Numbered<T> {
    house: T,
    number: String,
    /// The number after it, if no house has that.
    left_out: Option<u32>,
}

/// Numbers the houses of a street, given in their order on its left and on its right; returns each
/// with its number.
///
/// ```
/// use openbench_osm::draws::stream;
/// use openbench_osm::houses::{Inserted, number_street};
///
/// let draws = &mut stream(1, 1, 0);
/// let numbers = number_street(&["a", "b", "c"], &["x", "y"], Inserted::Letter, draws);
/// assert_eq!(numbers.len(), 5);
/// ```
pub fn number_street<T: Copy>(
    left: &[T],
    right: &[T],
    inserted: Inserted,
    draws: &mut Pcg64Mcg,
) -> Vec<(T, String)> {
    let (mut left, mut right) = (left.to_vec(), right.to_vec());
    if chance(draws, 0.5) {
        // The town's middle, from which numbers count, is at the other end.
        left.reverse();
        right.reverse();
        std::mem::swap(&mut left, &mut right);
    }
    let first = 2 * whole(draws, 0, 24);
    let numbered = if chance(draws, 0.2) {
        // Up one side and down the other.
        right.reverse();
        left.append(&mut right);
        count(&left, first / 2 + 1, 1, inserted, draws)
    } else {
        let mut numbered = count(&left, first + 1, 2, inserted, draws);
        numbered.extend(count(&right, first + 2, 2, inserted, draws));
        numbered
    };
    numbered
        .into_iter()
        .map(|house| house.with_range(draws))
        .collect()
}

/// Numbers houses in their order.
fn count<T: Copy>(
    order: &[T],
    first: u32,
    step: u32,
    inserted: Inserted,
    draws: &mut Pcg64Mcg,
) -> Vec<Numbered<T>> {
    let mut number = first;
    let mut is_inserted = true;
    let mut numbered: Vec<Numbered<T>> = Vec::with_capacity(order.len());
    for &house in order {
        let (gap, between) = (chance(draws, GAPS), chance(draws, INSERTED));
        if between && !is_inserted {
            // Built later, beside the house with the number before.
            numbered.push(Numbered {
                house,
                number: inserted.behind(number - step),
                left_out: None,
            });
            is_inserted = true;
            continue;
        }
        if gap {
            // A house that stands beside one with a letter keeps a single number.
            if let Some(before) = numbered.last_mut().filter(|_| !is_inserted) {
                before.left_out = Some(number);
            }
            number += step;
        }
        numbered.push(Numbered {
            house,
            number: number.to_string(),
            left_out: None,
        });
        number += step;
        is_inserted = false;
    }
    numbered
}

impl Inserted {
    fn behind(self, number: u32) -> String {
        match self {
            Self::Letter => format!("{number}a"),
            Self::Bis => format!("{number} bis"),
        }
    }
}

impl<T> Numbered<T> {
    /// The house with its number, and here and there with the next one that no other house has.
    fn with_range(self, draws: &mut Pcg64Mcg) -> (T, String) {
        let number = match self.left_out.filter(|_| chance(draws, RANGES)) {
            Some(next) => format!("{}-{next}", self.number),
            None => self.number,
        };
        (self.house, number)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::draws::stream;

    #[test]
    fn every_house_has_a_number_of_its_own() {
        let (left, right) = ([0, 1, 2, 3, 4, 5, 6], [7, 8, 9, 10]);
        let mut are_consecutive = 0;
        for seed in 0..200 {
            let draws = &mut stream(seed, 1, 0);
            let numbered = number_street(&left, &right, Inserted::Letter, draws);
            let houses: BTreeSet<i32> = numbered.iter().map(|(house, _)| *house).collect();
            let numbers: BTreeSet<&str> = numbered.iter().map(|(_, n)| n.as_str()).collect();
            assert_eq!((houses.len(), numbers.len()), (11, 11), "{numbered:?}");
            let is_odd = |text: &str| {
                text.trim_end_matches('a')
                    .ends_with(['1', '3', '5', '7', '9'])
            };
            let on_left = numbered.iter().filter(|(house, _)| *house < 7);
            let odd = on_left.filter(|(_, number)| is_odd(number)).count();
            are_consecutive += usize::from(odd != 0 && odd != 7);
        }
        assert!((20..60).contains(&are_consecutive), "{are_consecutive}");
    }

    #[test]
    fn some_houses_have_two_numbers_and_no_number_is_given_twice() {
        let (left, right): (Vec<i32>, Vec<i32>) = ((0..20).collect(), (20..40).collect());
        let (mut ranges, mut between) = (0, 0);
        for seed in 0..50 {
            let draws = &mut stream(seed, 1, 0);
            let mut taken = BTreeSet::new();
            for (_, number) in number_street(&left, &right, Inserted::Bis, draws) {
                ranges += usize::from(number.contains('-'));
                between += usize::from(number.ends_with(" bis"));
                for one in number.split('-') {
                    assert!(taken.insert(one.to_owned()), "{seed}: {number}");
                }
            }
        }
        assert!((30..110).contains(&ranges), "{ranges}");
        assert!((80..180).contains(&between), "{between}");
    }
}
