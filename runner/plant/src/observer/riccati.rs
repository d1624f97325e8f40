//! Steady-state Kalman filter of a linear system, by the structure-preserving doubling algorithm.

use crate::error::ObserverError;
use nalgebra::DMatrix;

/// Largest number of doublings. Each squares the remaining influence of the initial state.
const DOUBLINGS: usize = 60;
const CONVERGED: f64 = 1e-13;

/// A linear system sampled: `x' = A x + w`, `y = C x + v`, with the covariances of `w` and `v`.
pub(crate) struct Sampled {
    /// Transition matrix `A`.
    pub transition: DMatrix<f64>,
    /// Measurement matrix `C`.
    pub probes: DMatrix<f64>,
    /// Covariance `Q` of `w`.
    pub disturbance: DMatrix<f64>,
    /// Covariance `R` of `v`.
    pub noise: DMatrix<f64>,
}

/// Steady-state filter.
pub struct Steady {
    /// `L`: change of the state per unit of innovation.
    pub gain: DMatrix<f64>,
    /// `W` with `W^T W = S^-1`, lower triangle.
    pub whitening: DMatrix<f64>,
    /// `P`: covariance of the prediction, before the correction.
    #[cfg(test)]
    pub covariance: DMatrix<f64>,
}

impl Sampled {
    /// Solves `P = A P A^T - A P C^T (C P C^T + R)^-1 C P A^T + Q`.
    ///
    /// Source: Chu, Fan, Lin, Wang 2004, Structure-preserving algorithms for periodic discrete-time algebraic Riccati
    /// equations, International Journal of Control 77.
    ///
    /// # Errors
    /// Returns an error if the measurement noise is singular or the filter has no steady state.
    pub fn steady(&self) -> Result<Steady, ObserverError> {
        let n = self.transition.nrows();
        let weight = self.noise.clone().try_inverse().ok_or(ObserverError::NoNoise)?;
        let one = DMatrix::<f64>::identity(n, n);
        let mut a = self.transition.transpose();
        let mut g = self.probes.transpose() * weight * &self.probes;
        let mut h = self.disturbance.clone();
        let mut settled = false;
        for _ in 0..DOUBLINGS {
            let w = (&one + &g * &h).try_inverse().ok_or(ObserverError::NotSteady)?;
            let (aw, hw) = (&a * &w, &h * &w);
            let more = a.transpose() * &hw * &a;
            g += &aw * &g * a.transpose();
            h += &more;
            a = &aw * &a;
            symmetrise(&mut g);
            symmetrise(&mut h);
            if more.norm() <= CONVERGED * h.norm() {
                settled = true;
                break;
            }
        }
        let covariance = h;
        let innovation = &self.probes * &covariance * self.probes.transpose() + &self.noise;
        let factor = innovation.cholesky().filter(|_| settled).ok_or(ObserverError::NotSteady)?;
        let gain = &covariance * self.probes.transpose() * factor.inverse();
        let whitening = factor.l().try_inverse().ok_or(ObserverError::NotSteady)?;
        Ok(Steady {
            gain,
            whitening,
            #[cfg(test)]
            covariance,
        })
    }
}

fn symmetrise(m: &mut DMatrix<f64>) {
    *m = 0.5 * (&*m + m.transpose());
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// A random walk measured in noise: `P = (q + sqrt(q^2 + 4 q r))/2`.
    #[test]
    fn a_random_walk() {
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        let (q, r) = (0.3, 2.0);
        let steady =
            Sampled { transition: one(1.0), probes: one(1.0), disturbance: one(q), noise: one(r) }.steady().unwrap();
        let p = 0.5 * (q + (q * q + 4.0 * q * r).sqrt());
        assert!((steady.covariance[(0, 0)] - p).abs() < 1e-12);
        assert!((steady.gain[(0, 0)] - p / (p + r)).abs() < 1e-12);
        assert!((steady.whitening[(0, 0)].powi(2) * (p + r) - 1.0).abs() < 1e-12);
    }

    /// The result of the doubling satisfies the Riccati equation, and the filter is stable.
    #[test]
    fn the_equation_holds() {
        let a = DMatrix::from_row_slice(3, 3, &[0.99, 0.1, 0.0, -0.2, 0.97, 0.05, 0.0, 0.0, 0.9999]);
        let c = DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.0]);
        let q = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![0.0, 0.0, 1e-4]));
        let r = DMatrix::from_element(1, 1, 0.01);
        let s = Sampled { transition: a.clone(), probes: c.clone(), disturbance: q.clone(), noise: r.clone() };
        let Steady { gain, covariance: p, .. } = s.steady().unwrap();
        let innovation = (&c * &p * c.transpose() + &r).try_inverse().unwrap();
        let again = &a * &p * a.transpose() - &a * &p * c.transpose() * innovation * &c * &p * a.transpose() + q;
        assert!((again - &p).norm() < 1e-12 * p.norm());
        let closed = (DMatrix::identity(3, 3) - &gain * &c) * &a;
        assert!(ballrace_base::eigenvalues::eigenvalues(&closed).unwrap().iter().all(|e| e.norm() < 1.0));
    }

    #[test]
    fn an_unobservable_growing_state_is_rejected() {
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        let open = Sampled { transition: one(1.0), probes: one(0.0), disturbance: one(1.0), noise: one(1.0) };
        assert!(open.steady().is_err());
    }
}
