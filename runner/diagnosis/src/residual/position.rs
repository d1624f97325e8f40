//! Position of the rotor at a site. The gaps of the probes are unknown, so that the mean of the readings says nothing of the position: it is where
//! the bearings carry the load. A parameter that changes their mean force therefore moves the rotor as well.

use super::super::Result;
use super::super::machine::Machine;
use super::super::measurement::GAP_FIRST;
use super::super::motion::{C, D};
use super::super::parameter::Unknown;
use super::site::DEPENDENT;
use super::{Evidence, Spectra};
use ballrace_base::parallel;
use ballrace_plant::probes;
use ballrace_scene::{Direction, Probe};
use nalgebra::{DMatrix, DVector, SVector};

/// Step of a difference quotient of the position, m and rad.
const STEP: [f64; D] = [1e-9, 1e-9, 1e-9, 1e-8, 1e-8];

/// Share of the least stiffness of the rotor that bounds its motion without contact: far below the stiffness of bearings that carry any load, which
/// determines the position.
const BOUND: f64 = 1e-3;

/// Probability that a probe was touched since the baseline: its gap may be any of a first recording.
const TOUCHED: f64 = 0.01;

/// Changes of the unexplained force by each coordinate of the position that probes measure.
struct ByPosition {
    changes: Vec<(usize, [Vec<C>; D])>,
    /// Least stiffness of each coordinate, as the change of the mean line.
    least: [f64; D],
}

impl Evidence<'_> {
    /// Returns the changes of the unexplained force of a machine by the position of the rotor.
    fn by_position(&self, spectra: &Spectra, machine: &Machine) -> Result<ByPosition> {
        let measured: Vec<usize> = (0..D).filter(|i| *i != 2 || self.weighting.has_axial_probe).collect();
        let of = |&i: &usize| {
            let mut moved = machine.clone();
            moved.position[i] += STEP[i];
            let mut change = self.no_force();
            for (b, before) in spectra.bearings.iter().enumerate() {
                let after = self.bearing(&moved, b)?;
                for ((change, after), before) in change.iter_mut().zip(&after.spectra).zip(&before.spectra) {
                    change.iter_mut().zip(after.iter().zip(before)).for_each(|(x, (a, b))| *x += (a - b) / STEP[i]);
                }
            }
            Ok((i, change))
        };
        let mean = self.constant[0].re;
        let least = self.least_stiffness().map(|x| -BOUND * x * mean);
        let changes = parallel::map(&measured, of).into_iter().collect::<Result<_>>()?;
        Ok(ByPosition { changes, least })
    }

    /// Adds to changes of the unexplained force, at a site, those of the positions of the rotor that keep its mean; returns these.
    pub(super) fn keep_mean_forces<'s>(
        &self,
        spectra: &Spectra,
        machine: &Machine,
        slopes: impl Iterator<Item = &'s mut [Vec<C>; D]>,
    ) -> Result<Vec<[f64; D]>> {
        let mut slopes: Vec<_> = slopes.collect();
        if self.site.is_none() || slopes.is_empty() {
            return Ok(vec![[0.0; D]; slopes.len()]);
        }
        let by_position = self.by_position(spectra, machine)?;
        let keep = |slope: &mut &mut [Vec<C>; D]| {
            let moved = by_position.balancing(slope).unwrap_or_default();
            by_position.add(&moved, slope);
            moved
        };
        Ok(slopes.iter_mut().map(keep).collect())
    }

    /// Returns the gaps of the radial probes beyond those of the baseline, in standard deviations; nothing for another recording.
    pub(crate) fn gaps(&self) -> Vec<f64> {
        self.radial_gaps().map(|(_, [gap, deviation])| gap / deviation).collect()
    }

    /// Returns minus twice the logarithm of the density of the gaps over that at none, in units of chi-squared of the lines; 0 without a baseline.
    pub(crate) fn chi_square_of_gaps(&self) -> f64 {
        if self.is_without_baseline() {
            return 0.0;
        }
        DEPENDENT * self.radial_gaps().map(|(_, gap)| surprise(*gap)).sum::<f64>()
    }

    /// Returns the radial probes of a site with their gaps.
    fn radial_gaps(&self) -> impl Iterator<Item = (&Probe, &[f64; 2])> {
        let gaps = self.site.iter().flat_map(|site| &site.gaps);
        self.weighting.probes.iter().zip(gaps).filter(|(probe, _)| probe.direction != Direction::Axial)
    }

    /// Returns the change of the residual by each unknown, with the rotor of a site where the bearings carry the mean force, and that of [`Self::gaps`].
    pub(crate) fn moving_slopes(
        &self,
        spectra: &Spectra,
        machine: &Machine,
        unknowns: &[Unknown],
    ) -> Result<Vec<[Vec<f64>; 2]>> {
        let mut slopes = self.force_slopes(spectra, machine, unknowns)?;
        let moved = self.keep_mean_forces(spectra, machine, slopes.iter_mut())?;
        let of = |(slope, moved): (&[Vec<C>; D], &[f64; D])| {
            let read = |probe: &Probe| probes::row(probe).iter().zip(moved).map(|(a, x)| a * x).sum::<f64>();
            [
                self.at_probes(slope),
                self.radial_gaps().map(|(probe, [_, deviation])| -read(probe) / deviation).collect(),
            ]
        };
        Ok(slopes.iter().zip(&moved).map(of).collect())
    }

    /// Moves the rotor of a machine to where its bearings carry the mean force of another one; both with their spectra.
    pub fn keep_mean_force(&self, machine: &mut Machine, spectra: &Spectra, before: &Spectra) -> Result<()> {
        let [after, before] = [spectra, before].map(|spectra| self.force(spectra));
        let mean = self.constant[0];
        let change = SVector::<C, D>::from_fn(|i, _| (after[i][0] - before[i][0]) / mean);
        let mut stiffness = self.held(self.dynamic_stiffness(&self.mean_stiffness(machine)?, 0, 0.0));
        let least = self.least_stiffness();
        (0..D).for_each(|i| stiffness[(i, i)] += C::new(BOUND * least[i], 0.0));
        let moved = stiffness.lu().solve(&change).filter(|moved| moved.iter().all(|x| x.re.is_finite()));
        if let Some(moved) = moved {
            machine.position.iter_mut().zip(moved.iter()).for_each(|(x, moved)| *x += moved.re);
        }
        Ok(())
    }
}

impl ByPosition {
    /// Returns the change of the position by which the mean of a force stays although the force changes by `slope`; `None` where it has no bound.
    fn balancing(&self, slope: &[Vec<C>; D]) -> Option<[f64; D]> {
        let n = self.changes.len();
        let row = |a: usize| self.changes[a].0;
        // A moment over the unit of an angle is a force.
        let unit = |i: usize| STEP[i] / STEP[0];
        let stiffness = DMatrix::from_fn(n, n, |a, b| {
            let least = if a == b { self.least[row(a)] } else { 0.0 };
            (self.changes[b].1[row(a)][0].re + least) * unit(row(a)) * unit(row(b))
        });
        let force = DVector::from_fn(n, |a, _| -slope[row(a)][0].re * unit(row(a)));
        let moved = stiffness.lu().solve(&force)?;
        let mut all = [0.0; D];
        moved.iter().enumerate().for_each(|(a, x)| all[row(a)] = x * unit(row(a)));
        all.iter().all(|x| x.is_finite()).then_some(all)
    }

    /// Adds the change of the force by a change of the position.
    fn add(&self, moved: &[f64; D], slope: &mut [Vec<C>; D]) {
        for (i, change) in &self.changes {
            for (slope, change) in slope.iter_mut().zip(change) {
                slope.iter_mut().zip(change).for_each(|(slope, x)| *slope += moved[*i] * x);
            }
        }
    }
}

/// Returns minus twice the logarithm of the density of a gap over that of none, from its standard deviation.
fn surprise([gap, deviation]: [f64; 2]) -> f64 {
    let density = |gap: f64| {
        let normal = |deviation: f64| (-0.5 * (gap / deviation).powi(2)).exp() / deviation;
        (1.0 - TOUCHED) * normal(deviation) + TOUCHED * normal(GAP_FIRST)
    };
    -2.0 * (density(gap) / density(0.0)).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotor on springs that couple its coordinates: the mean force stays where it was, the other lines change as by the motion.
    #[test]
    fn the_mean_of_a_force_stays() {
        let spring = |i: usize, j: usize| {
            let unit = [1.0, 1.0, 1.0, 0.1, 0.1];
            -1e8 * unit[i] * unit[j] * if i == j { 1.0 } else { 0.2 / (1.0 + i.abs_diff(j) as f64) }
        };
        let lines =
            |j: usize| std::array::from_fn(|i| vec![C::new(spring(i, j), 0.0), C::new(0.0, 0.5 * spring(i, j))]);
        let all = ByPosition { changes: (0..D).map(|j| (j, lines(j))).collect(), least: [0.0; D] };
        let slope: [Vec<C>; D] = std::array::from_fn(|i| vec![C::new(3e6 - 1e6 * i as f64, 0.0), C::new(7.0, 0.0)]);
        let moved = all.balancing(&slope).unwrap_or_default();
        let mut balanced = slope.clone();
        all.add(&moved, &mut balanced);
        for (i, (after, before)) in balanced.iter().zip(&slope).enumerate() {
            assert!(after[0].norm() < 1e-7 * before[0].norm().max(1e6), "{i}: {}", after[0]);
            // The second line is i/2 times the first of the springs.
            let expected = before[1] - C::new(0.0, 0.5) * before[0];
            assert!((after[1] - expected).norm() < 1e-6 * expected.norm(), "{i}: {} instead of {expected}", after[1]);
        }
        // Without an axial probe, the axial position is none that the readings give.
        let radial = ByPosition { changes: [0, 1, 3, 4].map(|j| (j, lines(j))).into(), least: [0.0; D] };
        let moved = radial.balancing(&slope).unwrap_or_default();
        assert!(moved[2] == 0.0 && moved[0] != 0.0, "{moved:?}");
        // Without contact, the least stiffness bounds the motion.
        let none = |_| std::array::from_fn(|_| vec![C::new(0.0, 0.0); 2]);
        let free = ByPosition { changes: (0..D).map(|j| (j, none(j))).collect(), least: [-1e6; D] };
        assert_eq!(free.balancing(&slope).map(|moved| moved[0]), Some(3.0));
    }

    /// A gap counts by its square up to three deviations, and hardly more from where the probe was touched.
    #[test]
    fn a_gap_surprises_no_more_than_a_probe_that_was_touched() {
        // 0.99 exp(-g^2 / 2) + 0.01 exp(-g^2 / 800) / 20, over its value at 0.
        for (gap, expected) in [(0.0, 0.0), (-0.5e-6, 0.24987), (3e-6, 8.91306), (10e-6, 15.43271), (-20e-6, 16.18271)]
        {
            let found = surprise([gap, 1e-6]);
            assert!((found - expected).abs() < 1e-5, "{gap}: {found} instead of {expected}");
        }
    }
}
