//! Rounding down in loops that shall become vector instructions: a cast from a floating to a whole number does it too, and sees to numbers that
//! are too large, for which the compiler leaves vectors.

/// `x` less its floor; 0 from 2^22 on.
#[inline(always)]
pub(crate) fn fraction(x: f32) -> f32 {
    // One and a half times 2^23: added to a number, it leaves no place for binary digits behind the point.
    const ROUND: f32 = 12_582_912.0;
    let near = (x + ROUND) - ROUND;
    let rest = if near > x { x - near + 1.0 } else { x - near };
    if x.abs() < 4_194_304.0 { rest } else { 0.0 }
}

/// The whole part of a number from 0 to 2^22; of others one of these. A cast does the same and more, for which no compiler uses vectors.
#[inline(always)]
pub(crate) fn whole(x: f32) -> u32 {
    const ROUND: f32 = 8_388_608.0;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 4_194_304.0 { x } else { 4_194_304.0 };
    let near = x + ROUND;
    (near.to_bits() & 0x7f_ffff) - u32::from(near - ROUND > x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_are_rounded_down_as_casts_and_floors_do(x in 0.0_f32..4_194_304.0, y in -4_000_000.0_f32..4_000_000.0) {
            prop_assert_eq!(whole(x), x as u32);
            prop_assert_eq!(whole(x.floor()), x as u32);
            let rest = y - y as i32 as f32;
            prop_assert_eq!(fraction(y), if rest < 0.0 { rest + 1.0 } else { rest });
        }
    }

    #[test]
    fn what_is_no_sensible_number_gives_some_number() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -3.0, 1e30] {
            assert!(whole(x) <= 4_194_304, "{x}");
            assert!((0.0..=1.0).contains(&fraction(x)), "{x}");
        }
    }
}
