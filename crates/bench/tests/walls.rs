//! The dependency rules of ARCHITECTURE.md, checked with `cargo metadata`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Layers: a crate may depend only on crates of lower layers.
const LAYERS: [(&str, u8); 20] = [
    ("openbench-core", 0),
    ("openbench-geometry", 1),
    ("openbench-models", 1),
    ("openbench-logs", 1),
    ("openbench-osm", 2),
    ("openbench-scene", 3),
    ("openbench-neighbourhoods", 3),
    ("openbench-language", 3),
    ("openbench-routing", 3),
    ("openbench-motion", 3),
    ("openbench-localization", 3),
    ("openbench-vision", 3),
    ("openbench-sim", 4),
    ("openbench-agents", 4),
    ("openbench-bench", 5),
    ("openbench-trials", 6),
    ("openbench-environment", 6),
    ("openbench", 7),
    ("extensions", 8),
    ("openbench-python", 8),
];

/// The folders of `bench`, from low to high: a file imports from its own folder and lower ones.
const BENCH_FOLDERS: [&str; 7] = [
    "suite",
    "worlds",
    "trace",
    "score",
    "report",
    "run",
    "yardsticks",
];

/// For each crate of the workspace, the crates of the workspace that it depends on, without
/// dev-dependencies.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
            "--manifest-path",
            manifest,
        ])
        .output()
        .unwrap();
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let name = |package: &serde_json::Value| package["name"].as_str().unwrap().to_owned();
    let ours: BTreeSet<String> = packages.iter().map(name).collect();
    let needs = |package: &serde_json::Value| {
        let all = package["dependencies"].as_array().unwrap().iter();
        let built = all.filter(|d| d["kind"].as_str() != Some("dev"));
        built.map(name).filter(|d| ours.contains(d)).collect()
    };
    packages.iter().map(|p| (name(p), needs(p))).collect()
}

/// The direct and indirect dependencies of `crate_name`.
fn reach(graph: &BTreeMap<String, BTreeSet<String>>, crate_name: &str) -> BTreeSet<String> {
    let mut seen = BTreeSet::new();
    let mut open = vec![crate_name.to_owned()];
    while let Some(next) = open.pop() {
        for dependency in graph.get(&next).into_iter().flatten() {
            if seen.insert(dependency.clone()) {
                open.push(dependency.clone());
            }
        }
    }
    seen
}

#[test]
fn agents_do_not_depend_on_the_truth() {
    let reached = reach(&dependencies(), "openbench-agents");
    for truth in ["openbench-sim", "openbench-scene", "openbench-bench"] {
        assert!(
            !reached.contains(truth),
            "openbench-agents depends on {truth}"
        );
    }
}

/// The source code of a crate, without tests and comments.
fn code(crate_folder: &str) -> String {
    code_below(&crates().join(crate_folder).join("src"))
}

/// The source code of all files below a folder, without tests and comments.
fn code_below(folder: &Path) -> String {
    let mut code = String::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            code += &code_below(&path);
        } else if path.ends_with("tests.rs") {
            assert!(
                is_for_tests_only(&path),
                "{}: its module is not behind `#[cfg(test)]`",
                path.display()
            );
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            code += &code_of(&path);
        }
    }
    code
}

/// Whether the module above a file `tests.rs` includes it only when tests are built.
fn is_for_tests_only(tests: &Path) -> bool {
    let folder = tests.parent().unwrap();
    [
        folder.with_extension("rs"),
        folder.join("mod.rs"),
        folder.join("lib.rs"),
    ]
    .iter()
    .filter_map(|module| std::fs::read_to_string(module).ok())
    .any(|module| {
        let lines: Vec<&str> = module.lines().collect();
        lines
            .windows(2)
            .any(|pair| pair[0] == "#[cfg(test)]" && pair[1].ends_with("mod tests;"))
    })
}

/// The source code of a file, without tests, which stand at its end, and without comments.
fn code_of(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let end = text.find("#[cfg(test)]").unwrap_or(text.len());
    text[..end]
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .fold(String::new(), |code, line| code + line + "\n")
}

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The crates of an agent do not contain the word, and the types that an agent receives have only
/// fields that a robot can know: a start, maps, sensor data.
#[test]
fn the_interface_of_agents_does_not_contain_the_truth() {
    let mut parts = reach(&dependencies(), "openbench-agents");
    parts.insert("openbench-agents".into());
    for part in parts {
        let code = code(part.trim_start_matches("openbench-")).to_lowercase();
        assert!(
            !code.contains("truth"),
            "the code of {part} speaks of the truth"
        );
    }
    let agent = code("core");
    for (name, fields) in [
        (
            "Briefing",
            "map_osm georeference goal start robot time_limit",
        ),
        ("Observation<'a>", "time imu wheels scan gnss camera"),
    ] {
        let (_, body) = agent.split_once(&format!("pub struct {name} {{")).unwrap();
        let (body, _) = body.split_once("\n}").unwrap();
        let found: Vec<&str> = body
            .lines()
            .filter_map(|l| l.trim().strip_prefix("pub ")?.split(':').next())
            .collect();
        assert_eq!(
            found.join(" "),
            fields,
            "{name} has other fields; are they what a robot can know?"
        );
    }
}

/// The benchmark scores any agent in the same way, so it depends on none.
#[test]
fn the_benchmark_depends_on_no_agent() {
    let reached = reach(&dependencies(), "openbench-bench");
    assert!(
        !reached.contains("openbench-agents"),
        "openbench-bench depends on openbench-agents"
    );
}

#[test]
fn folders_of_the_benchmark_import_from_lower_ones_only() {
    let source = crates().join("bench/src");
    for (level, folder) in BENCH_FOLDERS.iter().enumerate() {
        assert_imports_none(&source.join(folder), &BENCH_FOLDERS[level + 1..]);
    }
    for entry in std::fs::read_dir(&source).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        if path.is_dir() {
            assert!(BENCH_FOLDERS.contains(&name), "give {name} a place here");
        } else if name != "lib" {
            assert_imports_none(&path, &BENCH_FOLDERS);
        }
    }
}

/// Panics if a file, or a file below a folder, names one of the `higher` modules of its crate.
fn assert_imports_none(path: &Path, higher: &[&str]) {
    let code = if path.is_dir() {
        code_below(path)
    } else {
        code_of(path)
    };
    let path = path.display();
    // These would hide a module from the search below.
    assert!(
        !code.contains("crate::{"),
        "{path}: write one `use` for each module of the crate"
    );
    assert!(
        !code.contains("super::super"),
        "{path}: write `crate::` for other folders"
    );
    for module in higher {
        let import = format!("crate::{module}");
        assert!(
            !code.contains(&import),
            "{path} imports {import}, which is above it"
        );
    }
}

#[test]
fn core_depends_on_no_crate_of_ours() {
    assert_eq!(dependencies()["openbench-core"], BTreeSet::new());
}

#[test]
fn crates_depend_on_lower_layers_only() {
    let layers: BTreeMap<&str, u8> = LAYERS.into_iter().collect();
    for (name, needs) in dependencies() {
        let own = layers
            .get(name.as_str())
            .unwrap_or_else(|| panic!("give {name} a layer here and in ARCHITECTURE.md"));
        for need in needs {
            assert!(
                layers[need.as_str()] < *own,
                "{name} (layer {own}) depends on {need}"
            );
        }
    }
}

/// Algorithms return values or take an observer; only the command line prints.
#[test]
fn algorithms_do_not_print() {
    let lints =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml")).unwrap();
    for lint in ["print_stdout", "print_stderr", "dbg_macro"] {
        assert!(
            lints.contains(&format!("{lint} = \"warn\"")),
            "the workspace's lints no longer forbid {lint}"
        );
    }
    for (name, _) in LAYERS {
        let folder = match name.strip_prefix("openbench-") {
            Some("python") => "python".into(),
            Some(folder) => format!("crates/{folder}"),
            None if name == "openbench" => "crates/cli".into(),
            None => format!("examples/{name}"),
        };
        let manifest = format!("{}/../../{folder}/Cargo.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&manifest).unwrap();
        assert!(
            text.contains("[lints]\nworkspace = true"),
            "{manifest} does not take the workspace's lints"
        );
    }
}
