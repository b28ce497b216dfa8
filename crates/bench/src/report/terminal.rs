//! The results as plain text, at most 100 columns wide.

use std::fmt::Write;

use openbench_core::{Health, PlanPart};

use super::contacts;
use super::headline::{self, Headline};
use super::html::{interval_text, number, percent};
use crate::plural::{count, plural};
use crate::score::departures::departures;
use crate::score::results::{DeliveryResult, EpisodeResult, Metrics, Results};
use crate::score::stages::stage_sums;

/// Width of a line, columns of the terminal.
const LINE_COLUMNS: usize = 100;
/// What stands before a line that belongs to the row above it.
const UNDER_ROW: &str = "       ";
/// Largest width of an address, columns of the terminal.
const ADDRESS_COLUMNS: usize = 40;

/// A table with one row per delivery, followed by a summary of all metrics.
///
/// The columns 10 m and 2 m say whether the delivery succeeded by the paper's and by the strict
/// criterion; unit, whether no other door's approach point was nearer.
pub fn terminal_table(results: &Results) -> String {
    let mut out = String::new();
    for departure in departures(results) {
        named(&mut out, "note", &departure);
    }
    if !out.is_empty() {
        out.push('\n');
    }
    let addresses = results
        .deliveries
        .iter()
        .map(|d| text_columns(&d.address().to_string()));
    let longest = addresses.max().unwrap_or(0);
    let address_columns = longest.clamp("delivery".len(), ADDRESS_COLUMNS);
    out += &heading(address_columns);
    for delivery in &results.deliveries {
        row(&mut out, delivery, address_columns);
        failure(&mut out, delivery);
        models(&mut out, delivery);
        // Fallbacks are for a whole plan, which the first delivery stands for.
        let episode = results
            .episodes
            .iter()
            .find(|e| e.episode == delivery.episode);
        if let Some(episode) = episode.filter(|_| delivery.task == 0) {
            fallbacks(&mut out, episode);
        }
    }
    out.push('\n');
    summary(&mut out, &results.metrics);
    stages(&mut out, results);
    health(&mut out, results);
    named(&mut out, "targets", results.targets.description());
    if let Some(doors) = results.doors {
        named(&mut out, "doors", &doors.describe());
    }
    out
}

/// A line with a name in front; what is too long continues below.
fn named(out: &mut String, name: &str, text: &str) {
    const NAME_COLUMNS: usize = 9;
    wrapped(out, &pad(name, NAME_COLUMNS), text);
}

/// A text after a head; what is too long continues below, as far in as the head is long.
fn wrapped(out: &mut String, head: &str, text: &str) {
    let indent = text_columns(head);
    let mut line = head.to_owned();
    for word in text.split_whitespace() {
        // What a model answered may contain sequences that control a terminal.
        let word: String = word.chars().filter(|c| !c.is_control()).collect();
        let used = text_columns(&line);
        if used > indent && used + 1 + text_columns(&word) > LINE_COLUMNS {
            let _ = writeln!(out, "{line}");
            line = " ".repeat(indent);
        }
        if text_columns(&line) > indent {
            line.push(' ');
        }
        line.push_str(&word);
    }
    let _ = writeln!(out, "{}", line.trim_end());
}

/// The two lines above the rows; column widths as in [`row`].
fn heading(address_columns: usize) -> String {
    let first = format!(
        "{:>5}  {}  {:>4} {:>3} {:>4}  {:>6} {:>7} {:>8} {:>5} {:>6}",
        "",
        pad("", address_columns),
        "",
        "",
        "",
        "door",
        "path",
        "shortest",
        "time",
        "colli-",
    );
    let second = format!(
        "{:>5}  {}  {:>4} {:>3} {:>4}  {:>6} {:>7} {:>8} {:>5} {:>6}",
        "task",
        pad("delivery", address_columns),
        "10 m",
        "2 m",
        "unit",
        "(m)",
        "(m)",
        "path (m)",
        "(s)",
        "sions",
    );
    format!("{first}\n{second}\n")
}

fn row(out: &mut String, d: &DeliveryResult, address_columns: usize) {
    let mark = |success: bool| if success { "yes" } else { "no" };
    let line = format!(
        "{:>5}  {}  {:>4} {:>3} {:>4}  {:>6} {:>7} {:>8} {:>5} {:>6}",
        format!("{}.{}", d.episode, d.task),
        // Not a width of the format, which counts characters instead of columns.
        pad(&d.address().to_string(), address_columns),
        mark(d.success_10m),
        mark(d.success_2m),
        mark(d.correct_unit),
        number(d.distance_to_door_m, 2),
        number(Some(d.path_m), 1),
        number(d.shortest_path_m, 1),
        number(Some(d.sim_seconds), 0),
        d.collisions,
    );
    let _ = writeln!(out, "{line}");
}

/// Why a delivery failed; nothing if it did not.
fn failure(out: &mut String, d: &DeliveryResult) {
    let Some(cause) = d.failure else {
        return;
    };
    let detail = d.failure_detail.iter().filter(|detail| !detail.is_empty());
    let detail: String = detail.map(|detail| format!(": {detail}")).collect();
    wrapped(out, UNDER_ROW, &format!("{cause}{detail}"));
}

/// How often models were asked during a delivery; nothing if none was.
fn models(out: &mut String, d: &DeliveryResult) {
    if d.model_calls > 0 {
        let asked = count(d.model_calls as usize, "question", "questions");
        let failed = d.model_calls_failed;
        let _ = writeln!(out, "       {asked} to models, {failed} without an answer");
    }
}

/// The parts of a plan that another planner made.
fn fallbacks(out: &mut String, episode: &EpisodeResult) {
    for fallback in &episode.fallbacks {
        let part = match fallback.part {
            PlanPart::Addresses => "doors",
            PlanPart::Order => "order",
        };
        let line = format!(
            "{part} by the planner {}: {}",
            fallback.from, fallback.because
        );
        wrapped(out, UNDER_ROW, &line);
    }
}

/// A rate in percent with its interval, or a dash.
fn rate(m: &Metrics, Headline { key, value, .. }: Headline) -> String {
    let Some(value) = value else {
        return "–".to_owned();
    };
    let interval = m.intervals.get(key).copied().flatten();
    let interval = interval.map(|interval| format!(" [{}]", interval_text(&interval, "-")));
    format!("{} %{}", percent(value), interval.unwrap_or_default())
}

/// Lines with some metrics, at most `columns` in each; none without metrics.
fn rates(out: &mut String, m: &Metrics, name: &str, metrics: &[Headline], columns: usize) {
    // Narrow intervals have decimals, and fewer fit then.
    const CELL_COLUMNS: usize = 16;
    let cell = |metric: &Headline| {
        let rate = rate(m, *metric);
        let width = text_columns(&rate).max(CELL_COLUMNS);
        format!("  {} {}", metric.label, pad(&rate, width))
    };
    let (mut line, mut cells) = (format!("{name:<7}"), 0);
    for cell in metrics.iter().map(cell) {
        let width = text_columns(&line) + text_columns(cell.trim_end());
        if cells == columns || width > LINE_COLUMNS {
            let _ = writeln!(out, "{}", line.trim_end());
            (line, cells) = (format!("{:<7}", ""), 0);
        }
        line.push_str(&cell);
        cells += 1;
    }
    if cells > 0 {
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

fn summary(out: &mut String, m: &Metrics) {
    rates(out, m, "paper", &headline::paper(m), 4);
    rates(out, m, "strict", &headline::strict(m), 4);
    // Their labels are longer: four would not fit.
    rates(out, m, "member", &headline::members(m), 3);
    rates(out, m, "also", &headline::beside(m), 3);
    if let Some(sum) = m.localization {
        let _ = writeln!(
            out,
            "pose     error {:.3} m RMS, 95 % within {:.3} m, maximum {:.3} m, \
             largest jump {:.3} m",
            sum.rmse_m, sum.p95_m, sum.max_m, sum.max_jump_m
        );
    }
    let _ = writeln!(
        out,
        "drive    {:.1} m in {:.0} s of simulated time, {}{}",
        m.path_m,
        m.sim_seconds,
        m.real_time_factor.map_or(String::new(), |factor| format!(
            "real-time factor {factor:.1}, "
        )),
        collisions(m)
    );
    if !m.collisions_by_class.is_empty() {
        named(out, "contact", &contacts::by_class(m));
    }
    let _ = writeln!(out, "motion   {}", m.smoothness.describe(m.path_m));
    if let Some(encounters) = m.encounters {
        named(out, "traffic", &encounters.describe());
    }
}

/// What the agent did for how long, over all episodes.
fn stages(out: &mut String, results: &Results) {
    let sums = stage_sums(results.episodes.iter().flat_map(|episode| &episode.stages));
    if !sums.is_empty() {
        let parts = sums
            .iter()
            .map(|(stage, seconds)| format!("{seconds:.0} s {stage}"));
        named(out, "stages", &parts.collect::<Vec<_>>().join(", "));
    }
}

/// Seconds that the agent did not trust its pose, and the episodes in which it trusted a wrong one.
fn health(out: &mut String, results: &Results) {
    let spans = results.episodes.iter().flat_map(|e| &e.health);
    // Folded from +0, since the `sum()` of nothing is -0.
    let doubtful = spans
        .filter(|span| span.health != Health::Good)
        .fold(0.0, |all, span| all + (span.to_s - span.from_s));
    if doubtful > 0.0 {
        let _ = writeln!(out, "health   {doubtful:.1} s degraded or lost");
    }
    let silent = results.episodes.iter().filter(|episode| {
        episode
            .localization
            .is_some_and(|sum| sum.silent_divergences > 0)
    });
    let silent: Vec<String> = silent.map(|e| e.episode.to_string()).collect();
    if !silent.is_empty() {
        let text = format!(
            "the pose was wrong by more than 1 m while the agent reported good health, in {} {}",
            plural(silent.len(), "episode", "episodes"),
            silent.join(", ")
        );
        named(out, "warning", &text);
    }
}

/// Number of collisions, and the time in contact if there was any.
fn collisions(m: &Metrics) -> String {
    let events = count(m.collisions, "collision", "collisions");
    if m.contact_s > 0.0 {
        format!("{events} ({:.1} s in contact)", m.contact_s)
    } else {
        events
    }
}

/// `text` truncated or padded with spaces to `width` columns.
fn pad(text: &str, width: usize) -> String {
    let mut out = String::new();
    let mut used = 0;
    let all = text_columns(text);
    // A truncated text needs one column for the ellipsis.
    let room = if all > width { width - 1 } else { width };
    for c in text.chars().filter(|c| !c.is_control()) {
        if used + columns(c) > room {
            break;
        }
        out.push(c);
        used += columns(c);
    }
    if all > width {
        out.push('…');
        used += 1;
    }
    // Also after an ellipsis: a wide character may have left the last column free.
    out.extend(std::iter::repeat_n(' ', width.saturating_sub(used)));
    out
}

/// Columns of a text on a terminal.
fn text_columns(text: &str) -> usize {
    text.chars().map(columns).sum()
}

/// Columns of a character on a terminal: two for East Asian wide characters, recognized by the
/// large blocks of Unicode.
fn columns(c: char) -> usize {
    match c {
        c if c.is_control() => 0,
        '\u{1100}'..='\u{115f}'
        | '\u{2e80}'..='\u{a4cf}'
        | '\u{ac00}'..='\u{d7a3}'
        | '\u{f900}'..='\u{faff}' => 2,
        '\u{fe30}'..='\u{fe4f}'
        | '\u{ff00}'..='\u{ff60}'
        | '\u{1f300}'..='\u{1faff}'
        | '\u{20000}'..='\u{3fffd}' => 2,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::metrics::{LocalizationSum, RunTotals, summarize};
    use crate::score::results::tests::{delivery, results};
    use openbench_core::FailureCause;

    #[test]
    fn lines_fit_a_hundred_columns() {
        let mut failed = delivery(11, 4);
        failed.building = "非常长的建筑物名称第三号楼东侧".into();
        (failed.failure, failed.success_2m) = (Some(FailureCause::PlannerUnavailable), false);
        (failed.path_m, failed.distance_to_door_m) = (1234.5, None);
        failed.failure_detail = Some("the model answered \u{1b}[2J nonsense ".repeat(9));
        let mut long = delivery(12, 0);
        long.building = "Max-Mustermann-Gedächtnis-Straße 12345 a".into();
        let mut results = results(vec![delivery(0, 0), failed, long]);
        // Enough singles and sequences for intervals everywhere.
        let more = (1..20).flat_map(|episode| (0..episode % 3).map(move |task| (episode, task)));
        let more = more.map(|(episode, task)| delivery(episode, task));
        let others = more.filter(|d| ![11, 12].contains(&d.episode));
        results.deliveries.extend(others);
        results.metrics = summarize(&results.deliveries, &RunTotals::default());
        let table = terminal_table(&results);
        for line in table.lines() {
            let width: usize = line.chars().map(columns).sum();
            assert!(width <= 100, "{width}: {line}");
        }
        assert!(table.contains("  0.0  unit1, building3"), "{table}");
        let failure = "       planner failed: the model answered [2J nonsense";
        assert_eq!(table.matches("nonsense").count(), 9, "the whole detail");
        assert!(table.contains(failure), "{table}");
        assert!(table.contains("Gedächtnis-Straße…"), "{table}");
        assert!(table.contains("strict   SR 90.0 % ["), "{table}");
        assert!(table.contains("member   paper SR 100.0 % ["), "{table}");
    }

    #[test]
    fn what_is_too_long_for_a_line_continues_below() {
        let mut out = String::new();
        named(&mut out, "note", &"nine more ".repeat(12));
        let lines: Vec<&str> = out.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("note     nine more nine") && lines[0].len() <= 100);
        assert!(lines[1].starts_with("         nine") || lines[1].starts_with("         more"));
        // A word that is longer than a line stays whole.
        out.clear();
        named(&mut out, "note", &"x".repeat(200));
        assert_eq!(out.lines().count(), 1);
    }

    #[test]
    fn a_narrow_interval_is_shown_whole_with_a_decimal() {
        let mut results = results(vec![delivery(0, 0)]);
        let metrics = &mut results.metrics;
        for (key, value) in [
            ("sr_2m", &mut metrics.sr_2m),
            ("spl", &mut metrics.spl),
            ("lsr", &mut metrics.lsr),
            ("lspl", &mut metrics.lspl),
        ] {
            *value = Some(0.998);
            metrics
                .intervals
                .insert(key.to_owned(), Some([0.9961, 0.9999]));
        }
        let table = terminal_table(&results);
        assert!(table.contains("SPL 99.8 % [99.6-100.0]"), "{table}");
        assert!(
            table.lines().all(|line| text_columns(line) <= 100),
            "{table}"
        );
    }

    #[test]
    fn a_silent_divergence_is_named_with_its_episode() {
        let silent = |silent_divergences| EpisodeResult {
            episode: 4,
            localization: Some(LocalizationSum {
                rmse_m: 1.5,
                p95_m: 2.0,
                max_m: 3.0,
                max_yaw_rad: 0.1,
                max_jump_m: 0.1,
                silent_divergences,
            }),
            ..EpisodeResult::default()
        };
        let warned = |divergences| {
            let mut results = results(vec![delivery(4, 0)]);
            results.episodes = vec![silent(divergences)];
            let table = terminal_table(&results);
            let warning = table.lines().find(|line| line.starts_with("warning"));
            warning.map(str::to_owned)
        };
        assert_eq!(warned(0), None);
        let warning = warned(2).unwrap();
        assert!(
            warning.contains("good health") && warning.ends_with("episode 4"),
            "{warning}"
        );
    }

    #[test]
    fn wide_characters_take_two_columns() {
        assert_eq!(pad("楼ab", 5), "楼ab ");
        assert_eq!(pad("楼楼楼", 5), "楼楼…");
        assert_eq!(pad("abc", 2), "a…");
    }
}
