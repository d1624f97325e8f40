//! Data of the figures of a diagnosis: force rose, full spectra of the unexplained force, motion with and without the fault.
//!
//! All are computed from the force that the fitted machine without this fault leaves unexplained below the highest line in use.

use super::fit::{Fitted, changed};
use super::force_rose::{HARMONICS, Instant, STEPS, direction_deg, energy, mean_pass};
use super::machine::Machine;
use super::motion::{C, D};
use super::residual::{Evidence, MEAN_LINES};
use super::surface::Component;
use super::{DiagnosisInput, Result};
use ballrace::{BearingKinematicState, Phase};
use ballrace_outcome::{FaultMotion, ForceRose, ForceSpectrum, ReferenceFrame, UnexplainedMotion};
use ballrace_plant::probes;
use ballrace_scene::Probe;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Largest number of points of a spectrum.
const SPECTRUM_POINTS: usize = 600;
/// Largest number of points of a motion.
const MOTION_POINTS: usize = 1200;
/// Number of intervals between the points of the mean pass.
const PASS_POINTS: usize = 360;
/// Least value of the window at which the force is computed from its product with the window.
const MIN_WINDOW: f64 = 0.3;
/// Harmonics of the family that a spectrum shows.
const SHOWN_HARMONICS: f64 = 5.0;
/// Highest order in the spectrum of a fault without lines of its own.
const SHOWN_ORDERS: f64 = 12.0;
/// Largest number of marked lines in a spectrum, and their least share of the strongest line.
const MARKED: (usize, f64) = (10, 0.1);
/// Lines closer than this, in orders, are one.
const APART: f64 = 0.15;
/// Ball diameter over pitch diameter of a drawing where the scene has no geometry.
const USUAL_BALL: f64 = 0.2;

/// A fault with the machines that have it and lack it.
pub(crate) struct Contrast<'a, 'b> {
    input: &'a DiagnosisInput<'b>,
    e: &'a Evidence<'b>,
    pub machine: &'a Machine,
    /// Bearing and component of the damaged surface, for a fault of one.
    surface: Option<(usize, Component)>,
    /// Bearing of the fault; `None` if the rotor has it.
    bearing: Option<usize>,
    grid: Grid,
    /// Unexplained force without and with the fault, as spectra about the centre of mass.
    without: [Vec<C>; D],
    with: [Vec<C>; D],
}

impl<'a, 'b> Contrast<'a, 'b> {
    /// Creates the contrast of a fault at a surface or another place: `last` is the fitted machine with it, `lacking` without it.
    pub(super) fn new(
        input: &'a DiagnosisInput<'b>,
        e: &'a Evidence<'b>,
        last: &'a Fitted,
        lacking: &Machine,
        surface: Option<(usize, Component)>,
        bearing: Option<usize>,
    ) -> Result<Self> {
        let lacking = changed(e, last, lacking)?;
        // The force that is missing has the opposite sign of the force that is left over.
        let missing = |of: &Fitted| e.force(&of.spectra).map(|line| line.iter().map(|f| -f).collect::<Vec<C>>());
        Ok(Self {
            input,
            e,
            machine: &last.machine,
            surface,
            bearing,
            grid: Grid::new(e),
            without: missing(&lacking),
            with: missing(last),
        })
    }

    fn speed(&self) -> f64 {
        self.e.motion.mean_speed()
    }

    /// Highest order of the shaft in use.
    fn highest_order(&self) -> f64 {
        self.e.transform.lines.last().copied().unwrap_or(0.0) / self.speed().abs()
    }

    /// Cage speed over shaft speed.
    fn cage_ratio(&self, b: usize) -> f64 {
        self.e.plant.bearings[b].kinematics.cage_ratio * (1.0 - self.machine.bearings[b].cage.slip)
    }

    /// Azimuth of the first element, rad.
    fn cage_angle(&self, b: usize, turns: f64) -> f64 {
        let first = self.e.plant.bearings[b].element_azimuths.first().map_or(0.0, |a| a.radians());
        let rolling = self.e.plant.bearings[b].kinematics.cage_ratio;
        TAU * self.machine.bearings[b].cage.revolutions(rolling, turns, &self.e.motion) + first
    }

    /// Spin of the balls over shaft speed.
    fn ball_ratio(&self, b: usize) -> f64 {
        self.e.plant.bearings[b].kinematics.ball_ratio() * (1.0 - self.machine.bearings[b].cage.spin_slip)
    }

    /// Speed of a frame over shaft speed.
    fn frame_ratio(&self, b: usize, frame: ReferenceFrame) -> f64 {
        match frame {
            ReferenceFrame::Fixed => 0.0,
            ReferenceFrame::Shaft => 1.0,
            ReferenceFrame::Cage => self.cage_ratio(b),
        }
    }

    /// Angle of a frame, rad.
    fn frame_angle(&self, b: usize, frame: ReferenceFrame, turns: f64) -> f64 {
        match frame {
            ReferenceFrame::Fixed => 0.0,
            ReferenceFrame::Shaft => TAU * turns,
            ReferenceFrame::Cage => self.cage_angle(b, turns),
        }
    }

    /// Bearing, component and order of the lines of a damaged surface.
    fn lines(&self) -> Option<(usize, Component, f64)> {
        let (b, component) = self.surface?;
        let elements = self.e.plant.bearings[b].elements;
        Some((b, component, component.order(elements, self.cage_ratio(b), self.ball_ratio(b).abs())))
    }

    /// Returns `F_X + i F_Y` at the bearing of the fault under the window, without its mean; about the centre of mass where the
    /// fault has no bearing.
    fn plane_force(&self, force: &[Vec<C>; D]) -> Vec<C> {
        let [x, y] = at_bearing(self.e, self.bearing, force);
        self.grid.plane(&x, &y, MEAN_LINES)
    }

    /// Force of the mean pass of an element over the damage at an azimuth of its component, rad.
    pub fn rose(&self, azimuth: f64) -> Option<ForceRose> {
        let (b, component, order) = self.lines()?;
        let frame = component.frame();
        let force = self.plane_force(&self.without);
        let mounted = &self.e.plant.bearings[b];
        let n = mounted.elements as f64;
        let spin_phase = self.machine.bearings[b].cage.spin_phase;
        let instant = |(i, (force, &turns)): (usize, (&C, &f64))| {
            let window = self.e.transform.window_at(i as f64 / self.grid.turns.len() as f64);
            let at = BearingKinematicState {
                inner: Phase::from_revolutions(turns),
                cage: Phase::from_radians(self.cage_angle(b, turns)),
                ball: Phase::from_revolutions(spin_phase + self.ball_ratio(b) * turns),
                ..BearingKinematicState::default()
            };
            (window > MIN_WINDOW).then(|| Instant { force: force / window, at })
        };
        let instants = force.iter().zip(&self.grid.turns).enumerate().filter_map(instant);
        let harmonics = ((self.highest_order() - 1.0) / order).clamp(1.0, HARMONICS as f64) as usize;
        let pass = mean_pass(instants, mounted.elements, component, harmonics)?;
        let first = mounted.element_azimuths.first().map_or(0.0, |a| a.radians());
        let start = if frame == ReferenceFrame::Cage { 0.0 } else { self.cage_angle(b, self.middle_turn()) };
        let diameters = self.machine.bearings[b].scene.diameters();
        Some(ForceRose {
            frame,
            energy: energy(&pass),
            direction_deg: direction_deg(&pass),
            pass: pass_by_angle(&pass, azimuth, if component == Component::Ball { 2.0 } else { n }),
            peak_n: pass.iter().map(|f| f.norm()).fold(0.0, f64::max),
            passes: order * (self.grid.turns[self.grid.turns.len() - 1] - self.grid.turns[0]).abs(),
            element_azimuths: mounted.element_azimuths.iter().map(|a| start + a.radians() - first).collect(),
            ball_over_pitch: diameters.map_or(USUAL_BALL, |[element, pitch]| element / pitch),
        })
    }

    /// Full spectra of the force: in the frames of the components of the bearing, or in the fixed one where no surface is damaged.
    pub fn spectra(&self) -> Vec<ForceSpectrum> {
        let (without, with) = (self.plane_force(&self.without), self.plane_force(&self.with));
        let added: Vec<C> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
        let Some((b, component, order)) = self.lines() else {
            return vec![self.spectrum(ReferenceFrame::Fixed, [&without, &added], &|_| 0.0, SHOWN_ORDERS)];
        };
        let own = component.frame();
        let frames = [ReferenceFrame::Fixed, ReferenceFrame::Shaft, ReferenceFrame::Cage];
        let one = |frame: ReferenceFrame| {
            let angle = |turns: f64| self.frame_angle(b, frame, turns);
            let spectrum = self.spectrum(frame, [&without, &added], &angle, SHOWN_HARMONICS * order + 2.0);
            ForceSpectrum { is_of_component: frame == own, ..spectrum }
        };
        let is_known = |frame: &ReferenceFrame| *frame == ReferenceFrame::Fixed || self.frame_ratio(b, *frame) != 0.0;
        frames.into_iter().filter(is_known).map(one).collect()
    }

    fn spectrum(
        &self,
        frame: ReferenceFrame,
        [without, added]: [&[C]; 2],
        angle: &dyn Fn(f64) -> f64,
        shown: f64,
    ) -> ForceSpectrum {
        let shown = shown.min(self.highest_order());
        let sign = self.speed().signum();
        let bin = self.e.transform.lines[1] / self.speed().abs();
        let full = |force: &[C]| {
            let turned = force.iter().zip(&self.grid.turns).map(|(f, turns)| f * C::from_polar(1.0, -angle(*turns)));
            self.grid.amplitudes(turned.collect(), sign * bin, shown)
        };
        let (unexplained, explained) = (full(without), full(added));
        let lines = strongest(&explained);
        let thin = |points: &[(f64, f64)]| peaks(points, SPECTRUM_POINTS);
        ForceSpectrum {
            frame,
            is_of_component: false,
            unexplained: thin(&unexplained),
            explained: thin(&explained),
            lines,
        }
    }

    /// A keyphasor pulse in the middle of the record, in total revolutions.
    fn middle_turn(&self) -> f64 {
        let turns = &self.e.motion.turns;
        turns[turns.len() / 2].round()
    }

    /// Motion over two revolutions at the probe whose unexplained motion the fault lowers most, in units of its noise.
    pub fn motion(&self) -> Option<FaultMotion> {
        let motion = &self.e.motion;
        let middle = self.middle_turn();
        let displacements = [&self.without, &self.with].map(|force| self.e.displacement_by(force));
        let fall = |probe: &Probe| {
            let [without, with, noise] = self.unexplained_rms(&probes::row(probe), &displacements);
            (without * without - with * with) / (noise * noise)
        };
        let all = self.input.probes.iter().enumerate().map(|(i, probe)| (fall(probe), i, probe));
        let (_, i, probe) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let row = probes::row(probe);
        let within: Vec<usize> = (0..motion.len()).filter(|&t| (motion.turns[t] - middle).abs() <= 1.0).collect();
        let stride = within.len().div_ceil(MOTION_POINTS).max(1);
        let shown: Vec<usize> = within.into_iter().step_by(stride).collect();
        let [without, with] = displacements.each_ref().map(|x| self.grid.reading(&row, x));
        let at = |series: &[f64], t: usize| interpolated(series, t as f64 / motion.len() as f64);
        let measured = |t: usize| self.input.samples[t].row.probes[i];
        let um = |of: &dyn Fn(usize) -> f64| shown.iter().map(|&t| 1e6 * of(t)).collect::<Vec<f64>>();
        let rms = self.unexplained_rms(&row, &displacements).map(|rms| 1e6 * rms);
        Some(FaultMotion {
            probe: probe.column.clone(),
            revolutions: shown.iter().map(|&t| 1.0 + self.speed().signum() * (motion.turns[t] - middle)).collect(),
            measured: um(&measured),
            without: um(&|t| measured(t) - at(&without, t)),
            with: um(&|t| measured(t) - at(&with, t)),
            unexplained: UnexplainedMotion::new(&probe.column, rms),
        })
    }

    /// Returns the rms of the unexplained motion at a probe over the record without the fault, with it, and by the noise of the probes, m.
    ///
    /// By Parseval's theorem the sum over the window `w` of `N` samples is `sum |X_k|^2 / N`, over the lines of both signs; noise with
    /// the standard deviation `s` has `|X_k|^2 = s^2 sum w^2`.
    fn unexplained_rms(&self, row: &[f64; D], displacements: &[[Vec<C>; D]; 2]) -> [f64; 3] {
        let (samples, lines) = (self.e.motion.len() as f64, self.e.transform.lines.len());
        let rms = |x: &[Vec<C>; D]| {
            let square = |k: usize| row.iter().zip(x).map(|(a, x)| x[k] * *a).sum::<C>().norm_sqr();
            let both_signs = |k: usize| if k == 0 { 1.0 } else { 2.0 };
            let sum: f64 = (0..lines).map(|k| both_signs(k) * square(k)).sum();
            (sum / (samples * self.e.transform.power)).sqrt()
        };
        let [without, with] = displacements.each_ref().map(rms);
        [without, with, self.e.reading_noise(row) * ((2 * lines - 1) as f64 / samples).sqrt()]
    }
}

/// Returns the mean pass by the angle from the damage, with `per_turn` passes in a turn.
fn pass_by_angle(pass: &[C], azimuth: f64, per_turn: f64) -> Vec<[f64; 3]> {
    let towards = C::from_polar(1.0, -direction_deg(pass).to_radians());
    let point = |i: usize| {
        // From half a period before the damage to half a period after it.
        let share = i as f64 / PASS_POINTS as f64 - 0.5;
        let step = (share + azimuth * per_turn / TAU).rem_euclid(1.0) * STEPS as f64;
        let force = pass[step as usize % pass.len()] * towards;
        [360.0 * share / per_turn, force.re, force.im]
    };
    (0..=PASS_POINTS).map(point).collect()
}

/// Returns the radial force along X and Y at a bearing.
///
/// A force about the centre of mass determines the radial forces at two stations:
/// `F_b = (M_Y - z_o F_X, -M_X - z_o F_Y) / (z_b - z_o)`. With another number of bearings, the whole force is assigned to one.
pub(super) fn at_bearing(e: &Evidence, bearing: Option<usize>, force: &[Vec<C>; D]) -> [Vec<C>; 2] {
    let whole = || [force[0].clone(), force[1].clone()];
    let (Some(b), [first, second]) = (bearing, e.plant.bearings.as_slice()) else { return whole() };
    let (own, other) = if b == 0 { (first.station, second.station) } else { (second.station, first.station) };
    let span = own - other;
    if span == 0.0 {
        return whole();
    }
    let part =
        |of: &[C], moment: &[C], sign: f64| of.iter().zip(moment).map(|(f, m)| (m * sign - f * other) / span).collect();
    [part(&force[0], &force[4], 1.0), part(&force[1], &force[3], -1.0)]
}

/// A grid in time on which band-limited series are represented.
struct Grid {
    /// Samples of the record.
    samples: usize,
    /// Total revolutions of the shaft at each point.
    turns: Vec<f64>,
    /// Sum of the window over the points.
    window: f64,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl Grid {
    fn new(e: &Evidence) -> Self {
        let count = (8 * e.transform.lines.len()).next_power_of_two();
        let samples = e.motion.len();
        let turns = (0..count).map(|i| interpolated(&e.motion.turns, i as f64 / count as f64)).collect();
        let mut planner = FftPlanner::new();
        Self {
            samples,
            turns,
            window: e.transform.sum() * count as f64 / samples as f64,
            forward: planner.plan_fft_forward(count),
            inverse: planner.plan_fft_inverse(count),
        }
    }

    /// Returns `x + i y` of two real series from their spectra, without the `skipped` lowest lines.
    fn plane(&self, x: &[C], y: &[C], skipped: usize) -> Vec<C> {
        let count = self.turns.len();
        let mut all = vec![C::new(0.0, 0.0); count];
        for (k, (x, y)) in x.iter().zip(y).enumerate().skip(skipped) {
            all[k] = (x + C::i() * y) / self.samples as f64;
            if k > 0 {
                all[count - k] = (x.conj() + C::i() * y.conj()) / self.samples as f64;
            }
        }
        self.inverse.process(&mut all);
        all
    }

    /// Returns the reading of a probe by a displacement of the centre of mass with these spectra.
    fn reading(&self, row: &[f64; D], displacement: &[Vec<C>; D]) -> Vec<f64> {
        let lines = displacement[0].len();
        let along = |k: usize| row.iter().zip(displacement).map(|(a, x)| x[k] * *a).sum::<C>();
        let x: Vec<C> = (0..lines).map(along).collect();
        self.plane(&x, &vec![C::new(0.0, 0.0); lines], 0).iter().map(|x| x.re).collect()
    }

    /// Returns order and peak amplitude of the lines of a complex series; `bin` is the order of the first line, negative where
    /// forward precession has negative frequencies.
    fn amplitudes(&self, mut series: Vec<C>, bin: f64, highest: f64) -> Vec<(f64, f64)> {
        self.forward.process(&mut series);
        let count = series.len() as isize;
        let half = ((highest / bin.abs()) as isize).min(count / 2 - 1);
        let point = |k: isize| {
            let line = if bin > 0.0 { k } else { -k };
            (k as f64 * bin.abs(), series[line.rem_euclid(count) as usize].norm() / self.window)
        };
        (-half..=half).map(point).collect()
    }
}

/// Returns the value of a series at a share of its length.
fn interpolated(series: &[f64], share: f64) -> f64 {
    let at = share * series.len() as f64;
    let i = (at as usize).min(series.len() - 2);
    series[i] + (at - i as f64) * (series[i + 1] - series[i])
}

/// Returns at most `limit` points: the highest of each run.
fn peaks(points: &[(f64, f64)], limit: usize) -> Vec<(f64, f64)> {
    let run = points.len().div_ceil(limit).max(1);
    points.chunks(run).filter_map(|run| run.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))).collect()
}

/// Returns the orders of the strongest lines, strongest first.
fn strongest(points: &[(f64, f64)]) -> Vec<f64> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
    let least = MARKED.1 * sorted.first().map_or(0.0, |point| point.1);
    let mut lines: Vec<f64> = vec![];
    for (order, _) in sorted.into_iter().take_while(|point| point.1 > least) {
        if lines.len() == MARKED.0 {
            break;
        }
        if order.abs() > APART && lines.iter().all(|other| (other - order).abs() > APART) {
            lines.push(order);
        }
    }
    lines
}
