//! The table of deliveries.

use std::fmt::Write;

use super::html::{escape, number};
use crate::score::results::{DeliveryResult, Results};

/// Writes one row per delivery.
pub fn render(out: &mut String, results: &Results) {
    if results.deliveries.is_empty() {
        return;
    }
    out.push_str(HEAD);
    for delivery in &results.deliveries {
        row(out, delivery);
    }
    out.push_str("</tbody>\n</table>\n</div>\n</section>\n");
}

const HEAD: &str = "<section>\n<h2>Deliveries</h2>\n<div class=\"scroll\">\n<table>\n<thead>\n\
    <tr><th>Episode</th><th>Delivery</th><th class=\"c\">Paper</th><th class=\"c\">Strict</th>\
    <th class=\"c\">Unit</th><th class=\"n\">To door<small>m</small></th>\
    <th class=\"n\">Driven<small>m</small></th><th class=\"n\">Shortest<small>m</small></th>\
    <th class=\"n\">Time<small>s</small></th><th class=\"n\">Pose error<small>m</small></th>\
    <th class=\"n\">Plates<small>read</small></th><th class=\"n\">Collisions</th>\
    <th>Failure</th></tr>\n</thead>\n<tbody>\n";

fn row(out: &mut String, d: &DeliveryResult) {
    let _ = write!(
        out,
        "<tr><td><a href=\"#episode-{0}\">{0}</a><span class=\"task\">.{1}</span></td>\
         <td>{2}</td>{3}{4}{5}",
        d.episode,
        d.task,
        escape(&d.address().to_string()),
        verdict(d.success_10m),
        verdict(d.success_2m),
        verdict(d.correct_unit),
    );
    let numbers = [
        number(d.distance_to_door_m, 2),
        number(Some(d.path_m), 1),
        number(d.shortest_path_m, 1),
        number(Some(d.sim_seconds), 0),
        number(d.pose_error_m, 2),
        d.plates_read.to_string(),
    ];
    for value in numbers {
        let _ = write!(out, "<td class=\"n\">{value}</td>");
    }
    let class = if d.collisions > 0 { "n bad" } else { "n" };
    let _ = writeln!(
        out,
        "<td class=\"{class}\">{}</td><td class=\"cause\">{}</td></tr>",
        d.collisions,
        failure(d)
    );
}

fn verdict(success: bool) -> &'static str {
    if success {
        "<td class=\"c good\">✓ yes</td>"
    } else {
        "<td class=\"c bad\">✗ no</td>"
    }
}

fn failure(delivery: &DeliveryResult) -> String {
    let cause = delivery
        .failure
        .map(|f| format!("<b>{}</b>", escape(&f.to_string())));
    let detail = delivery
        .failure_detail
        .as_deref()
        .map(|d| format!("<small>{}</small>", escape(d)));
    [cause, detail].into_iter().flatten().collect()
}
