//! Log of a device: displacement, angles, speed, force and status as bits, one line per sample.

use ballrace::bearing::LastValidWrench;
use ballrace::{Bearing, BearingKinematicState, Displacement, Phase, Status, Wrench};
use core::fmt;

/// Number of samples.
pub const SAMPLES: u16 = 64;

/// Columns of the input, as `ballrace force` reads them.
pub const INPUT: &str = "u,v,w,thu,thv,cage_phase,inner_phase,inner_speed";

/// Displacement of sample `i`: an orbit in steps that every machine computes alike.
pub fn displacement(i: u16) -> Displacement<f32> {
    let part = f32::from(i) / 64.0;
    let half = if i < 32 { part } else { 1.0 - part };
    Displacement { u: 6e-6 * half, v: 4e-6 * (0.25 - half), w: 5e-6 + 4e-6 * part, thu: 1e-4 * half, thv: -5e-5 * part }
}

/// Angles and speed at sample `i`: the angles are no multiples of a decimal fraction of a revolution.
pub fn rotation(i: u16) -> BearingKinematicState<f32> {
    let turn = Phase(u64::from(i).wrapping_mul(0x0200_0000_0300_0007));
    BearingKinematicState {
        cage: turn,
        inner: turn.wrapping_mul(3),
        inner_speed: 1256.0,
        ..BearingKinematicState::default()
    }
}

/// One line: the columns [`INPUT`], then `FX,FY,FZ,MX,MY,status`.
pub struct Row {
    displacement: Displacement<f32>,
    at: BearingKinematicState<f32>,
    wrench: Wrench<f32>,
    status: Status,
}

impl Row {
    /// Computes the force of one sample.
    pub fn new(bearing: &impl Bearing<f32>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Self {
        let (wrench, status) = bearing.sample(&mut LastValidWrench::new(), u, at);
        Self { displacement: *u, at: *at, wrench, status }
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for x in self.displacement.to_array() {
            write!(f, "{:#010x},", x.to_bits())?;
        }
        let speed = self.at.inner_speed.to_bits();
        write!(f, "{:#018x},{:#018x},{speed:#010x}", self.at.cage.0, self.at.inner.0)?;
        for x in self.wrench.to_array() {
            write!(f, ",{:#010x}", x.to_bits())?;
        }
        write!(f, ",{:#04x}", self.status.bits())
    }
}
