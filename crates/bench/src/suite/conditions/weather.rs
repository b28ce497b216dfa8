//! Rain, fog and wet ground.

use openbench_sim::Weather;

use super::level::{Condition, check_ranges};

impl Condition for Weather {
    const KEY: &'static str = "weather";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("dry", Self::DRY),
        (
            "wet",
            Self {
                wetness: 0.7,
                ..Self::DRY
            },
        ),
        (
            "rain",
            Self {
                rain_mm_h: 10.0,
                wetness: 1.0,
                ..Self::DRY
            },
        ),
        (
            "fog",
            Self {
                visibility_m: 60.0,
                ..Self::DRY
            },
        ),
    ];

    fn check(&self) -> Result<(), String> {
        check_ranges(&[
            ("rain_mm_h", self.rain_mm_h, 200.0),
            ("visibility_m", self.visibility_m, 1e6),
            ("wetness", self.wetness, 1.0),
        ])?;
        if self.visibility_m > 0.0 && self.visibility_m < 1.0 {
            return Err(format!(
                "visibility_m = {}: give at least 1, or 0 for none",
                self.visibility_m
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fog_that_is_a_wall_is_refused() {
        let fog = |visibility_m| Weather {
            visibility_m,
            ..Weather::DRY
        };
        assert!(fog(0.5).check().unwrap_err().contains("at least 1"));
        assert!(fog(f64::NAN).check().is_err() && fog(-5.0).check().is_err());
        assert_eq!(fog(20.0).check(), Ok(()));
    }
}
