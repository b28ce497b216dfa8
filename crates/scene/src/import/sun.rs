//! The directional light of a world.

use std::path::Path;

use nalgebra::Vector3;
use roxmltree::Node;

use super::error::ImportError;
use super::frames::pose_of;
use super::warnings::Warnings;
use super::xml::{child, child_color, child_numbers, children};
use crate::Sun;

/// The first directional `<light>`, with the `<ambient>` of the `<scene>`; further lights are
/// counted.
pub(crate) fn read_sun(
    path: &Path,
    world: Node,
    warnings: &mut Warnings,
) -> Result<Option<Sun>, ImportError> {
    let mut sun = None;
    for light in children(world, "light") {
        if light.attribute("type") == Some("directional") && sun.is_none() {
            sun = Some(directional(path, world, light)?);
        } else {
            warnings.add("light other than one sun is not supported");
        }
    }
    Ok(sun)
}

fn directional(path: &Path, world: Node, light: Node) -> Result<Sun, ImportError> {
    // Light has a strength and no colour here.
    let mean = |c: [f32; 3]| (c[0] + c[1] + c[2]) / 3.0;
    let direction =
        child_numbers::<3>(path, light, "direction")?.map_or(-Vector3::z(), Vector3::from);
    let turned = pose_of(path, light)?.pose.rotation * direction;
    let unit = turned.try_normalize(1e-9).unwrap_or(-Vector3::z());
    let ambient = child(world, "scene")
        .map(|s| child_color(path, s, "ambient"))
        .transpose()?
        .flatten();
    Ok(Sun {
        direction: [unit.x as f32, unit.y as f32, unit.z as f32],
        diffuse: child_color(path, light, "diffuse")?.map_or(1.0, mean),
        ambient: ambient.map_or(Sun::default().ambient, mean),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_shines_as_the_world_says() {
        let text = "<world><light name='sun' type='directional'><diffuse>0.8 0.8 0.8 1</diffuse>\
            <direction>0 3 -4</direction></light><light name='lamp' type='point'/>\
            <scene><ambient>0.4 0.4 0.4 1</ambient></scene></world>";
        let doc = roxmltree::Document::parse(text).unwrap();
        let mut warnings = Warnings::default();
        let sun = read_sun(Path::new("f"), doc.root_element(), &mut warnings)
            .unwrap()
            .unwrap();
        assert_eq!(sun.direction, [0.0, 0.6, -0.8]);
        assert!((sun.diffuse - 0.8).abs() < 1e-6 && (sun.ambient - 0.4).abs() < 1e-6);
        assert_eq!(warnings.into_lines().len(), 1);
    }
}
