//! The results of one window and of all.

use std::collections::BTreeMap;

use openbench_core::FailureCause;
use serde::{Deserialize, Serialize};

use super::odometry::OdometrySum;
use super::plan::TownsPlan;
use super::windows::WindowPlace;
use openbench_bench::score::metrics::{ErrorCounts, RunTotals, summarize};
use openbench_bench::score::results::{DeliveryResult, Metrics, Results};

/// The results of a window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Town {
    /// Number of the window.
    pub number: usize,
    /// Position of the window.
    pub place: WindowPlace,
    /// Results of the deliveries.
    pub results: Results,
    /// Errors of the poses that the agent reported.
    pub pose_errors: ErrorCounts,
    /// Odometry errors of a drive.
    pub odometry: OdometrySum,
}

impl Town {
    /// Failures by cause.
    pub fn failures(&self) -> BTreeMap<FailureCause, usize> {
        failures(&self.results.deliveries)
    }

    /// CPU time of the run, seconds.
    fn cpu_seconds(&self) -> f64 {
        let Metrics {
            sim_seconds,
            real_time_factor,
            ..
        } = self.results.metrics;
        // Results contain no CPU time, but the factor that was made from it.
        real_time_factor.map_or(0.0, |factor| sim_seconds / factor)
    }
}

/// The results of the experiment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Towns {
    /// Its parameters.
    pub plan: TownsPlan,
    /// Requested number of windows; the maps may have space for fewer.
    pub wanted: usize,
    /// The windows.
    pub towns: Vec<Town>,
    /// Metrics over the deliveries of all windows.
    pub metrics: Metrics,
    /// Failures by cause.
    pub failures: BTreeMap<FailureCause, usize>,
    /// Errors of the poses of all windows; null if the agent reported none.
    pub pose: Option<PoseSum>,
    /// Number of times that the error exceeded 1 m while the agent reported good health.
    pub silent_divergences: usize,
}

/// Statistics of position errors, metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PoseSum {
    /// Root mean square.
    pub rms_m: f64,
    /// 95th percentile.
    pub p95_m: f64,
    /// Maximum.
    pub max_m: f64,
}

impl PoseSum {
    /// The statistics of a histogram; `None` without errors.
    pub fn of(counts: &ErrorCounts) -> Option<Self> {
        Some(Self {
            rms_m: counts.rms()?,
            p95_m: counts.quantile(0.95)?,
            max_m: counts.quantile(1.0)?,
        })
    }
}

impl Towns {
    /// Summarizes windows.
    pub fn of(plan: TownsPlan, wanted: usize, towns: Vec<Town>) -> Self {
        let mut deliveries: Vec<DeliveryResult> = Vec::new();
        for town in &towns {
            // Episodes are numbered across all windows.
            let before = deliveries.last().map_or(0, |last| last.episode + 1);
            deliveries.extend(
                town.results
                    .deliveries
                    .iter()
                    .map(|delivery| DeliveryResult {
                        episode: before + delivery.episode,
                        ..delivery.clone()
                    }),
            );
        }
        let sum = |value: fn(&Town) -> f64| towns.iter().map(value).sum::<f64>();
        // Without localization: percentiles of windows cannot be merged. `pose` has those of the
        // histograms.
        let totals = RunTotals {
            sim_seconds: sum(|town| town.results.metrics.sim_seconds),
            wall_seconds: Some(sum(|town| town.results.metrics.wall_seconds.unwrap_or(0.0))),
            cpu_seconds: Some(sum(Town::cpu_seconds)),
            seed: plan.window_seed(0),
            ..RunTotals::default()
        };
        let mut errors = ErrorCounts::default();
        towns.iter().for_each(|town| errors.add(&town.pose_errors));
        let silent = |town: &Town| {
            town.results
                .metrics
                .localization
                .map_or(0, |l| l.silent_divergences)
        };
        Self {
            metrics: summarize(&deliveries, &totals),
            failures: failures(&deliveries),
            pose: PoseSum::of(&errors),
            silent_divergences: towns.iter().map(silent).sum(),
            plan,
            wanted,
            towns,
        }
    }
}

fn failures(deliveries: &[DeliveryResult]) -> BTreeMap<FailureCause, usize> {
    let mut counts = BTreeMap::new();
    for cause in deliveries.iter().filter_map(|delivery| delivery.failure) {
        *counts.entry(cause).or_default() += 1;
    }
    counts
}
