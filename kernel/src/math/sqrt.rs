//! Square roots by the instruction of the target. With the tables of a blob, the only unsafe code.
//!
//! Every path is correctly rounded (IEEE 754), so the results are the same on all targets.
//!
//! Stable Rust accepts no floating-point operands in assembly for Arm. A single root uses core registers; two share the
//! moves; four are a call by the standard calling convention, which passes floats in the registers of the FPU.
#![allow(unsafe_code)]

/// Square root, correctly rounded.
#[inline(always)]
pub fn sqrt_f32(x: f32) -> f32 {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};
        // SAFETY: SSE is part of the x86-64 baseline.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }
    #[cfg(vsqrt)]
    {
        fpu::sqrt(x)
    }
    #[cfg(fsqrt)]
    {
        let root: f32;
        // SAFETY: the target has this instruction; it accesses no memory and only the named registers.
        unsafe {
            core::arch::asm!(
                "fsqrt.s {root}, {x}",
                x = in(freg) x,
                root = lateout(freg) root,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        root
    }
    #[cfg(not(any(target_arch = "x86_64", vsqrt, fsqrt)))]
    libm::sqrtf(x)
}

/// Square root of each, correctly rounded.
#[inline(always)]
pub fn sqrt_each_f32<const K: usize>(x: [f32; K]) -> [f32; K] {
    #[cfg(vsqrt)]
    {
        fpu::in_groups(x, fpu::sqrt_of_two, fpu::sqrt)
    }
    #[cfg(not(vsqrt))]
    x.map(sqrt_f32)
}

/// `x sqrt|x|` of each, root and product correctly rounded.
#[inline(always)]
pub fn three_halves_f32<const K: usize>(x: [f32; K]) -> [f32; K] {
    #[cfg(vsqrt)]
    {
        if K == 4 {
            fpu::in_groups(x, fpu::three_halves_of_four, fpu::three_halves)
        } else {
            fpu::in_groups(x, fpu::three_halves_of_two, fpu::three_halves)
        }
    }
    #[cfg(not(vsqrt))]
    x.map(|x| x * sqrt_f32(f32::from_bits(x.to_bits() & 0x7fff_ffff)))
}

/// The single-precision FPU of the Cortex-M4F, M7F and M33F.
#[cfg(vsqrt)]
mod fpu {
    use core::arch::{asm, naked_asm};

    /// Applies `group` to all full groups of `G` numbers and `single` to the rest.
    #[inline(always)]
    pub fn in_groups<const K: usize, const G: usize>(
        mut x: [f32; K],
        group: impl Fn([f32; G]) -> [f32; G],
        single: impl Fn(f32) -> f32,
    ) -> [f32; K] {
        let (groups, rest) = x.as_chunks_mut::<G>();
        for values in groups {
            *values = group(*values);
        }
        for value in rest {
            *value = single(*value);
        }
        x
    }

    #[inline(always)]
    pub fn sqrt(x: f32) -> f32 {
        let root: u32;
        // SAFETY: the target has these instructions; they access no memory and only the named registers. This holds for all
        // blocks below.
        unsafe {
            asm!(
                "vmov s0, {x}",
                "vsqrt.f32 s0, s0",
                "vmov {x}, s0",
                x = inout(reg) x.to_bits() => root,
                out("s0") _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        f32::from_bits(root)
    }

    #[inline(always)]
    pub fn sqrt_of_two([x, y]: [f32; 2]) -> [f32; 2] {
        let (x_root, y_root): (u32, u32);
        // SAFETY: as above.
        unsafe {
            asm!(
                "vmov s0, s1, {x}, {y}",
                "vsqrt.f32 s0, s0",
                "vsqrt.f32 s1, s1",
                "vmov {x}, {y}, s0, s1",
                x = inout(reg) x.to_bits() => x_root,
                y = inout(reg) y.to_bits() => y_root,
                out("s0") _,
                out("s1") _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        [f32::from_bits(x_root), f32::from_bits(y_root)]
    }

    #[inline(always)]
    pub fn three_halves(x: f32) -> f32 {
        let power: u32;
        // SAFETY: as above.
        unsafe {
            asm!(
                "vmov s0, {x}",
                "vabs.f32 s1, s0",
                "vsqrt.f32 s1, s1",
                "vmul.f32 s0, s0, s1",
                "vmov {x}, s0",
                x = inout(reg) x.to_bits() => power,
                out("s0") _,
                out("s1") _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        f32::from_bits(power)
    }

    #[inline(always)]
    pub fn three_halves_of_two([x, y]: [f32; 2]) -> [f32; 2] {
        let (x_power, y_power): (u32, u32);
        // SAFETY: as above.
        unsafe {
            asm!(
                "vmov s0, s1, {x}, {y}",
                "vabs.f32 s2, s0",
                "vabs.f32 s3, s1",
                "vsqrt.f32 s2, s2",
                "vsqrt.f32 s3, s3",
                "vmul.f32 s0, s0, s2",
                "vmul.f32 s1, s1, s3",
                "vmov {x}, {y}, s0, s1",
                x = inout(reg) x.to_bits() => x_power,
                y = inout(reg) y.to_bits() => y_power,
                out("s0") _,
                out("s1") _,
                out("s2") _,
                out("s3") _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        [f32::from_bits(x_power), f32::from_bits(y_power)]
    }

    #[inline(always)]
    pub fn three_halves_of_four([a, b, c, d]: [f32; 4]) -> [f32; 4] {
        let Four(a, b, c, d) = three_halves_by_call(a, b, c, d);
        [a, b, c, d]
    }

    /// Four floats that the calling convention returns in s0 to s3.
    #[repr(C)]
    struct Four(f32, f32, f32, f32);

    // SAFETY: takes s0 to s3, returns there, and uses s4 to s7, which are the callee's to use (AAPCS, section 6.1.2).
    #[unsafe(naked)]
    extern "C" fn three_halves_by_call(a: f32, b: f32, c: f32, d: f32) -> Four {
        naked_asm!(
            // Assembly outside a function has no FPU by default.
            ".fpu fpv4-sp-d16",
            "vabs.f32 s4, s0",
            "vabs.f32 s5, s1",
            "vabs.f32 s6, s2",
            "vabs.f32 s7, s3",
            "vsqrt.f32 s4, s4",
            "vsqrt.f32 s5, s5",
            "vsqrt.f32 s6, s6",
            "vsqrt.f32 s7, s7",
            "vmul.f32 s0, s0, s4",
            "vmul.f32 s1, s1, s5",
            "vmul.f32 s2, s2, s6",
            "vmul.f32 s3, s3, s7",
            "bx lr",
        )
    }
}

/// Square root, correctly rounded.
#[inline(always)]
pub fn sqrt_f64(x: f64) -> f64 {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_mm_cvtsd_f64, _mm_set_sd, _mm_sqrt_sd};
        // SAFETY: SSE2 is part of the x86-64 baseline.
        unsafe {
            let vector = _mm_set_sd(x);
            _mm_cvtsd_f64(_mm_sqrt_sd(vector, vector))
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    libm::sqrt(x)
}
