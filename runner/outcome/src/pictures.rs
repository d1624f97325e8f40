//! Data of the figures of a report.

use crate::field::NumericField;
use crate::options::Source;
use crate::rotor_drawing::RotorDrawing;
use ballrace_scene::Indicator;

/// Data of the pictures. Lengths in um, forces in N, times in s, frequencies in Hz.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    /// Drawing of the rotor; `None` if the scene has no rotor.
    pub rotor: Option<RotorDrawing>,
    /// Mean line of a flexible rotor.
    pub deflected_line: Option<DeflectedLine>,
    /// Traces of the first turns, one per probe.
    pub traces: Vec<Trace>,
    /// Orbits, one per plane of two or more radial probes.
    pub orbits: Vec<Orbit>,
    /// One-sided spectra, one per probe.
    pub half_spectra: Vec<HalfSpectrum>,
    /// Full spectra, one per plane.
    pub full_spectra: Vec<FullSpectrum>,
    /// Lines marked in every spectrum: 1X and each bearing's lines.
    pub lines: Vec<MarkedLine>,
    /// Natural frequencies of the rotor in its bearings at the mean speed, named N1, N2, ...; empty where they are not computed.
    pub natural_frequencies: Vec<MarkedLine>,
    /// Readings over stretches of the recording.
    pub excerpt: Excerpt,
    /// Forces, one entry per bearing.
    pub forces: Vec<ForceTrace>,
    /// Element loads, one entry per bearing with elements.
    pub element_loads: Vec<ElementLoads>,
    /// Blocks of turns from start to end.
    pub blocks: Vec<Block>,
    /// Cascades, one per plane, or one per radial probe where there is no plane.
    pub cascades: Vec<Cascade>,
    /// Clearance circles, one per plane.
    pub clearances: Vec<Option<Clearance>>,
    /// Limits of the scene to draw in trends.
    pub limits: Vec<LimitLine>,
    /// Envelope spectra, one per vibration sensor.
    pub envelopes: Vec<EnvelopeSpectrum>,
}

/// Readings of all probes over stretches of the recording, from which figures of a chosen time are computed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Excerpt {
    /// Samples per second.
    pub rate_hz: f64,
    /// In their order in time.
    pub stretches: Vec<Stretch>,
}

/// Consecutive samples of all probes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stretch {
    /// Time of the first sample.
    pub start_s: f64,
    /// Number of samples.
    pub count: usize,
    /// Readings of each probe, um; NaN where missing.
    pub measured: Vec<Vec<f32>>,
    /// The same of the twin.
    pub twin: Vec<Vec<f32>>,
    /// Samples before which the keyphasor passed.
    pub keyphasor: Vec<usize>,
}

impl Stretch {
    /// Returns the number of samples.
    #[must_use]
    pub const fn samples(&self) -> usize {
        self.count
    }
}

/// One block of four turns, or several consecutive blocks joined.
#[derive(Debug, Clone, Default)]
pub struct Block {
    /// Start time, s.
    pub start_s: f64,
    /// End time, s.
    pub end_s: f64,
    /// Mean speed.
    pub speed_rpm: f64,
    /// Figures, one entry per probe.
    pub probes: Vec<BlockFigures>,
    /// Farthest from the mean place in each plane, um peak.
    pub smax_um: Vec<f64>,
}

/// One probe in a block. Amplitudes are peak unless the name ends in pp.
#[derive(Debug, Clone, Copy, Default)]
pub struct BlockFigures {
    /// Mean position.
    pub mean_um: f64,
    /// Peak to peak, the mean where blocks were joined.
    pub peak_to_peak_um: f64,
    /// Peak to peak, the greatest where blocks were joined.
    pub greatest_um_pp: f64,
    /// Peak to peak of the signal without 1X.
    pub not_one_x_um_pp: f64,
    /// About the mean.
    pub rms_um: f64,
    /// Greatest distance from the mean over the rms.
    pub crest_factor: f64,
    /// 1.5 of a sine, 3 of noise.
    pub kurtosis: f64,
    /// Rms of measured - twin, bias included.
    pub residual_rms_um: f64,
    /// Cosine and sine of 1X.
    pub one_x_um: [f64; 2],
    /// The same of the twin.
    pub twin_one_x_um: [f64; 2],
    /// Amplitude of 2X.
    pub two_x_um: f64,
    /// Amplitude about 0.5X.
    pub half_x_um: f64,
}

/// Field of the blocks that the report draws over time, and the live page over hours.
#[derive(Debug)]
pub struct TrendField {
    /// Indicator whose limits and events are drawn with it.
    pub indicator: Indicator,
    /// The field; its key is that of the field of a second.
    pub field: NumericField<BlockFigures>,
    /// Sets its value.
    pub set: fn(&mut BlockFigures, f64),
}

impl BlockFigures {
    /// Fields with a trend, in the order of the drawing.
    pub const TRENDS: [TrendField; 4] = [
        TrendField {
            indicator: Indicator::PeakToPeak,
            field: NumericField::new("peak_to_peak_um", "Peak to peak", "um pp", |f| f.greatest_um_pp),
            set: |figures, value| figures.greatest_um_pp = value,
        },
        TrendField {
            indicator: Indicator::OneX,
            field: NumericField::new("one_x_um", "1X", "um peak", |f| f.one_x_um[0].hypot(f.one_x_um[1])),
            set: |figures, value| figures.one_x_um = [value, 0.0],
        },
        TrendField {
            indicator: Indicator::Residual,
            field: NumericField::new("residual_rms_um", "Residual", "um rms", |f| f.residual_rms_um),
            set: |figures, value| figures.residual_rms_um = value,
        },
        TrendField {
            indicator: Indicator::Kurtosis,
            field: NumericField::new("kurtosis", "Kurtosis", "", |f| f.kurtosis),
            set: |figures, value| figures.kurtosis = value,
        },
    ];
}

/// Cascade: spectra in the order of time.
#[derive(Debug, Clone, Default)]
pub struct Cascade {
    /// Probes of the plane, or the probe.
    pub name: String,
    /// True if forward and reverse precession are separate.
    pub two_sided: bool,
    /// Hz between two bins.
    pub bin_hz: f64,
    /// In their order in time.
    pub slices: Vec<Slice>,
}

/// One spectrum of a cascade.
#[derive(Debug, Clone, Default)]
pub struct Slice {
    /// Middle, s.
    pub time_s: f64,
    /// Mean speed.
    pub speed_rpm: f64,
    /// Bins from -half to +half, the middle one 0 Hz; um peak.
    pub amplitude_um: Vec<f64>,
}

/// Clearance circle of a bearing.
#[derive(Debug, Clone, Default)]
pub struct Clearance {
    /// The bearing nearest to the plane.
    pub bearing: String,
    /// From the plane to the bearing, mm.
    pub distance_mm: f64,
    /// Half the diametral clearance, um.
    pub radius_um: f64,
}

/// Mean line of a flexible rotor. A point has the station as drawn, mm, and the displacements along X and Y, um.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeflectedLine {
    /// The twin, in the order of the stations.
    pub twin: Vec<[f64; 3]>,
    /// Measured mean at each probe plane.
    pub measured: Vec<[f64; 3]>,
    /// Names and stations of the bearings.
    pub bearings: Vec<(String, f64)>,
}

/// A limit of the scene at one probe.
#[derive(Debug, Clone, Default)]
pub struct LimitLine {
    /// The indicator, as the scene names it.
    pub indicator: &'static str,
    /// The probe's column.
    pub probe: String,
    /// The bearing, for the line of a race.
    pub bearing: Option<String>,
    /// Limit, um or dimensionless.
    pub max: f64,
    /// Largest value of a block of the recording, in the unit of `max`; `None` without a complete block.
    pub largest: Option<f64>,
}

/// Spectrum of a band's squared envelope.
#[derive(Debug, Clone, Default)]
pub struct EnvelopeSpectrum {
    /// The sensor.
    pub name: String,
    /// Least and greatest frequency of the band, Hz.
    pub band_hz: [f64; 2],
    /// Reason for the choice of the band.
    pub reason: String,
    /// Hz between two bins.
    pub bin_hz: f64,
    /// Amplitude over the band's mean square.
    pub modulation: Vec<f64>,
    /// Lines to mark: 1X, and those of the sensor's bearings.
    pub lines: Vec<MarkedLine>,
    /// Side bands to mark, Hz.
    pub side_bands_hz: Vec<f64>,
}

/// The first turns of one probe.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Probe.
    pub name: String,
    /// Time of each sample, s.
    pub time: Vec<f64>,
    /// Readings, um; NaN where missing.
    pub measured: Vec<f64>,
    /// Motion of the twin, um.
    pub twin: Vec<f64>,
    /// Times at which the keyphasor passed, s.
    pub keyphasor: Vec<f64>,
}

/// The first turns of one plane, in X and Y.
#[derive(Debug, Clone, Default)]
pub struct Orbit {
    /// Names of the plane's probes.
    pub name: String,
    /// Station as drawn, mm.
    pub station_mm: f64,
    /// (x, y) um, several turns.
    pub measured: Vec<(f64, f64)>,
    /// (x, y) um of the twin, the same samples.
    pub twin: Vec<(f64, f64)>,
    /// Indices into the two lists at which the keyphasor passed.
    pub keyphasor: Vec<usize>,
    /// Probe directions: name and angle, rad from +X towards +Y.
    pub probes: Vec<(String, f64)>,
    /// 1X of the first block, where there is one.
    pub one_x: Option<FilteredOrbit>,
}

/// The 1X part of an orbit: X and Y of the cosine, then of the sine of the shaft's angle, um.
#[derive(Debug, Clone, Copy, Default)]
pub struct FilteredOrbit {
    /// Mean speed of the block.
    pub speed_rpm: f64,
    /// Orbit of the machine.
    pub measured: [(f64, f64); 2],
    /// Orbit of its twin.
    pub twin: [(f64, f64); 2],
}

/// One-sided amplitude spectrum (peak amplitude of a sine).
#[derive(Debug, Clone, Default)]
pub struct HalfSpectrum {
    /// Probe.
    pub name: String,
    /// Hz between two bins.
    pub bin_hz: f64,
    /// Amplitudes of the readings, um.
    pub measured: Vec<f64>,
    /// Amplitudes of the twin, um.
    pub twin: Vec<f64>,
    /// Amplitudes of measured - twin, um.
    pub residual: Vec<f64>,
}

/// Full spectrum of x + jy: forward to the right, reverse to the left.
#[derive(Debug, Clone, Default)]
pub struct FullSpectrum {
    /// Plane.
    pub name: String,
    /// Hz between two bins.
    pub bin_hz: f64,
    /// Bins from -half to +half, `2 half + 1` entries, the middle one 0 Hz; um.
    pub measured: Vec<f64>,
    /// The same of the twin.
    pub twin: Vec<f64>,
}

/// A line to mark in the spectra.
#[derive(Debug, Clone, Default)]
pub struct MarkedLine {
    /// "1X", "DE outer", ...
    pub label: String,
    /// Per turn.
    pub order: f64,
    /// At the mean speed.
    pub hz: f64,
}

/// Forces of one bearing over the first turns.
#[derive(Debug, Clone, Default)]
pub struct ForceTrace {
    /// Bearing.
    pub name: String,
    /// Time of each sample, s.
    pub time: Vec<f64>,
    /// Displacement of `measured`.
    pub source: Source,
    /// FX, FY, FZ at the displacement of `source`, N.
    pub measured: [Vec<f64>; 3],
    /// The same of the twin.
    pub twin: [Vec<f64>; 3],
    /// One sigma of probe noise on FX, FY, FZ of `measured`; empty when unknown.
    pub sigma: [Vec<f64>; 3],
}

/// Load on each element while the cage turns once.
#[derive(Debug, Clone, Default)]
pub struct ElementLoads {
    /// Bearing.
    pub name: String,
    /// Azimuth bins around the ring, rad (centre of each).
    pub azimuth: Vec<f64>,
    /// Displacement of the loads that are not the twin's.
    pub source: Source,
    /// Mean load of the element passing there, N.
    pub mean: Vec<f64>,
    /// Largest load there, N.
    pub largest: Vec<f64>,
    /// Mean load there of the twin, N.
    pub twin_mean: Vec<f64>,
    /// Load on element 1 against its azimuth over the first revolutions of the cage: (azimuth rad, N).
    pub first_element: Vec<(f64, f64)>,
}
