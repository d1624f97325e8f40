//! The Pareto front, and the choice of a model for a given error or deadline.

use super::{Candidate, Response};
use ballrace_plant::error::TradeError;
use serde::Serialize;

/// Goal of the choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// The cheapest candidate with at most this error in 99 of 100 poses, relative to the largest load.
    Error(f64, Target),
    /// The most accurate candidate with at most this many cycles for one sample of every bearing.
    Deadline {
        /// Deadline, s.
        time: f64,
        /// Clock of the target, Hz.
        clock: f64,
    },
}

/// Processor whose cost counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// Modelled cycles of a Cortex-M4F, in `f32` with exact math, as `bake` writes it.
    CortexM4f,
    /// Time on this machine, in `f64` with exact math, as this program computes.
    Desktop,
}

/// The recommended model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// Fidelity level.
    pub model: String,
    /// Precision.
    pub precision: &'static str,
    /// Its error in 99 of 100 poses.
    pub error: f64,
    /// Its cost in the requested unit.
    pub cost: f64,
    /// `cycles` or `ns`
    pub unit: &'static str,
    /// Time at the given clock, s, where there is one.
    pub seconds: Option<f64>,
}

/// Errors below this count as equal.
const ROUNDED: f64 = 1e-12;

/// Marks the candidates that no other beats in both cost and error.
pub fn mark(candidates: &mut [Candidate]) {
    let error = |c: &Candidate| if c.overflow.is_some() { f64::INFINITY } else { c.error.most_99.max(ROUNDED) };
    let desktop: Vec<_> = candidates.iter().map(|c| Some((c.desktop_ns, error(c)))).collect();
    let cortex: Vec<_> = candidates.iter().map(|c| c.cortex.and_then(|cost| Some((cost.cycles?, error(c))))).collect();
    for (i, candidate) in candidates.iter_mut().enumerate() {
        candidate.front_desktop = on_front(&desktop, i);
        candidate.front_cortex = on_front(&cortex, i);
    }
}

/// Marks the responses that no other beats in both computing time and residual.
pub(crate) fn mark_responses(responses: &mut [Response]) {
    let points: Vec<_> = responses.iter().map(|r| Some((1.0 / r.times_real_time, r.error.residual))).collect();
    for (i, response) in responses.iter_mut().enumerate() {
        response.front = on_front(&points, i);
    }
}

fn on_front(points: &[Option<(f64, f64)>], i: usize) -> bool {
    let Some(Some(own)) = points.get(i) else { return false };
    let beats = |other: &(f64, f64)| other.0 <= own.0 && other.1 <= own.1 && (other.0 < own.0 || other.1 < own.1);
    own.1.is_finite() && !points.iter().flatten().any(beats)
}

/// Returns the candidate that meets the goal best.
///
/// # Errors
/// Returns [`TradeError::NotCounted`] where no candidate has a cost on the target, and [`TradeError::Error`] or
/// [`TradeError::Deadline`] with the goal that the nearest candidate meets where none meets `goal`.
pub fn choose(goal: &Goal, candidates: &[Candidate]) -> Result<Choice, TradeError> {
    let target = match goal {
        Goal::Error(_, target) => *target,
        Goal::Deadline { .. } => Target::CortexM4f,
    };
    let cost = |c: &Candidate| match target {
        Target::CortexM4f => c.cortex.and_then(|cost| cost.cycles),
        Target::Desktop => Some(c.desktop_ns),
    };
    let precision = if target == Target::CortexM4f { "f32" } else { "f64" };
    let open = candidates.iter().filter(|c| c.arithmetic.precision == precision && c.arithmetic.math == "exact");
    let (open, overflowed): (Vec<_>, Vec<_>) =
        open.filter_map(|c| Some((c, cost(c)?))).partition(|(c, _)| c.overflow.is_none());
    if open.is_empty() {
        let reason = overflowed.first().and_then(|(c, _)| c.overflow.clone());
        return Err(reason.map_or(TradeError::NotCounted, |reason| TradeError::Overflow { reason }));
    }
    let error = |c: &Candidate| c.error.most_99;
    let found = match goal {
        Goal::Error(most, _) => open.iter().filter(|(c, _)| error(c) <= *most).min_by(|(_, a), (_, b)| a.total_cmp(b)),
        Goal::Deadline { time, clock } => {
            let within = open.iter().filter(|(_, cost)| *cost <= time * clock);
            within.min_by(|(a, x), (b, y)| error(a).total_cmp(&error(b)).then(x.total_cmp(y)))
        }
    };
    let (candidate, cost) = found.ok_or_else(|| nearest(goal, &open))?;
    let clock = if let Goal::Deadline { clock, .. } = goal { Some(*clock) } else { None };
    Ok(Choice {
        model: candidate.model.clone(),
        precision,
        error: error(candidate),
        cost: *cost,
        unit: if target == Target::CortexM4f { "cycles" } else { "ns" },
        seconds: clock.map(|clock| cost / clock),
    })
}

/// Returns the error with the goal that the nearest candidate meets.
fn nearest(goal: &Goal, open: &[(&Candidate, f64)]) -> TradeError {
    match goal {
        Goal::Error(most, _) => {
            let least = open.iter().map(|(c, _)| c.error.most_99).fold(f64::INFINITY, f64::min);
            TradeError::Error { found: *most, least }
        }
        Goal::Deadline { time, clock } => {
            let least = open.iter().map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
            TradeError::Deadline { found: *time, clock: *clock, least: least / clock }
        }
    }
}
