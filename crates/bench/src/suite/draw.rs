//! Random deliveries with instructions, for any list of doors.

use openbench_core::Address;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use crate::suite::Episode;

const ITEMS: [&str; 6] = ["box", "parcel", "package", "item", "letter", "crate"];
/// Templates; `{item}`, `{unit}` and `{building}` are replaced.
const SINGLE: [&str; 6] = [
    "Please deliver this {item} to {unit}, {building}.",
    "Take the {item} to {building}, {unit}.",
    "Bring this {item} to {unit} in {building}, please.",
    "Please deliver this {item} into {unit}, {building}.",
    "The {item} goes to {building}, {unit}.",
    "Could you drop the {item} off at {unit} of {building}?",
];

/// Draws episodes with deliveries to a list of doors.
///
/// ```
/// use openbench_bench::suite::draw::Draw;
/// use openbench_core::Address;
///
/// let doors = vec![Address::new("building1", "unit1"), Address::new("building2", "unit1")];
/// let episodes = Draw::new(doors, 7).singles(4);
/// // Every door is drawn once before any is drawn again.
/// assert_ne!(episodes[0].deliveries, episodes[1].deliveries);
/// assert!(episodes[0].instruction.contains("unit1"));
/// ```
#[derive(Debug, Clone)]
pub struct Draw {
    doors: Vec<Address>,
    random: Pcg32,
}

impl Draw {
    /// Draws from `doors` with random numbers from `seed`.
    pub fn new(doors: Vec<Address>, seed: u64) -> Self {
        Self {
            doors,
            random: Pcg32::seed_from_u64(seed),
        }
    }

    /// `count` episodes of one delivery each. Every door is drawn once before any is drawn again.
    pub fn singles(&mut self, count: usize) -> Vec<Episode> {
        let mut drawn = Vec::with_capacity(count);
        while drawn.len() < count && !self.doors.is_empty() {
            let left = count - drawn.len();
            drawn.extend(self.shuffled().into_iter().take(left));
        }
        drawn
            .into_iter()
            .map(|door| self.episode(vec![door]))
            .collect()
    }

    /// `count` episodes of `length` different doors each, or of all doors if there are fewer.
    /// Without doors there are no episodes.
    pub fn sequences(&mut self, count: usize, length: usize) -> Vec<Episode> {
        let draws: Vec<Vec<Address>> = (0..count)
            .map(|_| self.shuffled().into_iter().take(length).collect())
            .collect();
        draws
            .into_iter()
            .filter(|doors| !doors.is_empty())
            .map(|doors| self.episode(doors))
            .collect()
    }

    /// As many episodes as there are in others, to as many doors each, those to one door first.
    pub fn like(&mut self, others: &[Episode]) -> Vec<Episode> {
        let (sequences, singles): (Vec<&Episode>, Vec<&Episode>) = others
            .iter()
            .partition(|episode| episode.deliveries.len() > 1);
        let mut episodes = self.singles(singles.len());
        for sequence in sequences {
            episodes.extend(self.sequences(1, sequence.deliveries.len()));
        }
        episodes
    }

    // The built-in suites are drawn anew by every version: the order of random draws, here and in
    // `sentence`, must not change.
    fn shuffled(&mut self) -> Vec<Address> {
        let mut doors = self.doors.clone();
        // Fisher-Yates: every order has the same probability.
        for i in (1..doors.len()).rev() {
            doors.swap(i, self.random.random_range(0..=i));
        }
        doors
    }

    fn episode(&mut self, doors: Vec<Address>) -> Episode {
        let sentences: Vec<String> = doors.iter().map(|door| self.sentence(door)).collect();
        Episode {
            instruction: sentences.join(" "),
            deliveries: doors,
            before: Vec::new(),
        }
    }

    fn sentence(&mut self, door: &Address) -> String {
        let template = SINGLE[self.random.random_range(0..SINGLE.len())];
        let item = ITEMS[self.random.random_range(0..ITEMS.len())];
        let Some(unit) = &door.unit else {
            return format!("Please deliver this {item} to {}.", door.building);
        };
        template
            .replace("{item}", item)
            .replace("{unit}", &in_words(unit))
            .replace("{building}", &door.building)
    }
}

/// A unit as people write it: a letter apart from the word, which alone would be another word.
fn in_words(unit: &str) -> String {
    let letters = unit.strip_prefix("unit").unwrap_or_default();
    let is_letter = !letters.is_empty() && letters.chars().all(|c| c.is_ascii_alphabetic());
    if is_letter {
        format!("unit {}", letters.to_ascii_uppercase())
    } else {
        unit.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_with_letters_are_written_apart() {
        for (unit, words) in [
            ("unita", "unit A"),
            ("unit3", "unit3"),
            ("unit3a", "unit3a"),
            ("unit", "unit"),
            ("Atelier", "Atelier"),
        ] {
            assert_eq!(in_words(unit), words);
        }
    }

    fn doors(n: usize) -> Vec<Address> {
        (0..n)
            .map(|i| {
                Address::new(
                    format!("building{}", i / 2 + 1),
                    format!("unit{}", i % 2 + 1),
                )
            })
            .collect()
    }

    #[test]
    fn singles_use_every_door_once_before_any_twice() {
        let episodes = Draw::new(doors(5), 3).singles(10);
        for half in episodes.chunks(5) {
            let mut seen: Vec<&Address> = half.iter().map(|e| &e.deliveries[0]).collect();
            seen.sort();
            seen.dedup();
            assert_eq!(seen.len(), 5);
        }
    }

    #[test]
    fn instructions_contain_the_addresses_of_their_doors() {
        for episode in Draw::new(doors(6), 9).sequences(20, 4) {
            assert_eq!(episode.deliveries.len(), 4);
            for door in &episode.deliveries {
                assert!(
                    episode.instruction.contains(door.unit.as_ref().unwrap()),
                    "{}",
                    episode.instruction
                );
                assert!(
                    episode.instruction.contains(&door.building),
                    "{}",
                    episode.instruction
                );
            }
        }
    }

    #[test]
    fn a_draw_like_others_has_their_numbers_and_is_the_same_like_itself() {
        let mut draw = Draw::new(doors(5), 3);
        let mut others = draw.sequences(2, 4);
        others.extend(draw.singles(3));
        let like = |others: &[Episode]| Draw::new(doors(3), 7).like(others);
        let first = like(&others);
        let lengths: Vec<usize> = first.iter().map(|e| e.deliveries.len()).collect();
        assert_eq!(lengths, [1, 1, 1, 3, 3]);
        assert_eq!(like(&first), first);
    }

    #[test]
    fn draws_depend_on_the_seed_only_and_without_doors_are_empty() {
        let draw = |seed| Draw::new(doors(6), seed).singles(6);
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
        assert!(Draw::new(vec![], 1).singles(3).is_empty());
        assert!(Draw::new(vec![], 1).sequences(3, 2).is_empty());
    }
}
