//! Drives the episodes of a run and shows progress.

use openbench_bench::plural::count;
use openbench_bench::score::results::DeliveryResult;
use openbench_bench::{BenchError, EpisodeEnd, Results, RunRequest};

use crate::outcome::tell;
use crate::progress::progress_bar;

/// Drives the episodes of a request; shows a bar on a terminal; elsewhere it writes a line for each
/// delivery.
pub fn drive_with_progress(request: RunRequest<'_>) -> Result<Results, BenchError> {
    let episodes = request.prepared.episodes.len();
    let bar = progress_bar(episodes, "delivering");
    let output = openbench_bench::run(&RunRequest {
        progress: &|end| {
            bar.set_position(end.ended as u64);
            // A hidden bar: nobody watches a terminal.
            if bar.is_hidden() {
                tell(&delivery_lines(end, episodes));
            }
        },
        ..request
    });
    bar.finish_and_clear();
    Ok(output?.results)
}

/// A line for each delivery of an episode.
fn delivery_lines(end: &EpisodeEnd, episodes: usize) -> String {
    let line = |delivery: &DeliveryResult| {
        let ended = match delivery.failure {
            Some(failure) => failure.to_string(),
            None => "delivered".to_owned(),
        };
        format!(
            "{} of {}: {}.{} {}: {ended}, {:.0} s",
            end.ended,
            count(episodes, "episode", "episodes"),
            delivery.episode,
            delivery.task,
            delivery.address(),
            delivery.sim_seconds
        )
    };
    let lines: Vec<String> = end.deliveries.iter().map(line).collect();
    lines.join("\n")
}
