//! Streams of random numbers: one for each purpose and element, so that one more tree in the map
//! does not repaint the houses.

use openbench_osm::{ElementId, ElementKind};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// The purpose of a stream. The numbers are part of every world: new purposes go to the end.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub(super) enum Purpose {
    Palette = 1,
    Building,
    Doorway,
    Cars,
    Tree,
    Barrier,
    Planting,
    Furniture,
    Horizon,
    Wear,
}

/// The stream of one element for one purpose.
pub(super) fn stream(seed: u64, purpose: Purpose, element: u64) -> Pcg64Mcg {
    // Mixed after each part, so that seeds, purposes and elements that differ by little give
    // unrelated streams.
    let mixed = mix(mix(mix(seed) ^ purpose as u64) ^ element);
    Pcg64Mcg::new((u128::from(mixed) << 64) | u128::from(mix(mixed)))
}

/// A number for an element; a way and a relation of one number have different ones.
pub(super) fn element_number(element: ElementId) -> u64 {
    let kind = match element.kind {
        ElementKind::Node => 0,
        ElementKind::Way => 1,
        ElementKind::Relation => 2,
    };
    // Nodes, ways and relations count independently of each other in OSM.
    (element.id as u64).wrapping_mul(3).wrapping_add(kind)
}

/// A number between `low` and `high`.
pub(super) fn between(rng: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// One of `choices`.
pub(super) fn pick<T: Copy>(rng: &mut Pcg64Mcg, choices: &[T]) -> T {
    // As `u32`: the draw is the same whatever the width of a `usize` is.
    choices[rng.random_range(0..choices.len() as u32) as usize]
}

/// True in a `share` of all cases.
pub(super) fn chance(rng: &mut Pcg64Mcg, share: f64) -> bool {
    rng.random::<f64>() < share
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
pub(super) fn mix(value: u64) -> u64 {
    let a = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let b = (a ^ (a >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let c = (b ^ (b >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    c ^ (c >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_seed_purpose_and_element() {
        let first = |seed, purpose, element| stream(seed, purpose, element).random::<u64>();
        let base = first(1, Purpose::Tree, 7);
        assert_eq!(base, first(1, Purpose::Tree, 7));
        assert_ne!(base, first(2, Purpose::Tree, 7));
        assert_ne!(base, first(1, Purpose::Cars, 7));
        assert_ne!(base, first(1, Purpose::Tree, 8));
    }
}
