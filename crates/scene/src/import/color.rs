//! Colours of imported materials.

/// A colour with its channels limited to 0 to 1; `None` if one is no finite number, as in damaged
/// files.
pub(crate) fn color(channels: [f32; 3]) -> Option<[f32; 3]> {
    let is_colour = channels.iter().all(|channel| channel.is_finite());
    is_colour.then(|| channels.map(|channel| channel.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_limited_and_what_is_no_number_is_no_colour() {
        assert_eq!(color([-1.0, 0.5, 7.0]), Some([0.0, 0.5, 1.0]));
        assert_eq!(color([0.0, f32::NAN, 0.0]), None);
        assert_eq!(color([f32::INFINITY, 0.0, 0.0]), None);
    }
}
