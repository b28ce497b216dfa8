//! Procedural images of windows, doors and fence panels.

use super::images::{paint, rgb, speck};
use crate::material::Texture;

/// Width of a window with its shutters, in widths of the window.
pub(crate) const SHUTTERED_WIDTHS: f64 = 1.8;

/// How a window is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Glazing {
    /// One large pane.
    Single,
    /// Two casements.
    Casements,
    /// Two by three small panes.
    Sash,
}

/// A window: frame, panes with a reflection of the sky, curtains behind.
pub(super) fn window(frame: [f32; 3], glazing: Glazing, curtains: bool, seed: u64) -> Texture {
    let (width, height) = (96_u32, 112_u32);
    paint(width, height, |x, y| {
        let border = x < 7 || x >= width - 7 || y < 7 || y >= height - 7;
        if border || is_bar([x, y], [width, height], glazing) {
            // Lit from above left, as a moulding would be.
            let shade = if x < 2 || y < 2 {
                1.0
            } else if x + 2 >= width || y + 2 >= height {
                0.72
            } else {
                0.92
            };
            return rgb(frame, shade);
        }
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        let reveal = if x < 11 || y < 13 { 0.55 } else { 1.0 };
        if curtains && !(0.24..=0.76).contains(&u) {
            let fold = if (x / 3) % 2 == 0 { 0.86 } else { 0.74 };
            return rgb([0.88, 0.86, 0.80], fold * reveal * 0.85);
        }
        let streak = if (u + v * 0.7 + 0.2).fract() < 0.22 {
            0.16
        } else {
            0.0
        };
        let sky = 0.50 - 0.26 * v + streak;
        rgb(
            [0.62 + 0.1 * v, 0.76, 0.90],
            (sky + 0.03 * speck(x, y, seed)) * reveal,
        )
    })
}

/// A window between open shutters of horizontal slats; `widths` is the width of the whole in widths
/// of the window.
pub(super) fn with_shutters(window: &Texture, color: [f32; 3], widths: f64) -> Texture {
    let width = (f64::from(window.width) * widths) as u32;
    let side = (width - window.width) / 2;
    paint(width, window.height, |x, y| {
        if (side..side + window.width).contains(&x) {
            let at = 4 * (y * window.width + x - side) as usize;
            return [
                window.rgba[at],
                window.rgba[at + 1],
                window.rgba[at + 2],
                255,
            ];
        }
        let across = if x < side { x } else { x - side - window.width };
        let frame = across < 4
            || across + 4 >= side
            || y < 5
            || y + 5 >= window.height
            || y.abs_diff(56) < 3;
        let slat = [0.62, 0.74, 0.90, 1.0, 0.98, 0.84][(y % 6) as usize];
        rgb(color, if frame { 0.92 } else { slat })
    })
}

/// A shop window: large panes with bright goods behind them. There are two looks.
pub(super) fn shop_window(look: u32, seed: u64) -> Texture {
    let (width, height) = (160_u32, 112_u32);
    paint(width, height, |x, y| {
        let bar = x < 5 || x + 5 >= width || y < 5 || y + 5 >= height;
        if bar || look == 0 && x.abs_diff(width / 2) < 3 || look == 1 && y.abs_diff(height / 4) < 2
        {
            return rgb([0.22, 0.23, 0.25], 0.9);
        }
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        let streak = if (u + v * 0.6 + 0.3).fract() < 0.16 {
            0.12
        } else {
            0.0
        };
        // Goods on shelves, dim behind the glass.
        let (shelf, place) = (y / 22, x / 12);
        let is_good =
            y % 22 > 6 + (speck(place, shelf, seed) * 9.0) as u32 && x % 12 > 2 && v > 0.28;
        if is_good {
            let hue = |k: u32| 0.35 + 0.6 * speck(place * 3 + k, shelf + 7 * look, seed ^ 5);
            return rgb([hue(0), hue(1), hue(2)], 0.80 + streak);
        }
        rgb([0.90, 0.84, 0.70], 0.52 + 0.18 * (1.0 - v) + streak)
    })
}

/// Stripes for awnings, light and dark, grey for tinting.
pub(super) fn stripes() -> Texture {
    paint(64, 64, |x, _| {
        rgb([1.0; 3], if x / 16 % 2 == 0 { 1.0 } else { 0.62 })
    })
}

/// Whether a texel belongs to a glazing bar of a window of this size, texels.
fn is_bar([x, y]: [u32; 2], [width, height]: [u32; 2], glazing: Glazing) -> bool {
    match glazing {
        Glazing::Single => is_within(y, height / 4, 2),
        Glazing::Casements => is_within(x, width / 2, 3),
        Glazing::Sash => {
            is_within(x, width / 2, 1)
                || is_within(y, height / 2, 2)
                || is_within(y, height / 4, 1)
                || is_within(y, 3 * height / 4, 1)
        }
    }
}

/// Whether a texel lies within `half` texels of the middle of a bar.
fn is_within(texel: u32, middle: u32, half: u32) -> bool {
    texel.abs_diff(middle) <= half
}

/// A panelled door leaf with a handle, grey for tinting; glazed at the top if `glass`.
pub(super) fn door(glass: bool) -> Texture {
    let (width, height) = (96_u32, 192_u32);
    paint(width, height, |x, y| {
        if (76..86).contains(&x) && (98..102).contains(&y)
            || (81..86).contains(&x) && (92..112).contains(&y)
        {
            return rgb([0.95, 0.9, 0.75], 0.95);
        }
        let Some(InPanel { inset, in_shade }) = door_panel(x, y) else {
            return rgb([1.0; 3], 0.88 - 0.02 * speck(x / 2, y / 16, 1));
        };
        if glass && y < 84 && inset > 3 {
            let streak = if (x + y / 2) % 48 < 12 { 0.16 } else { 0.0 };
            return rgb([0.55, 0.68, 0.78], 0.55 + streak);
        }
        rgb(
            [1.0; 3],
            if inset <= 2 {
                if in_shade { 0.55 } else { 0.98 }
            } else {
                0.78
            },
        )
    })
}

/// A texel in a panel of a door.
struct InPanel {
    /// Distance from the nearest edge of the panel, texels.
    inset: u32,
    /// Whether that edge is in shade: light comes from above left.
    in_shade: bool,
}

/// The place of a texel in the panel of a door; `None` outside of panels.
fn door_panel(x: u32, y: u32) -> Option<InPanel> {
    let columns = [(12_u32, 44_u32), (52, 74)];
    let rows = [(12_u32, 84_u32), (116, 180)];
    let (left, right) = columns.into_iter().find(|c| (c.0..c.1).contains(&x))?;
    let (top, bottom) = rows.into_iter().find(|r| (r.0..r.1).contains(&y))?;
    let (near, far) = ((x - left).min(y - top), (right - 1 - x).min(bottom - 1 - y));
    Some(InPanel {
        inset: near.min(far),
        // The nearest edge is the upper or the left one, which lies in the shade of its moulding.
        in_shade: near <= far,
    })
}

/// A garage door of horizontal leaves, grey for tinting.
pub(super) fn garage() -> Texture {
    paint(128, 128, |x, y| {
        let groove = y % 26 < 2 || x % 32 < 1;
        rgb(
            [1.0; 3],
            if groove {
                0.6
            } else {
                0.9 - 0.02 * speck(x / 4, y / 4, 2)
            },
        )
    })
}

/// Pickets with gaps between them, grey for tinting; the image is about 1 m wide.
pub(super) fn pickets() -> Texture {
    paint(128, 128, |x, y| {
        let picket = x % 16 < 10 && y >= (x % 16).abs_diff(5);
        let rail = (22..32).contains(&y) || (92..102).contains(&y);
        let mut texel = rgb(
            [1.0; 3],
            if picket {
                0.9 - 0.1 * speck(x / 16, 0, 6)
            } else {
                0.72
            },
        );
        texel[3] = if picket || rail { 255 } else { 0 };
        texel
    })
}

/// Upright bars between two rails; the image is about 1 m wide.
pub(super) fn railings() -> Texture {
    paint(128, 128, |x, y| {
        let solid = x % 16 < 3 || (4..9).contains(&y) || (116..121).contains(&y);
        let mut texel = rgb([1.0; 3], if x % 16 == 0 { 0.95 } else { 0.75 });
        texel[3] = if solid { 255 } else { 0 };
        texel
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_has_a_frame_and_darker_panes() {
        let image = window([1.0; 3], Glazing::Casements, false, 1);
        let luma = |x: u32, y: u32| u32::from(image.rgba[4 * (y * image.width + x) as usize + 1]);
        assert!(luma(3, 50) > 200 && luma(48, 50) > 200);
        assert!(luma(30, 80) < 150);
    }
}
