//! Flaws of a recording that do not stop its reading: counts, positions, messages.

use serde::Serialize;

/// Number of positions that the ledger stores for each kind and column: the first ones.
const PLACES: usize = 5;

/// Kind of flaw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Flaw {
    /// A cell is NaN or empty. The sample has no reading there.
    MissingValue,
    /// A row has fewer cells than the header has names. Absent cells are missing readings.
    ShortRow,
    /// A row repeats the time stamp of an earlier one. The row is omitted.
    RepeatedTimeStamp,
    /// A time stamp is before that of an earlier row. The row is omitted.
    BackwardTimeStamp,
    /// A single time stamp is too late while the next row continues regularly. The row is kept as the next sample.
    StrayTimeStamp,
    /// Samples are missing in the file.
    Gap,
    /// The bytes between two frames are no frame, or one with a wrong checksum. They are omitted.
    DamagedFrame,
    /// A probe repeats one reading. The sample has no reading there once the probe is known to be stuck.
    StuckProbe,
    /// Many samples are exactly at the highest or lowest reading. The readings are kept.
    ClippedProbe,
    /// A keyphasor pulse is missing. It is interpolated; the count of samples is one of pulses.
    MissedPulse,
    /// A keyphasor pulse is spurious. It is omitted.
    SpuriousPulse,
    /// A pulse of a toothed wheel is where its gap is expected. The next gap is angle 0 again.
    ToothInGap,
    /// There is no keyphasor pulse up to the end. The angle is extrapolated and nothing is compared there.
    DeadKeyphasor,
    /// A speed is too high for the scene's machine. The speed before it is held.
    ImplausibleSpeed,
    /// A reading is outside the range that the bearings allow. Observer and force do not use it.
    ReadingOutOfRange,
}

impl Flaw {
    /// Returns true for a kind of which consecutive samples are one occurrence.
    const fn joins_neighbours(self) -> bool {
        matches!(self, Self::MissingValue | Self::ImplausibleSpeed | Self::ReadingOutOfRange)
    }
}

/// Position in the recording.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Position {
    /// Sample, counted from 0 in samples of the nominal rate.
    pub index: u64,
    /// Line of the file.
    pub line: u64,
    /// s
    #[serde(rename = "time_s")]
    pub time: f64,
}

impl From<&super::Row> for Position {
    fn from(row: &super::Row) -> Self {
        Self { index: row.index, line: row.line, time: row.time }
    }
}

/// One occurrence of a flaw.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Occurrence {
    /// Its first sample.
    #[serde(flatten)]
    pub at: Position,
    /// Number of samples.
    pub samples: u64,
    /// The reading that a probe is stuck or clipped at, m.
    #[serde(rename = "reading_m", skip_serializing_if = "Option::is_none")]
    pub reading: Option<f64>,
}

/// All flaws of one kind in one column.
#[derive(Debug, Clone, PartialEq)]
struct Entry {
    flaw: Flaw,
    column: Option<String>,
    count: u64,
    samples: u64,
    /// First sample after the last occurrence.
    end: u64,
    first: Vec<Occurrence>,
}

/// Flaws of a recording: counts, and the first few positions of each kind and column. Its size does not grow with the
/// recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FlawLedger {
    entries: Vec<Entry>,
}

/// Summary of one kind of flaw in one column.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FlawSummary {
    /// Kind.
    pub kind: Flaw,
    /// Column, where the flaw belongs to one.
    pub column: Option<String>,
    /// Number of occurrences; consecutive missing values are one.
    pub count: u64,
    /// Number of samples.
    pub samples_affected: u64,
    /// Line of the first.
    pub first_line: u64,
    /// Time of the first, s.
    pub first_time_s: f64,
    /// The first occurrences.
    pub places: Vec<Occurrence>,
    /// Summary as a sentence.
    pub sentence: String,
}

impl FlawLedger {
    /// Adds one occurrence of `samples` samples. A missing value right after another one extends that occurrence.
    pub fn record(&mut self, flaw: Flaw, column: Option<&str>, at: Position, samples: u64) {
        self.enter(flaw, column, Occurrence { at, samples, reading: None });
    }

    /// Adds an occurrence as [`record`](Self::record), with the reading (m) at which the probe is stuck or clipped.
    pub fn record_reading(&mut self, flaw: Flaw, column: &str, at: Position, samples: u64, reading: f64) {
        self.enter(flaw, Some(column), Occurrence { at, samples, reading: Some(reading) });
    }

    /// Extends the last occurrence by one sample, where there is one.
    pub(crate) fn lengthen(&mut self, flaw: Flaw, column: Option<&str>) {
        if let Some(entry) = self.find(flaw, column) {
            entry.lengthen(1);
        }
    }

    /// Returns true where there is no flaw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns the number of occurrences of a kind, over all columns.
    #[must_use]
    pub fn count(&self, flaw: Flaw) -> u64 {
        self.entries.iter().filter(|entry| entry.flaw == flaw).map(|entry| entry.count).sum()
    }

    /// Returns the summary of each kind and column, in the order of their first occurrences.
    #[must_use]
    pub fn summary(&self) -> Vec<FlawSummary> {
        self.entries.iter().filter_map(Entry::summary).collect()
    }

    fn find(&mut self, flaw: Flaw, column: Option<&str>) -> Option<&mut Entry> {
        self.entries.iter_mut().find(|entry| entry.flaw == flaw && entry.column.as_deref() == column)
    }

    fn enter(&mut self, flaw: Flaw, column: Option<&str>, occurrence: Occurrence) {
        match self.find(flaw, column) {
            Some(entry) if flaw.joins_neighbours() && entry.end == occurrence.at.index => {
                entry.lengthen(occurrence.samples);
            }
            Some(entry) => entry.add(occurrence),
            None => {
                let column = column.map(str::to_owned);
                let mut entry = Entry { flaw, column, count: 0, samples: 0, end: 0, first: Vec::with_capacity(1) };
                entry.add(occurrence);
                self.entries.push(entry);
            }
        }
    }
}

impl Entry {
    fn add(&mut self, occurrence: Occurrence) {
        self.count += 1;
        self.samples += occurrence.samples;
        self.end = occurrence.at.index + occurrence.samples;
        if self.first.len() < PLACES {
            self.first.push(occurrence);
        }
    }

    fn lengthen(&mut self, samples: u64) {
        self.samples += samples;
        self.end += samples;
        // The last occurrence is among those kept only while all are kept.
        if self.count == self.first.len() as u64
            && let Some(last) = self.first.last_mut()
        {
            last.samples += samples;
        }
    }

    fn summary(&self) -> Option<FlawSummary> {
        let first = self.first.first()?;
        Some(FlawSummary {
            kind: self.flaw,
            column: self.column.clone(),
            count: self.count,
            samples_affected: self.samples,
            first_line: first.at.line,
            first_time_s: first.at.time,
            places: self.first.clone(),
            sentence: self.sentence(first),
        })
    }

    fn sentence(&self, first: &Occurrence) -> String {
        let (count, samples) = (self.count, counted(self.samples, "sample"));
        let from = if count > 1 { "first at" } else { "at" };
        let place = format!("{from} line {} ({:.6} s)", first.at.line, first.at.time);
        let description = match self.flaw {
            Flaw::MissingValue => format!("no value in {samples}{}, {place}", places(count)),
            Flaw::ShortRow => {
                format!(
                    "{} truncated, {place}: the cells that are missing count as missing values",
                    counted(count, "row")
                )
            }
            Flaw::RepeatedTimeStamp => {
                format!("{} omitted for a repeated time stamp, {place}", counted(count, "row"))
            }
            Flaw::BackwardTimeStamp => {
                format!("{} omitted for a time stamp that goes back, {place}", counted(count, "row"))
            }
            Flaw::StrayTimeStamp => {
                format!("{} out of line, {place}: the row is kept in its place", counted(count, "time stamp"))
            }
            Flaw::Gap => format!("{samples} missing in {}, {place}", counted(count, "gap")),
            Flaw::DamagedFrame => format!("{} omitted, {place}", counted(self.samples, "damaged frame")),
            Flaw::StuckProbe => self.stuck(first, &samples),
            Flaw::ClippedProbe => format!("clipped{} in {samples}, {place}", at_reading(first)),
            Flaw::MissedPulse => {
                format!("{} missing and filled in{}, {place}", counted(self.samples, "pulse"), places(count))
            }
            Flaw::SpuriousPulse => format!("{} spurious and omitted, {place}", counted(count, "pulse")),
            Flaw::ToothInGap => {
                format!(
                    "a pulse in the gap of the toothed wheel{}, {place}: the angle is 0 again at the next gap",
                    places(count)
                )
            }
            Flaw::DeadKeyphasor => {
                format!("no pulse in the last {samples}, {place}: the shaft angle there is not measured")
            }
            Flaw::ImplausibleSpeed => {
                format!("speed out of range in {samples}{}, {place}: the speed before it is held", places(count))
            }
            Flaw::ReadingOutOfRange => {
                format!("reading{} out of range in {samples}{}, {place}", at_reading(first), places(count))
            }
        };
        self.column.as_ref().map_or_else(|| description.clone(), |column| format!("{column}: {description}"))
    }

    fn stuck(&self, first: &Occurrence, samples: &str) -> String {
        let run = counted(first.samples, "sample");
        let episode = format!("{} from line {} for {run}", at_reading(first), first.at.line);
        match self.count {
            1 => format!("stuck{episode}"),
            count => format!("stuck {count} times, {samples} in all, first{episode}"),
        }
    }
}

fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn places(count: u64) -> String {
    if count > 1 { format!(" in {count} places") } else { String::new() }
}

/// Returns text such as ` at 0.105 um`; micrometres because a probe's reading is of that order in any unit.
fn at_reading(occurrence: &Occurrence) -> String {
    // Six digits: the conversion to metres and back leaves rounding in the last of the seventeen.
    let rounded = |reading: f64| format!("{:.5e}", reading * 1e6).parse::<f64>().ok();
    occurrence.reading.and_then(rounded).map_or_else(String::new, |reading| format!(" at {reading} um"))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn at(index: u64) -> Position {
        Position { index, line: index + 2, time: index as f64 / 1000.0 }
    }

    #[test]
    fn neighbours_are_one_occurrence() {
        let mut ledger = FlawLedger::default();
        assert!(ledger.is_empty());
        for index in [3, 4, 5, 9] {
            ledger.record(Flaw::MissingValue, Some("A"), at(index), 1);
        }
        ledger.record(Flaw::MissingValue, Some("B"), at(6), 1);
        let summary = ledger.summary();
        assert_eq!((summary[0].count, summary[0].samples_affected), (2, 4));
        assert_eq!(summary[0].places[0].samples, 3);
        assert_eq!(summary[0].sentence, "A: no value in 4 samples in 2 places, first at line 5 (0.003000 s)");
        assert_eq!(summary[1].sentence, "B: no value in 1 sample, at line 8 (0.006000 s)");
    }

    #[test]
    fn memory_is_bounded_and_nothing_is_lost() {
        let mut ledger = FlawLedger::default();
        for index in 0..10_000 {
            ledger.record(Flaw::Gap, None, at(index * 3), 2);
            ledger.lengthen(Flaw::Gap, None);
        }
        let summary = ledger.summary();
        assert_eq!(summary.len(), 1);
        assert_eq!(summary[0].places.len(), PLACES);
        assert_eq!((summary[0].count, summary[0].samples_affected), (10_000, 30_000));
        assert!(summary[0].places.iter().all(|place| place.samples == 3));
    }

    #[test]
    fn stuck_probe_in_words() {
        let mut ledger = FlawLedger::default();
        ledger.record_reading(Flaw::StuckProbe, "DE_Y_um", at(810), 2999, 0.105e-6);
        ledger.lengthen(Flaw::StuckProbe, Some("DE_Y_um"));
        assert_eq!(ledger.summary()[0].sentence, "DE_Y_um: stuck at 0.105 um from line 812 for 3000 samples");
    }

    #[test]
    fn kinds_are_snake_case() {
        let mut ledger = FlawLedger::default();
        ledger.record(Flaw::RepeatedTimeStamp, Some("t"), at(1), 1);
        let json = serde_json::to_string(&ledger.summary()).unwrap();
        assert!(json.contains("\"kind\":\"repeated_time_stamp\""), "{json}");
        assert!(json.contains("\"time_s\":0.001"), "{json}");
    }
}
