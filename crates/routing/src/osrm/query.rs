//! The texts of a request: coordinates and options.

use openbench_core::LonLat;

use super::failure::Failure;
use super::polyline;
use crate::geo::Place;
use crate::position::BearingRange;

/// One `key=value` of a query, and its offset.
#[derive(Debug, Clone)]
pub(super) struct Setting<'a> {
    pub(super) key: &'a str,
    /// Percent-decoded.
    pub(super) value: String,
    pub(super) position: usize,
}

/// A part of a request as it may be quoted: shortened.
pub(super) fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}

/// `lon,lat;lon,lat`, `polyline(…)` or `polyline6(…)`.
pub(super) fn places(coordinates: &str, position: usize) -> Result<Vec<Place>, Failure> {
    let decoded = percent_decoded(coordinates).ok_or_else(|| Failure::query(position))?;
    let text = decoded.strip_suffix(".json").unwrap_or(&decoded);
    let line = |start: &str, places: u32| {
        let inner = text.strip_prefix(start)?.strip_suffix(')')?;
        Some(polyline::decode(inner, places))
    };
    let positions: Vec<LonLat> = match line("polyline(", 5).or_else(|| line("polyline6(", 6)) {
        Some(line) => {
            let line = line.ok_or_else(|| Failure::query(position))?;
            line.into_iter()
                .map(|[lat, lon]| LonLat::new(lon, lat))
                .collect()
        }
        None => {
            let mut at = position;
            let mut pairs = Vec::new();
            for pair in text.split(';') {
                pairs.push(lonlat(pair).ok_or_else(|| Failure::query(at))?);
                // The offset of the next pair, behind the semicolon: errors name it.
                at += pair.len() + 1;
            }
            pairs
        }
    };
    // The text was a pair of numbers, but they are off the Earth: another error than a malformed
    // one.
    let invalid = || Failure::new("InvalidValue", "Invalid coordinate value.");
    positions
        .into_iter()
        .map(|position| Place::new(position).ok_or_else(invalid))
        .collect()
}

fn lonlat(pair: &str) -> Option<LonLat> {
    let (lon, lat) = pair.split_once(',')?;
    Some(LonLat::new(number(lon)?, number(lat)?))
}

/// A finite number, written in digits.
pub(super) fn number(text: &str) -> Option<f64> {
    let digits = text
        .bytes()
        .all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    text.parse()
        .ok()
        .filter(|number: &f64| digits && number.is_finite())
}

/// Metres; without a limit if the text is empty.
pub(super) fn radius(text: &str) -> Option<f64> {
    match text {
        "" | "unlimited" => Some(f64::INFINITY),
        _ => number(text).filter(|radius| *radius >= 0.0),
    }
}

/// `bearing,tolerance`, degrees.
pub(super) fn bearing_range(text: &str) -> Option<BearingRange> {
    let (bearing, tolerance) = text.split_once(',')?;
    let range = BearingRange {
        bearing: number(bearing)?,
        tolerance: number(tolerance)?,
    };
    let is_valid =
        (0.0..=360.0).contains(&range.bearing) && (0.0..=180.0).contains(&range.tolerance);
    is_valid.then_some(range)
}

fn percent_decoded(text: &str) -> Option<String> {
    if !text.contains('%') {
        return Some(text.to_owned());
    }
    let (mut bytes, mut rest) = (Vec::new(), text.as_bytes());
    while let [first, after @ ..] = rest {
        rest = after;
        if *first != b'%' {
            bytes.push(*first);
            continue;
        }
        let [high, low, after @ ..] = after else {
            return None;
        };
        let digit = |byte: u8| char::from(byte).to_digit(16);
        bytes.push((digit(*high)? * 16 + digit(*low)?) as u8);
        rest = after;
    }
    String::from_utf8(bytes).ok()
}

/// The options of a query that begins at `position`.
pub(super) fn options(query: &str, mut position: usize) -> Result<Vec<Setting<'_>>, Failure> {
    let mut options = Vec::new();
    for option in query.split('&').filter(|_| !query.is_empty()) {
        let (key, value) = option
            .split_once('=')
            .ok_or_else(|| Failure::query(position))?;
        let value = percent_decoded(value).ok_or_else(|| Failure::query(position))?;
        options.push(Setting {
            key,
            value,
            position,
        });
        position += option.len() + 1;
    }
    Ok(options)
}

impl Setting<'_> {
    pub(super) fn fail(&self) -> Failure {
        Failure::query(self.position)
    }

    pub(super) fn boolean(&self) -> Result<bool, Failure> {
        match self.value.as_str() {
            "true" => Ok(true),
            "false" => Ok(false),
            _ => Err(self.fail()),
        }
    }

    pub(super) fn whole(&self) -> Result<usize, Failure> {
        self.value.parse().map_err(|_| self.fail())
    }

    /// Indices separated by semicolons; none for `all`.
    pub(super) fn indices(&self) -> Result<Vec<usize>, Failure> {
        match self.value.as_str() {
            "all" | "" => Ok(Vec::new()),
            list => list
                .split(';')
                .map(|i| i.parse().map_err(|_| self.fail()))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_decoded_and_remember_their_offset() {
        let options = options("steps=true&annotations=duration%2Cspeed", 10).unwrap();
        let found: Vec<_> = options
            .iter()
            .map(|o| (o.key, o.value.as_str(), o.position))
            .collect();
        assert_eq!(
            found,
            [("steps", "true", 10), ("annotations", "duration,speed", 21)]
        );
        assert!(super::options("steps", 0).is_err());
        assert!(super::options("steps=%2", 0).is_err());
    }

    #[test]
    fn bearings_need_a_tolerance() {
        let range = BearingRange {
            bearing: 90.0,
            tolerance: 20.0,
        };
        assert_eq!(bearing_range("90,20"), Some(range));
        for text in ["", "90", "90,181", "361,20", "90,x", "nan,20"] {
            assert_eq!(bearing_range(text), None, "{text}");
        }
    }
}
