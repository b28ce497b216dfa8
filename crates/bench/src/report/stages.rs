//! What the agent did over time, as SVG.

use std::fmt::Write;

use crate::score::stages::{StageSpan, stage_sums};

const WIDTH_PX: f64 = 1040.0;
const HEIGHT_PX: f64 = 14.0;
/// Margins of the axis of time, as in the chart of errors.
const LEFT_PX: f64 = 64.0;
const RIGHT_PX: f64 = 8.0;

/// Writes a bar with the stages one after another; nothing for an agent that tells none.
pub fn render(out: &mut String, spans: &[StageSpan]) {
    let Some(last) = spans.last() else { return };
    let end_s = last.to_s.max(1.0);
    let x = |seconds: f64| LEFT_PX + seconds / end_s * (WIDTH_PX - LEFT_PX - RIGHT_PX);
    let _ = writeln!(
        out,
        "<h4>What it did</h4>\n<div class=\"stages\"><svg viewBox=\"0 0 {WIDTH_PX} {HEIGHT_PX}\" \
         role=\"img\" aria-label=\"stages over time\">"
    );
    for span in spans {
        let (from, to) = (x(span.from_s), x(span.to_s));
        let _ = writeln!(
            out,
            "<rect class=\"stage-{:?}\" x=\"{from:.1}\" y=\"0\" width=\"{:.1}\" \
             height=\"{HEIGHT_PX}\"><title>{:.0} to {:.0} s: {}</title></rect>",
            span.stage,
            (to - from).max(0.5),
            span.from_s,
            span.to_s,
            span.stage
        );
    }
    out.push_str("</svg></div>\n<p class=\"note stages\">");
    for (stage, seconds) in stage_sums(spans.iter()) {
        let _ = write!(
            out,
            "<span><i class=\"stage-{stage:?}\"></i>{stage}: {seconds:.0} s</span> "
        );
    }
    out.push_str("</p>\n");
}

#[cfg(test)]
mod tests {
    use openbench_core::Stage;

    use super::*;

    #[test]
    fn each_stage_is_drawn_and_named_with_its_time() {
        let span = |from_s: f64, to_s: f64, stage| StageSpan {
            from_s,
            to_s,
            stage,
        };
        let mut out = String::new();
        render(
            &mut out,
            &[
                span(0.0, 10.0, Stage::Locating),
                span(10.0, 40.0, Stage::Travelling),
                span(40.0, 41.0, Stage::Locating),
            ],
        );
        assert_eq!(out.matches("<rect").count(), 3);
        assert!(out.contains("finding out where it is: 11 s"), "{out}");
        let mut nothing = String::new();
        render(&mut nothing, &[]);
        assert_eq!(nothing, "");
    }
}
