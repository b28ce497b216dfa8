//! `openbench data`, against a server on this machine. No test asks the sources themselves.

mod common;

use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Output};

use flate2::Compression;
use flate2::write::GzEncoder;

/// The published worlds, where the data beside the project has them.
const PUBLISHED: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../../shared/data/openbench"
);

fn pull(mirror: &str, name: &str, out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_openbench"));
    command.args(["data", "pull", name, "--out"]).arg(out);
    command
        .env("OPENBENCH_DATA_MIRROR", mirror)
        .output()
        .unwrap()
}

/// A server that answers one request with these bytes; its address.
fn serve(body: Vec<u8>) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut request = [0; 4096];
        let _ = stream.read(&mut request);
        let head = format!("HTTP/1.1 200 OK\r\ncontent-length: {}\r\n\r\n", body.len());
        let _ = stream.write_all(head.as_bytes());
        let _ = stream.write_all(&body);
    });
    address
}

/// An archive with these files, under names of its own.
fn archive(files: &[Vec<u8>]) -> Vec<u8> {
    let mut builder = tar::Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
    for (i, bytes) in files.iter().enumerate() {
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        builder
            .append_data(&mut header, format!("repository/file{i}"), bytes.as_slice())
            .unwrap();
    }
    builder.into_inner().unwrap().finish().unwrap()
}

/// All files of the published worlds, and others among them.
fn published() -> Option<Vec<Vec<u8>>> {
    let mut files = vec![b"a README".to_vec()];
    for world in ["small", "medium"] {
        for entry in std::fs::read_dir(Path::new(PUBLISHED).join(world)).ok()? {
            files.push(std::fs::read(entry.ok()?.path()).ok()?);
        }
    }
    Some(files)
}

#[test]
fn files_of_an_archive_are_recognised_by_their_content() {
    let Some(files) = published() else {
        common::skipped(&format!("there is no {PUBLISHED}"));
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let ran = pull(&serve(archive(&files)), "published", place.path());
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let world = place.path().join("published/small/small_osm.world");
    let original = Path::new(PUBLISHED).join("small/small_osm.world");
    assert_eq!(
        std::fs::read(world).unwrap(),
        std::fs::read(original).unwrap()
    );
    // All files are here now, so nobody is asked.
    let again = pull("http://127.0.0.1:9", "published", place.path());
    assert!(
        again.status.success(),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );
}

#[test]
fn an_archive_without_the_pinned_files_is_refused_with_their_names() {
    let place = tempfile::tempdir().unwrap();
    let ran = pull(
        &serve(archive(&[b"something else".to_vec()])),
        "published",
        place.path(),
    );
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(2), "{said}");
    assert!(
        said.contains("small/small_osm.world") && said.contains("changed"),
        "{said}"
    );
    assert!(!place.path().join("published").exists());
}

#[test]
fn what_is_no_archive_and_what_is_longer_is_refused() {
    let place = tempfile::tempdir().unwrap();
    for (name, body) in [
        ("published", b"<html>".to_vec()),
        ("sample-map", vec![7; 1 << 20]),
    ] {
        let ran = pull(&serve(body), name, place.path());
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert_eq!(ran.status.code(), Some(2), "{said}");
        assert!(said.contains("http://127.0.0.1"), "{said}");
    }
}

#[test]
fn a_name_that_there_is_not_is_answered_with_those_that_there_are() {
    let ran = pull("http://127.0.0.1:9", "large", Path::new("."));
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(2), "{said}");
    assert!(said.contains("published, sample-map"), "{said}");
}
