//! How long a ferry takes, from the tag `duration`.

/// The seconds of `MM`, `HH:MM`, `HH:MM:SS` or an ISO 8601 duration such as `PT1H30M`. `None` for
/// other texts, and for durations below a second or above 11 days.
pub(super) fn seconds(duration: &str) -> Option<f64> {
    let text = duration.trim();
    let seconds = match text.strip_prefix("PT") {
        Some(units) => iso_seconds(units)?,
        None => clock_seconds(text)?,
    };
    (1.0..1e6).contains(&seconds).then_some(seconds)
}

/// `1H30M`.
fn iso_seconds(mut rest: &str) -> Option<f64> {
    let mut total = 0.0;
    while let Some(unit) = rest.find(['H', 'M', 'S']) {
        let size = match rest.as_bytes()[unit] {
            b'H' => 3600.0,
            b'M' => 60.0,
            _ => 1.0,
        };
        total += rest[..unit].parse::<f64>().ok()? * size;
        rest = &rest[unit + 1..];
    }
    Some(total)
}

/// `30`, `1:30` or `1:30:00`.
fn clock_seconds(text: &str) -> Option<f64> {
    let parts: Vec<&str> = text.split(':').collect();
    let sizes: &[f64] = match parts.len() {
        1 => &[60.0],
        2 => &[3600.0, 60.0],
        3 => &[3600.0, 60.0, 1.0],
        _ => return None,
    };
    let mut total = 0.0;
    for (part, size) in parts.iter().zip(sizes) {
        total += part.parse::<f64>().ok()? * size;
    }
    Some(total)
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn timetables_are_read() {
        for (text, expected) in [
            ("10", 600.0),
            ("01:30", 5400.0),
            ("0:10:30", 630.0),
            ("PT1H30M", 5400.0),
            ("PT45S", 45.0),
        ] {
            assert_eq!(seconds(text), Some(expected), "{text}");
        }
        for text in ["", "soon", "-5", "1:2:3:4", "PT", "PTxH", "nan", "inf"] {
            assert_eq!(seconds(text), None, "{text}");
        }
    }
}
