//! First look at a recording without a scene: its columns, their units and their probable meaning.

use super::error::RecordingError;
use super::format;
use super::table::{Cells, Table};
use ballrace_base::bounded::open_regular;
use ballrace_scene::{FileLayout, units};
use std::path::Path;

/// Number of rows that are read.
const ROWS: usize = 4096;
/// Number of columns that are read one after the other where they cannot be read together.
const SEPARATE: usize = 256;
/// Largest share of rows in which a keyphasor is on its rarer level.
const PULSES: f64 = 0.4;
/// Parts of names of keyphasors.
const KEYPHASORS: [&str; 6] = ["key", "kph", "tach", "trig", "pulse", "once"];
/// Whole words of names of keyphasors, which a number may follow; the parts of longer words mean something else.
const KEYPHASOR_WORDS: [&str; 2] = ["kp", "opr"];
/// Step of the angles at which probes are mounted, deg. Other numbers in names are those of channels or bearings.
const ANGLE_STEP: u16 = 15;
/// Highest order of the differences by which noise is estimated.
const HIGHEST_DIFFERENCE: u32 = 4;
/// Standard deviation of normally distributed values over their median magnitude.
const DEVIATION_PER_MEDIAN: f64 = 1.4826;
/// Least number of values for an estimate of the noise.
const LEAST_VALUES: usize = 64;
/// Units of vibration as columns name them, and as scenes do.
const VIBRATION: [(&str, &str); 8] = [
    ("g", "g"),
    ("m/s^2", "m/s^2"),
    ("m/s2", "m/s^2"),
    ("mps2", "m/s^2"),
    ("mm/s", "mm/s"),
    ("mmps", "mm/s"),
    ("m/s", "m/s"),
    ("v", "V"),
];

/// Least mean of a gap voltage, V, and least ratio of mean and standard deviation: the signal of a vibration sensor has no mean.
const GAP_VOLTAGE: (f64, f64) = (0.5, 3.0);

/// Columns of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// All columns.
    pub columns: Vec<PreviewColumn>,
    /// Sampling rate that the file states, Hz.
    pub rate: Option<f64>,
    /// Names of single numbers, of which one may be the rate.
    pub numbers: Vec<String>,
    /// The file is text without a line of names.
    pub is_headless: bool,
    /// The file was sampled in step with the shaft.
    pub is_synchronous: bool,
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviewColumn {
    /// Name.
    pub name: String,
    /// Probable meaning, by unit, name and values.
    pub role: ColumnRole,
    /// The file states the unit.
    pub has_unit: bool,
    /// Direction in its name, also of a column whose unit is not known.
    pub direction: Option<NamedDirection>,
    /// Estimates from the first rows, in the unit of the column.
    pub level: Option<ColumnLevel>,
}

/// Estimates from the first rows of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColumnLevel {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// Number of rows.
    pub rows: usize,
}

/// Probable meaning of a column. Units are those of the file, or of the end of the column's name.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnRole {
    /// Time of each sample.
    Time,
    /// Pulses of the shaft.
    Keyphasor,
    /// Speed of the shaft in this unit.
    Speed(String),
    /// Displacement in this unit, along this direction where the name of the column has it.
    Displacement(String, Option<NamedDirection>),
    /// Gap voltage of a displacement probe in this unit, along this direction where the name of the column has it.
    GapVoltage(String, Option<NamedDirection>),
    /// Vibration in this unit.
    Vibration(String),
    /// Not known.
    Unknown,
}

/// Direction in the name of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedDirection {
    /// `X` or `H`: horizontal.
    X,
    /// `Y` or `V`: vertical.
    Y,
    /// `Z` or `axial`.
    Axial,
    /// Angle from X towards Y, deg, such as 45 in `DE_45_um`.
    Degrees(u16),
}

/// Reads columns and first rows of a recording in any format.
///
/// # Errors
/// No such file, an unknown format, no header, no row.
pub fn preview(path: &Path) -> Result<Preview, RecordingError> {
    let unopened = |cause| RecordingError::Open { file: path.into(), cause };
    if path.metadata().map_err(unopened)?.is_dir() {
        return Err(RecordingError::NoFile { file: path.into() });
    }
    let open = |layout| Ok::<_, RecordingError>(format::open(open_regular(path).map_err(unopened)?, path, layout)?.0);
    let mut layout = FileLayout::default();
    let mut table = match open(layout) {
        Err(RecordingError::NoHeader { .. }) => {
            layout.is_headless = true;
            open(layout)?
        }
        opened => opened?,
    };
    let is_headless = layout.is_headless;
    let places: Vec<_> = (0..table.columns().len()).collect();
    let mut rates = vec![None; places.len()];
    let values = match table.select(&places) {
        // Columns that do not go together, such as those of different lengths.
        Err(RecordingError::Format { .. }) if places.len() > 1 => {
            let mut values = vec![Vec::new(); places.len()];
            for (place, column) in values.iter_mut().enumerate().take(SEPARATE) {
                table = open(layout)?;
                if table.select(&[place]).is_ok() {
                    *column = first_rows(table.as_mut(), 1)?.pop().unwrap_or_default();
                    rates.get_mut(place).into_iter().for_each(|rate| *rate = table.rate());
                }
            }
            values
        }
        selected => {
            selected?;
            rates.fill(table.rate());
            first_rows(table.as_mut(), places.len())?
        }
    };
    if values.iter().all(Vec::is_empty) {
        return Err(RecordingError::NoRows { file: path.into() });
    }
    let column = |(place, values): (usize, &Vec<f64>)| {
        let name = table.columns().get(place).cloned().unwrap_or_default();
        let role = role(&name, table.unit(place), values);
        let has_unit = table.unit(place).is_some();
        let (direction, level) = (direction(&words(&name)), level(values));
        PreviewColumn { name, role, has_unit, direction, level }
    };
    let columns: Vec<PreviewColumn> = values.iter().enumerate().map(column).collect();
    let is_synchronous = table.samples_per_revolution().is_some();
    let (rate, numbers) = (common_rate(&columns, &rates), table.scalar_names());
    Ok(Preview { columns, rate, numbers, is_headless, is_synchronous })
}

/// Returns the rate of the columns of probes and sensors, or of all where there are none; none where rates differ or one is absent.
fn common_rate(columns: &[PreviewColumn], rates: &[Option<f64>]) -> Option<f64> {
    let is_measured = |column: &PreviewColumn| {
        use ColumnRole::{Displacement, GapVoltage, Vibration};
        matches!(column.role, Displacement(..) | GapVoltage(..) | Vibration(_))
    };
    let of = |all: bool| columns.iter().zip(rates).filter(move |(column, _)| all || is_measured(column));
    let mut own = of(of(false).next().is_none()).map(|(_, rate)| *rate);
    let first = own.next()??;
    own.all(|rate| rate.is_some_and(|rate| (rate / first - 1.0).abs() < 1e-9)).then_some(first)
}

/// Returns mean and noise of the values that are numbers. The noise is the smallest of the estimates by the differences of
/// first to fourth order, of which each has the noise and a part of the motion, and at least that of the smallest step.
fn level(values: &[f64]) -> Option<ColumnLevel> {
    let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if known.len() < LEAST_VALUES {
        return None;
    }
    let rows = known.len();
    let mean = known.iter().sum::<f64>() / rows as f64;
    let (mut differences, mut square, mut noise, mut step) = (known, 1.0, f64::INFINITY, f64::INFINITY);
    for order in 1..=HIGHEST_DIFFERENCE {
        differences = differences.windows(2).filter_map(|pair| Some(pair.last()? - pair.first()?)).collect();
        // The sum of the squares of the binomial coefficients of this order.
        square *= f64::from(2 * (2 * order - 1)) / f64::from(order);
        let mut sizes: Vec<f64> = differences.iter().map(|difference| difference.abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        if order == 1 {
            step = sizes.iter().copied().find(|size| *size > 1e-9 * mean.abs()).unwrap_or(0.0);
        }
        let median = sizes.get(sizes.len() / 2).copied()?;
        noise = f64::min(noise, DEVIATION_PER_MEDIAN * median / square.sqrt());
    }
    Some(ColumnLevel { mean, noise: noise.max(step / 12.0_f64.sqrt()), rows })
}

/// Returns the first rows of the selected columns.
fn first_rows(table: &mut dyn Table, count: usize) -> Result<Vec<Vec<f64>>, RecordingError> {
    let mut values = vec![Vec::new(); count];
    let mut cells = Cells::default();
    while values.first().is_some_and(|column| column.len() < ROWS) && table.next(&mut cells)? {
        for (column, value) in values.iter_mut().zip(&cells.values) {
            column.push(*value);
        }
    }
    Ok(values)
}

/// Returns the words of a name in small letters.
fn words(name: &str) -> Vec<String> {
    name.split(|c: char| !(c.is_alphanumeric() || "/^".contains(c))).map(str::to_ascii_lowercase).collect()
}

fn is_keyphasor_word(word: &str) -> bool {
    KEYPHASOR_WORDS.contains(&word.trim_end_matches(|c: char| c.is_ascii_digit()))
}

fn role(name: &str, unit: Option<&str>, values: &[f64]) -> ColumnRole {
    let words = words(name);
    let has = |word: &str| words.iter().any(|own| own == word);
    let is_rising = values.windows(2).all(|pair| matches!(pair, [a, b] if a < b));
    if (has("time") || has("t")) && is_rising {
        return ColumnRole::Time;
    }
    let lower = name.to_ascii_lowercase();
    let is_named =
        KEYPHASORS.iter().any(|part| lower.contains(part)) || words.iter().any(|word| is_keyphasor_word(word));
    if is_named || is_pulse(values) {
        return ColumnRole::Keyphasor;
    }
    let last = words.iter().rev().find(|word| !word.is_empty()).cloned();
    let Some(unit) = unit.map(str::to_owned).or(last) else { return ColumnRole::Unknown };
    if units::length_column(&unit).is_ok() {
        return ColumnRole::Displacement(unit, direction(&words));
    }
    if units::speed_column(&unit).is_ok() {
        return ColumnRole::Speed(unit);
    }
    if let Ok(volts) = voltage(&unit)
        && is_gap(values, volts)
    {
        return ColumnRole::GapVoltage(if volts == 1.0 { "V" } else { "mV" }.to_owned(), direction(&words));
    }
    let vibration = VIBRATION.iter().find(|(name, _)| unit.eq_ignore_ascii_case(name));
    vibration.map_or(ColumnRole::Unknown, |(_, unit)| ColumnRole::Vibration((*unit).to_owned()))
}

/// Returns the volts per unit of a column; in names of columns the letters may be small.
fn voltage(unit: &str) -> Result<f64, units::Mismatch> {
    match unit {
        "v" => Ok(1.0),
        "mv" => Ok(1e-3),
        other => units::voltage_column(other),
    }
}

/// Returns true for a voltage about a mean that is not 0.
fn is_gap(values: &[f64], volts: f64) -> bool {
    let known = || values.iter().filter(|value| value.is_finite()).map(|value| value * volts);
    let count = known().count().max(1) as f64;
    let mean = known().sum::<f64>() / count;
    let deviation = (known().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
    let (least, ratio) = GAP_VOLTAGE;
    mean.abs() > least && mean.abs() > ratio * deviation
}

/// Returns true for two levels, one of which is rare.
fn is_pulse(values: &[f64]) -> bool {
    let Some(&first) = values.first() else { return false };
    let others: Vec<f64> = values.iter().copied().filter(|value| *value != first).collect();
    let share = others.len() as f64 / values.len() as f64;
    others.windows(2).all(|pair| matches!(pair, [a, b] if a == b))
        && others.len() > 1
        && !(PULSES..=1.0 - PULSES).contains(&share)
}

/// Returns the direction in the words of a name: a letter, or one angle.
fn direction(words: &[String]) -> Option<NamedDirection> {
    let letter = words.iter().find_map(|word| match word.as_str() {
        "x" | "h" | "horizontal" => Some(NamedDirection::X),
        "y" | "v" | "vertical" => Some(NamedDirection::Y),
        "z" | "axial" | "ax" => Some(NamedDirection::Axial),
        _ => None,
    });
    let mut angles = words.iter().filter_map(|word| angle(word));
    match (letter, angles.next(), angles.next()) {
        (None, Some(angle), None) => Some(NamedDirection::Degrees(angle)),
        (letter, ..) => letter,
    }
}

/// Returns the angle of a word such as `45` or `112deg`, deg.
fn angle(word: &str) -> Option<u16> {
    let digits = word.strip_suffix("deg").or_else(|| word.strip_suffix('\u{b0}'));
    let number: u16 = digits.unwrap_or(word).parse().ok().filter(|angle| *angle < 360)?;
    let is_mounting = word.len() >= 2 && number.is_multiple_of(ANGLE_STEP);
    (digits.is_some() || is_mounting).then_some(number)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn meaning_of_columns() {
        let pulse: Vec<f64> = (0..512).map(|i| f64::from(u8::from(i % 256 < 4))).collect();
        let wave: Vec<f64> = (0..512).map(|i| f64::from(i).sin()).collect();
        let rising: Vec<f64> = (0..512).map(f64::from).collect();
        let gap: Vec<f64> = wave.iter().map(|value| value - 9.5).collect();
        let volts = |unit: &str, direction| ColumnRole::GapVoltage(unit.to_owned(), direction);
        let um = |direction| ColumnRole::Displacement("um".to_owned(), direction);
        let cases = [
            ("DE_X_um", None, &wave, um(Some(NamedDirection::X))),
            ("NDE Y [um]", None, &wave, um(Some(NamedDirection::Y))),
            ("axial_um", None, &wave, um(Some(NamedDirection::Axial))),
            ("gap", Some("um"), &wave, um(None)),
            ("DE_X_V", None, &gap, volts("V", Some(NamedDirection::X))),
            ("gap", Some("mV"), &wave.iter().map(|value| 10.0 * value - 950.0).collect(), volts("mV", None)),
            ("DE_X_V", None, &wave, ColumnRole::Vibration("V".to_owned())),
            ("time_s", None, &rising, ColumnRole::Time),
            ("time_s", None, &wave, ColumnRole::Unknown),
            ("keyphasor", None, &wave, ColumnRole::Keyphasor),
            ("channel 4", None, &pulse, ColumnRole::Keyphasor),
            ("shaft_rpm", None, &wave, ColumnRole::Speed("rpm".to_owned())),
            ("acceleration (m/s^2)", None, &wave, ColumnRole::Vibration("m/s^2".to_owned())),
            ("DE_time", None, &wave, ColumnRole::Unknown),
            ("KP_V", None, &gap, ColumnRole::Keyphasor),
            ("kp1", Some("V"), &gap, ColumnRole::Keyphasor),
            ("pump_kpa", None, &wave, ColumnRole::Unknown),
            ("DE_45_um", None, &wave, um(Some(NamedDirection::Degrees(45)))),
            ("NDE 135deg [um]", None, &wave, um(Some(NamedDirection::Degrees(135)))),
            ("B2 112deg um", None, &wave, um(Some(NamedDirection::Degrees(112)))),
            ("channel_3_um", None, &wave, um(None)),
            ("brg_12_um", None, &wave, um(None)),
            ("30_45_um", None, &wave, um(None)),
        ];
        for (name, unit, values, expected) in cases {
            assert_eq!(role(name, unit, values), expected, "{name}");
        }
    }

    #[test]
    fn noise_and_mean() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut noise = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        for (turn, resolution) in [(0.02, 1e-3), (0.2, 0.01), (0.02, 0.1)] {
            let values: Vec<f64> = (0..4096_u16)
                .map(|i| 5.0 + (f64::from(i) * turn).sin() + 0.05 * noise())
                .map(|value| (value / resolution).round() * resolution)
                .collect();
            let found = level(&values).unwrap();
            assert!((found.noise / 0.05 - 1.0).abs() < 0.3, "{turn} {resolution}: {found:?}");
            assert!((found.mean - 5.0).abs() < 0.1, "{found:?}");
        }
        assert_eq!(level(&[1.0; 10]), None);
    }

    #[test]
    fn columns_of_the_demonstration() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/healthy.csv");
        let found = preview(&path).unwrap();
        assert_eq!(found.columns.len(), 7);
        assert_eq!(found.columns[6].role, ColumnRole::Keyphasor);
        assert!(
            matches!(&found.columns[1].role, ColumnRole::Displacement(unit, Some(NamedDirection::X)) if unit == "um")
        );
    }

    #[test]
    fn columns_of_every_format() {
        let folder = tempfile::tempdir().unwrap();
        let cases: [(&[u8], usize, Option<f64>); 9] = [
            (include_bytes!("mat/structures-packed.mat"), 10, None),
            (include_bytes!("hdf5/earliest.h5"), 12, None),
            (include_bytes!("hdf5/matlab.mat"), 11, None),
            (include_bytes!("npz/stored.npz"), 6, None),
            (include_bytes!("npz/packed.npz"), 6, None),
            (include_bytes!("uff/text.uff"), 3, Some(1000.0)),
            (include_bytes!("uff/binary.uff"), 3, Some(1000.0)),
            (b"0.5 2\n1.5 3\n", 2, None),
            (b"t;x_um\n0,5;2\n1,5;3\n", 2, None),
        ];
        for (place, (bytes, columns, rate)) in cases.into_iter().enumerate() {
            let path = folder.path().join("r.bin");
            std::fs::write(&path, bytes).unwrap();
            let found = preview(&path).unwrap();
            assert_eq!((found.columns.len(), found.rate.map(f64::round)), (columns, rate), "{place}");
        }
        let path = folder.path().join("r.uff");
        std::fs::write(&path, include_bytes!("uff/text.uff")).unwrap();
        let roles: Vec<_> = preview(&path).unwrap().columns.into_iter().map(|column| column.role).collect();
        assert!(matches!(&roles[0], ColumnRole::Displacement(unit, _) if unit == "um"), "{roles:?}");
    }
}
