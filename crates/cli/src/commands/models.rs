//! `openbench models`

use openbench_models::{CATALOGUE, ModelStore, catalogue};

use crate::args::{ModelsArgs, ModelsCommand};
use crate::outcome::{Outcome, say};
use crate::progress::PullProgress;

/// Does what is asked with model files.
pub fn run(args: &ModelsArgs) -> anyhow::Result<Outcome> {
    let store = ModelStore::from_environment()?;
    match &args.command {
        ModelsCommand::List => list(&store),
        ModelsCommand::Pull { name } if is_file(name) => {
            say(&format!("{}\n", store.add(name.as_ref())?.display()))?;
            Ok(Outcome::Done)
        }
        // The path of a file that does not exist, rather than an unknown name of the catalogue.
        ModelsCommand::Pull { name } if name.contains('/') || name.ends_with(".gguf") => {
            anyhow::bail!("there is no file {name}")
        }
        ModelsCommand::Pull { name } => {
            let mut progress = PullProgress::default();
            for path in store.download(name, &mut |event| progress.show(event))? {
                say(&format!("{}\n", path.display()))?;
            }
            Ok(Outcome::Done)
        }
    }
}

/// Whether a word means a file of the user's and no name of the catalogue.
fn is_file(word: &str) -> bool {
    catalogue::named(word).is_empty() && std::path::Path::new(word).is_file()
}

fn list(store: &ModelStore) -> anyhow::Result<Outcome> {
    for file in &CATALOGUE {
        let here = if store.contains(file) {
            "here"
        } else {
            "not here"
        };
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
