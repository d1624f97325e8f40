//! Indicators of every second, for live operation.

use super::force::EvaluatedForce;
use ballrace::Exact;
use ballrace::twin::{BlockStatistics, Statistics};
use ballrace_outcome::{NumericField, UNIT_OF_SENSOR, phase_lag_deg};
use ballrace_recording::status::SampleStatus;
use ballrace_recording::{Row, Sample};
use serde::Serialize;
use std::collections::VecDeque;
use std::f64::consts::TAU;

const UM: f64 = 1e6;

/// Indicators of one second.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Second {
    /// End of the second in the recording's time.
    pub time_s: f64,
    /// Index of the first sample after it.
    #[serde(skip)]
    pub next_index: u64,
    /// Number of samples with a reading of every probe.
    pub samples: u64,
    /// Mean speed.
    pub speed_rpm: f64,
    /// Mean of the observer's normalised innovation squared over the number of probes; 1 where model and noise are true.
    pub innovation: f64,
    /// Status flags of all its samples.
    pub status: u16,
    /// One entry a probe.
    pub probes: Vec<ProbeSecond>,
    /// One entry a bearing.
    pub bearings: Vec<BearingSecond>,
    /// One entry a vibration sensor, at the rate of the recording.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<SensorSecond>,
}

/// One vibration sensor over one second. Not a number where the second has no reading.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorSecond {
    /// Column of the sensor.
    pub name: String,
    /// Unit of the column.
    pub unit: String,
    /// Rms about the mean.
    pub rms: f64,
    /// Largest deviation from the mean.
    pub peak: f64,
    /// Largest deviation from the mean over the rms.
    pub crest_factor: f64,
    /// Kurtosis: 3 for noise, above it for impacts.
    pub kurtosis: f64,
}

/// One probe over one second.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProbeSecond {
    /// Column of the probe.
    pub name: String,
    /// Mean position.
    pub mean_um: f64,
    /// Largest minus smallest reading.
    pub peak_to_peak_um: f64,
    /// Rms about the mean.
    pub rms_um: f64,
    /// Largest deviation from the mean over the rms.
    pub crest_factor: f64,
    /// Kurtosis: 3 for noise, 1.5 for a sine.
    pub kurtosis: f64,
    /// Rms of the residual about its mean.
    pub residual_rms_um: f64,
    /// 1X amplitude, zero to peak, over the last complete block of 16 revolutions.
    pub one_x_um: f64,
    /// Phase lag of 1X behind the keyphasor mark.
    pub one_x_phase_lag_deg: f64,
}

/// One bearing over one second.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BearingSecond {
    /// Name of the bearing.
    pub name: String,
    /// Mean force on the inner ring along X at the observer's position.
    #[serde(rename = "FX_N")]
    pub fx_n: f64,
    /// The same along Y.
    #[serde(rename = "FY_N")]
    pub fy_n: f64,
    /// The same along Z.
    #[serde(rename = "FZ_N")]
    pub fz_n: f64,
    /// Largest radial force.
    #[serde(rename = "largest_radial_N")]
    pub largest_radial_n: f64,
}

impl Second {
    /// Fields of the machine.
    pub const FIELDS: [NumericField<Self>; 5] = [
        NumericField::new("time_s", "time", "s", |s: &Self| s.time_s)
            .help("End of the latest second in the time of the recording."),
        NumericField::new("samples", "samples", "", |s: &Self| s.samples as f64)
            .help("Samples with a reading of every probe in the second."),
        NumericField::new("speed_rpm", "speed", "rpm", |s: &Self| s.speed_rpm).help("Mean shaft speed."),
        NumericField::new("innovation", "innovation", "", |s: &Self| s.innovation)
            .help("Normalised innovation squared over its expectation; 1 for an exact model."),
        NumericField::new("status", "status", "", |s: &Self| f64::from(s.status))
            .help("Sum of the status flags of all samples."),
    ];
}

impl ProbeSecond {
    /// Fields of the probe.
    pub const FIELDS: [NumericField<Self>; 8] = [
        NumericField::new("mean_um", "mean position", "um", |p: &Self| p.mean_um).help("Mean position."),
        NumericField::new("peak_to_peak_um", "peak-to-peak", "um pp", |p: &Self| p.peak_to_peak_um)
            .help("Peak-to-peak displacement."),
        NumericField::new("rms_um", "rms", "um rms", |p: &Self| p.rms_um).help("RMS displacement about the mean."),
        NumericField::new("crest_factor", "crest factor", "", |p: &Self| p.crest_factor)
            .help("Largest deviation from the mean over the RMS."),
        NumericField::new("kurtosis", "kurtosis", "", |p: &Self| p.kurtosis)
            .help("Kurtosis: 3 for Gaussian noise, 1.5 for a sine."),
        NumericField::new("residual_rms_um", "residual", "um rms", |p: &Self| p.residual_rms_um)
            .help("RMS of measured minus twin, about its mean."),
        NumericField::new("one_x_um", "1X", "um peak", |p: &Self| p.one_x_um).help("1X amplitude, zero to peak."),
        NumericField::new("one_x_phase_lag_deg", "1X phase", "deg lag", |p: &Self| p.one_x_phase_lag_deg)
            .help("1X phase lag behind the keyphasor mark."),
    ];
}

impl SensorSecond {
    /// Fields of the sensor.
    pub const FIELDS: [NumericField<Self>; 4] = [
        NumericField::new("rms", "rms", UNIT_OF_SENSOR, |s: &Self| s.rms).help("RMS vibration about the mean."),
        NumericField::new("peak", "peak", UNIT_OF_SENSOR, |s: &Self| s.peak)
            .help("Largest deviation of the vibration from its mean."),
        NumericField::new("crest_factor", "crest factor", "", |s: &Self| s.crest_factor)
            .help("Peak of the vibration over its RMS."),
        NumericField::new("kurtosis", "kurtosis", "", |s: &Self| s.kurtosis)
            .help("Kurtosis of the vibration: 3 for Gaussian noise."),
    ];
}

impl BearingSecond {
    /// Fields of the bearing.
    pub const FIELDS: [NumericField<Self>; 4] = [
        NumericField::new("FX_N", "FX", "N", |b: &Self| b.fx_n).help("Mean force on the inner ring along X."),
        NumericField::new("FY_N", "FY", "N", |b: &Self| b.fy_n).help("Mean force on the inner ring along Y."),
        NumericField::new("FZ_N", "FZ", "N", |b: &Self| b.fz_n).help("Mean force on the inner ring along Z."),
        NumericField::new("largest_radial_N", "largest radial force", "N", |b: &Self| b.largest_radial_n)
            .help("Largest radial force in the second."),
    ];
}

/// Largest number of seconds that wait for the twin.
const MAX_WAITING: usize = 3600;

/// Statistics of vibration sensors by the second. The twin is behind the readings, so that several seconds wait.
pub(crate) struct StatisticsOfSensors {
    /// Names and units.
    sensors: Vec<(String, String)>,
    /// Number of each second that is not dropped, in order.
    seconds: VecDeque<(i64, Vec<SensorSecond>)>,
    /// Statistics and number of readings in the current second.
    current: Vec<(Statistics<f64>, u64)>,
    number: Option<i64>,
}

impl StatisticsOfSensors {
    /// Creates the statistics of sensors with these names and units.
    #[must_use]
    pub fn new(sensors: Vec<(String, String)>) -> Self {
        let current = vec![(Statistics::new(u32::MAX), 0); sensors.len()];
        Self { sensors, seconds: VecDeque::new(), current, number: None }
    }

    /// Adds the readings of a row.
    pub fn add(&mut self, row: &Row) {
        let number = row.time.floor() as i64;
        if let Some(before) = self.number.replace(number).filter(|before| *before != number) {
            let all = self.sensors.iter().zip(&mut self.current).map(sensor_second).collect();
            self.seconds.push_back((before, all));
            if self.seconds.len() > MAX_WAITING {
                self.seconds.pop_front();
            }
        }
        for ((statistics, count), &reading) in self.current.iter_mut().zip(&row.sensors) {
            if reading.is_finite() {
                statistics.add::<Exact>(reading);
                *count += 1;
            }
        }
    }

    /// Returns the statistics of the second that ends at `time_s`.
    #[must_use]
    pub fn of(&self, time_s: f64) -> Vec<SensorSecond> {
        let number = time_s.round() as i64 - 1;
        let found = self.seconds.iter().find(|(of, _)| *of == number).map(|(_, all)| all.clone());
        found.unwrap_or_else(|| self.sensors.iter().map(without_reading).collect())
    }

    /// Drops the seconds up to the one that ends at `time_s`.
    pub(crate) fn drop_until(&mut self, time_s: f64) {
        let number = time_s.round() as i64 - 1;
        while self.seconds.front().is_some_and(|(of, _)| *of <= number) {
            self.seconds.pop_front();
        }
    }
}

fn without_reading((name, unit): &(String, String)) -> SensorSecond {
    let nan = f64::NAN;
    let (name, unit) = (name.clone(), unit.clone());
    SensorSecond { name, unit, rms: nan, peak: nan, crest_factor: nan, kurtosis: nan }
}

fn sensor_second((sensor, (statistics, count)): (&(String, String), &mut (Statistics<f64>, u64))) -> SensorSecond {
    if std::mem::take(count) == 0 {
        return without_reading(sensor);
    }
    let BlockStatistics { rms, crest_factor, kurtosis, .. } = statistics.close::<Exact>();
    SensorSecond { rms, peak: crest_factor * rms, crest_factor, kurtosis, ..without_reading(sensor) }
}

#[derive(Clone, Default)]
struct Force {
    count: f64,
    sum: [f64; 3],
    largest: f64,
}

/// Accumulates the indicators of the current second.
pub(crate) struct SecondIndicators {
    names: Vec<String>,
    bearings: Vec<String>,
    measured: Vec<Statistics<f64, f64>>,
    residual: Vec<Statistics<f64, f64>>,
    forces: Vec<Force>,
    samples: u64,
    speed: f64,
    innovation: (f64, f64),
    status: SampleStatus,
    number: Option<i64>,
}

impl SecondIndicators {
    /// Creates the indicators for probes and bearings of these names.
    #[must_use]
    pub fn new(probes: Vec<String>, bearings: Vec<String>) -> Self {
        let blocks = || vec![Statistics::new(u32::MAX); probes.len()];
        Self {
            measured: blocks(),
            residual: blocks(),
            forces: vec![Force::default(); bearings.len()],
            names: probes,
            bearings,
            samples: 0,
            speed: 0.0,
            innovation: (0.0, 0.0),
            status: SampleStatus::default(),
            number: None,
        }
    }

    /// Adds a sample with a reading of every probe; returns the second that ended before it. `one_x` holds the amplitudes of
    /// cosine and sine of each probe's 1X in the last block.
    pub fn add(&mut self, sample: &Sample, twin: &[f64], one_x: &[[f64; 2]]) -> Option<Second> {
        let number = sample.row.time.floor() as i64;
        let before = self.number.replace(number);
        let done = before.filter(|n| *n != number).map(|n| {
            let second = self.close((n + 1) as f64, one_x);
            Second { next_index: sample.row.index, ..second }
        });
        for (i, (y, x)) in sample.row.probes.iter().zip(twin).enumerate() {
            for (statistics, value) in [(&mut self.measured[i], *y), (&mut self.residual[i], y - x)] {
                if before.is_none() {
                    *statistics = Statistics::about(value, u32::MAX);
                }
                statistics.add::<Exact>(value);
            }
        }
        self.samples += 1;
        self.speed += sample.speed;
        done
    }

    /// Adds a normalised innovation squared of the observer.
    pub(crate) fn add_innovation(&mut self, nis: f64) {
        self.innovation.0 += nis;
        self.innovation.1 += 1.0;
    }

    /// Adds the status flags of a sample.
    pub(crate) fn add_status(&mut self, status: SampleStatus) {
        self.status = self.status.and(status);
    }

    /// Adds the force of a bearing.
    pub fn add_force(&mut self, bearing: usize, force: &EvaluatedForce) {
        let Some(sum) = self.forces.get_mut(bearing) else { return };
        let [x, y, z, ..] = force.estimated;
        sum.count += 1.0;
        for (to, f) in sum.sum.iter_mut().zip([x, y, z]) {
            *to += f;
        }
        sum.largest = sum.largest.max(x.hypot(y));
    }

    fn close(&mut self, time_s: f64, one_x: &[[f64; 2]]) -> Second {
        let samples = std::mem::take(&mut self.samples);
        let speed = std::mem::take(&mut self.speed);
        let (nis, count) = std::mem::take(&mut self.innovation);
        let status = std::mem::take(&mut self.status);
        Second {
            time_s,
            next_index: 0,
            samples,
            speed_rpm: speed / samples.max(1) as f64 * 60.0 / TAU,
            innovation: nis / count.max(1.0) / self.names.len().max(1) as f64,
            status: status.bits(),
            probes: (0..self.names.len()).map(|i| self.probe(i, one_x)).collect(),
            bearings: self.forces.iter_mut().zip(&self.bearings).map(|(force, name)| force.close(name)).collect(),
            sensors: vec![],
        }
    }

    fn probe(&mut self, i: usize, one_x: &[[f64; 2]]) -> ProbeSecond {
        let BlockStatistics { mean, rms, peak_to_peak, crest_factor, kurtosis } = self.measured[i].close::<Exact>();
        let [cosine, sine] = one_x.get(i).copied().unwrap_or_default();
        ProbeSecond {
            name: self.names[i].clone(),
            mean_um: mean * UM,
            peak_to_peak_um: peak_to_peak * UM,
            rms_um: rms * UM,
            crest_factor,
            kurtosis,
            residual_rms_um: self.residual[i].close::<Exact>().rms * UM,
            one_x_um: cosine.hypot(sine) * UM,
            one_x_phase_lag_deg: phase_lag_deg(cosine, sine),
        }
    }
}

impl Force {
    fn close(&mut self, name: &str) -> BearingSecond {
        let Self { count, sum, largest } = std::mem::take(self);
        let [fx_n, fy_n, fz_n] = sum.map(|f| f / count.max(1.0));
        BearingSecond { name: name.to_owned(), fx_n, fy_n, fz_n, largest_radial_n: largest }
    }
}
