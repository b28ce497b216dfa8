//! The order in which a scan's rays are cast: rays of similar direction make a packet.

use super::pattern::{Aim, LINES};

/// Buckets round the azimuth and along the elevation: 5 by 4 degrees, with a packet's sixteen rays
/// or so in each.
const COLUMNS: usize = 72;
const ROWS: usize = 16;
const BUCKETS: usize = COLUMNS * ROWS;
/// Elevations between which rays point, radians, with a little room.
const LOWEST_RAD: f32 = -0.13;
const HIGHEST_RAD: f32 = 0.92;

/// Rays sorted by direction, by counting sort.
#[derive(Debug)]
pub(super) struct CastingOrder {
    /// Numbers of the rays in the order of casting.
    pub(super) rays: Vec<u32>,
    /// Bucket of each ray.
    buckets: Vec<u16>,
    /// First place of each bucket in `rays`, while sorting.
    begins: [u32; BUCKETS + 1],
}

impl CastingOrder {
    /// An order of this many rays.
    pub(super) fn new(rays: usize) -> Self {
        Self {
            rays: vec![0; rays],
            buckets: vec![0; rays],
            begins: [0; BUCKETS + 1],
        }
    }

    /// Forgets all directions.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.begins.fill(0);
    }

    /// Takes in the directions of rays number `first` and those after it.
    #[inline(always)]
    pub(super) fn note(&mut self, first: usize, aims: &[Aim]) {
        for (slot, aim) in self.buckets[first..][..aims.len()].iter_mut().zip(aims) {
            let bucket = bucket(aim);
            *slot = bucket as u16;
            self.begins[bucket + 1] += 1;
        }
    }

    /// Sorts the rays of every `stride`th firing, after all directions have been noted.
    #[inline(always)]
    pub(super) fn sort(&mut self, stride: usize) {
        self.rays.resize(self.buckets.len(), 0);
        // The counts stand one place too far right, so their running sums are where buckets begin.
        for bucket in 0..BUCKETS {
            self.begins[bucket + 1] += self.begins[bucket];
        }
        // In the order of firing within a bucket: the sort is stable, and the order of casting is
        // fixed.
        for (ray, bucket) in self.buckets.iter().enumerate() {
            let place = &mut self.begins[usize::from(*bucket)];
            self.rays[*place as usize] = ray as u32;
            *place += 1;
        }
        if stride > 1 {
            self.rays.retain(|ray| firing(*ray).is_multiple_of(stride));
        }
    }
}

/// The firing of a ray.
#[inline(always)]
fn firing(ray: u32) -> usize {
    ray as usize / LINES
}

#[inline(always)]
fn bucket(aim: &Aim) -> usize {
    // Rounding may give a whole turn; casts of negative numbers saturate at 0.
    let column = ((aim.turn * COLUMNS as f32) as usize).min(COLUMNS - 1);
    let height = (aim.elevation - LOWEST_RAD) / (HIGHEST_RAD - LOWEST_RAD);
    let row = ((height * ROWS as f32) as usize).min(ROWS - 1);
    // Up one column, down the next: a packet that ends one column begins the next beside it.
    column * ROWS
        + if column.is_multiple_of(2) {
            row
        } else {
            ROWS - 1 - row
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_sorted_by_bucket_and_keep_their_order_within_one() {
        let aim = |turn: f32| Aim {
            turn,
            ..Aim::default()
        };
        let mut order = CastingOrder::new(4);
        order.clear();
        order.note(0, &[aim(0.9), aim(0.1)]);
        order.note(2, &[aim(0.9), aim(0.5)]);
        order.sort(1);
        assert_eq!(order.rays, [1, 3, 0, 2]);
    }
}
