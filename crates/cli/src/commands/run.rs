//! `openbench run`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use openbench_bench::report::terminal_table;
use openbench_bench::suite::draw::Draw;
use openbench_bench::suite::{Sensors, deliveries};
use openbench_bench::worlds::{folder, load};
use openbench_bench::{
    AgentFactory, Agents, Episode, Prepared, RunRequest, Suite, TargetSource, TrafficPlan,
    WorldSource, builtin_suite, builtin_suites,
};
use openbench_core::Address;
use openbench_osm::{OsmData, write_atomically};

use crate::args::{RunArgs, Targets};
use crate::commands::{planned_targets, read_map};
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::{PullProgress, progress_bar};

/// Runs a suite and prints the results.
pub fn run(args: &RunArgs, agents: &Agents) -> anyhow::Result<Outcome> {
    let factory = agents.get(&args.agent)?.as_ref();
    let settings: BTreeMap<String, String> = args.settings.iter().cloned().collect();
    // First of all: a misspelt setting is found at once, while building the world takes a while.
    check_agent(factory, &settings)?;
    let prepared = prepare(args)?;
    prepare_agent(factory, &settings)?;
    let read = factory
        .inputs(&settings)
        .into_iter()
        .chain(args.memory.clone());
    spare(&args.out, &read.collect::<Vec<_>>())?;
    let memory = args
        .memory
        .as_deref()
        // The first of several runs with one memory begins without the file.
        .filter(|path| path.exists())
        .map(OsmData::read)
        .transpose()?;
    // Through XML, as the run's folder keeps it: a repeated run then starts from equal numbers.
    let memory = memory
        .map(|memory| OsmData::from_bytes(&memory.to_xml()))
        .transpose()?;
    if let Some(path) = &args.memory {
        probe(path)?;
    }
    let bar = progress_bar(prepared.episodes.len(), "delivering");
    let request = RunRequest {
        prepared: &prepared,
        agent: &args.agent,
        factory,
        settings: &settings,
        seed: args.seed,
        jobs: usize::from(args.jobs),
        level: args.record,
        out: Some(&args.out),
        memory: memory.as_ref(),
        command: &command_line(),
        progress: &|done| bar.set_position(done as u64),
    };
    let output = openbench_bench::run(&request)?;
    bar.finish_and_clear();
    if let Some(path) = &args.memory {
        write_atomically(path, &output.memory.to_xml())?;
    }
    if args.json {
        say_json(&output.results)?;
    } else {
        say(&terminal_table(&output.results))?;
    }
    tell(&format!(
        "report: {}",
        args.out.join("report.html").display()
    ));
    Ok(Outcome::Done)
}

/// Refuses what the run is told to read from the folder that it clears first.
fn spare(out: &Path, read: &[PathBuf]) -> anyhow::Result<()> {
    // A folder that does not exist holds nothing to be cleared.
    let Ok(folder) = out.canonicalize() else {
        return Ok(());
    };
    for path in read {
        // A missing file is reported where it is read.
        let Ok(full) = path.canonicalize() else {
            continue;
        };
        let cleared = [
            folder.join("episodes"),
            folder.join(openbench_bench::MEMORY_BEFORE),
        ];
        if cleared.iter().any(|cleared| full.starts_with(cleared)) {
            anyhow::bail!(
                "{} belongs to an earlier run in {}, which is cleared first; copy it, or \
                 choose another folder with --out",
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

fn prepare(args: &RunArgs) -> anyhow::Result<Prepared> {
    let (mut suite, truth) = match (&args.world, &args.map) {
        (Some(world), Some(map)) => (imported(args, world, map)?, args.truth.as_deref()),
        _ => (named(args.suite.as_deref().unwrap_or("small"))?, None),
    };
    for (asked, planned) in [
        (args.pedestrians, &mut suite.traffic.pedestrians),
        (args.cars, &mut suite.traffic.cars),
    ] {
        *planned = asked.map_or(*planned, usize::from);
    }
    let prepared = Prepared::new(suite, truth)?;
    prepared
        .world
        .warnings
        .iter()
        .for_each(|w| tell(&format!("{}: {w}", prepared.world.name)));
    prepared.warnings().iter().for_each(|w| tell(w));
    Ok(prepared)
}

/// The suite that a word names.
pub(super) fn named(name: &str) -> anyhow::Result<Suite> {
    let path = Path::new(name);
    if folder::is_world(path) {
        return Ok(folder::suite_of(path)?);
    }
    // A folder that happens to be called as a built-in suite does not hide the suite.
    if path.is_dir() && !builtin_suites().iter().any(|known| known == name) {
        anyhow::bail!(
            "{name}: the folder has no world.toml; make a world with `openbench world generate`"
        );
    }
    let is_file = path.extension().is_some_and(|e| e == "toml");
    Ok(if is_file {
        Suite::read(path)?
    } else {
        builtin_suite(name)?
    })
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
    let (traffic, sensors) = (TrafficPlan::default(), Sensors::default());
    Ok(Suite {
        name,
        world: source,
        targets,
        traffic,
        episodes,
        sensors,
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
