//! The square root of an `f32`, correctly rounded: by the FPU where the chip has one, by `libm` elsewhere. IEEE 754 leaves one result, so
//! the bits are the same.
//!
//! The only instruction of this crate that the compiler does not choose by itself: no safe function gives it without the standard
//! library. An `f64` stays with `libm`, for a processor of this target may compute `f32` alone, and nothing tells which it is.

/// √x of x ≥ 0; NaN of anything else.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[inline]
#[allow(unsafe_code)]
pub(super) fn sqrt(x: f32) -> f32 {
    let root: f32;
    // SAFETY: reads one register of the FPU and writes another; its flags are sticky and nobody reads them.
    unsafe {
        core::arch::asm!(
            "vsqrt.f32 {root}, {x}", root = lateout(sreg) root, x = in(sreg) x,
            options(pure, nomem, nostack, preserves_flags)
        );
    }
    root
}

#[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
pub(super) use libm::sqrtf as sqrt;
