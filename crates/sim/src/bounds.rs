//! The extent of a world on the ground.

use openbench_core::MapPoint;
use openbench_geometry::Bounds;
use openbench_scene::Scene;

/// Holds every point but those with NaN.
const EVERYWHERE: Bounds = Bounds {
    low: MapPoint::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    high: MapPoint::new(f64::INFINITY, f64::INFINITY),
};

/// The box around the static triangles of a scene; everywhere if it has none.
pub(crate) fn bounds_of(scene: &Scene) -> Bounds {
    let corners = scene
        .standing()
        .iter()
        .flat_map(|triangle| triangle.corners);
    corners
        .map(|corner| {
            let [x, y, _] = scene.vertices[corner as usize].position.map(f64::from);
            Bounds::of_point(MapPoint::new(x, y))
        })
        .reduce(Bounds::union)
        .unwrap_or(EVERYWHERE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_with_nan_lies_nowhere() {
        let nowhere = MapPoint::new(f64::NAN, 0.0);
        assert!(!EVERYWHERE.holds(nowhere, 50.0));
        assert!(EVERYWHERE.holds(MapPoint::new(1e9, -1e9), 0.0));
    }

    #[test]
    fn a_scene_without_triangles_is_everywhere() {
        assert_eq!(bounds_of(&Scene::default()), EVERYWHERE);
    }
}
