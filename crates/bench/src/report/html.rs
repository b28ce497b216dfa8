//! HTML escaping and formatting of numbers.

use std::collections::BTreeSet;

use crate::score::results::Results;

/// Escapes `text` for elements and attributes of HTML and SVG.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// A rate as a percentage with one decimal.
pub fn percent(rate: f64) -> String {
    format!("{:.1}", rate * 100.0)
}

/// An interval of shares in percent, without its sign. One that is narrower than a point has a
/// decimal, since it would look like a single number otherwise.
pub fn interval_text([low, high]: &[f64; 2], between: &str) -> String {
    let decimals = usize::from(high - low < 0.01);
    format!(
        "{:.decimals$}{between}{:.decimals$}",
        low * 100.0,
        high * 100.0
    )
}

/// `value` with a number of `decimals`, or a dash if it is missing or not finite.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    match value {
        Some(v) if v.is_finite() => format!("{v:.decimals$}"),
        _ => "–".to_owned(),
    }
}

/// Number of episodes with at least one delivery.
pub fn episode_count(results: &Results) -> usize {
    results
        .deliveries
        .iter()
        .map(|d| d.episode)
        .collect::<BTreeSet<_>>()
        .len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_is_escaped() {
        assert_eq!(
            escape("<a href=\"x\">'&'"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;"
        );
    }

    #[test]
    fn a_missing_number_is_a_dash() {
        assert_eq!(
            (percent(1.0), percent(0.7558)),
            ("100.0".into(), "75.6".into())
        );
        assert_eq!(
            (number(Some(1.25), 1), number(None, 1)),
            ("1.2".into(), "–".into())
        );
        assert_eq!(number(Some(f64::NAN), 1), "–");
    }
}
