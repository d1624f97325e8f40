//! What the package says of itself is true of its dependencies.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::process::Command;

/// `1.88` or `1.87.0` as numbers.
fn version(text: &str) -> Vec<u32> {
    let mut parts: Vec<u32> = text.split('.').map(|part| part.parse().expect("a number")).collect();
    parts.resize(3, 0);
    parts
}

/// No dependency of the kernel needs a newer Rust than the kernel declares.
#[test]
fn the_declared_rust_version_is_enough_for_every_dependency() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernel/Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--offline", "--manifest-path"])
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
