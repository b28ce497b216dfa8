//! How the agent found itself on its map: pictures of a few moments.

use std::fmt::Write;

use nalgebra::{Matrix2, SymmetricEigen};
use openbench_core::{AcceptedPose, Hypothesis, MapComparison, MapPoint, PlaceScores, Pose2};

use super::input::WorldMap;
use super::map::{View, draw_world};
use crate::trace::TimedComparison;

/// Side of a picture, pixels.
const SIDE_PX: f64 = 320.0;
/// Least and largest distance from the middle of a picture to its sides, metres.
const REACH_M: [f64; 2] = [30.0, 150.0];
/// Free ground around what is shown, metres.
const MARGIN_M: f64 = 12.0;
/// Less probable poses are not shown.
const SHOWN: f64 = 0.01;
/// Poses that are more probable than all others together.
const PROBABLE: f64 = 0.5;
/// Squared radius of an ellipse that holds 95 % of a normal distribution of two dimensions.
const CHI2_95: f64 = 5.991;
/// Places are the stronger the better they fit: the opacity of the best one,
const BEST_OPACITY: f64 = 0.8;
/// how fast it falls with the score,
const CONTRAST: i32 = 3;
/// and what is too weak to be seen.
const LEAST_OPACITY: f64 = 0.02;
/// Radius of an ellipse that is too small to be seen, pixels.
const LEAST_PX: f64 = 4.0;

/// Writes a row of pictures; nothing for an agent that never looked for itself.
pub fn render(out: &mut String, world: &WorldMap, comparisons: &[TimedComparison]) {
    let moments = moments(comparisons);
    if moments.is_empty() {
        return;
    }
    out.push_str("<h4>Where it found itself</h4>\n<div class=\"comparisons\">\n");
    for moment in moments {
        picture(out, world, moment);
    }
    out.push_str(
        "</div>\n<p class=\"note\">Ring: the true place. Dots: places where the robot may be, the \
         larger the more probable. Green: the accepted place with its ellipse of 95 %. Small \
         squares: facades that the robot saw, as they would lie on its map. Coloured ground: how \
         well each place fits what the robot saw, with its best heading, while it did not know \
         its place. Errors are those on the map as the robot has it.</p>\n",
    );
}

/// The first look, the first probable and the first accepted pose, the first loss, and the end.
fn moments(all: &[TimedComparison]) -> Vec<&TimedComparison> {
    let is_probable = |one: &TimedComparison| {
        let best = one.found.hypotheses.first();
        best.is_some_and(|best| best.probability >= PROBABLE)
    };
    let is_accepted = |one: &TimedComparison| one.found.accepted.is_some();
    let accepted = all.iter().position(is_accepted);
    let lost = accepted.and_then(|first| {
        let later = all[first..].iter().position(|one| !is_accepted(one))?;
        Some(first + later)
    });
    let mut chosen = vec![
        (!all.is_empty()).then_some(0),
        all.iter().position(is_probable),
        accepted,
        lost,
        all.len().checked_sub(1),
    ];
    chosen.sort();
    chosen.dedup();
    chosen.into_iter().flatten().map(|i| &all[i]).collect()
}

fn picture(out: &mut String, world: &WorldMap, moment: &TimedComparison) {
    let (truth, found) = (moment.truth.point(), &moment.found);
    let shown = |one: &&Hypothesis| one.probability >= SHOWN && is_finite(one.pose);
    let hypotheses: Vec<&Hypothesis> = found.hypotheses.iter().filter(shown).collect();
    let away = hypotheses
        .iter()
        .map(|one| one.pose.point().distance(truth));
    let farthest = away.fold(0.0, f64::max) + MARGIN_M;
    let reach = farthest.clamp(REACH_M[0], REACH_M[1]);
    let view = View::square(truth, reach, SIDE_PX);
    let caption = caption(moment);
    let _ = writeln!(
        out,
        "<figure><svg viewBox=\"0 0 {SIDE_PX} {SIDE_PX}\" role=\"img\" aria-label=\"{caption}\">\
         <rect class=\"ground\" width=\"{SIDE_PX}\" height=\"{SIDE_PX}\"/>"
    );
    draw_world(out, &view, world);
    if let Some(scores) = &found.places {
        places(out, &view, scores, SIDE_PX / (2.0 * reach));
    }
    let facades = found.facades.iter().map(|at| view.pixel(*at));
    // Agents may report anything, and SVG knows no NaN.
    for [x, y] in facades.filter(|at| at.iter().all(|value| value.is_finite())) {
        let _ = writeln!(
            out,
            "<rect class=\"facade\" x=\"{:.1}\" y=\"{:.1}\" width=\"2\" height=\"2\"/>",
            x - 1.0,
            y - 1.0
        );
    }
    for one in hypotheses {
        let [x, y] = view.pixel(one.pose.point());
        // The area of a dot is its probability.
        let radius = 1.5 + 7.0 * one.probability.clamp(0.0, 1.0).sqrt();
        let _ = writeln!(
            out,
            "<circle class=\"hypothesis\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" \
             fill-opacity=\"0.6\"><title>{:.0} %</title></circle>",
            100.0 * one.probability
        );
    }
    if let Some(accepted) = &found.accepted {
        ellipse(out, &view, accepted, SIDE_PX / (2.0 * reach));
    }
    let [x, y] = view.pixel(truth);
    let _ = writeln!(
        out,
        "<circle class=\"truth\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"9\"/></svg>\
         <figcaption>{caption}</figcaption></figure>"
    );
}

/// Colours the ground by how well it fits.
fn places(out: &mut String, view: &View, scores: &PlaceScores, pixels_per_metre: f64) {
    let PlaceScores {
        origin,
        cell_m,
        width,
        cells,
    } = scores;
    let side = cell_m * pixels_per_metre;
    for (cell, score) in cells.iter().enumerate() {
        let share = f64::from(*score).clamp(0.0, 100.0) / 100.0;
        let opacity = BEST_OPACITY * share.powi(CONTRAST);
        let (Some(row), Some(column)) = (cell.checked_div(*width), cell.checked_rem(*width)) else {
            return;
        };
        // The corner that is at the top and on the left in a picture.
        let north_west = MapPoint::new(
            origin.x + column as f64 * cell_m,
            origin.y + (row + 1) as f64 * cell_m,
        );
        let [x, y] = view.pixel(north_west);
        let is_seen = |at: f64| at > -side && at < SIDE_PX;
        // Nothing that is not finite is seen.
        if opacity >= LEAST_OPACITY && side.is_finite() && is_seen(x) && is_seen(y) {
            let _ = writeln!(
                out,
                "<rect class=\"place\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{side:.1}\" \
                 height=\"{side:.1}\" fill-opacity=\"{opacity:.2}\"/>"
            );
        }
    }
}

fn is_finite(pose: Pose2) -> bool {
    pose.x.is_finite() && pose.y.is_finite()
}

/// The ellipse of 95 % of an accepted pose.
fn ellipse(out: &mut String, view: &View, accepted: &AcceptedPose, pixels_per_metre: f64) {
    let [[xx, xy, _], [_, yy, _], _] = accepted.covariance;
    let [x, y] = view.pixel(accepted.pose.point());
    if ![x, y, xx, xy, yy].iter().all(|value| value.is_finite()) {
        return;
    }
    let eigen = SymmetricEigen::new(Matrix2::new(xx, xy, xy, yy));
    let radius = |variance: f64| {
        let metres = libm::sqrt(CHI2_95 * variance.max(0.0));
        (metres * pixels_per_metre).clamp(LEAST_PX, SIDE_PX)
    };
    let axis = eigen.eigenvectors.column(0);
    // The y axis of SVG points down.
    let turn = -libm::atan2(axis[1], axis[0]).to_degrees();
    let _ = writeln!(
        out,
        "<ellipse class=\"ellipse\" rx=\"{:.1}\" ry=\"{:.1}\" \
         transform=\"translate({x:.1} {y:.1}) rotate({turn:.1})\"/>",
        radius(eigen.eigenvalues[0]),
        radius(eigen.eigenvalues[1]),
    );
}

/// What a picture shows, in words.
fn caption(moment: &TimedComparison) -> String {
    let truth = moment.truth.point();
    let seconds = moment.time.seconds();
    let MapComparison {
        hypotheses,
        accepted,
        is_refused,
        ..
    } = &moment.found;
    match (accepted, hypotheses.first()) {
        (Some(accepted), _) if is_finite(accepted.pose) => format!(
            "{seconds:.0} s: {}, {:.1} m off",
            if *is_refused {
                "accepted before, and not confirmed"
            } else {
                "accepted"
            },
            accepted.pose.point().distance(truth)
        ),
        (None, Some(best)) if is_finite(best.pose) => format!(
            "{seconds:.0} s: none accepted; the best, with {:.0} %, is {:.1} m off; elsewhere, or \
             beside the map: {:.0} %",
            100.0 * best.probability,
            best.pose.point().distance(truth),
            100.0 * elsewhere(hypotheses)
        ),
        _ => format!("{seconds:.0} s: no place fits"),
    }
}

/// Probability that the robot is at none of the poses.
fn elsewhere(hypotheses: &[Hypothesis]) -> f64 {
    let at_one: f64 = hypotheses.iter().map(|one| one.probability).sum();
    (1.0 - at_one).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use openbench_core::{MapPoint, SimTime};

    use super::*;

    fn moment(seconds: u64, probability: f64, is_accepted: bool) -> TimedComparison {
        let pose = Pose2::new(3.0, 4.0, 0.1);
        TimedComparison {
            time: SimTime::from_millis(1000 * seconds),
            truth: Pose2::default(),
            found: MapComparison {
                hypotheses: vec![Hypothesis { pose, probability }],
                accepted: is_accepted.then_some(AcceptedPose {
                    pose,
                    covariance: [[4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.01]],
                }),
                is_refused: false,
                facades: Vec::new(),
                places: None,
            },
        }
    }

    #[test]
    fn the_moments_that_tell_the_story_are_shown() {
        let all = [
            moment(1, 0.2, false),
            moment(5, 0.3, false),
            moment(9, 0.7, false),
            moment(13, 0.9, false),
            moment(17, 0.99, true),
            moment(21, 0.99, true),
            moment(25, 0.1, false),
            moment(29, 0.99, true),
        ];
        let times = |all: &[TimedComparison]| -> Vec<u64> {
            let chosen = moments(all);
            chosen
                .iter()
                .map(|one| one.time.0 / 1_000_000_000)
                .collect()
        };
        assert_eq!(times(&all), [1, 9, 17, 25, 29]);
        assert_eq!(times(&all[4..5]), [17]);
        assert!(times(&[]).is_empty());
    }

    #[test]
    fn a_picture_has_all_that_was_found_and_no_nan() {
        let mut out = String::new();
        let mut broken = moment(17, 0.99, true);
        let nan = f64::NAN;
        broken.found.accepted.as_mut().unwrap().pose.x = nan;
        broken.found.hypotheses[0].pose.x = nan;
        broken.found.facades.push(MapPoint::new(nan, 0.0));
        let places = |cell_m: f64, width: usize| PlaceScores {
            origin: MapPoint::new(-2.0, -2.0),
            cell_m,
            width,
            cells: vec![-1, 0, 50, 100],
        };
        broken.found.places = Some(places(nan, 2));
        let mut first = moment(1, 0.6, false);
        first.found.places = Some(places(2.0, 2));
        let mut second = moment(9, 0.99, true);
        second.found.places = Some(places(2.0, 0));
        let all = [first, second, broken];
        render(&mut out, &WorldMap::default(), &all);
        assert_eq!(out.matches("<figure>").count(), 3);
        assert_eq!(out.matches("class=\"ellipse\"").count(), 1);
        // Variances of 4 and 1 m² at 320 px for 60 m.
        assert!(out.contains("rx=\"26.1\" ry=\"13.1\"") || out.contains("rx=\"13.1\" ry=\"26.1\""));
        // Only cells that fit at all are drawn, the best one in the north-east of four.
        assert_eq!(out.matches("class=\"place\"").count(), 2);
        assert!(out.contains(
            "x=\"160.0\" y=\"149.3\" width=\"10.7\" height=\"10.7\" fill-opacity=\"0.80\""
        ));
        assert!(out.contains("none accepted; the best, with 60 %, is 5.0 m off"));
        assert!(!out.contains("NaN"), "{out}");
    }
}
