//! `run KIND --seed N`: another neighbourhood for each seed.

mod common;

use common::{Place, Ran};

/// Drives by the truth, which is quick.
fn run(place: &Place, words: &str) -> Ran {
    place.openbench(&format!(
        "run {words} --agent omniscient --record none --json"
    ))
}

#[test]
fn a_seed_draws_a_neighbourhood_and_a_noise_seed_does_not() {
    let place = Place::new();
    let words = "small --seed 7 --noise-seed 3 --out r";
    let drawn = run(&place, words).succeeded().json();
    assert_eq!(drawn["suite"], "small-7");
    assert_eq!(drawn["seed"], 3);
    place.openbench("verify r").succeeded();
}

#[test]
fn several_seeds_are_several_neighbourhoods() {
    let place = Place::new();
    run(&place, "small --seeds 7..8 --out both").succeeded();
    for seed in [7, 8] {
        let results = place.json(&format!("both/seed-{seed}/results.json"));
        assert_eq!(results["suite"], format!("small-{seed}"));
    }
    let refused = run(&place, "small --seeds 7..8 --noise-seed 1 --out both");
    refused.refused_with(&["--noise-seed"]);
}

#[test]
fn a_neighbourhood_can_be_kept_as_a_folder() {
    let place = Place::new();
    let said = place
        .openbench("world draw small --seed 7 --out w")
        .succeeded()
        .stdout
        .clone();
    assert!(said.starts_with("small-7: "), "{said}");
    assert!(place.read("w/map.osm").contains("entrance"));
    assert!(!place.read("w/public.osm").contains("entrance"));
    place
        .openbench("world draw huge --out w")
        .refused_with(&["huge"]);
}
