//! How values on the command line are read.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use openbench_core::{LonLat, MapPoint, Pose2};
use openbench_osm::{Window, WindowError};

/// A value on the command line that cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ValueError {
    /// It has another form, or is out of range.
    #[error("`{text}` is not {expected}")]
    Unexpected {
        /// What was written.
        text: String,
        /// What should be.
        expected: &'static str,
    },
    /// It is a window that is not on the Earth.
    #[error(transparent)]
    Window(#[from] WindowError),
}

fn unexpected(text: &str, expected: &'static str) -> ValueError {
    ValueError::Unexpected {
        text: text.to_owned(),
        expected,
    }
}

pub(super) fn key_value(text: &str) -> Result<(String, String), ValueError> {
    let (key, value) = text
        .split_once('=')
        .ok_or_else(|| unexpected(text, "KEY=VALUE"))?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// Accepts names that the map server of ROS accepts.
pub(super) fn yaml_file(text: &str) -> Result<PathBuf, ValueError> {
    file_of_kind(text, &["yaml", "yml"], "a file whose name ends in .yaml")
}

/// Accepts names by which other programs take a file for a log.
pub(super) fn mcap_file(text: &str) -> Result<PathBuf, ValueError> {
    file_of_kind(text, &["mcap"], "a file whose name ends in .mcap")
}

/// Accepts names of the kinds of pictures that are written.
pub(super) fn picture_file(text: &str) -> Result<PathBuf, ValueError> {
    let expected = "a file whose name ends in .png or .jpg";
    file_of_kind(text, &["png", "jpg", "jpeg"], expected)
}

/// Accepts names by which other programs take a file for a drawing.
pub(super) fn svg_file(text: &str) -> Result<PathBuf, ValueError> {
    file_of_kind(text, &["svg"], "a file whose name ends in .svg")
}

/// Accepts names by which other programs take a file for OSM XML.
pub(super) fn osm_file(text: &str) -> Result<PathBuf, ValueError> {
    file_of_kind(text, &["osm"], "a file whose name ends in .osm")
}

/// A file to write, of the kind that its ending says.
fn file_of_kind(
    text: &str,
    endings: &[&str],
    expected: &'static str,
) -> Result<PathBuf, ValueError> {
    let ending = Path::new(text)
        .extension()
        .and_then(|ending| ending.to_str());
    let fits = ending.is_some_and(|ending| {
        endings
            .iter()
            .any(|known| ending.eq_ignore_ascii_case(known))
    });
    if fits {
        Ok(text.into())
    } else {
        Err(unexpected(text, expected))
    }
}

/// The first and the last of some seeds.
pub(super) fn seeds(text: &str) -> Result<RangeInclusive<u64>, ValueError> {
    const MOST: u64 = 1000;
    let ends = text.split_once("..").and_then(|(first, last)| {
        let range = first.trim().parse().ok()?..=last.trim().parse().ok()?;
        (range.start() <= range.end() && range.end() - range.start() < MOST).then_some(range)
    });
    ends.ok_or_else(|| unexpected(text, "FIRST..LAST, up to 1000 seeds, such as 0..9"))
}

/// Finite numbers, separated by commas.
fn numbers<const COUNT: usize>(
    text: &str,
    expected: &'static str,
) -> Result<[f64; COUNT], ValueError> {
    let numbers = text.split(',').map(|word| word.trim().parse().ok());
    let numbers: Option<Vec<f64>> = numbers.collect();
    let finite = numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
    finite
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| unexpected(text, expected))
}

/// A number of which something holds.
fn number(
    text: &str,
    holds: impl FnOnce(f64) -> bool,
    expected: &'static str,
) -> Result<f64, ValueError> {
    // `parse` accepts NaN, which is in no range.
    let number = text.parse().ok().filter(|number| holds(*number));
    number.ok_or_else(|| unexpected(text, expected))
}

pub(super) fn lonlat(text: &str) -> Result<LonLat, ValueError> {
    let expected = "LON,LAT in degrees";
    let [lon, lat] = numbers(text, expected)?;
    // Neither is NaN: `numbers` accepts finite numbers only.
    if lon.abs() > 180.0 || lat.abs() > 90.0 {
        return Err(unexpected(text, expected));
    }
    Ok(LonLat::new(lon, lat))
}

pub(super) fn place(text: &str) -> Result<MapPoint, ValueError> {
    let [x, y] = numbers(text, "X,Y in metres, such as 12.5,-3")?;
    Ok(MapPoint::new(x, y))
}

/// Position in metres, heading in degrees.
pub(super) fn pose(text: &str) -> Result<Pose2, ValueError> {
    let [x, y, yaw] = numbers(text, "X,Y,YAW in metres and degrees")?;
    Ok(Pose2::new(x, y, yaw.to_radians()))
}

pub(super) fn pair(text: &str) -> Result<(f64, f64), ValueError> {
    let expected = "two numbers of at least 0, such as 30,0.5";
    let [a, b] = numbers(text, expected)?;
    if a < 0.0 || b < 0.0 {
        return Err(unexpected(text, expected));
    }
    Ok((a, b))
}

pub(super) fn window(text: &str) -> Result<Window, ValueError> {
    let [west, south, east, north] = numbers(text, "WEST,SOUTH,EAST,NORTH in degrees")?;
    Ok(Window::new(west, south, east, north)?)
}

pub(super) fn points(text: &str) -> Result<f64, ValueError> {
    let range = 0.1..=100.0;
    number(
        text,
        |p| range.contains(&p),
        "a difference from 0.1 to 100 points",
    )
}

pub(super) fn metres(text: &str) -> Result<f64, ValueError> {
    let is_length = |metres: f64| metres > 0.0 && metres.is_finite();
    number(text, is_length, "a length in metres")
}

pub(super) fn radius(text: &str) -> Result<f64, ValueError> {
    let range = 1.0..=20_000.0;
    number(
        text,
        |m| range.contains(&m),
        "a distance from 1 to 20000 metres",
    )
}

pub(super) fn kilometres(text: &str) -> Result<f64, ValueError> {
    let range = 0.001..=1000.0;
    number(
        text,
        |km| range.contains(&km),
        "a distance from 0.001 to 1000 kilometres",
    )
}

pub(super) fn far(text: &str) -> Result<f64, ValueError> {
    let range = 0.0..=10_000.0;
    number(
        text,
        |km| range.contains(&km),
        "a distance from 0 to 10000 kilometres",
    )
}

pub(super) fn minutes(text: &str) -> Result<f64, ValueError> {
    let range = 0.05..=600.0;
    number(
        text,
        |minutes| range.contains(&minutes),
        "a duration from 0.05 to 600 minutes",
    )
}

pub(super) fn share(text: &str) -> Result<f64, ValueError> {
    let range = 0.0..=1.0;
    number(text, |share| range.contains(&share), "a number from 0 to 1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_settings_are_read() {
        assert_eq!(lonlat("7.4,-43.7").unwrap(), LonLat::new(7.4, -43.7));
        assert!(lonlat("7.4").is_err() && lonlat("7.4,91").is_err() && lonlat("a,b").is_err());
        assert_eq!(key_value("a=b=c").unwrap(), ("a".into(), "b=c".into()));
        assert!(key_value("a").is_err());
    }

    #[test]
    fn files_have_the_ending_of_what_is_written() {
        assert_eq!(
            yaml_file("a/ground.yaml").unwrap(),
            Path::new("a/ground.yaml")
        );
        assert!(picture_file("view.PNG").is_ok() && picture_file("view.jpeg").is_ok());
        assert!(mcap_file("drive.mcap").is_ok());
        for name in ["drive.bag", "mcap", "drive", ".mcap"] {
            assert!(mcap_file(name).is_err(), "{name}");
        }
        assert!(svg_file("map.svg").is_ok() && svg_file("map.png").is_err());
        assert!(osm_file("wrong.osm").is_ok() && osm_file("wrong.osm.pbf").is_err());
        let error = picture_file("tour.gif").unwrap_err().to_string();
        assert!(
            error.contains("tour.gif") && error.contains(".png"),
            "{error}"
        );
    }

    #[test]
    fn numbers_are_complete_finite_and_in_range() {
        assert_eq!(place(" 12.5, -3").unwrap(), MapPoint::new(12.5, -3.0));
        for text in ["12.5", "1,2,3", "1,inf", "1,2x", "1,,2", ""] {
            let error = place(text).unwrap_err().to_string();
            assert_eq!(
                error,
                format!("`{text}` is not X,Y in metres, such as 12.5,-3")
            );
        }
        assert_eq!(pair("30,0.5").unwrap(), (30.0, 0.5));
        assert!(pair("30,-0.5").is_err());
        assert!(share("1").is_ok() && share("1.1").is_err() && share("NaN").is_err());
        assert!(metres("0").is_err() && metres("inf").is_err());
        assert!(radius("20000").is_ok() && radius("0.9").is_err());
    }

    #[test]
    fn a_window_off_the_earth_is_refused_with_its_reason() {
        let error = window("10,0,5,1").unwrap_err();
        assert!(matches!(error, ValueError::Window(_)), "{error}");
        assert!(window("5,0,10").is_err());
    }
}
