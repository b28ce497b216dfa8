//! `openbench verify`

use openbench_bench::Prepared;
use openbench_bench::recording::{Recording, RunRecord, verify};

use crate::args::VerifyArgs;
use crate::outcome::{Outcome, say};
use crate::progress::progress_bar;

/// Drives a run's actions again.
pub fn run(args: &VerifyArgs) -> anyhow::Result<Outcome> {
    let record = RunRecord::read(&args.run)?;
    if record.version != env!("CARGO_PKG_VERSION") {
        anyhow::bail!(
            "{} was made by version {}, this is {}; the same bytes are promised within one version only",
            args.run.display(),
            record.version,
            env!("CARGO_PKG_VERSION")
        );
    }
    if record.episodes == 0 {
        anyhow::bail!("{} holds no episodes; nothing can be verified", args.run.display());
    }
    let recordings: Result<Vec<Recording>, _> =
        (0..record.episodes).map(|i| Recording::read(&args.run, i)).collect();
    let recordings = recordings?;
    let prepared = Prepared::world_of(record.suite)?;
    let bar = progress_bar(recordings.len(), "verifying");
    for (number, recording) in recordings.iter().enumerate() {
        verify(&prepared, number, recording)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    say(&format!("{}: {} episodes repeat to the bit\n", args.run.display(), recordings.len()))?;
    Ok(Outcome::Done)
}
