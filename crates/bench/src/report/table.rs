//! The table of deliveries.

use std::fmt::Write;

use super::html::{escape, number};
use crate::score::results::{DeliveryResult, Results};

/// Writes one row per delivery.
pub fn render(out: &mut String, results: &Results) {
    if results.deliveries.is_empty() {
        return;
    }
    let asks_models = results.models.is_some();
    head(out, asks_models);
    let mut deliveries: Vec<&DeliveryResult> = results.deliveries.iter().collect();
    // Failures first. Stable: otherwise in the order in which they ended.
    deliveries.sort_by_key(|delivery| delivery.success_2m);
    for delivery in deliveries {
        row(out, delivery, asks_models);
    }
    out.push_str("</tbody>\n</table>\n</div>\n</section>\n");
}

fn head(out: &mut String, asks_models: bool) {
    out.push_str(HEAD);
    if asks_models {
        out.push_str("<th class=\"n\">Models<small>asked</small></th>");
    }
    out.push_str("<th>Failure</th></tr>\n</thead>\n<tbody>\n");
}

const HEAD: &str = "<section>\n<h2>Deliveries</h2>\n<div class=\"scroll\">\n<table>\n<thead>\n\
    <tr><th>Episode</th><th>Delivery</th><th class=\"c\">Paper</th><th class=\"c\">Strict</th>\
    <th class=\"c\">Unit</th><th class=\"n\">To door<small>m</small></th>\
    <th class=\"n\">Driven<small>m</small></th><th class=\"n\">Shortest<small>m</small></th>\
    <th class=\"n\">Time<small>s</small></th><th class=\"n\">Pose error<small>m</small></th>\
    <th class=\"n\">Plates<small>read</small></th><th class=\"n\">Collisions</th>";

fn row(out: &mut String, d: &DeliveryResult, asks_models: bool) {
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
    let _ = write!(out, "<td class=\"{class}\">{}</td>", d.collisions);
    if asks_models {
        models(out, d);
    }
    let _ = writeln!(out, "<td class=\"cause\">{}</td></tr>", failure(d));
}

/// How often models were asked, and how often in vain.
fn models(out: &mut String, d: &DeliveryResult) {
    let _ = write!(out, "<td class=\"n\">{}", d.model_calls);
    if d.model_calls_failed > 0 {
        let failed = d.model_calls_failed;
        let _ = write!(out, "<br><span class=\"bad\">{failed} in vain</span>");
    }
    out.push_str("</td>");
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
