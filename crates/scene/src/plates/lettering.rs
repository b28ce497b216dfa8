//! Lines of text as coverage: the share of ink in each texel.

use super::typefaces::Typeface;

/// Characters that are drawn at most: memory must not grow with what a map says.
const LONGEST_TEXT: usize = 32;
/// Space between letters in addition to the font's own, in heights of a capital.
const TRACKING: f32 = 0.02;

/// A drawn line of text.
#[derive(Debug, Clone)]
pub(super) struct Lettering {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Row in which capitals begin; accents are above it.
    pub capital_top: usize,
    /// Height of the capitals, texels.
    pub capital: usize,
    ink: Vec<f32>,
}

/// A glyph and its place: the column of its left edge, and the row of its top above the baseline.
struct Placed {
    left: i32,
    top: i32,
    width: usize,
    ink: Vec<u8>,
}

impl Lettering {
    /// Draws a line with capitals of so many texels.
    pub fn draw(text: &str, typeface: &Typeface, capital: usize) -> Self {
        let font = typeface.font();
        // A font's size is not the height of its capitals: it is scaled by that of an H.
        let px = capital as f32 * 1000.0 / font.metrics('H', 1000.0).height.max(1) as f32;
        let mut pen = 0.0_f32;
        let mut glyphs = Vec::new();
        for c in text.chars().take(LONGEST_TEXT) {
            let (metrics, ink) = font.rasterize(c, px);
            if metrics.width > 0 {
                glyphs.push(Placed {
                    left: pen as i32 + metrics.xmin,
                    top: metrics.ymin + metrics.height as i32,
                    width: metrics.width,
                    ink,
                });
            }
            pen += metrics.advance_width + TRACKING * capital as f32;
        }
        Self::of_glyphs(&glyphs, capital)
    }

    fn of_glyphs(glyphs: &[Placed], capital: usize) -> Self {
        let left = glyphs.iter().map(|g| g.left).min().unwrap_or(0);
        let right = glyphs.iter().map(|g| g.left + g.width as i32).max();
        let rows = |g: &Placed| (g.ink.len() / g.width) as i32;
        let capital_rows = capital as i32;
        let top = glyphs.iter().map(|g| g.top).max().unwrap_or(0);
        let top = top.max(capital_rows);
        let bottom = glyphs.iter().map(|g| g.top - rows(g)).min().unwrap_or(0);
        let bottom = bottom.min(0);
        let width = (right.unwrap_or(1) - left).max(1) as usize;
        let height = (top - bottom).max(1) as usize;
        let mut ink = vec![0.0_f32; width * height];
        for glyph in glyphs {
            for (i, value) in glyph.ink.iter().enumerate() {
                let x = (glyph.left - left) as usize + i % glyph.width;
                let y = (top - glyph.top) as usize + i / glyph.width;
                // Boxes of neighbouring glyphs may overlap.
                let texel = &mut ink[y * width + x];
                *texel = texel.max(f32::from(*value) / 255.0);
            }
        }
        Self {
            width,
            height,
            capital_top: (top - capital_rows) as usize,
            capital,
            ink,
        }
    }

    /// Share of ink in a texel; none outside.
    pub fn at(&self, x: i32, y: i32) -> f32 {
        let inside = (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y);
        if inside {
            self.ink[y as usize * self.width + x as usize]
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::typefaces::typefaces;
    use super::*;

    #[test]
    fn capitals_have_the_height_that_was_asked_for() {
        for face in typefaces() {
            let line = Lettering::draw("H", face, 40);
            let rows: Vec<i32> = (0..line.height as i32)
                .filter(|y| (0..line.width as i32).any(|x| line.at(x, *y) > 0.5))
                .collect();
            assert!(
                rows.len().abs_diff(40) <= 4,
                "{}: {}",
                face.name,
                rows.len()
            );
        }
    }

    #[test]
    fn odd_texts_do_not_panic() {
        let long = "W".repeat(10_000);
        for text in ["", " ", "\u{0}\u{1F4E6}", &long] {
            let line = Lettering::draw(text, &typefaces()[0], 20);
            assert!(line.width >= 1 && line.width < 2_000);
        }
    }
}
