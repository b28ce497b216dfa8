//! Comparisons and choices without a branch: a branch for each lane would keep the compiler from
//! using vector instructions.

#[inline(always)]
pub(super) fn lower(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(super) fn upper(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Ones in every bit if `holds`, else zeros.
#[inline(always)]
pub(super) fn mask(holds: bool) -> u32 {
    u32::from(holds).wrapping_neg()
}

/// `yes` where `mask` is ones, `no` where it is zeros.
#[inline(always)]
pub(super) fn select(mask: u32, yes: f32, no: f32) -> f32 {
    f32::from_bits((yes.to_bits() & mask) | (no.to_bits() & !mask))
}
