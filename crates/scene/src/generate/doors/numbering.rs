//! House numbers of buildings that the map gives none: a letter behind a mapped number next to
//! them, else counted along the street.

use std::collections::BTreeSet;

use openbench_osm::houses::{Inserted, number_street};
use rand_pcg::Pcg64Mcg;

/// A mapped number this near along the street is the neighbour's, metres.
const NEIGHBOUR_M: f64 = 25.0;
/// Letters behind a number that are tried.
const LETTERS: [char; 6] = ['a', 'b', 'c', 'd', 'e', 'f'];

/// Numbers after that of a building that are tried.
const MOST_FOLLOWING: u32 = 500;

/// A building beside a street.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beside {
    /// Index of the building.
    pub building: usize,
    /// Metres along the street.
    pub along: f64,
    /// Whether it is on the left.
    pub is_left: bool,
}

/// The buildings beside one street.
#[derive(Debug, Clone, Default)]
pub(super) struct StreetSides {
    /// Those that shall get a number.
    pub without: Vec<Beside>,
    /// Those with a number in the map.
    pub with: Vec<(Beside, String)>,
}

/// A number that was drawn for a building.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DrawnNumber {
    pub building: usize,
    pub number: String,
}

impl StreetSides {
    /// Numbers the buildings that have none; `is_taken` says whether any building has a number.
    pub fn number(
        mut self,
        is_taken: impl Fn(&str) -> bool,
        draws: &mut Pcg64Mcg,
    ) -> Vec<DrawnNumber> {
        // Ties keep the order of the map.
        self.without.sort_by(|a, b| a.along.total_cmp(&b.along));
        let mut given = Given {
            is_taken,
            numbers: BTreeSet::new(),
            numbered: Vec::new(),
        };
        let mut left_over = Vec::new();
        for house in &self.without {
            let neighbour = self.neighbour(*house).and_then(digits);
            let lettered = neighbour.into_iter().flat_map(with_letters);
            if !given.first_free(house.building, lettered) {
                left_over.push(*house);
            }
        }
        let side = |is_left: bool| -> Vec<usize> {
            let there = left_over.iter().filter(|house| house.is_left == is_left);
            there.map(|house| house.building).collect()
        };
        let (left, right) = (side(true), side(false));
        for (building, number) in number_street(&left, &right, Inserted::Letter, draws) {
            let number = given.with_free_range(number);
            let lettered = digits(&number).into_iter().flat_map(with_letters);
            let following = following(&number);
            let own = std::iter::once(number);
            given.first_free(building, own.chain(lettered).chain(following));
        }
        given.numbered
    }

    /// The mapped number nearest to a building on its side of the street.
    fn neighbour(&self, house: Beside) -> Option<&str> {
        let off = |other: &Beside| (other.along - house.along).abs();
        let beside = self
            .with
            .iter()
            .filter(|(other, _)| other.is_left == house.is_left && off(other) < NEIGHBOUR_M);
        let nearest = beside.min_by(|(a, _), (b, _)| off(a).total_cmp(&off(b)));
        nearest.map(|(_, number)| number.as_str())
    }
}

/// The numbers that were given so far.
struct Given<F> {
    is_taken: F,
    numbers: BTreeSet<String>,
    numbered: Vec<DrawnNumber>,
}

impl<F: Fn(&str) -> bool> Given<F> {
    /// Gives the first of some numbers that is free to a building; false if none is.
    fn first_free(&mut self, building: usize, mut numbers: impl Iterator<Item = String>) -> bool {
        let is_free = |number: &String| !(self.is_taken)(number) && !self.numbers.contains(number);
        let Some(number) = numbers.find(is_free) else {
            return false;
        };
        self.numbers.insert(number.clone());
        self.numbered.push(DrawnNumber { building, number });
        true
    }

    /// The number itself, or its first one where another building has its last one.
    fn with_free_range(&self, number: String) -> String {
        match number.split_once('-') {
            Some((first, last)) if (self.is_taken)(last) || self.numbers.contains(last) => {
                first.to_owned()
            }
            _ => number,
        }
    }
}

/// The digits with which a number begins.
fn digits(number: &str) -> Option<String> {
    let digits: String = number.chars().take_while(char::is_ascii_digit).collect();
    (!digits.is_empty()).then_some(digits)
}

fn with_letters(number: String) -> impl Iterator<Item = String> {
    LETTERS
        .into_iter()
        .map(move |letter| format!("{number}{letter}"))
}

/// The next numbers on the same side of a street with odd and even sides.
fn following(number: &str) -> impl Iterator<Item = String> + use<> {
    let first = digits(number).and_then(|digits| digits.parse::<u32>().ok());
    let after = move |steps: u32| Some((first?.checked_add(2 * steps)?).to_string());
    (1..MOST_FOLLOWING).map_while(after)
}

#[cfg(test)]
mod tests {
    use openbench_osm::draws::stream;

    use super::*;

    fn beside(building: usize, along: f64) -> Beside {
        Beside {
            building,
            along,
            is_left: true,
        }
    }

    #[test]
    fn a_house_next_to_a_mapped_number_gets_a_letter_and_others_are_counted() {
        let street = StreetSides {
            without: vec![beside(3, 500.0), beside(1, 22.0), beside(2, 18.0)],
            with: vec![(beside(0, 20.0), "12".to_owned())],
        };
        let is_taken = |number: &str| ["12", "12a"].contains(&number);
        let numbered = street.number(is_taken, &mut stream(1, 1, 1));
        let of = |building| {
            let found = numbered.iter().find(|n| n.building == building);
            found.unwrap().number.as_str()
        };
        assert_eq!((of(2), of(1)), ("12b", "12c"));
        assert!(of(3).chars().all(|c| c.is_ascii_digit()), "{numbered:?}");
    }

    #[test]
    fn no_number_is_given_twice() {
        for seed in 0..50 {
            let street = StreetSides {
                without: (0..40).map(|i| beside(i, i as f64)).collect(),
                with: vec![(beside(99, 5.0), "7".to_owned())],
            };
            let numbered = street.number(|number| number == "7", &mut stream(seed, 1, 1));
            let different: BTreeSet<&str> = numbered.iter().map(|n| n.number.as_str()).collect();
            assert_eq!(different.len(), 40);
            assert!(!different.contains("7"));
        }
    }
}
