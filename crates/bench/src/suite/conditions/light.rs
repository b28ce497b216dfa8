//! The light: the hour of day, clouds, lamps.

use openbench_sim::Daylight;
use openbench_sim::noise::Noise;
use serde::{Deserialize, Serialize};

use super::level::{Condition, check_ranges};

/// Stream of random numbers, distinct from those of sensors, traffic, fixes, starts, robots and
/// lenses.
const RANDOM_STREAM: u64 = 36;
/// Days and hours that are tried until the sun is where it shall be. Even a sun that is in a range
/// of one degree is found in far fewer.
const MOST_TRIES: usize = 10_000;

/// The light under which a run takes place. Day and hour are drawn: any in a year at which the sun
/// is as high as said.
///
/// ```
/// use openbench_bench::suite::{Condition, LightLevel};
///
/// let night = LightLevel::LEVELS.iter().find(|(name, _)| *name == "night").unwrap().1;
/// let drawn = night.draw(7, 48.2).unwrap();
/// assert!(drawn.lamps && drawn.sun_elevation_deg <= -12.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightLevel {
    /// Whether the sun is drawn; otherwise the world has its own light, that of a clear noon
    /// without shadows.
    pub drawn: bool,
    /// Least height of the sun above the horizon, degrees.
    pub sun_from_deg: f64,
    /// Largest height of the sun above the horizon, degrees.
    pub sun_to_deg: f64,
    /// Share of the sky that clouds cover.
    pub clouds: f64,
    /// Whether lamps and windows are lit, and the robot has its light on.
    pub lamps: bool,
}

impl LightLevel {
    const NOON: Self = Self {
        drawn: false,
        sun_from_deg: 5.0,
        sun_to_deg: 90.0,
        clouds: 0.0,
        lamps: false,
    };

    /// A day and an hour at this latitude, degrees; `None` for the world's own light.
    pub fn draw(&self, seed: u64, latitude_deg: f64) -> Option<Daylight> {
        if !self.drawn {
            return None;
        }
        let mut noise = Noise::new(seed, RANDOM_STREAM);
        let mut nearest = Daylight::at(latitude_deg, 80, 12.0);
        let mut miss = f64::INFINITY;
        for _ in 0..MOST_TRIES {
            let day = 1 + (365.0 * noise.uniform()) as u32;
            let light = Daylight::at(latitude_deg, day, 24.0 * noise.uniform());
            let height = light.sun_elevation_deg;
            let off = (self.sun_from_deg - height).max(height - self.sun_to_deg);
            if off < miss {
                (nearest, miss) = (light, off);
            }
            if miss <= 0.0 {
                break;
            }
        }
        // Near the poles the sun may never be there; then it is as near to it as it gets.
        Some(Daylight {
            clouds: self.clouds,
            lamps: self.lamps,
            ..nearest
        })
    }
}

impl Default for LightLevel {
    fn default() -> Self {
        Self::NOON
    }
}

impl Condition for LightLevel {
    const KEY: &'static str = "light";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("noon", Self::NOON),
        (
            "day",
            Self {
                drawn: true,
                ..Self::NOON
            },
        ),
        (
            "overcast",
            Self {
                drawn: true,
                clouds: 1.0,
                ..Self::NOON
            },
        ),
        (
            "dusk",
            Self {
                drawn: true,
                sun_from_deg: -4.0,
                sun_to_deg: -1.0,
                clouds: 0.0,
                lamps: true,
            },
        ),
        (
            "night",
            Self {
                drawn: true,
                sun_from_deg: -90.0,
                sun_to_deg: -12.0,
                clouds: 0.0,
                lamps: true,
            },
        ),
    ];

    fn check(&self) -> Result<(), String> {
        check_ranges(&[("clouds", self.clouds, 1.0)])?;
        let heights = [
            ("sun_from_deg", self.sun_from_deg),
            ("sun_to_deg", self.sun_to_deg),
        ];
        for (key, value) in heights {
            // False for NaN as well.
            if !(-90.0..=90.0).contains(&value) {
                return Err(format!("{key} = {value}: give a number from -90 to 90"));
            }
        }
        if self.sun_from_deg > self.sun_to_deg {
            return Err(format!(
                "sun_from_deg = {}: give at most sun_to_deg = {}",
                self.sun_from_deg, self.sun_to_deg
            ));
        }
        if !self.drawn && *self != Self::NOON {
            let problem = "noon is as it is; set drawn = true, or begin with a level such as day";
            return Err(problem.to_owned());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_is_drawn_where_each_level_says() {
        for (name, level) in LightLevel::LEVELS {
            assert_eq!(level.check(), Ok(()), "{name}");
            for seed in 0..20 {
                let Some(light) = level.draw(seed, 48.2) else {
                    assert!(level.is_off());
                    continue;
                };
                let heights = level.sun_from_deg..=level.sun_to_deg;
                assert!(
                    heights.contains(&light.sun_elevation_deg),
                    "{name}: {light:?}"
                );
            }
        }
    }

    #[test]
    fn a_sun_that_never_rises_so_high_is_as_high_as_it_gets() {
        let high = LightLevel {
            drawn: true,
            sun_from_deg: 60.0,
            ..LightLevel::NOON
        };
        let light = high.draw(1, 78.2).unwrap();
        assert!((30.0..36.0).contains(&light.sun_elevation_deg), "{light:?}");
    }

    #[test]
    fn heights_must_be_in_order_and_in_range() {
        let level = |from, to| LightLevel {
            sun_from_deg: from,
            sun_to_deg: to,
            ..LightLevel::NOON
        };
        assert!(level(10.0, 5.0).check().unwrap_err().contains("at most"));
        assert!(level(-95.0, 5.0).check().unwrap_err().contains("-90 to 90"));
        assert!(level(f64::NAN, 5.0).check().is_err());
    }
}
