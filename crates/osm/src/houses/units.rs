//! Units: numbers, letters, or numbers of floors.

use rand_pcg::Pcg64Mcg;

use crate::draws::{between, chance, whole};

/// Letters of the alphabet: no house with more doors has them.
const LETTERS: usize = 26;

/// The units of so many doors, all different.
pub(super) fn units(count: usize, draws: &mut Pcg64Mcg) -> Vec<String> {
    let share = between(draws, 0.0, 1.0);
    // One number may be left out, as where two flats were joined.
    let gap = (chance(draws, 0.1) && count > 2).then(|| whole(draws, 2, count as u32));
    let number = |i: usize| {
        let plain = i as u32 + 1;
        plain + u32::from(gap.is_some_and(|gap| plain >= gap))
    };
    (0..count)
        .map(|i| {
            let letter = char::from(b'A' + (i % LETTERS) as u8);
            match share {
                share if share < 0.12 && (2..=LETTERS).contains(&count) => letter.to_string(),
                share if share < 0.18 && count > 2 => (100 + number(i)).to_string(),
                _ => number(i).to_string(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::stream;

    #[test]
    fn the_units_of_a_building_are_different() {
        for (seed, count) in (0..200).flat_map(|seed| [(seed, 2), (seed, 20), (seed, 40)]) {
            let mut names = units(count, &mut stream(seed, 1, 0));
            names.sort();
            names.dedup();
            assert_eq!(names.len(), count);
        }
    }
}
