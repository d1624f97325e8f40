//! Lines that a surface imperfection leaves in the unexplained force, and the imperfection that fits them.
//!
//! A deviation `p` of a surface changes the deflection of the ball at azimuth `b` and so the force by `K(b) p`, with `K` the
//! change of force per deflection of a ball there. With the Fourier series `K = sum K_l e^(i l b)` and `p = sum P_m e^(i m psi)`
//! the sum over N balls leaves `l + m = k N` only:
//!
//! | surface | force |
//! | --- | --- |
//! | outer race | `N K_l P_(kN-l) e^(i k N c)` |
//! | inner race | `N K_l P_(kN-l) e^(i k N (c - s)) e^(i l s)` |
//! | one ball | `2 K_l P_h e^(i h b) e^(i l c)`, h even |
//! | all balls alike | `2 N K_0 P_h e^(i h b)`, h even |
//!
//! with c, s, b the angles of cage, shaft and ball. `K_l` is evaluated along the measured motion, sample by sample.

use super::Result;
use super::fit::Fitted;
use super::machine::Machine;
use super::motion::{C, D};
use super::residual::{Evidence, MEAN_LINES};
use ballrace::Phase;
use ballrace_base::statistics::median;
use ballrace_outcome::{FaultKind, ReferenceFrame};
use ballrace_scene::{Defect, DefectShape, Surface};
use nalgebra::{SMatrix, SVector};
use std::f64::consts::{PI, TAU};

/// Azimuths at which the force per deflection is evaluated.
const AZIMUTHS: usize = 8;
/// Highest harmonic of the force per deflection around the ring.
const L: i32 = 2;
/// Columns of one harmonic of a family: l from -L to L.
const WIDTH: usize = 2 * L as usize + 1;
/// Real values of its amplitudes.
const VALUES: f64 = 2.0 * WIDTH as f64;
/// Harmonics of a family.
const HARMONICS: usize = 10;
/// Half widths of a spall that are tried, rad.
const HALF_WIDTHS: [f64; 7] = [0.02, 0.03, 0.045, 0.065, 0.1, 0.15, 0.22];
/// Number of spall positions that are tried.
const CENTRES: usize = 48;
/// Angles of the cage within a pitch that are tried.
const PHASES: usize = 48;

/// Component of a bearing whose surface has an imperfection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    Outer,
    Inner,
    Ball,
}

impl Component {
    pub const ALL: [Self; 3] = [Self::Outer, Self::Inner, Self::Ball];

    /// Returns the kind of a fault of the surface.
    pub fn kind(self) -> FaultKind {
        match self {
            Self::Outer => FaultKind::OuterRace,
            Self::Inner => FaultKind::InnerRace,
            Self::Ball => FaultKind::Element,
        }
    }

    /// Returns the frame in which the component is stationary.
    pub fn frame(self) -> ReferenceFrame {
        match self {
            Self::Outer => ReferenceFrame::Fixed,
            Self::Inner => ReferenceFrame::Shaft,
            Self::Ball => ReferenceFrame::Cage,
        }
    }

    /// Returns the order of the lines of a damaged surface from the speeds of cage and balls over shaft speed.
    pub fn order(self, elements: usize, cage_ratio: f64, ball_ratio: f64) -> f64 {
        match self {
            Self::Outer => elements as f64 * cage_ratio,
            Self::Inner => elements as f64 * (1.0 - cage_ratio),
            Self::Ball => 2.0 * ball_ratio,
        }
    }
}

/// Series on a coarse grid in time, from their spectra within a band about 0.
pub struct Coarse {
    /// Values under the window, one per coarse sample.
    pub values: Vec<[C; D]>,
}

/// Transforms between coarse samples and lines about a carrier.
pub(crate) struct Baseband {
    half_width: usize,
    count: usize,
    forward: std::sync::Arc<dyn rustfft::Fft<f64>>,
    /// Total revolutions of the shaft at the coarse samples.
    turns: Vec<f64>,
}

impl Baseband {
    /// Creates a band of `orders` orders of the shaft on each side of a carrier.
    pub fn new(e: &Evidence, orders: f64) -> Self {
        let bin = e.transform.lines[1];
        let half_width = (orders * e.motion.mean_speed().abs() / bin).ceil() as usize;
        let count = (4 * half_width).next_power_of_two();
        let n = e.motion.len();
        let turns = (0..count)
            .map(|i| {
                let at = i as f64 * n as f64 / count as f64;
                let k = (at as usize).min(n - 2);
                e.motion.turns[k] + (at - k as f64) * (e.motion.turns[k + 1] - e.motion.turns[k])
            })
            .collect();
        Self { half_width, count, forward: rustfft::FftPlanner::new().plan_fft_forward(count), turns }
    }

    /// Decimates a series of the full rate, multiplied by the window.
    pub fn thin(&self, e: &Evidence, of: impl Fn(usize) -> [C; D]) -> Coarse {
        let inverse = rustfft::FftPlanner::new().plan_fft_inverse(self.count);
        let mut values = vec![[C::new(0.0, 0.0); D]; self.count];
        for i in 0..D {
            let all = e.transform.full(|t| of(t)[i]);
            let n = all.len();
            let mut band = vec![C::new(0.0, 0.0); self.count];
            for b in 0..=self.half_width {
                band[b] = all[b] / n as f64;
                if b > 0 {
                    band[self.count - b] = all[n - b] / n as f64;
                }
            }
            inverse.process(&mut band);
            for (v, x) in values.iter_mut().zip(&band) {
                v[i] = *x;
            }
        }
        Coarse { values }
    }

    /// Returns `e^(2 pi i order turns)` at the coarse samples.
    fn turned(&self, order: f64) -> Vec<C> {
        self.turns.iter().map(|turns| C::from_polar(1.0, TAU * (order * turns).fract())).collect()
    }

    /// Returns the carrier of an order in the band about the line nearest to `centre`, an order of the shaft; `None` if the band exceeds
    /// the lines in use.
    pub fn carrier(&self, e: &Evidence, centre: f64, order: f64) -> Option<Carrier> {
        let nearest = (centre.abs() * e.motion.mean_speed().abs() / e.transform.lines[1]).round() as usize;
        if nearest <= 2 * MEAN_LINES || nearest + self.half_width >= e.transform.lines.len() {
            return None;
        }
        let is_backward = centre < 0.0;
        let sign = if is_backward { -1.0 } else { 1.0 };
        let n = e.motion.len() as f64;
        let shift = |i: usize| {
            let turns = sign * order * self.turns[i] - nearest as f64 * i as f64 / self.count as f64;
            C::from_polar(n / self.count as f64, TAU * turns.fract())
        };
        Some(Carrier { line: nearest, is_backward, shifts: (0..self.count).map(shift).collect() })
    }

    /// Returns the residual at the probes of a force at a bearing, a series times the carrier, for the lines of the band.
    pub fn column(&self, e: &Evidence, series: &Coarse, bearing: usize, carrier: &Carrier) -> Vec<C> {
        let mut spectra: [Vec<C>; D] = Default::default();
        for (i, spectrum) in spectra.iter_mut().enumerate() {
            // A carrier of negative frequency appears conjugated at the positive one.
            let value = |v: &[C; D]| if carrier.is_backward { v[i].conj() } else { v[i] };
            *spectrum = series.values.iter().zip(&carrier.shifts).map(|(v, s)| value(v) * s).collect();
            self.forward.process(spectrum);
        }
        let mut out = Vec::with_capacity((2 * self.half_width + 1) * e.rows);
        for b in 0..=2 * self.half_width {
            let at = (b + self.count - self.half_width) % self.count;
            let line = (carrier.line + b).wrapping_sub(self.half_width);
            if line >= e.transform.lines.len() || line < MEAN_LINES {
                continue;
            }
            for row in &e.whitening_of_bearing[bearing][line] {
                out.push(row.iter().zip(&spectra).map(|(a, s)| a * s[at]).sum());
            }
        }
        out
    }

    /// Returns the part of a residual that belongs to the lines of a column about `line`.
    pub fn part(&self, e: &Evidence, residual: &[f64], line: usize) -> Vec<C> {
        let per = 2 * e.rows;
        let (first, last) = (line.saturating_sub(self.half_width).max(MEAN_LINES), line + self.half_width);
        residual[first * per..(last + 1) * per].chunks(2).map(|x| C::new(x[0], x[1])).collect()
    }
}

/// Carrier of an order of the shaft at the coarse samples, moved by the line about which its band is.
pub(crate) struct Carrier {
    pub line: usize,
    /// True for a negative frequency.
    is_backward: bool,
    shifts: Vec<C>,
}

impl Carrier {
    /// Adds the order of a factor by [`Baseband::turned`].
    fn turn(&mut self, factor: &[C]) {
        for (shift, factor) in self.shifts.iter_mut().zip(factor) {
            *shift *= if self.is_backward { factor.conj() } else { *factor };
        }
    }
}

/// Force per deflection of a ball along the motion, as harmonics around the ring.
pub(crate) struct Compliance {
    bearing: usize,
    /// l from -L to L.
    harmonics: Vec<Coarse>,
}

impl Compliance {
    pub fn new(e: &Evidence, band: &Baseband, bearing: usize, machine: &Machine) -> Result<Self> {
        const DEPTH: f64 = 1e-8;
        let zero = C::new(0.0, 0.0);
        let mut harmonics = vec![[[zero; D]; WIDTH]; e.motion.len()];
        let mut of = machine.bearings[bearing].clone();
        of.scene.defect.clear();
        let first = e.plant.bearings[bearing].element_azimuths[0].revolutions();
        for a in 0..AZIMUTHS {
            let azimuth = TAU * a as f64 / AZIMUTHS as f64;
            let mut damaged = of.clone();
            let mut dent = spall(Surface::Outer, azimuth, 0.01, DEPTH);
            dent.shape = DefectShape::Rectangular;
            damaged.scene.defect.push(dent);
            let damaged = e.evaluated_as(machine, bearing, &damaged)?;
            let cage = Phase::from_revolutions(a as f64 / AZIMUTHS as f64 - first);
            let turns: [C; WIDTH] =
                std::array::from_fn(|l| C::from_polar(1.0 / AZIMUTHS as f64, -(l as f64 - f64::from(L)) * azimuth));
            for (t, harmonics) in harmonics.iter_mut().enumerate() {
                for (i, change) in damaged.change_at_first_ball(&e.motion, t, cage).into_iter().enumerate() {
                    for (h, turn) in harmonics.iter_mut().zip(&turns) {
                        h[i] -= turn * (change / DEPTH);
                    }
                }
            }
        }
        let harmonics = (0..WIDTH).map(|l| band.thin(e, |t| harmonics[t][l])).collect();
        Ok(Self { bearing, harmonics })
    }
}

/// Normal equations of the complex amplitudes of one harmonic of a family, l from -L to L; conjugated amplitudes where the
/// carrier turns backward.
#[derive(Clone)]
struct Harmonic {
    normal: [[C; WIDTH]; WIDTH],
    right: [C; WIDTH],
    backward: bool,
}

/// A family of lines fitted to the unexplained force at one slip.
#[derive(Clone)]
pub(crate) struct Family {
    pub component: Component,
    pub bearing: usize,
    /// Slip of the cage, or of the ball's spin.
    pub slip: f64,
    pub elements: f64,
    harmonics: Vec<(usize, Harmonic)>,
}

/// Order of harmonic `k` (from 1) and side line `l` in revolutions of the shaft.
fn order(e: &Evidence, bearing: usize, component: Component, slip: f64, cage_slip: f64, k: usize, l: i32) -> f64 {
    let mounted = &e.plant.bearings[bearing];
    let n = mounted.elements as f64;
    let cage = mounted.kinematics.cage_ratio;
    let (k, l) = (k as f64, f64::from(l));
    match component {
        Component::Outer => k * n * cage * (1.0 - slip),
        Component::Inner => k * n * (cage * (1.0 - slip) - 1.0) + l,
        Component::Ball => 2.0 * k * mounted.kinematics.ball_ratio() * (1.0 - slip) + l * cage * (1.0 - cage_slip),
    }
}

/// Slips that a scan returns by each of its three scores.
const PEAKS: usize = 4;
/// Steps of a scan within which it has one peak.
const APART_STEPS: usize = 3;
/// Lines whose median is the background of each of them, and the least background, in units of the noise.
const BACKGROUND_LINES: usize = 64;
const LEAST_BACKGROUND: f64 = 0.01;
/// Energy of a line over its background from which it stands out: the number of such lines tells a spall, not the energy of two of another cause.
const STANDS_OUT: f64 = 10.0;

/// Returns the slips at which the lines of a family stand out most: by the number of its harmonics that do, as those of a spall at a site, by
/// the energy of all, and by the strongest of them, as that of a wave. The noise of a site has what sound surfaces may do at any line, so that its
/// background is far below 1.
fn scan(
    e: &Evidence,
    residual: &[f64],
    bearing: usize,
    component: Component,
    cage_slip: Option<f64>,
    [from, to]: [f64; 2],
) -> Vec<f64> {
    let lines = e.transform.lines.len();
    let per = 2 * e.rows;
    // Energy of each line and two neighbours on both sides, over that of noise.
    let square: Vec<f64> = residual.chunks(per).map(|c| c.iter().map(|x| x * x).sum()).collect();
    let around = |k: usize| {
        let range = k.saturating_sub(1)..(k + 2).min(lines);
        let count = range.len() as f64;
        square[range].iter().sum::<f64>() / (count * per as f64)
    };
    let background: Vec<f64> = square.chunks(BACKGROUND_LINES).map(|lines| median(lines).unwrap_or_default()).collect();
    let over_background = |k: usize, energy: f64| {
        let background = background[k / BACKGROUND_LINES] / per as f64;
        energy / background.max(LEAST_BACKGROUND)
    };
    let bin = e.transform.lines[1];
    let speed = e.motion.mean_speed().abs();
    let finest = 2.0 * HARMONICS as f64 * e.plant.bearings[bearing].elements as f64 * speed / bin;
    let steps = ((to - from) * finest).ceil() as usize;
    let slip = |i: usize| from + (to - from) * i as f64 / steps as f64;
    let scored = |i: usize| {
        let [mut number, mut sum, mut strongest] = [0.0, 0.0, 0.0_f64];
        for k in 1..=HARMONICS {
            let side = if component == Component::Outer { 0..=0 } else { -1..=1 };
            let at = side.map(|l| {
                let order = order(e, bearing, component, slip(i), cage_slip.unwrap_or(slip(i)), k, l).abs();
                (order * speed / bin).round() as usize
            });
            let energies = at.filter(|&at| at > 8 && at + 2 < lines).map(|at| (at, around(at)));
            let Some((at, best)) = energies.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
            number += (1.0 + over_background(at, best).min(STANDS_OUT)).ln();
            sum += (1.0 + best).ln();
            strongest = strongest.max(best);
        }
        [number, sum, strongest]
    };
    let scores: Vec<[f64; 3]> = (0..=steps).map(scored).collect();
    let mut peaks: Vec<usize> = vec![];
    for score in 0..3 {
        let mut highest: Vec<usize> = (0..=steps).collect();
        if score == 0 {
            let around = |i: usize| &scores[i.saturating_sub(APART_STEPS)..(i + APART_STEPS + 1).min(scores.len())];
            highest.retain(|&i| around(i).iter().all(|other| other[0] <= scores[i][0]));
        }
        highest.sort_by(|a, b| scores[*b][score].total_cmp(&scores[*a][score]));
        let most = peaks.len() + PEAKS;
        for i in highest {
            if peaks.len() < most && peaks.iter().all(|peak| peak.abs_diff(i) > APART_STEPS) {
                peaks.push(i);
            }
        }
    }
    peaks.into_iter().map(slip).collect()
}

impl Family {
    /// Fits free amplitudes at a slip.
    pub fn new(
        e: &Evidence,
        band: &Baseband,
        residual: &[f64],
        compliance: &Compliance,
        component: Component,
        slip: f64,
        cage_slip: f64,
    ) -> Self {
        let bearing = compliance.bearing;
        let n = e.plant.bearings[bearing].elements as f64;
        let weight = if component == Component::Ball { 2.0 } else { n };
        let order = |k: usize, l: i32| order(e, bearing, component, slip, cage_slip, k, l);
        // The side lines of every harmonic are this far apart.
        let apart = order(1, 1) - order(1, 0);
        let factor = band.turned(apart);
        let mut harmonics = vec![];
        for k in 1..=HARMONICS {
            let centre = order(k, 0);
            let Some(mut carrier) = band.carrier(e, centre, order(k, -L)) else { continue };
            let mut columns = Vec::with_capacity(WIDTH);
            for series in &compliance.harmonics {
                columns.push(band.column(e, series, bearing, &carrier));
                if apart != 0.0 {
                    carrier.turn(&factor);
                }
            }
            let part = band.part(e, residual, carrier.line);
            let product = |a: &[C], b: &[C]| a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<C>() * weight;
            let normal = std::array::from_fn(|i| std::array::from_fn(|j| product(&columns[i], &columns[j]) * weight));
            let right = std::array::from_fn(|i| -product(&columns[i], &part));
            harmonics.push((k, Harmonic { normal, right, backward: centre < 0.0 }));
        }
        Self { component, bearing, slip, elements: n, harmonics }
    }

    /// Returns the fall of chi-squared by free amplitudes of each harmonic.
    fn gains(&self) -> impl Iterator<Item = f64> {
        let of = |h: &Harmonic| {
            let normal = SMatrix::<C, WIDTH, WIDTH>::from_fn(|i, j| h.normal[i][j]);
            let ridge = SMatrix::<C, WIDTH, WIDTH>::identity() * C::new(1e-9 * normal.trace().re / WIDTH as f64, 0.0);
            let right = SVector::<C, WIDTH>::from_fn(|i, _| h.right[i]);
            (normal + ridge).lu().solve(&right).map_or(0.0, |x| x.dotc(&right).re)
        };
        self.harmonics.iter().map(move |(_, h)| of(h))
    }

    /// Returns the fall of chi-squared by free amplitudes, beyond that of noise.
    pub fn gain(&self) -> f64 {
        self.gains().map(|gain| gain - VALUES).sum()
    }

    fn scores(&self) -> Scores {
        let gains: Vec<f64> = self.gains().collect();
        Scores {
            lines: gains.iter().map(|gain| (1.0 + gain.max(0.0) / VALUES).ln()).sum(),
            gain: gains.iter().map(|gain| gain - VALUES).sum(),
            wave: self.wave().map_or(0.0, |(gain, ..)| gain),
        }
    }

    /// Order of the profile at harmonic `k` (from 1) and l.
    fn profile_order(&self, k: usize, l: usize) -> f64 {
        let l = l as f64 - f64::from(L);
        match self.component {
            Component::Ball => 2.0 * k as f64,
            _ => k as f64 * self.elements - l,
        }
    }

    /// Returns spalls with their falls of chi-squared: the best of each half width tried, best first, then the best at some angles of
    /// the cage. `known` is the angle of the cage if it is known, in pitches (for a ball: its azimuth in revolutions, except for whole
    /// pitches).
    pub fn spalls(&self, known: Option<f64>) -> Vec<(f64, SpallGuess)> {
        let is_ball = self.component == Component::Ball;
        // Balls: the two contacts make half a revolution of spin a period.
        let whole = if is_ball { PI } else { TAU };
        let count = match known {
            None => PHASES,
            Some(_) if is_ball => self.elements as usize,
            Some(_) => 1,
        };
        let phases: Vec<f64> = (0..count).map(|p| known.unwrap_or(0.0) + p as f64 / count as f64).collect();
        let larger = |best: Option<(f64, SpallGuess)>, other: Option<(f64, SpallGuess)>| match (best, other) {
            (Some(best), Some(other)) => Some(if other.0 > best.0 { other } else { best }),
            (best, other) => best.or(other),
        };
        let mut of_width = [None; HALF_WIDTHS.len()];
        let mut of_phase = vec![None; phases.len()];
        for (half_width, best) in HALF_WIDTHS.into_iter().zip(&mut of_width) {
            for c in 0..CENTRES {
                let tried = self.tried(half_width, whole * c as f64 / CENTRES as f64, &phases);
                for (tried, of_phase) in tried.into_iter().zip(&mut of_phase) {
                    *of_phase = larger(*of_phase, tried);
                    *best = larger(*best, tried);
                }
            }
        }
        let sorted = |all: &[Option<(f64, SpallGuess)>]| {
            let mut all: Vec<(f64, SpallGuess)> = all.iter().flatten().copied().collect();
            all.sort_by(|a, b| b.0.total_cmp(&a.0));
            all
        };
        let mut guesses = sorted(&of_width);
        guesses.extend(sorted(&of_phase));
        guesses
    }

    /// Returns the spalls of this width and place at each of `phases`; none where its depth would be negative.
    fn tried(&self, half_width: f64, centre: f64, phases: &[f64]) -> Vec<Option<(f64, SpallGuess)>> {
        let of = |phase: f64, (linear, quadratic): (f64, f64)| {
            let depth = linear / quadratic.max(1e-300);
            (depth > 0.0).then_some((linear * depth, SpallGuess { centre, half_width, depth, phase }))
        };
        let products = |phase: f64| {
            self.harmonics.iter().map(move |(k, h)| {
                let x = self.pattern(*k, h.backward, centre, half_width, phase);
                let linear: C = x.iter().zip(&h.right).map(|(x, r)| x.conj() * r).sum();
                let quadratic: f64 =
                    (0..WIDTH).map(|i| (x[i].conj() * (0..WIDTH).map(|j| h.normal[i][j] * x[j]).sum::<C>()).re).sum();
                (*k as f64, h.backward, linear, quadratic)
            })
        };
        if self.component == Component::Ball {
            let sums =
                |phase: f64| products(phase).fold((0.0, 0.0), |(l, q), (_, _, linear, quad)| (l + linear.re, q + quad));
            return phases.iter().map(|&phase| of(phase, sums(phase))).collect();
        }
        // A change of the cage angle shifts the phase of each harmonic as a whole.
        let at_zero: Vec<_> = products(0.0).collect();
        let quadratic: f64 = at_zero.iter().map(|p| p.3).sum();
        let linear = |phase: f64| -> f64 {
            let turned = |(k, backward, linear, _): &(f64, bool, C, f64)| {
                let angle = TAU * k * phase;
                (C::from_polar(1.0, if *backward { angle } else { -angle }) * linear).re
            };
            at_zero.iter().map(turned).sum()
        };
        phases.iter().map(|&phase| of(phase, (linear(phase), quadratic))).collect()
    }

    /// Amplitudes of a spall of depth 1 at harmonic `k`.
    fn pattern(&self, k: usize, backward: bool, centre: f64, half_width: f64, phase: f64) -> [C; WIDTH] {
        std::array::from_fn(|l| {
            let m = self.profile_order(k, l);
            let height = -half_sine(m, half_width);
            let turned = match self.component {
                Component::Ball => (l as f64 - f64::from(L)) * TAU * phase,
                _ => k as f64 * TAU * phase,
            };
            let angle = turned - m * centre;
            C::from_polar(height, if backward { -angle } else { angle })
        })
    }

    /// Returns the wave that explains most: fall of chi-squared, order and complex amplitude. A wave of the elements is the same on all,
    /// so that their sum has no side bands of the cage.
    pub fn wave(&self) -> Option<(f64, u32, C)> {
        let mut best: Option<(f64, u32, C)> = None;
        let side_bands = if self.component == Component::Ball { L as usize..L as usize + 1 } else { 0..WIDTH };
        for (k, h) in &self.harmonics {
            for l in side_bands.clone() {
                let amplitude = h.right[l] / h.normal[l][l].re.max(1e-300);
                let gain = (amplitude.conj() * h.right[l]).re;
                let order = self.profile_order(*k, l);
                if order >= 1.0 && best.as_ref().is_none_or(|b| gain > b.0) {
                    best = Some((gain, order as u32, if h.backward { amplitude.conj() } else { amplitude }));
                }
            }
        }
        best
    }
}

/// Initial estimate of a spall.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpallGuess {
    /// Angle of the spall on its component, rad.
    pub centre: f64,
    pub half_width: f64,
    pub depth: f64,
    /// Cage angle at revolution 0 in pitches; for a ball, its azimuth in revolutions.
    pub phase: f64,
}

/// Fourier coefficient of order `m` of `cos(pi x / 2 w)`, |x| < w.
fn half_sine(m: f64, w: f64) -> f64 {
    let a = 2.0 * m * w / PI;
    let shape = if (1.0 - a * a).abs() < 1e-6 { PI / 4.0 } else { (m * w).cos() / (1.0 - a * a) };
    2.0 * w / (PI * PI) * shape
}

/// Peaks of the scan of slips about which further slips are tried.
const REFINED: usize = 2;
/// Distances of further slips from the best peak, in lines of the highest harmonic.
const BLUR: [f64; 6] = [3.0, 6.0, 9.0, 12.0, 15.0, 18.0];
/// Distance of these, in lines of the highest harmonic.
const BETWEEN: f64 = 0.7;
/// Distance of two slips from which they are two starts of a fit, in lines of the highest harmonic.
const APART: f64 = 8.0;

/// Families of the lines of a surface at the slips that explain most.
pub(crate) struct Families {
    /// At the slip at which most harmonics show, as those of a spall.
    pub of_spall: Family,
    /// By the strongest of them, as that of a wave; best first. Where the lines of the sound machine hide part of a line, its neighbours may
    /// seem to be the line of another slip.
    pub of_wave: Vec<Family>,
}

/// Returns the families of the lines of a surface at the slips that explain most.
pub(crate) fn best_families(
    e: &Evidence,
    band: &Baseband,
    from: &Fitted,
    compliance: &Compliance,
    component: Component,
    range: [f64; 2],
    observable: bool,
) -> Families {
    let bearing = compliance.bearing;
    let slip = from.machine.bearings[bearing].cage.slip;
    let bin = e.transform.lines[1];
    let step = bin / (e.motion.mean_speed().abs() * HARMONICS as f64 * e.plant.bearings[bearing].elements as f64);
    let at = |tried: f64| {
        // Balls that roll in a slipping cage slip with it.
        let cage_slip = if observable { slip } else { tried };
        let family = Family::new(e, band, &from.residual, compliance, component, tried, cage_slip);
        (family.scores(), family)
    };
    let mut tried: Vec<(Scores, Family)> = if observable && component != Component::Ball {
        vec![at(slip)]
    } else {
        let mut peaks = scan(e, &from.residual, bearing, component, observable.then_some(slip), range);
        if component != Component::Ball {
            // The cage may be known from earlier samples.
            peaks.push(slip);
        }
        peaks.into_iter().map(at).collect()
    };
    let mut about = vec![];
    if tried.len() > 1 {
        // The lines of the better peaks, between the steps of the scan.
        let between = |peak: f64| [-2.0, -1.0, 1.0, 2.0].map(|i| at(peak + BETWEEN * step * i));
        let by_lines = |a: &(Scores, Family), b: &(Scores, Family)| a.0.lines.total_cmp(&b.0.lines);
        let first = tried.iter().max_by(|a, b| by_lines(a, b)).cloned();
        tried.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
        let mut peaks: Vec<f64> = tried.iter().take(REFINED).map(|(_, family)| family.slip).collect();
        let of_wave = tried.iter().max_by(|a, b| a.0.wave.total_cmp(&b.0.wave));
        peaks.extend(of_wave.map(|(_, family)| family.slip).filter(|slip| !peaks.contains(slip)));
        tried.extend(peaks.into_iter().flat_map(between));
        // A speed that changes blurs the spectrum of the scan, not the lines of a family, which turn with the shaft.
        let blurred = |first: f64| [-1.0, 1.0].into_iter().flat_map(move |side| BLUR.map(|i| first + side * i * step));
        let further = first.iter().flat_map(|(_, first)| blurred(first.slip)).map(at);
        let sharp = further.chain(first.clone()).max_by(by_lines);
        about.extend(sharp.iter().flat_map(|(_, sharp)| between(sharp.slip)));
        about.extend(sharp);
    }
    let none = || Family { component, bearing, slip: 0.0, elements: 1.0, harmonics: vec![] };
    let best = if about.is_empty() { &tried } else { &about }.iter().max_by(|a, b| a.0.gain.total_cmp(&b.0.gain));
    let of_spall = best.map_or_else(none, |(_, family)| family.clone());
    let mut of_wave: Vec<Family> = vec![];
    tried.sort_by(|a, b| b.0.wave.total_cmp(&a.0.wave));
    for (_, family) in tried {
        let is_apart = |other: &Family| (other.slip - family.slip).abs() > APART * step;
        if of_wave.len() < REFINED && of_wave.iter().all(is_apart) {
            of_wave.push(family);
        }
    }
    Families { of_spall, of_wave }
}

/// What a family explains.
#[derive(Clone, Copy)]
struct Scores {
    /// How surely the lines are those of a spall, which are many: one strong line of another cause counts little.
    lines: f64,
    /// Fall of chi-squared by free amplitudes of all, and by one wave.
    gain: f64,
    wave: f64,
}

/// Returns a spall with a half-sine profile.
pub fn spall(surface: Surface, azimuth: f64, half_width: f64, depth: f64) -> Defect {
    Defect { surface, azimuth, half_width, depth, shape: DefectShape::HalfSine }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fourier coefficients by summation.
    #[test]
    fn profile_of_a_spall() {
        const N: usize = 100_000;
        for (m, w) in [(1.0, 0.05), (9.0, 0.05), (18.0, 0.1), (PI / 0.2, 0.1)] {
            let sum: f64 = (0..N)
                .map(|i| w * (2.0 * (i as f64 + 0.5) / N as f64 - 1.0))
                .map(|x| (0.5 * PI * x / w).cos() * (m * x).cos() * 2.0 * w / N as f64 / TAU)
                .sum();
            assert!((half_sine(m, w) - sum).abs() < 1e-9, "{m} {w}: {} {sum}", half_sine(m, w));
        }
    }
}
