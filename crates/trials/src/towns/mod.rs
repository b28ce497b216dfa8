//! A battery of towns: neighbourhoods that a seed draws from maps, and an agent's deliveries in
//! each.
//!
//! Worlds that nobody chose show what an agent was tuned to. A window is a square of a map; its
//! world is generated, four single deliveries and a sequence of three are drawn, driven and scored,
//! and a drive of three minutes is given to the odometry. What is done stays in the folder: a
//! battery that was broken off goes on with the next window.
//!
//! | module | its one job |
//! |---|---|
//! | [`plan`] | [`TownsPlan`]: what a battery is |
//! | [`windows`] | neighbourhoods from a seed |
//! | [`odometry`] | a drive through a window, and how well odometry follows it |
//! | [`summary`] | [`Town`] and [`Towns`]: what came of one window and of all |

pub mod odometry;
pub mod plan;
pub mod summary;
pub mod windows;

use std::path::{Path, PathBuf};

use openbench_core::LonLat;
use openbench_osm::write_atomically;
use serde::Serialize;
use serde::de::DeserializeOwned;

use openbench_bench::{AgentFactory, BenchError, Level, Prepared, RunRequest, run as run_suite};

pub use odometry::OdometrySum;
pub use plan::TownsPlan;
pub use summary::{Town, Towns};
pub use windows::DOORS;
use windows::{Maps, Place};

/// The file of a window that is done.
const DONE: &str = "town.json";
/// The file that says what a folder's windows are of.
const PLAN: &str = "towns.json";

/// A battery to be run.
pub struct TownsRequest<'a> {
    /// What it is.
    pub plan: &'a TownsPlan,
    /// How many windows.
    pub windows: usize,
    /// Makes the agent.
    pub factory: &'a dyn AgentFactory,
    /// Episodes at a time.
    pub jobs: usize,
    /// Folder for windows and results.
    pub out: &'a Path,
    /// Told of each window that is done, and whether it was done before.
    pub progress: &'a dyn Fn(&Town, bool),
}

/// Runs the windows that are not done yet and sums up all.
///
/// # Errors
/// A folder that holds windows of another plan, maps that cannot be read, a window that cannot be
/// driven to its end.
pub fn run(request: &TownsRequest<'_>) -> Result<Towns, BenchError> {
    claim(request.plan, request.out)?;
    let maps = Maps::read(&request.plan.maps)?;
    let mut towns: Vec<Town> = Vec::new();
    for number in 0..request.windows {
        let folder = folder(request.out, number);
        if let Some(town) = read::<Town>(&folder.join(DONE))? {
            (request.progress)(&town, true);
            towns.push(town);
            continue;
        }
        let taken: Vec<(usize, LonLat)> = towns
            .iter()
            .map(|town| (town.place.map, town.place.around))
            .collect();
        let Some((place, prepared)) =
            maps.draw(request.plan, number, &taken, &folder.join("world"))?
        else {
            // No map has room for another one.
            break;
        };
        let town = drive(request, number, place, &prepared, &folder)?;
        write(&folder.join(DONE), &town)?;
        (request.progress)(&town, false);
        towns.push(town);
    }
    Ok(Towns::of(request.plan.clone(), request.windows, towns))
}

/// A window whose world was made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drawn {
    /// Where it lies.
    pub place: Place,
    /// The folder of its world.
    pub world: PathBuf,
}

/// Draws the windows of a battery and makes their worlds, which are those that [`run`] drives in.
///
/// # Errors
/// A folder that holds windows of another plan, maps that cannot be read.
pub fn draw(plan: &TownsPlan, windows: usize, out: &Path) -> Result<Vec<Drawn>, BenchError> {
    claim(plan, out)?;
    let maps = Maps::read(&plan.maps)?;
    let mut drawn: Vec<Drawn> = Vec::new();
    for number in 0..windows {
        let taken: Vec<(usize, LonLat)> = drawn
            .iter()
            .map(|Drawn { place, .. }| (place.map, place.around))
            .collect();
        let world = folder(out, number).join("world");
        let Some((place, _)) = maps.draw(plan, number, &taken, &world)? else {
            break;
        };
        drawn.push(Drawn { place, world });
    }
    Ok(drawn)
}

/// The folder of a window.
fn folder(out: &Path, number: usize) -> PathBuf {
    out.join(format!("{number:03}"))
}

/// Notes what the folder's windows are of, or checks it.
fn claim(plan: &TownsPlan, out: &Path) -> Result<(), BenchError> {
    std::fs::create_dir_all(out).map_err(|e| BenchError::file(out, e))?;
    let path = out.join(PLAN);
    match read::<TownsPlan>(&path)? {
        None => write(&path, plan),
        Some(before) if before == *plan => Ok(()),
        Some(_) => Err(BenchError::bad_file(
            &path,
            "the folder holds windows of other maps, settings or another version; name another one with --out",
        )),
    }
}

fn drive(
    request: &TownsRequest<'_>,
    number: usize,
    place: Place,
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
        memory: None,
        command: "openbench bench towns",
        progress: &|_| {},
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
    let bad = |e: serde_json::Error| {
        BenchError::bad_file(path, format!("{e}; remove the file to drive this again"))
    };
    serde_json::from_slice(&text).map(Some).map_err(bad)
}

fn write(path: &Path, value: &impl Serialize) -> Result<(), BenchError> {
    let text = serde_json::to_vec_pretty(value).map_err(|e| BenchError::bad_file(path, e))?;
    write_atomically(path, &text).map_err(|e| BenchError::bad_file(path, e))
}
