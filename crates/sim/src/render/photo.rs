//! Pictures as the light that reaches each pixel: through a lens, row by row as a shutter rolls,
//! under any illumination.

use openbench_core::Pose3;
use openbench_scene::Snapshot;
use openbench_scene::bvh::{Kernel, LANES, MISS, PacketHits};

use super::block::{BLOCK, Block, PACKETS, PLACES, SIDE, pixel};
use super::eye::BlockRays;
use super::illumination::{Illumination, Lamp};
use super::lens::Lens;
use super::planes::LightPlanes;
use super::radiance::{Lit, Sight};
use super::shade::{Look, Shader, Surfaces};

/// Where the camera was at an instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// Pose in `map`.
    pub(crate) pose: Pose3,
    /// Time relative to the instant of the movers, seconds; at most 0.
    pub(crate) lag: f32,
}

/// A picture to take.
#[derive(Clone, Copy)]
pub(crate) struct Shot<'a> {
    pub(crate) lens: &'a Lens,
    /// When the camera looks through the first and through the last row. Poses between them are
    /// interpolated.
    pub(crate) moments: &'a [Moment],
    pub(crate) light: &'a Illumination,
    /// The lamps that matter, see [`Illumination::lamps_near`].
    pub(crate) lamps: &'a [Lamp],
    /// Distance at which half of a surface's colour has faded into the haze, metres.
    pub(crate) range: f32,
}

/// A picture that is being taken.
pub(super) struct Taking<'a> {
    pub(super) seen: Snapshot<'a>,
    pub(super) shader: &'a Shader,
    pub(super) shot: Shot<'a>,
    pub(super) planes: &'a mut LightPlanes,
}

impl Kernel for Taking<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            seen,
            shader,
            shot,
            planes,
        } = self;
        let lit = Lit {
            seen,
            light: shot.light,
            lamps: shot.lamps,
            look: Look {
                pixel_angle: 1.0 / shot.lens.focal_length,
                haze: shot.range,
            },
        };
        let mut surfaces = Surfaces::NONE;
        let rows = (planes.size.height as usize).div_ceil(SIDE);
        for row in 0..rows {
            let (above, below) = (gaze(shot, row, rows), gaze(shot, row + 1, rows));
            for column in 0..planes.columns {
                let directions = directions(shot.lens, [column, row], &above, &below);
                let block = BlockRays::new(above.origin, directions, shot.range);
                let hits = seen.cast_block_at(&block.beam, &block.packets, above.lag);
                let sight = Sight {
                    origin: above.origin,
                    directions: &block.directions,
                    hits: &hits,
                    lag: above.lag,
                };
                let light = shader.radiance(&mut surfaces, lit, sight);
                put(planes, [column, row], &light);
                planes.nearness[row * planes.columns + column] = nearness(&hits);
            }
        }
        planes.spread_edges();
    }
}

/// Origin and axes of the camera at an instant, as numbers that can be blended.
struct Gaze {
    origin: [f32; 3],
    /// Forward, left and up.
    axes: [[f32; 3]; 3],
    lag: f32,
}

/// The camera when it reads the row of blocks `row` of so many.
fn gaze(shot: Shot<'_>, row: usize, rows: usize) -> Gaze {
    let between = shot.moments.len().saturating_sub(1);
    let at = (row * between) as f32 / rows as f32;
    let before = (at as usize).min(between);
    let (first, second) = (
        &shot.moments[before],
        &shot.moments[(before + 1).min(between)],
    );
    let share = at - before as f32;
    let (a, b) = (Gaze::of(first), Gaze::of(second));
    let blend = |x: [f32; 3], y: [f32; 3]| [0, 1, 2].map(|i| x[i] + share * (y[i] - x[i]));
    Gaze {
        origin: blend(a.origin, b.origin),
        axes: [0, 1, 2].map(|axis| blend(a.axes[axis], b.axes[axis])),
        lag: a.lag + share * (b.lag - a.lag),
    }
}

impl Gaze {
    fn of(moment: &Moment) -> Self {
        let matrix = moment
            .pose
            .rotation
            .to_rotation_matrix()
            .into_inner()
            .cast::<f32>();
        let column = |i: usize| [matrix[(0, i)], matrix[(1, i)], matrix[(2, i)]];
        Self {
            origin: moment.pose.translation.vector.cast::<f32>().into(),
            axes: [column(0), column(1), column(2)],
            lag: moment.lag,
        }
    }

    #[inline(always)]
    fn turn(&self, [left, up]: [f32; 2]) -> [f32; 3] {
        [0, 1, 2].map(|i| self.axes[0][i] + left * self.axes[1][i] + up * self.axes[2][i])
    }
}

/// Directions through a block's pixels, interpolated between its corners. The upper corners are
/// seen when the block's first row is read, the lower ones when the next block's is.
#[inline(always)]
fn directions(lens: &Lens, [column, row]: [usize; 2], above: &Gaze, below: &Gaze) -> [Block; 3] {
    const STEP: f32 = 1.0 / SIDE as f32;
    let (a, b) = (
        above.turn(lens.corner(column, row)),
        above.turn(lens.corner(column + 1, row)),
    );
    let (c, d) = (
        below.turn(lens.corner(column, row + 1)),
        below.turn(lens.corner(column + 1, row + 1)),
    );
    let mut directions = [[0.0; BLOCK]; 3];
    for (axis, directions) in directions.iter_mut().enumerate() {
        for (i, direction) in directions.iter_mut().enumerate() {
            let (u, v) = (PLACES[0][i] * STEP, PLACES[1][i] * STEP);
            let upper = a[axis] + u * (b[axis] - a[axis]);
            let lower = c[axis] + u * (d[axis] - c[axis]);
            *direction = upper + v * (lower - upper);
        }
    }
    directions
}

/// Mean of the inverse depths, 1/m; the sky has 0.
#[inline(always)]
fn nearness(hits: &[PacketHits; PACKETS]) -> f32 {
    let mut sum = 0.0;
    for packet in hits {
        for lane in 0..LANES {
            if packet.triangle[lane] != MISS && packet.distance[lane] > 0.0 {
                sum += 1.0 / packet.distance[lane];
            }
        }
    }
    sum / BLOCK as f32
}

#[inline(always)]
fn put(planes: &mut LightPlanes, [column, row]: [usize; 2], light: &[Block; 3]) {
    for (channel, light) in light.iter().enumerate() {
        for y in 0..SIDE {
            let at = planes.index(SIDE * column, SIDE * row + y);
            let mut line = [0.0; SIDE];
            for (x, value) in line.iter_mut().enumerate() {
                *value = light[pixel(x, y)];
            }
            planes.channels[channel][at..at + SIDE].copy_from_slice(&line);
        }
    }
}
