//! Departures of a run from the defaults. A reader needs them to interpret its numbers.

use crate::plural::count;
use crate::score::results::{ComputingSum, Results};
use crate::suite::{GoalKind, TargetSource};

/// Of an agent that is charged for its work, and reports none.
const UNCHARGED: &str = "the agent's computing was not charged: it reports no work (agents in \
    Python and in other programs are charged by the clock with --realtime)";

/// The departures of a run, a line each; empty for a run with all defaults.
pub fn departures(results: &Results) -> Vec<String> {
    let mut lines = Vec::new();
    if results.targets == TargetSource::Planner {
        lines.push(
            "targets were read from the instructions by OPEN's grammar: where it errs, success \
             and SRTP are wrong"
                .to_owned(),
        );
    }
    if results.goal == GoalKind::Point {
        lines.push("the agent was told where the door is, and got no instruction".to_owned());
    }
    if results.provenance.uses_truth {
        lines.push("the agent was told what no robot can know: this run is a yardstick".to_owned());
    }
    for (key, setting) in results.settings.iter().filter(|(_, s)| !s.default) {
        lines.push(format!("setting {key}={}", setting.value));
    }
    if let Some(reason) = &results.provenance.cannot_repeat {
        lines.push(format!("nobody can check who made these results: {reason}"));
    }
    if let Some(memory) = &results.memory {
        let doors = count(memory.doors, "door", "doors");
        lines.push(format!("the agent knew {doors} from earlier runs"));
    }
    if results.sensors.gnss {
        lines.push("the robot has a GNSS receiver".to_owned());
    }
    let traffic = results.traffic;
    if !traffic.is_empty() {
        lines.push(format!(
            "traffic: {} and {}",
            count(traffic.pedestrians, "pedestrian", "pedestrians"),
            count(traffic.cars, "car", "cars")
        ));
    }
    let conditions = results.conditions.words();
    lines.extend(
        conditions
            .into_iter()
            .map(|word| format!("condition {word}")),
    );
    lines.extend(results.drawn_map.map(|map| map.describe()));
    lines.extend(computing(results));
    lines.extend(results.drawn_doors.map(|doors| doors.describe()));
    lines.extend(
        results
            .drawn_plates
            .as_ref()
            .map(|plates| plates.describe()),
    );
    lines.extend(
        results
            .drawn_scenery
            .as_ref()
            .map(|scenery| scenery.describe()),
    );
    lines.extend(unmapped(results));
    lines.extend(fallbacks(results));
    lines.extend(failed_calls(results));
    lines
}

/// How much time computing took, and how late decisions came.
fn computing(results: &Results) -> Option<String> {
    let sums = || results.episodes.iter().filter_map(|e| e.computing.as_ref());
    sums().next()?;
    let total = |value: fn(&ComputingSum) -> f64| sums().map(value).sum::<f64>();
    let driven: f64 = results.episodes.iter().map(|e| e.sim_seconds).sum();
    let latest = sums().map(|sum| sum.latest_s).fold(0.0, f64::max);
    let lost: u32 = sums().map(|sum| sum.lost_observations).sum();
    if total(|sum| sum.busy_s) == 0.0 {
        return Some(UNCHARGED.to_owned());
    }
    let by_clock = if total(|sum| sum.by_clock_s) > 0.0 {
        ", by the clock of the machine"
    } else {
        ""
    };
    Some(format!(
        "computing took {:.0} % of the time{by_clock}; decisions came up to {latest:.2} s late; \
         the robot stood {:.0} s for want of one; {} lost",
        100.0 * total(|sum| sum.busy_s) / driven.max(f64::MIN_POSITIVE),
        total(|sum| sum.held_up_s),
        count(lost as usize, "observation was", "observations were"),
    ))
}

/// The deliveries that the rates leave out.
fn unmapped(results: &Results) -> Option<String> {
    let unmapped = results.metrics.unmapped?;
    let rate = unmapped.sr_2m.unwrap_or_default();
    Some(format!(
        "{} to buildings that the map lacks or misnames: {:.0} % succeeded (strict); SR and SPL \
         are without them",
        count(unmapped.deliveries, "delivery", "deliveries"),
        100.0 * rate
    ))
}

/// The episodes of which another planner made a part.
fn fallbacks(results: &Results) -> Option<String> {
    let planned = results.episodes.iter().filter(|e| !e.fallbacks.is_empty());
    let numbers: Vec<String> = planned.map(|e| e.episode.to_string()).collect();
    (!numbers.is_empty()).then(|| {
        format!(
            "another planner made a part of the plan in {} of {} ({})",
            numbers.len(),
            count(results.episodes.len(), "episode", "episodes"),
            numbers.join(", ")
        )
    })
}

fn failed_calls(results: &Results) -> Option<String> {
    let used = results.models?;
    (used.failed > 0).then(|| {
        format!(
            "{} of {} got no answer",
            used.failed,
            count(
                used.calls as usize,
                "question to a model",
                "questions to models"
            )
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::provenance::Setting;
    use crate::score::results::tests::{delivery, results};
    use crate::score::results::{EpisodeResult, MemoryUse, ModelTotals, Unmapped};
    use crate::worlds::DrawnMap;
    use openbench_core::{Fallback, PlanPart};

    #[test]
    fn a_plain_run_has_none() {
        assert!(departures(&results(vec![delivery(0, 0)])).is_empty());
    }

    #[test]
    fn everything_that_changes_what_numbers_mean_is_named() {
        let mut run = results(vec![delivery(0, 0)]);
        run.targets = TargetSource::Planner;
        let set = |value: &str| Setting::new(value, "fused");
        run.settings.insert("localizer".into(), set("truth"));
        run.settings.insert("other".into(), set("fused"));
        run.provenance.uses_truth = true;
        run.provenance.cannot_repeat = Some("it waits for people".into());
        run.memory = Some(MemoryUse {
            doors: 3,
            hash: String::new(),
        });
        run.sensors.gnss = true;
        run.conditions.set("map", "poor").unwrap();
        run.drawn_map = Some(DrawnMap {
            buildings: 30,
            missing: 3,
            ..DrawnMap::default()
        });
        run.metrics.unmapped = Some(Unmapped {
            deliveries: 2,
            sr_2m: Some(0.5),
            ..Unmapped::default()
        });
        run.traffic.cars = 2;
        run.episodes = vec![EpisodeResult {
            fallbacks: vec![Fallback {
                part: PlanPart::Addresses,
                from: "grammar".into(),
                because: "no answer".into(),
            }],
            ..EpisodeResult::default()
        }];
        run.models = Some(ModelTotals {
            calls: 2,
            failed: 1,
            ..ModelTotals::default()
        });
        let all = departures(&run).join("\n");
        for part in [
            "grammar",
            "localizer=truth",
            "waits for people",
            "3 doors",
            "GNSS",
            "condition map=poor",
            "of 30 buildings, moved by 0.00 m more (root mean square), 3 missing",
            "2 deliveries to buildings that the map lacks or misnames: 50 % succeeded",
            "0 pedestrians and 2 cars",
            "in 1 of 1 episode (0)",
            "1 of 2 questions to models got no answer",
        ] {
            assert!(all.contains(part), "{part}: {all}");
        }
        assert!(!all.contains("fused"), "a default is no departure: {all}");
    }
}
