//! Reports for people: `report.html`, one file without external resources in light or dark
//! colours, and the table for a terminal.
//!
//! | module | content |
//! |---|---|
//! | `input` | [`ReportInput`]: the input of a report |
//! | `from_run` | [`report_input`]: that input from results and traces |
//! | `html` | escaping and formatting of numbers |
//! | `headline` | the headline metrics by both criteria |
//! | `tiles` | these with their intervals, side by side |
//! | `reference` | what others achieve in the same suite |
//! | `contacts` | collisions by class, in words |
//! | `table` | one row per delivery |
//! | `map` | the map of an episode, as SVG |
//! | `public_map` | [`public_map_svg`]: a wrong public map over the world, as SVG |
//! | `comparisons` | how the agent found itself on its map |
//! | `stages` | what the agent did over time |
//! | `drift` | the localization error over time |
//! | `frames` | the camera frames in which plates were read |
//! | `across` | means over several runs and differences between systems, as plain text |
//! | `terminal` | the same metrics as plain text for a terminal |

mod across;
mod comparisons;
mod contacts;
mod drift;
mod frames;
mod from_run;
mod headline;
mod html;
mod input;
mod map;
mod public_map;
mod reference;
mod stages;
mod table;
mod terminal;
mod tiles;

use std::fmt::Write;

use openbench_core::{Fallback, PlanPart};

use crate::plural::count;
use crate::score::departures::departures;
use crate::score::results::{EpisodeResult, Results};
pub use across::{comparison_table, means_table};
pub use from_run::report_input;
use html::escape;
pub use input::{Declaration, DoorMark, EpisodeReport, MapArea, PlateFrame, ReportInput, WorldMap};
pub use public_map::public_map_svg;
pub use terminal::terminal_table;

const STYLE: &str = include_str!("style.css");

// `write!` to a string cannot fail, so its result is ignored throughout this folder.

/// Renders the whole report as HTML.
pub fn render(input: &ReportInput<'_>) -> String {
    let results = input.results;
    let title = escape(&format!("{} · {}", results.suite, results.agent));
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title} · OpenBench</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n"
    );
    header(&mut out, input);
    notes(&mut out, results);
    tiles::render(&mut out, results);
    table::render(&mut out, results);
    out.push_str("<section>\n<h2>Episodes</h2>\n");
    if input
        .episodes
        .iter()
        .any(|e| has_failed(results, e.episode))
    {
        out.push_str("<p class=\"note\">Those with failures come first.</p>\n");
    }
    map::legend(&mut out, &input.episodes);
    let mut episodes: Vec<&EpisodeReport> = input.episodes.iter().collect();
    // Stable: otherwise in the order of the suite.
    episodes.sort_by_key(|e| !has_failed(results, e.episode));
    for episode in episodes {
        render_episode(&mut out, input, episode);
    }
    out.push_str("</section>\n");
    reproduction(&mut out, input);
    out.push_str("</main>\n</body>\n</html>\n");
    out
}

/// Whether a delivery of an episode failed by the strict criterion.
fn has_failed(results: &Results, episode: usize) -> bool {
    let deliveries = &results.deliveries;
    deliveries
        .iter()
        .any(|d| d.episode == episode && !d.success_2m)
}

fn header(out: &mut String, input: &ReportInput<'_>) {
    let results = input.results;
    let _ = write!(
        out,
        "<header>\n<p class=\"kicker\">OpenBench report</p>\n<h1>{}</h1>\n\
         <p class=\"facts\">agent <b>{}</b> · seed <b>{}</b> · version <b>{}</b> · \
         {} in {} · targets {}</p>\n</header>\n",
        escape(&results.suite),
        escape(&results.agent),
        results.seed,
        escape(&results.version),
        count(results.deliveries.len(), "delivery", "deliveries"),
        count(html::episode_count(results), "episode", "episodes"),
        results.targets.description(),
    );
}

/// What the reader has to know before any number.
fn notes(out: &mut String, results: &Results) {
    let departures = departures(results);
    if departures.is_empty() {
        return;
    }
    out.push_str("<section class=\"departures\">\n<h2>Departures from the defaults</h2>\n<ul>\n");
    for line in departures {
        let _ = writeln!(out, "<li>{}</li>", escape(&line));
    }
    out.push_str("</ul>\n</section>\n");
}

fn render_episode(out: &mut String, input: &ReportInput<'_>, episode: &EpisodeReport) {
    let deliveries: Vec<_> = input
        .results
        .deliveries
        .iter()
        .filter(|d| d.episode == episode.episode)
        .collect();
    // All deliveries of an episode have its instruction, so the first one is enough.
    let instruction = deliveries.first().map_or("", |d| d.instruction.trim());
    let succeeded = deliveries.iter().filter(|d| d.success_2m).count();
    let _ = write!(
        out,
        "<article id=\"episode-{0}\">\n<h3>Episode {0}<span class=\"score\">\
         {succeeded} of {1} succeeded (strict)</span></h3>\n<blockquote>{2}</blockquote>\n",
        episode.episode,
        deliveries.len(),
        escape(instruction),
    );
    plan(out, episode);
    let result = input.results.episodes.get(episode.episode);
    if let Some(result) = result {
        fallbacks(out, result);
    }
    if let Some(world) = input.worlds.get(episode.world) {
        map::render(out, world, episode);
    }
    if let Some(world) = input.worlds.get(episode.world) {
        comparisons::render(out, world, &episode.comparisons);
    }
    if let Some(result) = result {
        stages::render(out, &result.stages);
    }
    drift::render(out, episode);
    frames::render(out, &episode.plates);
    out.push_str("</article>\n");
}

fn plan(out: &mut String, episode: &EpisodeReport) {
    if episode.plan.is_empty() {
        return;
    }
    out.push_str("<p class=\"plan\"><span>Plan</span> ");
    for (i, delivery) in episode.plan.iter().enumerate() {
        let problem = delivery
            .problem
            .as_deref()
            .map(|p| format!(" <em class=\"bad\">({})</em>", escape(p)));
        let arrow = if i > 0 { " → " } else { "" };
        let address = escape(&delivery.address().to_string());
        let _ = write!(
            out,
            "{arrow}{} to {address}{}",
            escape(&delivery.item),
            problem.unwrap_or_default()
        );
    }
    out.push_str("</p>\n");
}

/// The parts of the plan that another planner made, and why.
fn fallbacks(out: &mut String, episode: &EpisodeResult) {
    for Fallback {
        part,
        from,
        because,
    } in &episode.fallbacks
    {
        let part = match part {
            PlanPart::Addresses => "doors were chosen",
            PlanPart::Order => "order was chosen",
        };
        let _ = writeln!(
            out,
            "<p class=\"plan bad\">The {part} by the planner {}: {}</p>",
            escape(from),
            escape(because)
        );
    }
}

fn reproduction(out: &mut String, input: &ReportInput<'_>) {
    let results = input.results;
    out.push_str("<section>\n<h2>Settings</h2>\n<dl class=\"settings\">\n");
    let fixed = [
        ("suite", results.suite.clone()),
        ("agent", results.agent.clone()),
        ("seed", results.seed.to_string()),
    ];
    let build = &results.provenance.build;
    let made = [
        ("commit", build.commit.clone()),
        ("program (BLAKE3)", shortened(&build.program)),
        ("platform", build.target.clone()),
        (
            "world (BLAKE3)",
            shortened(&results.provenance.hashes.world),
        ),
        ("map (BLAKE3)", shortened(&results.provenance.hashes.map)),
    ];
    let set = results.settings.iter().map(|(key, setting)| {
        let mark = if setting.default { " (default)" } else { "" };
        (key.as_str(), format!("{}{mark}", setting.value))
    });
    for (key, value) in fixed.into_iter().chain(set).chain(made) {
        let _ = writeln!(
            out,
            "<div><dt>{}</dt><dd>{}</dd></div>",
            escape(key),
            escape(&value)
        );
    }
    let _ = write!(
        out,
        "</dl>\n<h2>How to reproduce</h2>\n<p>With version {} of OpenBench:</p>\n\
         <pre><code>{}</code></pre>\n",
        escape(&results.version),
        escape(&input.command),
    );
    out.push_str("<h2>How to read the numbers</h2>\n");
    out.push_str(READING);
    if !results.attribution.is_empty() {
        out.push_str("<h2>Attribution</h2>\n<ul class=\"attribution\">\n");
        for line in &results.attribution {
            let _ = writeln!(out, "<li>{}</li>", escape(line));
        }
        out.push_str("</ul>\n");
    }
    out.push_str("</section>\n");
}

/// The first digits of a hash, which tell two files apart for people.
fn shortened(hash: &str) -> String {
    hash.chars().take(16).collect()
}

const READING: &str = "<p class=\"note\">SR is the share of successful single deliveries. \
    SPL weights each success by the ratio of the shortest path to the driven path. \
    LSR and LSPL are the same over sequences, where earlier deliveries have larger weights. \
    <b>Paper</b>: declared within 10 m of the plate; the shortest path is a straight line. \
    <b>Strict</b>: declared within 2 m of the correct door's approach point and closer to it than \
    to any other door's; the shortest path is the one that the robot can drive. \
    Intervals are 95 %: Wilson for rates, bootstrap by episode for means, none below five \
    episodes.</p>\n";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::provenance::Setting;
    use crate::score::results::tests::{delivery, results};
    use openbench_core::{MapPoint, Pose2};

    fn world() -> WorldMap {
        let outline =
            [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (0.0, 5.0)].map(|(x, y)| MapPoint::new(x, y));
        WorldMap {
            buildings: vec![MapArea {
                name: Some("<b>uilding3".into()),
                outline: outline.to_vec(),
                holes: vec![],
            }],
            ..WorldMap::default()
        }
    }

    fn episode() -> EpisodeReport {
        EpisodeReport {
            start: Pose2::new(-5.0, -5.0, 0.0),
            driven: vec![MapPoint::new(-5.0, -5.0), MapPoint::new(2.0, -1.0)],
            ..EpisodeReport::default()
        }
    }

    #[test]
    fn text_from_users_is_escaped() {
        let mut hostile = delivery(0, 0);
        hostile.instruction = "<script>alert(1)</script>".into();
        hostile.failure_detail = Some("\"><img src=x>".into());
        let mut results = results(vec![hostile]);
        results.suite = "a<b".into();
        results
            .settings
            .insert("<k>".into(), Setting::new("<v>", ""));
        results.attribution.push("© <OSM>".into());
        let input = ReportInput {
            results: &results,
            command: "run <x>".into(),
            worlds: vec![world()],
            episodes: vec![episode()],
        };
        let html = render(&input);
        for raw in [
            "<script",
            "<img src=x",
            "a<b",
            "<k>",
            "<v>",
            "<OSM>",
            "run <x>",
            "<b>uilding",
        ] {
            assert!(!html.contains(raw), "{raw}");
        }
        assert!(html.contains("&lt;script&gt;"));
    }

    #[test]
    fn the_report_loads_no_external_resource() {
        let results = results(vec![delivery(0, 0)]);
        let input = ReportInput {
            results: &results,
            command: String::new(),
            worlds: vec![world()],
            episodes: vec![episode()],
        };
        let html = render(&input);
        for remote in ["http://", "https://", "<link", "<script", "@import", "url("] {
            assert!(!html.contains(remote), "{remote}");
        }
    }

    #[test]
    fn episodes_with_failures_come_first() {
        let mut deliveries: Vec<_> = (0..3).map(|episode| delivery(episode, 0)).collect();
        deliveries[1].success_2m = false;
        let results = results(deliveries);
        let numbered = |episode| EpisodeReport {
            episode,
            ..self::episode()
        };
        let input = ReportInput {
            results: &results,
            command: String::new(),
            worlds: vec![world()],
            episodes: (0..3).map(numbered).collect(),
        };
        let html = render(&input);
        let places = [1, 0, 2].map(|number| html.find(&format!("id=\"episode-{number}\"")));
        assert!(places.is_sorted() && places[0].is_some(), "{places:?}");
        assert!(html.contains("Those with failures come first."));
        assert_eq!(
            html.matches("class=\"legend\"").count(),
            1,
            "one for all maps"
        );
    }

    #[test]
    fn a_run_without_deliveries_has_a_report() {
        let results = results(vec![]);
        let input = ReportInput {
            results: &results,
            command: String::new(),
            worlds: vec![],
            episodes: vec![EpisodeReport::default()],
        };
        assert!(render(&input).ends_with("</html>\n"));
    }
}
