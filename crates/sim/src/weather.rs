//! Rain and fog, as cameras and LiDARs meet them.
//!
//! Light falls exponentially on its way through air. The visibility is the distance at which a
//! black thing has 2 % contrast (Koschmieder 1924). Rain of R mm/h has one of 11.6 R^-0.63 km
//! (Atlas 1953).

use serde::{Deserialize, Serialize};

use crate::lidar::Air;
use crate::render::Illumination;

/// Negative logarithm of the contrast at the visibility.
const KOSCHMIEDER: f64 = 3.912;
/// Visibility in rain of 1 mm/h, metres, and how it falls with the rate.
const RAIN_VISIBILITY_M: f64 = 11_600.0;
const RAIN_EXPONENT: f64 = 0.63;
/// Share of the beams that a drop returns at 1 mm/h, and the largest one.
const DROPS_AT_1_MM_H: f64 = 1.5e-3;
const MOST_DROPS: f64 = 0.2;
/// The same in fog with a visibility of 50 m.
const DROPS_IN_FOG: f64 = 0.02;
/// Light under rain clouds or in fog, relative to that without sun.
const UNDER_CLOUDS: f32 = 0.6;
/// Thickness of the air before the sky, metres.
const SKY_M: f64 = 1500.0;

/// Rain, fog and wet ground. Nothing by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Weather {
    /// Rate of the rain, mm/h.
    pub rain_mm_h: f64,
    /// Visibility in fog, metres; 0 without fog.
    pub visibility_m: f64,
    /// Share of the water on roads and pavements that makes them mirrors, 0 to 1.
    pub wetness: f64,
}

impl Weather {
    /// A dry day without fog.
    pub const DRY: Self = Self {
        rain_mm_h: 0.0,
        visibility_m: 0.0,
        wetness: 0.0,
    };

    /// Share of the light that is lost on each metre, for short ways.
    pub(crate) fn extinction(&self) -> f64 {
        let fog = if self.visibility_m > 0.0 {
            KOSCHMIEDER / self.visibility_m
        } else {
            0.0
        };
        let rain = if self.rain_mm_h > 0.0 {
            KOSCHMIEDER / RAIN_VISIBILITY_M * libm::pow(self.rain_mm_h, RAIN_EXPONENT)
        } else {
            0.0
        };
        fog + rain
    }

    /// The air that beams of a LiDAR pass through.
    pub fn air(&self) -> Air {
        let rain = DROPS_AT_1_MM_H * self.rain_mm_h;
        let fog = if self.visibility_m > 0.0 {
            DROPS_IN_FOG * 50.0 / self.visibility_m
        } else {
            0.0
        };
        Air {
            extinction: self.extinction() as f32,
            drops: (rain + fog).min(MOST_DROPS) as f32,
        }
    }

    /// Drops on the lens of a camera that the rain falls on.
    pub fn lens_drops(&self) -> u32 {
        // The root, since drops run off as more of them fall. The cast saturates.
        (3.0 * self.rain_mm_h.max(0.0).sqrt()) as u32
    }

    /// Changes the light of dry, clear weather.
    pub(crate) fn dim(&self, light: &mut Illumination) {
        light.extinction = self.extinction() as f32;
        light.wetness = self.wetness as f32;
        if self.rain_mm_h <= 0.0 && self.visibility_m <= 0.0 {
            return;
        }
        // Clouds or fog before the sun: its light comes evenly from the sky.
        for channel in 0..3 {
            let grey = UNDER_CLOUDS * (light.ambient[1] + 0.3 * light.sun[1]);
            light.ambient[channel] = 0.3 * light.ambient[channel] * UNDER_CLOUDS + 0.7 * grey;
        }
        light.sun = [0.0; 3];
        light.shadows = false;
        light.glow = [0.0; 3];
        let way = self.extinction() * SKY_M;
        let veil = (1.0 - libm::exp(-way)) as f32;
        for channel in 0..3 {
            let grey = 255.0 * light.ambient[channel].sqrt();
            light.horizon[channel] = grey;
            let above = 0.5 * (light.zenith[channel] + grey).min(2.2 * grey);
            light.zenith[channel] = above + veil * (grey - above);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_scene::Sun;

    #[test]
    fn fog_takes_all_but_two_percent_at_the_visibility() {
        let fog = Weather {
            visibility_m: 50.0,
            ..Weather::DRY
        };
        let left = libm::exp(-fog.extinction() * 50.0);
        assert!((left - 0.02).abs() < 1e-3);
        assert!(fog.air().drops > 0.0);
    }

    #[test]
    fn rain_dims_less_than_fog_and_wets_the_lens() {
        let rain = Weather {
            rain_mm_h: 10.0,
            ..Weather::DRY
        };
        // 2.7 km by Atlas's formula.
        let visibility = 3.912 / rain.extinction();
        assert!((2600.0..2800.0).contains(&visibility), "{visibility}");
        assert!(rain.lens_drops() > 3);
        assert_eq!(Weather::DRY.lens_drops(), 0);
        assert_eq!(Weather::DRY.air(), Air::default());
    }

    #[test]
    fn dry_weather_leaves_the_light_as_it_is() {
        let noon = Illumination::of(&Sun::default());
        let mut light = noon.clone();
        Weather::DRY.dim(&mut light);
        assert_eq!(light, noon);
        let rain = Weather {
            rain_mm_h: 5.0,
            ..Weather::DRY
        };
        rain.dim(&mut light);
        assert!(light.sun == [0.0; 3] && light.ambient[1] < noon.ambient[1]);
    }
}
