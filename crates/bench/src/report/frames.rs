//! The camera frames in which plates were read, with the text's outline drawn over them.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::html::escape;
use super::input::PlateFrame;
use crate::plural::count;

/// More frames than these would make the file heavy and tell little new; they are counted instead.
const SHOWN: usize = 12;
/// The first of them are open, the rest folds away.
const OPEN: usize = 3;

/// Writes the frames in the order given.
pub fn render(out: &mut String, plates: &[PlateFrame]) {
    if plates.is_empty() {
        return;
    }
    let shown = &plates[..plates.len().min(SHOWN)];
    let (open, folded) = shown.split_at(shown.len().min(OPEN));
    let _ = write!(out, "<h4>Plates read</h4>\n<div class=\"frames\">\n");
    open.iter().for_each(|p| figure(out, p));
    out.push_str("</div>\n");
    if !folded.is_empty() {
        let _ = write!(
            out,
            "<details><summary>{}</summary>\n<div class=\"frames\">\n",
            count(folded.len(), "more frame", "more frames")
        );
        folded.iter().for_each(|p| figure(out, p));
        out.push_str("</div>\n</details>\n");
    }
    if plates.len() > SHOWN {
        let _ = writeln!(
            out,
            "<p class=\"note\">{} further readings are in the log.</p>",
            plates.len() - SHOWN
        );
    }
}

fn figure(out: &mut String, plate: &PlateFrame) {
    let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
    let corners: Vec<String> = plate
        .corners
        .iter()
        .map(|[x, y]| format!("{:.1},{:.1}", finite(*x), finite(*y)))
        .collect();
    let text = escape(&plate.text);
    let _ = writeln!(
        out,
        "<figure><div class=\"frame\"><img alt=\"Camera frame, plate read as {text}\" width=\"{w}\" height=\"{h}\" \
         src=\"data:image/jpeg;base64,{data}\"><svg viewBox=\"0 0 {w} {h}\" aria-hidden=\"true\">\
         <polygon class=\"halo\" points=\"{points}\"/><polygon points=\"{points}\"/></svg></div>\
         <figcaption><b>“{text}”</b> <span>{confidence:.0} %</span> <span>{time:.1} s</span></figcaption></figure>",
        w = plate.width,
        h = plate.height,
        data = STANDARD.encode(&plate.jpeg),
        points = corners.join(" "),
        confidence = finite(plate.confidence) * 100.0,
        time = plate.time.seconds(),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn a_long_episode_keeps_its_report_light() {
        let plate = PlateFrame {
            jpeg: vec![0xff, 0xd8],
            width: 640,
            height: 480,
            time: SimTime::from_millis(1500),
            text: "Unit <1>".into(),
            confidence: 0.9,
            corners: [[1.0, 2.0], [f32::NAN, 2.0], [3.0, 4.0], [1.0, 4.0]],
        };
        let mut out = String::new();
        render(&mut out, &vec![plate; 20]);
        assert_eq!(out.matches("<figure>").count(), SHOWN);
        assert!(out.contains("8 further readings") && out.contains("data:image/jpeg;base64,/9g="));
        assert!(!out.contains("NaN") && !out.contains("<1>"));
    }
}
