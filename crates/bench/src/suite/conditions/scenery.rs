//! What makes the streets of a world differ; built in `openbench_scene::generate`.

use openbench_scene::scenery::Scenery;

use super::level::{Condition, check_ranges};

impl Condition for Scenery {
    const KEY: &'static str = "scenery";
    const LEVELS: &'static [(&'static str, Self)] =
        &[("plain", Self::PLAIN), ("varied", Self::VARIED)];

    fn check(&self) -> Result<(), String> {
        check_ranges(&[
            ("ground", self.ground, 1.0),
            ("shapes", self.shapes, 1.0),
            ("clutter", self.clutter, 1.0),
            ("relief", self.relief, 1.0),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::super::Conditions;

    fn read(text: &str) -> Result<Conditions, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn amounts_are_checked() {
        let conditions = read("[scenery]\nlevel = \"varied\"\nrelief = 0").unwrap();
        assert_eq!(conditions.scenery.relief, 0.0);
        assert!(conditions.scenery.clutter > 0.0);
        for (text, expected) in [
            ("scenery = \"wild\"", "write one of plain, varied"),
            (
                "[scenery]\nclutter = 1.5",
                "clutter = 1.5: give a number from 0 to 1",
            ),
            (
                "[scenery]\nground = -0.5",
                "ground = -0.5: give a number from 0 to 1",
            ),
            ("[scenery]\nbins = 1", "there is no `bins`"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
