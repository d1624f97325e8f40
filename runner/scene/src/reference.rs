//! The tables of keys in `docs/src/scene.md`, and the schema in `docs/schema`, are those of the reader. `BALLRACE_WRITE=1` writes them.

use crate::json_schema;
use crate::key::{Bounds, Choice, Keys, Kind};
use crate::read::keys::SCENE;
use std::fs;
use std::ops::Bound::{Excluded, Included, Unbounded};
use std::path::{Path, PathBuf};

const HEADER: &str = "| key | meaning | type, unit | default | valid range | example |";

/// Compares a file with what it has to be, or writes it.
fn check(file: &str, text: &str) {
    let file: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(file);
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        fs::write(file, text).unwrap();
    } else {
        assert_eq!(fs::read_to_string(file).unwrap(), text, "BALLRACE_WRITE=1 writes it");
    }
}

#[test]
fn the_published_schema_is_that_of_the_reader() {
    check("schema/scene.schema.json", &format!("{:#}\n", json_schema()));
}

#[test]
fn the_tables_of_the_reference_are_those_of_the_reader() {
    let mut sections: Vec<(&str, String)> = vec![];
    collect(&SCENE, &mut sections);
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/scene.md")).unwrap();
    let (mut rewritten, mut written) = (String::new(), 0);
    let (mut heading, mut lines) = ("", text.lines().peekable());
    while let Some(line) = lines.next() {
        if line.starts_with('#') {
            heading = line.trim_start_matches('#').trim();
        }
        if line.starts_with("| key |") {
            let (_, rows) = sections.iter().find(|(name, _)| *name == heading).unwrap();
            rewritten += &format!("{HEADER}\n| --- | --- | --- | --- | --- | --- |\n{rows}");
            while lines.next_if(|line| line.starts_with('|')).is_some() {}
            written += 1;
        } else {
            rewritten += &format!("{line}\n");
        }
    }
    assert_eq!(written, sections.len(), "one table for each of {:?}", sections.iter().map(|(name, _)| name));
    check("src/scene.md", &rewritten);
}

/// Adds the rows of each section.
fn collect(keys: &'static Keys, sections: &mut Vec<(&'static str, String)>) {
    check_choices(keys);
    for (heading, _) in keys.sections {
        if !sections.iter().any(|(known, _)| known == heading) {
            let own = keys.sections.iter().filter(|(other, _)| other == heading);
            sections.push((heading, own.map(|(_, lists)| rows(lists.iter().copied().flatten(), "")).collect()));
        }
    }
    for key in keys.all() {
        if let Some(inner) = table_of(&key.kind) {
            check_choices(inner);
            if has_section(inner) {
                collect(inner, sections);
            }
        }
    }
}

/// The keys of a choice are keys of the table.
fn check_choices(keys: &Keys) {
    for choice in keys.choices {
        let names: Vec<&str> = match choice {
            Choice::One(sets) | Choice::Any(sets) => sets.concat(),
            Choice::AtMostOne(names) => names.to_vec(),
        };
        assert!(names.iter().all(|name| keys.find(name).is_some()), "{}: {names:?}", keys.name);
    }
}

/// True for a table whose rows have a heading of their own.
fn has_section(keys: &Keys) -> bool {
    keys.sections.iter().all(|(heading, _)| !heading.is_empty())
}

/// Keys of a table, or of the tables of a list.
fn table_of(kind: &'static Kind) -> Option<&'static Keys> {
    kind.keys().or_else(|| kind.entry(0)?.keys())
}

fn rows(keys: impl IntoIterator<Item = &'static crate::key::Key>, table: &str) -> String {
    let mut rows = String::new();
    for key in keys {
        let name = format!("{table}{}", key.name);
        let default = if key.is_required() && !table.is_empty() { "required in the table" } else { key.default };
        let mut range = ranges(&key.kind);
        range.extend((!key.range.is_empty()).then(|| key.range.to_owned()));
        let example = if key.example.is_empty() { String::new() } else { format!("`{}`", key.example) };
        let cells =
            [&format!("`{name}`"), key.meaning, &kind_and_unit(&key.kind), default, &range.join("; "), &example];
        let cells = cells.map(|cell| if cell.is_empty() { " ".to_owned() } else { format!(" {cell} ") });
        rows += &format!("|{}|\n", cells.join("|"));
        if let Some(inner) = table_of(&key.kind).filter(|inner| !has_section(inner)) {
            rows += &self::rows(inner.all(), &format!("{name}."));
        }
    }
    rows
}

/// Kind of a value, with the unit of a bare number.
fn kind_and_unit(kind: &Kind) -> String {
    match kind {
        Kind::Text(what) => (*what).to_owned(),
        Kind::Boolean => "true or false".to_owned(),
        Kind::Integer(..) => "whole number".to_owned(),
        Kind::Number(_) => "number".to_owned(),
        Kind::NumberIn(unit, _) => format!("number, {unit}"),
        Kind::Quantity(dimension, _) => match dimension.si_unit().as_str() {
            "N/m^1.5" => format!("{}, N/m^n", dimension.name()),
            unit => format!("{}, {unit}", dimension.name()),
        },
        Kind::Temperature => "temperature".to_owned(),
        Kind::Words(_) => "word".to_owned(),
        Kind::Unit(dimension) => format!("unit of {}", dimension.name()),
        Kind::Table(_) => "table".to_owned(),
        Kind::List(Kind::Table(_)) => "list of tables".to_owned(),
        Kind::List(entry) => format!("list: {}", kind_and_unit(entry)),
        Kind::Tuple(entries) => {
            let mut parts: Vec<(usize, String)> = vec![];
            for entry in *entries {
                let one = kind_and_unit(entry);
                match parts.last_mut().filter(|(_, last)| *last == one) {
                    Some((count, _)) => *count += 1,
                    None => parts.push((1, one)),
                }
            }
            let parts: Vec<String> = parts.into_iter().map(|(count, one)| format!("{count} x {one}")).collect();
            format!("[{}]", parts.join("; "))
        }
        Kind::Either(kinds) => kinds.iter().map(kind_and_unit).collect::<Vec<_>>().join(", or "),
    }
}

/// Ranges of the values of a kind.
fn ranges(kind: &Kind) -> Vec<String> {
    let one = |text: String| if text.is_empty() { vec![] } else { vec![text] };
    match kind {
        Kind::Integer(least, most) if *most == i64::from(u32::MAX) => one(format!("{least} or more")),
        Kind::Integer(least, most) => one(format!("{least} to {most}")),
        Kind::Number(bounds) | Kind::NumberIn(_, bounds) | Kind::Quantity(_, bounds) => one(range(*bounds)),
        Kind::Words(words) => one(words().iter().map(|word| format!("`\"{word}\"`")).collect::<Vec<_>>().join(", ")),
        Kind::Temperature => one("`degC`, `K`, `degF`".to_owned()),
        Kind::List(entry) => ranges(entry),
        Kind::Tuple(entries) => {
            let mut all: Vec<String> = entries.iter().flat_map(ranges).collect();
            all.dedup();
            all
        }
        Kind::Either(kinds) => {
            let mut all: Vec<String> = kinds.iter().flat_map(ranges).collect();
            all.dedup();
            all
        }
        Kind::Text(_) | Kind::Boolean | Kind::Unit(_) | Kind::Table(_) => vec![],
    }
}

fn range(bounds: Bounds) -> String {
    let bounds = [bounds.0, bounds.1]
        .map(|bound| bound.map(|x| if x != 0.0 && x < 1e-2 { format!("{x:e}") } else { x.to_string() }));
    match &bounds {
        [Unbounded, Unbounded] => String::new(),
        [Included(least), Unbounded] => format!("{least} or more"),
        [Excluded(least), Unbounded] => format!("above {least}"),
        [Included(least), Included(most)] => format!("{least} to {most}"),
        [Included(least), Excluded(most)] => format!("{least} to below {most}"),
        [Excluded(least), Included(most)] => format!("above {least}, at most {most}"),
        [Excluded(least), Excluded(most)] => format!("above {least}, below {most}"),
        [Unbounded, Included(most) | Excluded(most)] => format!("up to {most}"),
    }
}
