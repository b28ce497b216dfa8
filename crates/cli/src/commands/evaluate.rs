//! `openbench evaluate`

use openbench_bench::score::evaluate::evaluate;

use crate::args::EvaluateArgs;
use crate::outcome::{Outcome, say_json};

/// Prints the metrics of a recorder's log.
pub fn run(args: &EvaluateArgs) -> anyhow::Result<Outcome> {
    say_json(&evaluate(&args.log, &args.truth, args.sequence)?)?;
    Ok(Outcome::Done)
}
