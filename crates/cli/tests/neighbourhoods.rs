//! `run KIND --seed N`: another neighbourhood for each seed.

mod common;

use common::{Place, Ran};

/// Drives by the truth, so that a run takes a second.
fn run(place: &Place, words: &str) -> Ran {
    place.openbench(&format!(
        "run {words} --agent omniscient --record none --json"
    ))
}

#[test]
fn a_seed_draws_a_neighbourhood_and_a_noise_seed_does_not() {
    let place = Place::new();
    let drawn = run(&place, "small --seed 7 --out r").succeeded().json();
    assert_eq!(drawn["suite"], "small-7");
    place.openbench("verify r").succeeded();
    // The same world by its name, with other noise.
    let named = run(&place, "small-7 --seed 3 --out n").succeeded().json();
    let noisy = run(&place, "small --seed 7 --noise-seed 3 --out m");
    let noisy = noisy.succeeded().json();
    let world = |results: &serde_json::Value| results["provenance"]["hashes"]["world"].clone();
    assert_eq!(world(&drawn), world(&named));
    assert_eq!(
        (&named["seed"], &named["deliveries"]),
        (&noisy["seed"], &noisy["deliveries"])
    );
    // Seed 0 is the built-in world, whatever the noise.
    let built_in = run(&place, "small --noise-seed 3 --out b")
        .succeeded()
        .json();
    assert_eq!(built_in["suite"], "small");
    assert_ne!(world(&built_in), world(&drawn));
}

#[test]
fn several_seeds_are_several_neighbourhoods() {
    let place = Place::new();
    run(&place, "small --seeds 7..8 --out both").succeeded();
    for seed in [7, 8] {
        let results = place.json(&format!("both/seed-{seed}/results.json"));
        assert_eq!(results["suite"], format!("small-{seed}"));
    }
    place.openbench("verify both").succeeded();
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
