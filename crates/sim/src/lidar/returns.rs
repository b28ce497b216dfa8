//! The return of a ray: whether the sensor detects it, and the range that it reports.
//!
//! The MID-360's data sheet states a detection range of 40 m at 10 % reflectivity and a range
//! deviation of at most 2 cm at 10 m. The light that comes back from a matt surface is ρ cos α / r²
//! (Lambert), so the first figure gives the least light that is detected.

/// Least range that the sensor reports, metres.
pub const MIN_RANGE_M: f32 = 0.1;
/// Largest range that the sensor reports, metres. The real one sees bright surfaces farther off;
/// the benchmark's robot is specified with 50 m.
pub const MAX_RANGE_M: f32 = 50.0;
/// Light that is detected with probability 1/2: 10 % reflectivity at 40 m.
const THRESHOLD: f32 = 0.1 / (40.0 * 40.0);
/// Least reflectivity in infrared, as a share. Surfaces that are darker to the eye have this one.
const DARKEST: f32 = 0.08;
/// Standard deviation of the range that comes from the timing, metres.
const TIMING_M: f32 = 0.015;
/// Standard deviation that grows with the range, metres per metre: 2 cm in all at 10 m.
const GROWTH: f32 = 0.0013;
/// Width of the beam, radians: on a slanting surface it spreads the range.
const DIVERGENCE_RAD: f32 = 0.003;
/// Below this cosine of the incidence the spread does not grow.
const GRAZING: f32 = 0.05;

/// The return of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Echo {
    /// True range, metres.
    pub(super) range: f32,
    /// Standard deviation of the reported range, metres.
    pub(super) deviation: f32,
    /// Light that comes back, see [`light`].
    pub(super) light: f32,
    /// Reflectivity of the surface, 0 to 255.
    pub(super) reflectivity: u8,
}

impl Echo {
    /// Of a ray that hits nothing.
    pub(super) const NONE: Self = Self {
        range: 0.0,
        deviation: 0.0,
        light: 0.0,
        reflectivity: 0,
    };

    /// Probability that the sensor reports the return.
    #[inline(always)]
    pub(super) fn detection(&self) -> f32 {
        // None below half the threshold, all above one and a half of it: a straight line stands
        // for the distribution function of the noise.
        lower(upper(self.light - 0.5, 0.0), 1.0)
    }
}

/// Light that comes back from a surface at `range` metres; 1 is detected with probability 1/2, and
/// out of the sensor's range there is none. `cosine` is that of the angle of incidence,
/// `reflectivity` counts 0 to 255.
#[inline(always)]
#[expect(
    clippy::manual_range_contains,
    reason = "two comparisons become vector instructions"
)]
pub(super) fn light(range: f32, cosine: f32, reflectivity: f32) -> f32 {
    // Reflectivities follow what the eye sees; in infrared no surface is quite as dark.
    let share = upper(reflectivity * (1.0 / 255.0), DARKEST);
    // At range 0 the quotient is infinite or NaN; the test of the range discards it.
    let light = share * cosine / (range * range) * (1.0 / THRESHOLD);
    if range >= MIN_RANGE_M && range <= MAX_RANGE_M {
        light
    } else {
        0.0
    }
}

/// Share of the light that air leaves on a way of `range` metres there and back, by the share that
/// it takes on each metre.
#[inline(always)]
pub(super) fn left_by_air(extinction: f32, range: f32) -> f32 {
    // The exponential function of an eighth, by its series, to the eighth power: within 2 % up to
    // what fog of 60 m takes at 50 m.
    let way = (2.0 / 8.0) * extinction * range;
    let series = 1.0 + way * (1.0 + way * (0.5 + way * (1.0 / 6.0 + way / 24.0)));
    let square = series * series;
    let fourth = square * square;
    1.0 / (fourth * fourth)
}

/// Standard deviation of the reported range, metres, at an angle of incidence with this cosine.
#[inline(always)]
pub(super) fn deviation(range: f32, cosine: f32) -> f32 {
    // A uniform distribution over a width has that width over the root of 12 as its deviation.
    const SPREAD: f32 = DIVERGENCE_RAD * DIVERGENCE_RAD / 12.0;
    let square = upper(cosine, GRAZING) * upper(cosine, GRAZING);
    // On a surface at the angle α, a beam that is wide by w spreads the range by w tan α.
    let slant = SPREAD * (1.0 - square) / square;
    (TIMING_M * TIMING_M + range * range * (GROWTH * GROWTH + slant)).sqrt()
}

/// `f32::max` without its treatment of NaN, which costs two instructions.
#[inline(always)]
fn upper(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `f32::min` without its treatment of NaN.
#[inline(always)]
fn lower(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detection(range: f32, cosine: f32, reflectivity: f32) -> f32 {
        Echo {
            light: light(range, cosine, reflectivity),
            ..Echo::NONE
        }
        .detection()
    }

    #[test]
    fn ranges_and_noise_match_the_data_sheet() {
        let dark = |range| detection(range, 1.0, 26.0);
        assert!(dark(30.0) > 0.99 && (0.4..0.6).contains(&dark(40.0)) && dark(49.9) < 0.2);
        assert!((deviation(10.0, 1.0) - 0.02).abs() < 0.001);
    }

    #[test]
    fn grazing_rays_are_lost_and_noisy() {
        assert!(detection(10.0, 0.02, 100.0) < detection(10.0, 0.5, 100.0));
        assert_eq!(detection(20.0, 0.005, 30.0), 0.0);
        assert!(deviation(20.0, 0.1) > 3.0 * deviation(20.0, 1.0));
    }

    #[test]
    fn nothing_is_detected_beyond_the_range_or_too_near() {
        for range in [50.1, 0.05, f32::INFINITY, f32::NAN] {
            assert_eq!(detection(range, 1.0, 255.0), 0.0, "{range}");
        }
    }

    #[test]
    fn air_takes_light_exponentially() {
        for way in [0.0, 0.3, 2.0, 6.5] {
            let left = f64::from(left_by_air(0.5 * way, 1.0));
            let exact = libm::exp(-f64::from(way));
            assert!((left / exact - 1.0).abs() < 0.02, "{way}: {left} {exact}");
        }
    }
}
