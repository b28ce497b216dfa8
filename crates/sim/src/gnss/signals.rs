//! How a satellite's signal arrives at the antenna.

use nalgebra::Vector3;
use openbench_scene::{Hit, RayCaster, SemanticClass};

/// Directions in which walls are searched.
const PROBES: usize = 32;
/// Reflections by walls farther than this are ignored, metres.
const WALL_RANGE_M: f64 = 60.0;
/// Largest distance of an object that blocks a signal, metres.
const BLOCKING_RANGE_M: f32 = 300.0;
/// Distance from a surface at which a ray continues, metres.
const OFF_SURFACE_M: f64 = 0.05;
/// Most leaves that a ray passes through.
const MAX_LEAVES: usize = 16;
/// Surfaces with a smaller z of the normal count as upright.
const UPRIGHT: f64 = 0.2;
/// Cosine of the angle between a wall's normal and a satellite below which reflections are ignored.
const MIN_FACING: f64 = 0.02;

/// How a signal arrives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Arrival {
    /// Direct only.
    Direct,
    /// Direct, and reflected by a wall on a path that is longer by `extra` metres.
    Both { extra: f64 },
    /// Reflected by a wall only.
    Reflected { extra: f64 },
}

/// An upright plane near the antenna.
#[derive(Debug, Clone, Copy)]
struct Mirror {
    /// Towards the antenna; unit length.
    normal: Vector3<f64>,
    /// From the antenna, metres.
    distance: f64,
}

/// The surroundings of an antenna.
pub(super) struct Surroundings<'a> {
    caster: &'a RayCaster,
    antenna: Vector3<f64>,
    mirrors: Vec<Mirror>,
}

impl<'a> Surroundings<'a> {
    /// Searches for walls round the antenna.
    pub(super) fn new(caster: &'a RayCaster, antenna: Vector3<f64>) -> Self {
        let mut around = Self {
            caster,
            antenna,
            mirrors: Vec::new(),
        };
        for i in 0..PROBES {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / PROBES as f64);
            // Planes are collected, not hits: a satellite's own point of reflection is searched
            // later.
            let found = around.mirror(Vector3::new(cos, sin, 0.0), WALL_RANGE_M as f32);
            let Some(mirror) = found else { continue };
            if !around
                .mirrors
                .iter()
                .any(|known| known.is_plane_of(&mirror))
            {
                around.mirrors.push(mirror);
            }
        }
        around
    }

    /// How the signal of a satellite in that direction arrives, if it does. Of several reflections
    /// the shortest counts: the others are as weak and arrive later.
    pub(super) fn arrival(&self, satellite: Vector3<f64>) -> Option<Arrival> {
        let extras = self
            .mirrors
            .iter()
            .filter_map(|mirror| self.reflection(mirror, satellite));
        let extra = extras.min_by(f64::total_cmp);
        match (self.is_clear(self.antenna, satellite), extra) {
            (true, None) => Some(Arrival::Direct),
            (true, Some(extra)) => Some(Arrival::Both { extra }),
            (false, Some(extra)) => Some(Arrival::Reflected { extra }),
            (false, None) => None,
        }
    }

    /// Extra length of the path by way of the mirror, metres: `2 h (n · s)`, as from the antenna's
    /// image behind the plane.
    fn reflection(&self, mirror: &Mirror, satellite: Vector3<f64>) -> Option<f64> {
        let facing = mirror.normal.dot(&satellite);
        if facing < MIN_FACING {
            return None;
        }
        // Mirrored, the direction has -facing along the normal, so it meets the plane after
        // distance / facing.
        let towards = satellite - mirror.normal * (2.0 * facing);
        let reach = mirror.distance / facing;
        // The wall may end before the point of reflection.
        let met = self.mirror(towards, reach as f32 + 1.0)?;
        // Off the surface, so that the wall does not block its own reflection.
        let place = self.antenna + towards * reach + mirror.normal * OFF_SURFACE_M;
        let reflects = met.is_plane_of(mirror) && self.is_clear(place, satellite);
        reflects.then_some(2.0 * mirror.distance * facing)
    }

    /// The first surface on a ray from the antenna, if it is upright.
    fn mirror(&self, direction: Vector3<f64>, limit: f32) -> Option<Mirror> {
        let hit = self.first_hit(self.antenna, direction, limit)?;
        let normal = Vector3::from(self.caster.surface(hit.triangle).normal.map(f64::from));
        // Triangles reflect on both sides; the normal follows from the order of their corners.
        let normal = if normal.dot(&direction) > 0.0 {
            -normal
        } else {
            normal
        };
        let distance = -normal.dot(&direction) * f64::from(hit.distance);
        (normal.z.abs() < UPRIGHT).then_some(Mirror { normal, distance })
    }

    fn is_clear(&self, from: Vector3<f64>, direction: Vector3<f64>) -> bool {
        self.first_hit(from, direction, BLOCKING_RANGE_M).is_none()
    }

    /// The first surface that stops a signal. Signals pass through leaves.
    fn first_hit(&self, from: Vector3<f64>, direction: Vector3<f64>, limit: f32) -> Option<Hit> {
        let mut passed = 0.0;
        for _ in 0..MAX_LEAVES {
            let origin = single(from + direction * passed);
            let mut hit = self
                .caster
                .cast(origin, single(direction), limit - passed as f32)?;
            hit.distance += passed as f32;
            let class = self.caster.material(hit.triangle).class;
            if class.coarse() != SemanticClass::Vegetation {
                return Some(hit);
            }
            // Beyond this leaf, or the next ray would hit it again.
            passed = f64::from(hit.distance) + OFF_SURFACE_M;
        }
        None
    }
}

impl Mirror {
    /// Whether both are the same plane within the precision of rays.
    fn is_plane_of(&self, other: &Self) -> bool {
        // 2.6 degrees and 10 cm: bays and window frames belong to their wall.
        self.normal.dot(&other.normal) > 0.999 && (self.distance - other.distance).abs() < 0.1
    }
}

fn single(v: Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
