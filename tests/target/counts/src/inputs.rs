//! The inputs that a constant count has to hold for.

use ballrace::{Displacement, Phase, Scalar};

/// Values that branches, subnormal handling or library calls would betray themselves on.
const SPECIAL: [f32; 14] = [
    0.0,
    -0.0,
    1e-45,
    -1e-40,
    1e-38,
    2e-6,
    -9e-6,
    40e-6,
    1.0,
    1e30,
    f32::MAX,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
];

/// How many there are.
pub const COUNT: u32 = 700;

/// Input number `i`: special values on one or two coordinates, else pseudo-random motion of some micrometres with
/// contact on all, some or no elements; the cage angle walks through every quadrant. Number 1 is an ordinary one.
pub fn input<T: Scalar>(i: u32) -> (Displacement<T>, Phase) {
    let mut seed = u64::from(i).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x1234_5678_9abc_def1);
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 40) as f32 / 16_777_216.0 - 0.5
    };
    let mut u = [random() * 60e-6, random() * 60e-6, random() * 120e-6, random() * 1e-3, random() * 1e-3];
    let special = |k: u32| SPECIAL.get(k as usize % SPECIAL.len()).copied().unwrap_or(0.0);
    if i.is_multiple_of(3) {
        let k = i / 3;
        if let Some(x) = u.get_mut(k as usize % 5) {
            *x = special(k / 5);
        }
        if let Some(x) = u.get_mut((k as usize + 1) % 5) {
            *x = special(k / 5 + k);
        }
    }
    let cage = Phase(u64::from(i).wrapping_mul(0x6a09_e667_f3bc_c908));
    (Displacement::from_array(u.map(|x| T::from_f64(f64::from(x)))), cage)
}

/// Count of reading `k` in the buffer number `i`: rails of the converter, counts that stand still, else some micrometres at 1 um a count.
pub fn counts(i: u32, k: u32) -> u16 {
    let hash = i.wrapping_mul(32).wrapping_add(k).wrapping_mul(2_654_435_761) >> 16;
    match hash & 7 {
        0 => 0,
        1 => u16::MAX,
        2 | 3 => 0x8000,
        _ => (0x8000 + (hash >> 3) % 128 - 64) as u16,
    }
}
