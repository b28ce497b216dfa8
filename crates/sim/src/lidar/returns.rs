//! What comes back of a ray: whether anything does, and how far the sensor believes it to be.
//!
//! The MID-360's data sheet states a detection range of 40 m at 10 % reflectivity and a range deviation of at most 2 cm at 10 m. The light
//! that comes back from a matt surface is ρ cos α / r² (Lambert), so the first figure gives the least light that is detected.

/// Ranges that the sensor reports, metres. It sees bright things further off, but the benchmark's robot is told of 50 m.
pub const RANGE: (f32, f32) = (0.1, 50.0);
/// Least light that is detected as often as not: 10 % at 40 m.
const THRESHOLD: f32 = 0.1 / (40.0 * 40.0);
/// Surfaces darker than this to the eye still send back this share of infrared light.
const DARKEST: f32 = 0.08;
/// Deviation of the range from the timing, metres.
const TIMING: f32 = 0.015;
/// Deviation that grows with the range, metres a metre: 2 cm in all at 10 m.
const GROWTH: f32 = 0.0013;
/// Width of the beam, radians: on a slanting surface it spreads the range.
const DIVERGENCE: f32 = 0.003;
/// Below this cosine of the incidence the spread grows no more.
const GRAZING: f32 = 0.05;

/// What comes back of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// True range, metres.
    pub range: f32,
    /// Deviation of the reported range, metres.
    pub deviation: f32,
    /// Probability that the sensor reports anything.
    pub detection: f32,
    /// Reflectivity of the surface, 0 to 255.
    pub reflectivity: u8,
}

impl Echo {
    /// Nothing.
    pub const NONE: Self = Self {
        range: 0.0,
        deviation: 0.0,
        detection: 0.0,
        reflectivity: 0,
    };
}

/// Probability that the sensor reports a surface: at a range in metres, under an angle of incidence with this cosine, with a reflectivity of 0
/// to 255.
#[inline(always)]
pub fn detection(range: f32, cosine: f32, reflectivity: f32) -> f32 {
    let share = upper(reflectivity * (1.0 / 255.0), DARKEST);
    let light = share * cosine / (range * range);
    let chance = lower(upper(light * (1.0 / THRESHOLD) - 0.5, 0.0), 1.0);
    if range >= RANGE.0 && range <= RANGE.1 {
        chance
    } else {
        0.0
    }
}

/// Deviation of the reported range, metres, under an angle of incidence with this cosine.
#[inline(always)]
pub fn deviation(range: f32, cosine: f32) -> f32 {
    // The deviation of a range that is spread evenly over a width is that width over the root of 12.
    const SPREAD: f32 = DIVERGENCE * DIVERGENCE / 12.0;
    let square = upper(cosine, GRAZING) * upper(cosine, GRAZING);
    let slant = SPREAD * (1.0 - square) / square;
    (TIMING * TIMING + range * range * (GROWTH * GROWTH + slant)).sqrt()
}

/// As `f32::max`, whose care for NaN costs two instructions more.
#[inline(always)]
fn upper(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lower(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_data_sheets_figures_come_out() {
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
    fn nothing_is_seen_beyond_the_range_or_too_near() {
        for range in [50.1, 0.05, f32::INFINITY, f32::NAN] {
            assert_eq!(detection(range, 1.0, 255.0), 0.0, "{range}");
        }
    }
}
