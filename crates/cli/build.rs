//! Tells the program from which commit it is built. Results name it.

use std::path::Path;
use std::process::Command;

fn main() {
    let target = std::env::var("TARGET").unwrap_or_default();
    println!("cargo::rustc-env=OPENBENCH_TARGET={target}");
    let commit = packaged().or_else(described);
    let commit = commit.unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=OPENBENCH_COMMIT={commit}");
}

/// The commit of a crate from a registry, as `cargo package` has noted it.
fn packaged() -> Option<String> {
    const NOTE: &str = ".cargo_vcs_info.json";
    let text = std::fs::read_to_string(NOTE).ok()?;
    let (_, rest) = text.split_once("\"sha1\"")?;
    rest.split('"').nth(1).map(str::to_owned)
}

/// The commit of a checkout, with `-dirty` if files of it were edited.
fn described() -> Option<String> {
    let words = [
        "describe",
        "--always",
        "--dirty",
        "--abbrev=40",
        "--exclude=*",
    ];
    let git = |words: &[&str]| {
        let output = Command::new("git").args(words).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    let folder = git(&["rev-parse", "--absolute-git-dir"])?;
    // A commit changes the log of HEAD, and an edit one of the sources.
    let log = Path::new(&folder).join("logs/HEAD");
    for path in [log.as_path(), Path::new("..")] {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    git(&words)
}
