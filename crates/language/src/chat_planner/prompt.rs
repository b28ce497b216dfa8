//! The prompts' gaps and what they are filled with.

use serde_json::Value;

use crate::PlanRequest;
use crate::arrange::travel_times;
use crate::gazetteer::Gazetteer;
use crate::grammar::evidence::Evidence;
use crate::order::UNKNOWN;
use crate::resolve::Stop;

/// The most names of the map in a prompt.
const MOST_NAMES: usize = 200;
/// The longest quotation of a name, in characters.
const LONGEST_NAME: usize = 80;

/// Fills each `{{gap}}` of a template once; what is filled in is not looked at again.
pub(super) fn fill(template: &str, values: &[(&str, &str)]) -> String {
    // By splitting the template, not by replacing in the result: an instruction with `{{names}}` in
    // it stays as it is.
    let mut pieces = template.split("{{");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (gap, rest) = piece.split_once("}}").unwrap_or(("", piece));
        let value = values.iter().find(|(name, _)| *name == gap);
        text.push_str(value.map_or("", |(_, value)| value));
        text.push_str(rest);
    }
    text
}

/// An instruction that cannot close the quotation marks of a prompt.
pub(super) fn without_marks(instruction: &str) -> String {
    instruction.replace("<<<", "<").replace(">>>", ">")
}

/// The map's names as JSON strings, those that the instruction seems to hold first.
pub(super) fn names(gazetteer: &Gazetteer, evidence: &Evidence) -> String {
    let said = evidence.places.iter().copied();
    let mut names: Vec<String> = Vec::new();
    for place in said.chain(0..gazetteer.places.len()) {
        let name = quoted(&gazetteer.places[place].name);
        if !names.contains(&name) {
            names.push(name);
        }
        if names.len() >= MOST_NAMES {
            break;
        }
    }
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

/// Stops, numbered from 1, a line each.
pub(super) fn stops(stops: &[Stop]) -> String {
    let line = |(i, stop): (usize, &Stop)| format!("{i}: {}", quoted(&stop.address.to_string()));
    (1..).zip(stops).map(line).collect::<Vec<_>>().join("\n")
}

/// Seconds from the start and each stop to each stop, a line each; `null` where unknown.
pub(super) fn times(request: &PlanRequest<'_>, stops: &[Stop]) -> String {
    let rows = travel_times(request, stops);
    let lines = rows.iter().enumerate().map(|(from, row)| {
        let label = if from == 0 {
            "start".to_owned()
        } else {
            from.to_string()
        };
        let cells: Vec<String> = row.iter().skip(1).map(|ms| seconds(*ms)).collect();
        format!("{label}: [{}]", cells.join(", "))
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn seconds(milliseconds: u64) -> String {
    if milliseconds >= UNKNOWN {
        "null".to_owned()
    } else {
        // Rounded up, so that different places are never no time apart.
        milliseconds.div_ceil(1000).to_string()
    }
}

fn quoted(name: &str) -> String {
    Value::String(name.chars().take(LONGEST_NAME).collect()).to_string()
}
