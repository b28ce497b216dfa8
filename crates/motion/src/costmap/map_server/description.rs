//! The `.yaml` file: where a grid lies, and what the grey levels of its image mean.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::MapServerError;

/// How grey levels are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Occupied, free, or unknown.
    #[default]
    Trinary,
    /// From free to occupied, or unknown.
    Scale,
    /// As they are.
    Raw,
}

/// The `.yaml` file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// The image, relative to the description's folder.
    pub image: PathBuf,
    /// Side of a cell, metres.
    pub resolution: f64,
    /// South-west corner in `map` and direction of the rows: metres, metres, radians.
    pub origin: Vec<f64>,
    /// Whether light means occupied.
    #[serde(default, with = "flag")]
    pub negate: bool,
    /// Probability above which a cell is occupied.
    pub occupied_thresh: f64,
    /// Probability below which it is free.
    pub free_thresh: f64,
    /// How grey levels are read.
    #[serde(default)]
    pub mode: Mode,
}

/// Reads a description from its text; `path` is for errors.
pub fn describe(text: &str, path: &Path) -> Result<Description, MapServerError> {
    let description: Description =
        serde_saphyr::from_str(text).map_err(|source| MapServerError::Description {
            path: path.to_owned(),
            source: Box::new(source),
        })?;
    description.check(path)?;
    Ok(description)
}

impl Description {
    /// Whether all values make sense; `path` is for errors.
    pub(super) fn check(&self, path: &Path) -> Result<(), MapServerError> {
        let wrong = |key: &'static str, value: String, wanted: &'static str| {
            Err(MapServerError::Value {
                path: path.to_owned(),
                key,
                value,
                wanted,
            })
        };
        let Self {
            resolution,
            origin,
            occupied_thresh,
            free_thresh,
            ..
        } = self;
        // Ranges, here and below, contain no NaN.
        if !(1e-4..=1e3).contains(resolution) {
            return wrong(
                "resolution",
                resolution.to_string(),
                "give metres from 0.0001 to 1000",
            );
        }
        let is_place = origin.iter().all(|v| v.is_finite() && v.abs() < 1e7);
        if !(2..=3).contains(&origin.len()) || !is_place {
            let wanted = "give x, y and yaw in metres and radians";
            return wrong("origin", format!("{origin:?}"), wanted);
        }
        if !(0.0..=1.0).contains(occupied_thresh) {
            return wrong(
                "occupied_thresh",
                occupied_thresh.to_string(),
                "give a probability",
            );
        }
        if !(0.0..=*occupied_thresh).contains(free_thresh) {
            let wanted = "give a probability below `occupied_thresh`";
            return wrong("free_thresh", free_thresh.to_string(), wanted);
        }
        Ok(())
    }
}

/// `negate` is written as 0 or 1, or as a boolean.
mod flag {
    use serde::{Deserialize, Deserializer, Serializer};

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Flag {
        Number(i64),
        Boolean(bool),
    }

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
    pub(super) fn serialize<S: Serializer>(flag: &bool, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_i64(i64::from(*flag))
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<bool, D::Error> {
        match Flag::deserialize(deserializer)? {
            Flag::Number(number) => Ok(number != 0),
            Flag::Boolean(flag) => Ok(flag),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::error::Error;

    pub(in crate::costmap::map_server) const YAML: &str = "\
image: a.pgm
resolution: 0.1
origin: [-2.0, 3.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
";

    /// The error of a description with a change, with its causes.
    fn refused(from: &str, to: &str) -> String {
        let text = YAML.replace(from, to);
        let error = describe(&text, Path::new("a.yaml")).unwrap_err();
        let mut message = error.to_string();
        let mut cause = error.source();
        while let Some(error) = cause {
            message += &format!(": {error}");
            cause = error.source();
        }
        message
    }

    #[test]
    fn a_value_that_makes_no_sense_is_reported_with_its_key() {
        assert!(refused("0.1\n", "-1\n").contains("`resolution` is -1"));
        assert!(refused("0.1\n", ".nan\n").contains("`resolution`"));
        assert!(refused("[-2.0, 3.0, 0.0]", "[1]").contains("`origin`"));
        assert!(refused("0.196", "0.9").contains("`free_thresh` is 0.9"));
    }

    #[test]
    fn a_description_that_lacks_something_says_what() {
        assert!(refused("resolution: 0.1\n", "").contains("resolution"));
        assert!(refused("negate: 0\n", "mode: other\n").contains("a.yaml"));
        assert!(describe("[", Path::new("a.yaml")).is_err());
    }
}
