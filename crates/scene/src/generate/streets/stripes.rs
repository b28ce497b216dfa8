//! Painted rectangles on the ground.

use openbench_core::Pose2;

use crate::generate::ground::levels::Z_MARKING_M;
use crate::generate::inputs::Inputs;
use crate::generate::output::Output;
use crate::generate::shapes::level_rectangle;

/// Paints a rectangle about a pose; length and width in metres.
pub(super) fn paint(inputs: &Inputs, out: &mut Output, pose: Pose2, length: f64, width: f64) {
    if !out.is_full() {
        let paint = inputs.palette.marking;
        level_rectangle(&mut out.scene, paint, pose, length, width, Z_MARKING_M);
    }
}
