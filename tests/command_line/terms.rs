//! Terms and sentences of documents, comments, messages, public names and help texts.

use crate::documents::{documents, prose, read, root, sources, without_code};
use crate::support::program;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Terms of no field, and verbs of persons for programs and files.
const PRIVATE_TERMS: [&str; 36] = [
    "abreast",
    "anew",
    "asks",
    "believed",
    "even_places",
    "findings",
    "geared",
    "good enough",
    "in_cage",
    "into_cage",
    "ladder",
    "nobody",
    "nobody announced",
    "promises",
    "remembers",
    "rung",
    "rungs",
    "said",
    "says",
    "seat",
    "seats",
    "settles",
    "so many",
    "sparing",
    "tells",
    "thorough",
    "to_cage_frame",
    "told",
    "touches down",
    "truest",
    "wander",
    "wanders",
    "wants",
    "weighed",
    "what was given is said",
    "worked off",
];

/// Further terms that help texts do not have.
const PRIVATE_TERMS_OF_HELP: [&str; 10] = [
    "ask",
    "judge",
    "left out",
    "of which",
    "one way",
    "promise",
    "remember",
    "remembered",
    "settle time",
    "warned of",
];

/// Names that no public item has: another term is the one of the field.
const PRIVATE_NAMES: [&str; 58] = [
    "Abreast",
    "AngularSeat",
    "Arc",
    "Arrangement",
    "Attached",
    "BallSeat",
    "Coupling",
    "Disturbed",
    "Drive",
    "Finding",
    "Gear",
    "Geared",
    "General",
    "Glance",
    "Guards",
    "Heard",
    "HeldWrench",
    "InCage",
    "Made",
    "Moment",
    "Need",
    "Needs",
    "News",
    "PartAngles",
    "Pairs",
    "Part",
    "Place",
    "Places",
    "Push",
    "Rung",
    "SceneFault",
    "Seat",
    "Seen",
    "Settled",
    "Shape",
    "SideBySide",
    "Spots",
    "TableSeat",
    "Told",
    "Touch",
    "Tuned",
    "Turn",
    "Uneven",
    "Watch",
    "Way",
    "Whole",
    "Wholes",
    "WideRegisters",
    "Zero",
    "even_places",
    "finding",
    "findings",
    "into_cage",
    "needs",
    "rung",
    "settle",
    "wander",
    "wide",
];

/// Lowercase words of a text, single spaces between them.
fn words(text: &str) -> String {
    let plain: String =
        text.chars().map(|c| if c.is_alphanumeric() || c == '_' { c.to_ascii_lowercase() } else { ' ' }).collect();
    format!(" {} ", plain.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn documents_use_the_terms_of_the_field() {
    for document in documents() {
        let text = read(&document);
        let plain: String = prose(&text).map(|line| without_code(line) + " ").collect();
        let plain = words(&plain);
        for term in PRIVATE_TERMS {
            assert!(!plain.contains(&format!(" {term} ")), "{document}: {term:?}");
        }
    }
}

#[test]
fn no_sentence_of_a_document_begins_with_what() {
    for document in documents().into_iter().filter(|name| name.starts_with("docs") || name == "README.md") {
        let text = read(&document);
        for line in prose(&text) {
            let starts = [line.trim_start_matches(['#', '-', '|', '*', ' ']), ""];
            let begins = starts.iter().any(|start| start.starts_with("What "))
                || [". What ", ": What ", "| What "].iter().any(|inside| line.contains(inside));
            // A question is no subject.
            assert!(!begins || line.ends_with('?'), "{document}: {line}");
        }
    }
}

/// Comments and sentences of a source file: text after `//`, and string literals with a space.
fn comments_and_sentences(source: &str) -> String {
    let mut all = String::new();
    for line in source.lines() {
        match line.split_once("//") {
            Some((code, comment)) if !code.contains('"') => all += comment,
            _ => all.extend(line.split('"').skip(1).step_by(2).filter(|text| text.contains(' '))),
        }
        all.push('\n');
    }
    all
}

/// Rust files of the kernel and of the packages under `runner`.
fn package_sources(packages: &[&str]) -> Vec<PathBuf> {
    let mut files = vec![];
    for package in packages {
        sources(&root().join(package).join("src"), &mut files);
    }
    let is_test =
        |file: &Path| file.strip_prefix(root()).unwrap().iter().any(|name| name == "tests" || name == "tests.rs");
    files.retain(|file| file.extension().is_some_and(|extension| extension == "rs") && !is_test(file));
    files
}

#[test]
fn comments_and_messages_use_the_terms_of_the_field() {
    let files = package_sources(&["kernel", "kernel/c", "runner/twin", "runner/report", "runner", "runner/python"]);
    assert!(files.len() > 300, "{} files", files.len());
    for file in files {
        let text = comments_and_sentences(&fs::read_to_string(&file).unwrap());
        let plain: String = text.lines().map(|line| without_code(line) + " ").collect();
        let plain = words(&plain);
        for term in PRIVATE_TERMS {
            assert!(!plain.contains(&format!(" {term} ")), "{}: {term:?}", file.display());
        }
        for line in text.lines() {
            let sentence = line.trim_start_matches(['/', '!', '-', ' ']);
            let begins = ["What ", "Of ", "Who ", "Whose "].iter().any(|start| sentence.starts_with(start));
            assert!(!begins, "{}: a sentence without a subject: {line}", file.display());
        }
    }
}

#[test]
fn public_names_are_the_terms_of_the_field() {
    let mut count = 0;
    for file in package_sources(&["kernel", "runner/twin", "runner/report", "runner"]) {
        let text = fs::read_to_string(&file).unwrap();
        for line in text.lines().map(str::trim_start).filter(|line| line.starts_with("pub ")) {
            let mut names = line.split(|c: char| !c.is_alphanumeric() && c != '_');
            let is_item = |word: &&str| ["struct", "enum", "trait", "type", "mod", "fn"].contains(word);
            let Some(name) = names.find(is_item).and_then(|_| names.next()) else { continue };
            assert!(!PRIVATE_NAMES.contains(&name), "{}: {line}", file.display());
            count += 1;
        }
    }
    assert!(count > 1200, "{count} items");
}

#[test]
fn help_texts_use_the_terms_of_the_field() {
    let help = |arguments: &[&str]| {
        let output = Command::new(program()).args(arguments).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let general = help(&["--help"]);
    let list = general.split_once("Commands:").expect("a list of commands").1.split_once("Options:").unwrap().0;
    let commands: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.len() > 10, "{commands:?}");
    let mut texts = vec![general.clone()];
    texts.extend(commands.iter().filter(|name| **name != "help").map(|name| help(&[name, "--help"])));
    for text in texts {
        let plain = words(&text);
        for term in PRIVATE_TERMS.iter().chain(&PRIVATE_TERMS_OF_HELP) {
            assert!(!plain.contains(&format!(" {term} ")), "{term:?} in: {text}");
        }
        let starts =
            |line: &str| ["What ", "Of ", "Where ", "Whose "].iter().any(|start| line.contains(&format!("  {start}")));
        assert!(!text.lines().any(starts), "a line that begins as no description does: {text}");
    }
}
