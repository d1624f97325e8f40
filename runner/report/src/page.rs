//! A report as one HTML file: verdict, contents, figures, tables, the values of the figures and the script that reads them.
//!
//! Every report is a [`Page`]; the template, the style and the script are the same for all. The page loads nothing and runs no script
//! but its own ([`script_hash`]).

use super::figures::{CurveKind, CurveValues, Picture, Plot, Shape, Source};
use anyhow::{Context, Result};
use ballrace_twin::replay::outcome::NumericField;
use minijinja::value::Serde;
use minijinja::{Environment, Value};
use serde::{Serialize, Serializer};
use serde_json::json;
use sha2::{Digest, Sha256};
use std::borrow::Cow;

const NAME: &str = "report.html";
const TEMPLATE: &str = include_str!("page/report.html");
const STYLE: &str = include_str!("page/report.css");
const SCRIPT: &str = include_str!("page/report.js");

/// Heading of the figures that show why the verdict is as it is.
pub(super) const EVIDENCE: &str = "Evidence";
/// Number of its figures that are printed: all of two faults.
const PRINTED_EVIDENCE: usize = 6;
/// Largest number of figures of a report whose figures are all printed.
const PRINTED: usize = 8;
/// Number of figures that are printed per section of a larger report, so that it has about six pages.
const PRINTED_OF_SECTION: usize = 2;
/// Largest number of sections with this number of printed figures; with more sections, one figure of each is printed.
const MAX_SECTIONS: usize = 12;

/// One report.
#[derive(Debug, Default, Serialize)]
pub(super) struct Page {
    /// Name of the machine.
    pub(super) title: String,
    /// Subject of the report.
    pub(super) subtitle: String,
    pub(super) verdict: Option<Verdict>,
    /// Name and value, below the verdict.
    pub(super) facts: Vec<Fact>,
    pub(super) sections: Vec<PageSection>,
    /// Units and conventions.
    pub(super) footer: String,
    /// Values of the page as a whole for the script.
    #[serde(skip)]
    pub(super) data: serde_json::Map<String, serde_json::Value>,
    /// Names of probes and bearings whose figures are printed first.
    #[serde(skip)]
    pub(super) relevant: Vec<String>,
}

/// A verdict in a colour and words.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Verdict {
    pub(super) level: Level,
    pub(super) word: &'static str,
    pub(super) sentence: String,
    /// Recommended action; may be empty.
    pub(super) action: String,
}

/// Colour of a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Level {
    Red,
    Amber,
    Green,
    /// Nothing is judged.
    Neutral,
}

/// Name and value.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Fact {
    pub(super) name: String,
    pub(super) value: String,
}

impl Fact {
    pub(super) fn new(name: &str, value: impl Into<String>) -> Self {
        Self { name: name.to_owned(), value: value.into() }
    }
}

/// A section with its heading, which the contents list.
#[derive(Debug, Serialize)]
pub(super) struct PageSection {
    pub(super) heading: String,
    pub(super) content: Content,
    /// Explanation below the heading; may be empty.
    pub(super) note: String,
}

/// Content of a section.
#[derive(Debug, Serialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub(super) enum Content {
    Figures {
        shape: &'static str,
        #[serde(serialize_with = "pictures")]
        figures: Vec<Picture>,
    },
    Table {
        table: Table,
    },
    Facts {
        facts: Vec<Fact>,
    },
    List {
        items: Vec<String>,
    },
}

/// A table: units are below the names of the columns.
#[derive(Debug, Default, Serialize)]
pub(super) struct Table {
    /// Names above several columns, with the number of columns of each; empty where there are none.
    pub(super) groups: Vec<(usize, &'static str)>,
    pub(super) columns: Vec<Column>,
    pub(super) rows: Vec<Row>,
    /// Explanation below; may be empty.
    pub(super) note: String,
    /// A column has sentences: on a narrow screen each row becomes a list.
    pub(super) is_wordy: bool,
}

/// A column.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Column {
    pub(super) name: Cow<'static, str>,
    pub(super) unit: &'static str,
    /// Class of its cells: `name`, `number` or `words`.
    pub(super) class: &'static str,
}

impl Column {
    /// Creates a column of numbers.
    pub(super) fn number(name: impl Into<Cow<'static, str>>, unit: &'static str) -> Self {
        Self { name: name.into(), unit, class: "number" }
    }

    /// Creates the column of a field.
    pub(super) fn field<T, V>(field: &NumericField<T, V>) -> Self {
        Self::number(field.name, field.unit)
    }

    /// Creates a column of short names.
    pub(super) fn name(name: &'static str) -> Self {
        Self { name: name.into(), unit: "", class: "name" }
    }

    /// Creates a column of sentences.
    pub(super) fn words(name: &'static str) -> Self {
        Self { name: name.into(), unit: "", class: "words" }
    }
}

/// A row.
#[derive(Debug, Default, Serialize)]
pub(super) struct Row {
    pub(super) cells: Vec<Cell>,
    /// Number of the diagnosis that a click highlights.
    pub(super) diagnosis: Option<usize>,
    /// Class of the row; may be empty.
    pub(super) class: &'static str,
}

impl Row {
    pub(super) fn new<T: Into<Cell>>(cells: impl IntoIterator<Item = T>) -> Self {
        Self { cells: cells.into_iter().map(Into::into).collect(), ..Self::default() }
    }
}

/// A cell.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct Cell {
    pub(super) text: String,
    /// Number of rows that it spans; 0 for one row.
    pub(super) rows: usize,
    /// Class; if empty, that of its column where a row has a cell for every column.
    pub(super) class: &'static str,
    /// The cell is the heading of its row.
    pub(super) is_head: bool,
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), ..Self::default() }
    }
}

impl Table {
    /// Adds a row. In a row with a cell for every column, the first cell becomes the heading.
    pub(super) fn push(&mut self, mut row: Row) {
        self.is_wordy = self.columns.iter().any(|column| column.class == "words");
        if row.cells.len() == self.columns.len() {
            for (i, (cell, column)) in row.cells.iter_mut().zip(&self.columns).enumerate() {
                cell.is_head = i == 0;
                if cell.class.is_empty() {
                    cell.class = column.class;
                }
            }
        }
        self.rows.push(row);
    }

    /// Returns a table of rows of texts.
    pub(super) fn of<R: IntoIterator<Item = String>>(
        columns: Vec<Column>,
        rows: impl IntoIterator<Item = R>,
        note: impl Into<String>,
    ) -> Self {
        let mut table = Self { columns, note: note.into(), ..Self::default() };
        rows.into_iter().for_each(|row| table.push(Row::new(row)));
        table
    }
}

impl PageSection {
    pub(super) fn figures(heading: &str, shape: Shape, figures: Vec<Picture>) -> Self {
        let shape = match shape {
            Shape::Square => "square",
            Shape::Wide => "wide",
        };
        // A note that all figures share is printed once, under the heading.
        let first = figures.first().map_or("", |picture| picture.note.as_str()).to_owned();
        let is_shared = figures.len() > 1 && figures.iter().all(|picture| picture.note == first);
        let (note, figures) = if is_shared {
            (first, figures.into_iter().map(|picture| Picture { note: String::new(), ..picture }).collect())
        } else {
            (String::new(), figures)
        };
        Self { heading: heading.to_owned(), content: Content::Figures { shape, figures }, note }
    }

    fn pictures(&self) -> Option<&[Picture]> {
        match &self.content {
            Content::Figures { figures, .. } => Some(figures),
            _ => None,
        }
    }

    pub(super) fn table(heading: &str, table: Table) -> Self {
        Self { heading: heading.to_owned(), content: Content::Table { table }, note: String::new() }
    }

    pub(super) fn list(heading: &str, items: Vec<String>) -> Self {
        Self { heading: heading.to_owned(), content: Content::List { items }, note: String::new() }
    }

    pub(super) fn facts(heading: &str, facts: Vec<Fact>) -> Self {
        Self { heading: heading.to_owned(), content: Content::Facts { facts }, note: String::new() }
    }
}

fn pictures<S: Serializer>(pictures: &[Picture], serializer: S) -> Result<S::Ok, S::Error> {
    let view = |picture: &Picture| {
        json!({
            "title": picture.title,
            "note": picture.note,
            "svg": picture.drawing.svg,
            "is_printed": picture.is_printed,
        })
    };
    serializer.collect_seq(pictures.iter().map(view))
}

/// Renders the page as HTML.
///
/// # Errors
/// Returns an error if the template cannot be read or rendered.
pub(super) fn render(mut page: Page) -> Result<String> {
    let counts: Vec<usize> = page.sections.iter().filter_map(PageSection::pictures).map(<[Picture]>::len).collect();
    let most = match counts.iter().sum::<usize>() {
        figures if figures <= PRINTED => PRINTED,
        _ if counts.len() > MAX_SECTIONS => 1,
        _ => PRINTED_OF_SECTION,
    };
    let mut left_out = 0;
    for section in &mut page.sections {
        if let Content::Figures { figures, .. } = &mut section.content {
            let most = if section.heading == EVIDENCE { PRINTED_EVIDENCE } else { most };
            left_out += choose_printed(figures, most, &page.relevant);
        }
    }
    let mut environment = Environment::new();
    // The name ends in .html: every value is escaped, save those marked as safe.
    environment.add_template(NAME, TEMPLATE).context("reading the report's template")?;
    let template = environment.get_template(NAME).context("reading the report's template")?;
    let data = data(&page).to_string().replace('<', "\\u003c");
    let context = minijinja::context! {
        page => Value::from(Serde(&page)),
        left_out => left_out,
        version => env!("CARGO_PKG_VERSION"),
        style => Value::from_safe_string(STYLE.to_owned()),
        script => Value::from_safe_string(SCRIPT.to_owned()),
        script_hash => Value::from_safe_string(script_hash()),
        data => Value::from_safe_string(data),
    };
    template.render(context).context("writing the report")
}

/// Marks at most `most` figures of a section as printed, those with relevant names first; returns the number of the others.
fn choose_printed(figures: &mut [Picture], most: usize, relevant: &[String]) -> usize {
    let is_relevant = |picture: &Picture| relevant.iter().any(|name| picture.title.contains(name.as_str()));
    let mut order: Vec<usize> = (0..figures.len()).collect();
    order.sort_by_key(|i| !is_relevant(&figures[*i]));
    for i in order.iter().take(most) {
        figures[*i].is_printed = true;
    }
    figures.len().saturating_sub(most)
}

/// Returns the source expression of a content security policy that allows the script of the reports and no other.
pub(super) fn script_hash() -> String {
    format!("sha256-{}", base64(&Sha256::digest(SCRIPT.as_bytes())))
}

/// Returns the data of the script: the frames of each figure in the order of the page, with the values of their curves.
fn data(page: &Page) -> serde_json::Value {
    let figures = page.sections.iter().filter_map(PageSection::pictures);
    let figure = |picture: &Picture| {
        let plots: Vec<_> = picture.drawing.plots.iter().map(plot).collect();
        json!({ "plots": plots, "source": picture.source.map(source) })
    };
    let mut data = page.data.clone();
    data.insert("figures".to_owned(), figures.flatten().map(figure).collect());
    data.into()
}

fn source(source: Source) -> serde_json::Value {
    let (kind, index) = match source {
        Source::Trace(i) => ("trace", i),
        Source::Spectrum(i) => ("spectrum", i),
        Source::FullSpectrum(i) => ("full", i),
        Source::Orbit(i) => ("orbit", i),
        Source::FilteredOrbit(i) => ("filtered", i),
    };
    json!({ "kind": kind, "index": index })
}

fn plot(plot: &Plot) -> serde_json::Value {
    let frame = &plot.frame;
    let axis = |axis: &super::figures::Axis| json!({ "low": axis.low(), "high": axis.high(), "log": axis.is_logarithmic(), "title": axis.title });
    let tenths = |x: f64| (10.0 * x).round() / 10.0;
    let edges = [frame.left, frame.top, frame.right, frame.bottom].map(tenths);
    let curves: Vec<serde_json::Value> = plot.curves.iter().map(curve).collect();
    json!({
        "box": edges,
        "x": axis(&frame.x),
        "y": axis(&frame.y),
        "below": plot.has_labels_below,
        "curves": curves,
    })
}

fn curve(curve: &CurveValues) -> serde_json::Value {
    let x: Vec<f64> = curve.points.iter().map(|point| point.0).collect();
    let y: Vec<f64> = curve.points.iter().map(|point| point.1).collect();
    let kind = match curve.kind {
        CurveKind::Function => "function",
        CurveKind::Path => "path",
        CurveKind::Scatter => "scatter",
        CurveKind::Ridge(_) => "ridge",
    };
    let along = if let CurveKind::Ridge(along) = curve.kind { Some(along) } else { None };
    json!({ "name": curve.name, "kind": kind, "along": along, "x": column(&x), "y": singles(&y) })
}

/// Returns evenly spaced values as start, step and number, other values as [`singles`].
fn column(values: &[f64]) -> serde_json::Value {
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return json!("") };
    let step = (last - first) / (values.len() - 1).max(1) as f64;
    let is_even = |(i, x): (usize, &f64)| (x - (first + step * i as f64)).abs() <= 1e-6 * step.abs();
    if values.len() > 1 && values.iter().enumerate().all(is_even) {
        json!([first, step, values.len()])
    } else {
        singles(values)
    }
}

/// Returns values as base64 of little-endian `f32`.
pub(super) fn singles(values: &[f64]) -> serde_json::Value {
    json!(base64(&values.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect::<Vec<u8>>()))
}

/// Returns values as base64 of little-endian `i16` with offset and step; `i16::MIN` is a missing value.
pub(super) fn steps(values: &[f32]) -> serde_json::Value {
    const MISSING: i16 = i16::MIN;
    let finite = values.iter().copied().filter(|x| x.is_finite()).map(f64::from);
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let (middle, step) = if low <= high { (0.5 * (low + high), (high - low) / 65_000.0) } else { (0.0, 0.0) };
    let step = step.max(f64::MIN_POSITIVE);
    let number = |x: &f32| if x.is_finite() { ((f64::from(*x) - middle) / step).round() as i16 } else { MISSING };
    let bytes: Vec<u8> = values.iter().flat_map(|x| number(x).to_le_bytes()).collect();
    json!({ "offset": middle, "step": step, "values": base64(&bytes) })
}

/// Returns the bytes in base64 (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let word = group.iter().enumerate().fold(0_u32, |word, (i, byte)| word | u32::from(*byte) << (16 - 8 * i));
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= group.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest script of a report, bytes.
    const MAX_SCRIPT: usize = 60_000;

    #[test]
    fn base64_is_that_of_the_rfc() {
        let cases =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (text, expected) in cases {
            assert_eq!(base64(text.as_bytes()), expected);
        }
    }

    #[test]
    fn the_script_is_small_and_ends_no_element() {
        assert!(SCRIPT.len() < MAX_SCRIPT, "{} bytes", SCRIPT.len());
        assert!(!SCRIPT.contains("</") && !SCRIPT.contains("<!--") && !STYLE.contains("</"));
    }

    #[test]
    fn even_columns_are_short() {
        assert_eq!(column(&[1.0, 1.5, 2.0]), json!([1.0, 0.5, 3]));
        assert!(column(&[1.0, 1.5, 2.1]).is_string() && column(&[1.0]).is_string());
    }

    #[test]
    fn readings_keep_their_values_to_a_step() {
        let values = [-3.0, f32::NAN, 7.0, 2.5];
        let packed = steps(&values);
        let (offset, step) = (packed["offset"].as_f64().unwrap_or(0.0), packed["step"].as_f64().unwrap_or(0.0));
        assert!((offset - 2.0).abs() < 1e-9 && (step - 10.0 / 65_000.0).abs() < 1e-9);
        assert_eq!(packed["values"], base64(&[0x0c, 0x81, 0x00, 0x80, 0xf4, 0x7e, 0xb2, 0x0c]).as_str());
    }
}
