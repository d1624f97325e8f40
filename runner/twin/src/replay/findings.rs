//! Diagnosis: lines of the residual that the twin does not explain, and the verdict as a sentence.

use super::attribution::LineAttribution;
use super::comparison::Comparison;
use super::lines::{INNER_HARMONICS, OUTER_HARMONICS, inner_line, outer_line};
use crate::baseline::Baseline;
use crate::outcome::{Finding, FindingKind, ProbeOutcome, Standing};
use crate::plant::MountedBearing;
use crate::scene::{Direction, Probe};

const UM: f64 = 1e6;
/// Smallest level of a line over the residual around it, dB.
const LEAST_LEVEL_DB: f64 = 12.0;
/// Smallest share of the residual's energy in a family of lines.
const LEAST_SHARE: f64 = 0.2;
/// Smallest share of a family over that of the strongest. Weaker families are intermodulation in the nonlinear bearings.
const LEAST_OF_STRONGEST: f64 = 0.5;

/// A family of lines: the orders of one fault.
struct Family {
    kind: FindingKind,
    bearing: Option<usize>,
    order: f64,
    /// (index of the followed line, its order)
    lines: Vec<(usize, f64)>,
}

/// Data for the diagnosis.
pub struct Evidence<'a> {
    /// The scene's probes.
    pub probes: &'a [Probe],
    /// The bearings.
    pub mounted: &'a [MountedBearing],
    /// Comparison of the readings with the twin.
    pub comparison: &'a Comparison,
    /// Attribution of lines to one of two bearings.
    pub attribution: Option<&'a LineAttribution>,
    /// Residual of the sound machine, where it is known.
    pub baseline: Option<&'a Baseline>,
    /// Mean shaft speed, Hz.
    pub speed_hz: f64,
    /// Samples per second.
    pub rate: f64,
}

/// Returns the findings, strongest first.
#[must_use]
pub fn findings(evidence: &Evidence) -> Vec<Finding> {
    let total = energy(evidence, |probe| evidence.comparison.residual_rms_about_mean(probe).powi(2));
    if total == 0.0 || is_quiet(evidence) {
        return vec![];
    }
    let mut judged: Vec<(f64, Finding)> =
        families(evidence.mounted).iter().filter_map(|family| judge(evidence, family, total)).collect();
    judged.sort_by(|a, b| b.0.total_cmp(&a.0));
    let strongest = judged.first().map_or(0.0, |j| j.0);
    judged.into_iter().filter(|(share, _)| *share >= LEAST_OF_STRONGEST * strongest).map(|(_, f)| f).collect()
}

/// Returns true where the residual is explained by probe noise or is that of the baseline.
fn is_quiet(evidence: &Evidence) -> bool {
    let within = |(i, p): (usize, &Probe)| {
        let usual = evidence.baseline.map_or(0.0, |b| b.residual(i)).max(p.noise.unwrap_or(0.0));
        evidence.comparison.residual_rms_about_mean(i) <= 1.5 * usual
    };
    evidence.probes.iter().enumerate().all(within)
}

fn radial(probe: &Probe) -> bool {
    probe.direction != Direction::Axial
}

fn energy(evidence: &Evidence, of: impl Fn(usize) -> f64) -> f64 {
    evidence.probes.iter().enumerate().filter(|(_, p)| radial(p)).map(|(i, _)| of(i)).sum()
}

fn families(mounted: &[MountedBearing]) -> Vec<Family> {
    let mut families = vec![Family { kind: FindingKind::Unbalance, bearing: None, order: 1.0, lines: vec![(0, 1.0)] }];
    for (i, bearing) in mounted.iter().enumerate().filter(|(_, s)| s.kinematics.cage_ratio != 0.0) {
        let orders = bearing.kinematics.orders;
        let harmonics = |count: i32, order: f64, index: fn(usize, i32) -> usize| {
            (1..=count).map(|k| (index(i, k), f64::from(k) * order)).collect()
        };
        families.push(Family {
            kind: FindingKind::OuterRace,
            bearing: Some(i),
            order: orders.outer_race,
            lines: harmonics(OUTER_HARMONICS, orders.outer_race, outer_line),
        });
        families.push(Family {
            kind: FindingKind::InnerRace,
            bearing: Some(i),
            order: orders.inner_race,
            lines: harmonics(INNER_HARMONICS, orders.inner_race, inner_line),
        });
    }
    families
}

fn judge(evidence: &Evidence, family: &Family, total: f64) -> Option<(f64, Finding)> {
    let suspects = match origin(evidence, family) {
        Origin::Elsewhere => return None,
        Origin::Here => family.bearing.into_iter().collect(),
        Origin::OneOf(bearings) => bearings,
    };
    let names: Vec<&str> = suspects.iter().map(|&b| evidence.mounted[b].name.as_str()).collect();
    let amplitude = |line: usize, probe: usize| evidence.comparison.residual_line(line, probe);
    let share = energy(evidence, |p| family.lines.iter().map(|l| 0.5 * amplitude(l.0, p).powi(2)).sum()) / total;
    let strongest = evidence
        .probes
        .iter()
        .enumerate()
        .filter(|(_, p)| radial(p))
        .flat_map(|(p, _)| family.lines.iter().map(move |l| (p, *l)))
        .max_by(|a, b| amplitude(a.1.0, a.0).total_cmp(&amplitude(b.1.0, b.0)))?;
    let (probe, (line, order)) = strongest;
    let size = amplitude(line, probe);
    let usual = evidence.baseline.map_or(0.0, |b| b.line(line, probe));
    let level_db = 20.0 * (size / background(evidence, probe, order).max(usual).max(1e-15)).log10();
    if share < LEAST_SHARE || level_db < LEAST_LEVEL_DB {
        return None;
    }
    let line_hz = family.order * evidence.speed_hz;
    // The bearing is named only where it is unambiguous.
    let bearing = (names.len() == 1).then(|| names.concat());
    let where_seen = &evidence.probes[probe].column;
    let sentence = format!(
        "{}: the residual stands at {:.1} Hz ({:.2} per turn{}), {:.2} um on {where_seen}, {level_db:.0} dB above {}, {:.0} % of the residual's energy.",
        fault_name(family.kind, &names.join(" or ")),
        line_hz,
        family.order,
        if family.lines.len() > 1 { " and multiples" } else { "" },
        size * UM,
        if evidence.baseline.is_some() { "the baseline" } else { "what is around it" },
        100.0 * share.min(1.0),
    );
    let confidence = share.min(1.0) * (1.0 - 10_f64.powf(-level_db / 20.0));
    let finding = Finding { kind: family.kind, bearing, line_hz, order: family.order, level_db, confidence, sentence };
    Some((share, finding))
}

fn fault_name(kind: FindingKind, bearings: &str) -> String {
    let of = if bearings.is_empty() { String::new() } else { format!(" of {bearings}") };
    match kind {
        FindingKind::Unbalance => "Unbalance other than the scene's".to_owned(),
        FindingKind::OuterRace => format!("Outer race{of}"),
        FindingKind::InnerRace => format!("Inner race{of}"),
        other => format!("{other:?}{of}"),
    }
}

/// Origin of the lines of a family.
enum Origin {
    /// This bearing.
    Here,
    /// Another bearing with the same lines.
    Elsewhere,
    /// One of several with the same lines; reported once, for the first of them.
    OneOf(Vec<usize>),
}

/// Smallest ratio of the unexplained forces of two bearings from which one is named.
const CLEAR_RATIO: f64 = 2.0;

fn origin(evidence: &Evidence, family: &Family) -> Origin {
    let Some(own) = family.bearing else { return Origin::Here };
    let order = |b: usize| match family.kind {
        FindingKind::InnerRace => evidence.mounted[b].kinematics.orders.inner_race,
        _ => evidence.mounted[b].kinematics.orders.outer_race,
    };
    let moving = |b: &usize| evidence.mounted[*b].kinematics.cage_ratio != 0.0;
    let same: Vec<usize> =
        (0..evidence.mounted.len()).filter(moving).filter(|&b| (order(b) - order(own)).abs() < 0.05).collect();
    if same == [own] {
        return Origin::Here;
    }
    match evidence.attribution.and_then(|l| l.unexplained(family.lines.iter().map(|l| l.0))) {
        Some(force) if force[own] > CLEAR_RATIO * force[1 - own] => Origin::Here,
        Some(force) if force[1 - own] > CLEAR_RATIO * force[own] => Origin::Elsewhere,
        _ if same.first() == Some(&own) => Origin::OneOf(same),
        _ => Origin::Elsewhere,
    }
}

/// Returns the noise amplitude of the residual around an order in a block of the order tracking: the median of the spectrum
/// within one order, converted from the length of the spectrum to that of the block.
fn background(evidence: &Evidence, probe: usize, order: f64) -> f64 {
    let n = evidence.probes.len();
    let spectrum = evidence.comparison.spectra.half(2 * n + probe);
    let bin = evidence.comparison.spectra.bin(evidence.rate);
    if bin == 0.0 || evidence.speed_hz == 0.0 {
        return 0.0;
    }
    let at = |order: f64| (order * evidence.speed_hz / bin).round().max(1.0) as usize;
    let last = spectrum.len().saturating_sub(1);
    let range = at(order - 1.0).min(last)..=at(order + 1.0).min(last);
    let mut around: Vec<f64> = spectrum.get(range).unwrap_or_default().to_vec();
    around.sort_by(f64::total_cmp);
    let median = around.get(around.len() / 2).copied().unwrap_or(0.0);
    let block = super::lines::BLOCK_TURNS / evidence.speed_hz;
    median * (1.0 / (bin * block)).sqrt()
}

/// Returns the root mean square of a figure over the probes; none where a probe lacks it.
fn rms(probes: &[ProbeOutcome], of: impl Fn(&ProbeOutcome) -> Option<f64>) -> Option<f64> {
    let values: Option<Vec<f64>> = probes.iter().map(of).collect();
    values.map(|values| (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt())
}

/// Returns true where the twin is as good as any simpler predictor, or its residual is noise.
#[must_use]
pub fn follows(probes: &[ProbeOutcome]) -> bool {
    let residual = rms(probes, |p| Some(p.residual_rms_um)).unwrap_or(0.0);
    let at_noise = rms(probes, |p| p.noise_um).is_some_and(|noise| residual <= 1.5 * noise);
    at_noise || probes.iter().all(|p| p.baselines.worst() != Standing::Worse)
}

/// Returns the verdict as a sentence: why there is none, else the strongest finding, else whether the twin follows.
#[must_use]
pub fn verdict(
    findings: &[Finding],
    probes: &[ProbeOutcome],
    implausible: &[String],
    not_judged: &[String],
    out_of_range: u64,
) -> String {
    if !implausible.is_empty() {
        return format!(
            "The recording is not plausible for the scene: {}. Nothing is diagnosed.",
            implausible.join("; ")
        );
    }
    if !not_judged.is_empty() {
        return format!("No verdict: {}.", not_judged.join("; "));
    }
    let left_out = match out_of_range {
        0 => String::new(),
        1 => " 1 sample with a reading out of range is left out.".to_owned(),
        count => format!(" {count} samples with a reading out of range are left out."),
    };
    let verdict = judged(findings, probes);
    format!("{verdict}{left_out}")
}

fn judged(findings: &[Finding], probes: &[ProbeOutcome]) -> String {
    if let Some(worst) = findings.first() {
        return format!("The machine departs from its twin. {}", worst.sentence);
    }
    let (residual, noise) = (rms(probes, |p| Some(p.residual_rms_um)).unwrap_or(0.0), rms(probes, |p| p.noise_um));
    let against = noise.map_or(String::new(), |noise| format!(", {:.2} times the probe noise", residual / noise));
    let count = |standing| probes.iter().filter(|p| p.baselines.worst() == standing).count();
    let (better, worse) = (count(Standing::Better), count(Standing::Worse));
    let follows = if follows(probes) { "follows" } else { "does not follow" };
    let rivals = if better == probes.len() {
        "it beats all four simpler predictors on every probe".to_owned()
    } else if worse == 0 {
        format!(
            "no simpler predictor does better, and on {} of {} probes one does as well",
            probes.len() - better,
            probes.len()
        )
    } else {
        format!("a simpler predictor does better on {worse} of {} probes", probes.len())
    };
    format!(
        "The twin {follows} the machine: residual {residual:.3} um rms{against}; {rivals}; no line stands out of the residual."
    )
}
