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

/// A surface as a ray meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// True range, metres.
    pub range: f32,
    /// Cosine of the angle of incidence, 0 to 1.
    pub cosine: f32,
    /// Reflectivity of the surface, 0 to 255.
    pub reflectivity: u8,
}

impl Echo {
    /// Probability that the sensor reports anything.
    pub fn detection(&self) -> f32 {
        if !(RANGE.0..=RANGE.1).contains(&self.range) {
            return 0.0;
        }
        let share = (f32::from(self.reflectivity) / 255.0).max(DARKEST);
        let light = share * self.cosine / (self.range * self.range);
        (light / THRESHOLD - 0.5).clamp(0.0, 1.0)
    }

    /// Deviation of the reported range, metres.
    pub fn deviation(&self) -> f32 {
        // The deviation of a range that is spread evenly over a width is that width over the root of 12.
        const SPREAD: f32 = DIVERGENCE * DIVERGENCE / 12.0;
        let cosine = self.cosine.max(GRAZING);
        let slant = SPREAD * (1.0 - cosine * cosine) / (cosine * cosine);
        (TIMING * TIMING + self.range * self.range * (GROWTH * GROWTH + slant)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn echo(range: f32, cosine: f32, reflectivity: u8) -> Echo {
        Echo { range, cosine, reflectivity }
    }

    #[test]
    fn the_data_sheets_figures_come_out() {
        let dark = |range| echo(range, 1.0, 26).detection();
        assert!(dark(30.0) > 0.99 && (0.4..0.6).contains(&dark(40.0)) && dark(49.9) < 0.2);
        assert!((echo(10.0, 1.0, 200).deviation() - 0.02).abs() < 0.001);
    }

    #[test]
    fn grazing_rays_are_lost_and_noisy() {
        assert!(echo(10.0, 0.02, 100).detection() < echo(10.0, 0.5, 100).detection());
        assert_eq!(echo(20.0, 0.005, 30).detection(), 0.0);
        assert!(echo(20.0, 0.1, 100).deviation() > 3.0 * echo(20.0, 1.0, 100).deviation());
    }

    #[test]
    fn nothing_is_seen_beyond_the_range_or_too_near() {
        assert_eq!(echo(50.1, 1.0, 255).detection(), 0.0);
        assert_eq!(echo(0.05, 1.0, 255).detection(), 0.0);
        assert_eq!(echo(f32::INFINITY, 1.0, 255).detection(), 0.0);
    }
}
