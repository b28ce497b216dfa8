//! How fast the parts are, for comparisons with peers under `benchmarks/`. CPU time of one thread, which does nothing else.
//!
//! | module | what |
//! |---|---|
//! | [`sim`] | rays, images, and the simulator as a whole |
//! | [`routing`] | routes, nearest places, tables, and preparing a map |
//! | [`dump`] | the triangles and rays that were measured, as files for peers |

pub mod dump;
pub mod routing;
pub mod sim;

use std::time::Duration;

use cpu_time::ThreadTime;

/// CPU time that `work` takes: the least of several goes, since others only ever add to it.
fn fastest(goes: usize, mut work: impl FnMut()) -> Duration {
    let once = |()| {
        let began = ThreadTime::now();
        work();
        began.elapsed()
    };
    std::iter::repeat_n((), goes)
        .map(once)
        .min()
        .unwrap_or_default()
}

/// The most memory that this process has held, megabytes; where the system does not say, `None`.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes * 1024.0 / 1e6)
}
