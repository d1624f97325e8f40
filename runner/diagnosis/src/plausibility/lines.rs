//! Checks of the lines in the order spectrum of the radial probes: the speed of a shaft that is not measured, the number of elements
//! and the designation of each bearing.

use super::{Evidence, Implausibility};
use ballrace::bearing::kinematics::Orders;
use ballrace_models::build::kinematics;
use ballrace_plant::spectrum::amplitudes;
use ballrace_recording::Sample;
use ballrace_scene::{Bearing, Direction, Recording, RotationSource, Scene, catalogue};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// Fewest revolutions of an order spectrum that separates the ball passes of neighbouring numbers of elements.
const MIN_REVOLUTIONS: f64 = 16.0;
/// Largest order of the spectrum.
const LARGEST_ORDER: f64 = 24.0;
/// Half of the width over which the local noise floor is taken, orders.
const FLOOR_WIDTH: f64 = 1.0;
/// Relative distance of a ball-pass line from pure rolling: cages slip by up to 2 %, and the contact angle changes with the load.
const SLIP: RangeInclusive<f64> = 0.97..=1.01;
/// Power over the local floor above which a line is present. One of 1e4 bins of noise reaches 20 by chance.
const PRESENT: f64 = 100.0;
/// Power over the local floor below which a line is absent.
const ABSENT: f64 = 10.0;
/// Smallest share of one line in the variance of the readings for which a rotating shaft must be its cause.
const DOMINANT: f64 = 0.3;
/// Number of harmonics of the lines of races and balls that a bearing may have.
const HARMONICS: i32 = 4;
/// Relative distance from the shaft speed within which a line is 1X, for a speed that is not measured.
const NEAR_SPEED: f64 = 0.03;
/// Bins of a line under the Hann window to either side.
const LINE_WIDTH: f64 = 2.0;

/// Returns the implausibilities of the lines.
pub(super) fn of_lines(evidence: &Evidence) -> Vec<Implausibility> {
    let Some(recording) = &evidence.scene.recording else { return vec![] };
    let Some(spectrum) = OrderSpectrum::of(recording, evidence.samples) else { return vec![] };
    let lines = Lines::of(evidence.scene);
    match recording.rotation {
        RotationSource::Scene => shaft_speed(evidence, &spectrum, &lines).into_iter().collect(),
        _ => element_counts(evidence.scene, &spectrum, &lines),
    }
}

/// Spectrum over the orders of the shaft, averaged over probes.
struct OrderSpectrum {
    /// Power over the local floor.
    over_floor: Vec<f64>,
    /// Share of the variance.
    share: Vec<f64>,
    /// Revolutions, the number of bins per order.
    revolutions: f64,
}

impl OrderSpectrum {
    /// Computes the spectrum of the radial probes; none where the shaft turns too little.
    fn of(recording: &Recording, samples: &[Sample]) -> Option<Self> {
        let is_radial = |i: &usize| matches!(recording.probes[*i].direction, Direction::Radial(_));
        Self::new(samples, &(0..recording.probes.len()).filter(is_radial).collect::<Vec<_>>())
    }

    /// Computes the spectrum of these probes; none where the shaft turns too little.
    fn new(samples: &[Sample], probes: &[usize]) -> Option<Self> {
        let (first, last) = (samples.first()?.total_revolutions(), samples.last()?.total_revolutions());
        let revolutions = (last - first).abs().floor();
        if revolutions < MIN_REVOLUTIONS || probes.is_empty() {
            return None;
        }
        let per_revolution = (samples.len() as f64 / revolutions).floor().max(1.0);
        let bins = ((LARGEST_ORDER.min(0.4 * per_revolution)) * revolutions) as usize;
        let (mut over_floor, mut share) = (vec![0.0; bins], vec![0.0; bins]);
        for &probe in probes {
            let readings = at_even_angles(samples, probe, revolutions, per_revolution);
            let power: Vec<f64> = amplitudes(&readings).iter().take(bins).map(|a| a * a).collect();
            let mean = readings.iter().sum::<f64>() / readings.len() as f64;
            let variance = readings.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / readings.len() as f64;
            if variance <= 0.0 || power.len() < bins {
                continue;
            }
            for (bin, (sum, share)) in over_floor.iter_mut().zip(&mut share).enumerate() {
                *sum += power[bin] / floor(&power, bin, revolutions).max(f64::MIN_POSITIVE) / probes.len() as f64;
                *share += 0.5 * power[bin] / variance / probes.len() as f64;
            }
        }
        Some(Self { over_floor, share, revolutions })
    }

    /// Returns the bins of a range of orders.
    fn bins(&self, orders: RangeInclusive<f64>) -> RangeInclusive<usize> {
        let bin = |order: f64| (order * self.revolutions).clamp(0.0, self.over_floor.len().saturating_sub(1) as f64);
        (bin(*orders.start()) - LINE_WIDTH).max(0.0).round() as usize
            ..=(bin(*orders.end()) + LINE_WIDTH).round() as usize
    }

    /// Returns the largest power over the floor in a range of orders, without the bins that `others` may hold.
    fn largest(&self, orders: RangeInclusive<f64>, others: &[RangeInclusive<f64>]) -> f64 {
        self.free(orders, others).into_iter().map(|bin| self.power(bin)).fold(0.0, f64::max)
    }

    /// Returns the bin of the strongest line in a range of orders. A bin on the flank of a stronger line is none.
    fn line(&self, orders: RangeInclusive<f64>, others: &[RangeInclusive<f64>]) -> Option<usize> {
        let width = 2 * LINE_WIDTH as usize;
        let is_line = |bin: &usize| {
            let around = bin.saturating_sub(width)..=bin + width;
            around.into_iter().all(|other| self.power(other) <= self.power(*bin))
        };
        let free = self.free(orders, others).into_iter().filter(is_line);
        free.max_by(|a, b| self.power(*a).total_cmp(&self.power(*b)))
    }

    /// Returns the power of a bin over the local floor.
    fn power(&self, bin: usize) -> f64 {
        self.over_floor.get(bin).copied().unwrap_or(0.0)
    }

    /// Returns the bins of a range of orders without those that `others` may hold.
    fn free(&self, orders: RangeInclusive<f64>, others: &[RangeInclusive<f64>]) -> Vec<usize> {
        let others: Vec<_> = others.iter().map(|orders| self.bins(orders.clone())).collect();
        self.bins(orders).filter(|bin| !others.iter().any(|range| range.contains(bin))).collect()
    }
}

/// Returns the readings at even steps of the shaft angle, by linear interpolation.
fn at_even_angles(samples: &[Sample], probe: usize, revolutions: f64, per_revolution: f64) -> Vec<f64> {
    let at = |sample: &Sample| sample.total_revolutions();
    let (Some(first), Some(last)) = (samples.first().map(at), samples.last().map(at)) else { return vec![] };
    let direction = (last - first).signum();
    let turned = |sample: &Sample| direction * (at(sample) - first);
    let reading = |sample: &Sample| sample.row.probes.get(probe).copied().unwrap_or(0.0);
    let mut pairs = samples.windows(2).peekable();
    let steps = (revolutions * per_revolution) as usize;
    let mut readings = Vec::with_capacity(steps);
    for step in 0..steps {
        let angle = step as f64 / per_revolution;
        while pairs.next_if(|pair| turned(&pair[1]) < angle).is_some() {}
        let Some([a, b]) = pairs.peek() else { break };
        let share = ((angle - turned(a)) / (turned(b) - turned(a))).clamp(0.0, 1.0);
        readings.push(reading(a) + if share.is_finite() { share * (reading(b) - reading(a)) } else { 0.0 });
    }
    readings
}

/// Returns the median power around a bin: that of the noise where fewer than half of the bins hold lines.
fn floor(power: &[f64], bin: usize, revolutions: f64) -> f64 {
    let width = (FLOOR_WIDTH * revolutions) as usize;
    let range = bin.saturating_sub(width)..(bin + width + 1).min(power.len());
    let mut around: Vec<f64> = power.get(range).unwrap_or_default().to_vec();
    let middle = around.len() / 2;
    if around.is_empty() { 0.0 } else { *around.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Lines that the machine of the scene may have.
struct Lines {
    /// For each bearing: name, number of elements, order of the cage relative to the outer ring, and its lines.
    bearings: Vec<BearingLines>,
}

struct BearingLines {
    name: String,
    elements: usize,
    /// Revolutions of the cage relative to the outer ring, per revolution of the shaft.
    cage: f64,
    lines: Vec<RangeInclusive<f64>>,
}

impl Lines {
    fn of(scene: &Scene) -> Self {
        let bearings = scene.bearings.iter().filter(|bearing| bearing.elements > 0).filter_map(|bearing| {
            let orders = rolling_orders(scene, bearing)?;
            let cage = orders.outer_race / bearing.elements as f64;
            // A defect that turns with the inner ring or with a ball has its lines beside the harmonics.
            let parts = [(orders.outer_race, 0.0), (orders.inner_race, 1.0), (orders.ball_spin, cage)];
            let lines = parts.iter().flat_map(|(order, carrier)| {
                let beside = move |n: i32| (-2..=2).map(move |k| f64::from(n) * order + f64::from(k) * carrier);
                (1..=HARMONICS).flat_map(beside)
            });
            // A rotor that rattles in its clearance moves at halves of the ball pass.
            let halves = (0..HARMONICS).map(move |n| (f64::from(n) + 0.5) * orders.outer_race);
            let lines = lines.chain(halves);
            let slips = |order: f64| {
                let width = order.abs().max(1.0);
                order - (1.0 - SLIP.start()) * width..=order + (SLIP.end() - 1.0) * width
            };
            let lines = lines.map(slips).collect();
            Some(BearingLines { name: bearing.name.clone(), elements: bearing.elements, cage, lines })
        });
        Self { bearings: bearings.collect() }
    }

    /// Returns the lines of all bearings and the harmonics of half the shaft speed.
    fn all(&self) -> Vec<RangeInclusive<f64>> {
        let bearings = self.bearings.iter().flat_map(|bearing| bearing.lines.clone());
        bearings.chain(harmonics_of_shaft()).collect()
    }
}

/// Returns the orders of pure rolling; those of `cage_ratio` only where there is no geometry. A cage ratio that was estimated from the
/// recording with a wrong number of elements fits its line.
fn rolling_orders(scene: &Scene, bearing: &Bearing) -> Option<Orders> {
    let free = Bearing { cage_ratio: None, ..bearing.clone() };
    let rolling = kinematics(scene, &free).ok().filter(|kinematics| kinematics.spin_known);
    rolling.or_else(|| kinematics(scene, bearing).ok()).map(|kinematics| kinematics.orders)
}

fn harmonics_of_shaft() -> impl Iterator<Item = RangeInclusive<f64>> {
    (1..=2 * LARGEST_ORDER as u32).map(|n| 0.5 * f64::from(n)).map(|order| order..=order)
}

/// Returns an implausibility if no line of the machine explains the dominant line of the spectrum.
fn shaft_speed(evidence: &Evidence, spectrum: &OrderSpectrum, lines: &Lines) -> Option<Implausibility> {
    let [_, mean, _] = evidence.collected.speeds().rpm()?;
    let (bin, share) = spectrum.share.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let order = bin as f64 / spectrum.revolutions;
    let at_speed = 1.0 - NEAR_SPEED..=1.0 + NEAR_SPEED;
    let is_known = |orders: RangeInclusive<f64>| spectrum.bins(orders).contains(&bin);
    let harmonics = (1..=LARGEST_ORDER as u32).map(|n| {
        let n = f64::from(n);
        n * at_speed.start()..=n * at_speed.end()
    });
    let is_explained = lines.all().into_iter().chain(harmonics).any(is_known);
    if share < DOMINANT || is_explained || spectrum.largest(at_speed, &[]) > PRESENT {
        return None;
    }
    let hertz = order * mean.abs() / 60.0;
    Some(Implausibility {
        subject: "shaft speed".to_owned(),
        found: format!(
            "the strongest line of the probes is at {hertz:.1} Hz, {order:.2} times the scene's {:.0} rpm, and none is at the shaft speed",
            mean.abs()
        ),
        cause: "another speed or another sampling rate; the recording measures no speed".to_owned(),
        remedy: format!(
            "[shaft] speed = \"{:.0} rpm\" or [recording] rate = \"{:.1} Hz\"",
            hertz * 60.0,
            evidence.rate_hz / order
        ),
    })
}

/// Returns the orders at which a ball pass of this order has its line.
fn around(order: f64) -> RangeInclusive<f64> {
    SLIP.start() * order..=SLIP.end() * order
}

/// A bearing of the scene that has no line at its outer-race ball pass, so that one of another bearing may be seen.
struct Silent<'a> {
    spectrum: &'a OrderSpectrum,
    /// Lines that the machine of the scene may have: they are no evidence for another bearing.
    own: Vec<RangeInclusive<f64>>,
}

impl<'a> Silent<'a> {
    /// Returns none where the bearing of this index has its line.
    fn new(spectrum: &'a OrderSpectrum, lines: &Lines, index: usize) -> Option<Self> {
        let bearing = lines.bearings.get(index)?;
        // A line that may be of the other bearing does not show that this one has none.
        let of_shaft: Vec<_> = harmonics_of_shaft().collect();
        let pass = around(bearing.elements as f64 * bearing.cage);
        (spectrum.largest(pass, &of_shaft) <= ABSENT).then(|| Self { spectrum, own: lines.all() })
    }

    /// Returns the bin of a line at this outer-race ball pass that the machine of the scene cannot have.
    fn line(&self, order: f64) -> Option<usize> {
        self.spectrum.line(around(order), &self.own).filter(|bin| self.spectrum.power(*bin) > ABSENT)
    }

    /// A ball pass has harmonics; a single line may come from a wave on a ball or a race of the bearing of the scene.
    fn is_pass(&self, bin: usize) -> bool {
        let order = 2.0 * self.order(bin);
        let harmonic = self.spectrum.line(order..=order, &[]);
        self.spectrum.power(bin) > PRESENT && harmonic.is_some_and(|bin| self.spectrum.power(bin) > ABSENT)
    }

    fn order(&self, bin: usize) -> f64 {
        bin as f64 / self.spectrum.revolutions
    }
}

/// Returns an implausibility for each bearing whose ball-pass line is absent while that of another number of elements is present.
fn element_counts(scene: &Scene, spectrum: &OrderSpectrum, lines: &Lines) -> Vec<Implausibility> {
    let wrong = lines.bearings.iter().enumerate().filter_map(|(i, bearing)| {
        let silent = Silent::new(spectrum, lines, i)?;
        let counts = (bearing.elements / 2).max(3)..=bearing.elements + bearing.elements / 2;
        let seen: Vec<(usize, usize)> = counts
            .filter(|count| *count != bearing.elements)
            .filter_map(|count| Some((count, silent.line(count as f64 * bearing.cage)?)))
            .collect();
        // Lines at several multiples of the cage speed do not determine a number of elements.
        let [(count, bin)] = seen.as_slice() else { return None };
        let speed = scene.shaft.speed.range().1.abs() / TAU;
        silent.is_pass(*bin).then(|| {
            let [scene_order, order] = [bearing.elements, *count].map(|n| n as f64 * bearing.cage);
            Implausibility {
                subject: format!("bearing {}: elements", bearing.name),
                found: format!(
                    "no line at the outer-race ball pass of {} elements (order {scene_order:.3}, {:.1} Hz), one at that of {count} (order {order:.3}, {:.1} Hz)",
                    bearing.elements,
                    scene_order * speed,
                    order * speed
                ),
                cause: "another number of elements, or another bearing".to_owned(),
                remedy: format!("elements = {count}, or the designation of the bearing"),
            }
        })
    });
    wrong.collect()
}

/// Returns an implausibility for each bearing of the catalogue whose ball-pass line is absent while that of other bearings of its bore is
/// present, as the lowest line of its family.
pub fn of_designations(scene: &Scene, samples: &[Sample]) -> Vec<Implausibility> {
    let Some(recording) = scene.recording.as_ref().filter(|of| !matches!(of.rotation, RotationSource::Scene)) else {
        return vec![];
    };
    let Some(spectrum) = OrderSpectrum::of(recording, samples) else { return vec![] };
    let lines = Lines::of(scene);
    let wrong = lines.bearings.iter().enumerate().filter_map(|(i, bearing)| {
        let entry = scene.bearings.iter().find(|of| of.name == bearing.name)?.catalogue.as_ref()?.listed.entry;
        let silent = Silent::new(&spectrum, &lines, i)?;
        let same_bore = catalogue::all().iter().filter(|other| other.bore == entry.bore && *other != entry);
        let seen: Vec<(f64, &str, usize)> = same_bore
            .filter_map(|other| {
                let order = other.orders().outer_race;
                let bin = silent.line(order)?;
                Some(((silent.order(bin) / order - 1.0).abs(), other.designation, bin))
            })
            .collect();
        let bin = seen.iter().map(|(.., bin)| *bin).max_by(|a, b| spectrum.power(*a).total_cmp(&spectrum.power(*b)))?;
        let order = silent.order(bin);
        let is_lowest = [2.0, 3.0, 4.0].into_iter().all(|part| {
            let lower = spectrum.line(order / part..=order / part, &harmonics_of_shaft().collect::<Vec<_>>());
            lower.is_none_or(|bin| spectrum.power(bin) <= ABSENT)
        });
        // Lines of several families, each the ball pass of another bearing, tell none; unbalance puts lines beside a ball pass.
        let is_of_family = |other: usize| {
            (1..=HARMONICS).any(|n| {
                let aside = silent.order(other) - f64::from(n) * order;
                (aside - aside.round()).abs() * spectrum.revolutions <= f64::from(n) * LINE_WIDTH
            })
        };
        let is_one = seen.iter().all(|(.., other)| is_of_family(*other));
        let mut named: Vec<_> = seen.iter().filter(|(.., other)| other.abs_diff(bin) <= LINE_WIDTH as usize).collect();
        named.sort_by(|a, b| a.0.total_cmp(&b.0));
        let named: Vec<&str> = named.into_iter().take(3).map(|(_, designation, _)| *designation).collect();
        (is_one && is_lowest && silent.is_pass(bin)).then(|| Implausibility {
            subject: format!("bearing {}: bearing", bearing.name),
            found: format!(
                "no line at the outer-race ball pass of {} (order {:.3}), one at order {order:.3} with its double, as of {}",
                entry.designation,
                bearing.elements as f64 * bearing.cage,
                named.join(", ")
            ),
            cause: "another bearing of the same bore".to_owned(),
            remedy: "bearing = the designation that is stamped on the ring".to_owned(),
        })
    });
    wrong.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bins beside a strong line hold more than noise, but no line.
    #[test]
    fn flanks_are_no_lines() {
        let revolutions = 100.0;
        let flank = |bin: usize| 1e5 / (1.0 + (bin as f64 - 400.0).powi(4));
        let mut over_floor: Vec<f64> = (0..1000).map(flank).collect();
        over_floor[420] = 50.0;
        let spectrum = OrderSpectrum { share: vec![0.0; over_floor.len()], over_floor, revolutions };
        let harmonics = [4.0..=4.0];
        assert!(spectrum.largest(4.04..=4.1, &harmonics) > ABSENT);
        assert_eq!(spectrum.line(4.04..=4.1, &harmonics), None);
        assert_eq!(spectrum.line(4.04..=4.25, &harmonics), Some(420));
        assert_eq!(spectrum.line(3.9..=4.1, &[]), Some(400));
    }
}
