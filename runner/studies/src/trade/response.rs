//! Simulated motion of a candidate against the reference: levels, integrators and time steps.

use super::timing::spread;
use ballrace::Phase;
use ballrace::twin::OrderVector;
use ballrace_plant::Plant;
use ballrace_plant::error::{Error, Result};
use ballrace_plant::motion;
use ballrace_plant::spectrum::line;
use ballrace_scene::{Method, Scene};
use serde::Serialize;
use std::time::Instant;

/// Errors of a computed motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotionErrors {
    /// Error of the 1X vector over that of the reference (at least 1 % of its peak to peak), in the worst direction.
    pub one_per_turn: f64,
    /// Error of the vector at the outer ball-pass frequency, over the peak to peak of the reference; none without a bearing that has
    /// one.
    pub ball_pass: Option<f64>,
    /// Relative error of the peak-to-peak value.
    pub peak_to_peak: f64,
    /// Rms of the residual about its mean, over the rms of the reference about its mean.
    pub residual: f64,
    /// Error of the mean position, over the peak to peak of the reference.
    pub mean: f64,
}

/// Equal parts of a motion that are timed.
const PARTS: u64 = 32;

/// Integrators with their names in the scene.
pub(crate) const METHODS: [(&str, Method); 3] =
    [("runge-kutta", Method::RungeKutta), ("newmark", Method::Newmark { newton_steps: 2 }), ("verlet", Method::Verlet)];

/// Displacement of all bearings along X and Y, sample by sample.
pub struct Motion {
    /// One series per bearing and direction.
    series: Vec<Vec<f64>>,
    turned: Vec<f64>,
    orders: Vec<f64>,
    /// Computing time over simulated time.
    pub seconds_per_second: f64,
    /// Spread of the computing times of equal parts.
    pub spread: f64,
    /// Error of a motion that overflows, whose series end there.
    pub overflow: Option<String>,
    /// Mean step of an integrator that chooses its own, s.
    pub mean_step: Option<f64>,
}

/// Computes the motion of a candidate over the span of the reference, with the same sampling times.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn run(scene: &Scene, plant: &Plant, span: motion::Span) -> Result<Motion> {
    let mut series = vec![Vec::new(); 2 * plant.bearings.len()];
    let mut turned = Vec::new();
    let part = (span.samples / PARTS).max(1);
    let (mut parts, mut last) = (vec![], None::<Instant>);
    let begun = Instant::now();
    let run = motion::run(
        scene,
        plant,
        span,
        |_| {},
        |now| {
            for i in 0..plant.bearings.len() {
                let u = plant.displacement(i, now.twin.coordinates());
                for (along, x) in series.iter_mut().skip(2 * i).zip([u.u, u.v]) {
                    along.push(x);
                }
            }
            turned.push(now.turned);
            if (turned.len() as u64).is_multiple_of(part) {
                let now = Instant::now();
                parts.extend(last.map(|last| now.duration_since(last).as_secs_f64()));
                last = Some(now);
            }
            Ok::<_, Error>(())
        },
    );
    let (overflow, checks) = match run {
        Ok(twin) => (None, twin.multibody_checks()),
        Err(Error::Motion(overflow)) => (Some(overflow.to_string()), None),
        Err(error) => return Err(error),
    };
    let computed = (span.settle + span.samples) as f64 / span.rate;
    let orders = plant.bearings.iter().map(|s| s.kinematics.orders.outer_race).collect();
    let seconds_per_second = begun.elapsed().as_secs_f64() / computed;
    let mean_step = checks.map(|checks| computed / checks.steps.taken.max(1) as f64);
    Ok(Motion { series, turned, orders, seconds_per_second, spread: spread(parts), overflow, mean_step })
}

impl Motion {
    /// Returns the errors of this motion against the reference `truth`; infinite where it overflows.
    #[must_use]
    pub fn errors(&self, truth: &Self) -> MotionErrors {
        if self.overflow.is_some() {
            let none = f64::INFINITY;
            return MotionErrors {
                one_per_turn: none,
                ball_pass: None,
                peak_to_peak: none,
                residual: none,
                mean: none,
            };
        }
        let sum = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
        let spread = |x: &[f64]| x.iter().fold(f64::MIN, |m, &x| m.max(x)) - x.iter().fold(f64::MAX, |m, &x| m.min(x));
        // Relative to the largest direction: one without motion has no information.
        let most =
            |size: &dyn Fn(&[f64]) -> f64| truth.series.iter().map(|x| size(x)).fold(f64::MIN_POSITIVE, f64::max);
        let rms = |x: &[f64], about: f64| sum(&x.iter().map(|x| (x - about).powi(2)).collect::<Vec<_>>()).sqrt();
        let size = |v: [f64; 2]| v[0].hypot(v[1]);
        let (moved, swung) = (most(&spread), most(&|x| rms(x, sum(x))));
        // Without 1X in the reference, the denominator is a share of its peak to peak.
        let once = most(&|x| size(line_at(x, &truth.turned, 1.0))).max(0.01 * moved);
        let mut errors =
            MotionErrors { one_per_turn: 0.0, ball_pass: None, peak_to_peak: 0.0, residual: 0.0, mean: 0.0 };
        let mut ball_pass = 0.0;
        for (i, (x, right)) in self.series.iter().zip(&truth.series).enumerate() {
            let order = truth.orders.get(i / 2).copied().unwrap_or(0.0);
            let off = |order: f64| {
                let (a, b) = (line_at(x, &truth.turned, order), line_at(right, &truth.turned, order));
                size([a[0] - b[0], a[1] - b[1]])
            };
            let apart: Vec<f64> = x.iter().zip(right).map(|(a, b)| a - b).collect();
            let entries = [
                (&mut errors.one_per_turn, off(1.0) / once),
                (&mut ball_pass, if order > 0.0 { off(order) / moved } else { 0.0 }),
                (&mut errors.peak_to_peak, (spread(x) - spread(right)).abs() / moved),
                (&mut errors.residual, rms(&apart, sum(&apart)) / swung),
                (&mut errors.mean, sum(&apart).abs() / moved),
            ];
            for (worst, error) in entries {
                *worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
            }
        }
        errors.ball_pass = truth.orders.iter().any(|order| *order > 0.0).then_some(ball_pass);
        errors
    }
}

/// Returns the amplitude vector at an order of the shaft.
fn line_at(x: &[f64], turned: &[f64], order: f64) -> OrderVector<f64> {
    line(x, turned.iter().map(|turned| Phase::from_revolutions(order * turned)))
}
