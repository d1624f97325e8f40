//! Reader of the table of machines.

use super::machine::{Machine, SceneSource};
use super::row::Key;
use ballrace_base::bounded::open_regular;
use ballrace_base::bounded::read_bytes;
use ballrace_base::caught::caught;
use ballrace_plant::error::{FleetError, TablePosition};
use ballrace_recording::Time;
use chrono::{DateTime, NaiveDate};
use parquet::basic::{LogicalType, TimeUnit};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

/// Largest length of the file, bytes.
const LARGEST_FILE: u64 = 256 << 20;

/// One row of a table as text.
#[derive(Debug, Clone)]
pub struct Cells {
    /// The row.
    pub position: TablePosition,
    /// One cell per column.
    pub cells: Vec<String>,
}

/// Reads a table of machines in CSV (comma, semicolon or tab) or Parquet.
///
/// The columns `machine` and `scene` are required, `recording`, `baseline` and `time` optional; every other column is a tag. A
/// scene is a path, or, with a line break, the text of a scene. Relative paths start from the folder of the table.
///
/// # Errors
/// Returns an error if the file cannot be read, or the first error in the table.
pub fn read_table(file: &Path) -> Result<Vec<Machine>, FleetError> {
    let failed = |source| FleetError::Read { file: file.to_owned(), source };
    let bytes = read_bytes(file, LARGEST_FILE).map_err(failed)?;
    let (header, columns, rows) = if bytes.starts_with(b"PAR1") { parquet(file)? } else { csv(file, &bytes)? };
    machines(file, header, &columns, rows)
}

/// Returns the machines of a table.
///
/// Error messages contain `file`, and relative paths start from its folder; `header` is the position of the names of the columns.
///
/// # Errors
/// Returns the first error in the table.
pub fn machines(
    file: &Path,
    header: TablePosition,
    columns: &[String],
    rows: impl IntoIterator<Item = Cells>,
) -> Result<Vec<Machine>, FleetError> {
    let columns: Vec<&str> = columns.iter().map(|name| name.trim()).collect();
    let mut names = HashSet::new();
    if let Some(column) = columns.iter().find(|name| !names.insert(**name)) {
        return Err(FleetError::RepeatedColumn { file: file.into(), position: header, column: (*column).to_owned() });
    }
    if let Some(column) = ["machine", "scene"].into_iter().find(|name| !names.contains(name)) {
        let found = columns.iter().map(|name| (*name).to_owned()).collect();
        return Err(FleetError::MissingColumn { file: file.into(), position: header, column, found });
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    let (mut machines, mut keys) = (Vec::new(), HashMap::<Key, TablePosition>::new());
    for Cells { position, cells } in rows {
        if cells.len() != columns.len() {
            let (found, expected) = (cells.len(), columns.len());
            return Err(FleetError::RowLength { file: file.into(), position, found, expected });
        }
        let cells = columns.iter().copied().zip(cells).collect();
        let machine = machine(file, folder, position, cells)?;
        if let Some(first) = keys.insert(machine.key(), position) {
            let Key { machine, recording } = machine.key();
            return Err(FleetError::RepeatedKey { file: file.into(), position, first, machine, recording });
        }
        machines.push(machine);
    }
    if machines.is_empty() {
        return Err(FleetError::Empty { file: file.into() });
    }
    Ok(machines)
}

fn machine(
    file: &Path,
    folder: &Path,
    position: TablePosition,
    mut cells: BTreeMap<&str, String>,
) -> Result<Machine, FleetError> {
    let invalid =
        |column, found, expected| FleetError::Cell { file: file.to_owned(), position, column, found, expected };
    let mut cell = |column: &str| cells.remove(column).filter(|text| !text.trim().is_empty());
    let name = cell("machine").ok_or_else(|| invalid("machine", String::new(), "the name of a machine"))?;
    let scene = cell("scene").ok_or_else(|| invalid("scene", String::new(), "a scene file or the text of a scene"))?;
    let path = |text: String| folder.join(text.trim());
    let scene = if scene.trim().contains('\n') {
        SceneSource::Text { text: scene, folder: folder.to_owned() }
    } else {
        SceneSource::Path(path(scene))
    };
    let recording = cell("recording");
    let time = cell("time").map(|text| Time::parse(&text).ok_or_else(|| invalid("time", text, Time::ALLOWED)));
    Ok(Machine {
        name: name.trim().to_owned(),
        scene,
        recording_name: recording.as_deref().unwrap_or_default().trim().to_owned(),
        recording: recording.map(path),
        baseline: cell("baseline").map(path),
        time: time.transpose()?,
        tags: cells.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
    })
}

type Text = (TablePosition, Vec<String>, Vec<Cells>);

fn csv(file: &Path, bytes: &[u8]) -> Result<Text, FleetError> {
    let format = |found: String| FleetError::Format { file: file.to_owned(), found };
    let text = std::str::from_utf8(bytes).map_err(|_| format("bytes that are not UTF-8 text".to_owned()))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let head = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let delimiter = [b',', b';', b'\t'].into_iter().find(|delimiter| head.as_bytes().contains(delimiter));
    let mut builder = csv::ReaderBuilder::new();
    let mut reader =
        builder.delimiter(delimiter.unwrap_or(b',')).has_headers(false).flexible(true).from_reader(text.as_bytes());
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| format(error.to_string()))?;
        let position = TablePosition::Line(record.position().map_or(0, csv::Position::line));
        let cells: Vec<String> = record.iter().map(str::to_owned).collect();
        if cells.iter().any(|cell| !cell.trim().is_empty()) {
            rows.push(Cells { position, cells });
        }
    }
    if rows.is_empty() {
        return Err(FleetError::Empty { file: file.to_owned() });
    }
    let header = rows.remove(0);
    Ok((header.position, header.cells, rows))
}

fn parquet(file: &Path) -> Result<Text, FleetError> {
    let format = |found: String| FleetError::Format { file: file.to_owned(), found };
    // The library's decoders panic on some damaged files.
    let read = caught(|| rows_of(file)).unwrap_or_else(|_| Err("a damaged file, which cannot be decoded".into()));
    let (columns, rows) = read.map_err(|error| format(error.to_string()))?;
    let cells = |(cells, row)| Cells { position: TablePosition::Row(row), cells };
    Ok((TablePosition::Columns, columns, rows.into_iter().zip(1..).map(cells).collect()))
}

type Failure = Box<dyn std::error::Error>;

/// Returns the names of the columns and the rows of a Parquet file.
fn rows_of(file: &Path) -> Result<(Vec<String>, Vec<Vec<String>>), Failure> {
    let reader = SerializedFileReader::new(open_regular(file)?)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let fields = schema.root_schema().get_fields();
    let columns: Vec<String> = fields.iter().map(|field| field.name().to_owned()).collect();
    let nanoseconds: Vec<bool> = fields
        .iter()
        .map(|field| {
            let logical = field.get_basic_info().logical_type_ref();
            matches!(logical, Some(LogicalType::Timestamp(kind)) if kind.unit == TimeUnit::NANOS)
        })
        .collect();
    let mut rows = Vec::new();
    for row in reader.get_row_iter(None)? {
        let row = row?;
        let cells = row.get_column_iter().zip(&nanoseconds).map(|((_, field), nanoseconds)| text(field, *nanoseconds));
        rows.push(cells.collect());
    }
    Ok((columns, rows))
}

fn text(field: &Field, nanoseconds: bool) -> String {
    let time = |time: Option<DateTime<chrono::Utc>>| time.map_or_else(String::new, |time| time.to_rfc3339());
    match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        Field::Date(days) => NaiveDate::from_epoch_days(*days).map_or_else(String::new, |date| date.to_string()),
        Field::TimestampMillis(value) => time(DateTime::from_timestamp_millis(*value)),
        Field::TimestampMicros(value) => time(DateTime::from_timestamp_micros(*value)),
        Field::Long(value) if nanoseconds => time(Some(DateTime::from_timestamp_nanos(*value))),
        other => other.to_string(),
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_recording::parquet_table::{self, Column, Values};
    use std::fs::File;
    use std::path::PathBuf;

    fn joined(folder: &str, name: &str) -> PathBuf {
        Path::new(folder).join(name)
    }

    fn read(text: &str) -> Result<Vec<Machine>, String> {
        let (header, columns, rows) = csv(Path::new("a/m.csv"), text.as_bytes()).map_err(|e| e.to_string())?;
        machines(Path::new("a/m.csv"), header, &columns, rows).map_err(|error| error.to_string())
    }

    #[test]
    fn rows_are_machines() {
        let text = "\u{feff}machine;time;scene;recording;hall;baseline\r\n\r\npump 1;2026-01-02;p.toml;d/1.csv;A;\r\nfan;;/x/f.toml;;\"B; C\";b.json\r\n";
        let machines = read(text).unwrap();
        let [pump, fan] = [&machines[0], &machines[1]];
        assert_eq!(pump.scene, SceneSource::Path(joined("a", "p.toml")));
        assert_eq!((pump.recording.clone(), pump.recording_name.as_str()), (Some(joined("a", "d/1.csv")), "d/1.csv"));
        assert_eq!(pump.time, Time::parse("2026-01-02"));
        assert_eq!(pump.tags.get("hall").map(String::as_str), Some("A"));
        assert_eq!((fan.scene.clone(), fan.recording.clone()), (SceneSource::Path("/x/f.toml".into()), None));
        assert_eq!(fan.baseline, Some(joined("a", "b.json")));
        assert_eq!(fan.tags.get("hall").map(String::as_str), Some("B; C"));
    }

    #[test]
    fn a_scene_with_line_breaks_is_its_text() {
        let machines = read("machine,scene\nfan,\"name = \"\"x\"\"\n[shaft]\n\"\n").unwrap();
        let expected = SceneSource::Text { text: "name = \"x\"\n[shaft]\n".to_owned(), folder: "a".into() };
        assert_eq!(machines[0].scene, expected);
    }

    #[test]
    fn a_wrong_table_has_one_error_with_its_place() {
        let wrong = [
            (
                "machine,recording\na,b\n",
                "a/m.csv:1: missing column \"scene\", expected the columns machine and scene; found machine, recording",
            ),
            ("machine,scene,scene\n", "a/m.csv:1: repeated column: \"scene\", expected each name once"),
            ("", "a/m.csv: empty table, expected at least one machine"),
            ("machine,scene\n", "a/m.csv: empty table, expected at least one machine"),
            ("machine,scene\na,b,c\n", "a/m.csv:2: wrong number of cells: 3, expected 2 as in the header"),
            ("machine,scene\n,b\n", "a/m.csv:2: column machine: invalid value: \"\", expected the name of a machine"),
            (
                "machine,scene,time\na,b,\nc,d,monday\n",
                "a/m.csv:3: column time: invalid value: \"monday\", expected an ISO 8601 date",
            ),
            (
                "machine,scene\na,b\n\nc,d\na,e\n",
                "a/m.csv:5: repeated machine and recording: \"a\" with \"\" as at a/m.csv:2, expected each pair once",
            ),
        ];
        for (text, expected) in wrong {
            let found = read(text).unwrap_err();
            assert!(found.starts_with(expected), "{found}, expected {expected}");
        }
    }

    #[test]
    fn parquet_is_read_as_csv_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("m.parquet");
        let word = |name: &str, cells: [&str; 2]| Column::new(name, Values::Word(cells.map(str::to_owned).to_vec()));
        let columns = [
            word("machine", ["a", "b"]),
            word("scene", ["a.toml", "b.toml"]),
            word("time", ["2026-01-01", ""]),
            Column::new("line", Values::Count(vec![Some(7), None])),
        ];
        parquet_table::write(File::create(&file).unwrap(), "machines", &columns).unwrap();
        let machines = read_table(&file).unwrap();
        assert_eq!(machines[0].scene, SceneSource::Path(folder.path().join("a.toml")));
        assert_eq!((machines[0].time, machines[1].time), (Time::parse("2026-01-01"), None));
        let tags = machines.iter().map(|machine| machine.tags["line"].as_str()).collect::<Vec<_>>();
        assert_eq!(tags, ["7", ""]);
        std::fs::write(&file, b"PAR1 and nothing else").unwrap();
        assert!(read_table(&file).unwrap_err().to_string().contains("unreadable table"));
    }
}
