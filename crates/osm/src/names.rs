//! Which tags name a building or a unit, and when two names are equal.
//!
//! Names are compared folded: case, spaces, hyphens, full-width forms and leading zeros do not
//! matter. Words are not translated: a language planner must know that `3号楼` is building 3.

use crate::tags::Tags;

/// Keys that hold a building's name in full, in addition to `name:<language>`.
const NAME_KEYS: [&str; 7] = [
    "name",
    "addr:housename",
    "alt_name",
    "short_name",
    "official_name",
    "loc_name",
    "int_name",
];

/// The most house numbers that one element may list. An endless list would be multiplied by the
/// street's name.
const MOST_NUMBERS: usize = 100;

/// The usual name of a building: its `name`, else `addr:housename`, else street (or place) and
/// `addr:housenumber`, else the bare house number, else `ref`.
pub fn building_name(tags: &Tags) -> Option<String> {
    let number = tags.get("addr:housenumber");
    let plain = tags
        .get("name")
        .or_else(|| tags.get("addr:housename"))
        .map(str::to_owned);
    let street_and_number = || {
        street_or_place(tags)
            .zip(number)
            .map(|(street, number)| format!("{street} {number}"))
    };
    plain
        .or_else(street_and_number)
        .or_else(|| number.or_else(|| tags.get("ref")).map(str::to_owned))
}

/// All full names of a building, folded: names in all languages, the house name, and street and
/// number in either order.
pub(crate) fn full_names(tags: &Tags) -> Vec<String> {
    let mut names: Vec<String> = tags
        .iter()
        .filter(|(key, _)| is_name_key(key))
        .flat_map(|(_, v)| list(v))
        .collect();
    if let (Some(street), Some(numbers)) = (street_or_place(tags), tags.get("addr:housenumber")) {
        for number in numbers
            .split([';', ','])
            .map(str::trim)
            .filter(|n| !n.is_empty())
            .take(MOST_NUMBERS)
        {
            names.push(fold(&format!("{street} {number}")));
            names.push(fold(&format!("{number} {street}")));
        }
    }
    names
}

/// The bare numbers of a building, folded. They count where no full name matches.
pub(crate) fn numbers(tags: &Tags) -> Vec<String> {
    let values = [tags.get("ref"), tags.get("addr:housenumber")];
    values
        .into_iter()
        .flatten()
        .flat_map(|v| v.split([';', ',']))
        .map(fold)
        .filter(|n| !n.is_empty())
        .collect()
}

/// The names of the unit behind a door: `addr:unit`, `ref`, `name`, in this order. Lists are split,
/// and each name is given once.
pub(crate) fn unit_names(tags: &Tags) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for value in ["addr:unit", "ref", "name"]
        .into_iter()
        .filter_map(|key| tags.get(key))
    {
        for name in value
            .split(';')
            .map(str::trim)
            .filter(|name| !name.is_empty())
        {
            if !names
                .iter()
                .any(|known| fold_unit(known) == fold_unit(name))
            {
                names.push(name.to_owned());
            }
        }
    }
    names
}

/// Folds `name` for comparison: lower case, without spaces, hyphens and leading zeros. Numbers that
/// were separate stay separate.
///
/// ```
/// use openbench_osm::names::fold;
///
/// assert_eq!(fold("Building 03"), "building3");
/// assert_eq!(fold("building-3"), "building3");
/// assert_eq!(fold("Block 1-2"), "block1-2");
/// ```
pub fn fold(name: &str) -> String {
    let mut folded = String::with_capacity(name.len());
    let mut apart = false;
    for c in name.chars().map(half_width).flat_map(char::to_lowercase) {
        if c.is_whitespace() || is_separator(c) {
            apart = true;
            continue;
        }
        // Without the hyphen `1-2` would become `12`, another building.
        if apart && c.is_ascii_digit() && folded.ends_with(|last: char| last.is_ascii_digit()) {
            folded.push('-');
        }
        // A zero is dropped only when a digit follows it, so that `0` itself remains.
        if c.is_ascii_digit() && after_leading_zero(&folded) {
            folded.pop();
        }
        folded.push(c);
        apart = false;
    }
    folded
}

/// [`fold`] without the word for a unit: `Unit 1`, `unit1` and `1` are the same unit.
pub fn fold_unit(name: &str) -> String {
    without_word(fold(name), &["unit", "entrance", "door"])
}

/// [`fold`] without the word for a building: `Building 3` and `3` are the same number.
pub(crate) fn fold_number(name: &str) -> String {
    without_word(fold(name), &["building", "block", "house", "no"])
}

fn without_word(folded: String, words: &[&str]) -> String {
    let rest = words
        .iter()
        .find_map(|word| folded.strip_prefix(word))
        // A unit that is called `Door` keeps its name.
        .filter(|rest| !rest.is_empty());
    rest.map_or_else(|| folded.clone(), str::to_owned)
}

/// Whether the text ends in a zero that begins a number.
fn after_leading_zero(text: &str) -> bool {
    text.strip_suffix('0')
        .is_some_and(|before| !before.ends_with(|c: char| c.is_ascii_digit()))
}

fn is_separator(c: char) -> bool {
    matches!(
        c,
        '-' | '_' | '.' | ',' | '#' | '\'' | '’' | '\u{2010}'..='\u{2015}'
    )
}

fn half_width(c: char) -> char {
    match c {
        // The block of full-width forms repeats ASCII from `!` to `~`, at a fixed distance.
        '\u{FF01}'..='\u{FF5E}' => char::from_u32(u32::from(c) - 0xFEE0).unwrap_or(c),
        '\u{3000}' => ' ',
        _ => c,
    }
}

fn is_name_key(key: &str) -> bool {
    NAME_KEYS.contains(&key)
        || key
            .strip_prefix("name:")
            .or_else(|| key.strip_prefix("alt_name:"))
            .is_some_and(is_language)
}

/// `de`, `yue`, `zh-Hant`, `ja_rm`, but not `etymology`, `left` or `signed`.
fn is_language(suffix: &str) -> bool {
    // Codes of ISO 639 have two or three letters. Scripts and regions follow behind a hyphen.
    let code = suffix.split(['-', '_']).next().unwrap_or_default();
    matches!(code.len(), 2 | 3) && code.bytes().all(|b| b.is_ascii_lowercase())
}

fn list(value: &str) -> impl Iterator<Item = String> {
    value.split(';').map(fold).filter(|name| !name.is_empty())
}

/// The street of an address, or the place that numbers houses without a street (`addr:place`).
pub fn street_or_place(tags: &Tags) -> Option<&str> {
    tags.get("addr:street").or_else(|| tags.get("addr:place"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn spelling_does_not_matter_but_numbers_do() {
        for name in [
            "Building 3",
            "building3",
            "BUILDING-03",
            "Ｂuilding　３",
            "building_003",
        ] {
            assert_eq!(fold(name), "building3", "{name}");
        }
        for (name, folded) in [
            ("Block 1-2", "block1-2"),
            ("12", "12"),
            ("10", "10"),
            ("0", "0"),
            ("00", "0"),
            ("100 A", "100a"),
        ] {
            assert_eq!(fold(name), folded);
        }
        assert_eq!(fold("Rua 5 – 07"), "rua5-7");
    }

    #[test]
    fn units_are_the_same_with_and_without_the_word() {
        for name in ["unit1", "1", "Unit 01", "UNIT-1", "door 1"] {
            assert_eq!(fold_unit(name), "1", "{name}");
        }
        assert_eq!(fold_unit("Unit"), "unit");
        assert_ne!(fold_unit("unit 11"), fold_unit("unit 1"));
    }

    #[test]
    fn a_building_has_its_most_specific_name() {
        let name = |tags: &[(&str, &str)]| building_name(&tags.iter().copied().collect());
        let address = [("addr:street", "Rua Alta"), ("addr:housenumber", "5")];
        assert_eq!(name(&address).as_deref(), Some("Rua Alta 5"));
        assert_eq!(name(&address[1..]).as_deref(), Some("5"));
        assert_eq!(
            name(&[address[0], address[1], ("addr:housename", "Villa")]).as_deref(),
            Some("Villa")
        );
        assert_eq!(name(&[("ref", "B7")]).as_deref(), Some("B7"));
        assert_eq!(name(&[("building", "yes")]), None);
    }

    #[test]
    fn names_in_other_languages_count_but_etymologies_do_not() {
        let tags = Tags::from([
            ("name", "도서관"),
            ("name:en", "Library"),
            ("name:etymology", "Somebody"),
            ("alt_name", "Old; New"),
        ]);
        assert_eq!(full_names(&tags), ["old", "new", "도서관", "library"]);
    }

    #[test]
    fn each_unit_of_a_door_is_named_once() {
        let tags = Tags::from([
            ("ref", "1"),
            ("addr:unit", "Unit 1;Unit 2"),
            ("name", "Post"),
        ]);
        assert_eq!(unit_names(&tags), ["Unit 1", "Unit 2", "Post"]);
    }

    proptest! {
        #[test]
        fn folding_twice_changes_nothing(name in "[a-zA-Z0-9 _.Ａ-Ｚ０-９é号-]{0,12}") {
            let once = fold(&name);
            prop_assert_eq!(fold(&once), once);
        }
    }
}
