//! Means over several runs and differences between systems, as plain text.

use std::fmt::Write;

use crate::plural::count;
use crate::score::across::comparison::{Compared, Difference, Row, SuccessTest};
use crate::score::across::means::Mean;
use crate::score::across::paired::lowest_p;
use crate::score::across::{ClusteredBy, Comparison, Means, Unit};

/// Width of the names of measures, columns.
const NAME_COLUMNS: usize = 20;
/// Below this p-value a difference counts as found.
const LEVEL: f64 = 0.05;
/// Runs whose own values are shown.
const RUNS_SHOWN: usize = 5;

/// The systems of a comparison, and a table of differences for each but the first.
pub fn comparison_table(comparison: &Comparison) -> String {
    let mut out = String::new();
    for (number, system) in comparison.systems.iter().enumerate() {
        let _ = write!(out, "{}  ", letter(number));
        heading(&mut out, system);
    }
    if comparison.systems.len() == 1 {
        out.push('\n');
        means_alone(&mut out, comparison);
    }
    for other in 1..comparison.systems.len() {
        out.push('\n');
        differences(&mut out, comparison, other);
        success(&mut out, comparison, other);
    }
    out.push('\n');
    if comparison.systems.len() > 1 {
        let _ = writeln!(out, "{}", clustering(comparison.clustered_by));
    }
    to_tell(&mut out, comparison);
    out
}

/// Name, agent and runs of a system, and what has to be known before any number.
fn heading(out: &mut String, system: &Compared) {
    let suites: Vec<&str> = system.suites.iter().map(String::as_str).collect();
    let _ = writeln!(
        out,
        "{}: {}, {} of {}",
        system.name,
        system.agent,
        count(system.runs, "run", "runs"),
        suites.join(", ")
    );
    for departure in &system.departures {
        let _ = writeln!(out, "   {departure}");
    }
    if system.silent_divergences > 0 {
        let episodes = count(system.silent_divergences, "episode", "episodes");
        let _ = writeln!(
            out,
            "   warning: the pose was wrong by more than 1 m while the agent reported good health, \
             in {episodes}"
        );
    }
}

/// The letter by which a table names a system.
fn letter(number: usize) -> String {
    char::from_digit(number as u32 + 10, 36).map_or_else(
        || format!("#{number}"),
        |letter| letter.to_ascii_uppercase().to_string(),
    )
}

fn means_alone(out: &mut String, comparison: &Comparison) {
    for row in &comparison.measures {
        let value = shown(row.means[0], row.unit);
        let _ = writeln!(out, "{:<NAME_COLUMNS$} {value:>10}", row.name);
    }
}

fn differences(out: &mut String, comparison: &Comparison, other: usize) {
    let letter = letter(other);
    let _ = writeln!(
        out,
        "{:<NAME_COLUMNS$} {:>10} {letter:>10} {:>10}  {:<20} {:>6}",
        "",
        "A",
        format!("{letter} - A"),
        "95 % interval",
        "pairs"
    );
    for row in &comparison.measures {
        let line = difference_line(row, other);
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

fn difference_line(row: &Row, other: usize) -> String {
    let means = [row.means[0], row.means[other]].map(|mean| shown(mean, row.unit));
    let [first, second] = means;
    let (difference, interval, pairs) = match row.differences[other - 1] {
        Some(difference) => described(difference, row.unit),
        None => ("–".to_owned(), String::new(), String::new()),
    };
    format!(
        "{:<NAME_COLUMNS$} {first:>10} {second:>10} {difference:>10}  {interval:<20} {pairs:>6}",
        row.name
    )
}

/// Difference, interval and number of pairs.
fn described(difference: Difference, unit: Unit) -> (String, String, String) {
    let decimals = decimals(unit);
    let scaled = |value: f64| format!("{:+.decimals$}", value * scale(unit));
    let bounds = difference.interval.map_or_else(
        || "–".to_owned(),
        |[low, high]| format!("[{}, {}]", scaled(low), scaled(high)),
    );
    (
        scaled(difference.mean),
        bounds,
        difference.pairs.to_string(),
    )
}

fn success(out: &mut String, comparison: &Comparison, other: usize) {
    let Some(test) = comparison.tests.get(other - 1).filter(|t| t.pairs > 0) else {
        return;
    };
    let letter = letter(other);
    let _ = write!(
        out,
        "{:<NAME_COLUMNS$} only A succeeded {} times, only {letter} {} times: McNemar p = {}",
        "sr_2m",
        test.only_first,
        test.only_other,
        probability(test.p)
    );
    if comparison.tests.len() > 1 {
        let _ = write!(out, ", Holm {}", probability(test.p_holm));
    }
    out.push('\n');
    if let Some(needed) = more_clusters(test, comparison.tests.len()) {
        let (one, many) = match comparison.clustered_by {
            ClusteredBy::World => ("world", "worlds"),
            ClusteredBy::Episode => ("episode", "episodes"),
        };
        let _ = writeln!(
            out,
            "{:<NAME_COLUMNS$} {} cannot show a difference at 5 %; it takes {needed} at least",
            "",
            count(test.clusters, one, many)
        );
    }
}

/// The number of clusters from which on the best of `tests` tests can find a difference at 5 %;
/// `None` if this one has as many.
fn more_clusters(test: &SuccessTest, tests: usize) -> Option<usize> {
    // Holm multiplies the lowest p by the number of tests.
    let can_find = |clusters| lowest_p(clusters) * tests as f64 <= LEVEL;
    (test.clusters + 1..)
        .find(|clusters| can_find(*clusters))
        .filter(|_| !can_find(test.clusters))
}

fn probability(p: f64) -> String {
    if p < 0.001 {
        "below 0.001".to_owned()
    } else {
        format!("{p:.3}")
    }
}

fn clustering(by: ClusteredBy) -> &'static str {
    match by {
        ClusteredBy::World => "Intervals are for other worlds: whole worlds are resampled.",
        ClusteredBy::Episode => {
            "Intervals are for other episodes in these worlds: with fewer than five worlds, whole\n\
             episodes are resampled."
        }
    }
}

fn to_tell(out: &mut String, comparison: &Comparison) {
    let Some(needed) = comparison.to_tell else {
        return;
    };
    let _ = writeln!(
        out,
        "A difference of {:.1} points in sr_2m is found with 80 % probability in {} single \
         deliveries,\nif {:.0} % of them end differently. They are taken as independent: those of \
         one world\nor of one episode with several seeds count for less.",
        100.0 * needed.difference,
        needed.pairs,
        100.0 * needed.disagreement
    );
}

/// Means over runs, with the value of each of the first few.
pub fn means_table(means: &Means) -> String {
    let mut out = String::new();
    heading(&mut out, &means.system);
    out.push('\n');
    let shown_seeds = means.seeds.iter().take(RUNS_SHOWN);
    let heads: String = shown_seeds
        .map(|seed| format!(" {:>9}", format!("seed {seed}")))
        .collect();
    let _ = writeln!(
        out,
        "{:<NAME_COLUMNS$} {:>9}  {:<16}{heads}",
        count(means.seeds.len(), "run", "runs"),
        "mean",
        "95 % interval"
    );
    for mean in &means.measures {
        let _ = writeln!(out, "{}", mean_line(mean).trim_end());
    }
    let _ = writeln!(out, "{}", clustering(means.clustered_by));
    out
}

fn mean_line(mean: &Mean) -> String {
    let interval = mean.interval.map_or_else(
        || "–".to_owned(),
        |[low, high]| {
            let (scale, decimals) = (scale(mean.unit), decimals(mean.unit));
            format!("[{:.decimals$}, {:.decimals$}]", low * scale, high * scale)
        },
    );
    let runs = mean.runs.iter().take(RUNS_SHOWN);
    let runs: String = runs
        .map(|value| format!(" {:>9}", shown(*value, mean.unit)))
        .collect();
    format!(
        "{:<NAME_COLUMNS$} {:>9}  {interval:<16}{runs}",
        mean.name,
        shown(Some(mean.mean), mean.unit)
    )
}

fn shown(value: Option<f64>, unit: Unit) -> String {
    let Some(value) = value else {
        return "–".to_owned();
    };
    match unit {
        Unit::Share => format!("{:.1} %", 100.0 * value),
        Unit::Count => format!("{value:.2}"),
        Unit::Seconds => format!("{value:.1} s"),
    }
}

/// Decimals of a number that is shown.
fn decimals(unit: Unit) -> usize {
    match unit {
        Unit::Count => 2,
        Unit::Share | Unit::Seconds => 1,
    }
}

/// From a value to the number that is shown.
fn scale(unit: Unit) -> f64 {
    match unit {
        Unit::Share => 100.0,
        Unit::Count | Unit::Seconds => 1.0,
    }
}
