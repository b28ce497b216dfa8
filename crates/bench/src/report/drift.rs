//! The chart of the localization error over time, as SVG.

use std::fmt::Write;

use openbench_core::Health;

use super::html::escape;
use super::input::EpisodeReport;
use crate::score::health::health_spans;
use crate::score::metrics::localization::localization;
use crate::trace::{PoseError, TimedComparison};

const WIDTH_PX: f64 = 1040.0;
const HEIGHT_PX: f64 = 120.0;
/// Margins for the axis labels at the left and at the bottom.
const LEFT_PX: f64 = 64.0;
const BOTTOM_PX: f64 = 22.0;
/// Maximum number of points drawn; each is the largest error of its interval.
const MAX_POINTS: usize = 500;

/// Writes the chart; nothing if no error is finite.
pub fn render(out: &mut String, episode: &EpisodeReport) {
    // NaN and infinity have no place on an axis. `localization` leaves them out too.
    let errors: Vec<PoseError> = episode
        .pose_errors
        .iter()
        .filter(|e| e.distance().is_finite())
        .copied()
        .collect();
    let (Some(sum), Some(last)) = (localization([&errors[..]].into_iter()), errors.last()) else {
        return;
    };
    // At least a second: a single pose at the start would otherwise divide by zero.
    let axes = Axes {
        seconds: last.time.seconds().max(1.0),
        metres: ceiling(sum.max_m),
    };
    let _ = write!(
        out,
        "<h4>Localization error</h4>\n<div class=\"drift\">\
         <svg viewBox=\"0 0 {WIDTH_PX} {HEIGHT_PX}\" role=\"img\" \
         aria-label=\"localization error over time\">\n"
    );
    axes.draw(out);
    shade_doubt(out, &errors, axes);
    mark_comparisons(out, &episode.comparisons, axes);
    draw_errors(out, &errors, axes);
    let _ = writeln!(
        out,
        "<p class=\"note\">Distance between the estimated and the true position: {} RMS, \
         95 % within {}, maximum {}; maximum heading error {:.2}°. {}{}</p>",
        metres(sum.rmse_m),
        metres(sum.p95_m),
        metres(sum.max_m),
        sum.max_yaw_rad.to_degrees(),
        health_note(&errors, sum.silent_divergences),
        if episode.comparisons.is_empty() {
            ""
        } else {
            " Marks below the axis: comparisons with the map that accepted or confirmed a pose, \
             and, paler, those that did not."
        },
    );
}

/// What the axes of the chart reach to.
#[derive(Clone, Copy)]
struct Axes {
    seconds: f64,
    metres: f64,
}

// 8 px at the right and 10 px at the top stay free, so that strokes and labels are not cut off.
impl Axes {
    /// Where a time is, pixels from the left.
    fn x(self, time: f64) -> f64 {
        LEFT_PX + time / self.seconds * (WIDTH_PX - LEFT_PX - 8.0)
    }

    /// Where an error is, pixels from the top.
    fn y(self, metres: f64) -> f64 {
        HEIGHT_PX - BOTTOM_PX - metres / self.metres * (HEIGHT_PX - BOTTOM_PX - 10.0)
    }

    /// Draws lines and labels.
    fn draw(self, out: &mut String) {
        for part in [0.0, 0.5, 1.0] {
            let (at, label) = (self.y(self.metres * part), metres(self.metres * part));
            let _ = writeln!(
                out,
                "<path class=\"grid\" d=\"M{LEFT_PX} {at:.1}H{WIDTH_PX}\"/>\
                 <text class=\"axis\" x=\"{:.0}\" y=\"{:.1}\">{label}</text>",
                LEFT_PX - 6.0,
                at + 4.0
            );
        }
        for part in 0..=4 {
            let time = self.seconds * f64::from(part) / 4.0;
            // The last label ends at its mark. Centred, it would reach beyond the picture.
            let anchor = if part == 4 { "end" } else { "middle" };
            let _ = writeln!(
                out,
                "<text x=\"{:.1}\" y=\"{:.0}\" text-anchor=\"{anchor}\">{time:.0} s</text>",
                self.x(time),
                HEIGHT_PX - 5.0
            );
        }
    }
}

/// Marks the comparisons with the map, below the axis of time.
fn mark_comparisons(out: &mut String, comparisons: &[TimedComparison], axes: Axes) {
    for one in comparisons {
        let class = if one.found.accepted.is_some() && !one.found.is_refused {
            "accepted"
        } else {
            "refused"
        };
        let (at, top) = (axes.x(one.time.seconds()), HEIGHT_PX - BOTTOM_PX);
        let _ = writeln!(out, "<path class=\"{class}\" d=\"M{at:.1} {top:.0}v5\"/>");
    }
}

/// Draws the errors and ends the picture.
fn draw_errors(out: &mut String, errors: &[PoseError], axes: Axes) {
    let mut line = String::new();
    // The maximum of each stretch, not a sample of it: thinning must not hide a peak.
    for stretch in errors.chunks(errors.len().div_ceil(MAX_POINTS)) {
        let distance = stretch.iter().map(PoseError::distance).fold(0.0, f64::max);
        let letter = if line.is_empty() { 'M' } else { 'L' };
        let _ = write!(
            line,
            "{letter}{:.1} {:.1}",
            axes.x(stretch[0].time.seconds()),
            axes.y(distance)
        );
    }
    let _ = writeln!(out, "<path class=\"error\" d=\"{line}\"/>\n</svg></div>");
}

/// Shades the times in which the agent did not trust its pose.
fn shade_doubt(out: &mut String, errors: &[PoseError], axes: Axes) {
    for span in health_spans(errors) {
        if span.health == Health::Good {
            continue;
        }
        let (from, to) = (axes.x(span.from_s), axes.x(span.to_s));
        let _ = writeln!(
            out,
            "<rect class=\"doubt\" x=\"{from:.1}\" y=\"10\" width=\"{:.1}\" height=\"{:.1}\">\
             <title>{}</title></rect>",
            // A single pose would not be seen.
            (to - from).max(1.0),
            HEIGHT_PX - BOTTOM_PX - 10.0,
            escape(&span.health.to_string()),
        );
    }
}

/// What the agent reported about its pose, in words.
fn health_note(errors: &[PoseError], silent_divergences: usize) -> String {
    let doubted = errors.iter().any(|error| error.health != Health::Good);
    let shaded = if doubted {
        "Shaded: the agent did not trust its pose. "
    } else {
        ""
    };
    let silent = if silent_divergences > 0 {
        "<b class=\"bad\">The agent reported good health with an error above 1 m.</b>"
    } else {
        ""
    };
    format!("{shaded}{silent}")
}

/// The smallest of 1, 2, 5 or 10 times a power of ten that is not below `metres`.
fn ceiling(metres: f64) -> f64 {
    // At least a millimetre: without any error the logarithm would be infinite, and the axis empty.
    let power = libm::pow(10.0, libm::floor(libm::log10(metres.max(1e-3))));
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    steps
        .into_iter()
        .find(|step| *step >= metres)
        .unwrap_or(10.0 * power)
}

/// A length in millimetres, centimetres or metres.
fn metres(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        small if small < 0.01 => format!("{:.1} mm", small * 1e3),
        small if small < 1.0 => format!("{:.1} cm", small * 1e2),
        large => format!("{large:.1} m"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{AcceptedPose, MapComparison, Pose2, PoseEstimate, SimTime};

    fn errors(count: u64, metres: f64) -> Vec<PoseError> {
        let estimated = |i: u64| Pose2::new(metres * i as f64 / count as f64, 0.0, 0.0);
        (1..=count)
            .map(|i| {
                PoseError::new(
                    SimTime::from_millis(100 * i),
                    Pose2::default(),
                    PoseEstimate {
                        pose: estimated(i),
                        health: Health::Good,
                    },
                )
            })
            .collect()
    }

    fn drive(pose_errors: Vec<PoseError>) -> EpisodeReport {
        EpisodeReport {
            pose_errors,
            ..EpisodeReport::default()
        }
    }

    #[test]
    fn a_long_drive_is_downsampled_and_keeps_its_largest_error() {
        let mut out = String::new();
        render(&mut out, &drive(errors(30_000, 0.3)));
        let points = out.matches('L').count();
        assert!((400..=MAX_POINTS).contains(&points), "{points}");
        assert!(
            out.contains("maximum 30.0 cm") && out.contains(">50.0 cm<") && out.contains("3000 s"),
            "{out}"
        );
    }

    #[test]
    fn comparisons_that_did_not_confirm_a_pose_are_marked_as_refused() {
        let compared = |accepted: bool, is_refused: bool| TimedComparison {
            time: SimTime::from_millis(100),
            truth: Pose2::default(),
            found: MapComparison {
                accepted: accepted.then(|| AcceptedPose {
                    pose: Pose2::default(),
                    covariance: [[0.0; 3]; 3],
                }),
                is_refused,
                ..MapComparison::default()
            },
        };
        let episode = EpisodeReport {
            comparisons: vec![
                compared(true, false),
                compared(true, true),
                compared(false, false),
            ],
            ..drive(errors(3, 0.1))
        };
        let mut out = String::new();
        render(&mut out, &episode);
        let count = |class: &str| out.matches(&format!("class=\"{class}\"")).count();
        assert_eq!((count("accepted"), count("refused")), (1, 2), "{out}");
    }

    #[test]
    fn an_empty_drive_draws_nothing_and_nan_is_left_out() {
        let mut out = String::new();
        render(&mut out, &EpisodeReport::default());
        assert_eq!(out, "");
        let mut broken = errors(3, 0.0);
        broken[1].offset[0] = f64::NAN;
        render(&mut out, &drive(broken));
        assert!(out.contains("maximum 0") && !out.contains("NaN"), "{out}");
    }
}
