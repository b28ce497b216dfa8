//! `openbench bench localization`

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Context;
use openbench_bench::suite::{Condition, Conditions, GoalKind, StartErrors};
use openbench_bench::worlds::suite_named;
use openbench_bench::{Prepared, Sensors, Suite, TargetSource, TrafficPlan};
use openbench_osm::disturb::MapErrors;
use openbench_osm::write_atomically;
use openbench_trials::localization::cases::{Known, cases};
use openbench_trials::localization::drift::drifting;
use openbench_trials::localization::drives::{DRIVE_M, Drive, Recording, record};
use openbench_trials::localization::examples::examples;
use openbench_trials::localization::labels::Labels;
use openbench_trials::localization::mixed_seed;
use openbench_trials::localization::peers::{PeerKind, peer_trials};
use openbench_trials::localization::report::Report;
use openbench_trials::localization::trial::{Without, trials};
use serde::Serialize;

use crate::args::{BenchLocalizationArgs, LabelSource, RegistrationPart};
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::progress_bar;

/// What is printed.
#[derive(Debug, Serialize)]
struct Found {
    /// How wrong the map is.
    level: String,
    /// The share of buildings that it lacks, if it is not the level's.
    missing: Option<f64>,
    /// What is known about the start.
    start: String,
    /// How facades are distinguished from other surfaces.
    labels: LabelSource,
    /// The part of registration that is left out.
    without: Option<RegistrationPart>,
    /// Length of a drive, metres.
    drive_m: f64,
    /// By how much odometry was made worse.
    odometry_drift: Option<f64>,
    seed: u64,
    /// On all worlds together.
    #[serde(flatten)]
    all: Report,
    /// On each of them.
    worlds: BTreeMap<String, Report>,
    /// What other ways find on all worlds together, if they were asked for.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    peers: BTreeMap<String, Report>,
}

/// Localizes a robot on drives through worlds.
pub fn run(args: &BenchLocalizationArgs) -> anyhow::Result<Outcome> {
    let errors = errors_of_map(args)?;
    let is_on_map = args.start != "off";
    let beside = if is_on_map {
        None
    } else {
        let suite = suite_named(&args.beside).context("--beside")?;
        Some(Prepared::world_of(suite)?)
    };
    let known = match &beside {
        Some(other) => Known::Off(other),
        None => Known::Start(level_of_start(&args.start)?),
    };
    let without = args.without.map(|part| match part {
        RegistrationPart::FreeSpace => Without::FreeSpace,
        RegistrationPart::BuildingOffsets => Without::BuildingOffsets,
        RegistrationPart::HypothesisBank => Without::HypothesisBank,
    });
    let suites = suites(args)?;
    let bar = progress_bar(2 * suites.len(), "worlds recorded and tried");
    let threads = usize::from(args.jobs);
    let mut worlds = BTreeMap::new();
    let mut all = Vec::new();
    let mut of_peers = BTreeMap::new();
    let mut lines = String::new();
    let map = map_in_words(&args.level, args.missing);
    for (name, suite) in suites {
        let prepared = Prepared::world_of(suite)?;
        prepared.warnings().iter().for_each(|warning| tell(warning));
        let drives = drives(args, &name, &prepared)?;
        bar.inc(1);
        let own = seed_of(&name, args.seed);
        let drives = with_drift(drives, args.odometry_drift, own);
        let cases = cases(&prepared, &drives, &errors, known, own)?;
        if args.examples.is_some() {
            for example in examples(&cases, threads) {
                let labelled = (&name, &map, &args.start, example);
                writeln!(lines, "{}", serde_json::to_string(&labelled)?)?;
            }
        } else {
            let moments = trials(&prepared, &cases, without, threads);
            worlds.insert(name, Report::of(&moments, is_on_map));
            all.extend(moments);
            for peer in peers(args) {
                let known: &mut Vec<_> = of_peers.entry(peer.name()).or_default();
                known.extend(peer_trials(&peer, &cases, threads)?);
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(path) = &args.examples {
        write_atomically(path, lines.as_bytes())?;
        return Ok(Outcome::Done);
    }
    let found = Found {
        level: args.level.clone(),
        missing: args.missing,
        start: args.start.clone(),
        labels: args.labels,
        without: args.without,
        drive_m: args.drive,
        odometry_drift: args.odometry_drift,
        seed: args.seed,
        all: Report::of(&all, is_on_map),
        worlds,
        peers: of_peers
            .into_iter()
            .map(|(name, moments)| (name, Report::of_peer(&moments)))
            .collect(),
    };
    if args.json {
        say_json(&found)?;
    } else {
        say(&table(&found))?;
    }
    Ok(Outcome::Done)
}

/// Other ways that are asked for.
fn peers(args: &BenchLocalizationArgs) -> impl Iterator<Item = PeerKind> {
    let built_in = PeerKind::BUILT_IN.into_iter().filter(|_| args.peers);
    // A name without a folder is a file, and no command of the search path.
    let file = |path: &PathBuf| PeerKind::Program(Path::new(".").join(path));
    built_in.chain(args.peer.iter().map(file))
}

/// The seed of starts and map errors in a world: by its name, so that worlds do not share their
/// draws, and each has its own whichever others are tried. A world in a folder is named by that
/// folder, wherever it lies.
fn seed_of(name: &str, seed: u64) -> u64 {
    let name = Path::new(name).file_name().unwrap_or(name.as_ref());
    let bytes = name.as_encoded_bytes().iter();
    bytes.fold(seed, |mixed, byte| mixed_seed(mixed, u64::from(*byte)))
}

/// The level of a condition with a name.
fn level<C: Condition>(name: &str) -> anyhow::Result<C> {
    let found = C::LEVELS.iter().find(|(known, _)| *known == name);
    found.map(|(_, level)| *level).with_context(|| {
        let known: Vec<&str> = C::LEVELS.iter().map(|(name, _)| *name).collect();
        format!(
            "there is no level `{name}`; write one of {}",
            known.join(", ")
        )
    })
}

/// What is wrong with the map.
fn errors_of_map(args: &BenchLocalizationArgs) -> anyhow::Result<MapErrors> {
    let errors: MapErrors = level(&args.level).context("--level")?;
    let missing = args.missing.unwrap_or(errors.missing);
    Ok(MapErrors { missing, ..errors })
}

/// The map's level, and what differs from it.
fn map_in_words(level: &str, missing: Option<f64>) -> String {
    missing.map_or(level.to_owned(), |share| {
        format!("{level}, {} % of the buildings missing", 100.0 * share)
    })
}

fn level_of_start(name: &str) -> anyhow::Result<StartErrors> {
    level(name).context("--start, where `off` is also possible")
}

/// The worlds that are asked for, with their names.
fn suites(args: &BenchLocalizationArgs) -> anyhow::Result<Vec<(String, Suite)>> {
    if let Some(world) = args.imported.source() {
        let file = args.imported.world.as_deref().and_then(Path::file_stem);
        let name = file.map_or("world".into(), |stem| stem.to_string_lossy().into_owned());
        let suite = Suite {
            goal: GoalKind::default(),
            name: name.clone(),
            world,
            targets: TargetSource::World,
            traffic: TrafficPlan::default(),
            episodes: Vec::new(),
            sensors: Sensors::default(),
            conditions: Conditions::default(),
            seed: 0,
        };
        return Ok(vec![(name, suite)]);
    }
    let named = args
        .worlds
        .iter()
        .map(|name| Ok((name.clone(), suite_named(name)?)));
    named.collect()
}

/// The drives through a world: those that are kept, or new ones.
fn drives(
    args: &BenchLocalizationArgs,
    name: &str,
    prepared: &Prepared,
) -> anyhow::Result<Vec<Drive>> {
    let what = Recording {
        metres: args.drive,
        count: args.poses as usize,
        labels: match args.labels {
            LabelSource::Geometry => Labels::Geometry,
            LabelSource::Truth => Labels::Truth,
        },
        seed: args.seed,
    };
    let kept = args
        .drives
        .as_deref()
        .map(|folder| folder.join(kept(name, &what)));
    if let Some(path) = kept.as_deref().filter(|path| path.exists()) {
        let read = || -> anyhow::Result<Vec<Drive>> {
            with_legs(serde_json::from_slice(&std::fs::read(path)?)?)
        };
        let mut drives = read().with_context(|| {
            format!(
                "{}: no recorded drives; delete it to record anew",
                path.display()
            )
        })?;
        if drives.len() >= what.count {
            drives.truncate(what.count);
            return Ok(drives);
        }
    }
    let drives = record(prepared, &what, usize::from(args.jobs))?;
    if let Some(path) = kept {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        write_atomically(&path, &serde_json::to_vec(&drives)?)?;
    }
    Ok(drives)
}

/// Drives that were read, if each has a leg.
fn with_legs(drives: Vec<Drive>) -> anyhow::Result<Vec<Drive>> {
    let has_legs = |drive: &Drive| !drive.legs.is_empty();
    anyhow::ensure!(drives.iter().all(has_legs), "a drive has no legs");
    Ok(drives)
}

/// Drives with the drift that is asked for.
fn with_drift(drives: Vec<Drive>, share: Option<f64>, seed: u64) -> Vec<Drive> {
    let Some(share) = share else { return drives };
    let numbered = (0_u64..).zip(&drives);
    numbered
        .map(|(number, drive)| drifting(drive, share, mixed_seed(seed, number)))
        .collect()
}

/// Name of the file in which the drives through a world are kept.
fn kept(world: &str, what: &Recording) -> String {
    let mut name: String = world
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect();
    if what.metres != DRIVE_M {
        let _ = write!(name, "-{}m", what.metres);
    }
    if what.labels == Labels::Truth {
        name.push_str("-truth");
    }
    format!("{name}-seed-{}.json", what.seed)
}

fn table(found: &Found) -> String {
    let mut text = header(found);
    text.push_str(&line([
        "world",
        "n",
        "within 3 m: 0/20/40/60 m",
        "1 m",
        "accepted",
        "fixes",
        "wrong",
        "inside 95",
        "wall .5 m",
        "ms",
    ]));
    for (name, report) in &found.worlds {
        text.push_str(&row(name, report));
    }
    text.push_str(&row("all", &found.all));
    for (name, report) in &found.peers {
        text.push_str(&row(&format!("by {name}"), report));
    }
    text.push_str(
        "\nRates in percent. 1 m: within 1 m after 40 m. Wrong: accepted fixes off by more than 5 m.
Inside 95: fixes inside their ellipsoid of 95 %. Wall: distance to the nearest wall right within
0.5 m. ms: median computing time of an attempt while localized.\n",
    );
    let along = &found.all.along;
    if let (Some(median), Some(most)) = (along.p50_m, along.p95_m) {
        let _ = writeln!(
            text,
            "All along, the pose is accepted in {} % and right within 1 m in {} %; accepted ones \
             are off by {median:.2} m in the median and by {most:.2} m at 95 %.",
            percent(along.located),
            percent(along.within_1m),
        );
    }
    if let Some(rate) = found.all.rejected_off_map {
        let _ = writeln!(
            text,
            "Beside the map, {} % of the drives have no fix.",
            percent(Some(rate))
        );
    }
    text
}

/// What was tried. Injected truth, drift and parts left out are said in words.
fn header(found: &Found) -> String {
    let map = map_in_words(&found.level, found.missing);
    let mut text = format!("map {map}, start {}", found.start);
    if found.labels == LabelSource::Truth {
        text.push_str(", true labels");
    }
    if let Some(part) = found.without {
        let part = match part {
            RegistrationPart::FreeSpace => "free space",
            RegistrationPart::BuildingOffsets => "building offsets",
            RegistrationPart::HypothesisBank => "hypothesis bank",
        };
        let _ = write!(text, ", without {part}");
    }
    if found.drive_m != DRIVE_M {
        let _ = write!(text, ", drives of {} m", found.drive_m);
    }
    if let Some(share) = found.odometry_drift {
        let _ = write!(text, ", {} % of drift added", 100.0 * share);
    }
    text.push('\n');
    text
}

fn row(name: &str, report: &Report) -> String {
    let recall = |after: &str, limit: &str| percent(report.recall[after][limit]);
    let within = ["0m", "20m", "40m", "60m"].map(|after| recall(after, "3"));
    line([
        name,
        &report.n.to_string(),
        &within.join(" / "),
        &recall("40m", "1"),
        &percent(report.accepted),
        &report.fixes.to_string(),
        &report.wrong_5m.to_string(),
        &percent(report.inside_95),
        &percent(report.wall_relative["0.5"]),
        &report
            .ms_p50
            .map_or("–".to_owned(), |ms| format!("{ms:.1}")),
    ])
}

/// A line of the table.
fn line(
    [
        world,
        n,
        within,
        metre,
        accepted,
        fixes,
        wrong,
        inside,
        wall,
        ms,
    ]: [&str; 10],
) -> String {
    format!(
        "{world:<30}  {n:>5}  {within:>27}  {metre:>5}  {accepted:>8}  {fixes:>6}  {wrong:>5}  \
         {inside:>9}  {wall:>9}  {ms:>5}\n"
    )
}

fn percent(rate: Option<f64>) -> String {
    rate.map_or("–".to_owned(), |rate| format!("{:.1}", 100.0 * rate))
}
