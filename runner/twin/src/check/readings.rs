//! Statistics of the readings of each probe or sensor.

use crate::recording::{Row, Sample};
use crate::scene::{Direction, Recording, TemperatureChannel};
use serde::Serialize;

/// Readings of one column: in um for a probe, in the unit of the column for a sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingSummary {
    /// The column.
    pub column: String,
    /// Unit of the values here.
    pub unit: String,
    /// Station and angle of a radial probe, mm and degrees.
    pub radial: Option<[f64; 2]>,
    /// Mean.
    pub mean: f64,
    /// Root of the mean square about the mean.
    pub rms: f64,
    /// Greatest less least.
    pub peak_to_peak: f64,
    /// Amplitude and phase lag (degrees) of the line at shaft speed; none without a shaft angle.
    pub one_x: Option<[f64; 2]>,
    /// Samples with a reading.
    pub samples: u64,
}

/// Sums over one column.
#[derive(Debug, Clone, Copy)]
struct Sums {
    count: u64,
    mean: f64,
    /// Sum of the squares about the mean.
    squares: f64,
    least: f64,
    greatest: f64,
    /// Sums of reading times cosine and sine of the shaft angle, of cosine and sine, and the number of samples.
    turning: [f64; 4],
    turning_count: u64,
}

impl Default for Sums {
    fn default() -> Self {
        let (least, greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { count: 0, mean: 0.0, squares: 0.0, least, greatest, turning: [0.0; 4], turning_count: 0 }
    }
}

impl Sums {
    fn add(&mut self, x: f64) {
        self.count += 1;
        let before = x - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (x - self.mean);
        self.least = self.least.min(x);
        self.greatest = self.greatest.max(x);
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }

    /// Returns cosine and sine amplitude of 1X.
    fn one_x(&self) -> Option<[f64; 2]> {
        let [x_cos, x_sin, cos, sin] = self.turning;
        let n = self.turning_count as f64;
        (self.turning_count > 0).then(|| [2.0 * (x_cos - self.mean * cos) / n, 2.0 * (x_sin - self.mean * sin) / n])
    }
}

/// Readings of all columns: probes, then sensors, then temperatures.
pub(super) struct Readings(Vec<Sums>);

impl Readings {
    pub fn new(count: usize) -> Self {
        Self(vec![Sums::default(); count])
    }

    /// Adds the readings of a row.
    pub fn add(&mut self, row: &Row) {
        let readings = row.probes.iter().chain(&row.sensors).chain(&row.temperatures);
        for (sums, x) in self.0.iter_mut().zip(readings).filter(|(_, x)| x.is_finite()) {
            sums.add(*x);
        }
    }

    /// Adds the readings of a sample with a shaft angle.
    pub fn add_at(&mut self, sample: &Sample) {
        let (sin, cos) = sample.angle.radians().sin_cos();
        let readings = sample.row.probes.iter().chain(&sample.row.sensors).chain(&sample.row.temperatures);
        for (sums, x) in self.0.iter_mut().zip(readings).filter(|(_, x)| x.is_finite()) {
            for (sum, term) in sums.turning.iter_mut().zip([x * cos, x * sin, cos, sin]) {
                *sum += term;
            }
            sums.turning_count += 1;
        }
    }

    /// Returns the standard deviation of the amplitude of 1X by noise as large as the whole reading, in SI.
    pub fn one_x_noise(&self) -> Vec<f64> {
        self.0.iter().map(|sums| sums.rms() * (2.0 / sums.turning_count.max(1) as f64).sqrt()).collect()
    }

    pub fn summary(&self, recording: &Recording) -> Vec<ReadingSummary> {
        let probes = recording.probes.iter().map(|probe| {
            let radial = match probe.direction {
                Direction::Radial(angle) => Some([probe.station * 1e3, angle.to_degrees()]),
                Direction::Axial => None,
            };
            (probe.column.clone(), "um".to_owned(), radial, 1e6)
        });
        let sensors = recording.sensors.iter().map(|sensor| (sensor.column.clone(), sensor.unit.clone(), None, 1.0));
        let temperature = |channel: &TemperatureChannel| (channel.column.clone(), "K".to_owned(), None, 1.0);
        let temperatures = recording.temperatures.iter().map(temperature);
        let one = |((column, unit, radial, scale), sums): ((String, String, _, f64), &Sums)| ReadingSummary {
            column,
            unit,
            radial,
            mean: sums.mean * scale,
            rms: sums.rms() * scale,
            peak_to_peak: (sums.greatest - sums.least).max(0.0) * scale,
            one_x: sums
                .one_x()
                .map(|[cos, sin]| [cos.hypot(sin) * scale, sin.atan2(cos).to_degrees().rem_euclid(360.0)]),
            samples: sums.count,
        };
        probes.chain(sensors).chain(temperatures).zip(&self.0).map(one).collect()
    }
}
