//! Statistics of readings and speed over a recording.

use super::checks::SPEED_FACTOR;
use ballrace::Exact;
use ballrace::math::Math;
use ballrace_base::moments::Moments;
use ballrace_recording::status::SampleStatus;
use ballrace_recording::{Row, Sample};
use ballrace_scene::{Direction, Probe, Recording, Speed, TemperatureChannel};
use serde::Serialize;
use std::f64::consts::TAU;

/// Fewest readings of a column that only rises or falls: noise does so once in 64! times.
const MIN_MONOTONIC: u64 = 64;

/// Readings of one column: in um for a probe, in the unit of the column for a sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingSummary {
    /// The column.
    pub column: String,
    /// Unit of the values here.
    pub unit: String,
    /// Station and angle of a radial probe, mm and degrees.
    pub radial: Option<[f64; 2]>,
    /// Wiring of a probe whose column is in volts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voltage: Option<VoltageSummary>,
    /// Mean.
    pub mean: f64,
    /// Root of the mean square about the mean.
    pub rms: f64,
    /// Greatest minus least reading.
    pub peak_to_peak: f64,
    /// Amplitude and phase lag (degrees) of the line at shaft speed; none without a shaft angle.
    pub one_x: Option<[f64; 2]>,
    /// Samples with a reading.
    pub samples: u64,
    /// Rms of the white noise, at most, from the quietest part; none of few readings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
}

/// Sensitivity and mean voltage of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VoltageSummary {
    /// Sensitivity, mV per um.
    pub sensitivity_mv_per_um: f64,
    /// Voltage with the shaft in the middle, `offset` in the scene.
    pub offset_v: f64,
    /// Mean voltage: the gap voltage of a proximity probe.
    pub mean_v: f64,
}

impl VoltageSummary {
    /// Returns the summary of a probe with this mean displacement, m; none for a probe whose column is a length.
    fn new(probe: &Probe, mean: f64) -> Option<Self> {
        let sensitivity = probe.sensitivity?;
        Some(Self {
            sensitivity_mv_per_um: sensitivity * 1e-3,
            offset_v: probe.offset * sensitivity,
            mean_v: (mean + probe.offset) * sensitivity,
        })
    }
}

/// Least mean square of the third differences over blocks of consecutive readings: the motion of a shaft is slow beside the
/// sampling rate, so that what remains is noise. White noise of the variance s^2 has third differences of 20 s^2.
#[derive(Debug, Clone, Copy, Default)]
struct Differences {
    /// The last three readings.
    last: [f64; 3],
    readings: u64,
    sum: f64,
    least: Option<f64>,
}

impl Differences {
    const BLOCK: u64 = 64;
    const OF_WHITE_NOISE: f64 = 20.0;

    fn add(&mut self, x: f64) {
        let [c, b, a] = self.last;
        self.last = [b, a, x];
        self.readings += 1;
        if self.readings <= 3 {
            return;
        }
        self.sum += (x - 3.0 * a + 3.0 * b - c).powi(2);
        if (self.readings - 3).is_multiple_of(Self::BLOCK) {
            let mean = self.sum / Self::BLOCK as f64;
            self.least = Some(self.least.map_or(mean, |least| least.min(mean)));
            self.sum = 0.0;
        }
    }

    /// Returns the rms of the noise.
    fn noise(&self) -> Option<f64> {
        self.least.map(|least| (least / Self::OF_WHITE_NOISE).sqrt())
    }
}

/// Sums over one column.
#[derive(Debug, Clone, Copy)]
struct Sums {
    all: Moments,
    differences: Differences,
    least: f64,
    greatest: f64,
    last: f64,
    /// No reading was below the one before, or equal to it.
    rises: bool,
    /// No reading was above the one before, or equal to it.
    falls: bool,
    /// Sums of reading times cosine and sine of the shaft angle, and of cosine and sine.
    turning: [f64; 4],
    /// Readings in range, in samples with a shaft angle.
    within: Moments,
}

impl Default for Sums {
    fn default() -> Self {
        let (least, greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        Self {
            all: Moments::default(),
            differences: Differences::default(),
            least,
            greatest,
            last: f64::NAN,
            rises: true,
            falls: true,
            turning: [0.0; 4],
            within: Moments::default(),
        }
    }
}

impl Sums {
    fn add(&mut self, x: f64) {
        self.least = self.least.min(x);
        self.greatest = self.greatest.max(x);
        let is_first = self.all.count() == 0;
        self.rises &= is_first || x > self.last;
        self.falls &= is_first || x < self.last;
        self.last = x;
        self.all.add(x);
        self.differences.add(x);
    }

    /// Returns cosine and sine amplitude of 1X.
    fn one_x(&self) -> Option<[f64; 2]> {
        let [x_cos, x_sin, cos, sin] = self.turning;
        let (n, mean) = (self.within.divisor(), self.all.mean());
        (self.within.count() > 0).then(|| [2.0 * (x_cos - mean * cos) / n, 2.0 * (x_sin - mean * sin) / n])
    }
}

fn readings(row: &Row) -> impl Iterator<Item = &f64> {
    row.probes.iter().chain(&row.sensors).chain(&row.temperatures)
}

/// Statistics of all columns and of the shaft speed.
pub struct Collector {
    /// Number of probes and sensors, which come first.
    signals: usize,
    columns: Vec<Sums>,
    speeds: Speeds,
}

impl Collector {
    /// Creates a collector for the columns of a recording (probes, sensors, temperatures) and the speed of the scene.
    pub fn new(recording: &Recording, scene_speed: Speed) -> Self {
        let signals = recording.probes.len() + recording.sensors.len();
        let columns = signals + recording.temperatures.len();
        let (a, b) = scene_speed.range();
        // Magnitudes only, because a keyphasor gives no sign.
        let (slow, fast) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
        let plausible = [slow / SPEED_FACTOR, fast * SPEED_FACTOR];
        Self { signals, columns: vec![Sums::default(); columns], speeds: Speeds { plausible, ..Speeds::default() } }
    }

    /// Adds the readings of a row as they were measured.
    pub fn add_row(&mut self, row: &Row) {
        for (sums, x) in self.columns.iter_mut().zip(readings(row)).filter(|(_, x)| x.is_finite()) {
            sums.add(*x);
        }
    }

    /// Adds shaft angle and speed of a sample, with the readings that are in range.
    pub fn add_sample(&mut self, sample: &Sample) {
        self.speeds.add(sample);
        let (sin, cos): (f64, f64) = Exact::sin_cos(sample.angle);
        for (sums, x) in self.columns.iter_mut().zip(readings(&sample.row)).filter(|(_, x)| x.is_finite()) {
            for (sum, term) in sums.turning.iter_mut().zip([x * cos, x * sin, cos, sin]) {
                *sum += term;
            }
            sums.within.add(*x);
        }
    }

    /// Returns the figures of the shaft speed.
    pub const fn speeds(&self) -> &Speeds {
        &self.speeds
    }

    /// Returns the index of a probe or sensor whose readings only rise or only fall.
    pub fn monotonic(&self) -> Option<usize> {
        self.columns
            .iter()
            .take(self.signals)
            .position(|sums| sums.all.count() >= MIN_MONOTONIC && (sums.rises || sums.falls))
    }

    /// Returns the root of the mean square about the mean of the readings in range, in SI; none for a column that has readings in
    /// less than half of the samples, which is a flaw of its own.
    pub(crate) fn rms_in_range(&self) -> Vec<Option<f64>> {
        let samples = self.columns.iter().map(|sums| sums.within.count()).max().unwrap_or(0);
        let is_read = |within: &Moments| within.count() > 0 && 2 * within.count() >= samples;
        self.columns.iter().map(|sums| is_read(&sums.within).then(|| sums.within.rms_about_mean())).collect()
    }

    /// Returns the standard deviation of the amplitude of 1X by noise as large as the whole motion, in SI.
    pub(crate) fn one_x_noise(&self) -> Vec<f64> {
        let noise = |(rms, sums): (Option<f64>, &Sums)| rms.unwrap_or(0.0) * (2.0 / sums.within.divisor()).sqrt();
        self.rms_in_range().into_iter().zip(&self.columns).map(noise).collect()
    }

    /// Returns the figures of each column.
    pub fn summary(&self, recording: &Recording) -> Vec<ReadingSummary> {
        let probes = recording.probes.iter().map(|probe| {
            let radial = match probe.direction {
                Direction::Radial(angle) => Some([probe.station * 1e3, angle.to_degrees()]),
                Direction::Axial => None,
            };
            (probe.column.clone(), "um".to_owned(), radial, 1e6, Some(probe))
        });
        let sensors =
            recording.sensors.iter().map(|sensor| (sensor.column.clone(), sensor.unit.clone(), None, 1.0, None));
        let temperature = |channel: &TemperatureChannel| (channel.column.clone(), "K".to_owned(), None, 1.0, None);
        let temperatures = recording.temperatures.iter().map(temperature);
        let one = |((column, unit, radial, scale, probe), sums): ((String, String, _, f64, Option<&Probe>), &Sums)| {
            ReadingSummary {
                column,
                unit,
                radial,
                voltage: probe.and_then(|probe| VoltageSummary::new(probe, sums.all.mean())),
                mean: sums.all.mean() * scale,
                rms: sums.all.rms_about_mean() * scale,
                peak_to_peak: (sums.greatest - sums.least).max(0.0) * scale,
                one_x: sums
                    .one_x()
                    .map(|[cos, sin]| [cos.hypot(sin) * scale, sin.atan2(cos).to_degrees().rem_euclid(360.0)]),
                samples: sums.all.count(),
                noise: sums.differences.noise().map(|noise| noise * scale),
            }
        };
        probes.chain(sensors).chain(temperatures).zip(&self.columns).map(one).collect()
    }
}

/// Least, mean and greatest of the shaft speed.
#[derive(Default)]
pub struct Speeds {
    /// Magnitudes between which a speed is plausible, rad/s.
    plausible: [f64; 2],
    least: f64,
    greatest: f64,
    sum: f64,
    count: u64,
    /// Samples at a plausible speed.
    at_speed: u64,
}

impl Speeds {
    fn add(&mut self, sample: &Sample) {
        if sample.status.has(SampleStatus::ANGLE_NOT_MEASURED) {
            return;
        }
        let (speed, is_first) = (sample.speed, self.count == 0);
        self.least = if is_first { speed } else { self.least.min(speed) };
        self.greatest = if is_first { speed } else { self.greatest.max(speed) };
        self.sum += speed;
        self.count += 1;
        let [slow, fast] = self.plausible;
        self.at_speed += u64::from((slow..=fast).contains(&speed.abs()));
    }

    /// Returns least, mean and greatest, rpm; none without a sample with a measured speed.
    pub fn rpm(&self) -> Option<[f64; 3]> {
        let to_rpm = 60.0 / TAU;
        let mean = self.sum / self.count as f64;
        (self.count > 0).then(|| [self.least, mean, self.greatest].map(|speed| speed * to_rpm))
    }

    /// Returns the share of the samples at a plausible speed.
    pub(crate) fn share_at_speed(&self) -> f64 {
        self.at_speed as f64 / self.count.max(1) as f64
    }
}
