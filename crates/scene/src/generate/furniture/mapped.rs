//! Street furniture at the map's nodes: lamps, benches, baskets, boxes, hydrants, bollards, poles.

use std::f64::consts::FRAC_PI_2;

use openbench_core::Pose2;
use openbench_core::frames::wrap_angle;

use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BUILDING, DOOR, START};
use crate::generate::layout::features::Feature;
use crate::generate::layout::occupied::Occupied;
use crate::generate::materials::palette::Palette;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, stream};
use crate::generate::shapes::{Block, Frustum, Surface, cuboid, frustum};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// A thing farther than this from every road or path faces east, metres.
const FACING_REACH_M: f64 = 200.0;
/// Free radius that a thing needs, metres.
const FREE_RADIUS_M: f64 = 0.3;
/// Radius that a thing keeps free, metres.
const KEPT_RADIUS_M: f64 = 0.4;

/// Builds the map's furniture.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let mut in_the_way = 0;
    for feature in inputs
        .features
        .iter()
        .filter(|f| inputs.is_on_ground(f.position))
    {
        let Some(kind) = kind_of(feature) else {
            continue;
        };
        // The count of triangles only grows, so no later piece would be built either.
        if out.is_full() {
            break;
        }
        let p = feature.position;
        if !occupied.is_free_at(p, FREE_RADIUS_M, BUILDING | DOOR | START) {
            in_the_way += 1;
            continue;
        }
        out.scene.begin_object(kind.value, SemanticClass::Furniture);
        let mut piece = Piece {
            scene: &mut out.scene,
            palette: &inputs.palette,
            pose: Pose2::new(p.x, p.y, facing(inputs, feature)),
            seed: inputs.seed,
            node: feature.node,
        };
        (kind.build)(&mut piece);
        occupied.add_disc(p, KEPT_RADIUS_M);
    }
    if in_the_way > 0 {
        out.warnings.push(format!(
            "{in_the_way} pieces of furniture stand in front of doors or in buildings and were \
             left out"
        ));
    }
}

/// Towards the nearest road or path, unless the map has a direction: radians.
fn facing(inputs: &Inputs, feature: &Feature) -> f64 {
    let direction = feature
        .tags
        .get("direction")
        .and_then(|d| d.parse::<f64>().ok());
    if let Some(degrees) = direction.filter(|d| d.is_finite()) {
        // OSM counts clockwise from north, `map` counter-clockwise from east.
        return wrap_angle(FRAC_PI_2 - degrees.to_radians());
    }
    let roads = &inputs.map.roads;
    let nearest = inputs
        .lanes
        .nearest(roads, feature.position, FACING_REACH_M);
    nearest.map_or(0.0, |nearest| {
        let ends = nearest.lane.ends(roads);
        let length = ends.length().max(1e-9);
        // Towards the nearest point of the road's segment.
        let (run, _) = ends.pose().inverse_transform(feature.position);
        feature
            .position
            .bearing_to(ends.at((run / length).clamp(0.0, 1.0)))
    })
}

/// A kind of furniture: its tag, and the function that builds it.
struct Kind {
    key: &'static str,
    value: &'static str,
    build: fn(&mut Piece),
}

const KINDS: [Kind; 10] = [
    Kind {
        key: "highway",
        value: "street_lamp",
        build: lamp,
    },
    Kind {
        key: "amenity",
        value: "bench",
        build: bench,
    },
    Kind {
        key: "amenity",
        value: "waste_basket",
        build: waste_basket,
    },
    Kind {
        key: "amenity",
        value: "waste_disposal",
        build: container,
    },
    Kind {
        key: "amenity",
        value: "recycling",
        build: container,
    },
    Kind {
        key: "amenity",
        value: "post_box",
        build: post_box,
    },
    Kind {
        key: "emergency",
        value: "fire_hydrant",
        build: hydrant,
    },
    Kind {
        key: "barrier",
        value: "bollard",
        build: bollard,
    },
    Kind {
        key: "power",
        value: "pole",
        build: pole,
    },
    Kind {
        key: "highway",
        value: "bus_stop",
        build: stop_sign,
    },
];

/// The kind of furniture that a node represents.
fn kind_of(feature: &Feature) -> Option<&'static Kind> {
    let underground = feature.tags.is("fire_hydrant:type", "underground");
    let kind = KINDS
        .iter()
        .find(|kind| feature.tags.is(kind.key, kind.value));
    kind.filter(|_| !underground)
}

/// A piece of furniture under construction. It faces along its pose.
struct Piece<'a> {
    scene: &'a mut SceneBuilder,
    palette: &'a Palette,
    pose: Pose2,
    seed: u64,
    /// Number of the map's node.
    node: i64,
}

impl Piece<'_> {
    fn block(&mut self, layer: Layer, surface: Surface, min: [f64; 3], max: [f64; 3]) {
        cuboid(self.scene, layer, surface, self.pose, Block { min, max });
    }

    /// A round post between two heights, with radii at its foot and its top, metres.
    fn post(&mut self, layer: Layer, surface: Surface, sides: usize, z: [f64; 2], radii: [f64; 2]) {
        let center = self.pose.point();
        let post = Frustum {
            center,
            sides,
            z: z[0]..z[1],
            radii,
        };
        frustum(self.scene, layer, surface, post);
    }
}

fn lamp(piece: &mut Piece) {
    let mut rng = stream(piece.seed, Purpose::Furniture, piece.node as u64);
    let height = between(&mut rng, 4.6, 5.4);
    let (metal, glass) = (piece.palette.dark_metal, piece.palette.lamp_glass);
    let (low, seen) = (height - 0.06, Layer::Visible);
    piece.post(Layer::Both, metal, 6, [0.0, 0.6], [0.11, 0.10]);
    piece.post(Layer::Both, metal, 6, [0.6, height], [0.06, 0.045]);
    piece.block(seen, metal, [0.0, -0.04, low], [1.0, 0.04, height]);
    piece.block(
        seen,
        metal,
        [0.7, -0.14, height],
        [1.3, 0.14, height + 0.08],
    );
    piece.block(
        seen,
        glass,
        [0.78, -0.11, height - 0.09],
        [1.25, 0.11, height],
    );
}

fn bench(piece: &mut Piece) {
    let (wood, metal) = (piece.palette.wood, piece.palette.dark_metal);
    // A seat of three boards, a back of two, and two frames under them.
    for x in [-0.18, 0.0, 0.18] {
        piece.block(
            Layer::Both,
            wood,
            [x - 0.075, -0.8, 0.42],
            [x + 0.075, 0.8, 0.46],
        );
    }
    for z in [0.58, 0.74] {
        piece.block(Layer::Both, wood, [-0.30, -0.8, z], [-0.26, 0.8, z + 0.12]);
    }
    for y in [-0.65, 0.6] {
        piece.block(Layer::Both, metal, [-0.25, y, 0.0], [0.22, y + 0.06, 0.42]);
        piece.block(
            Layer::Visible,
            metal,
            [-0.26, y, 0.42],
            [-0.22, y + 0.06, 0.86],
        );
    }
}

fn waste_basket(piece: &mut Piece) {
    let (green, metal) = (piece.palette.green, piece.palette.dark_metal);
    piece.post(Layer::Both, green, 8, [0.05, 0.85], [0.2, 0.24]);
    piece.post(Layer::Visible, metal, 8, [0.85, 0.9], [0.26, 0.2]);
}

fn post_box(piece: &mut Piece) {
    let (red, dark) = (piece.palette.red, piece.palette.dark_metal);
    piece.block(Layer::Both, dark, [-0.12, -0.12, 0.0], [0.12, 0.12, 0.7]);
    piece.block(Layer::Both, red, [-0.2, -0.25, 0.7], [0.2, 0.25, 1.35]);
    piece.block(Layer::Visible, dark, [0.2, -0.16, 1.15], [0.21, 0.16, 1.19]);
}

fn hydrant(piece: &mut Piece) {
    let (red, yellow) = (piece.palette.red, piece.palette.yellow);
    piece.post(Layer::Both, red, 8, [0.0, 0.55], [0.13, 0.12]);
    piece.post(Layer::Both, yellow, 8, [0.55, 0.72], [0.15, 0.05]);
    piece.block(
        Layer::Visible,
        yellow,
        [-0.05, -0.22, 0.36],
        [0.05, 0.22, 0.46],
    );
}

fn bollard(piece: &mut Piece) {
    let (metal, red) = (piece.palette.metal, piece.palette.red);
    piece.post(Layer::Both, metal, 8, [0.0, 0.8], [0.09, 0.08]);
    piece.post(Layer::Visible, red, 8, [0.8, 0.9], [0.085, 0.03]);
}

fn pole(piece: &mut Piece) {
    let wood = piece.palette.bark;
    piece.post(Layer::Both, wood, 8, [0.0, 8.0], [0.15, 0.11]);
    piece.block(Layer::Visible, wood, [-0.06, -0.9, 7.2], [0.06, 0.9, 7.35]);
}

fn container(piece: &mut Piece) {
    let (green, yellow) = (piece.palette.green, piece.palette.yellow);
    piece.block(Layer::Both, green, [-0.5, -1.3, 0.0], [0.5, -0.05, 1.4]);
    piece.block(Layer::Both, yellow, [-0.5, 0.05, 0.0], [0.5, 1.3, 1.4]);
}

fn stop_sign(piece: &mut Piece) {
    let palette = piece.palette;
    let (metal, glass, yellow) = (palette.metal, palette.lamp_glass, palette.yellow);
    piece.post(Layer::Both, metal, 6, [0.0, 2.6], [0.04, 0.04]);
    piece.block(
        Layer::Visible,
        yellow,
        [-0.03, -0.25, 2.2],
        [0.03, 0.25, 2.7],
    );
    piece.block(Layer::Visible, glass, [-0.03, -0.2, 1.3], [0.03, 0.2, 1.8]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::MapPoint;
    use openbench_osm::Tags;

    #[test]
    fn an_underground_hydrant_is_not_built() {
        let feature = |tags: &[(&str, &str)]| Feature {
            node: 1,
            position: MapPoint::default(),
            tags: tags.iter().copied().collect::<Tags>(),
        };
        assert!(kind_of(&feature(&[("emergency", "fire_hydrant")])).is_some());
        let hidden = [
            ("emergency", "fire_hydrant"),
            ("fire_hydrant:type", "underground"),
        ];
        assert!(kind_of(&feature(&hidden)).is_none());
        assert!(kind_of(&feature(&[("amenity", "cafe")])).is_none());
    }
}
