//! Exact squared Euclidean distance to the nearest marked cell, in linear time.
//!
//! After Felzenszwalb and Huttenlocher, *Distance Transforms of Sampled Functions*, 2012: the lower envelope of
//! parabolas along the rows, then along the columns.

/// Squared distance in cells from each cell's middle to the nearest marked cell's middle; `width * height` values row by
/// row. Where nothing is marked all distances are huge.
pub fn squared_distances(marked: &[bool], width: usize, height: usize) -> Vec<f32> {
    const FAR: f32 = 1e12;
    let mut field: Vec<f32> = marked.iter().map(|&m| if m { 0.0 } else { FAR }).collect();
    let mut line = Envelope::new(width.max(height));
    for row in field.chunks_exact_mut(width.max(1)) {
        line.transform(row.len(), |i| row[i]);
        row.copy_from_slice(&line.result[..width]);
    }
    for x in 0..width {
        line.transform(height, |y| field[y * width + x]);
        for y in 0..height {
            field[y * width + x] = line.result[y];
        }
    }
    field
}

/// Lower envelope of parabolas over one line.
struct Envelope {
    apex: Vec<usize>,
    border: Vec<f32>,
    value: Vec<f32>,
    result: Vec<f32>,
}

impl Envelope {
    fn new(length: usize) -> Self {
        Self {
            apex: vec![0; length],
            border: vec![0.0; length + 1],
            value: vec![0.0; length],
            result: vec![0.0; length],
        }
    }

    fn transform(&mut self, length: usize, sample: impl Fn(usize) -> f32) {
        for i in 0..length {
            self.value[i] = sample(i);
        }
        let mut last = 0;
        (self.apex[0], self.border[0], self.border[1]) = (0, f32::NEG_INFINITY, f32::INFINITY);
        for q in 1..length {
            let mut s = self.meeting(q, self.apex[last]);
            while s <= self.border[last] {
                last -= 1;
                s = self.meeting(q, self.apex[last]);
            }
            last += 1;
            (self.apex[last], self.border[last], self.border[last + 1]) = (q, s, f32::INFINITY);
        }
        let mut k = 0;
        for q in 0..length {
            while self.border[k + 1] < q as f32 {
                k += 1;
            }
            let away = q as f32 - self.apex[k] as f32;
            self.result[q] = away * away + self.value[self.apex[k]];
        }
    }

    /// Where the parabolas with apexes `q` and `p` meet.
    fn meeting(&self, q: usize, p: usize) -> f32 {
        let (fq, fp) = (q as f32, p as f32);
        ((self.value[q] + fq * fq) - (self.value[p] + fp * fp)) / (2.0 * (fq - fp))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn equals_the_loop_over_all_marked_cells(marks in prop::collection::vec(prop::bool::weighted(0.1), 12 * 9)) {
            let (width, height) = (12, 9);
            let field = squared_distances(&marks, width, height);
            for (i, &distance) in field.iter().enumerate() {
                let nearest = (0..marks.len()).filter(|&j| marks[j]).map(|j| {
                    let (dx, dy) = ((i % width).abs_diff(j % width), (i / width).abs_diff(j / width));
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
