//! The one module that may be unsafe: it reaches the square root of the target.
//!
//! Every path is correctly rounded (IEEE 754), so the choice never changes a result.
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
        let root: u32;
        // SAFETY: one instruction that the target has; it touches no memory and only the registers named. Operands go
        // through core registers because stable Rust takes no floating-point ones here.
        unsafe {
            core::arch::asm!(
                "vmov s0, {x}",
                "vsqrt.f32 s0, s0",
                "vmov {root}, s0",
                x = in(reg) x.to_bits(),
                root = lateout(reg) root,
                out("s0") _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        f32::from_bits(root)
    }
    #[cfg(not(any(target_arch = "x86_64", vsqrt)))]
    libm::sqrtf(x)
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
