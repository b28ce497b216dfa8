//! Rounding down in loops that become vector instructions. A cast from a floating-point number to
//! an integer saturates numbers that are too large, and for that compilers leave vector
//! instructions.

/// `x` minus its floor; 0 from 2^22 on.
#[inline(always)]
pub(crate) fn fraction(x: f32) -> f32 {
    // One and a half times 2^23: the sum with a number has no binary digits behind the point.
    const ROUND: f32 = 12_582_912.0;
    // The nearest integer. Rust keeps the order of floating-point operations, so this is not
    // simplified.
    let near = (x + ROUND) - ROUND;
    let rest = if near > x { x - near + 1.0 } else { x - near };
    if x.abs() < 4_194_304.0 { rest } else { 0.0 }
}

/// The integer part of a number from 0 to 2^22. Other numbers, NaN included, give one of the two
/// bounds.
#[inline(always)]
pub(crate) fn whole(x: f32) -> u32 {
    const ROUND: f32 = 8_388_608.0;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 4_194_304.0 { x } else { 4_194_304.0 };
    // Between 2^23 and 2^24 the bits of the mantissa count units. Where the sum was rounded up, one
    // is taken away.
    let near = x + ROUND;
    (near.to_bits() & 0x7f_ffff) - u32::from(near - ROUND > x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_are_rounded_down_as_by_casts_and_floors(
            x in 0.0_f32..4_194_304.0,
            y in -4_000_000.0_f32..4_000_000.0,
        ) {
            prop_assert_eq!(whole(x), x as u32);
            prop_assert_eq!(whole(x.floor()), x as u32);
            let rest = y - y as i32 as f32;
            prop_assert_eq!(fraction(y), if rest < 0.0 { rest + 1.0 } else { rest });
        }
    }

    #[test]
    fn nan_infinity_and_large_numbers_stay_within_bounds() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -3.0, 1e30] {
            assert!(whole(x) <= 4_194_304, "{x}");
            assert!((0.0..=1.0).contains(&fraction(x)), "{x}");
        }
    }
}
