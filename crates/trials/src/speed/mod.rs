//! Speed of the parts, for the comparisons in `benchmarks/`: CPU time of one thread.
//!
//! | module | measures |
//! |---|---|
//! | [`sim`] | rays, images, and the whole simulator |
//! | [`routing`] | routes, nearest positions, tables, and the preparation of a map |
//! | `dump` | writes the measured triangles and rays as files for other programs |

mod dump;
pub mod routing;
pub mod sim;

use std::time::Duration;

use cpu_time::ThreadTime;

/// Minimum CPU time of several repetitions: disturbances only add to it.
fn fastest(repetitions: usize, mut work: impl FnMut()) -> Duration {
    let once = |()| {
        let began = ThreadTime::now();
        work();
        began.elapsed()
    };
    // CPU time of the thread: that of other processes would otherwise be counted.
    std::iter::repeat_n((), repetitions)
        .map(once)
        .min()
        .unwrap_or_default()
}

/// Peak memory of this process, megabytes; `None` if the system does not report it.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    // The kernel's kB has 1024 bytes, the megabyte of the result a million.
    Some(kilobytes * 1024.0 / 1e6)
}
