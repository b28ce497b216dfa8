//! Worlds with door plates as in streets: what changes, and what does not.

use openbench_scene::World;
use openbench_scene::generate::{Alterations, PlateOptions, builtin, builtin_with};
use openbench_scene::plates::{Facts, StreetPlates};

fn world(name: &str, shares: StreetPlates, seed: u64) -> World {
    let plates = PlateOptions { shares, seed };
    let by = Alterations {
        plates,
        ..Alterations::default()
    };
    builtin_with(name, 1, by).unwrap().unwrap()
}

#[test]
fn plates_of_the_paper_are_those_of_before() {
    let usual = builtin("small", 1).unwrap().unwrap();
    // A seed alone changes nothing.
    let same = world("small", StreetPlates::PAPER, 7);
    assert_eq!(usual.scene, same.scene);
    assert!(same.plates.is_none());
}

#[test]
fn doors_stay_where_they_are_and_get_plates_that_are_true() {
    let usual = builtin("large", 1).unwrap().unwrap();
    let real = world("large", StreetPlates::REAL, 10_000);
    assert_eq!(usual.scene.doors.len(), real.scene.doors.len());
    assert_eq!(usual.map.to_xml(), real.map.to_xml());
    for (before, door) in usual.scene.doors.iter().zip(&real.scene.doors) {
        assert_eq!(
            (&before.address, before.doorway),
            (&door.address, door.doorway)
        );
        let facts = Facts::of(&door.address, false);
        let said: Vec<char> = door.text.chars().filter(char::is_ascii_digit).collect();
        let digits = |fact: &Option<String>| fact.clone().unwrap_or_default();
        let all = digits(&facts.number) + &digits(&facts.unit);
        // Only digits of the address, in its order.
        let mut rest = all.chars();
        let is_true = said.iter().all(|digit| rest.any(|c| c == *digit));
        assert!(is_true, "{} at {}", door.text, door.address);
    }
}

#[test]
fn what_was_drawn_is_counted() {
    let real = world("large", StreetPlates::REAL, 10_000);
    let drawn = real.plates.unwrap();
    let texts = real.scene.doors.iter().filter(|door| door.text.is_empty());
    assert_eq!(drawn.doors, real.scene.doors.len());
    assert_eq!(texts.count(), drawn.missing);
    let kinds = drawn.number_only + drawn.unit_only + drawn.both;
    assert_eq!(kinds, drawn.doors - drawn.missing);
    assert_eq!(drawn.makes.values().sum::<usize>(), kinds);
    assert!(drawn.signs > 20, "{drawn:?}");
    let all_missing = StreetPlates {
        missing: 1.0,
        ..StreetPlates::REAL
    };
    let none = world("small", all_missing, 1);
    assert!(none.scene.doors.iter().all(|door| door.text.is_empty()));
}

#[test]
fn seeds_draw_other_plates_and_a_seed_the_same() {
    let of = |seed| world("small", StreetPlates::REAL, seed).scene;
    assert_eq!(of(3), of(3));
    assert_ne!(of(3), of(4));
}
