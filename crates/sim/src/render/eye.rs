//! The rays through the pixels of a view.

use nalgebra::Vector3;
use openbench_scene::RayPacket;
use openbench_scene::bvh::{Beam, LANES};

use super::block::{BLOCK, Block, Corner, PACKETS, PLACES, SIDE, pixel};
use super::view::View;

/// Origin and directions of a view's rays. Directions have length 1 along the optical axis.
pub(super) struct Eye {
    origin: [f32; 3],
    /// Direction through the middle of the top left pixel.
    corner: [f32; 3],
    /// Change of the direction from one column to the next.
    right: [f32; 3],
    /// Change of the direction from one row to the next.
    down: [f32; 3],
    /// Angle of a pixel, radians.
    pub(super) pixel_angle: f32,
}

/// The rays of a block.
pub(super) struct BlockRays {
    pub(super) directions: [Block; 3],
    /// The same rays in packets.
    pub(super) packets: [RayPacket; PACKETS],
    pub(super) beam: Beam,
}

impl Eye {
    pub(super) fn new(view: &View) -> Self {
        let forward = view.pose.rotation * Vector3::x();
        let left = view.pose.rotation * Vector3::y();
        let up = view.pose.rotation * Vector3::z();
        let f = view.focal_length;
        let (w, h) = (f64::from(view.size.width), f64::from(view.size.height));
        let corner = forward + left * ((w - 1.0) / 2.0 / f) + up * ((h - 1.0) / 2.0 / f);
        Self {
            origin: single(view.pose.translation.vector),
            corner: single(corner),
            right: single(-left / f),
            down: single(-up / f),
            pixel_angle: (1.0 / f) as f32,
        }
    }

    /// The rays through a block. They end at `limit` metres along the optical axis.
    #[inline(always)]
    pub(super) fn block(&self, corner: Corner, limit: f32) -> BlockRays {
        let (x, y) = (corner.x as f32, corner.y as f32);
        let mut directions = [[0.0; BLOCK]; 3];
        for (axis, directions) in directions.iter_mut().enumerate() {
            for (i, direction) in directions.iter_mut().enumerate() {
                let (u, v) = (x + PLACES[0][i], y + PLACES[1][i]);
                *direction = self.corner[axis] + u * self.right[axis] + v * self.down[axis];
            }
        }
        BlockRays::new(self.origin, directions, limit)
    }
}

impl BlockRays {
    /// Rays from a point. They end at `limit` lengths of their directions.
    #[inline(always)]
    pub(super) fn new(origin: [f32; 3], directions: [Block; 3], limit: f32) -> Self {
        let [ox, oy, oz] = origin;
        let mut packets = [const { RayPacket::idle() }; PACKETS];
        for (i, rays) in packets.iter_mut().enumerate() {
            rays.origin = [[ox; LANES], [oy; LANES], [oz; LANES]];
            rays.limit = [limit; LANES];
            for (packet, directions) in rays.direction.iter_mut().zip(&directions) {
                packet.copy_from_slice(&directions[i * LANES..][..LANES]);
            }
        }
        // Every ray of the block lies between those of its corner pixels, so the beam holds them
        // all.
        const END: usize = SIDE - 1;
        const CORNERS: [usize; 4] = [pixel(0, 0), pixel(END, 0), pixel(END, END), pixel(0, END)];
        let mut corners = [[0.0; 3]; 4];
        for (corner, i) in corners.iter_mut().zip(CORNERS) {
            *corner = [directions[0][i], directions[1][i], directions[2][i]];
        }
        Self {
            directions,
            packets,
            beam: Beam::new(origin, &corners),
        }
    }
}

fn single(v: Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
