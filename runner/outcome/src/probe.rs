//! Comparison of machine and twin at one probe, and its tabular list.

use crate::field::NumericField;
use crate::motion::{BallPassLine, Motion};
use crate::predictors::SimplePredictors;
use ballrace_scene::Indicator;
use serde::Serialize;

/// Comparison at one probe.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProbeOutcome {
    /// The probe's column.
    pub name: String,
    /// Along Z as drawn: from the centre of mass of a rigid rotor, from the origin of a flexible rotor's drawing.
    pub station_mm: f64,
    /// From +X towards +Y; absent for an axial probe.
    pub angle_deg: Option<f64>,
    /// The machine.
    pub measured: Motion,
    /// Its twin.
    pub twin: Motion,
    /// Size of the difference of the two 1X vectors.
    pub one_x_error_um: f64,
    /// One entry a bearing with moving elements.
    pub ball_pass: Vec<BallPassLine>,
    /// Mean of measured - twin.
    pub residual_bias_um: f64,
    /// Rms of measured - twin, bias included.
    pub residual_rms_um: f64,
    /// residual_rms over the normaliser.
    pub nrmse_percent: f64,
    /// Normaliser of the NRMSE, in words.
    pub nrmse_normaliser: String,
    /// Probe noise, rms, when the scene gives it.
    pub noise_um: Option<f64>,
    /// Simpler predictors of the signal at a probe.
    pub baselines: SimplePredictors,
    /// Tabular list; none where no block of revolutions is complete.
    pub list: Option<TabularList>,
}

/// Value of an indicator of a probe.
type ProbeValue = fn(&ProbeOutcome) -> f64;

impl ProbeOutcome {
    /// Place and direction of the probe.
    pub const PLACE: [NumericField<Self>; 2] = [
        NumericField::new("station_mm", "Station", "mm", |p: &Self| p.station_mm).decimals(1),
        NumericField::new("angle_deg", "Angle", "deg", |p: &Self| p.angle_deg.unwrap_or(f64::NAN)).decimals(1),
    ];

    /// Difference of measured and twin.
    pub const RESIDUAL: [NumericField<Self>; 4] = [
        NumericField::new("one_x_error_um", "1X vector", "um peak", |p| p.one_x_error_um),
        NumericField::new("residual_bias_um", "Bias", "um", |p| p.residual_bias_um),
        NumericField::new("residual_rms_um", "RMS", "um rms", |p: &Self| p.residual_rms_um).short("rms"),
        NumericField::new("nrmse_percent", "NRMSE", "%", |p| p.nrmse_percent),
    ];

    /// Noise of the probe.
    pub const NOISE: NumericField<Self> =
        NumericField::new("noise_um", "Probe noise", "um rms", |p| p.noise_um.unwrap_or(f64::NAN));

    /// Indicators with a value of the whole recording, in the unit of [`Indicator::unit`].
    pub const INDICATORS: [(Indicator, ProbeValue); 7] = [
        (Indicator::Residual, |p| p.residual_rms_um),
        (Indicator::OneX, |p| p.measured.one_x_um),
        (Indicator::TwoX, |p| p.list.map_or(f64::NAN, |list| list.two_x_um_pp / 2.0)),
        (Indicator::PeakToPeak, |p| p.measured.peak_to_peak_um),
        (Indicator::Rms, |p| p.measured.rms_um),
        (Indicator::CrestFactor, |p| p.list.map_or(f64::NAN, |list| list.crest_factor)),
        (Indicator::Kurtosis, |p| p.list.map_or(f64::NAN, |list| list.kurtosis)),
    ];

    /// Returns true where the readings were compared with the twin's, which requires a shaft angle.
    #[must_use]
    pub const fn has_twin(&self) -> bool {
        !self.twin.mean_um.is_nan()
    }
}

/// One row of the tabular list: means over blocks of four turns. The name of a length states whether it is a peak or a peak-to-peak value.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TabularList {
    /// Overall, peak to peak within a block.
    pub direct_um_pp: f64,
    /// The greatest of any block.
    pub greatest_um_pp: f64,
    /// Mean position.
    pub gap_um: f64,
    /// Amplitude of 1X, peak to peak.
    pub one_x_um_pp: f64,
    /// Lag of 1X behind the keyphasor, 0 to 360; none where the speed changes.
    pub one_x_phase_lag_deg: Option<f64>,
    /// Amplitude of 2X, peak to peak.
    pub two_x_um_pp: f64,
    /// Peak to peak of the signal without 1X.
    pub not_one_x_um_pp: f64,
    /// Amplitude about 0.5X (0.3X to 0.7X), peak to peak.
    pub half_x_um_pp: f64,
    /// Greatest distance from the mean over the rms.
    pub crest_factor: f64,
    /// 1.5 of a sine, 3 of noise.
    pub kurtosis: f64,
}

impl TabularList {
    /// No block of revolutions.
    pub const NONE: Self = Self {
        direct_um_pp: f64::NAN,
        greatest_um_pp: f64::NAN,
        gap_um: f64::NAN,
        one_x_um_pp: f64::NAN,
        one_x_phase_lag_deg: None,
        two_x_um_pp: f64::NAN,
        not_one_x_um_pp: f64::NAN,
        half_x_um_pp: f64::NAN,
        crest_factor: f64::NAN,
        kurtosis: f64::NAN,
    };

    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 10] = [
        NumericField::new("direct_um_pp", "Direct", "um pp", |list| list.direct_um_pp),
        NumericField::new("greatest_um_pp", "Greatest", "um pp", |list| list.greatest_um_pp),
        NumericField::new("gap_um", "Gap", "um", |list| list.gap_um),
        NumericField::new("one_x_um_pp", "1X", "um pp", |list| list.one_x_um_pp),
        NumericField::new("one_x_phase_lag_deg", "1X phase", "deg lag", |list: &Self| {
            list.one_x_phase_lag_deg.unwrap_or(f64::NAN)
        })
        .decimals(1),
        NumericField::new("two_x_um_pp", "2X", "um pp", |list| list.two_x_um_pp),
        NumericField::new("not_one_x_um_pp", "Not 1X", "um pp", |list| list.not_one_x_um_pp),
        NumericField::new("half_x_um_pp", "0.5X band", "um pp", |list| list.half_x_um_pp),
        NumericField::new("crest_factor", "Crest factor", "", |list: &Self| list.crest_factor).decimals(2),
        NumericField::new("kurtosis", "Kurtosis", "", |list: &Self| list.kurtosis).decimals(2),
    ];
}
