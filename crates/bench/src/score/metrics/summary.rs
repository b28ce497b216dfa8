//! All metrics over the deliveries of a run.

use std::collections::BTreeMap;
use std::ops::Add;

use super::collisions;
use super::encounters::EncounterSum;
use super::localization::LocalizationSum;
use super::path_ratio::spl;
use super::sequence::sequence_mean;
use super::srtp::Understood;
use super::values::{
    Value, by_episode, clean_success, correct_unit, paper_ratio, paper_success, strict_ratio,
    strict_success,
};
use crate::score::results::{DeliveryResult, Metrics, Unmapped};
use crate::score::statistics::{Proportion, mean_interval, rate_interval};
use crate::trace::SmoothnessSum;

/// Totals of a run that are not in the results of its deliveries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunTotals {
    /// Simulated time of all episodes, seconds.
    pub sim_seconds: f64,
    /// Wall-clock time of the run, seconds; `None` if it was not measured as a whole.
    pub wall_seconds: Option<f64>,
    /// CPU time of the process, seconds; `None` if it was not measured as a whole.
    pub cpu_seconds: Option<f64>,
    /// Instructions that were understood; `None` if the agent makes no plans.
    pub instructions: Option<Understood>,
    /// Errors of the poses that the agent reported.
    pub localization: Option<LocalizationSum>,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// The metrics of a run. The deliveries of an episode are a sequence if there are several of them,
/// in the order of `task`.
pub fn summarize(deliveries: &[DeliveryResult], totals: &RunTotals) -> Metrics {
    let mut metrics = sums(deliveries, totals);
    let mut intervals = Intervals {
        seed: totals.seed,
        found: BTreeMap::new(),
    };
    let Episodes { singles, sequences } = Episodes::of(deliveries);
    let single = Shares::of(&on_map(&singles), "", &mut intervals);
    metrics.sr_10m = single.sr_10m;
    metrics.spl_straight = single.spl_straight;
    metrics.sr_2m = single.sr_2m;
    metrics.sr_clean = single.sr_clean;
    metrics.correct_unit = single.correct_unit;
    metrics.spl = single.spl;
    let member = Shares::of(&on_map(&sequences), "member_", &mut intervals);
    metrics.member_sr_10m = member.sr_10m;
    metrics.member_spl_straight = member.spl_straight;
    metrics.member_sr_2m = member.sr_2m;
    metrics.member_sr_clean = member.sr_clean;
    metrics.member_correct_unit = member.correct_unit;
    metrics.member_spl = member.spl;
    metrics.srtp = totals
        .instructions
        .and_then(|i| intervals.rate("srtp", i.by_planner));
    metrics.srtp_with_fallback = totals
        .instructions
        .and_then(|i| intervals.rate("srtp_with_fallback", i.with_fallbacks));
    // LSR and LSPL are computed for each sequence first, then averaged.
    metrics.lsr = intervals.sequences("lsr", &sequences, strict_success);
    metrics.lspl = intervals.sequences("lspl", &sequences, strict_ratio);
    metrics.lsr_10m = intervals.sequences("lsr_10m", &sequences, paper_success);
    metrics.lspl_straight = intervals.sequences("lspl_straight", &sequences, paper_ratio);
    metrics.unmapped = unmapped(deliveries);
    metrics.intervals = intervals.found;
    metrics
}

/// The episodes with their deliveries to buildings that the public map has under their names.
fn on_map<'a>(episodes: &[Vec<&'a DeliveryResult>]) -> Vec<Vec<&'a DeliveryResult>> {
    let kept = episodes.iter().map(|episode| {
        let deliveries = episode.iter().copied();
        deliveries.filter(|d| d.on_map.is_right()).collect()
    });
    kept.filter(|episode: &Vec<_>| !episode.is_empty())
        .collect()
}

/// The metrics of the other deliveries; `None` if there are none.
fn unmapped(deliveries: &[DeliveryResult]) -> Option<Unmapped> {
    let others: Vec<_> = deliveries.iter().filter(|d| !d.on_map.is_right()).collect();
    let mean = |value: Value| spl(&others.iter().map(|d| value(d)).collect::<Vec<_>>());
    (!others.is_empty()).then(|| Unmapped {
        deliveries: others.len(),
        sr_10m: mean(paper_success),
        sr_2m: mean(strict_success),
        spl: mean(strict_ratio),
    })
}

/// The metrics that are sums over all deliveries.
fn sums(deliveries: &[DeliveryResult], totals: &RunTotals) -> Metrics {
    // Folded from +0, since the `sum()` of nothing is -0, which JSON would show.
    let sum = |value: fn(&DeliveryResult) -> f64| deliveries.iter().map(value).fold(0.0, Add::add);
    Metrics {
        collisions: deliveries.iter().map(|d| d.collisions).sum(),
        contact_s: sum(|d| d.contact_s),
        collisions_by_class: collisions::total(deliveries.iter().map(|d| &d.collisions_by_class)),
        encounters: deliveries
            .iter()
            .filter_map(|d| d.encounters)
            .reduce(EncounterSum::plus),
        path_m: sum(|d| d.path_m),
        smoothness: deliveries
            .iter()
            .map(|d| d.smoothness)
            .fold(SmoothnessSum::default(), SmoothnessSum::plus),
        localization: totals.localization,
        sim_seconds: totals.sim_seconds,
        wall_seconds: totals.wall_seconds,
        real_time_factor: totals
            .cpu_seconds
            .filter(|seconds| *seconds > 0.0)
            .map(|seconds| totals.sim_seconds / seconds),
        ..Metrics::default()
    }
}

/// Deliveries by episode, in the order of their tasks.
struct Episodes<'a> {
    /// Episodes of one delivery, in which the robot starts anew.
    singles: Vec<Vec<&'a DeliveryResult>>,
    /// Episodes of several deliveries, each of which starts where the last one ended.
    sequences: Vec<Vec<&'a DeliveryResult>>,
}

impl<'a> Episodes<'a> {
    fn of(deliveries: &'a [DeliveryResult]) -> Self {
        let episodes = by_episode(deliveries).into_values();
        let (singles, sequences) = episodes.partition(|episode| episode.len() == 1);
        Self { singles, sequences }
    }
}

/// The rates and ratios of single deliveries, or of the members of sequences.
struct Shares {
    sr_10m: Option<f64>,
    spl_straight: Option<f64>,
    sr_2m: Option<f64>,
    sr_clean: Option<f64>,
    correct_unit: Option<f64>,
    spl: Option<f64>,
}

impl Shares {
    /// Names of the metrics in results are prefixed with `prefix`.
    fn of(episodes: &[Vec<&DeliveryResult>], prefix: &str, intervals: &mut Intervals) -> Self {
        let mut mean =
            |name: &str, value| intervals.deliveries(&format!("{prefix}{name}"), episodes, value);
        Self {
            sr_10m: mean("sr_10m", paper_success),
            spl_straight: mean("spl_straight", paper_ratio),
            sr_2m: mean("sr_2m", strict_success),
            sr_clean: mean("sr_clean", clean_success),
            correct_unit: mean("correct_unit", correct_unit),
            spl: mean("spl", strict_ratio),
        }
    }
}

/// The intervals computed so far, by name of the metric; `None` for too few episodes.
struct Intervals {
    seed: u64,
    found: BTreeMap<String, Option<[f64; 2]>>,
}

impl Intervals {
    /// Adds the interval of the share of instructions; returns the share.
    fn rate(&mut self, name: &str, proportion: Proportion) -> Option<f64> {
        let rate = proportion.rate()?;
        self.found
            .insert(name.to_owned(), rate_interval(proportion));
        Some(rate)
    }

    /// Adds the interval of the mean over all deliveries of some episodes; returns the mean.
    fn deliveries(
        &mut self,
        name: &str,
        episodes: &[Vec<&DeliveryResult>],
        value: Value,
    ) -> Option<f64> {
        let values: Vec<Vec<f64>> = episodes
            .iter()
            .map(|episode| episode.iter().map(|d| value(d)).collect())
            .collect();
        self.clusters(name, &values)
    }

    /// Adds the interval of the mean over sequences, each of which has the weighted mean of its
    /// deliveries; returns the mean.
    fn sequences(
        &mut self,
        name: &str,
        sequences: &[Vec<&DeliveryResult>],
        value: Value,
    ) -> Option<f64> {
        let weighted = |sequence: &Vec<&DeliveryResult>| {
            let values: Vec<f64> = sequence.iter().map(|d| value(d)).collect();
            sequence_mean(&values).map(|mean| vec![mean])
        };
        let values: Vec<Vec<f64>> = sequences.iter().filter_map(weighted).collect();
        self.clusters(name, &values)
    }

    /// Adds the interval of the mean of clustered values; returns the mean.
    fn clusters(&mut self, name: &str, clusters: &[Vec<f64>]) -> Option<f64> {
        // `spl` is a plain mean, whatever the metric.
        let mean = spl(&clusters.concat())?;
        let interval = mean_interval(clusters, self.seed);
        self.found.insert(name.to_owned(), interval);
        Some(mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::results::tests::delivery;

    #[test]
    fn both_criteria_are_reported() {
        let mut far = delivery(1, 0);
        (far.success_2m, far.correct_unit) = (false, true);
        let totals = RunTotals {
            sim_seconds: 40.0,
            cpu_seconds: Some(2.0),
            ..RunTotals::default()
        };
        let metrics = summarize(&[delivery(0, 0), far], &totals);
        assert_eq!(
            (metrics.sr_10m, metrics.sr_2m, metrics.correct_unit),
            (Some(1.0), Some(0.5), Some(1.0))
        );
        assert_eq!(
            (metrics.spl_straight, metrics.spl),
            (Some(0.5), Some(0.375))
        );
        assert_eq!(
            (metrics.lsr, metrics.lspl, metrics.srtp),
            (None, None, None)
        );
        assert_eq!(
            (metrics.path_m, metrics.real_time_factor),
            (16.0, Some(20.0))
        );
        assert_eq!(
            metrics.intervals["sr_10m"], None,
            "two episodes are too few"
        );
        assert!(!metrics.intervals.contains_key("lsr"));
        let five: Vec<_> = (0..5).map(|episode| delivery(episode, 0)).collect();
        let intervals = summarize(&five, &totals).intervals;
        assert_eq!(intervals["sr_10m"].unwrap()[1], 1.0);
        assert!(intervals["spl"].is_some_and(|[low, high]| low < high));
    }

    #[test]
    fn sequences_are_episodes_of_several_deliveries_in_task_order() {
        let mut deliveries: Vec<_> = (0..5).rev().map(|task| delivery(3, task)).collect();
        deliveries
            .iter_mut()
            .find(|d| d.task == 0)
            .unwrap()
            .success_2m = false;
        deliveries.push(delivery(4, 0));
        deliveries.last_mut().unwrap().collisions = 1;
        let metrics = summarize(&deliveries, &RunTotals::default());
        assert_eq!(libm::round(metrics.lsr.unwrap() * 1e4), 7558.0);
        assert_eq!(metrics.lsr_10m.map(|v| libm::round(v * 1e9)), Some(1e9));
        // Singles and members are never pooled.
        assert_eq!((metrics.sr_2m, metrics.sr_clean), (Some(1.0), Some(0.0)));
        assert_eq!(metrics.member_sr_2m, Some(0.8));
        assert_eq!(metrics.member_sr_clean, Some(0.8));
        let only_members = summarize(&deliveries[..5], &RunTotals::default());
        assert_eq!((only_members.sr_2m, only_members.spl), (None, None));
    }

    #[test]
    fn a_run_without_deliveries_has_no_rates() {
        let metrics = summarize(
            &[],
            &RunTotals {
                instructions: Some(Understood::default()),
                ..RunTotals::default()
            },
        );
        assert_eq!(
            (metrics.sr_10m, metrics.spl, metrics.srtp),
            (None, None, None)
        );
        assert!(metrics.intervals.is_empty());
    }
}
