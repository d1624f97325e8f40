//! Statements of the packages about counts, Rust version and dependencies are true.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::process::Command;

/// `1.88` or `1.87.0` as numbers.
fn version(text: &str) -> Vec<u32> {
    let mut parts: Vec<u32> = text.split('.').map(|part| part.parse().expect("a number")).collect();
    parts.resize(3, 0);
    parts
}

/// The Cortex-M4F costs that `ballrace trade` reads are those of `docs/src/performance.md`, which the tests of the target hold.
#[test]
fn the_runner_has_the_counts_of_the_target() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect("a file of this project");
    let chapter = read("docs/src/performance.md");
    let table = chapter.lines().skip_while(|line| !line.starts_with("| what | N | precision |")).skip(2);
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let most = cells[5].split(" to ").last().unwrap_or_default();
        [&cells[..5], &[most], &cells[6..9]].concat().join(";")
    };
    let stated: Vec<String> = table.take_while(|line| line.starts_with('|')).map(row).collect();
    assert!(stated.len() >= 150, "{} rows", stated.len());
    let known = read("runner/studies/src/trade/cores/cortex-m4f.csv");
    assert_eq!(known.lines().collect::<Vec<_>>(), stated, "BALLRACE_WRITE=1 of the target's test writes both");
}

/// No dependency of the kernel needs a newer Rust than the kernel declares.
#[test]
fn the_declared_rust_version_is_enough_for_every_dependency() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernel/Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--manifest-path"])
        .arg(manifest)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let list = |value: &serde_json::Value| value.as_array().cloned().unwrap_or_default();
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let packages: HashMap<_, _> = list(&metadata["packages"]).into_iter().map(|p| (text(&p["id"]), p)).collect();
    let nodes: HashMap<_, _> = list(&metadata["resolve"]["nodes"]).into_iter().map(|n| (text(&n["id"]), n)).collect();
    let (kernel, package) = packages.iter().find(|(_, p)| p["name"] == "ballrace").expect("the kernel");
    let declared = version(&text(&package["rust_version"]));

    let (mut open, mut seen) = (vec![kernel.clone()], HashSet::new());
    while let Some(id) = open.pop().filter(|id| !id.is_empty()) {
        if !seen.insert(id.clone()) {
            continue;
        }
        if let Some(needed) = packages[&id]["rust_version"].as_str() {
            assert!(version(needed) <= declared, "{} needs Rust {needed}", packages[&id]["name"]);
        }
        let normal = |d: &serde_json::Value| list(&d["dep_kinds"]).iter().any(|kind| kind["kind"].is_null());
        open.extend(list(&nodes[&id]["deps"]).iter().filter(|d| normal(d)).map(|d| text(&d["pkg"])));
    }
    assert!(seen.len() > 5, "{} packages looked at", seen.len());
}

/// Crates on which a package depends, with the sets of features that it takes them with where it has these features itself.
fn features_of_dependencies(package: &str, own: &str) -> HashMap<String, HashSet<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let output = Command::new(env!("CARGO"))
        .args([
            "tree",
            "--locked",
            "--prefix",
            "none",
            "--edges",
            "normal,build",
            "--format",
            "{p} [{f}]",
            "-p",
            package,
            "--features",
            own,
        ])
        .current_dir(root)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut found: HashMap<String, HashSet<String>> = HashMap::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let line = line.trim_end_matches(" (*)");
        if let Some((name, features)) = line.split_once(" [").filter(|(name, _)| !name.contains("(/")) {
            found.entry(name.to_owned()).or_default().insert(features.trim_end_matches(']').to_owned());
        }
    }
    found
}

/// Program and Python package take their common dependencies with the same features, so that these are compiled once.
#[test]
fn common_dependencies_have_one_set_of_features() {
    let program = features_of_dependencies("ballrace-runner", "");
    let python = features_of_dependencies("ballrace-python", "");
    let common: Vec<&String> = program.keys().filter(|name| python.contains_key(*name)).collect();
    assert!(common.len() > 50, "{} common dependencies", common.len());
    for name in common {
        let (one, other) = (&program[name], &python[name]);
        assert_eq!(one, other, "{name}: add the features to runner/features/Cargo.toml");
    }
}

/// The tests of the program have Sparkplug, whose crates ask for no other features of what the twin library is compiled with.
#[test]
fn the_twin_is_compiled_once_for_program_and_tests() {
    let program = features_of_dependencies("ballrace-runner", "");
    let tested = features_of_dependencies("ballrace-runner", "sparkplug");
    let twin = features_of_dependencies("ballrace-twin", "");
    assert!(twin.len() > 50, "{} dependencies", twin.len());
    for name in twin.keys() {
        let (one, other) = (&program[name], &tested[name]);
        assert!(one.is_subset(other), "{name}: {one:?}, {other:?}: add the features to runner/features/Cargo.toml");
    }
}

/// The repository.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Packages of the workspace, as `cargo metadata` states them: those that would be published, and the names of the others.
fn packages() -> (Vec<serde_json::Value>, Vec<String>) {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--no-deps"])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages").clone();
    // `publish = false` is an empty list of registries.
    let (published, others): (Vec<_>, Vec<_>) = packages.into_iter().partition(|package| package["publish"].is_null());
    (published, others.iter().filter_map(|package| package["name"].as_str()).map(str::to_owned).collect())
}

#[test]
fn published_packages_have_all_that_a_registry_shows() {
    let (published, others) = packages();
    assert!(published.len() >= 10, "{published:?}");
    assert!(others.iter().any(|name| name == "ballrace-tests"), "{others:?}");
    for package in &published {
        let manifest = Path::new(package["manifest_path"].as_str().expect("a path"));
        for key in ["description", "license", "readme"] {
            assert!(package[key].is_string(), "{}: no {key}; add `{key}.workspace = true`", manifest.display());
        }
        for key in ["keywords", "categories"] {
            let count = package[key].as_array().map_or(0, Vec::len);
            assert!((1..=5).contains(&count), "{}: no {key}; add `{key}.workspace = true`", manifest.display());
        }
        let read = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
        for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
            let own = manifest.with_file_name(licence);
            assert_eq!(read(&own), read(&root().join(licence)), "{}: a link to that of the repository", own.display());
        }
    }
}

/// Every package is packed, with the versions of its dependencies in this workspace; `tests/run --all` also builds it from its archive.
#[test]
fn published_packages_can_be_packed() {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["package", "--locked", "--quiet", "--allow-dirty", "--workspace"]).current_dir(root());
    for name in packages().1 {
        cargo.args(["--exclude", &name]);
    }
    if !ballrace_tests::runs_all() {
        cargo.arg("--no-verify");
    }
    let output = cargo.output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Changelog and citation name the version of the packages; the entry of a version stays short.
#[test]
fn changelog_and_citation_name_this_version() {
    let read = |path: &str| std::fs::read_to_string(root().join(path)).expect("a file of this project");
    let version = env!("CARGO_PKG_VERSION");
    assert!(read("CITATION.cff").lines().any(|line| line == format!("version: {version}")), "CITATION.cff");
    let changelog = read("CHANGELOG.md");
    let (_, entries) = changelog.split_once("\n## ").expect("an entry");
    let entries: Vec<&str> = entries.split("\n## ").collect();
    let has = |start: &str| entries.iter().any(|entry| entry.starts_with(start));
    assert!(has(&format!("[{version}]")) || has("[Unreleased]"), "CHANGELOG.md has no entry for {version}");
    for entry in entries {
        assert!(entry.len() <= 6_000, "CHANGELOG.md: {} bytes in {:?}", entry.len(), entry.lines().next());
    }
}
