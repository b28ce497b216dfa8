//! Wrong numbers of buildings: near the right one, and of no other building; with a letter where
//! all numbers nearby are taken.

use std::collections::BTreeSet;

use rand_pcg::Pcg64Mcg;

use crate::draws::chance;
use crate::names::{fold, street_or_place};
use crate::tags::Tags;

/// A wrong number is at most so far from the right one.
const FARTHEST: u64 = 40;
/// Letters behind the right number that are tried where all others are taken.
const LETTERS: [char; 6] = ['a', 'b', 'c', 'd', 'e', 'f'];
/// Keys that may hold a building's number, in the order in which they are looked at.
const KEYS: [&str; 3] = ["name", "addr:housenumber", "ref"];

/// The names with numbers of a building, folded: what [`renumber`] must not give to another one.
pub(super) fn numbered_names(tags: &Tags) -> impl Iterator<Item = String> + '_ {
    KEYS.into_iter().filter_map(|key| name_by(tags, key))
}

/// The tags of a building with another number, which none of the `taken` names has; `None` if it
/// has no number.
pub(super) fn renumber(
    tags: &Tags,
    taken: &BTreeSet<String>,
    draws: &mut Pcg64Mcg,
) -> Option<Tags> {
    let ascending = chance(draws, 0.5);
    let (key, parts) = KEYS.into_iter().find_map(|key| {
        let parts = Numbered::of(tags.get(key)?)?;
        Some((key, parts))
    })?;
    let numbers = (1..=FARTHEST).flat_map(|distance| parts.neighbours(distance, ascending));
    let plain = numbers.map(|number| number.to_string());
    let lettered = LETTERS.map(|letter| format!("{}{letter}", parts.number));
    let mut changed = plain.chain(lettered).map(|number| {
        // Other names would tell the right one.
        let mut changed = nameless(tags);
        let place = tags.iter().filter(|(other, _)| is_place(other));
        for (other, value) in place {
            changed.insert(other, value);
        }
        changed.insert(key, parts.with(&number));
        changed
    });
    changed.find(|tags| name_by(tags, key).is_some_and(|name| !taken.contains(&name)))
}

/// Whether a key tells where a building is, and not which one it is.
fn is_place(key: &str) -> bool {
    let own = ["addr:housenumber", "addr:housename"];
    key.starts_with("addr:") && !own.contains(&key)
}

/// The name that a key gives to a building, folded: a house number counts in its street.
fn name_by(tags: &Tags, key: &str) -> Option<String> {
    let value = tags.get(key)?;
    let street = street_or_place(tags).filter(|_| key == "addr:housenumber");
    Some(match street {
        Some(street) => fold(&format!("{street} {value}")),
        None => fold(value),
    })
}

/// The tags of a building without its names and numbers.
pub(super) fn nameless(tags: &Tags) -> Tags {
    let mut left = tags.clone();
    left.retain(|key, _| {
        let is_name = key == "ref" || key == "name" || key.ends_with("_name");
        !is_name && !key.starts_with("name:") && !key.starts_with("addr:")
    });
    left
}

/// A text with a number in it.
#[derive(Debug, PartialEq, Eq)]
struct Numbered<'a> {
    before: &'a str,
    number: u64,
    after: &'a str,
}

impl<'a> Numbered<'a> {
    /// The last number of a text; `None` if it has none, or a huge one.
    fn of(text: &'a str) -> Option<Self> {
        let end = text.rfind(|c: char| c.is_ascii_digit())? + 1;
        let start = text[..end]
            .rfind(|c: char| !c.is_ascii_digit())
            .map_or(0, |at| {
                at + text[at..].chars().next().map_or(1, char::len_utf8)
            });
        Some(Self {
            before: &text[..start],
            number: text[start..end].parse().ok()?,
            after: &text[end..],
        })
    }

    /// The numbers at a distance from this one, 1 and above.
    fn neighbours(&self, distance: u64, ascending: bool) -> impl Iterator<Item = u64> {
        let above = self.number.checked_add(distance);
        let below = self.number.checked_sub(distance).filter(|n| *n > 0);
        let order = if ascending {
            [above, below]
        } else {
            [below, above]
        };
        order.into_iter().flatten()
    }

    fn with(&self, number: &str) -> String {
        format!("{}{number}{}", self.before, self.after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::stream;

    #[test]
    fn the_last_number_of_a_text_is_its_number() {
        let parts = |before, number, after| Numbered {
            before,
            number,
            after,
        };
        assert_eq!(Numbered::of("building3"), Some(parts("building", 3, "")));
        assert_eq!(Numbered::of("12a"), Some(parts("", 12, "a")));
        assert_eq!(Numbered::of("14-18"), Some(parts("14-", 18, "")));
        assert_eq!(Numbered::of("3号楼"), Some(parts("", 3, "号楼")));
        assert_eq!(Numbered::of("号楼3"), Some(parts("号楼", 3, "")));
        assert_eq!(Numbered::of("Town hall"), None);
        assert_eq!(Numbered::of("99999999999999999999"), None);
    }

    #[test]
    fn a_wrong_number_is_that_of_no_other_building() {
        let taken: BTreeSet<String> = (1..=9).map(|n| format!("building{n}")).collect();
        let renumbered = |tags: &Tags, taken| renumber(tags, taken, &mut stream(1, 1, 1));
        let tags = Tags::from([("name", "building3"), ("building", "yes")]);
        let wrong = renumbered(&tags, &taken).unwrap();
        assert_eq!(wrong.get("name"), Some("building10"));
        let nameless = Tags::from([("building", "yes")]);
        assert_eq!(renumbered(&nameless, &taken), None);
        // The street belongs to the name: 3 is taken in another street only.
        let mut house = Tags::from([("addr:street", "Hill"), ("addr:housenumber", "2")]);
        let taken = BTreeSet::from(["hill2".to_owned(), "lane3".to_owned(), "lane1".to_owned()]);
        let wrong = renumbered(&house, &taken).unwrap();
        assert!(["1", "3"].contains(&wrong.get("addr:housenumber").unwrap()));
        // What else would tell the right number is gone, the street is not.
        house.insert("name", "Town hall");
        house.insert("alt_name", "Hill 2");
        let wrong = renumbered(&house, &taken).unwrap();
        assert_eq!((wrong.get("name"), wrong.get("alt_name")), (None, None));
        assert_eq!(wrong.get("addr:street"), Some("Hill"));
    }

    #[test]
    fn a_nameless_building_keeps_what_it_is() {
        let tags = Tags::from([
            ("building", "yes"),
            ("name", "building3"),
            ("alt_name", "Old mill"),
            ("addr:street", "Hill"),
            ("height", "7"),
        ]);
        let left = Tags::from([("building", "yes"), ("height", "7")]);
        assert_eq!(nameless(&tags), left);
    }
}
