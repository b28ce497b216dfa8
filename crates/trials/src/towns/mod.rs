//! The towns experiment: an agent's deliveries in neighbourhoods drawn at random from maps.
//!
//! Worlds that were not selected reveal overfitting of an agent. A window is a square of a map. Its
//! world is generated; four single deliveries and a sequence of three are drawn, driven and scored;
//! and the odometry is tested on a drive of three minutes. Finished windows are kept in the folder,
//! so an interrupted experiment continues with the next window.
//!
//! | module | content |
//! |---|---|
//! | `plan` | [`TownsPlan`]: the parameters of the experiment |
//! | `windows` | random windows of maps |
//! | `odometry` | odometry errors on a drive through a window |
//! | `summary` | [`Town`] and [`Towns`]: the results of one window and of all |

mod odometry;
mod plan;
mod summary;
mod windows;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use openbench_osm::write_atomically;
use serde::Serialize;
use serde::de::DeserializeOwned;

use openbench_bench::{
    AgentFactory, BenchError, Build, Level, Prepared, RunRequest, Unfinished, run as run_suite,
};

pub use odometry::OdometrySum;
pub use plan::TownsPlan;
pub use summary::{PoseSum, Town, Towns};
pub use windows::WindowPlace;
use windows::{DrawnWorld, Maps};

/// The file of a finished window.
const TOWN_FILE: &str = "town.json";
/// The file with the plan of a folder's windows.
const PLAN_FILE: &str = "towns.json";

/// A run of the experiment.
pub struct TownsRequest<'a> {
    /// Its parameters.
    pub plan: &'a TownsPlan,
    /// Number of windows.
    pub windows: usize,
    /// The factory of the agent.
    pub factory: &'a dyn AgentFactory,
    /// The program, for the results.
    pub build: &'a Build,
    /// Number of threads.
    pub jobs: usize,
    /// Folder for windows and results.
    pub out: &'a Path,
    /// Called for each finished window; the flag says whether it was finished in an earlier run.
    pub progress: &'a dyn Fn(&Town, bool),
}

/// Runs the unfinished windows and summarizes all.
///
/// # Errors
/// A folder with windows of another plan, a map that cannot be read, or a window that cannot be
/// finished.
pub fn run(request: &TownsRequest<'_>) -> Result<Towns, BenchError> {
    claim(request.plan, request.out)?;
    let maps = Maps::read(&request.plan.maps)?;
    let mut towns: Vec<Town> = Vec::new();
    for number in 0..request.windows {
        let folder = folder(request.out, number);
        // The file of a window is written last, so a window that has one is complete.
        if let Some(town) = read::<Town>(&folder.join(TOWN_FILE))? {
            (request.progress)(&town, true);
            towns.push(town);
            continue;
        }
        // Windows of an earlier run count, too: a continued run draws what an uninterrupted one
        // would.
        let taken: Vec<&WindowPlace> = towns.iter().map(|town| &town.place).collect();
        let world = folder.join("world");
        let Some(DrawnWorld { place, prepared }) =
            maps.draw(request.plan, number, &taken, &world)?
        else {
            // No map has space for another window.
            break;
        };
        let town = drive(request, number, place, &prepared, &folder)?;
        write(&folder.join(TOWN_FILE), &town)?;
        (request.progress)(&town, false);
        towns.push(town);
    }
    Ok(Towns::of(request.plan.clone(), request.windows, towns))
}

/// A window with its world.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrawnWindow {
    /// Position of the window.
    pub place: WindowPlace,
    /// The folder of its world.
    pub world: PathBuf,
}

/// Draws the windows of a plan and writes their worlds, which are those of [`run`].
///
/// # Errors
/// A folder with windows of another plan, or a map that cannot be read.
pub fn draw(plan: &TownsPlan, windows: usize, out: &Path) -> Result<Vec<DrawnWindow>, BenchError> {
    claim(plan, out)?;
    let maps = Maps::read(&plan.maps)?;
    let mut drawn: Vec<DrawnWindow> = Vec::new();
    for number in 0..windows {
        let taken: Vec<&WindowPlace> = drawn.iter().map(|window| &window.place).collect();
        let world = folder(out, number).join("world");
        let Some(DrawnWorld { place, .. }) = maps.draw(plan, number, &taken, &world)? else {
            break;
        };
        drawn.push(DrawnWindow { place, world });
    }
    Ok(drawn)
}

/// The folder of a window.
fn folder(out: &Path, number: usize) -> PathBuf {
    out.join(format!("{number:03}"))
}

/// Writes the plan into a new folder, or compares it with that of an existing folder.
fn claim(plan: &TownsPlan, out: &Path) -> Result<(), BenchError> {
    std::fs::create_dir_all(out).map_err(|e| BenchError::file(out, e))?;
    let path = out.join(PLAN_FILE);
    match read::<TownsPlan>(&path)? {
        None => write(&path, plan),
        Some(before) if before == *plan => Ok(()),
        Some(_) => Err(BenchError::bad_file(
            &path,
            "the folder contains windows of other maps, settings or another version; use another \
             folder with --out",
        )),
    }
}

fn drive(
    request: &TownsRequest<'_>,
    number: usize,
    place: WindowPlace,
    prepared: &Prepared,
    folder: &Path,
) -> Result<Town, BenchError> {
    let plan = request.plan;
    let out = folder.join("run");
    let output = run_suite(&RunRequest {
        prepared,
        agent: &plan.agent,
        factory: request.factory,
        settings: &plan.settings,
        seed: plan.seed.wrapping_add(number as u64),
        jobs: request.jobs,
        level: Level::None,
        out: Some(&out),
        // A window has few episodes: an unfinished one begins anew.
        unfinished: Unfinished::Discard,
        memory: None,
        memory_file: None,
        build: request.build,
        command: "openbench bench towns",
        progress: &|_| {},
        stop: &AtomicBool::new(false),
    })?;
    let odometry = odometry::measure(prepared, plan.seed.wrapping_add(number as u64))?;
    Ok(Town {
        number,
        place,
        results: output.results,
        pose_errors: output.pose_errors,
        odometry,
    })
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, BenchError> {
    let text = match std::fs::read(path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(BenchError::file(path, e)),
    };
    serde_json::from_slice(&text)
        .map(Some)
        .map_err(|source| BenchError::bad_file(path, UnreadableRecord(source)))
}

/// A record of an earlier run that cannot be parsed.
#[derive(Debug, thiserror::Error)]
#[error("it is no record of this version; remove it to repeat its window")]
struct UnreadableRecord(#[source] serde_json::Error);

fn write(path: &Path, value: &impl Serialize) -> Result<(), BenchError> {
    let text = serde_json::to_vec_pretty(value).map_err(|e| BenchError::bad_file(path, e))?;
    write_atomically(path, &text).map_err(|e| BenchError::bad_file(path, e))
}
