//! Vibration sensors in live operation: statistics of every second, and the envelope spectra of blocks on a thread of their own,
//! with a bounded share of one core.

use super::background::{Pause, Task, set_priority};
use super::notices::Notices;
use super::running_diagnosis::OpenFaults;
use super::second::{SensorSecond, StatisticsOfSensors};
use ballrace_diagnosis::vibration::signals::{Evaluation, Signals};
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::options::BackgroundSchedule;
use ballrace_outcome::{Diagnosis, FaultKind};
use ballrace_plant::error::Result;
use ballrace_recording::{Row, Sample};
use ballrace_scene::{Recording, Scene};
use std::sync::Arc;

/// Revolutions of a block: 39 spectra of 16 revolutions, half overlapping.
const BLOCK_TURNS: f64 = 320.0;
/// Largest number of readings in a block of all sensors together, which need 32 MiB.
const MAX_READINGS: u64 = 1 << 22;

/// Work of the thread.
enum Work {
    /// A block is filled.
    Filling(Signals),
    /// The thread evaluates a block that ends at a time of the recording, s.
    Evaluating(Task<Result<Evaluation>>, f64),
    /// No block begins before the end of the pause.
    Resting(Pause),
    /// No block begins any more.
    Ended,
}

/// Monitor of the vibration sensors.
pub(super) struct RunningVibration {
    scene: Arc<Scene>,
    recording: Recording,
    baseline: Option<Arc<Baseline>>,
    /// Rate of the recording, Hz.
    rate: f64,
    schedule: BackgroundSchedule,
    /// Index of the last row.
    index: u64,
    seconds: StatisticsOfSensors,
    work: Work,
    /// Faults of the last block, which the next one confirms.
    candidates: Vec<(FaultKind, Option<String>)>,
    faults: OpenFaults,
    last: Evaluation,
}

impl RunningVibration {
    /// Creates the monitor of a recording at `rate`, Hz; none without sensors.
    pub fn new(scene: &Scene, rate: f64, baseline: Option<&Baseline>, schedule: BackgroundSchedule) -> Option<Self> {
        let recording = scene.recording.clone().filter(|recording| !recording.sensors.is_empty())?;
        let sensors = recording.sensors.iter().map(|sensor| (sensor.column.clone(), sensor.unit.clone())).collect();
        Some(Self {
            scene: Arc::new(scene.clone()),
            recording,
            baseline: baseline.cloned().map(Arc::new),
            rate,
            schedule,
            index: 0,
            seconds: StatisticsOfSensors::new(sensors),
            work: Work::Resting(Pause::default()),
            candidates: vec![],
            faults: OpenFaults::default(),
            last: Evaluation::default(),
        })
    }

    /// Adds the readings of a row.
    pub fn add(&mut self, row: &Row, notices: &mut Notices) {
        self.seconds.add(row);
        self.index = row.index;
        match &mut self.work {
            Work::Filling(signals) => {
                let has_room = signals.add(row);
                // A shaft that hardly turns fills no block.
                if !has_room {
                    self.work = Work::Resting(Pause::default());
                }
            }
            Work::Resting(pause) if pause.is_over() => {
                let block = Signals::of_block(&self.recording, self.rate, row.index, MAX_READINGS);
                self.work = block.map_or(Work::Ended, |mut block| {
                    block.add(row);
                    Work::Filling(block)
                });
            }
            _ => self.advance(notices),
        }
    }

    /// Takes the result of an evaluation that has ended, also where the source sends no more.
    pub fn advance(&mut self, notices: &mut Notices) {
        if let Work::Evaluating(task, _) = &self.work
            && task.is_due(self.schedule, self.index)
        {
            self.take_result(notices);
        }
    }

    /// Adds a sample with its shaft angle, and starts the evaluation of a full block.
    pub fn add_angle(&mut self, sample: &Sample, notices: &mut Notices) {
        let Work::Filling(signals) = &mut self.work else { return };
        signals.add_angle(sample);
        if signals.turns() < BLOCK_TURNS {
            return;
        }
        let Work::Filling(signals) = std::mem::replace(&mut self.work, Work::Ended) else { return };
        let (scene, baseline) = (self.scene.clone(), self.baseline.clone());
        let time = sample.row.time;
        let thread = std::thread::Builder::new().name("vibration".to_owned());
        let schedule = self.schedule;
        let evaluate = move || {
            set_priority(schedule);
            signals.evaluate(&scene, baseline.as_deref())
        };
        match thread.spawn(evaluate) {
            Ok(thread) => self.work = Work::Evaluating(Task::new(thread, sample.row.index), time),
            Err(error) => ended(&error.to_string(), time, notices),
        }
    }

    /// Drops the block, because the shaft angle is interrupted.
    pub fn interrupt(&mut self) {
        if matches!(self.work, Work::Filling(_)) {
            self.work = Work::Resting(Pause::default());
        }
    }

    /// Takes the result of the thread.
    fn take_result(&mut self, notices: &mut Notices) {
        let Work::Evaluating(task, time) = std::mem::replace(&mut self.work, Work::Ended) else { return };
        let (result, pause) = task.join(self.schedule);
        let found = match result {
            Ok(Ok(found)) => found,
            Ok(Err(error)) => return ended(&error.to_string(), time, notices),
            Err(_) => return ended("its thread ended", time, notices),
        };
        self.work = Work::Resting(pause);
        match &found.not_judged {
            Some(reason) => notices.add("sensors-not-judged", time, || format!("Sensors: no verdict: {reason}.")),
            None => self.report(&found.diagnoses, time, notices),
        }
        self.last = found;
    }

    /// Reports the faults that two blocks in a row show: one block in many thousands shows a line by chance.
    fn report(&mut self, diagnoses: &[Diagnosis], time: f64, notices: &mut Notices) {
        let fault = |diagnosis: &Diagnosis| (diagnosis.kind, diagnosis.bearing.clone());
        let before = std::mem::replace(&mut self.candidates, diagnoses.iter().map(fault).collect());
        let confirmed = diagnoses.iter().filter(|diagnosis| before.contains(&fault(diagnosis))).cloned().collect();
        self.faults.report(confirmed, time, notices);
    }

    /// Returns the faults of the last blocks.
    pub fn diagnoses(&self) -> Vec<Diagnosis> {
        self.faults.diagnoses()
    }

    /// Continues with the faults of an earlier process.
    pub(crate) fn restore(&mut self, faults: &[Diagnosis]) {
        self.faults = OpenFaults::new(faults);
    }

    /// Returns the statistics of the second that ends at `time_s`.
    pub fn second(&self, time_s: f64) -> Vec<SensorSecond> {
        self.seconds.of(time_s)
    }

    /// Drops the statistics of the seconds up to the one that ends at `time_s`.
    pub(crate) fn drop_seconds(&mut self, time_s: f64) {
        self.seconds.drop_until(time_s);
    }

    /// Returns the faults and the envelope spectra of the last block.
    pub fn conclusion(&mut self) -> Evaluation {
        let mut last = std::mem::take(&mut self.last);
        last.diagnoses = self.diagnoses();
        last.notes.clear();
        last.not_judged = None;
        last
    }
}

/// Reports that the diagnosis of the sensors has ended; their statistics continue.
fn ended(reason: &str, time: f64, notices: &mut Notices) {
    let sentence = format!("The monitor evaluates no envelope spectra any more: {reason}.");
    notices.add_always("sensors-ended", time, sentence);
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace::Phase;
    use ballrace_scene::read::read_str;
    use std::f64::consts::TAU;
    use std::path::Path;

    const SCENE: &str = "[shaft]\nspeed = \"3000 rpm\"\n[[bearing]]\nname = \"DE\"\nstation = \"0 mm\"\nfacing = \"both\"\n\
        model = \"angular\"\nelements = 9\nball_diameter = \"7.94 mm\"\npitch_diameter = \"39.04 mm\"\n\
        inner_conformity = 0.52\nouter_conformity = 0.52\ncontact_angle = \"0 deg\"\n[recording]\nfile = \"r.csv\"\n\
        rate = \"12.8 kHz\"\nsensors = [{ column = \"a\", unit = \"g\" }]\n\
        keyphasor = { column = \"k\", pulses_per_turn = 1 }\n";
    const RATE: f64 = 12_800.0;

    /// Runs blocks of a sensor that rings `order` times a turn until one more is evaluated.
    fn run(vibration: &mut RunningVibration, order: f64, start: u64, notices: &mut Notices) -> u64 {
        let (mut state, mut hit, mut index) = (7_u64, -1.0, start);
        let mut passed = (order * 50.0 * start as f64 / RATE).floor();
        loop {
            let time = index as f64 / RATE;
            if (order * 50.0 * time).floor() > passed {
                (passed, hit) = ((order * 50.0 * time).floor(), time);
            }
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let noise = (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
            let ring = 3.0 * (-900.0 * (time - hit)).exp() * (4100.0 * TAU * (time - hit)).sin();
            let row = Row { index, time, sensors: vec![0.2 * noise + ring], ..Row::default() };
            vibration.add(&row, notices);
            let (revolution, speed) = ((50.0 * time).floor() as i64, 50.0 * TAU);
            let angle = Phase::from_revolutions(50.0 * time);
            vibration.add_angle(&Sample { row, angle, revolution, speed, ..Sample::default() }, notices);
            index += 1;
            if matches!(vibration.work, Work::Evaluating(..)) {
                while matches!(vibration.work, Work::Evaluating(..)) {
                    let row = Row { index, time: index as f64 / RATE, sensors: vec![f64::NAN], ..Row::default() };
                    vibration.add(&row, notices);
                    index += 1;
                }
                return index;
            }
        }
    }

    #[test]
    fn two_blocks_find_a_fault_and_two_end_it() {
        let scene = read_str(SCENE, Path::new("s.toml")).unwrap();
        let mut vibration = RunningVibration::new(&scene, RATE, None, BackgroundSchedule::Samples(100)).unwrap();
        let mut notices = Notices::default();
        let outer = 4.5 * (1.0 - 7.94 / 39.04);
        let index = run(&mut vibration, outer, 1000, &mut notices);
        assert!(notices.take().is_empty() && vibration.diagnoses().is_empty());
        let index = run(&mut vibration, outer, index, &mut notices);
        let found = notices.take();
        assert!(found.len() == 1 && found[0].kind == "fault-found", "{found:?}");
        assert!(found[0].sentence.starts_with("Outer race of DE"), "{found:?}");
        assert_eq!(vibration.conclusion().envelopes.len(), 1);
        let index = run(&mut vibration, 1e-9, index, &mut notices);
        assert!(notices.take().is_empty() && vibration.diagnoses().len() == 1);
        run(&mut vibration, 1e-9, index, &mut notices);
        let found = notices.take();
        assert!(found.len() == 1 && found[0].kind == "fault-ended", "{found:?}");
    }

    #[test]
    fn seconds_of_a_sensor() {
        let scene = read_str(SCENE, Path::new("s.toml")).unwrap();
        let mut vibration = RunningVibration::new(&scene, RATE, None, BackgroundSchedule::Samples(100)).unwrap();
        let mut notices = Notices::default();
        for index in 0..3 * RATE as u64 {
            let time = index as f64 / RATE;
            let reading = if time < 1.0 { 2.0 * (50.0 * TAU * time).sin() } else { f64::NAN };
            vibration.add(&Row { index, time, sensors: vec![reading], ..Row::default() }, &mut notices);
        }
        let [second] = &vibration.second(1.0)[..] else { unreachable!() };
        assert_eq!((second.name.as_str(), second.unit.as_str()), ("a", "g"));
        assert!((second.rms - 2.0_f64.sqrt()).abs() < 1e-6 && (second.peak - 2.0).abs() < 1e-3, "{second:?}");
        assert!((second.kurtosis - 1.5).abs() < 1e-3, "{second:?}");
        assert!(vibration.second(2.0)[0].rms.is_nan());
        vibration.drop_seconds(1.0);
        assert!(vibration.second(1.0)[0].rms.is_nan());
    }
}
