//! Once-per-turn vectors of recordings, for balancing: the 1X vectors of the trend, block by block, as a table of vectors.
//!
//! A mass at the angle `a` from the keyphasor mark, in the direction of positive rotation, pushes the shaft at the angle `a + theta` where
//! the shaft has turned by `theta` since the mark passed. A reading is `c cos(theta) + s sin(theta)`; its vector is `c - i s`, whose angle grows
//! with that of the mass. A run-out of the scene is subtracted before.

mod speeds;

use super::trend::Trend;
use ballrace_outcome::Block;
use ballrace_plant::error::{Error, Result, VectorError};
use ballrace_recording::Reader;
use ballrace_recording::clock::check_rate;
use ballrace_recording::rotation::Tracker;
use ballrace_recording::run_out::RunOut;
use ballrace_recording::status::SampleStatus;
use ballrace_scene::{Recording, RotationSource, Scene};
use ballrace_studies::balance::table::{C, Record, Set, VectorTable};
use ballrace_studies::balance::{MassesError, Plane, masses, radial_probes};
use speeds::{Passed, common};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Unit of the vectors.
const UNIT: &str = "um";

/// A recording of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedRun {
    /// File.
    pub file: PathBuf,
    /// Baseline, trial or trim run.
    pub set: Set,
    /// Masses added to planes, g mm; none in a baseline.
    pub masses: Vec<(Plane, C)>,
}

/// Runs of a machine and the planes of its correction.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedRuns {
    /// Planes: those that were given, else of the trials, else of the scene.
    pub planes: Vec<Plane>,
    /// Runs.
    pub runs: Vec<RecordedRun>,
}

impl RecordedRuns {
    /// Returns the runs without masses, those with trial masses and those with masses that stay mounted, both by their text (see [`masses`]);
    /// `planes` are bearings or stations.
    ///
    /// # Errors
    /// Returns an error for a wrong text, a mass in another plane than the given ones, or a file that stands twice.
    pub fn new<'a>(
        scene: &Scene,
        without: &[PathBuf],
        [trials, trims]: [&'a [(PathBuf, String)]; 2],
        planes: &[String],
    ) -> Result<Self, MassesError> {
        let mut of = Self { planes: vec![], runs: vec![] };
        for plane in planes {
            of.add_plane(&Plane::named(scene, plane)?);
        }
        let each = |(set, runs): (Set, &'a [(PathBuf, String)])| runs.iter().map(move |run| (set, run));
        let are_given = !planes.is_empty();
        of.runs.extend(without.iter().map(|file| RecordedRun {
            file: file.clone(),
            set: Set::Baseline,
            masses: vec![],
        }));
        for (set, (file, text)) in [(Set::Trial, trials), (Set::Trim, trims)].into_iter().flat_map(each) {
            let masses = masses(scene, text)?;
            for (plane, _) in &masses {
                if are_given && !of.planes.iter().any(|other| other.is_same(plane)) {
                    let names: Vec<&str> = of.planes.iter().map(|plane| plane.name.as_str()).collect();
                    return Err(MassesError {
                        found: format!("{text:?}: mass in plane {}", plane.name),
                        expected: format!("one of the planes {}", names.join(", ")),
                    });
                }
                of.add_plane(plane);
            }
            of.runs.push(RecordedRun { file: file.clone(), set, masses });
        }
        let is_repeated = |i: &usize| of.runs.iter().take(*i).any(|run| run.file == of.runs[*i].file);
        if let Some(i) = (0..of.runs.len()).find(is_repeated) {
            let found = format!("{} stands twice", of.runs[i].file.display());
            return Err(MassesError { found, expected: "a recording of its own for each run".to_owned() });
        }
        if of.planes.is_empty() {
            of.planes = Plane::of_scene(scene);
        }
        Ok(of)
    }

    fn add_plane(&mut self, plane: &Plane) {
        if !self.planes.iter().any(|other| other.is_same(plane)) {
            self.planes.push(plane.clone());
        }
    }
}

/// Returns true where the angle 0 of each recording is the same mark on the shaft.
fn has_mark(recording: &Recording) -> bool {
    match &recording.rotation {
        RotationSource::Keyphasor { pulses_per_turn, missing, .. } => *pulses_per_turn == 1 || *missing > 0,
        RotationSource::Synchronous => true,
        RotationSource::SpeedColumn { .. } | RotationSource::Scene => false,
    }
}

/// Reads recordings of a scene as a table of vectors of its radial probes, a condition for each file: a record for each block of turns, and of
/// a run-up for each speed that it passes.
///
/// # Errors
/// Returns an error for a scene without probes and a mark on the shaft, a recording that cannot be read, is too short or changes its speed too
/// fast, and for a trial at another speed than the runs without masses.
pub fn vector_table(scene: &Scene, of: &RecordedRuns) -> Result<VectorTable> {
    let RecordedRuns { planes, runs } = of;
    let file = || scene.path.clone();
    let Some(recording) = &scene.recording else { return Err(VectorError::NoRecording { file: file() }.into()) };
    let probes: Vec<usize> = radial_probes(recording).map(|(i, _)| i).collect();
    if probes.is_empty() {
        return Err(VectorError::NoProbe { file: file() }.into());
    }
    if !has_mark(recording) {
        return Err(VectorError::NoMark { file: file() }.into());
    }
    let run_out = RunOut::of(scene)?;
    let passed = |run: &RecordedRun| -> Result<Passed> {
        Ok(Passed::new(&run.file, blocks(scene, recording, &run.file, run_out.clone())?)?)
    };
    let all = runs.iter().map(passed).collect::<Result<Vec<Passed>>>()?;
    let speeds = common(&all)?;
    let mut records: Vec<Record> = vec![];
    for (run, passed) in runs.iter().zip(&all) {
        let moment =
            |plane: &Plane| run.masses.iter().filter(|(of, _)| of.is_same(plane)).map(|(_, moment)| moment).sum();
        let moments: Vec<C> = planes.iter().map(moment).collect();
        records.extend(passed.vectors(&probes, &speeds).into_iter().map(|(speed, response)| Record {
            condition: run.file.display().to_string(),
            set: run.set,
            speed,
            moments: Some(moments.clone()),
            response,
            time: None,
        }));
    }
    let names = probes.iter().filter_map(|&i| recording.probes.get(i)).map(|probe| probe.column.clone());
    let table = VectorTable {
        planes: planes.iter().map(|plane| plane.name.clone()).collect(),
        probes: names.collect(),
        unit: UNIT.to_owned(),
        records,
        has_run_ups: !speeds.is_empty(),
    };
    check_speeds(&table)?;
    Ok(table)
}

/// Checks that each speed has a run without masses.
fn check_speeds(table: &VectorTable) -> Result<()> {
    let (of_record, speeds) = table.speeds();
    let numbered = || table.records.iter().zip(&of_record);
    let has_baseline = |speed: usize| numbered().any(|(record, of)| *of == speed && record.set == Set::Baseline);
    match numbered().find(|(_, speed)| !has_baseline(**speed)) {
        None => Ok(()),
        Some((record, speed)) => Err(VectorError::OtherSpeed {
            file: record.condition.clone().into(),
            found: speeds[*speed],
            expected: (0..speeds.len()).filter(|speed| has_baseline(*speed)).map(|speed| speeds[speed]).collect(),
        }
        .into()),
    }
}

/// Returns the blocks of a recording with a reading of every probe.
fn blocks(scene: &Scene, recording: &Recording, file: &Path, run_out: Option<Arc<RunOut>>) -> Result<Vec<Block>> {
    let mut reader = Reader::open(file, recording)?;
    check_rate(reader.rate(), recording, scene.shaft.speed).map_err(|e| e.of(scene, &file.display().to_string()))?;
    let mut tracker = Tracker::of(recording, reader.rate(), scene.shaft.speed).with_run_out(run_out);
    let mut trend = Trend::new(recording.probes.len(), vec![]);
    // The trend has room for the readings of a twin; here is none.
    let none = vec![f64::NAN; recording.probes.len()];
    let mut last: Option<f64> = None;
    let mut goes_on = true;
    while goes_on {
        let mut row = tracker.blank();
        goes_on = reader.next_row(&mut row)?;
        let pushed = if goes_on { tracker.push(row) } else { tracker.finish() };
        pushed.map_err(Error::in_file(file))?;
        while let Some(sample) = tracker.pop() {
            let turned = sample.total_revolutions();
            let revolutions = last.map_or(0.0, |last| turned - last);
            last = Some(turned);
            if !sample.status.has(SampleStatus::ANGLE_NOT_MEASURED) {
                trend.add(&sample, &none, revolutions);
            }
        }
    }
    Ok(trend.finish())
}
