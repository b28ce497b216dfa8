//! Which way a satellite's signal comes to the antenna.

use nalgebra::Vector3;
use openbench_scene::{Hit, RayCaster, SemanticClass};

/// Directions in which walls are looked for.
const PROBES: usize = 32;
/// Walls farther away reflect nothing that matters, metres.
const WALLS: f64 = 60.0;
/// What stands higher or farther than this blocks nothing, metres.
const BLOCKING: f32 = 300.0;
/// How far off a surface a ray begins anew, metres.
const OFF_SURFACE: f64 = 0.05;
/// Leaves that a ray may go through.
const LEAVES: usize = 16;

/// How a signal comes in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Arrival {
    /// Straight only.
    Straight,
    /// Straight, and reflected by a wall with a way longer by `extra` metres.
    Both { extra: f64 },
    /// By a wall only.
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

/// What stands around an antenna.
pub(super) struct Surroundings<'a> {
    caster: &'a RayCaster,
    antenna: Vector3<f64>,
    mirrors: Vec<Mirror>,
}

impl<'a> Surroundings<'a> {
    /// Looks round from the antenna for walls.
    pub(super) fn new(caster: &'a RayCaster, antenna: Vector3<f64>) -> Self {
        let mut around = Self {
            caster,
            antenna,
            mirrors: Vec::new(),
        };
        for i in 0..PROBES {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / PROBES as f64);
            let mirror = around.mirror(antenna, Vector3::new(cos, sin, 0.0), WALLS as f32);
            if let Some(mirror) = mirror.filter(|m| !around.mirrors.iter().any(|known| known.is(m)))
            {
                around.mirrors.push(mirror);
            }
        }
        around
    }

    /// How the signal of a satellite in that direction comes in, if it does. Of several reflections the shortest counts: the others
    /// are as weak and come later.
    pub(super) fn arrival(&self, satellite: Vector3<f64>) -> Option<Arrival> {
        let extras = self
            .mirrors
            .iter()
            .filter_map(|mirror| self.reflection(mirror, satellite));
        let extra = extras.min_by(f64::total_cmp);
        match (self.is_clear(self.antenna, satellite), extra) {
            (true, None) => Some(Arrival::Straight),
            (true, Some(extra)) => Some(Arrival::Both { extra }),
            (false, Some(extra)) => Some(Arrival::Reflected { extra }),
            (false, None) => None,
        }
    }

    /// By how much the way over the mirror is longer: `2 h (n · s)`, as from the antenna's image behind the plane.
    fn reflection(&self, mirror: &Mirror, satellite: Vector3<f64>) -> Option<f64> {
        let facing = mirror.normal.dot(&satellite);
        if facing < 0.02 {
            return None;
        }
        let towards = satellite - mirror.normal * (2.0 * facing);
        let reach = mirror.distance / facing;
        // The wall may end before the place where the signal would be reflected.
        let met = self.mirror(self.antenna, towards, reach as f32 + 1.0)?;
        let place = self.antenna + towards * reach + mirror.normal * OFF_SURFACE;
        (met.is(mirror) && self.is_clear(place, satellite))
            .then_some(2.0 * mirror.distance * facing)
    }

    /// The upright plane that a ray from the antenna meets first, if it meets one.
    fn mirror(&self, from: Vector3<f64>, direction: Vector3<f64>, limit: f32) -> Option<Mirror> {
        let hit = self.first(from, direction, limit)?;
        let normal = Vector3::from(self.caster.surface(hit.triangle).normal.map(f64::from));
        let normal = if normal.dot(&direction) > 0.0 {
            -normal
        } else {
            normal
        };
        let distance = -normal.dot(&direction) * f64::from(hit.distance);
        (normal.z.abs() < 0.2).then_some(Mirror { normal, distance })
    }

    fn is_clear(&self, from: Vector3<f64>, direction: Vector3<f64>) -> bool {
        self.first(from, direction, BLOCKING).is_none()
    }

    /// What a signal meets first. It passes through leaves.
    fn first(&self, from: Vector3<f64>, direction: Vector3<f64>, limit: f32) -> Option<Hit> {
        let plain = |v: Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let mut gone = 0.0;
        for _ in 0..LEAVES {
            let mut hit = self.caster.cast(
                plain(from + direction * gone),
                plain(direction),
                limit - gone as f32,
            )?;
            hit.distance += gone as f32;
            if self.caster.material(hit.triangle).class != SemanticClass::Vegetation {
                return Some(hit);
            }
            gone = f64::from(hit.distance) + OFF_SURFACE;
        }
        None
    }
}

impl Mirror {
    /// Whether both are one plane, as far as rays tell.
    fn is(&self, other: &Self) -> bool {
        self.normal.dot(&other.normal) > 0.999 && (self.distance - other.distance).abs() < 0.1
    }
}
