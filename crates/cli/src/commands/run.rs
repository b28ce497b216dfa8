//! `openbench run`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use openbench_bench::plural::count;
use openbench_bench::report::terminal_table;
use openbench_bench::suite::draw::Draw;
use openbench_bench::suite::{Condition, Conditions, GoalKind, Sensors, deliveries};
use openbench_bench::worlds::{is_drawn_by_seed, is_name, load, suite_of_seed};
use openbench_bench::{
    AgentFactory, Agents, BenchError, Episode, InterruptedRun, Prepared, Results, RunRequest,
    Suite, TargetSource, TrafficPlan, Unfinished, WorldSource, interrupted,
};
use openbench_core::Address;
use openbench_osm::{OsmData, lost_in_merge};

use crate::args::{RunArgs, Targets};
use crate::commands::driving::drive_with_progress;
use crate::commands::{planned_targets, read_map, seeds};
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::PullProgress;
use crate::signals::StopSignal;

/// Runs a suite and prints the results.
pub fn run(args: &RunArgs, agents: &Agents) -> anyhow::Result<Outcome> {
    let stop = StopSignal::catch().context("signals cannot be caught")?;
    match &args.resume {
        Some(out) => resume(out, args, agents, &stop),
        None => begin(args, agents, &stop),
    }
}

/// Runs a suite from its first episode.
fn begin(args: &RunArgs, agents: &Agents, stop: &StopSignal) -> anyhow::Result<Outcome> {
    let factory = agent_named(agents, &args.agent)?;
    let factory = factory.as_ref();
    let settings = settings(args);
    // First of all: a misspelt setting is found at once, while building the world takes a while.
    check_agent(factory, &settings)?;
    if args.seeds.is_none() {
        seeds::refuse_several_runs(&args.out)?;
    }
    let unfinished = if args.discard {
        Unfinished::Discard
    } else {
        refuse_unfinished(&args.out)?;
        Unfinished::Keep
    };
    let prepared = prepare(args, first_seeds(args))?;
    warn(&prepared);
    charge_once(&prepared.suite, factory, &settings)?;
    let fits = factory.check_robot(&settings, &prepared.robot);
    fits.map_err(anyhow::Error::from_boxed)?;
    prepare_agent(factory, &settings)?;
    reach_server(factory, &settings)?;
    let mut read = factory.inputs(&settings);
    read.extend(inputs(args, &prepared.suite.world));
    for out in seeds::folders(args) {
        spare(&out, &read)?;
    }
    if let Some(memory) = &args.memory {
        spare_inputs(memory, &prepared.suite.world, args)?;
    }
    let memory = args
        .memory
        .as_deref()
        .map(read_memory)
        .transpose()?
        .flatten();
    if let (Some(path), Some(memory)) = (&args.memory, &memory) {
        refuse_other_maps(&prepared, path, memory)?;
    }
    // From wherever the run is resumed.
    let memory_file = args
        .memory
        .as_deref()
        .map(std::path::absolute)
        .transpose()?;
    let request = RunRequest {
        prepared: &prepared,
        agent: &args.agent,
        factory,
        settings: &settings,
        seed: first_seeds(args).noise,
        jobs: usize::from(args.jobs),
        level: args.record,
        out: Some(&args.out),
        unfinished,
        memory: memory.as_ref(),
        memory_file: memory_file.as_deref(),
        build: &crate::build(),
        command: &command_line(),
        progress: &|_| {},
        stop: stop.asked(),
    };
    match &args.seeds {
        None => drive(request, args, stop),
        Some(seeds) => {
            let world_of = |seed| own_world(args, &prepared, seed);
            seeds::drive_each(seeds, &request, &world_of, args, stop)
        }
    }
}

/// Runs what is missing of an interrupted run.
fn resume(
    out: &Path,
    args: &RunArgs,
    agents: &Agents,
    stop: &StopSignal,
) -> anyhow::Result<Outcome> {
    let Some(InterruptedRun {
        record,
        memory,
        finished,
    }) = interrupted(out)?
    else {
        let results = out.join(Results::FILE);
        if !results.exists() {
            anyhow::bail!("{} contains no run that was interrupted", out.display());
        }
        tell(&format!("the run in {} is complete", out.display()));
        return print(&Results::read(&results)?, out, args);
    };
    tell(&format!(
        "{finished} of {} finished",
        count(record.episodes, "episode", "episodes")
    ));
    let factory = agent_named(agents, &record.agent)?;
    let factory = factory.as_ref();
    check_agent(factory, &record.settings)?;
    let prepared = Prepared::new(record.suite.clone(), record.truth.as_deref())?;
    prepare_agent(factory, &record.settings)?;
    reach_server(factory, &record.settings)?;
    let request = RunRequest {
        jobs: usize::from(args.jobs),
        level: record.logs,
        out: Some(out),
        unfinished: Unfinished::Resume,
        memory: memory.as_ref(),
        memory_file: record.memory_file.as_deref(),
        build: &crate::build(),
        stop: stop.asked(),
        ..record.request(&prepared, factory)
    };
    drive(request, args, stop)
}

/// Drives the episodes of a request that has a folder, and prints the results.
fn drive(request: RunRequest<'_>, args: &RunArgs, stop: &StopSignal) -> anyhow::Result<Outcome> {
    if let Some(path) = request.memory_file {
        probe(path)?;
    }
    let out = request.out.unwrap_or(&args.out);
    match drive_with_progress(request) {
        Err(BenchError::Interrupted) => {
            tell(&stopped(out)?);
            Ok(Outcome::Stopped(stop.number()))
        }
        results => print(&results?, out, args),
    }
}

/// What is said about a run that was stopped.
fn stopped(out: &Path) -> anyhow::Result<String> {
    let left = interrupted(out)?;
    Ok(left.map_or("stopped".to_owned(), |left| {
        format!(
            "stopped; {} of {} finished; continue with: openbench run --resume {}",
            left.finished,
            count(left.record.episodes, "episode", "episodes"),
            out.display()
        )
    }))
}

fn print(results: &Results, out: &Path, args: &RunArgs) -> anyhow::Result<Outcome> {
    if args.json {
        say_json(results)?;
    } else {
        say(&terminal_table(results))?;
    }
    tell(&format!("report: {}", out.join("report.html").display()));
    Ok(Outcome::Done)
}

/// Refuses a folder with an interrupted run, before a world is built for nothing.
fn refuse_unfinished(out: &Path) -> Result<(), BenchError> {
    match interrupted(out)? {
        Some(left) if left.finished > 0 => Err(BenchError::Unfinished {
            folder: out.to_owned(),
            finished: left.finished,
            episodes: left.record.episodes,
        }),
        _ => Ok(()),
    }
}

/// The doors in a memory's file; `None` if there is no file: the first of several runs with one
/// memory begins without it.
fn read_memory(path: &Path) -> anyhow::Result<Option<OsmData>> {
    if !path.exists() {
        return Ok(None);
    }
    // Through XML, as the run's folder keeps it: a repeated run then starts from equal numbers.
    let memory = OsmData::read(path)?;
    Ok(Some(OsmData::from_bytes(&memory.to_xml())?))
}

/// Refuses a memory that no run has written: the map from which the world is made, which has doors
/// that nobody has seen, and any map that would lose something when it is replaced.
fn refuse_other_maps(prepared: &Prepared, path: &Path, memory: &OsmData) -> anyhow::Result<()> {
    if prepared.is_own_map(memory) {
        anyhow::bail!(
            "{} has the doors of the world exactly where they are: it is the map that the world \
             is made from, and no memory of a run; name another file, which may be a new one",
            path.display()
        );
    }
    // As it is written: XML cannot represent each character.
    let public = OsmData::from_bytes(&prepared.public_data().to_xml())?;
    match lost_in_merge(&public, memory) {
        0 => Ok(()),
        lost => anyhow::bail!(
            "{} is no memory of this world: {lost} of its elements are not in the public map, or \
             have other tags there; --memory replaces the file when the run is complete, so name a \
             new one",
            path.display()
        ),
    }
}

/// The files and folders that a run reads, besides those of its agent.
fn inputs(args: &RunArgs, world: &WorldSource) -> Vec<PathBuf> {
    let named = [&args.deliveries, &args.truth, &args.memory];
    // A folder that happens to be called as a built-in suite is none that is read.
    let suite = args.suite.as_ref().filter(|name| !is_name(name));
    let suite = suite.map(PathBuf::from);
    let paths = world.paths().into_iter().map(Path::to_owned);
    paths
        .chain(named.into_iter().flatten().cloned())
        .chain(suite)
        .collect()
}

/// Refuses a memory that is another input of the run, or a file of its results: it is written when
/// the run is complete.
fn spare_inputs(memory: &Path, world: &WorldSource, args: &RunArgs) -> anyhow::Result<()> {
    let results = ["run.json", Results::FILE, "report.html"].map(|name| args.out.join(name));
    let others = inputs(args, world).into_iter();
    let all = others.filter(|path| path != memory).chain(results);
    // A file that does not exist yet lies where its folder is.
    let whole = |path: &Path| {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
        path.canonicalize()
            .ok()
            .or(Some(folder.join(path.file_name()?)))
    };
    let Some(memory) = whole(memory) else {
        // The error is that of the file that cannot be written.
        return Ok(());
    };
    match all
        .into_iter()
        .find(|path| whole(path).is_some_and(|path| memory.starts_with(path)))
    {
        Some(path) => anyhow::bail!(
            "{} belongs to {}, and would be replaced when the run is complete; name another file, \
             which may be a new one, or copy it",
            memory.display(),
            path.display()
        ),
        None => Ok(()),
    }
}

/// Refuses an input file that the run itself would replace or remove.
fn spare(out: &Path, read: &[PathBuf]) -> anyhow::Result<()> {
    // A folder that does not exist holds nothing to be replaced.
    let Ok(folder) = out.canonicalize() else {
        return Ok(());
    };
    for path in read {
        // A missing file is reported where it is read.
        let Ok(full) = path.canonicalize() else {
            continue;
        };
        let replaced = [
            "episodes",
            openbench_bench::UNFINISHED,
            openbench_bench::MEMORY_BEFORE,
            "run.json",
            "report.html",
            Results::FILE,
        ]
        .map(|name| folder.join(name));
        if replaced.iter().any(|replaced| full.starts_with(replaced)) {
            anyhow::bail!(
                "{} belongs to an earlier run in {}, which is replaced; copy it, or choose \
                 another folder with --out",
                path.display(),
                out.display()
            );
        }
    }
    Ok(())
}

/// Whether a file can be written, before hours are driven for it.
fn probe(path: &Path) -> anyhow::Result<()> {
    // Beside the file, where `write_atomically` will put its staging file: the folder must be
    // writable.
    let name = format!("{}.probe-{}", path.display(), std::process::id());
    let made = std::fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&name);
    made.with_context(|| format!("{} cannot be written", path.display()))?;
    Ok(std::fs::remove_file(&name)?)
}

/// The agent of a name.
pub(super) fn agent_named(agents: &Agents, name: &str) -> anyhow::Result<Arc<dyn AgentFactory>> {
    agents.get(name).map_err(anyhow::Error::from_boxed)
}

/// Lets an agent check its settings.
pub(super) fn check_agent(
    factory: &dyn AgentFactory,
    settings: &BTreeMap<String, String>,
) -> anyhow::Result<()> {
    factory.check(settings).map_err(anyhow::Error::from_boxed)
}

/// Lets an agent download what it needs.
pub(super) fn prepare_agent(
    factory: &dyn AgentFactory,
    settings: &BTreeMap<String, String>,
) -> anyhow::Result<()> {
    let mut progress = PullProgress::default();
    factory
        .prepare(settings, &mut |event| progress.show(event))
        .map_err(anyhow::Error::from_boxed)
}

/// Checks that the server of an agent can be reached, so that nothing is run without it.
fn reach_server(
    factory: &dyn AgentFactory,
    settings: &BTreeMap<String, String>,
) -> anyhow::Result<()> {
    factory.reach(settings).map_err(anyhow::Error::from_boxed)
}

/// Tells what is missing in a world, and for the deliveries in it.
fn warn(prepared: &Prepared) {
    let name = &prepared.world.name;
    let world = prepared.world.warnings.iter();
    world.for_each(|w| tell(&format!("{name}: {w}")));
    prepared.warnings().iter().for_each(|w| tell(w));
}

/// Refuses to charge for models by the clock and by the table. Agents that are charged by the clock
/// alone report no work of the table.
fn charge_once(
    suite: &Suite,
    factory: &dyn AgentFactory,
    settings: &BTreeMap<String, String>,
) -> anyhow::Result<()> {
    let by_clock = settings.get("thinking").is_some_and(|how| how == "charged");
    let by_both = by_clock && !factory.is_charged_by_clock(settings);
    anyhow::ensure!(
        suite.conditions.compute.is_off() || !by_both,
        "models would be charged twice: by the clock (--realtime, thinking=charged) and by the \
         table of `compute`; leave one out"
    );
    Ok(())
}

/// The settings of the agent.
fn settings(args: &RunArgs) -> BTreeMap<String, String> {
    let realtime = args.realtime.then(|| ("thinking".into(), "charged".into()));
    let given = args.settings.iter().cloned();
    realtime.into_iter().chain(given).collect()
}

/// The name of the suite to run.
fn suite_name(args: &RunArgs) -> &str {
    args.suite.as_deref().unwrap_or("small")
}

/// The seeds of one run.
#[derive(Debug, Clone, Copy)]
struct RunSeeds {
    /// Of the neighbourhood.
    world: u64,
    /// Of noise, traffic and conditions.
    noise: u64,
}

/// The seeds of the run, or of the first of several.
fn first_seeds(args: &RunArgs) -> RunSeeds {
    let world = args
        .seeds
        .as_ref()
        .map_or(args.seed, |seeds| *seeds.start());
    RunSeeds {
        world,
        noise: args.noise_seed.unwrap_or(world),
    }
}

/// Builds the world of the suite for the seeds of a run.
fn prepare(args: &RunArgs, seeds: RunSeeds) -> anyhow::Result<Prepared> {
    let (mut suite, truth) = match (&args.world, &args.map) {
        (Some(world), Some(map)) => (imported(args, world, map)?, args.truth.as_deref()),
        _ => (suite_of_seed(suite_name(args), seeds.world)?, None),
    };
    for (asked, planned) in [
        (args.pedestrians, &mut suite.traffic.pedestrians),
        (args.cars, &mut suite.traffic.cars),
    ] {
        *planned = asked.map_or(*planned, usize::from);
    }
    set_conditions(&mut suite, &args.conditions)?;
    Ok(Prepared::new(suite.with_seed(seeds.noise), truth)?)
}

/// The world of one of several seeds, where it differs from that of the first one.
fn own_world(args: &RunArgs, first: &Prepared, seed: u64) -> anyhow::Result<Option<Prepared>> {
    if args.world.is_some() || !is_drawn_by_seed(suite_name(args)) {
        return Ok(first.of_seed(seed)?);
    }
    let is_first = first_seeds(args).world == seed;
    let seeds = RunSeeds {
        world: seed,
        noise: seed,
    };
    let own = (!is_first).then(|| prepare(args, seeds)).transpose()?;
    own.iter().for_each(warn);
    Ok(own)
}

/// Sets what `--condition` says.
pub(super) fn set_conditions(
    suite: &mut Suite,
    conditions: &[(String, String)],
) -> anyhow::Result<()> {
    let words = conditions.iter().map(|(key, value)| (&**key, &**value));
    suite.conditions.set_all(words).context("--condition")
}

fn imported(args: &RunArgs, world: &Path, map: &Path) -> anyhow::Result<Suite> {
    // Absolute, since `run.json` has these paths, and `verify` may be started in another folder.
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let source = WorldSource::Imported {
        world: absolute(world),
        map: absolute(map),
        models: args.models.iter().map(|m| absolute(m)).collect(),
        georeference: args.georef.clone(),
    };
    let name = world
        .file_stem()
        .map_or("world".into(), |s| s.to_string_lossy().into_owned());
    let (episodes, targets) = match (&args.deliveries, args.draw.as_deref()) {
        (Some(file), _) => given(args, file, map)?,
        (None, Some(&[singles, sequences, length])) => {
            let doors: Vec<Address> = load(&source)?
                .scene
                .doors
                .into_iter()
                .map(|d| d.address)
                .collect();
            let mut draw = Draw::new(doors, args.seed);
            let mut episodes = draw.singles(singles);
            episodes.extend(draw.sequences(sequences, length));
            (episodes, TargetSource::World)
        }
        _ => anyhow::bail!(
            "say what to deliver: --deliveries FILE, or --draw SINGLES SEQUENCES LENGTH"
        ),
    };
    Ok(Suite {
        goal: GoalKind::default(),
        name,
        world: source,
        targets,
        traffic: TrafficPlan::default(),
        episodes,
        sensors: Sensors::default(),
        conditions: Conditions::default(),
        seed: 0,
    })
}

/// The episodes of a file of deliveries.
fn given(args: &RunArgs, file: &Path, map: &Path) -> anyhow::Result<(Vec<Episode>, TargetSource)> {
    let episodes = deliveries::read(file)?;
    match args.targets {
        Some(_) if deliveries::is_annotated(file) => anyhow::bail!(
            "{}: the file says itself which doors are meant; leave --targets out",
            file.display()
        ),
        Some(Targets::Planner) => {
            let episodes = planned_targets::read_doors(episodes, &read_map(map)?)
                .with_context(|| format!("{} cannot be used", file.display()))?;
            Ok((episodes, TargetSource::Planner))
        }
        // Before the world is built, which takes a while.
        None if args.truth.is_none() && !deliveries::is_annotated(file) => anyhow::bail!(
            "{}: nobody says which doors its instructions mean; give true positions with --truth, \
             a JSONL file with annotations, or --targets planner to let OPEN's grammar read them, \
             whose errors are then not seen",
            file.display()
        ),
        None => Ok((episodes, TargetSource::Annotation)),
    }
}

/// The command line as it was given.
fn command_line() -> String {
    let mut words = std::env::args();
    // The name alone: a program with agents of its own has another one, its folder is the user's.
    let program = words.next().map(PathBuf::from);
    let name = program
        .as_deref()
        .and_then(|path| path.file_name()?.to_str());
    let mut line = name.unwrap_or("openbench").to_owned();
    for word in words {
        line.push(' ');
        line += &quoted(word);
    }
    line
}

/// A word as a shell takes it for one.
fn quoted(word: String) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_=./:,@%+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
