//! Drops and smudges on the lens: discs in which the picture is blurred.

use super::planes::LightPlanes;
use crate::optics::LensDrop;

/// Places at which the picture is read for a blurred pixel, in radii from it: two rings.
const TAPS: [[f32; 2]; 12] = [
    [0.3, 0.0],
    [-0.3, 0.0],
    [0.0, 0.3],
    [0.0, -0.3],
    [0.7, 0.0],
    [0.5, 0.5],
    [0.0, 0.7],
    [-0.5, 0.5],
    [-0.7, 0.0],
    [-0.5, -0.5],
    [0.0, -0.7],
    [0.5, -0.5],
];
/// Share of the light that the rim of a drop keeps.
const RIM: f32 = 0.75;

/// Blurs the picture behind drops.
pub(crate) fn smear(planes: &mut LightPlanes, drops: &[LensDrop]) {
    let (width, height) = (planes.size.width as usize, planes.size.height as usize);
    if drops.is_empty() || width == 0 || height == 0 {
        return;
    }
    let clear = planes.clone();
    for drop in drops {
        let (x, y) = (drop.x * width as f64, drop.y * height as f64);
        let radius = (drop.radius * width as f64).max(1.0);
        // Casts of numbers below zero, or too large, saturate.
        let columns = (x - radius) as usize..((x + radius) as usize + 1).min(width);
        let rows = (y - radius) as usize..((y + radius) as usize + 1).min(height);
        for row in rows {
            for column in columns.clone() {
                let (dx, dy) = (column as f64 - x, row as f64 - y);
                let out = ((dx * dx + dy * dy).sqrt() / radius) as f32;
                if out < 1.0 {
                    blur(planes, &clear, [column, row], out, radius as f32);
                }
            }
        }
    }
}

/// Blurs one pixel at a share `out` of the drop's radius from its middle.
fn blur(planes: &mut LightPlanes, clear: &LightPlanes, at: [usize; 2], out: f32, radius: f32) {
    let (width, height) = (planes.size.width as usize, planes.size.height as usize);
    // Nothing changes at the rim, and most of the disc is blurred whole.
    let weight = (2.0 * (1.0 - out)).min(1.0);
    let kept = 1.0 - (1.0 - RIM) * out * out * weight;
    let place = planes.index(at[0], at[1]);
    for channel in 0..3 {
        let mut sum = 0.0;
        for tap in TAPS {
            let x = (at[0] as f32 + radius * tap[0]).max(0.0) as usize;
            let y = (at[1] as f32 + radius * tap[1]).max(0.0) as usize;
            let beside = clear.index(x.min(width - 1), y.min(height - 1));
            sum += clear.channels[channel][beside];
        }
        let blurred = kept * sum / TAPS.len() as f32;
        let own = clear.channels[channel][place];
        planes.channels[channel][place] = own + weight * (blurred - own);
    }
}

#[cfg(test)]
mod tests {
    use super::super::view::ImageSize;
    use super::*;

    #[test]
    fn a_drop_blurs_inside_of_its_disc_alone() {
        let mut planes = LightPlanes::new(ImageSize::new(100, 80));
        let at = planes.index(50, 40);
        planes.channels[0][at] = 12.0;
        let before = planes.clone();
        let drop = |x| LensDrop {
            x,
            y: 0.5,
            radius: 0.1,
        };
        smear(&mut planes, &[drop(0.5)]);
        assert!(planes.channels[0][at] < 2.0);
        let mut elsewhere = before.clone();
        smear(
            &mut elsewhere,
            &[drop(0.8), drop(-3.0), drop(9.0), drop(f64::NAN)],
        );
        assert_eq!(elsewhere, before);
    }
}
