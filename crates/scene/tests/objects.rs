//! The objects that visible triangles belong to.

use std::collections::BTreeMap;
use std::sync::Arc;

use openbench_scene::generate::{builtin, car_figure};
use openbench_scene::{Corner, RayCaster, SceneBuilder, SemanticClass, World};

fn small() -> World {
    builtin("small", 1).unwrap().unwrap()
}

#[test]
fn every_triangle_of_a_generated_world_belongs_to_an_object() {
    let scene = small().scene;
    assert_eq!(scene.object_numbers.len(), scene.triangles.len());
    for triangle in 0..scene.triangles.len() as u32 {
        assert!(
            scene.object(scene.object_number(triangle)).is_some(),
            "{triangle}"
        );
    }
    assert!(scene.object(0).is_none() && scene.object(u32::MAX).is_none());
    assert_eq!(scene.object_number(u32::MAX), 0);
}

#[test]
fn houses_doors_trees_and_cars_are_named_objects() {
    let world = small();
    let scene = &world.scene;
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    scene
        .objects
        .iter()
        .for_each(|o| *counts.entry(&*o.name).or_default() += 1);
    assert!(counts["tree"] > 5 && counts["car"] > 2, "{counts:?}");
    for door in &scene.doors {
        let name = format!("door of {}", door.address);
        assert_eq!(counts.get(&*name), Some(&1), "{name} in {counts:?}");
        assert_eq!(counts.get(&*door.address.building), Some(&1), "{counts:?}");
    }
}

#[test]
fn triangles_have_the_class_of_their_object() {
    let scene = small().scene;
    for (triangle, number) in scene.triangles.iter().zip(&scene.object_numbers) {
        let class = scene.materials[triangle.material.0 as usize].class;
        let object = scene.object(*number).unwrap();
        match object.class {
            // Whole things of one class.
            SemanticClass::Vehicle | SemanticClass::Furniture => {
                assert_eq!(class, object.class, "{object:?}")
            }
            SemanticClass::Building => {
                assert!(
                    !matches!(class, SemanticClass::Vehicle | SemanticClass::Road),
                    "{object:?} {class:?}"
                );
            }
            _ => {}
        }
    }
}

#[test]
fn triangles_before_the_first_object_belong_to_none() {
    let mut builder = SceneBuilder::new();
    let grey = builder.material(openbench_scene::Material::plain(
        SemanticClass::Other,
        [0.5; 3],
    ));
    let corner = |x: f64| Corner::new(nalgebra::Point3::new(x, x * x, 0.0), [0.0; 2]);
    let corners = [corner(0.0), corner(1.0), corner(2.0)];
    let layer = openbench_scene::Layer::Both;
    builder.mesh(layer, grey, &corners, &[[0, 1, 2]]);
    builder.begin_object("thing", SemanticClass::Other);
    builder.mesh(layer, grey, &corners, &[[0, 1, 2], [0, 1, 7], [0, 2, 1]]);
    let scene = builder.build();
    assert_eq!(
        scene.object_numbers,
        [0, 1, 1],
        "the broken triangle is left out of both tables"
    );
}

#[test]
fn a_car_is_solid_where_it_is_seen() {
    for look in 0..5 {
        let caster = RayCaster::new(Arc::new(car_figure(look)));
        let mut met = 0;
        for (height, across) in (1..10).flat_map(|z| (-21..=21).map(move |i| (z, i as f32 * 0.1))) {
            let z = height as f32 * 0.1;
            let rays = [
                ([4.0, across, z], [-1.0, 0.0, 0.0]),
                ([across, 4.0, z], [0.0, -1.0, 0.0]),
            ];
            for (from, toward) in rays {
                let seen = caster
                    .visible()
                    .cast(from, toward, 8.0)
                    .map(|hit| hit.distance);
                let solid = caster
                    .solid()
                    .cast(from, toward, 8.0)
                    .map(|hit| hit.distance);
                let apart = seen
                    .zip(solid)
                    .map_or(0.0, |(seen, solid)| (seen - solid).abs());
                // Windows, rims and lamps lie slightly in front of the solid surface.
                assert!(
                    seen.is_some() == solid.is_some() && apart < 0.03,
                    "car {look} from {from:?}: seen at {seen:?} m, solid at {solid:?} m"
                );
                met += usize::from(seen.is_some());
            }
        }
        assert!(met > 100, "{met}");
    }
}
