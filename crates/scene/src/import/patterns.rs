//! Procedural images: wood, asphalt with lane markings, paving. Each covers a known number of
//! metres.

use crate::Texture;

/// A procedural image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Pattern {
    /// Boards, upright.
    Wood,
    /// A carriageway: edge lines, and a broken line in the middle; u runs across, v along.
    MarkedRoad,
    /// Slabs.
    Paving,
}

const EDGE: u32 = 128;

impl Pattern {
    /// Metres that the image covers along u and v. The u of a road covers its width, whatever that
    /// is.
    pub(crate) fn metres(self) -> [f64; 2] {
        match self {
            Self::Wood => [1.2, 2.4],
            Self::MarkedRoad => [1.0, 8.0],
            Self::Paving => [1.2, 1.2],
        }
    }

    /// The image.
    pub(crate) fn draw(self) -> Texture {
        let texel = |i: u32| {
            let (x, y) = (i % EDGE, i / EDGE);
            let [r, g, b] = match self {
                Self::Wood => wood(x, y),
                Self::MarkedRoad => marked_road(x, y),
                Self::Paving => paving(x, y),
            };
            [r, g, b, 255]
        };
        let rgba: Vec<u8> = (0..EDGE * EDGE).flat_map(texel).collect();
        Texture {
            width: EDGE,
            height: EDGE,
            rgba: rgba.into(),
        }
    }
}

fn wood(x: u32, y: u32) -> [u8; 3] {
    let board = x / 16;
    let tone = 40 * noise(board, 7) / 255 + 18 * noise(x, y / 24) / 255;
    let gap = if x.is_multiple_of(16) { 60 } else { 0 };
    [150, 110, 72].map(|c: u32| (c + tone).saturating_sub(gap) as u8)
}

fn marked_road(x: u32, y: u32) -> [u8; 3] {
    let grain = 26 * noise(x, y) / 255;
    let edge_line = matches!(x, 4..=6 | 121..=123);
    let middle_line = matches!(x, 63..=64) && y < EDGE / 2;
    let base = if edge_line || middle_line { 205 } else { 66 };
    [base + grain, base + grain, base + grain + 3].map(|c| c as u8)
}

fn paving(x: u32, y: u32) -> [u8; 3] {
    let row = y / 32;
    let joint = y.is_multiple_of(32) || (x + 32 * (row % 2)).is_multiple_of(64);
    let tone = 25 * noise((x + 32 * (row % 2)) / 64, row) / 255 + 12 * noise(x, y) / 255;
    let base = if joint { 110 } else { 150 };
    [base + tone, base + tone, base + tone - 4].map(|c| c as u8)
}

/// A fixed number from 0 to 255 for each pair.
fn noise(x: u32, y: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    (h ^ (h >> 15)) & 255
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roads_have_light_lines_on_dark_ground() {
        let road = Pattern::MarkedRoad.draw();
        let at = |x: u32, y: u32| road.rgba[(4 * (y * EDGE + x)) as usize];
        assert!(
            at(63, 10) > 180 && at(63, 100) < 110,
            "the middle line is broken"
        );
        assert!(at(5, 10) > 180 && at(5, 100) > 180, "the edge line is not");
        assert!(at(30, 10) < 110);
    }
}
