//! Painted rectangles on the ground.

use openbench_core::Pose2;

use super::inputs::Inputs;
use super::levels::Z_MARKING_M;
use super::output::Output;
use super::shapes::level_rectangle;

/// Paints a rectangle about a pose; length and width in metres.
pub(super) fn paint(inputs: &Inputs, out: &mut Output, pose: Pose2, length: f64, width: f64) {
    if !out.is_full() {
        let paint = inputs.palette.marking;
        level_rectangle(&mut out.scene, paint, pose, length, width, Z_MARKING_M);
    }
}
