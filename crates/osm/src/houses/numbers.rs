//! House numbers along a street: odd and even sides, or up one side and down the other; with gaps
//! and letters here and there.

use rand_pcg::Pcg64Mcg;

use crate::draws::{chance, whole};

/// Share of the houses before which a number is left out.
pub const GAPS: f64 = 0.12;
/// Share of the houses that were built between two others: `12a`.
const LETTERS: f64 = 0.07;

/// Numbers the houses of a street, given in their order on its left and on its right; returns each
/// with its number.
///
/// ```
/// use openbench_osm::draws::stream;
/// use openbench_osm::houses::number_street;
///
/// let numbers = number_street(&["a", "b", "c"], &["x", "y"], &mut stream(1, 1, 0));
/// assert_eq!(numbers.len(), 5);
/// ```
pub fn number_street<T: Copy>(left: &[T], right: &[T], draws: &mut Pcg64Mcg) -> Vec<(T, String)> {
    let (mut left, mut right) = (left.to_vec(), right.to_vec());
    if chance(draws, 0.5) {
        // The town's middle, from which numbers count, is at the other end.
        left.reverse();
        right.reverse();
        std::mem::swap(&mut left, &mut right);
    }
    let first = 2 * whole(draws, 0, 24);
    if chance(draws, 0.2) {
        // Up one side and down the other.
        right.reverse();
        left.append(&mut right);
        return count(&left, first / 2 + 1, 1, draws);
    }
    let mut numbered = count(&left, first + 1, 2, draws);
    numbered.extend(count(&right, first + 2, 2, draws));
    numbered
}

/// Numbers houses in their order.
fn count<T: Copy>(order: &[T], first: u32, step: u32, draws: &mut Pcg64Mcg) -> Vec<(T, String)> {
    let mut number = first;
    let mut lettered = true;
    let mut numbered = Vec::with_capacity(order.len());
    for house in order {
        let (gap, letter) = (chance(draws, GAPS), chance(draws, LETTERS));
        if letter && !lettered {
            // Built later, beside the house with the number before.
            numbered.push((*house, format!("{}a", number - step)));
            lettered = true;
            continue;
        }
        number += if gap { step } else { 0 };
        numbered.push((*house, number.to_string()));
        number += step;
        lettered = false;
    }
    numbered
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
            let numbered = number_street(&left, &right, &mut stream(seed, 1, 0));
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
}
