//! Seeded random numbers for the sensors.

use std::sync::{Arc, LazyLock};

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// Entries of the table of normal quantiles.
const QUANTILES: usize = 4096;

/// A stream of random numbers. Each sensor has a stream of its own, so that one sensor's draws do
/// not change another's.
///
/// ```
/// use openbench_sim::noise::Noise;
///
/// let mut noise = Noise::new(7, 1);
/// assert!((0.0..1.0).contains(&noise.uniform()));
/// // The same seed and stream give the same numbers.
/// assert_eq!(Noise::new(7, 1).normal(), Noise::new(7, 1).normal());
/// assert_ne!(Noise::new(7, 1).normal(), Noise::new(7, 2).normal());
/// ```
#[derive(Debug, Clone)]
pub struct Noise {
    generator: Pcg32,
    quantiles: Arc<[f32]>,
}

impl Noise {
    /// Stream number `stream` of `seed`.
    pub fn new(seed: u64, stream: u64) -> Self {
        // Odd multipliers spread neighbouring seeds and streams over all bits; the first is that of
        // SplitMix64.
        let mixed =
            seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ stream.wrapping_mul(0xd1b5_4a32_d192_ed03);
        Self {
            generator: Pcg32::seed_from_u64(mixed),
            quantiles: NORMAL_QUANTILES.clone(),
        }
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        f64::from(self.generator.next_u32()) / 4_294_967_296.0
    }

    /// Normal with mean 0 and standard deviation 1, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        // Above zero, since the logarithm of zero is infinite.
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        // The method's second number is not kept: every call takes two draws.
        (-2.0 * libm::log(u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
    }

    /// Leaves out so many draws of the generator.
    pub(crate) fn skip(&mut self, draws: u64) {
        self.generator.advance(draws);
    }

    /// Two numbers from one draw: for many samples of small weight.
    #[inline(always)]
    pub(crate) fn quick(&mut self) -> QuickDraw {
        let bits = self.generator.next_u32();
        QuickDraw {
            // The highest 12 bits number the quantiles, and the other 20 are the uniform number.
            normal: self.quantiles[(bits >> 20) as usize],
            uniform: (bits & 0xf_ffff) as f32 / 1_048_576.0,
        }
    }
}

/// Two random numbers from one draw of the generator.
#[derive(Debug, Clone, Copy)]
pub(crate) struct QuickDraw {
    /// Normal with mean 0 and standard deviation 1, from a table.
    pub(crate) normal: f32,
    /// Uniform in [0, 1).
    pub(crate) uniform: f32,
}

/// Quantiles of the normal distribution at the middles of equal shares, scaled to a standard
/// deviation of exactly 1.
static NORMAL_QUANTILES: LazyLock<Arc<[f32]>> = LazyLock::new(|| {
    let raw: Vec<f64> = (0..QUANTILES)
        .map(|i| quantile((i as f64 + 0.5) / QUANTILES as f64))
        .collect();
    let deviation = (raw.iter().map(|q| q * q).sum::<f64>() / QUANTILES as f64).sqrt();
    raw.iter().map(|q| (q / deviation) as f32).collect()
});

/// Quantile of the normal distribution, by bisection of the error function.
fn quantile(share: f64) -> f64 {
    // The outermost of the table's quantiles is at 3.7. Fifty halvings reach a double's precision.
    let (mut low, mut high) = (-6.0, 6.0);
    for _ in 0..50 {
        let middle = (low + high) / 2.0;
        let below = 0.5 * (1.0 + libm::erf(middle / std::f64::consts::SQRT_2));
        if below < share {
            low = middle
        } else {
            high = middle
        }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_draws_have_their_means_and_deviations() {
        let mut noise = Noise::new(3, 1);
        let moments = |samples: Vec<f64>| {
            let n = samples.len() as f64;
            let mean = samples.iter().sum::<f64>() / n;
            (
                mean,
                (samples.iter().map(|s| (s - mean) * (s - mean)).sum::<f64>() / n).sqrt(),
            )
        };
        let exact = moments((0..50_000).map(|_| noise.normal()).collect());
        let (quick, even): (Vec<f64>, Vec<f64>) = (0..50_000)
            .map(|_| noise.quick())
            .map(|drawn| {
                let even = (f64::from(drawn.uniform) - 0.5) * 12.0_f64.sqrt();
                (f64::from(drawn.normal), even)
            })
            .unzip();
        let (quick, even) = (moments(quick), moments(even));
        for (mean, deviation) in [exact, quick, even] {
            assert!(
                mean.abs() < 0.02 && (deviation - 1.0).abs() < 0.02,
                "{mean} {deviation}"
            );
        }
    }

    #[test]
    fn seeds_and_streams_differ_and_repeat() {
        let first = |seed, stream| Noise::new(seed, stream).uniform();
        assert_eq!(first(1, 1), first(1, 1));
        assert_ne!(first(1, 1), first(2, 1));
        assert_ne!(first(1, 1), first(1, 2));
    }
}
