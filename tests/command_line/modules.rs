//! Structure of the packages: modules beside each other use each other in one direction, no terminal and no HTML in the library.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of the library below the program, which Cargo keeps in layers.
const LIBRARY: [&str; 9] = [
    "runner/base/src",
    "runner/scene/src",
    "runner/recording/src",
    "runner/models/src",
    "runner/outcome/src",
    "runner/plant/src",
    "runner/diagnosis/src",
    "runner/studies/src",
    "runner/replay/src",
];
/// Folders of the other packages.
const OTHERS: [&str; 6] =
    ["kernel/src", "kernel/c/src", "runner/report/src", "runner/src", "runner/python/src", "runner/fmu/src"];

/// A path of modules from the root of a package.
type ModulePath = Vec<String>;

/// Modules of a package, each with the paths that it uses.
type Uses = BTreeMap<ModulePath, BTreeSet<ModulePath>>;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Text without comments and without modules of tests.
fn code(text: &str) -> String {
    let mut code = String::new();
    let mut lines = text.lines();
    let mut is_test = false;
    while let Some(line) = lines.next() {
        let line = line.split("//").next().unwrap_or_default();
        is_test |= line == "#[cfg(test)]";
        if is_test && line.contains("mod ") {
            if line.ends_with('{') {
                lines.by_ref().find(|line| *line == "}");
            }
            is_test = false;
        } else {
            code += line;
            code.push('\n');
        }
    }
    code
}

/// Paths of the source files of a folder below `package`, with the code of each.
fn modules(package: &Path, folder: &Path, all: &mut Vec<(ModulePath, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap();
        if stem == "harness" || stem.ends_with("tests") {
            continue;
        }
        if path.is_dir() {
            modules(package, &path, all);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let relative = path.strip_prefix(package).unwrap().with_extension("");
            let mut names: ModulePath = relative.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
            if ["mod", "lib", "main"].contains(&stem) {
                names.pop();
            }
            all.push((names, code(&fs::read_to_string(&path).unwrap())));
        }
    }
}

/// Adds to `all` every path of the tree of names at the start of `text`, after `before`; returns the rest of the text.
fn tree<'a>(text: &'a str, before: &[String], all: &mut Vec<ModulePath>) -> &'a str {
    if let Some(mut rest) = text.strip_prefix('{') {
        loop {
            rest = tree(rest.trim_start(), before, all).trim_start();
            match rest.strip_prefix(',') {
                Some(next) if !next.trim_start().starts_with('}') => rest = next,
                Some(next) => return &next.trim_start()[1..],
                None => return rest.strip_prefix('}').unwrap_or(rest),
            }
        }
    }
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let (name, rest) = text.split_at(end);
    let path = [before, &[name.to_owned()]].concat();
    if let Some(below) =
        rest.strip_prefix("::").filter(|below| below.starts_with(|c: char| c == '{' || c.is_alphabetic()))
    {
        return tree(below, &path, all);
    }
    all.push(path);
    rest
}

/// Paths that `code` of the module `own` uses through `crate::` or `super::`.
fn used(own: &[String], code: &str) -> Vec<ModulePath> {
    let mut all = vec![];
    for start in ["crate::", "super::"] {
        for (at, _) in code.match_indices(start) {
            let is_inside = code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
            if is_inside {
                continue;
            }
            let (mut base, mut rest) = (own.to_vec(), &code[at..]);
            if start == "crate::" {
                (base, rest) = (vec![], &rest[start.len()..]);
            }
            while let Some(outer) = rest.strip_prefix("super::") {
                base.pop();
                rest = outer;
            }
            tree(rest, &base, &mut all);
        }
    }
    all
}

/// Edges between the modules of each folder: the module `a::b::c` that uses `a::d` gives an edge from `b` to `d` in the folder `a`.
fn edges(package: &Path) -> BTreeMap<ModulePath, Uses> {
    let mut sources = vec![];
    modules(package, package, &mut sources);
    let known: BTreeSet<&[String]> =
        sources.iter().flat_map(|(path, _)| (1..=path.len()).map(|length| &path[..length])).collect();
    let mut folders: BTreeMap<ModulePath, Uses> = BTreeMap::new();
    for (own, code) in &sources {
        for path in used(own, code) {
            let length = (1..=path.len()).take_while(|length| known.contains(&path[..*length])).count();
            let other = &path[..length];
            let common = own.iter().zip(other).take_while(|(a, b)| a == b).count();
            if let (Some(from), Some(to)) = (own.get(common), other.get(common)) {
                let folder = folders.entry(own[..common].to_vec()).or_default();
                folder.entry(vec![from.clone()]).or_default().insert(vec![to.clone()]);
            }
        }
    }
    folders
}

/// Modules that can be reached from `from`.
fn reached(uses: &Uses, from: &ModulePath) -> BTreeSet<ModulePath> {
    let mut all = BTreeSet::new();
    let mut next = vec![from];
    while let Some(module) = next.pop() {
        for other in uses.get(module).into_iter().flatten() {
            if all.insert(other.clone()) {
                next.push(other);
            }
        }
    }
    all
}

/// Modules of one folder that reach themselves.
fn on_a_circle(uses: &Uses) -> Vec<String> {
    uses.keys().filter(|module| reached(uses, module).contains(*module)).map(|module| module.join("::")).collect()
}

#[test]
fn no_modules_use_each_other_in_a_circle() {
    let mut count = 0;
    for package in LIBRARY.into_iter().chain(OTHERS) {
        for (folder, uses) in edges(&root().join(package)) {
            let circle = on_a_circle(&uses);
            assert!(circle.is_empty(), "{package}, {}: these modules use each other: {circle:?}", folder.join("::"));
            count += uses.values().map(BTreeSet::len).sum::<usize>();
        }
    }
    assert!(count > 500, "{count} uses were found");
}

#[test]
fn a_circle_of_two_imports_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    put("lib.rs", "mod a;\nmod b;\nmod c;\n");
    put("a.rs", "use super::{\n    c::Third,\n    b::{self, Other},\n};\n");
    put("b.rs", "// use crate::c;\nfn f() -> crate::c::Third {}\n");
    put("c.rs", "#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n");
    let circle = |folder: &Path| on_a_circle(&edges(folder)[&vec![]]);
    assert!(circle(folder.path()).is_empty(), "neither comments nor tests count");
    put("c.rs", "use crate::a::First;\n");
    assert_eq!(circle(folder.path()), ["a", "b", "c"]);
}

/// No library prints, and those below the program have no dependency of the command line and no untyped error.
#[test]
fn libraries_have_no_terminal() {
    for package in LIBRARY.into_iter().chain(["kernel/src", "runner/report/src"]) {
        let mut sources = vec![];
        modules(&root().join(package), &root().join(package), &mut sources);
        for (path, code) in sources {
            for call in ["println!", "print!", "stdout()", "stderr()", "crossterm", "ratatui"] {
                assert!(!code.contains(call), "{package}, {}: {call}", path.join("::"));
            }
        }
    }
    let mut sources = vec![];
    for package in LIBRARY {
        modules(&root().join(package), &root().join(package), &mut sources);
    }
    for (path, code) in sources {
        for word in ["anyhow", "<html", "<svg", "clap::Parser", "clap::Args"] {
            assert!(!code.contains(word), "{}: {word}", path.join("::"));
        }
    }
}
