//! Parameters of a healthy machine, determined from a recording of it.

use serde::{Deserialize, Serialize};

/// Parameters of a healthy machine, determined from a recording of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Parameters with their standard deviations.
    pub parameters: Vec<CalibratedParameter>,
    /// Correlation of each pair of parameters, row by row.
    pub correlation: Vec<Vec<f64>>,
    /// Sum of squares of the residual per value, in units of the noise: about 1 where the calibrated scene describes the recording.
    pub chi_square_per_value: f64,
    /// Readings of the probes of a site, in their order; nothing where the readings are the motion of the shaft alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<ProbeReadings>,
}

/// What the readings of a probe have besides the motion of the shaft, and the motion of the sound machine that its model leaves.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeReadings {
    /// Column of the probe.
    pub column: String,
    /// Reading with the shaft in the middle, m, beyond the scene's offset.
    pub gap: f64,
    /// Run-out beyond that measured at slow roll, m: cosine and sine of each multiple of the shaft angle, from 1.
    pub run_out: Vec<[f64; 2]>,
    /// Lines that the model does not explain: order and amplitude, m.
    pub lines: Vec<[f64; 2]>,
    /// Motion of the shaft about its mean at the probe, m rms; 0 where it is not known.
    #[serde(default)]
    pub motion_rms: f64,
}

/// A calibration compared with its scene and with its recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Learning {
    /// Parameters in the order of the calibration.
    pub parameters: Vec<LearnedParameter>,
    /// Number of rounds of the search.
    pub rounds: usize,
    /// Reason why the search does not converge; none where it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<String>,
    /// Chi-squared per value of the residual: about 1 where the learned parameters describe the recording.
    pub chi_square_per_value: f64,
    /// Largest chi-squared per value by noise and rounding alone.
    pub largest_chi_square_per_value: f64,
    /// True where the search converges and chi-squared per value is at most the largest: the parameters are used and stored. Otherwise the scene keeps its own.
    pub taken: bool,
    /// Chi-squared per value with the faults of the diagnosis and the parameters of the scene; none without a diagnosis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi_square_with_faults: Option<f64>,
    /// True where the recording is a baseline: the parameters, or the faults of the diagnosis, describe it, or it is stored by force.
    pub stored: bool,
}

impl Learning {
    /// Decides whether the recording is a baseline by chi-squared per value `with_faults`, if there is a diagnosis.
    pub fn judge(&mut self, with_faults: Option<f64>, is_forced: bool) {
        if self.taken {
            return;
        }
        self.chi_square_with_faults = with_faults;
        let is_described = with_faults.is_some_and(|with_faults| with_faults <= self.largest_chi_square_per_value);
        self.stored = is_forced || (is_described && self.not_converged.is_none());
    }

    /// Returns why the parameters are not taken.
    pub(super) fn misfit(&self) -> String {
        let [found, largest] = [self.chi_square_per_value, self.largest_chi_square_per_value];
        let with_faults = self.chi_square_with_faults;
        let search = self.not_converged.as_ref();
        if let Some(search) = search.filter(|_| found <= largest) {
            return search.clone();
        }
        format!(
            "{}the model does not describe the recording: chi-squared per value is {found:.3}{}, expected about 1 and at most {largest:.3} \
             by the noise of the probes",
            search.map_or_else(String::new, |search| format!("{search}; ")),
            with_faults.map_or_else(String::new, |with| format!(", with the faults of the diagnosis {with:.3}"))
        )
    }

    /// Returns notes on parameters that are not taken, and on taken ones that are unlikely.
    pub fn notes(&self) -> Vec<String> {
        if !self.taken {
            let which =
                if self.stored { "Levels and faults are learned, parameters are not" } else { "Nothing is learned" };
            return vec![format!("{which}: {}.", self.misfit())];
        }
        let unlikely = self.parameters.iter().filter(|of| of.unlikely);
        let note = |of: &LearnedParameter| {
            format!(
                "Learned {} is {:.1} standard deviations from the scene's: {:.4} {unit}, in the scene {:.4} {unit}. Check the scene's value.",
                of.name,
                of.deviations.unwrap_or_default().abs(),
                of.value,
                of.scene,
                unit = of.unit
            )
        };
        unlikely.map(note).collect()
    }
}

/// A learned parameter in the unit in which it is printed.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LearnedParameter {
    /// Name, with that of the bearing.
    pub name: String,
    /// Unit of all values.
    pub unit: &'static str,
    /// The scene's value.
    pub scene: f64,
    /// The learned value.
    pub value: f64,
    /// Lower end of its interval; all intervals have a joint confidence level of 95 %.
    pub low: f64,
    /// Upper end of its interval.
    pub high: f64,
    /// Difference from the scene's value, in standard deviations of both; none where the scene's value has no relation to the machine.
    pub deviations: Option<f64>,
    /// True where the scene's value is farther away than that of one machine in a thousand.
    pub unlikely: bool,
}

/// Calibrated parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedParameter {
    /// Name.
    pub name: ParameterName,
    /// Name of the bearing; `None` for a parameter of the rotor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI.
    pub deviation: f64,
}

/// Name of a parameter that a calibration determines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterName {
    /// Diametral clearance, m.
    DiametralClearance,
    /// Young's modulus of a bearing, Pa.
    YoungsModulus,
    /// Damping of translations, N s/m.
    TranslationDamping,
    /// Damping of rotations, N m s/rad.
    RotationDamping,
    /// Static unbalance along the keyphasor mark, kg m.
    UnbalanceX,
    /// Static unbalance a quarter of a revolution ahead, kg m.
    UnbalanceY,
    /// Couple unbalance along the keyphasor mark, kg m^2.
    CoupleX,
    /// Couple unbalance a quarter of a revolution ahead, kg m^2.
    CoupleY,
}

impl ParameterName {
    /// All parameters.
    pub const ALL: [Self; 8] = [
        Self::DiametralClearance,
        Self::YoungsModulus,
        Self::TranslationDamping,
        Self::RotationDamping,
        Self::UnbalanceX,
        Self::UnbalanceY,
        Self::CoupleX,
        Self::CoupleY,
    ];
}
