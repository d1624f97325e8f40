//! README and the chapters under `docs/src`: structure, links, scenes, and figures that the program prints.

use crate::support::{Sandbox, program};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Once;

/// Set to rewrite tables and figures from what the program prints.
pub fn rewrites() -> bool {
    std::env::var_os("BALLRACE_WRITE").is_some()
}

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

pub fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// File names in `docs/src` that end in `.md`.
fn chapters() -> Vec<String> {
    let entries = fs::read_dir(root().join("docs/src")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut chapters: Vec<String> = names.filter(|name| name.ends_with(".md")).collect();
    chapters.sort();
    chapters
}

/// README, contributing guides and chapters, from the root of the repository.
pub fn documents() -> Vec<String> {
    let mut all: Vec<String> = ["README.md", "CONTRIBUTING.md", "SECURITY.md", "benches/README.md", "kernel/README.md"]
        .map(str::to_owned)
        .into();
    all.extend(chapters().into_iter().map(|name| format!("docs/src/{name}")));
    all
}

/// A document's lines with the fenced blocks omitted.
pub fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fence && !fenced
    })
}

/// Fenced blocks of one language.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    text.split(&fence).skip(1).map(|rest| rest.split_once("```").expect("a closing fence").0).collect()
}

/// A line without its code spans.
pub fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join(" ")
}

/// The anchor of a heading, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    let kept = |c: char| match c {
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
        c if c.is_whitespace() => Some('-'),
        _ => None,
    };
    heading.trim_start_matches('#').trim().chars().filter_map(kept).collect()
}

fn anchors(text: &str) -> BTreeSet<String> {
    prose(text).filter(|line| line.starts_with('#')).map(anchor).collect()
}

/// Targets of the links of a text.
fn links(text: &str) -> Vec<String> {
    let whole: String = prose(text).map(|line| without_code(line) + "\n").collect();
    whole.split("](").skip(1).map(|rest| rest.split(')').next().unwrap().replace('\n', "")).collect()
}

/// Checks a relative link `target` of the file `from`.
fn check_link(from: &str, target: &str) {
    let (path, fragment) = target.split_once('#').unwrap_or((target, ""));
    let file = if path.is_empty() { root().join(from) } else { root().join(from).parent().unwrap().join(path) };
    assert!(file.exists(), "{from}: link to {target}: no such file");
    if !fragment.is_empty() {
        let text = fs::read_to_string(&file).unwrap();
        assert!(anchors(&text).contains(fragment), "{from}: link to {target}: no such heading");
    }
}

#[test]
fn every_chapter_is_in_the_summary_and_every_entry_is_a_chapter() {
    let listed: BTreeSet<String> = links(&read("docs/src/SUMMARY.md")).into_iter().collect();
    let there: BTreeSet<String> = chapters().into_iter().filter(|name| name != "SUMMARY.md").collect();
    assert_eq!(listed, there);
}

#[test]
fn every_relative_link_has_its_file_and_heading() {
    let mut checked = 0;
    for document in documents() {
        // Links of the kernel's text are rustdoc's, which checks them itself.
        let text = if document == "kernel/README.md" { String::new() } else { read(&document) };
        for target in links(&text).iter().filter(|target| !target.contains("://")) {
            check_link(&document, target);
            // The book has no other files.
            assert!(!document.starts_with("docs/") || !target.contains("../"), "{document}: link to {target}");
            checked += 1;
        }
    }
    assert!(checked > 40, "{checked} links");
}

/// Source files below `folder`.
pub fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if path.file_name().is_some_and(|name| name != "target") {
                sources(&path, all);
            }
        } else if path.extension().is_some_and(|extension| extension == "rs" || extension == "json") {
            all.push(path);
        }
    }
}

#[test]
fn every_section_that_code_cites_is_there() {
    let mut files = vec![];
    for folder in ["kernel", "runner", "tests", "benches"] {
        sources(&root().join(folder), &mut files);
    }
    let mut cited = 0;
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let name = file.display();
        // Built from two parts, so that this line does not find itself.
        assert!(!text.contains(concat!("MODEL", ".md")), "{name}: cites a file outside of the repository");
        for rest in text.split("docs/src/models.md#").skip(1) {
            let fragment: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '-' || *c == '_').collect();
            if !fragment.is_empty() {
                check_link("README.md", &format!("docs/src/models.md#{fragment}"));
                cited += 1;
            }
        }
    }
    assert!(cited > 10, "{cited} citations");
}

#[test]
fn the_readme_has_ten_to_twelve_kilobytes() {
    let size = read("README.md").len();
    assert!((10_000..=12_288).contains(&size), "{size} bytes");
}

/// Tables of a text: header line and rows.
fn tables(text: &str) -> Vec<(&str, Vec<&str>)> {
    let mut tables = vec![];
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line.starts_with('|') && lines.peek().is_some_and(|next| next.starts_with("| --")) {
            lines.next();
            let mut rows = vec![];
            while let Some(row) = lines.next_if(|row| row.starts_with('|')) {
                rows.push(row);
            }
            tables.push((line, rows));
        }
    }
    tables
}

fn first_cell(row: &str) -> &str {
    row.split('|').nth(1).unwrap_or_default().trim()
}

/// The rows of accuracy, speed and trade-off in the README are rows of the chapters.
#[test]
fn results_in_the_readme_are_those_of_the_chapters() {
    if rewrites() {
        rewrite_trade_table();
    }
    let mut readme = read("README.md");
    let text = readme.clone();
    let results = &text[text.find("## Accuracy").expect("results")..];
    let results = &results[..results.find("## Documentation").expect("their end")];
    let long = [read("docs/src/validation.md"), read("docs/src/performance.md")];
    let long: Vec<(&str, Vec<&str>)> = long.iter().flat_map(|text| tables(text)).collect();
    let short = tables(results);
    assert_eq!(short.len(), 3);
    for (header, rows) in short {
        assert!((3..=10).contains(&rows.len()), "{header}: {} rows", rows.len());
        let (_, all) = long.iter().find(|(other, _)| *other == header).unwrap_or_else(|| panic!("no table {header}"));
        for row in rows {
            let name = first_cell(row);
            let found = all.iter().find(|other| first_cell(other) == name).unwrap_or_else(|| panic!("no row {name}"));
            if rewrites() {
                readme = readme.replace(row, found);
            } else {
                assert_eq!(row, *found, "BALLRACE_WRITE=1 copies it from the chapter");
            }
        }
    }
    if rewrites() {
        fs::write(root().join("README.md"), readme).unwrap();
    }
}

/// The block of output after a block of commands is what the last of them prints, some lines omitted.
#[test]
fn the_worked_example_prints_what_the_readme_shows() {
    let text = read("README.md");
    let example = text.split_once("## A worked example").expect("an example").1;
    let commands = blocks(example, "sh")[0];
    let shown = blocks(example, "text")[0];
    let sandbox = Sandbox::empty();
    let script = commands.replace("ballrace ", &format!("{} ", program().display()));
    let output = Command::new("sh").args(["-e", "-c", &script]).current_dir(sandbox.path("")).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut lines = printed.lines();
    for line in shown.lines() {
        assert!(lines.any(|printed| printed == line), "not printed, or not in this order: {line}");
    }
}

/// Scenes of the documents: blocks of TOML with a name.
fn scenes() -> Vec<(String, String)> {
    let all = documents().into_iter().flat_map(|document| {
        let text = read(&document);
        let blocks: Vec<String> = blocks(&text, "toml").into_iter().map(str::to_owned).collect();
        blocks.into_iter().map(move |block| (document.clone(), block))
    });
    all.filter(|(_, block)| block.starts_with("name = ")).collect()
}

#[test]
fn every_documented_scene_is_accepted() {
    let scenes = scenes();
    assert!(scenes.len() >= 2, "{} scenes", scenes.len());
    for (document, scene) in scenes {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", &scene);
        // A bearing alone has an equilibrium under a load that its command states.
        let is_alone = !["[rotor]", "[system]", "preload"].iter().any(|key| scene.contains(key));
        let answer = sandbox.run(&[if is_alone { "check" } else { "equilibrium" }, "scene.toml"]);
        assert_eq!(answer.code, Some(0), "{document}: {answer:?}\n{scene}");
    }
}

const TRADE: [&str; 2] = ["<!-- trade:begin -->\n", "<!-- trade:end -->"];

/// Percent to two digits.
fn percent(share: f64) -> String {
    match 100.0 * share {
        large if large >= 9.95 => format!("{large:.0} %"),
        medium if medium >= 0.0995 => format!("{medium:.2} %"),
        small => format!("{small:.1e} %"),
    }
}

/// Rows of the table of errors and costs, from the documented spindle.
fn trade_rows() -> String {
    let (_, spindle) =
        scenes().into_iter().find(|(_, scene)| scene.starts_with("name = \"spindle\"")).expect("a spindle");
    let sandbox = Sandbox::empty();
    sandbox.put("spindle.toml", spindle);
    let answer = sandbox.run(&["trade", "spindle.toml", "--forces-only", "--format", "csv"]);
    assert_eq!(answer.code, Some(0), "{answer:?}");
    let mut reader = csv_rows(&answer.out);
    let header = reader.remove(0);
    let column = |name: &str| header.iter().position(|cell| cell == name).unwrap_or_else(|| panic!("no {name}"));
    let [model, precision, math, median, most, instructions, cycles, counted] = [
        "model",
        "precision",
        "math",
        "error_median",
        "error_largest",
        "m4f_instructions",
        "m4f_cycles",
        "m4f_counted",
    ]
    .map(column);
    let about = |row: &[String], cell: usize| {
        let number: f64 = row[cell].parse().unwrap_or_else(|_| panic!("{row:?}"));
        format!("{}{number:.0}", if row[counted] == "true" { "" } else { "~" })
    };
    let mut rows = String::new();
    for row in reader.iter().filter(|row| row[0] == "force" && row[precision] == "f32" && row[math] == "exact") {
        let [median, most] = [median, most].map(|cell| percent(row[cell].parse().unwrap()));
        let [instructions, cycles] = [instructions, cycles].map(|cell| about(row, cell));
        rows += &format!("| {} | {median} | {most} | {instructions} | {cycles} |\n", row[model]);
    }
    rows
}

/// Cells of CSV text whose quoted cells have no quotes in them.
fn csv_rows(text: &str) -> Vec<Vec<String>> {
    let cells = |line: &str| {
        let mut cells = vec![];
        for (i, part) in line.split('"').enumerate() {
            if i % 2 == 1 {
                *cells.last_mut().unwrap() = part.to_owned();
            } else {
                let plain = if i == 0 { part } else { part.strip_prefix(',').unwrap_or(part) };
                if i == 0 || !plain.is_empty() {
                    cells.extend(plain.split(',').map(str::to_owned));
                }
            }
        }
        cells
    };
    text.lines().map(cells).collect()
}

/// The chapter of the table of errors and costs: the text before the table, the table, the text after it.
fn trade_table() -> [String; 3] {
    let text = read("docs/src/performance.md");
    let (before, rest) = text.split_once(TRADE[0]).expect("a mark where the table begins");
    let (table, after) = rest.split_once(TRADE[1]).expect("a mark where it ends");
    [before, table, after].map(str::to_owned)
}

/// The table as the program computes it now.
fn trade_table_of_the_program() -> String {
    let header = "| forces of both bearings, f32 | median error | largest error | instructions | cycles |\n\
                  | --- | --: | --: | --: | --: |\n";
    format!("{header}{}", trade_rows())
}

/// Writes the table, once in a run of the tests.
fn rewrite_trade_table() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let [before, _, after] = trade_table();
        let text = [&before, TRADE[0], &trade_table_of_the_program(), TRADE[1], &after].concat();
        fs::write(root().join("docs/src/performance.md"), text).unwrap();
    });
}

#[test]
fn the_table_of_errors_and_costs_is_that_of_the_documented_spindle() {
    if rewrites() {
        rewrite_trade_table();
    } else {
        assert_eq!(trade_table()[1], trade_table_of_the_program(), "BALLRACE_WRITE=1 rewrites it");
    }
}

/// The figure in the README, from the report of the demonstration.
const FIGURE: (&str, &str) = ("Bearing DE: Spall on the outer race at 269 deg", "docs/src/diagnosis.svg");
/// Room around the figure.
const MARGIN: u32 = 10;

/// A figure of a report as a file of its own: on white, so that it is legible on any background.
pub fn standalone(report: &str, caption: &str) -> String {
    let (_, figure) = report.split_once(&format!("<figcaption>{caption}</figcaption>")).expect(caption);
    let (_, svg) = figure.split_once("<svg viewBox=\"0 0 ").expect("a figure");
    let (size, rest) = svg.split_once('"').unwrap();
    let (attributes, content) = rest.split_once(">\n").unwrap();
    let (content, _) = content.split_once("</svg>").unwrap();
    // The colours that the style of a page would set.
    let mut parts = content.split("var(--");
    let first = parts.next().unwrap().to_owned();
    let content = parts.fold(first, |text, part| {
        let (property, rest) = part.split_once(')').unwrap();
        text + property.split_once(',').unwrap().1 + rest
    });
    let size: Vec<u32> = size.split(' ').map(|number| number.parse::<f64>().unwrap().ceil() as u32).collect();
    let (width, height) = (size[0] + 2 * MARGIN, size[1] + 2 * MARGIN);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-{MARGIN} -{MARGIN} {width} {height}\" width=\"{}\"{attributes}>\n\
         <style>text{{paint-order:stroke;stroke:#fff;stroke-width:2.5px;stroke-linejoin:round}}</style>\n\
         <rect x=\"-{MARGIN}\" y=\"-{MARGIN}\" width=\"{width}\" height=\"{height}\" fill=\"#FFFFFF\"/>\n{content}</svg>\n",
        3 * width / 2
    )
}

/// Text of an SVG figure.
pub fn labels(svg: &str) -> Vec<String> {
    let texts = svg.split("<text ").skip(1);
    texts.map(|text| text.split_once('>').unwrap().1.split('<').next().unwrap().trim().to_owned()).collect()
}

#[test]
fn the_figure_of_the_readme_is_one_of_the_report() {
    let (caption, path) = FIGURE;
    assert!(read("README.md").contains(path));
    let sandbox = Sandbox::empty();
    sandbox.done(&["replay", "--report", "report.html"]);
    let figure = standalone(&sandbox.read("report.html"), caption);
    if rewrites() {
        fs::write(root().join(path), &figure).unwrap();
    }
    let stated = read(path);
    assert_eq!(labels(&stated), labels(&figure), "BALLRACE_WRITE=1 rewrites it");
    assert!(labels(&figure).len() > 10);
    assert!(stated.contains("fill=\"#FFFFFF\"/>"), "a white background");
}

#[test]
fn anchors_are_those_of_github() {
    assert_eq!(anchor("## Hertz contact"), "hertz-contact");
    assert_eq!(anchor("### Waviness, and `damage` (A.6)"), "waviness-and-damage-a6");
}
