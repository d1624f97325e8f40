//! Counts the inputs on which two square roots differ: all of them on the desktop, a dense set on the target.
#![cfg_attr(target_os = "none", no_std, no_main)]

use ballrace::{Exact, Math};

/// Both roots of one bit pattern are the same bits; which NaN a root of a negative number is does not matter.
fn same(bits: u32) -> bool {
    let x = f32::from_bits(bits);
    let (machine, pure) = (<Exact as Math<f32>>::sqrt(x), libm::sqrtf(x));
    machine.to_bits() == pure.to_bits() || machine.is_nan() && pure.is_nan()
}

/// Roots of two and four numbers use other instructions; each equals the root of one number.
fn same_in_groups(bits: u32) -> bool {
    let x = [0, 1, 2, 3].map(|i| f32::from_bits(bits.wrapping_add(i)));
    let pairs = <Exact as Math<f32>>::sqrt_each(x);
    let powers = <Exact as Math<f32>>::three_halves(x);
    let [a, b, ..] = x;
    let powers_of_two = <Exact as Math<f32>>::three_halves([a, b]);
    let expected = x.map(|x| x * libm::sqrtf(f32::from_bits(x.to_bits() & 0x7fff_ffff)));
    let equal = |x: f32, y: f32| x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan();
    pairs.into_iter().zip(x).all(|(root, x)| equal(root, libm::sqrtf(x)))
        && powers.into_iter().zip(expected).all(|(x, y)| equal(x, y))
        && powers_of_two.into_iter().zip(expected).all(|(x, y)| equal(x, y))
}

#[cfg(not(target_os = "none"))]
fn main() {
    // Every pattern, or one in a number that the first argument states.
    let step: usize = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(1);
    // Two halves of the bit patterns, each with its own sign; the progress is that of the first.
    let half = |sign: u32| {
        (0..1_u32 << 31).step_by(step).filter(move |&bits| {
            if sign == 0 && bits.trailing_zeros() >= 27 {
                eprint!("\r{:3} %", u64::from(bits) * 100 >> 31);
            }
            !same(bits | sign)
        })
    };
    let differ = std::thread::scope(|scope| {
        let negative = scope.spawn(|| half(1 << 31).count());
        half(0).count() + negative.join().unwrap_or(usize::MAX)
    });
    let groups = (0..u32::MAX).step_by(4_099).filter(|&bits| !same_in_groups(bits)).count();
    eprintln!("\r100 %");
    println!("{} compared, {differ} differ; {groups} groups differ", 2 * (1_u64 << 31).div_ceil(step as u64));
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use cortex_m_semihosting::{debug, hprintln};
    use panic_semihosting as _;
    // Every 4099th bit pattern, and all patterns next to each power of two and the subnormal, infinite and NaN ones.
    let spread = (0..u32::MAX).step_by(4_099);
    let corners =
        (0..512_u32).flat_map(|exponent| (0..65).map(move |i| (exponent << 23).wrapping_add(i).wrapping_sub(32)));
    let (mut compared, mut differ) = (0, 0);
    for bits in spread.chain(corners) {
        compared += 1;
        differ += u32::from(!same(bits) || !same_in_groups(bits));
    }
    hprintln!("{} compared, {} differ", compared, differ);
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        core::hint::spin_loop();
    }
}
