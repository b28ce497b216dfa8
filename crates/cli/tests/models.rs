//! `openbench models`, with a Python that only notes how it is started.
#![cfg(unix)]

mod common;

use std::os::unix::fs::PermissionsExt as _;
use std::process::Command;

use common::Place;

#[test]
fn pip_is_started_where_nothing_of_the_user_can_take_its_place() {
    let place = Place::new();
    std::fs::create_dir(place.path("bin")).unwrap();
    let script = format!(
        "#!/bin/sh\necho \"$PWD\" > '{0}'\necho \"$@\" >> '{0}'\nls -A | grep -v pip.log >> '{0}'\n\
         exit 1\n",
        place.path("noted").display()
    );
    place
        .file("bin/python3", script)
        .file("pip.py", "raise SystemExit('the user has a pip.py')\n");
    let python = place.path("bin/python3");
    std::fs::set_permissions(&python, std::fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:/usr/bin:/bin", place.path("bin").display());
    let output = Command::new(env!("CARGO_BIN_EXE_openbench"))
        .args(["models", "pull", "ppocr-v4"])
        .current_dir(place.path(""))
        .env("PATH", path)
        .env("XDG_CACHE_HOME", place.path("cache"))
        .output()
        .unwrap();
    assert!(!output.status.success(), "{output:?}");
    let noted = place.read("noted");
    let mut lines = noted.lines();
    let started_in = lines.next().unwrap();
    assert!(!place.path("").ends_with(started_in), "{noted}");
    // Isolated: neither the working folder nor the user's variables add modules.
    assert!(lines.next().unwrap().starts_with("-I -m pip"), "{noted}");
    assert_eq!(lines.next(), None, "the folder is empty: {noted}");
}
