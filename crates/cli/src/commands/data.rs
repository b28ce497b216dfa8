//! `openbench data`

use openbench_core::UnknownName;

use crate::args::{DataArgs, DataCommand, DataPullArgs};
use crate::datasets::{Dataset, datasets, pull};
use crate::outcome::{Outcome, say, tell};
use crate::progress::download_spinner;

/// Lists or downloads published data.
pub fn run(args: &DataArgs) -> anyhow::Result<Outcome> {
    let sets = datasets()?;
    match &args.command {
        DataCommand::List => list(&sets),
        DataCommand::Pull(args) => download(args, &sets),
    }
}

fn list(sets: &[Dataset]) -> anyhow::Result<Outcome> {
    for set in sets {
        let bytes: u64 = set.files.iter().map(|file| file.bytes).sum();
        say(&format!(
            "{:<12} {}\n{:13}{} files, {:.1} MB; {}; {}\n",
            set.name,
            set.about,
            "",
            set.files.len(),
            bytes as f64 / 1e6,
            set.origin,
            set.licence
        ))?;
    }
    Ok(Outcome::Done)
}

fn download(args: &DataPullArgs, sets: &[Dataset]) -> anyhow::Result<Outcome> {
    for name in &args.names {
        let set = sets
            .iter()
            .find(|set| set.name == *name)
            .ok_or_else(|| UnknownName {
                kind: "data set",
                name: name.clone(),
                known: sets.iter().map(|set| set.name.clone()).collect(),
            })?;
        let folder = args.out.join(&set.name);
        let spinner = download_spinner(&set.name);
        let stored = pull(set, &folder, &mut |bytes| spinner.set_position(bytes));
        // Before an error is returned, so that its message begins on an empty line.
        spinner.finish_and_clear();
        for path in stored? {
            say(&format!("{}\n", path.display()))?;
        }
        tell(&format!(
            "{}: from {}, licence {}",
            set.name, set.origin, set.licence
        ));
    }
    Ok(Outcome::Done)
}
