//! What door plates and other texts in the world are like; drawn in `openbench_scene::plates`.

use openbench_scene::plates::StreetPlates;

use super::level::{Condition, check_ranges};

impl Condition for StreetPlates {
    const KEY: &'static str = "plates";
    const LEVELS: &'static [(&'static str, Self)] = &[("paper", Self::PAPER), ("real", Self::REAL)];

    fn check(&self) -> Result<(), String> {
        check_ranges(&[
            ("missing", self.missing, 1.0),
            ("hidden", self.hidden, 1.0),
            ("second", self.second, 1.0),
            ("dirty", self.dirty, 1.0),
            ("glare", self.glare, 1.0),
            ("tilt_deg", self.tilt_deg, 12.0),
            ("signs", self.signs, 1.0),
        ])?;
        // Nothing would be drawn of what was asked for.
        if !self.real && *self != Self::PAPER {
            return Err(
                "only plates of the level `real` have shares; set level = \"real\"".to_owned(),
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Conditions;

    fn read(text: &str) -> Result<Conditions, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn shares_are_checked() {
        let conditions = read("[plates]\nlevel = \"real\"\nmissing = 0.5").unwrap();
        assert_eq!(conditions.plates.missing, 0.5);
        for (text, expected) in [
            ("plates = \"street\"", "write one of paper, real"),
            (
                "[plates]\nlevel = \"real\"\nhidden = 1.5",
                "hidden = 1.5: give a number from 0 to 1",
            ),
            ("[plates]\nmissing = 0.5", "set level = \"real\""),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
