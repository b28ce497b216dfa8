//! `openbench compare`

use openbench_bench::report::comparison_table;
use openbench_bench::score::across::{System, compare};

use crate::args::CompareArgs;
use crate::outcome::{Outcome, say, say_json};

/// Prints how systems differ from the first one.
pub fn run(args: &CompareArgs) -> anyhow::Result<Outcome> {
    let systems = args.runs.iter().map(|path| System::read(path));
    let systems: Vec<System> = systems.collect::<Result<_, _>>()?;
    let comparison = compare(&systems, args.points / 100.0)?;
    if args.json {
        say_json(&comparison)?;
    } else {
        say(&comparison_table(&comparison))?;
    }
    Ok(Outcome::Done)
}
