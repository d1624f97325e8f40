//! Matrices of a rigid rotor on bearings in flexible supports (`docs/src/models.md#rotor`).

use super::linear_system::SystemMatrices;
use super::rigid::sum_unbalances;
use super::{RotorParams, Unbalance};
use crate::bearing::geometry::{InvalidParameter, check};

/// Support of the outer ring of a bearing: a mass on springs along X and Y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    /// Mass, kg.
    pub mass: f64,
    /// Stiffness `[[k1, k12], [k12, k2]]`, N/m.
    pub stiffness: [[f64; 2]; 2],
    /// Damping `[[c1, c12], [c12, c2]]`, N s/m.
    pub damping: [[f64; 2]; 2],
}

/// Returns the matrices of a rigid rotor with the coordinates `u v w thu thv`, followed by `u v` of each support.
///
/// `M = diag(m, m, m, I_d, I_d, m_1, m_1, ...)`, `G[thu, thv] = I_p`; two supports need nine coordinates. Further
/// coordinates have a unit mass only. [`super::Attachment::on_rigid_rotor`] attaches the bearings.
///
/// # Errors
/// The first parameter outside its range; more supports than the system has coordinates.
pub fn supported_rotor<const D: usize>(
    params: &RotorParams,
    unbalances: &[Unbalance],
    supports: &[Support],
) -> Result<SystemMatrices<D>, InvalidParameter> {
    params.check()?;
    let needed = 5 + 2 * supports.len();
    check(needed <= D, "supports", supports.len() as f64, "at most (D - 5)/2 in a system of D coordinates")?;
    let mut all = SystemMatrices::<D>::unit_mass();
    let mass = [params.mass, params.mass, params.mass, params.diametral_inertia, params.diametral_inertia];
    let [gx, gy, gz] = params.gravity;
    let weight = [gx * params.mass, gy * params.mass, gz * params.mass, 0.0, 0.0];
    for i in 0..5 {
        all.mass[(i, i)] = mass.get(i).copied().unwrap_or(1.0);
        all.stiffness[(i, i)] = params.stiffness.get(i).copied().unwrap_or(0.0);
        for j in 0..5 {
            all.damping[(i, j)] = params.damping.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
        }
    }
    for ((entry, load), weight) in all.load.iter_mut().zip(params.load).zip(weight) {
        *entry = load + weight;
    }
    all.gyroscopic[(3, 4)] = params.polar_inertia;
    all.gyroscopic[(4, 3)] = -params.polar_inertia;
    let ([fx, fy], [cx, cy]) = sum_unbalances(unbalances)?;
    // The force rotates with the shaft; its couple about X is -station times the force along Y.
    let turning = [[fx, -fy], [fy, fx], [0.0, 0.0], [-cy, -cx], [cx, -cy]];
    for (entry, both) in all.unbalance.iter_mut().zip(turning) {
        *entry = both;
    }
    for (s, support) in supports.iter().enumerate() {
        check(support.mass > 0.0, "support mass", support.mass, "above 0 kg")?;
        let first = 5 + 2 * s;
        for (i, (k, c)) in support.stiffness.iter().zip(&support.damping).enumerate() {
            for (j, (&k, &c)) in k.iter().zip(c).enumerate() {
                check(true, "support stiffness", k, "a finite number")?;
                check(true, "support damping", c, "a finite number")?;
                all.stiffness[(first + i, first + j)] = k;
                all.damping[(first + i, first + j)] = c;
            }
            all.mass[(first + i, first + i)] = support.mass;
        }
        for (entry, g) in all.load.iter_mut().skip(first).zip([gx, gy]) {
            *entry = support.mass * g;
        }
    }
    Ok(all)
}
