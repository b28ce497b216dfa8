//! All metrics over the deliveries of a run.

use std::collections::BTreeMap;

use super::collisions;
use super::encounters::EncounterSum;
use super::localization::LocalizationSum;
use super::path_ratio::{path_ratio, spl};
use super::sequence::sequence_mean;
use crate::score::results::{DeliveryResult, Metrics};
use crate::score::statistics::{Proportion, bootstrap_interval, wilson_interval};
use crate::trace::SmoothnessSum;

/// Totals of a run that are not in the results of its deliveries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunTotals {
    /// Simulated time of all episodes, seconds.
    pub sim_seconds: f64,
    /// Wall-clock time of the run, seconds.
    pub wall_seconds: f64,
    /// CPU time of the process, seconds.
    pub cpu_seconds: f64,
    /// Instructions with exactly the right plan, among all; `None` if the agent makes no plans.
    pub instructions: Option<Proportion>,
    /// Errors of the poses that the agent reported.
    pub localization: Option<LocalizationSum>,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// The metrics of a run. The deliveries of an episode are a sequence if there are several of them,
/// in the order of `task`.
pub fn summarize(deliveries: &[DeliveryResult], totals: &RunTotals) -> Metrics {
    let mut metrics = Metrics {
        collisions: deliveries.iter().map(|d| d.collisions).sum(),
        collisions_by_class: collisions::total(deliveries.iter().map(|d| &d.collisions_by_class)),
        encounters: deliveries
            .iter()
            .filter_map(|d| d.encounters)
            .reduce(EncounterSum::plus),
        // Folded from +0, since the `sum()` of nothing is -0, which JSON would show.
        path_m: deliveries
            .iter()
            .map(|d| d.path_m)
            .fold(0.0, |sum, p| sum + p),
        smoothness: deliveries
            .iter()
            .map(|d| d.smoothness)
            .fold(SmoothnessSum::default(), SmoothnessSum::plus),
        localization: totals.localization,
        sim_seconds: totals.sim_seconds,
        wall_seconds: totals.wall_seconds,
        real_time_factor: if totals.cpu_seconds > 0.0 {
            totals.sim_seconds / totals.cpu_seconds
        } else {
            0.0
        },
        ..Metrics::default()
    };
    let mut intervals = Intervals {
        seed: totals.seed,
        found: BTreeMap::new(),
    };
    // Shares of deliveries have Wilson intervals, means of ratios bootstrapped ones.
    metrics.sr_10m = intervals.rate("sr_10m", Proportion::count(deliveries, |d| d.success_10m));
    metrics.sr_2m = intervals.rate("sr_2m", Proportion::count(deliveries, |d| d.success_2m));
    let correct_unit = Proportion::count(deliveries, |d| d.correct_unit);
    metrics.correct_unit = intervals.rate("correct_unit", correct_unit);
    metrics.srtp = totals.instructions.and_then(|i| intervals.rate("srtp", i));
    metrics.spl_straight = intervals.mean("spl_straight", &values(deliveries, paper_ratio));
    metrics.spl = intervals.mean("spl", &values(deliveries, strict_ratio));
    // LSR and LSPL are computed for each sequence first, then averaged.
    let sequences = sequences(deliveries);
    metrics.lsr = intervals.mean("lsr", &sequence_means(&sequences, strict_success));
    metrics.lspl = intervals.mean("lspl", &sequence_means(&sequences, strict_ratio));
    metrics.lsr_10m = intervals.mean("lsr_10m", &sequence_means(&sequences, paper_success));
    let paper_ratios = sequence_means(&sequences, paper_ratio);
    metrics.lspl_straight = intervals.mean("lspl_straight", &paper_ratios);
    metrics.intervals = intervals.found;
    metrics
}

fn values(deliveries: &[DeliveryResult], value: fn(&DeliveryResult) -> f64) -> Vec<f64> {
    deliveries.iter().map(value).collect()
}

fn paper_success(delivery: &DeliveryResult) -> f64 {
    f64::from(delivery.success_10m)
}

fn strict_success(delivery: &DeliveryResult) -> f64 {
    f64::from(delivery.success_2m)
}

fn paper_ratio(delivery: &DeliveryResult) -> f64 {
    path_ratio(
        delivery.success_10m,
        delivery.straight_line_m,
        delivery.path_m,
    )
}

fn strict_ratio(delivery: &DeliveryResult) -> f64 {
    // Without a drivable path to the door the ratio is 0.
    let shortest = delivery.shortest_path_m.unwrap_or(f64::INFINITY);
    path_ratio(delivery.success_2m, shortest, delivery.path_m)
}

fn sequences(deliveries: &[DeliveryResult]) -> Vec<Vec<&DeliveryResult>> {
    let mut episodes = BTreeMap::<usize, Vec<&DeliveryResult>>::new();
    for delivery in deliveries {
        episodes.entry(delivery.episode).or_default().push(delivery);
    }
    let mut sequences: Vec<_> = episodes.into_values().filter(|e| e.len() > 1).collect();
    // The weights of LSR and LSPL fall with the position in the sequence.
    sequences.iter_mut().for_each(|s| s.sort_by_key(|d| d.task));
    sequences
}

fn sequence_means(
    sequences: &[Vec<&DeliveryResult>],
    value: fn(&DeliveryResult) -> f64,
) -> Vec<f64> {
    sequences
        .iter()
        .filter_map(|sequence| {
            let values: Vec<f64> = sequence.iter().map(|delivery| value(delivery)).collect();
            sequence_mean(&values)
        })
        .collect()
}

/// The intervals computed so far, by name of the metric.
struct Intervals {
    seed: u64,
    found: BTreeMap<String, [f64; 2]>,
}

impl Intervals {
    /// Adds the interval of a rate; returns the rate.
    fn rate(&mut self, name: &str, proportion: Proportion) -> Option<f64> {
        let interval = wilson_interval(proportion.successes, proportion.trials);
        self.found.extend(interval.map(|i| (name.to_owned(), i)));
        proportion.rate()
    }

    /// Adds the interval of a mean; returns the mean.
    fn mean(&mut self, name: &str, values: &[f64]) -> Option<f64> {
        let interval = bootstrap_interval(values, self.seed);
        self.found.extend(interval.map(|i| (name.to_owned(), i)));
        // `spl` is a plain mean, whatever the metric.
        spl(values)
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
            cpu_seconds: 2.0,
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
        assert_eq!((metrics.path_m, metrics.real_time_factor), (16.0, 20.0));
        assert_eq!(metrics.intervals["sr_10m"][1], 1.0);
        assert!(!metrics.intervals.contains_key("lsr"));
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
        let metrics = summarize(&deliveries, &RunTotals::default());
        assert_eq!(libm::round(metrics.lsr.unwrap() * 1e4), 7558.0);
        assert_eq!(metrics.lsr_10m.map(|v| libm::round(v * 1e9)), Some(1e9));
    }

    #[test]
    fn a_run_without_deliveries_has_no_rates() {
        let metrics = summarize(
            &[],
            &RunTotals {
                instructions: Some(Proportion::default()),
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
