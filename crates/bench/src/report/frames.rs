//! The camera frames in which plates were read, with the outline of the text drawn over them.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::html::escape;
use super::input::PlateFrame;
use crate::plural::count;

/// Frames shown at most, to keep the file small; the others are only counted.
const MAX_SHOWN: usize = 12;
/// Frames shown without unfolding.
const MAX_UNFOLDED: usize = 3;

/// Writes the frames in the given order.
pub fn render(out: &mut String, plates: &[PlateFrame]) {
    if plates.is_empty() {
        return;
    }
    let shown = &plates[..plates.len().min(MAX_SHOWN)];
    let (open, folded) = shown.split_at(shown.len().min(MAX_UNFOLDED));
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
    if plates.len() > MAX_SHOWN {
        let _ = writeln!(
            out,
            "<p class=\"note\">{} further readings are in the log.</p>",
            plates.len() - MAX_SHOWN
        );
    }
}

fn figure(out: &mut String, plate: &PlateFrame) {
    // Readers are extensions, too, and may report anything.
    let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
    let corners: Vec<String> = plate
        .corners
        .iter()
        .map(|[x, y]| format!("{:.1},{:.1}", finite(*x), finite(*y)))
        .collect();
    let text = escape(&plate.text);
    // The text is outlined twice: a wide dark line below the bright one, visible on any background.
    let _ = writeln!(
        out,
        "<figure><div class=\"frame\">\
         <img alt=\"Camera frame, plate read as {text}\" width=\"{w}\" height=\"{h}\" \
         src=\"data:image/jpeg;base64,{data}\"><svg viewBox=\"0 0 {w} {h}\" aria-hidden=\"true\">\
         <polygon class=\"halo\" points=\"{points}\"/><polygon points=\"{points}\"/></svg></div>\
         <figcaption><b>“{text}”</b> <span>{confidence:.0} %</span> <span>{time:.1} s</span>\
         </figcaption></figure>",
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
    fn the_report_of_a_long_episode_stays_small() {
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
        assert_eq!(out.matches("<figure>").count(), MAX_SHOWN);
        assert!(out.contains("8 further readings") && out.contains("data:image/jpeg;base64,/9g="));
        assert!(!out.contains("NaN") && !out.contains("<1>"));
    }
}
