//! Rays into a scene: what they hit, and its surface.
//!
//! What most hits need of a triangle is in tables of their own: in a scene, triangles, vertices,
//! materials and textures are four places far apart in memory.

use std::ops::Range;
use std::sync::Arc;

use crate::bvh::{
    Beam, CastAmong, Hit, LANES, Lane, MISS, Movers, PacketHits, RayPacket, TriangleBvh, widest,
};
use crate::material::{Finish, Material, Texture};
use crate::scene::{Scene, Triangle};

/// A scene that rays can be cast into. Cheap to clone, and can be shared between threads.
#[derive(Debug, Clone)]
pub struct RayCaster {
    scene: Arc<Scene>,
    visible: Arc<TriangleBvh>,
    figures: Arc<[TriangleBvh]>,
    solid: Arc<TriangleBvh>,
    surfaces: Arc<[Surface]>,
    /// Texture coordinates of each triangle's corners.
    corners: Arc<[[[f32; 2]; 3]]>,
    /// For each material the holes in its texture, if it has any.
    holes: Arc<[Option<Holes>]>,
}

/// The holes of a texture: a bit for each texel.
#[derive(Debug)]
struct Holes {
    width: u32,
    height: u32,
    bits: Vec<u64>,
}

impl Holes {
    fn of(texture: &Texture) -> Self {
        let mut bits = vec![0; (texture.width as usize * texture.height as usize).div_ceil(64)];
        for (i, texel) in texture.rgba.chunks_exact(4).enumerate() {
            // A bit instead of four bytes a texel, so that look-ups touch little memory.
            bits[i / 64] |= u64::from(texel[3] < 128) << (i % 64);
        }
        Self {
            width: texture.width,
            height: texture.height,
            bits,
        }
    }

    /// Whether the texel at `uv` is a hole; the image repeats and v runs upwards.
    #[inline]
    fn has(&self, uv: [f32; 2]) -> bool {
        // Rounding may give the whole width.
        let x = ((fraction(uv[0]) * self.width as f32) as u32).min(self.width - 1);
        let y = (((1.0 - fraction(uv[1])) * self.height as f32) as u32).min(self.height - 1);
        let i = y as usize * self.width as usize + x as usize;
        self.bits[i / 64] >> (i % 64) & 1 != 0
    }
}

/// What most hits need of a triangle, in one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Unit normal, on the side from which the corners are counter-clockwise; of a figure in its
    /// own axes.
    pub normal: [f32; 3],
    /// Share of the LiDAR light that is reflected at normal incidence, 0 to 255.
    pub reflectivity: u8,
    /// How it meets light beyond that.
    pub finish: Finish,
    material: u32,
}

impl RayCaster {
    /// Builds the trees over the scene's visible and solid triangles, and one for each of its
    /// figures.
    pub fn new(scene: Arc<Scene>) -> Self {
        let corner = |i: u32| scene.vertices[i as usize].position;
        // Only cut-out materials can have holes, and only their triangles pay for the test.
        let cutout =
            |i: u32| scene.materials[scene.triangles[i as usize].material.0 as usize].cutout;
        let corners = |t: &Triangle| t.corners.map(corner);
        let visible = TriangleBvh::masked(scene.standing().iter().map(corners), cutout);
        let figure = |range: &Range<u32>| {
            let triangles = &scene.triangles[range.start as usize..range.end as usize];
            // Numbered as in the scene, so that hits of figures and of standing triangles share the
            // tables.
            TriangleBvh::numbered(triangles.iter().map(corners), range.start, cutout)
        };
        let figures = scene.figures.iter().map(figure).collect();
        let place = |i: u32| scene.solid.positions[i as usize];
        let solid = TriangleBvh::new(scene.solid.triangles.iter().map(|t| t.map(place)));
        let surface = |t: &Triangle| Surface {
            normal: normal(t.corners.map(corner)),
            reflectivity: scene.materials[t.material.0 as usize].reflectivity,
            finish: scene.materials[t.material.0 as usize].finish,
            material: t.material.0,
        };
        let uv = |t: &Triangle| t.corners.map(|i| scene.vertices[i as usize].uv);
        Self {
            visible: Arc::new(visible),
            figures,
            solid: Arc::new(solid),
            surfaces: scene.triangles.iter().map(surface).collect(),
            corners: scene.triangles.iter().map(uv).collect(),
            holes: scene
                .materials
                .iter()
                .map(|m| holes_of(m, &scene))
                .collect(),
            scene,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The tree over the solid triangles.
    pub fn solid(&self) -> &TriangleBvh {
        &self.solid
    }

    /// The tree over the visible triangles; it ignores holes of cut-out materials.
    pub fn visible(&self) -> &TriangleBvh {
        &self.visible
    }

    /// The trees of the scene's figures.
    pub fn figures(&self) -> &[TriangleBvh] {
        &self.figures
    }

    /// The first standing triangle that a ray hits within `limit` lengths of `direction`. Rays pass
    /// through holes of cut-out materials.
    pub fn cast(&self, origin: [f32; 3], direction: [f32; 3], limit: f32) -> Option<Hit> {
        self.visible
            .cast_filtered(origin, direction, limit, |hit| !self.is_hole(hit))
    }

    /// The first standing triangle that each ray of a packet hits, as [`RayCaster::cast`] finds it
    /// for one.
    #[inline]
    pub fn cast_packet(&self, rays: &RayPacket) -> PacketHits {
        self.visible
            .cast_packet_filtered(rays, |hit| !self.is_hole(hit))
    }

    /// The material of a visible triangle.
    pub fn material(&self, triangle: u32) -> &Material {
        &self.scene.materials[self.scene.triangles[triangle as usize].material.0 as usize]
    }

    /// Normal and reflectivity of a visible triangle.
    #[inline]
    pub fn surface(&self, triangle: u32) -> &Surface {
        &self.surfaces[triangle as usize]
    }

    /// Texture coordinates of a triangle's corners.
    #[inline]
    pub fn texture_corners(&self, triangle: u32) -> [[f32; 2]; 3] {
        self.corners[triangle as usize]
    }

    /// Texture coordinates at a hit.
    #[inline]
    pub fn texture_coordinates(&self, hit: &Hit) -> [f32; 2] {
        let [a, b, c] = self.texture_corners(hit.triangle);
        let w = 1.0 - hit.u - hit.v;
        [
            w * a[0] + hit.u * b[0] + hit.v * c[0],
            w * a[1] + hit.u * b[1] + hit.v * c[1],
        ]
    }

    /// Whether a hit on a cut-out material is in one of its holes.
    #[inline]
    fn is_hole(&self, hit: &Hit) -> bool {
        let holes = &self.holes[self.surfaces[hit.triangle as usize].material as usize];
        holes
            .as_ref()
            .is_some_and(|holes| holes.has(self.texture_coordinates(hit)))
    }
}

/// A scene at an instant: standing triangles, and movers at their places.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// Standing triangles, and the figures of movers.
    pub caster: &'a RayCaster,
    /// Movers.
    pub movers: &'a Movers,
}

impl Snapshot<'_> {
    /// The first hit of each ray of a packet. `lags` are the times at which the rays were cast,
    /// relative to the instant of the movers: seconds from -[`SWEEP_S`](crate::bvh::SWEEP_S) to 0.
    #[inline]
    pub fn cast_packet(&self, rays: &RayPacket, lags: &Lane) -> PacketHits {
        // The standing world first: its hits shorten the rays for the movers.
        let mut hits = self.caster.cast_packet(rays);
        self.cast_among_movers(rays, lags, &mut hits);
        hits
    }

    /// Which rays of a packet are free of anything on their way.
    #[inline]
    pub fn unobstructed(&self, rays: &RayPacket, lags: &Lane) -> [bool; LANES] {
        let opaque = |hit: &Hit| !self.caster.is_hole(hit);
        let mut hits = self.caster.visible.any_hits(rays, opaque);
        self.cast_among_movers(rays, lags, &mut hits);
        let mut free = [true; LANES];
        for (free, triangle) in free.iter_mut().zip(&hits.triangle) {
            *free = *triangle == MISS;
        }
        free
    }

    #[inline(always)]
    fn cast_among_movers(&self, rays: &RayPacket, lags: &Lane, hits: &mut PacketHits) {
        if self.movers.is_empty() {
            return;
        }
        widest(CastAmong {
            movers: self.movers,
            figures: self.caster.figures(),
            rays,
            lags,
            opaque: &|hit: &Hit| !self.caster.is_hole(hit),
            hits,
        });
    }

    /// The first hit of each ray of a block of packets at the instant of the movers; all rays lie
    /// within `beam`.
    #[inline(always)]
    pub fn cast_block<const K: usize>(
        &self,
        beam: &Beam,
        rays: &[RayPacket; K],
    ) -> [PacketHits; K] {
        let opaque = |hit: &Hit| !self.caster.is_hole(hit);
        let mut hits = self.caster.visible.cast_block(beam, rays, opaque);
        for (rays, hits) in rays.iter().zip(&mut hits) {
            self.cast_among_movers(rays, &[0.0; LANES], hits);
        }
        hits
    }

    /// The same at `lag` seconds relative to that instant, from
    /// -[`SWEEP_S`](crate::bvh::SWEEP_S) to 0. Faster, with places that differ by rounding. All
    /// rays begin at one point, idle ones too.
    #[inline(always)]
    pub fn cast_block_at<const K: usize>(
        &self,
        beam: &Beam,
        rays: &[RayPacket; K],
        lag: f32,
    ) -> [PacketHits; K] {
        let opaque = |hit: &Hit| !self.caster.is_hole(hit);
        let visible = &self.caster.visible;
        let mut hits = visible.cast_block_from_point(beam, rays, opaque);
        for (rays, hits) in rays.iter().zip(&mut hits) {
            self.cast_among_movers(rays, &[lag; LANES], hits);
        }
        hits
    }

    /// Unit normal in `map` of the surface that a lane's ray hit, on the side from which the
    /// corners are counter-clockwise.
    #[inline]
    pub fn normal(&self, hits: &PacketHits, lane: usize) -> [f32; 3] {
        let normal = self.caster.surface(hits.triangle[lane]).normal;
        if hits.mover[lane] == MISS {
            normal
        } else {
            self.movers.turn(hits.mover[lane], normal)
        }
    }
}

/// The holes in the texture of a material, if it may have any.
fn holes_of(material: &Material, scene: &Scene) -> Option<Holes> {
    let texture = material.texture.filter(|_| material.cutout)?;
    Some(Holes::of(&scene.textures[texture.0 as usize]))
}

/// Unit normal of a triangle; arbitrary for one without area.
fn normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let (e1, e2) = (
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]],
        [c[0] - a[0], c[1] - a[1], c[2] - a[2]],
    );
    let n = [
        e1[1] * e2[2] - e1[2] * e2[1],
        e1[2] * e2[0] - e1[0] * e2[2],
        e1[0] * e2[1] - e1[1] * e2[0],
    ];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt().max(1e-20);
    n.map(|c| c / length)
}

/// The texel at `uv`; the image repeats and v runs upwards.
pub fn nearest_texel(texture: &Texture, uv: [f32; 2]) -> [u8; 4] {
    let (u, v) = (fraction(uv[0]), 1.0 - fraction(uv[1]));
    let x = ((u * texture.width as f32) as u32).min(texture.width - 1);
    let y = ((v * texture.height as f32) as u32).min(texture.height - 1);
    let i = 4 * (y * texture.width + x) as usize;
    [
        texture.rgba[i],
        texture.rgba[i + 1],
        texture.rgba[i + 2],
        texture.rgba[i + 3],
    ]
}

/// The fractional part of `x`. By a cast, since on the baseline `floor` is a call into a library;
/// meaningless for numbers beyond two thousand million.
fn fraction(x: f32) -> f32 {
    let rest = x - x as i32 as f32;
    if rest < 0.0 { rest + 1.0 } else { rest }
}
