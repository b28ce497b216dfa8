//! Random numbers: a stream for each purpose and element of a map, so that one more tree does not
//! repaint the houses.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::element::{ElementId, ElementKind};

/// The stream of one element for one purpose.
///
/// ```
/// use openbench_osm::draws::{chance, stream};
///
/// let mut draws = stream(7, 1, 42);
/// assert!(chance(&mut draws, 1.0) && !chance(&mut draws, 0.0));
/// ```
pub fn stream(seed: u64, purpose: u64, element: u64) -> Pcg64Mcg {
    // Mixed after each part, so that seeds, purposes and elements that differ by little give
    // unrelated streams.
    let mixed = mix(mix(mix(seed) ^ purpose) ^ element);
    Pcg64Mcg::new((u128::from(mixed) << 64) | u128::from(mix(mixed)))
}

/// A number for an element; a way and a relation of one number have different ones.
pub fn element_number(element: ElementId) -> u64 {
    let kind = match element.kind {
        ElementKind::Node => 0,
        ElementKind::Way => 1,
        ElementKind::Relation => 2,
    };
    // Nodes, ways and relations count independently of each other in OSM.
    (element.id as u64).wrapping_mul(3).wrapping_add(kind)
}

/// A number between `low` and `high`.
pub fn between(draws: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * draws.random::<f64>()
}

/// A whole number from `low` to `high`, both included.
pub fn whole(draws: &mut Pcg64Mcg, low: u32, high: u32) -> u32 {
    let span = f64::from(high - low + 1);
    let drawn = between(draws, 0.0, span) as u32;
    // Rounding may give the end of the span itself.
    low + drawn.min(high - low)
}

/// One of `choices`.
///
/// # Panics
/// If there are none.
pub fn pick<T: Copy>(draws: &mut Pcg64Mcg, choices: &[T]) -> T {
    // As `u32`: the draw is the same whatever the width of a `usize` is.
    choices[draws.random_range(0..choices.len() as u32) as usize]
}

/// True in a `share` of all cases.
pub fn chance(draws: &mut Pcg64Mcg, share: f64) -> bool {
    draws.random::<f64>() < share
}

/// Normal with mean 0 and standard deviation 1, by Box and Muller.
pub fn normal(draws: &mut Pcg64Mcg) -> f64 {
    // Above zero, since the logarithm of zero is infinite.
    let (u, v) = (1.0 - draws.random::<f64>(), draws.random::<f64>());
    // The method's second number is not kept: every call takes two draws.
    (-2.0 * libm::log(u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
pub fn mix(value: u64) -> u64 {
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
        let base = first(1, 5, 7);
        assert_eq!(base, first(1, 5, 7));
        assert_ne!(base, first(2, 5, 7));
        assert_ne!(base, first(1, 4, 7));
        assert_ne!(base, first(1, 5, 8));
    }

    #[test]
    fn whole_numbers_reach_both_ends() {
        let mut draws = stream(1, 1, 1);
        let drawn: Vec<u32> = (0..200).map(|_| whole(&mut draws, 3, 5)).collect();
        assert!((3..=5).all(|n| drawn.contains(&n)));
        assert!(drawn.iter().all(|n| (3..=5).contains(n)));
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_deviation_one() {
        let mut draws = stream(1, 1, 1);
        let numbers: Vec<f64> = (0..10_000).map(|_| normal(&mut draws)).collect();
        let mean = numbers.iter().sum::<f64>() / 1e4;
        let variance = numbers.iter().map(|n| n * n).sum::<f64>() / 1e4;
        assert!(mean.abs() < 0.05, "{mean}");
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
    }
}
