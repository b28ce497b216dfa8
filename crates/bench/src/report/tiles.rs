//! The headline metrics.

use std::fmt::Write;

use super::contacts;
use super::headline::{self, Headline};
use super::html::{escape, interval_text, number, percent};
use super::reference;
use crate::score::results::{Metrics, Results};

/// Writes the metrics of both criteria as rows of tiles, then the other figures.
pub fn render(out: &mut String, results: &Results) {
    let m = &results.metrics;
    out.push_str("<section>\n<h2>Results</h2>\n<div class=\"readings\">\n");
    reading(
        out,
        m,
        "Paper",
        "within 10 m of the plate, straight lines",
        &headline::paper(m),
    );
    reading(
        out,
        m,
        "Strict",
        "within 2 m of the correct door, drivable paths",
        &headline::strict(m),
    );
    out.push_str("</div>\n");
    facts(out, results);
    reference::render(out, results);
    out.push_str("</section>\n");
}

fn reading(out: &mut String, metrics: &Metrics, name: &str, definition: &str, tiles: &[Headline]) {
    let _ = write!(
        out,
        "<div class=\"reading\">\n<p class=\"reading-name\"><b>{name}</b> \
         <span>{definition}</span></p>\n<div class=\"tiles\">\n"
    );
    for Headline { label, key, value } in tiles {
        tile(
            out,
            label,
            *value,
            metrics.intervals.get(*key).copied().flatten().as_ref(),
        );
    }
    out.push_str("</div>\n</div>\n");
}

fn tile(out: &mut String, label: &str, value: Option<f64>, interval: Option<&[f64; 2]>) {
    let figure = value.map_or("–".to_owned(), |v| {
        format!("{}<small>%</small>", percent(v))
    });
    let _ = write!(
        out,
        "<div class=\"tile\"><span class=\"label\">{label}</span>\
         <span class=\"figure\">{figure}</span>"
    );
    out.push_str(&interval_bar(value, interval));
    let words = match (value, interval) {
        (Some(_), Some(interval)) => interval_text(interval, " to ") + " %",
        (Some(_), None) => "no interval".to_owned(),
        // SR and SPL need single deliveries, LSR and LSPL sequences.
        (None, _) if label.starts_with('L') => "no sequences".to_owned(),
        (None, _) => "no single deliveries".to_owned(),
    };
    let _ = writeln!(out, "<span class=\"interval\">{words}</span></div>");
}

/// A scale from 0 to 100 % with the interval as a thick line and the value as a mark.
fn interval_bar(value: Option<f64>, interval: Option<&[f64; 2]>) -> String {
    let mut bar = String::from(
        "<svg class=\"bar\" viewBox=\"0 0 100 8\" preserveAspectRatio=\"none\" \
         aria-hidden=\"true\">",
    );
    bar.push_str("<rect class=\"scale\" x=\"0\" y=\"3.5\" width=\"100\" height=\"1\"/>");
    if let Some([low, high]) = interval {
        // An interval of no width would not be seen.
        let (x, width) = (low * 100.0, ((high - low) * 100.0).max(0.5));
        let _ = write!(
            bar,
            "<rect class=\"range\" x=\"{x:.1}\" y=\"2\" width=\"{width:.1}\" height=\"4\"/>"
        );
    }
    if let Some(v) = value {
        // The mark is 1.5 wide: centred on the value, but inside the scale at 0 and 100 %.
        let x = (v * 100.0 - 0.75).clamp(0.0, 98.5);
        let _ = write!(
            bar,
            "<rect class=\"value\" x=\"{x:.1}\" y=\"0\" width=\"1.5\" height=\"8\"/>"
        );
    }
    bar + "</svg>"
}

fn facts(out: &mut String, results: &Results) {
    let m = &results.metrics;
    let mut facts = Vec::new();
    for (group, metrics) in [
        ("", headline::beside(m)),
        ("In sequences: ", headline::members(m)),
    ] {
        for Headline { label, value, .. } in metrics {
            let rate = value.map_or("–".to_owned(), |v| format!("{} %", percent(v)));
            facts.push((format!("{group}{label}"), rate));
        }
    }
    facts.push(("Collisions".to_owned(), collisions(m)));
    if let Some(encounters) = m.encounters {
        facts.push(("People and cars".to_owned(), encounters.describe()));
    }
    facts.push(("Driven".to_owned(), format!("{:.0} m", m.path_m)));
    facts.push(("Smoothness".to_owned(), m.smoothness.describe(m.path_m)));
    facts.push(("Simulated".to_owned(), duration(m.sim_seconds)));
    facts.push((
        "Real-time factor".to_owned(),
        format!("{} ×", number(m.real_time_factor, 1)),
    ));
    if let Some(doors) = results.doors {
        facts.push(("Doors on the map".to_owned(), doors.describe()));
    }
    out.push_str("<dl class=\"counts\">\n");
    for (name, value) in facts {
        let _ = writeln!(
            out,
            "<div><dt>{}</dt><dd>{}</dd></div>",
            escape(&name),
            escape(&value)
        );
    }
    out.push_str("</dl>\n");
}

fn collisions(metrics: &Metrics) -> String {
    if metrics.collisions_by_class.is_empty() {
        return metrics.collisions.to_string();
    }
    format!("{} ({})", metrics.collisions, contacts::by_class(metrics))
}

/// A duration as seconds, minutes and seconds, or hours and minutes.
fn duration(seconds: f64) -> String {
    let whole = libm::round(seconds.max(0.0)) as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_use_the_two_largest_units() {
        assert_eq!(
            (duration(59.6), duration(59.4)),
            ("1 min 00 s".into(), "59 s".into())
        );
        assert_eq!(duration(3725.0), "1 h 02 min");
    }

    #[test]
    fn a_metric_without_a_value_is_a_dash() {
        let mut out = String::new();
        tile(&mut out, "LSR", None, None);
        assert!(out.contains("–") && out.contains("no sequences"));
        tile(&mut out, "SR", Some(0.8), Some(&[0.49, 0.943]));
        assert!(out.contains("80.0<small>%</small>") && out.contains("49 to 94 %"));
    }
}
