//! Bearings on counts, over inputs of their own: the nodes of a table leave a small device no memory for the subjects beside.

use crate::subjects::Checksum;
use crate::subjects::baked::bearing_nde;
use ballrace::bearing::Mirrored;
use ballrace::bearing::fixed_point::{self, RadialParams, TabulatedParams};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::tabulated::Tabulated;
use ballrace::{Exact, Phase};

/// Nodes of one speed of the bearing "NDE".
const LAYER: usize = 19 * 11;
/// Displacement of 2^31 counts, m.
const RANGE: f64 = 1e-3;
/// Number of inputs.
const INPUTS: u32 = 2000;
/// Counts that a branch on a value would betray itself on.
const SPECIAL: [i32; 4] = [0, i32::MAX, i32::MIN, -1];

/// Five counts of some micrometres, some of them special, and the angle of the cage.
fn input(i: u32) -> ([i32; 5], Phase) {
    let mut counts = [2_654_435_761, 2_246_822_519, 3_266_489_917, 668_265_263, 374_761_393_u32]
        .map(|factor| i.wrapping_mul(factor).cast_signed() >> (5 + i % 11));
    if let (Some(count), Some(special)) = (counts.get_mut(i as usize % 13), SPECIAL.get(i as usize % 4)) {
        *count = *special;
    }
    (counts, Phase(u64::from(i).wrapping_mul(0x0123_4567_89ab_cdef)))
}

/// Computes the checksum of radial elements and of balls in a table.
///
/// # Errors
/// None with the parameters here; constructors can always fail.
#[inline(never)]
pub fn on_counts() -> Result<u64, InvalidParameter> {
    let params = RadialParams { stiffness: 8e9, exponent: 1.5, radial_play: 5e-7, range: RANGE };
    let radial = fixed_point::Radial::<9>::try_new(Phase(0x0123_4567_89ab_cdef), &params)?;
    // Without its surface deviations, which are of floats.
    let Mirrored(of) = bearing_nde::bearing();
    let smooth = Tabulated::<_, Exact, _, _, 3>::new(bearing_nde::POSITIONS, *of.constants(), *of.table(), false);
    let params = TabulatedParams { speed: 1256.0, range: RANGE, mirrored: true };
    let mut nodes = [[0; 3]; LAYER];
    let table = fixed_point::Tabulated::<9, _, 3>::try_new(&smooth, &params, nodes.as_mut_slice())?;
    let mut sum = Checksum::EMPTY;
    for i in 0..INPUTS {
        let ([u, v, w, x, y], cage) = input(i);
        let (radial, found) = (radial.reaction(u, v, cage), table.reaction(u, v, w, x, y, cage));
        for x in [radial.fx, radial.fy, radial.load, found.fx, found.fy, found.fz, found.mx, found.my] {
            sum.add_bits(x.cast_unsigned());
        }
        sum.add_bits(u32::from((radial.status | found.status).bits()));
    }
    Ok(sum.0)
}
