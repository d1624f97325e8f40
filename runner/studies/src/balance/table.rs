//! Table of vibration vectors: once-per-turn amplitudes and phases of probes, with known and unknown masses on the planes.

use super::SAME_SPEED;
use ballrace_base::printable::name as printable;
use nalgebra::Complex;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Complex amplitude.
pub type C = Complex<f64>;

/// What is known of the masses of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Set {
    /// Nothing was added.
    Baseline,
    /// The added masses are given.
    Trial,
    /// The added masses are given and stay mounted.
    Trim,
    /// The added masses are asked for.
    Blind,
}

/// One vector of every probe.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Condition of the machine: the part of the identifier before `_N`.
    pub condition: String,
    /// What is known of its masses.
    pub set: Set,
    /// Shaft speed, rpm.
    pub speed: f64,
    /// Moment added to each plane, g mm; 0 in a baseline, unknown in a blind record.
    pub moments: Option<Vec<C>>,
    /// Once-per-turn vector of each probe, peak, in the unit of the table. Its angle grows with that of a mass.
    pub response: Vec<C>,
    /// Time of the record, s; `None` where the table has none.
    pub time: Option<f64>,
}

/// Vectors of one machine.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorTable {
    /// Names of the planes.
    pub planes: Vec<String>,
    /// Names of the probes.
    pub probes: Vec<String>,
    /// Unit of the vectors.
    pub unit: String,
    /// Records in the order of the file.
    pub records: Vec<Record>,
    /// Vectors were taken while the speed changed.
    pub has_run_ups: bool,
}

/// Error of a table of vectors.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    File {
        /// File.
        path: PathBuf,
        /// Cause.
        source: csv::Error,
    },
    /// A column is missing or has no meaning.
    #[error("{}: column {}: {found}, expected {expected}", path.display(), printable(column))]
    Column {
        /// File.
        path: PathBuf,
        /// Column.
        column: String,
        /// What was found.
        found: &'static str,
        /// What is expected.
        expected: String,
    },
    /// A cell is invalid.
    #[error("{}: line {line}: {}: value out of range: \"{}\", expected {expected}", path.display(), printable(column), printable(found))]
    Cell {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Column.
        column: String,
        /// Text of the cell.
        found: String,
        /// What is expected.
        expected: &'static str,
    },
    /// The table or its times do not hold what an estimate needs.
    #[error("{}: {found}, expected {expected}", path.display())]
    Records {
        /// File.
        path: PathBuf,
        /// What was found.
        found: String,
        /// What is expected.
        expected: String,
    },
}

/// Units of vectors.
const UNITS: [&str; 4] = ["um", "mil", "mm", "m"];
/// Columns of every table.
const FIXED: [&str; 3] = ["id", "set", "speed_rpm"];
/// Words of the column `set`.
const SETS: &str = "baseline, trial, trim or blind";
/// Column of the time of a record.
const TIME: &str = "time_s";

/// Columns of a table: those of each plane, and of each probe.
struct Columns {
    fixed: [usize; 3],
    time: Option<usize>,
    planes: Vec<(String, [usize; 2])>,
    probes: Vec<(String, [usize; 2])>,
    unit: String,
}

impl Columns {
    fn new(path: &Path, names: &csv::StringRecord) -> Result<Self, TableError> {
        let error = |column: &str, found: &'static str, expected: String| TableError::Column {
            path: path.to_owned(),
            column: column.to_owned(),
            found,
            expected,
        };
        let at = |name: &str| names.iter().position(|other| other.trim() == name);
        let required = |name: &str, why: &str| at(name).ok_or_else(|| error(name, "missing", why.to_owned()));
        let fixed = [
            required(FIXED[0], "an identifier such as A007_N1_m1_a1")?,
            required(FIXED[1], SETS)?,
            required(FIXED[2], "the shaft speed")?,
        ];
        let (mut planes, mut probes, mut unit) = (vec![], vec![], None);
        for (i, name) in names.iter().enumerate() {
            let name = name.trim();
            if names.iter().take(i).any(|other| other.trim() == name) {
                return Err(error(name, "stands twice", "each name once".to_owned()));
            }
            if let Some(plane) = name.strip_suffix("_g_mm") {
                let angle = required(&format!("{plane}_deg"), "the angle of the plane's mass")?;
                planes.push((plane.to_owned(), [i, angle]));
            } else if let Some((probe, of)) = name.rsplit_once("_re_") {
                if !UNITS.contains(&of) {
                    return Err(error(name, "unknown unit", format!("one of {}", UNITS.join(", "))));
                }
                if *unit.get_or_insert(of) != of {
                    return Err(error(
                        name,
                        "another unit than that of the column before",
                        "one unit for all probes".to_owned(),
                    ));
                }
                let imaginary = required(&format!("{probe}_im_{of}"), "the imaginary part of the vector")?;
                probes.push((probe.to_owned(), [i, imaginary]));
            }
        }
        let used = |i: usize| {
            let pairs = planes.iter().chain(&probes).any(|(_, pair): &(String, [usize; 2])| pair.contains(&i));
            pairs || fixed.contains(&i)
        };
        let is_time = |name: &str| name == TIME;
        if let Some((_, name)) = names.iter().enumerate().find(|(i, name)| !used(*i) && !is_time(name.trim())) {
            let expected =
                format!("{}, {TIME}, PLANE_g_mm with PLANE_deg, PROBE_re_UNIT with PROBE_im_UNIT", FIXED.join(", "));
            return Err(error(name, "unknown", expected));
        }
        if planes.is_empty() {
            return Err(error("PLANE_g_mm", "missing", "the moment on each plane".to_owned()));
        }
        let Some(unit) = unit else {
            return Err(error("PROBE_re_UNIT", "missing", "the real part of the vector of each probe".to_owned()));
        };
        Ok(Self { fixed, time: at(TIME), planes, probes, unit: unit.to_owned() })
    }
}

/// A line of a table.
struct Line<'a> {
    path: &'a Path,
    names: &'a csv::StringRecord,
    cells: &'a csv::StringRecord,
}

impl Line<'_> {
    fn text(&self, column: usize) -> &str {
        self.cells.get(column).unwrap_or_default().trim()
    }

    fn error(&self, column: usize, expected: &'static str) -> TableError {
        TableError::Cell {
            path: self.path.to_owned(),
            line: self.cells.position().map_or(0, csv::Position::line),
            column: self.names.get(column).unwrap_or_default().trim().to_owned(),
            found: self.text(column).to_owned(),
            expected,
        }
    }

    fn number(&self, column: usize, expected: &'static str) -> Result<f64, TableError> {
        self.text(column).parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| self.error(column, expected))
    }

    /// Returns the moment of a plane; an angle is required where it is not 0.
    fn moment(&self, [size, angle]: [usize; 2]) -> Result<C, TableError> {
        let moment = self.number(size, "the added moment in g mm, 0 or more")?;
        if moment < 0.0 {
            return Err(self.error(size, "the added moment in g mm, 0 or more"));
        }
        let angle = if moment == 0.0 { 0.0 } else { self.number(angle, "the angle of the mass in degrees")? };
        Ok(C::from_polar(moment, angle.to_radians()))
    }
}

impl VectorTable {
    /// Returns the speed of each record, by its number, and the mean of each speed, rpm.
    #[must_use]
    pub fn speeds(&self) -> (Vec<usize>, Vec<f64>) {
        let mut speeds: Vec<(f64, usize)> = vec![];
        let of_record = self.records.iter().map(|record| {
            let is_same = |(sum, count): &(f64, usize)| (record.speed * *count as f64 / sum - 1.0).abs() < SAME_SPEED;
            let speed = speeds.iter().position(is_same).unwrap_or_else(|| {
                speeds.push((0.0, 0));
                speeds.len() - 1
            });
            speeds[speed].0 += record.speed;
            speeds[speed].1 += 1;
            speed
        });
        let of_record = of_record.collect();
        (of_record, speeds.into_iter().map(|(sum, count)| sum / count as f64).collect())
    }

    /// Returns true if every record has a time.
    #[must_use]
    pub fn has_times(&self) -> bool {
        self.records.iter().all(|record| record.time.is_some())
    }

    /// Reads a table; `times` holds `condition, speed, unix_time_of_one_record`, where the table has no column of times. Without both, `times.csv`
    /// beside the table is read where it is there; returns the file of times.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read, or a column or a cell is invalid.
    pub fn read(path: &Path, times: Option<&Path>) -> Result<(Self, Option<PathBuf>), TableError> {
        let text =
            std::fs::read(path).map_err(|source| TableError::File { path: path.to_owned(), source: source.into() })?;
        let table = Self::parse(&text, path, times)?;
        let beside = times.is_none().then(|| path.with_file_name("times.csv"));
        match beside.filter(|beside| !table.has_times() && beside.is_file()) {
            Some(beside) => Ok((Self::parse(&text, path, Some(&beside))?, Some(beside))),
            None => Ok((table, times.map(Path::to_owned))),
        }
    }

    /// Reads a table from its text; `path` names it in errors.
    ///
    /// # Errors
    /// Returns an error if the file of times cannot be read, or a column or a cell is invalid.
    pub fn parse(text: &[u8], path: &Path, times: Option<&Path>) -> Result<Self, TableError> {
        let file = |path: &Path| {
            let path = path.to_owned();
            move |source: csv::Error| TableError::File { path: path.clone(), source }
        };
        // A line that ends with two characters would count the next one as itself.
        let is_part = |(i, byte): &(usize, &u8)| !(**byte == b'\r' && text.get(i + 1) == Some(&b'\n'));
        let plain: Vec<u8> = text.iter().enumerate().filter(is_part).map(|(_, byte)| *byte).collect();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(plain.as_slice());
        let names = reader.headers().map_err(file(path))?.clone();
        let columns = Columns::new(path, &names)?;
        if let Some(times) = times.filter(|_| columns.time.is_some()) {
            return Err(TableError::Records {
                path: times.to_owned(),
                found: format!("times of runs beside the column {TIME} of {}", path.display()),
                expected: "one of them".to_owned(),
            });
        }
        let times = times.map(|of| Ok((of, read_times(of)?))).transpose()?;
        let mut records: Vec<Record> = vec![];
        for cells in reader.records() {
            let cells = cells.map_err(file(path))?;
            let line = Line { path, names: &names, cells: &cells };
            let [id, set, speed] = columns.fixed;
            let name = line.text(id);
            let (condition, rest) = name.split_once("_N").unwrap_or((name, ""));
            if condition.is_empty() {
                return Err(line.error(id, "an identifier such as A007_N1_m1_a1"));
            }
            let set = match line.text(set) {
                "baseline" => Set::Baseline,
                "trial" => Set::Trial,
                "trim" => Set::Trim,
                "blind" => Set::Blind,
                _ => return Err(line.error(set, SETS)),
            };
            let moments = match set {
                Set::Baseline => Some(vec![C::new(0.0, 0.0); columns.planes.len()]),
                Set::Trial | Set::Trim => {
                    Some(columns.planes.iter().map(|(_, pair)| line.moment(*pair)).collect::<Result<Vec<_>, _>>()?)
                }
                Set::Blind => None,
            };
            if set == Set::Baseline {
                for (_, [size, _]) in &columns.planes {
                    if !line.text(*size).is_empty() && line.number(*size, "0 in a baseline")? != 0.0 {
                        return Err(line.error(*size, "0 in a baseline"));
                    }
                }
            }
            let turning = line.number(speed, "a shaft speed above 0")?;
            if turning <= 0.0 {
                return Err(line.error(speed, "a shaft speed above 0"));
            }
            let part = |[re, im]: [usize; 2]| -> Result<C, TableError> {
                Ok(C::new(line.number(re, "a number")?, line.number(im, "a number")?))
            };
            let response = columns.probes.iter().map(|(_, pair)| part(*pair)).collect::<Result<Vec<_>, _>>()?;
            let time = match (columns.time, &times) {
                (Some(column), _) => Some(line.number(column, "a time in seconds")?),
                (None, Some((of, times))) => {
                    let speed = format!("N{}", rest.split('_').next().unwrap_or_default());
                    let time = times.get(&(condition.to_owned(), speed.clone())).copied();
                    let missing = || TableError::Records {
                        path: of.to_path_buf(),
                        found: format!("no time of condition {} at speed {}", printable(condition), printable(&speed)),
                        expected: format!("a time of each condition and speed of {}", path.display()),
                    };
                    Some(time.ok_or_else(missing)?)
                }
                (None, None) => None,
            };
            let before = records.iter().find(|record| record.condition == condition);
            if before.is_some_and(|before| (before.set, &before.moments) != (set, &moments)) {
                return Err(line.error(id, "the set and the masses of the records of this condition before it"));
            }
            records.push(Record { condition: condition.to_owned(), set, speed: turning, moments, response, time });
        }
        if records.is_empty() {
            let (found, expected) = ("no record".to_owned(), "a baseline and trials".to_owned());
            return Err(TableError::Records { path: path.to_owned(), found, expected });
        }
        let of = |named: Vec<(String, [usize; 2])>| named.into_iter().map(|(name, _)| name).collect();
        Ok(Self {
            planes: of(columns.planes),
            probes: of(columns.probes),
            unit: columns.unit,
            records,
            has_run_ups: false,
        })
    }
}

/// Times by condition and name of the speed, s.
type Times = BTreeMap<(String, String), f64>;

fn read_times(path: &Path) -> Result<Times, TableError> {
    const COLUMNS: [&str; 3] = ["condition", "speed", "unix_time_of_one_record"];
    let file = |source| TableError::File { path: path.to_owned(), source };
    let mut reader = csv::Reader::from_path(path).map_err(file)?;
    let names = reader.headers().map_err(file)?.clone();
    let mut at = [0; 3];
    for (at, name) in at.iter_mut().zip(COLUMNS) {
        *at = names.iter().position(|other| other.trim() == name).ok_or_else(|| TableError::Column {
            path: path.to_owned(),
            column: name.to_owned(),
            found: "missing",
            expected: COLUMNS.join(", "),
        })?;
    }
    let mut times = Times::new();
    for cells in reader.records() {
        let cells = cells.map_err(file)?;
        let line = Line { path, names: &names, cells: &cells };
        let key = (line.text(at[0]).to_owned(), line.text(at[1]).to_owned());
        times.insert(key, line.number(at[2], "a time in seconds")?);
    }
    Ok(times)
}
