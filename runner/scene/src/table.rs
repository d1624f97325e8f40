//! Reader of TOML documents whose errors contain file, line and key.
//!
//! [`Node`] is one value with its place and the [`Kind`] that its key has; [`Table`] is a table whose keys have been checked.

use std::ops::Range;
use std::path::{Path, PathBuf};

use toml_edit::{ArrayOfTables, Item, TableLike, Value};

use super::key::{Bounds, Keys, Kind};
use super::units::{self, Dimension};
use std::ops::{Bound, RangeBounds};

/// Longest value that an error repeats, in characters.
const LONGEST_SHOWN: usize = 60;

/// Kind of a [`SceneError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Problem {
    /// The value is not one of those expected.
    InvalidValue,
    /// The value has to be unique and is not.
    RepeatedValue,
    /// The key does not go together with others.
    MisplacedKey,
    /// The error describes its problem itself.
    Described,
}

impl Problem {
    /// Returns the start of the message, empty where the error describes its problem itself.
    const fn text(self) -> &'static str {
        match self {
            Self::InvalidValue => "invalid value",
            Self::RepeatedValue => "repeated value",
            Self::MisplacedKey => "misplaced key",
            Self::Described => "",
        }
    }
}

/// Error returned when a scene is invalid: one line with file, line, key, value found and values expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.sentence())]
pub struct SceneError {
    /// The scene file.
    pub file: PathBuf,
    /// Line in it, from 1; none where the file could not be read at all.
    pub line: Option<usize>,
    /// Path of the key, such as `bearing[0].ball_diameter`; empty where it is not about a key.
    pub key: String,
    /// Kind of the error.
    pub problem: Problem,
    /// Value found, or a description of the problem; empty for a missing key.
    pub found: String,
    /// Values expected, with an example or a range; empty where `found` is a complete message.
    pub expected: String,
}

impl SceneError {
    /// Returns the error of a file that cannot be read.
    pub(super) fn file(file: &Path, found: impl Into<String>) -> Self {
        Self {
            file: file.to_owned(),
            line: None,
            key: String::new(),
            problem: Problem::Described,
            found: found.into(),
            expected: "a scene file (TOML text with at least [shaft] and one [[bearing]])".into(),
        }
    }

    fn sentence(&self) -> String {
        let mut text = self.file.display().to_string();
        if let Some(line) = self.line {
            text.push_str(&format!(":{line}"));
        }
        if !self.key.is_empty() {
            text.push_str(&format!(": {}", self.key));
        }
        let found = if self.found.is_empty() { "missing key" } else { self.found.as_str() };
        for part in [self.problem.text(), found].into_iter().filter(|part| !part.is_empty()) {
            text.push_str(&format!(": {part}"));
        }
        if !self.expected.is_empty() {
            text.push_str(&format!(", expected {}", self.expected));
        }
        text
    }
}

/// Result of a function that reads a part of the scene.
pub(super) type Read<T> = Result<T, SceneError>;

/// The text of the scene.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub text: &'a str,
    pub file: &'a Path,
}

impl Source<'_> {
    /// Returns an error at a byte of the text whose problem `found` describes.
    pub fn error(self, at: usize, key: &str, found: impl Into<String>, expected: impl Into<String>) -> SceneError {
        SceneError {
            file: self.file.to_owned(),
            line: Some(line_of(self.text.as_bytes(), at)),
            key: key.to_owned(),
            problem: Problem::Described,
            found: found.into(),
            expected: expected.into(),
        }
    }
}

/// Returns the line of a byte, from 1.
pub(super) fn line_of(text: &[u8], at: usize) -> usize {
    1 + text.iter().take(at).filter(|b| **b == b'\n').count()
}

#[derive(Clone, Copy)]
enum Content<'a> {
    Value(&'a Value),
    Table(&'a dyn TableLike),
    Tables(&'a ArrayOfTables),
}

/// One value of the document with its position and the path of its key.
#[derive(Clone)]
pub(super) struct Node<'a> {
    source: Source<'a>,
    path: String,
    span: Range<usize>,
    content: Content<'a>,
    kind: &'static Kind,
}

impl<'a> Node<'a> {
    fn of_value(
        source: Source<'a>,
        path: String,
        fallback: Range<usize>,
        value: &'a Value,
        kind: &'static Kind,
    ) -> Self {
        let content = match value {
            Value::InlineTable(table) => Content::Table(table),
            other => Content::Value(other),
        };
        let span = value.span().unwrap_or(fallback);
        Self { source, path, span, content, kind }
    }

    fn of_item(
        source: Source<'a>,
        path: String,
        key: Range<usize>,
        item: &'a Item,
        kind: &'static Kind,
    ) -> Option<Self> {
        let content = match item {
            Item::None => return None,
            Item::Value(value) => return Some(Self::of_value(source, path, key, value, kind)),
            Item::Table(table) => Content::Table(table),
            Item::ArrayOfTables(tables) => Content::Tables(tables),
        };
        Some(Self { source, path, span: item.span().unwrap_or(key), content, kind })
    }

    /// Returns an error at this value whose problem `found` describes.
    pub fn fail(&self, found: impl Into<String>, expected: impl Into<String>) -> SceneError {
        self.source.error(self.span.start, &self.path, found, expected)
    }

    /// Returns an error of an invalid value, `found` in the notation of the file.
    pub fn invalid(&self, found: impl Into<String>, expected: impl Into<String>) -> SceneError {
        SceneError { problem: Problem::InvalidValue, ..self.fail(found, expected) }
    }

    /// Returns an error of an invalid value that repeats this value.
    pub fn refuse(&self, expected: impl Into<String>) -> SceneError {
        self.invalid(self.shown(), expected)
    }

    /// Returns an error of a value that has to be unique and is not.
    pub fn repeated(&self, expected: impl Into<String>) -> SceneError {
        SceneError { problem: Problem::RepeatedValue, ..self.refuse(expected) }
    }

    /// Returns an error of a key that does not go together with others.
    pub fn misplaced(&self, expected: impl Into<String>) -> SceneError {
        SceneError { problem: Problem::MisplacedKey, ..self.refuse(expected) }
    }

    /// Returns the text of the value on one line.
    pub fn shown(&self) -> String {
        match self.content {
            Content::Tables(_) => "a list of tables".to_owned(),
            // A `[header]` or a dotted key repeats its path.
            Content::Table(_) if !self.raw().starts_with('{') => "a table".to_owned(),
            Content::Value(_) | Content::Table(_) => on_one_line(self.raw()),
        }
    }

    fn raw(&self) -> &'a str {
        self.source.text.get(self.span.clone()).unwrap_or_default()
    }

    /// Returns true where this is a table of any notation.
    pub(crate) fn is_table(&self) -> bool {
        matches!(self.content, Content::Table(_))
    }

    /// Returns true where this is a list.
    pub(crate) fn is_list(&self) -> bool {
        matches!(self.content, Content::Value(Value::Array(_)))
    }

    /// Reads a number without dimension, finite and in the range of its kind, which `expected` describes.
    pub fn number(&self, expected: &str) -> Read<f64> {
        self.in_bounds(self.bare_number(), expected)
    }

    /// Reads a number in the one SI unit that it may have, bare or with that unit, in the range of its kind, which `expected` describes.
    pub(crate) fn number_in_unit(&self, expected: &str) -> Read<f64> {
        let unit = if let Kind::NumberIn(unit, _) = self.kind { unit } else { "" };
        let number = match self.text(expected) {
            Ok(text) => text.trim().strip_suffix(unit).and_then(|number| number.trim().parse().ok()),
            Err(_) => self.bare_number(),
        };
        self.in_bounds(number, expected)
    }

    fn in_bounds(&self, number: Option<f64>, expected: &str) -> Read<f64> {
        let bounds = self.kind.number();
        debug_assert!(bounds.is_some(), "{} is no number", self.path);
        number.filter(|x| bounds.is_some_and(|bounds| bounds.contains(x))).ok_or_else(|| self.refuse(expected))
    }

    /// Reads a quantity in SI: a bare number or a text with a unit, in the range of its kind.
    pub fn quantity(&self) -> Read<f64> {
        let (dimension, bounds) = self.dimension()?;
        self.read_quantity(dimension, &dimension.expected(range_of(bounds)), |x| bounds.contains(&x))
    }

    /// Reads a quantity of a dimension that depends on other keys, in the range of its kind.
    pub fn quantity_in(&self, dimension: Dimension) -> Read<f64> {
        let (_, bounds) = self.dimension()?;
        self.read_quantity(dimension, &dimension.expected(range_of(bounds)), |x| bounds.contains(&x))
    }

    /// Reads a quantity in the range that `ok` tests and `range` describes, such as `above 0`.
    pub fn within(&self, range: &str, ok: impl Fn(f64) -> bool) -> Read<f64> {
        let (dimension, _) = self.dimension()?;
        self.read_quantity(dimension, &dimension.expected(range), ok)
    }

    /// Reads a quantity in the range that `ok` tests and `expected` describes in full.
    pub fn limited(&self, expected: &str, ok: impl Fn(f64) -> bool) -> Read<f64> {
        let (dimension, _) = self.dimension()?;
        self.read_quantity(dimension, expected, ok)
    }

    fn dimension(&self) -> Read<(Dimension, Bounds)> {
        let quantity = self.kind.quantity();
        debug_assert!(quantity.is_some(), "{} is no quantity", self.path);
        quantity.ok_or_else(|| self.refuse("no quantity"))
    }

    fn read_quantity(&self, dimension: Dimension, expected: &str, ok: impl Fn(f64) -> bool) -> Read<f64> {
        let value = match self.content {
            Content::Value(Value::String(text)) => {
                let parsed = units::parse(text.value(), dimension);
                parsed.map(Some).map_err(|e| self.invalid(e.found, e.expected))?
            }
            _ => self.bare_number(),
        };
        if let (Some(number), Some((limit, unit))) = (self.bare_number(), dimension.bare_limit())
            && number.abs() > limit
        {
            let expected = format!("{expected}; likely \"{number} {unit}\"");
            return Err(self.invalid(self.shown_quantity(dimension), expected));
        }
        value.filter(|x| ok(*x)).ok_or_else(|| self.invalid(self.shown_quantity(dimension), expected))
    }

    /// Returns the text of the value, with the SI unit of a bare number.
    pub(crate) fn shown_quantity(&self, dimension: Dimension) -> String {
        match self.bare_number() {
            Some(_) => format!("{} (a bare number is in {})", self.shown(), dimension.si_unit()),
            None => self.shown(),
        }
    }

    fn bare_number(&self) -> Option<f64> {
        let Content::Value(value) = self.content else {
            return None;
        };
        // Every integer of a scene is far below 2^53, and one above it only loses digits.
        let integer = value.as_integer().map(|i| i as f64);
        integer.or(value.as_float()).filter(|x| x.is_finite())
    }

    /// Reads a whole number in the range of its kind, which `expected` describes.
    pub fn integer(&self, expected: &str) -> Read<i64> {
        let range = self.kind.integer();
        debug_assert!(range.is_some(), "{} is no whole number", self.path);
        let (least, most) = range.unwrap_or_default();
        self.integer_within(least, most, expected)
    }

    /// Reads a number of its kind: whole, a quantity or one without unit.
    pub(crate) fn any_number(&self) -> Read<f64> {
        match self.kind {
            Kind::Integer(least, most) => {
                self.integer(&format!("a whole number from {least} to {most}")).map(|number| number as f64)
            }
            Kind::Quantity(..) => self.quantity(),
            _ => self.number("a number in the range of the scene reference"),
        }
    }

    /// Reads a whole number between two others.
    pub fn integer_within(&self, least: i64, most: i64, expected: &str) -> Read<i64> {
        match self.content {
            Content::Value(Value::Integer(i)) if (least..=most).contains(i.value()) => Ok(*i.value()),
            _ => Err(self.refuse(expected)),
        }
    }

    /// Reads a text that is not empty.
    pub fn text(&self, expected: &str) -> Read<&'a str> {
        let text = match self.content {
            Content::Value(Value::String(text)) => Some(text.value().as_str()),
            _ => None,
        };
        text.filter(|t| !t.trim().is_empty() && !t.contains(char::is_control)).ok_or_else(|| self.refuse(expected))
    }

    /// Reads `true` or `false`.
    pub fn boolean(&self) -> Read<bool> {
        match self.content {
            Content::Value(Value::Boolean(b)) => Ok(*b.value()),
            _ => Err(self.refuse("true or false")),
        }
    }

    /// Reads one of several words.
    pub fn choice<T: Copy>(&self, choices: &[(&str, T)]) -> Read<T> {
        let text = match self.content {
            Content::Value(Value::String(text)) => text.value().as_str(),
            _ => "",
        };
        let found = choices.iter().find(|(word, _)| *word == text);
        found.map(|(_, value)| *value).ok_or_else(|| {
            let words: Vec<String> = choices.iter().map(|(w, _)| format!("\"{w}\"")).collect();
            self.refuse(words.join(" or "))
        })
    }

    /// Returns the entries of a list, also of one written as `[[key]]` tables.
    pub fn list(&self, expected: &str) -> Read<Vec<Node<'a>>> {
        let path = |i: usize| format!("{}[{i}]", self.path);
        debug_assert!(self.kind.entry(0).is_some(), "{} is no list", self.path);
        let kind = |i: usize| self.kind.entry(i).unwrap_or(self.kind);
        match self.content {
            Content::Value(Value::Array(array)) => Ok(array
                .iter()
                .enumerate()
                .map(|(i, value)| Node::of_value(self.source, path(i), self.span.clone(), value, kind(i)))
                .collect()),
            Content::Tables(tables) => Ok(tables
                .iter()
                .enumerate()
                .map(|(i, table)| Node {
                    source: self.source,
                    path: path(i),
                    span: table.span().unwrap_or(self.span.clone()),
                    content: Content::Table(table),
                    kind: kind(i),
                })
                .collect()),
            _ => Err(self.refuse(expected)),
        }
    }

    /// Describes the quantities expected as one entry of a list.
    pub(crate) fn expected_of_entry(&self, index: usize) -> String {
        let quantity = self.kind.entry(index).and_then(Kind::quantity);
        quantity.map_or_else(String::new, |(dimension, _)| dimension.expected(""))
    }

    /// Reads a list of exactly `N` quantities.
    pub fn array<const N: usize>(&self, expected: &str) -> Read<[f64; N]> {
        let list = self.list(expected)?;
        if list.len() != N {
            return Err(self.fail(format!("a list of {}", list.len()), expected));
        }
        let mut values = [0.0; N];
        for (slot, node) in values.iter_mut().zip(&list) {
            *slot = node.quantity()?;
        }
        Ok(values)
    }

    /// Returns the table without a check of its keys, for tables that have been checked before.
    pub(crate) fn any_table(&self) -> Read<Table<'a>> {
        let keys = self.kind.keys();
        debug_assert!(keys.is_some(), "{} is no table", self.path);
        let (Content::Table(content), Some(keys)) = (self.content, keys) else { return Err(self.refuse("a table")) };
        Ok(Table {
            source: self.source,
            path: self.path.clone(),
            span: self.span.clone(),
            content,
            defaults: None,
            keys,
        })
    }

    /// Returns the table after a check that it has only keys of its kind.
    pub fn table(&self) -> Read<Table<'a>> {
        if !self.is_table() {
            let names = self.kind.keys().map(Keys::names).unwrap_or_default();
            return Err(self.refuse(format!("a table with the keys {}", names.join(", "))));
        }
        let table = self.any_table()?;
        table.check_keys()?;
        Ok(table)
    }
}

/// Returns the range of a quantity as messages describe it.
fn range_of(bounds: Bounds) -> &'static str {
    match bounds.0 {
        Bound::Excluded(_) => "above 0",
        Bound::Included(_) => "of 0 or more",
        Bound::Unbounded => "",
    }
}

/// A table whose keys are all known.
pub(super) struct Table<'a> {
    source: Source<'a>,
    path: String,
    span: Range<usize>,
    content: &'a dyn TableLike,
    defaults: Option<Defaults<'a>>,
    keys: &'static Keys,
}

/// Values of keys that the scene does not have.
#[derive(Clone)]
struct Defaults<'a> {
    content: &'a dyn TableLike,
    /// Key that stands for them, for errors.
    span: Range<usize>,
}

impl<'a> Table<'a> {
    /// Returns the whole document as a table.
    pub fn root(source: Source<'a>, content: &'a dyn TableLike, keys: &'static Keys) -> Read<Self> {
        let table = Self { source, path: String::new(), span: 0..0, content, defaults: None, keys };
        table.check_keys()?;
        Ok(table)
    }

    /// Returns the table with values of `content` for the keys that it does not have; `key` stands for them in errors.
    pub(crate) fn with_defaults(self, content: &'a dyn TableLike, key: &Node<'a>) -> Self {
        Self { defaults: Some(Defaults { content, span: key.span.clone() }), ..self }
    }

    /// Returns the value of a key, which is one of the table's.
    pub fn optional(&self, key: &str) -> Option<Node<'a>> {
        let known = self.keys.find(key);
        debug_assert!(known.is_some(), "no key {key} of {}", self.keys.name);
        let kind = &known?.kind;
        if let Some(item) = self.content.get(key) {
            return Node::of_item(self.source, self.path_of(key), self.key_span(key), item, kind);
        }
        let Defaults { content, span } = self.defaults.as_ref()?;
        Node::of_item(self.source, self.path_of(key), span.clone(), content.get(key)?, kind)
    }

    /// Returns the value of a required key; `expected` describes the values expected.
    pub fn required(&self, key: &str, expected: &str) -> Read<Node<'a>> {
        self.optional(key).ok_or_else(|| self.missing(key, expected))
    }

    /// Returns the error of a missing key.
    pub fn missing(&self, key: &str, expected: &str) -> SceneError {
        self.source.error(self.span.start, &self.path_of(key), "", expected)
    }

    /// Returns an error about the table as a whole whose problem `found` describes.
    pub fn fail(&self, found: impl Into<String>, expected: impl Into<String>) -> SceneError {
        self.source.error(self.span.start, &self.path, found, expected)
    }

    /// Rejects each of `keys` that is present, because it excludes others.
    pub fn check_without(&self, keys: &[&str], why: &str) -> Read<()> {
        match keys.iter().find_map(|key| self.optional(key)) {
            Some(node) => Err(node.misplaced(why)),
            None => Ok(()),
        }
    }

    /// Returns true where the table has the key.
    pub fn has(&self, key: &str) -> bool {
        self.optional(key).is_some()
    }

    /// Returns the keys that the scene has in this table.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.content.iter().map(|(key, _)| key)
    }

    /// Reads an optional key.
    pub fn read<T>(&self, key: &str, read: impl FnOnce(&Node<'a>) -> Read<T>) -> Read<Option<T>> {
        self.optional(key).map(|node| read(&node)).transpose()
    }

    /// Reads a required quantity in the range of its kind.
    pub fn quantity(&self, key: &str) -> Read<f64> {
        self.optional_quantity(key)?.ok_or_else(|| {
            let quantity = self.keys.find(key).and_then(|known| known.kind.quantity());
            let expected = quantity.map(|(dimension, bounds)| dimension.expected(range_of(bounds)));
            self.missing(key, &expected.unwrap_or_default())
        })
    }

    /// Reads an optional quantity in the range of its kind.
    pub fn optional_quantity(&self, key: &str) -> Read<Option<f64>> {
        self.read(key, Node::quantity)
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn key_span(&self, key: &str) -> Range<usize> {
        let span = self.content.key(key).and_then(toml_edit::Key::span);
        span.unwrap_or(self.span.clone())
    }

    /// Rejects unknown keys before values are read: a misspelt key would otherwise be reported as a missing one.
    fn check_keys(&self) -> Read<()> {
        match self.content.iter().find(|(key, _)| self.keys.find(key).is_none()) {
            Some((key, _)) => Err(self.unknown(key)),
            None => Ok(()),
        }
    }

    fn unknown(&self, key: &str) -> SceneError {
        let names = self.keys.names();
        let hint = nearest(key, &names).map_or(String::new(), |near| format!(" (did you mean {near}?)"));
        let found = format!("unknown key{hint}");
        let shown = on_one_line(key.escape_debug().to_string().as_str());
        let at = self.key_span(key).start;
        self.source.error(at, &self.path_of(&shown), found, format!("one of {}", names.join(", ")))
    }
}

/// Returns a part of the file on one line, shortened where it is long.
fn on_one_line(raw: &str) -> String {
    let words: Vec<&str> = raw.split_whitespace().collect();
    let line = words.join(" ");
    let mut shown: String = line.chars().take(LONGEST_SHOWN).collect();
    if shown.len() < line.len() {
        shown.push_str("...");
    }
    shown
}

/// Returns the allowed key that is most similar; none where no key is similar.
fn nearest<'k>(key: &str, keys: &[&'k str]) -> Option<&'k str> {
    // Two swapped letters count as two edits; in a short word as many make another word.
    let tolerated = match key.chars().count() {
        0..=3 => 1,
        4..=8 => 2,
        _ => 3,
    };
    let distances = keys.iter().map(|known| (distance(key, known), *known));
    let (least, known) = distances.min_by_key(|(d, _)| *d)?;
    (least <= tolerated).then_some(known)
}

/// Returns the Levenshtein distance; `key` is cut, because a key may be as long as the file.
fn distance(key: &str, known: &str) -> usize {
    let known: Vec<char> = known.chars().collect();
    let mut row: Vec<usize> = (0..=known.len()).collect();
    for (i, letter) in key.chars().take(2 * known.len() + 8).enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        for (slot, other) in row.iter_mut().skip(1).zip(&known) {
            let substituted = diagonal + usize::from(letter != *other);
            diagonal = *slot;
            left = substituted.min(left + 1).min(*slot + 1);
            *slot = left;
        }
        if let Some(first) = row.first_mut() {
            *first = i + 1;
        }
    }
    row.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_edits() {
        for (a, b, wanted) in [
            ("", "", 0),
            ("", "abc", 3),
            ("abc", "", 3),
            ("station", "station", 0),
            ("staton", "station", 1),
            ("statiom", "station", 1),
            ("sttaion", "station", 2),
            ("kitten", "sitting", 3),
        ] {
            assert_eq!(distance(a, b), wanted, "{a} {b}");
        }
    }

    #[test]
    fn nearest_key_is_only_offered_when_near() {
        let keys = ["ball_diameter", "name", "station"];
        assert_eq!(nearest("ball_daimeter", &keys), Some("ball_diameter"));
        assert_eq!(nearest("Name", &keys), Some("name"));
        assert_eq!(nearest("naem", &keys), Some("name"));
        assert_eq!(nearest("colour", &keys), None);
        assert_eq!(nearest("", &[]), None);
    }
}
