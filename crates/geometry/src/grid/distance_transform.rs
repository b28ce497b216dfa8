//! Exact squared Euclidean distance to the nearest marked cell, in linear time.
//!
//! After P. Felzenszwalb and D. Huttenlocher, *Distance Transforms of Sampled Functions*, 2012:
//! along the columns, the lower envelope of parabolas whose heights are the distances along the
//! rows.

/// Columns that are processed together: what a cache line holds of a row.
const BAND: usize = 16;
/// Distance in a row without a marked cell.
// The square of a million cells, far longer than a side of a grid. Sums with it stay finite.
const FAR: f32 = 1e12;

/// Squared distance from each cell's middle to the nearest marked cell's middle, in sides of cells;
/// `width * height` values, row by row. Without any marked cell all distances are huge.
pub fn squared_distances(marked: &[bool], width: usize, height: usize) -> Vec<f32> {
    let mut field = vec![FAR; marked.len()];
    for (row, marks) in field
        .chunks_exact_mut(width.max(1))
        .zip(marked.chunks_exact(width.max(1)))
    {
        along_row(marks, row);
    }
    let mut line = Envelope::new(height);
    // Columns are copied out, transformed and copied back, because a column in place touches one
    // cache line for each row.
    let mut band = vec![0.0; BAND * height];
    for left in (0..width).step_by(BAND) {
        let columns = BAND.min(width - left);
        for y in 0..height {
            let row = &field[y * width + left..][..columns];
            row.iter()
                .enumerate()
                .for_each(|(x, value)| band[x * height + y] = *value);
        }
        for column in band.chunks_exact_mut(height.max(1)).take(columns) {
            line.transform(column);
        }
        for y in 0..height {
            let row = &mut field[y * width + left..][..columns];
            row.iter_mut()
                .enumerate()
                .for_each(|(x, value)| *value = band[x * height + y]);
        }
    }
    field
}

/// Squared distance to the nearest marked cell of the row, if it has any.
fn along_row(marks: &[bool], row: &mut [f32]) {
    let mut last = None;
    for (x, (mark, value)) in marks.iter().zip(row.iter_mut()).enumerate() {
        last = if *mark { Some(x) } else { last };
        if let Some(last) = last {
            let away = (x - last) as f32;
            *value = away * away;
        }
    }
    // From the right: the nearer of both neighbours in the row counts.
    let mut next = None;
    for (x, (mark, value)) in marks.iter().zip(row.iter_mut()).enumerate().rev() {
        next = if *mark { Some(x) } else { next };
        if let Some(next) = next {
            let away = (next - x) as f32;
            *value = value.min(away * away);
        }
    }
}

/// Lower envelope of the parabolas over one line.
struct Envelope {
    apex: Vec<usize>,
    border: Vec<f32>,
    value: Vec<f32>,
}

impl Envelope {
    fn new(length: usize) -> Self {
        Self {
            apex: vec![0; length],
            border: vec![0.0; length + 1],
            value: vec![0.0; length],
        }
    }

    /// Lowers the values of a line to the envelope.
    fn transform(&mut self, line: &mut [f32]) {
        // `line` is overwritten while the heights of parabolas are still needed.
        self.value[..line.len()].copy_from_slice(line);
        // Without a marked cell there is no parabola.
        let mut known = (0..line.len()).filter(|q| line[*q] < FAR);
        let Some(first) = known.next() else { return };
        let mut last = 0;
        (self.apex[0], self.border[0], self.border[1]) = (first, f32::NEG_INFINITY, f32::INFINITY);
        for q in known {
            let mut s = self.meeting(q, self.apex[last]);
            // The last parabola is lowest nowhere: the new one is below it before its stretch
            // begins. The first border is minus infinity, so one parabola always remains.
            while s <= self.border[last] {
                last -= 1;
                s = self.meeting(q, self.apex[last]);
            }
            last += 1;
            (self.apex[last], self.border[last], self.border[last + 1]) = (q, s, f32::INFINITY);
        }
        // Parabola `k` is lowest from border `k` to border `k + 1`; both ascend with `q`.
        let mut k = 0;
        for (q, lowest) in line.iter_mut().enumerate() {
            while self.border[k + 1] < q as f32 {
                k += 1;
            }
            let away = q as f32 - self.apex[k] as f32;
            *lowest = away * away + self.value[self.apex[k]];
        }
    }

    /// Where the parabolas with apexes `q` and `p` meet.
    fn meeting(&self, q: usize, p: usize) -> f32 {
        let (fq, fp) = (q as f32, p as f32);
        // The x at which (x - q)^2 + value(q) equals (x - p)^2 + value(p). Apexes differ, so the
        // divisor is not 0.
        ((self.value[q] + fq * fq) - (self.value[p] + fp * fp)) / (2.0 * (fq - fp))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distances_are_those_of_a_loop_over_all_marked_cells(
            marks in prop::collection::vec(prop::bool::weighted(0.1), 12 * 9),
        ) {
            let (width, height) = (12, 9);
            let field = squared_distances(&marks, width, height);
            for (i, &distance) in field.iter().enumerate() {
                let nearest = (0..marks.len()).filter(|&j| marks[j]).map(|j| {
                    let dx = (i % width).abs_diff(j % width);
                    let dy = (i / width).abs_diff(j / width);
                    (dx * dx + dy * dy) as f32
                }).reduce(f32::min);
                match nearest {
                    Some(d) => prop_assert_eq!(distance, d),
                    None => prop_assert!(distance > 1e11),
                }
            }
        }
    }
}
