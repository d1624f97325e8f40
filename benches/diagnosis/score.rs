//! Diagnoses against the truth: verdict, errors of place and size, intervals.

use crate::fleet::Fault;
use crate::program::{Diagnosis, Estimate};
use std::f64::consts::TAU;

/// The kind of a diagnosis that names no cause.
const UNEXPLAINED: &str = "other";
/// Kinds of a diagnosis of the measurement, which accuses neither bearing nor rotor.
const OF_MEASUREMENT: [&str; 1] = ["run-out"];
/// Kinds of faults outside bearing and rotor, which may also be called unexplained.
const OUTSIDE: [&str; 2] = ["rub", "looseness"];

/// Verdict on the diagnoses of one recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The first diagnoses are the faults; a machine in good order has no diagnosis.
    Right,
    /// The first diagnoses name some of the faults and nothing else.
    Partial,
    /// One of the first diagnoses names another cause or bearing; on a machine in good order any diagnosis does.
    Wrong,
    /// No diagnosis, or none that names a cause.
    NotNamed,
}

/// Verdict, matches and further diagnoses of one recording.
pub struct Score {
    pub verdict: Verdict,
    /// Pairs of a fault and the diagnosis that names it, by index.
    pub matches: Vec<(usize, usize)>,
    /// Diagnoses beyond as many as there are faults.
    pub further: usize,
}

impl Score {
    /// Compares diagnoses, strongest first, with the faults of the machine. As many diagnoses count as there are faults.
    pub fn new(faults: &[Fault], diagnoses: &[Diagnosis]) -> Self {
        let is_of_machine = |diagnosis: &&Diagnosis| !OF_MEASUREMENT.contains(&diagnosis.kind.as_str());
        let diagnoses: Vec<&Diagnosis> = diagnoses.iter().filter(is_of_machine).collect();
        let considered = &diagnoses[..diagnoses.len().min(faults.len())];
        let further = diagnoses.len() - considered.len();
        if faults.is_empty() {
            let verdict = match diagnoses.iter().any(|diagnosis| diagnosis.kind != UNEXPLAINED) {
                true => Verdict::Wrong,
                false if diagnoses.is_empty() => Verdict::Right,
                false => Verdict::NotNamed,
            };
            return Self { verdict, matches: vec![], further: 0 };
        }
        let mut matches: Vec<(usize, usize)> = vec![];
        let mut foreign = 0;
        for (i, diagnosis) in considered.iter().enumerate() {
            let is_new = |f: &usize| matches.iter().all(|(fault, _)| fault != f);
            match (0..faults.len()).filter(is_new).find(|&f| names(diagnosis, &faults[f])) {
                Some(fault) => matches.push((fault, i)),
                None => foreign += usize::from(diagnosis.kind != UNEXPLAINED),
            }
        }
        let verdict = match (foreign, matches.len()) {
            (0, 0) => Verdict::NotNamed,
            (0, n) if n == faults.len() => Verdict::Right,
            (0, _) => Verdict::Partial,
            _ => Verdict::Wrong,
        };
        Self { verdict, matches, further }
    }
}

/// Returns true where the diagnosis has the cause and the bearing of the fault.
fn names(diagnosis: &Diagnosis, fault: &Fault) -> bool {
    let is_outside = OUTSIDE.contains(&fault.kind.as_str()) && diagnosis.kind == UNEXPLAINED;
    is_outside || (diagnosis.kind == fault.kind && (fault.bearing.is_none() || diagnosis.bearing == fault.bearing))
}

/// How an estimate is compared with the truth.
#[derive(Clone, Copy, PartialEq)]
pub enum Comparison {
    /// Difference of angles, deg.
    Angle,
    /// Difference in the unit of the diagnosis.
    Difference,
    /// Share of the truth, %.
    Relative,
}

/// A quantity of a fault: where the truth and the diagnosis state it.
pub struct Quantity {
    pub name: &'static str,
    pub unit: &'static str,
    pub comparison: Comparison,
    truth: fn(&Fault) -> Option<f64>,
    found: fn(&Diagnosis) -> Option<Estimate>,
}

/// Returns the value where the fault is of the kind.
fn of_kind(fault: &Fault, kind: &str, value: Option<f64>) -> Option<f64> {
    value.filter(|_| fault.kind == kind)
}

const fn degrees(angle: f64) -> f64 {
    angle * 360.0 / TAU
}

/// The quantities of the table.
#[rustfmt::skip]
pub const QUANTITIES: [Quantity; 15] = [
    Quantity { name: "azimuth of a spall, outer race", unit: "deg", comparison: Comparison::Angle, truth: |f| of_kind(f, "outer-race", f.azimuth).map(degrees), found: |f| f.azimuth_deg },
    Quantity { name: "angle of a spall, inner race", unit: "deg", comparison: Comparison::Angle, truth: |f| of_kind(f, "inner-race", f.azimuth).map(degrees), found: |f| f.azimuth_deg },
    Quantity { name: "depth of a spall, outer race", unit: "%", comparison: Comparison::Relative, truth: |f| of_kind(f, "outer-race", f.depth).map(|x| 1e6 * x), found: |f| f.depth_um },
    Quantity { name: "depth of a spall, inner race", unit: "%", comparison: Comparison::Relative, truth: |f| of_kind(f, "inner-race", f.depth).map(|x| 1e6 * x), found: |f| f.depth_um },
    Quantity { name: "depth of a spall, ball", unit: "%", comparison: Comparison::Relative, truth: |f| of_kind(f, "element", f.depth).map(|x| 1e6 * x), found: |f| f.depth_um },
    Quantity { name: "half width of a spall, races", unit: "%", comparison: Comparison::Relative, truth: |f| f.half_width.filter(|_| f.kind != "element").map(degrees), found: |f| f.half_width_deg },
    Quantity { name: "half width of a spall, ball", unit: "%", comparison: Comparison::Relative, truth: |f| of_kind(f, "element", f.half_width).map(degrees), found: |f| f.half_width_deg },
    Quantity { name: "order of a wave", unit: "", comparison: Comparison::Difference, truth: |f| f.order, found: |f| f.waviness_order },
    Quantity { name: "amplitude of a wave", unit: "%", comparison: Comparison::Relative, truth: |f| f.amplitude.map(|x| 1e6 * x), found: |f| f.amplitude_um },
    Quantity { name: "diametral clearance", unit: "%", comparison: Comparison::Relative, truth: |f| f.clearance.map(|x| 1e6 * x), found: |f| f.clearance_um },
    Quantity { name: "tilt of a ring", unit: "%", comparison: Comparison::Relative, truth: |f| f.tilt.map(|x| 1e3 * x), found: |f| f.tilt_mrad },
    Quantity { name: "axis of the tilt", unit: "deg", comparison: Comparison::Angle, truth: |f| f.direction.map(degrees), found: |f| f.axis_deg },
    Quantity { name: "unbalance moment", unit: "%", comparison: Comparison::Relative, truth: |f| f.moment.map(|x| 1e6 * x), found: |f| f.moment_g_mm },
    Quantity { name: "angle of the unbalance", unit: "deg", comparison: Comparison::Angle, truth: |f| f.angle.map(degrees), found: |f| f.angle_deg },
    Quantity { name: "station of the unbalance", unit: "mm", comparison: Comparison::Difference, truth: |f| f.station.map(|x| 1e3 * x), found: |f| f.station_mm },
];

/// Error of an estimate, and whether its interval holds the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantityError {
    pub error: f64,
    pub covered: Option<bool>,
}

impl Quantity {
    /// Compares a diagnosis with the fault it names; none where the truth does not state the quantity. A diagnosis that does not
    /// state it has an infinite error.
    pub fn error(&self, fault: &Fault, diagnosis: &Diagnosis) -> Option<QuantityError> {
        let truth = (self.truth)(fault)?;
        let Some(Estimate { value, low, high }) = (self.found)(diagnosis) else {
            return Some(QuantityError { error: f64::INFINITY, covered: None });
        };
        // The branch of the angle that is nearest to the estimate.
        let truth = match self.comparison {
            Comparison::Angle => truth - 360.0 * ((truth - value) / 360.0).round(),
            Comparison::Difference | Comparison::Relative => truth,
        };
        let scale = if self.comparison == Comparison::Relative { 100.0 / truth.abs() } else { 1.0 };
        let covered = low.zip(high).map(|(low, high)| (low..=high).contains(&truth));
        Some(QuantityError { error: (value - truth).abs() * scale, covered })
    }
}
