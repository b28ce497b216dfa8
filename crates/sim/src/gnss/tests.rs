//! Receivers under the open sky, in streets and under roofs.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use openbench_scene::{Layer, Material, SceneBuilder};

use super::*;
use openbench_scene::SemanticClass;

/// An upright wall.
struct Wall {
    /// Where it begins, metres.
    from: [f64; 2],
    /// From its beginning to its end, metres.
    edge: [f64; 2],
    /// Metres.
    height: f64,
}

/// Level ground with walls.
fn world(walls: &[Wall]) -> RayCaster {
    let mut builder = SceneBuilder::new();
    let ground = builder.material(Material::plain(SemanticClass::Ground, [0.4; 3]));
    let brick = builder.material(Material::plain(SemanticClass::Building, [0.6; 3]));
    let (x, y) = (Vector3::x() * 400.0, Vector3::y() * 400.0);
    builder.rectangle(
        Layer::Both,
        ground,
        Point3::new(-200.0, -200.0, 0.0),
        x,
        y,
        [1.0; 2],
    );
    for Wall { from, edge, height } in walls {
        let at = Point3::new(from[0], from[1], 0.0);
        let (along, up) = (Vector3::new(edge[0], edge[1], 0.0), Vector3::z() * *height);
        builder.rectangle(Layer::Both, brick, at, along, up, [1.0; 2]);
    }
    RayCaster::new(Arc::new(builder.build()))
}

/// A street of 8 m between houses of 12 m, 200 m long from west to east.
fn canyon() -> RayCaster {
    world(&[
        Wall {
            from: [-100.0, 4.0],
            edge: [200.0, 0.0],
            height: 12.0,
        },
        Wall {
            from: [-100.0, -4.0],
            edge: [200.0, 0.0],
            height: 12.0,
        },
    ])
}

/// Fixes of many receivers.
struct Fixes {
    fixes: usize,
    tried: usize,
    /// Root mean squares of the errors, metres: east, north, up.
    rms: [f64; 3],
    /// Root mean square of the error in the plane by the reported covariances, metres.
    reported: f64,
    satellites: f64,
}

/// A minute under each of many skies.
fn stand(caster: &RayCaster) -> Fixes {
    let mut out = Fixes {
        fixes: 0,
        tried: 0,
        rms: [0.0; 3],
        reported: 0.0,
        satellites: 0.0,
    };
    let base = Pose3::translation(0.0, 0.5, 0.0);
    for seed in 0..60 {
        let mut gnss = Gnss::new(Noise::new(seed, 3), Pose3::translation(0.0, 0.0, 0.4));
        for i in (0..300).step_by(30) {
            out.tried += 1;
            let Some(fix) = gnss.fix(caster, SimTime(i * FIX_NS), &base) else {
                continue;
            };
            let truth = [0.0, 0.5, 0.4];
            out.fixes += 1;
            out.satellites += f64::from(fix.satellites);
            out.reported += fix.covariance[0][0] + fix.covariance[1][1];
            (0..3).for_each(|axis| out.rms[axis] += (fix.position[axis] - truth[axis]).powi(2));
        }
    }
    let n = out.fixes.max(1) as f64;
    out.rms = out.rms.map(|sum| (sum / n).sqrt());
    Fixes {
        reported: (out.reported / n).sqrt(),
        satellites: out.satellites / n,
        ..out
    }
}

#[test]
fn under_an_open_sky_fixes_are_good_to_a_few_metres_and_report_it() {
    let open = stand(&world(&[]));
    let plane = libm::hypot(open.rms[0], open.rms[1]);
    assert_eq!(open.fixes, open.tried);
    assert!((1.5..3.5).contains(&plane), "{plane} m in the plane");
    assert!(
        open.rms[2] > open.rms[0] && open.rms[2] < 8.0,
        "heights are worse: {:?}",
        open.rms
    );
    assert!(
        (plane / open.reported - 1.0).abs() < 0.25,
        "{plane} m, reported {} m",
        open.reported
    );
    assert!((8.0..12.0).contains(&open.satellites));
}

#[test]
fn a_street_canyon_blocks_satellites_and_reflects_others() {
    let (open, street) = (stand(&world(&[])), stand(&canyon()));
    let plane = |w: &Fixes| libm::hypot(w.rms[0], w.rms[1]);
    assert!(street.fixes > 0 && street.satellites < open.satellites);
    assert!(
        plane(&street) > 2.0 * plane(&open),
        "{} m against {} m",
        plane(&street),
        plane(&open)
    );
    assert!(
        street.rms[1] > street.rms[0],
        "across the street is worse than along it: {:?}",
        street.rms
    );
}

#[test]
fn under_a_roof_there_is_no_fix() {
    let mut builder = SceneBuilder::new();
    let tin = builder.material(Material::plain(SemanticClass::Building, [0.6; 3]));
    builder.rectangle(
        Layer::Both,
        tin,
        Point3::new(-40.0, -40.0, 3.0),
        Vector3::x() * 80.0,
        Vector3::y() * 80.0,
        [1.0; 2],
    );
    assert_eq!(stand(&RayCaster::new(Arc::new(builder.build()))).fixes, 0);
}

#[test]
fn the_same_seed_gives_the_same_fixes_and_another_does_not() {
    let caster = canyon();
    let fixes = |seed| {
        let mut gnss = Gnss::new(Noise::new(seed, 3), Pose3::identity());
        let at = |i: u64| Pose3::translation(i as f64, 0.0, 0.4);
        (0..20)
            .map(|i| gnss.fix(&caster, SimTime(i * FIX_NS), &at(i)))
            .collect::<Vec<_>>()
    };
    assert_eq!(fixes(7), fixes(7));
    assert_ne!(fixes(7), fixes(8));
}

#[test]
fn a_wall_reflects_signals_that_it_does_not_block() {
    // A wall 3 m to the north.
    let caster = world(&[Wall {
        from: [-50.0, 3.0],
        edge: [100.0, 0.0],
        height: 10.0,
    }]);
    let around = Surroundings::new(&caster, Vector3::new(0.0, 0.0, 1.0));
    let at = |x: f64, y: f64, z: f64| around.arrival(Vector3::new(x, y, z).normalize());
    assert_eq!(at(0.0, 1.0, 1.0), None, "blocked, and no wall opposite");
    assert_eq!(at(1.0, 0.0, 1.0), Some(Arrival::Direct), "along the wall");
    let Some(Arrival::Both { extra }) = at(0.0, -1.0, 1.0) else {
        panic!("the wall is opposite")
    };
    assert!(
        (extra - 6.0 / 2.0_f64.sqrt()).abs() < 1e-3,
        "2 h times the cosine: {extra}"
    );
    assert_eq!(
        at(0.0, -1.0, 9.0),
        Some(Arrival::Direct),
        "it would be reflected above the wall's edge"
    );
    let two = world(&[
        Wall {
            from: [-50.0, 3.0],
            edge: [100.0, 0.0],
            height: 10.0,
        },
        Wall {
            from: [-50.0, -3.0],
            edge: [100.0, 0.0],
            height: 10.0,
        },
    ]);
    let around = Surroundings::new(&two, Vector3::new(0.0, 0.0, 1.0));
    let steep = Vector3::new(0.0, 1.0, 2.0).normalize();
    let Some(Arrival::Reflected { extra }) = around.arrival(steep) else {
        panic!("by the southern wall")
    };
    assert!((extra - 6.0 / 5.0_f64.sqrt()).abs() < 1e-3, "{extra}");
}

#[test]
fn interference_oscillates_and_is_bounded() {
    let errors: Vec<f64> = (0..4000)
        .map(|i| interference(f64::from(i) * 0.013))
        .collect();
    assert!(errors.iter().any(|e| *e > 0.5) && errors.iter().any(|e| *e < -0.5));
    assert!(errors.iter().all(|e| e.abs() < 6.5));
}
