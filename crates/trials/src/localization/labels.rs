//! Which LiDAR returns are of facades, in truth: the upper bound of what any labels give.

use std::collections::VecDeque;

use nalgebra::{Point3, Vector3};
use openbench_core::{LidarScan, Pose3, SimTime};
use openbench_scene::{RayCaster, SemanticClass};

/// How facades are distinguished from hedges, cars and other surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Labels {
    /// By the geometry of the returns.
    Geometry,
    /// By the true classes of the world's surfaces.
    Truth,
}

/// A return this far before or behind the surface is of something else, such as a car, metres.
const SAME_SURFACE_M: f32 = 0.5;
/// True poses are remembered for so many observations: a scan takes two.
const REMEMBERED: usize = 8;

/// Looks up which surfaces LiDAR returns are on.
pub struct TrueLabels<'a> {
    caster: &'a RayCaster,
    /// Pose of the LiDAR in `base_link`.
    lidar: Pose3,
    poses: VecDeque<(SimTime, Pose3)>,
}

impl<'a> TrueLabels<'a> {
    /// In a world, of a LiDAR at this pose in `base_link`.
    pub fn new(caster: &'a RayCaster, lidar: Pose3) -> Self {
        Self {
            caster,
            lidar,
            poses: VecDeque::new(),
        }
    }

    /// Takes in where the robot is, `base_link` in `map`.
    pub fn observe(&mut self, time: SimTime, base: Pose3) {
        self.poses.push_back((time, base));
        if self.poses.len() > REMEMBERED {
            self.poses.pop_front();
        }
    }

    /// Probability that a point of the newest scan is of a facade: 0 or 1.
    pub fn facade(&self, scan: &LidarScan, index: usize) -> f32 {
        let point = &scan.points[index];
        let time = scan.stamp + std::time::Duration::from_nanos(u64::from(point.offset_ns));
        let Some(base) = self.base_at(time) else {
            return 0.0;
        };
        let at = base * self.lidar;
        let origin = Vector3::from(at.translation.vector).cast::<f32>();
        let seen = at * Point3::from(Vector3::from(point.xyz).cast::<f64>());
        let ray = seen.coords.cast::<f32>() - origin;
        let range = ray.norm();
        if range.is_nan() || range <= 0.0 {
            return 0.0;
        }
        let direction = ray / range;
        let limit = range + SAME_SURFACE_M;
        let hit = self.caster.cast(origin.into(), direction.into(), limit);
        let is_facade = hit.is_some_and(|hit| {
            let class = self.caster.material(hit.triangle).class;
            hit.distance >= range - SAME_SURFACE_M && is_of_building(class)
        });
        f32::from(u8::from(is_facade))
    }

    /// Where the robot was: between the poses before and after.
    fn base_at(&self, time: SimTime) -> Option<Pose3> {
        let after = self.poses.iter().position(|(known, _)| *known >= time);
        let Some(after) = after else {
            return self.poses.back().map(|(_, pose)| *pose);
        };
        let (late, to) = self.poses[after];
        let Some((early, from)) = after.checked_sub(1).map(|before| self.poses[before]) else {
            return Some(to);
        };
        let share = time.since(early).as_secs_f64() / late.since(early).as_secs_f64();
        from.try_lerp_slerp(&to, share, 1e-9).or(Some(to))
    }
}

fn is_of_building(class: SemanticClass) -> bool {
    matches!(
        class,
        SemanticClass::Building | SemanticClass::Door | SemanticClass::Plate
    )
}

#[cfg(test)]
mod tests {
    use openbench_core::LidarPoint;
    use openbench_scene::{Layer, Material, SceneBuilder};

    use super::*;

    /// A wall of a class across the way, ten metres ahead.
    fn wall(class: SemanticClass) -> RayCaster {
        let mut builder = SceneBuilder::new();
        let material = builder.material(Material::plain(class, [0.5; 3]));
        let corner = Point3::new(10.0, 9.0, -1.0);
        let (along, up) = (Vector3::y() * -18.0, Vector3::z() * 6.0);
        builder.rectangle(Layer::Visible, material, corner, along, up, [1.0; 2]);
        RayCaster::new(builder.build().into())
    }

    /// How probable it is that a return so far ahead of a robot is of a facade that drove a metre
    /// while it scanned.
    fn facade(class: SemanticClass, ahead: f32, offset_ns: u32) -> f32 {
        let caster = wall(class);
        let mut labels = TrueLabels::new(&caster, Pose3::translation(0.0, 0.0, 0.3));
        labels.observe(SimTime::ZERO, Pose3::identity());
        labels.observe(SimTime::from_millis(100), Pose3::translation(1.0, 0.0, 0.0));
        let point = LidarPoint {
            xyz: [ahead, 0.0, 1.0],
            offset_ns,
            reflectivity: 100,
            line: 0,
        };
        let scan = LidarScan {
            stamp: SimTime::ZERO,
            points: vec![point],
        };
        labels.facade(&scan, 0)
    }

    #[test]
    fn what_is_on_a_house_is_of_a_facade_and_what_is_before_it_is_not() {
        assert_eq!(facade(SemanticClass::Building, 10.0, 0), 1.0);
        assert_eq!(facade(SemanticClass::Hedge, 10.0, 0), 0.0);
        assert_eq!(facade(SemanticClass::Building, 7.0, 0), 0.0);
        // At the end of the scan the house is nearer.
        assert_eq!(facade(SemanticClass::Building, 9.0, 100_000_000), 1.0);
        assert_eq!(facade(SemanticClass::Building, 9.0, 0), 0.0);
    }
}
