//! The tags of an element: `key=value` pairs, each key once.
//!
//! Kept sorted by key, so that elements with the same tags are equal and are written alike.

use std::fmt;

/// The tags of one element, sorted by key.
///
/// ```
/// use openbench_osm::Tags;
///
/// let tags = Tags::from([("highway", "footway"), ("width", "5 ft"), ("lit", "no")]);
/// assert!(tags.is("highway", "footway"));
/// assert!(tags.has("lit") && !tags.says("lit"));
/// assert!((tags.metres("width").unwrap() - 1.524).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tags(Vec<(String, String)>);

impl Tags {
    /// No tags.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.index(key).ok().map(|i| self.0[i].1.as_str())
    }

    /// Sets `key` to `value` and returns the previous value.
    pub fn insert(&mut self, key: impl Into<String>, value: impl Into<String>) -> Option<String> {
        let (key, value) = (key.into(), value.into());
        match self.index(&key) {
            Ok(i) => Some(std::mem::replace(&mut self.0[i].1, value)),
            Err(i) => {
                self.0.insert(i, (key, value));
                None
            }
        }
    }

    /// Removes `key` and returns its value.
    pub fn remove(&mut self, key: &str) -> Option<String> {
        self.index(key).ok().map(|i| self.0.remove(i).1)
    }

    /// Whether `key` has exactly this `value`.
    pub fn is(&self, key: &str, value: &str) -> bool {
        self.get(key) == Some(value)
    }

    /// Whether `key` is present.
    pub fn has(&self, key: &str) -> bool {
        self.index(key).is_ok()
    }

    /// Whether `key` is present with a value other than `no`: OSM's way to say "this is a
    /// building".
    pub fn says(&self, key: &str) -> bool {
        self.get(key).is_some_and(|value| value != "no")
    }

    /// A length in metres; `None` if `key` is missing or its value is no length.
    ///
    /// A length is a number followed by nothing, `m`, `cm`, `mm`, `km`, `ft` or `in`, or feet and
    /// inches as in `5'6"`.
    pub fn metres(&self, key: &str) -> Option<f64> {
        const FOOT: f64 = 0.3048;
        const INCH: f64 = 0.0254;
        // A decimal comma.
        let text = self.get(key)?.trim().replace(',', ".");
        let length = match text.split_once('\'') {
            Some((feet, "")) => number(feet)? * FOOT,
            Some((feet, inches)) => {
                number(feet)? * FOOT + number(inches.trim_end_matches('"'))? * INCH
            }
            None => {
                let unit = text
                    .find(|c: char| c.is_alphabetic() || c == '"')
                    .unwrap_or(text.len());
                let scale = match &text[unit..] {
                    "" | "m" => 1.0,
                    "cm" => 0.01,
                    "mm" => 0.001,
                    "km" => 1000.0,
                    "ft" => FOOT,
                    "in" | "\"" => INCH,
                    _ => return None,
                };
                number(&text[..unit])? * scale
            }
        };
        (length >= 0.0).then_some(length)
    }

    /// The pairs of keys and values, by key.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(k, v)| (k.as_str(), v.as_str()))
    }

    /// The number of pairs.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Keeps the pairs for which `keep` holds.
    pub fn retain(&mut self, mut keep: impl FnMut(&str, &str) -> bool) {
        self.0.retain(|(k, v)| keep(k, v));
    }

    fn index(&self, key: &str) -> Result<usize, usize> {
        self.0.binary_search_by(|(k, _)| k.as_str().cmp(key))
    }
}

/// If a key appears twice, the later value counts.
impl<K: Into<String>, V: Into<String>> FromIterator<(K, V)> for Tags {
    fn from_iter<I: IntoIterator<Item = (K, V)>>(pairs: I) -> Self {
        let mut all: Vec<(String, String)> = pairs
            .into_iter()
            .map(|(k, v)| (k.into(), v.into()))
            .collect();
        // The sort is stable and `dedup` keeps the first of equals. Reversed in between, that is
        // the pair that came last.
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all.reverse();
        all.dedup_by(|a, b| a.0 == b.0);
        all.reverse();
        Self(all)
    }
}

impl<K: Into<String>, V: Into<String>, const N: usize> From<[(K, V); N]> for Tags {
    fn from(pairs: [(K, V); N]) -> Self {
        pairs.into_iter().collect()
    }
}

impl fmt::Display for Tags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.iter().map(|(k, v)| format!("{k}={v}")).collect();
        f.write_str(&words.join(" "))
    }
}

/// A finite number.
fn number(text: &str) -> Option<f64> {
    text.trim()
        .parse()
        .ok()
        .filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_sorted_and_the_later_of_two_values_counts() {
        let tags = Tags::from([
            ("name", "b"),
            ("building", "yes"),
            ("name", "c"),
            ("a", "1"),
        ]);
        assert_eq!(tags.to_string(), "a=1 building=yes name=c");
    }

    #[test]
    fn lengths_have_units() {
        let metres = |text: &str| Tags::from([("height", text)]).metres("height");
        let close = |text: &str, wanted: f64| {
            assert!(
                (metres(text).unwrap() - wanted).abs() < 1e-9,
                "{text}: {:?}",
                metres(text)
            );
        };
        for (text, wanted) in [
            ("2", 2.0),
            (" 2,5 m", 2.5),
            ("15 cm", 0.15),
            ("150mm", 0.15),
            ("0", 0.0),
            ("1 km", 1000.0),
        ] {
            close(text, wanted);
        }
        for (text, wanted) in [
            ("6 ft", 1.8288),
            ("5'", 1.524),
            ("5'6\"", 1.6764),
            ("6\"", 0.1524),
            ("0'6\"", 0.1524),
        ] {
            close(text, wanted);
        }
        for text in [
            "",
            "high",
            "-3",
            "nan",
            "inf",
            "2 storeys",
            "1e3x",
            "'",
            "m",
            "1'x",
        ] {
            assert_eq!(metres(text), None, "{text}");
        }
        assert_eq!(Tags::new().metres("height"), None);
    }

    #[test]
    fn insert_replaces_and_returns_the_previous_value() {
        let mut tags = Tags::from([("ref", "1")]);
        assert_eq!(tags.insert("ref", "2").as_deref(), Some("1"));
        assert_eq!(tags.insert("door", "yes"), None);
        assert_eq!(tags.to_string(), "door=yes ref=2");
        assert_eq!(tags.remove("door").as_deref(), Some("yes"));
        assert!(!tags.has("door") && tags.is("ref", "2"));
    }

    #[test]
    fn building_no_is_no_building() {
        assert!(Tags::from([("building", "yes")]).says("building"));
        assert!(!Tags::from([("building", "no")]).says("building"));
    }
}
