//! Check of a scene and its recording before anything is computed from them: readings, speed, and each implausibility with its
//! probable cause.
//!
//! The recording is read once. The only model used is the static equilibrium, which bounds the readings that the bearings allow.

mod unknown;
mod values;

pub use ballrace_diagnosis::plausibility::{ReadingSummary, VoltageSummary};
pub use ballrace_outcome::Implausibility;
pub use unknown::{UnknownValue, unknown_values};
pub use values::ProbeCentre;

use ballrace_diagnosis::block::Block;
use ballrace_diagnosis::plausibility::range::ReadingRange;
use ballrace_diagnosis::plausibility::{Collector, Evidence, implausible, implausible_scene, of_designations};
use ballrace_models::build::{check_forces, kinematics};
use ballrace_outcome::{ClearanceOutcome, RotorDrawing, RotorOutcome};
use ballrace_plant::error::Result;
use ballrace_plant::{Plant, mounting_notes};
use ballrace_recording::Reader;
use ballrace_recording::clock::check_rate;
use ballrace_recording::flaws::FlawSummary;
use ballrace_recording::rotation::Tracker;
use ballrace_recording::run_out::RunOut;
use ballrace_scene::{Bearing, Clock, RotationSource, Scene};
use serde::Serialize;

/// Largest number of samples between two pulses of a keyphasor.
const LONGEST_WAIT: usize = 1 << 20;

/// Result of a check.
#[derive(Debug, Serialize)]
pub struct Checked {
    /// Name of the scene.
    pub scene: String,
    /// Bearings with their orders.
    pub bearings: Vec<BearingSummary>,
    /// Summary of the recording; `None` without a recording.
    pub recording: Option<RecordingSummary>,
    /// Implausible values with their probable causes.
    pub implausible: Vec<Implausibility>,
    /// Notes on estimated values.
    pub notes: Vec<String>,
    /// The flexible rotor and the error of its reduced model; `None` for another rotor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor: Option<RotorOutcome>,
    /// Drawing of the rotor; `None` without a rotor.
    #[serde(skip)]
    pub drawing: Option<RotorDrawing>,
}

/// Summary of a bearing of the scene.
#[derive(Debug, Serialize)]
pub struct BearingSummary {
    /// Its name.
    pub name: String,
    /// Designation in the catalogue.
    pub designation: Option<String>,
    /// Model.
    pub model: &'static str,
    /// Number of elements.
    pub elements: usize,
    /// Orders per revolution of the shaft: outer race, inner race, cage.
    pub orders: [f64; 3],
    /// Operating clearance; `None` without `fit` and `temperatures`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operating_clearance: Option<ClearanceOutcome>,
}

/// Summary of a recording.
#[derive(Debug, Serialize)]
pub struct RecordingSummary {
    /// Name of the file.
    pub file: String,
    /// Sampling rate.
    pub rate_hz: f64,
    /// Samples read.
    pub samples: u64,
    /// Duration.
    pub seconds: f64,
    /// Least, mean and greatest shaft speed; `None` if no sample has an angle.
    pub speed_rpm: Option<[f64; 3]>,
    /// True where the recording measures the speed.
    pub speed_is_measured: bool,
    /// Readings of each column.
    pub readings: Vec<ReadingSummary>,
    /// Mean of each radial probe beside the clearance; empty without a rotor.
    pub centres: Vec<ProbeCentre>,
    /// Note on the run-out that is subtracted before 1X is computed; `None` without `run_out`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_out: Option<String>,
    /// Source of the shaft angle.
    pub angle_source: String,
    /// Flaws of the recording.
    pub flaws: Vec<FlawSummary>,
}

/// Checks a scene and, if `reader` is given, its recording.
///
/// `file` is the name of the recording. `progress` receives the number of bytes read and the total number of bytes, if known.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter or the recording cannot be read.
pub fn check(
    scene: &Scene,
    reader: Option<Reader>,
    file: &str,
    progress: &dyn Fn(u64, Option<u64>),
) -> Result<Checked> {
    let has_plant = scene.rotor.is_some() && check_forces(scene).is_ok();
    let plant = has_plant.then(|| Plant::try_new(scene)).transpose()?;
    let bearings = scene.bearings.iter().map(|bearing| {
        let orders = kinematics(scene, bearing)?.orders;
        Ok(BearingSummary {
            name: bearing.name.clone(),
            designation: bearing.catalogue.as_ref().map(|used| used.listed.entry.designation.to_owned()),
            model: bearing.model.name(),
            elements: bearing.elements,
            orders: [orders.outer_race, orders.inner_race, orders.cage],
            operating_clearance: bearing.mounting.map(|mounting| mounting.operating().into()),
        })
    });
    let bearings = bearings.collect::<Result<Vec<_>>>()?;
    let (recording, mut implausible) = match reader {
        Some(reader) => {
            let (summary, found) = read(scene, plant.as_ref(), reader, file, progress)?;
            (Some(summary), found)
        }
        None => (None, implausible_scene(scene)),
    };
    implausible.extend(values::of_scene(scene, plant.as_ref())?);
    let rotor = plant.as_ref().and_then(|plant| plant.rotor_outcome(scene));
    let mut notes = plant.map_or_else(|| mounting_notes(scene), |plant| Ok(plant.notes))?;
    notes.extend(scene.bearings.iter().filter_map(without_forces));
    Ok(Checked {
        scene: scene.name.clone(),
        bearings,
        recording,
        implausible,
        rotor,
        notes,
        drawing: RotorDrawing::new(scene),
    })
}

/// States what a bearing without model is for; none with a model.
fn without_forces(bearing: &Bearing) -> Option<String> {
    let missing = bearing.kinematics?.keys_of_forces();
    Some(format!(
        "Bearing {} has no model: vibration sensors are diagnosed with its orders. Forces, equilibrium, simulation and the \
         evaluation of displacement probes need the keys {missing}.",
        bearing.name
    ))
}

fn read(
    scene: &Scene,
    plant: Option<&Plant>,
    mut reader: Reader,
    file: &str,
    progress: &dyn Fn(u64, Option<u64>),
) -> Result<(RecordingSummary, Vec<Implausibility>)> {
    let Some(recording) = &scene.recording else {
        return Err(ballrace_plant::error::ReplayError::NoRecording { file: scene.path.clone() }.into());
    };
    // A rate of the scene is one of the values that are listed.
    if matches!(recording.clock, Clock::Column { .. }) && !recording.probes.is_empty() {
        check_rate(reader.rate(), recording, scene.shaft.speed).map_err(|e| e.of(scene, file))?;
    }
    let mut range = match plant {
        Some(plant) if !recording.probes.is_empty() => Some(ReadingRange::try_new(scene, plant, &recording.probes)?),
        _ => None,
    };
    let rate = reader.rate() / f64::from(recording.average);
    let run_out = RunOut::of(scene)?;
    let tracker = Tracker::of(recording, reader.rate(), scene.shaft.speed).waiting_at_most(LONGEST_WAIT);
    let mut tracker = tracker.with_run_out(run_out.clone());
    let mut collected = Collector::new(recording, scene.shaft.speed);
    let mut block = Block::default();
    let (mut row, mut rows, mut rotation) = (tracker.blank(), 0_u64, Ok(()));
    loop {
        let goes_on = reader.next_row(&mut row)?;
        if !goes_on && rotation.is_ok() {
            rotation = tracker.finish();
        }
        while let Some(sample) = tracker.pop() {
            collected.add_sample(&sample);
            block.add(&sample);
            tracker.recycle(sample.row);
        }
        if !goes_on {
            break;
        }
        rows += 1;
        if rows.is_multiple_of(4096) {
            let (read, total) = reader.progress();
            progress(read, total);
        }
        collected.add_row(&row);
        let mut full = if rotation.is_ok() { std::mem::replace(&mut row, tracker.blank()) } else { row.clone() };
        if let Some(range) = &mut range {
            range.check(&mut full);
        }
        if rotation.is_ok() {
            rotation = tracker.push(full);
        }
    }
    let speed_is_measured = !matches!(recording.rotation, RotationSource::Scene);
    let rotation = rotation.err();
    let samples = block.into_samples();
    let mut found = implausible(&Evidence {
        scene,
        rate_hz: rate,
        collected: &collected,
        limits: range.as_ref().map(ReadingRange::limits),
        rotation: rotation.as_ref(),
        samples: &samples,
    });
    let readings = collected.summary(recording);
    // Readings in another unit also contradict noise and zero of the probes.
    if found.is_empty() {
        found = values::of_readings((scene, recording), plant, &readings);
        found.extend(of_designations(scene, &samples));
    }
    let centres = plant.map_or_else(Vec::new, |plant| values::centres((scene, recording), plant, &readings));
    let summary = RecordingSummary {
        file: file.to_owned(),
        rate_hz: rate,
        samples: rows,
        seconds: rows as f64 / reader.rate(),
        speed_rpm: collected.speeds().rpm(),
        speed_is_measured,
        readings,
        centres,
        run_out: run_out.and_then(|run_out| run_out.notes().first().cloned()),
        angle_source: tracker.source(),
        flaws: reader.flaws().summary(),
    };
    Ok((summary, found))
}
