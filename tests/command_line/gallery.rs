//! The gallery: its commands in their order, on its scenes, the figures that it states, and its pictures, which are figures of the reports.

use crate::board;
use crate::documents::{labels, read, rewrites, root, standalone};
use crate::support::{Sandbox, program};
use std::fs;
use std::process::Command;

const CHAPTER: &str = "docs/src/gallery.md";

/// Returns what stands between two marks of a text, in its order.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> Vec<&'a str> {
    text.split(begin).skip(1).map(|part| part.split(end).next().unwrap()).collect()
}

#[test]
fn the_pictures_are_figures_of_the_reports_that_the_commands_write() {
    let text = read(CHAPTER);
    let sandbox = Sandbox::empty();
    for folder in ["docs/boards/monitor", "tests/recordings"] {
        fs::create_dir_all(sandbox.path(folder)).unwrap();
    }
    sandbox.put("tests/recordings/healthy.toml", include_str!("../recordings/healthy.toml"));
    sandbox.put("tests/recordings/healthy.csv", include_str!("../recordings/healthy.csv"));
    board::scene_files().for_each(|(path, text)| sandbox.put(&path, text));
    sandbox.put("board.frames", board::log(true));
    for file in between(&text, "<!-- file: ", "```\n\n") {
        let (name, content) = file.split_once(" -->\n```toml\n").unwrap();
        sandbox.put(name, content);
    }
    let folder = fs::canonicalize(program()).unwrap().parent().unwrap().to_owned();
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
    let blocks: Vec<&str> = text.split("```sh\n").skip(1).collect();
    for block in blocks {
        let (commands, after) = block.split_once("```\n").unwrap();
        let script = format!("set -e\n{commands}");
        let output = Command::new("sh").args(["-c", &script]).env("PATH", &path).current_dir(sandbox.path("")).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{commands}{}", String::from_utf8_lossy(&output.stderr));
        // What the chapter says of the results.
        let printed = String::from_utf8_lossy(&output.stdout);
        let stated = after.strip_prefix("<!-- prints: ").map_or("", |stated| stated.split(" -->").next().unwrap());
        for part in stated.split(" | ") {
            assert!(printed.contains(part), "{commands}{part}: not in {printed}");
        }
    }
    let figures = between(&text, "<!-- figure: ", ".svg)");
    assert!(figures.len() >= 10, "{} pictures", figures.len());
    for figure in figures {
        let (of_report, rest) = figure.split_once(" -->\n").unwrap();
        let (report, caption) = of_report.split_once(": ").unwrap();
        let name = rest.split_once("](").unwrap().1;
        let fresh = standalone(&sandbox.read(report), caption);
        let path = format!("docs/src/{name}.svg");
        if rewrites() {
            fs::write(root().join(&path), &fresh).unwrap();
        }
        assert_eq!(labels(&read(&path)), labels(&fresh), "{path}: BALLRACE_WRITE=1 rewrites it");
    }
}
