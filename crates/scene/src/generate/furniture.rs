//! Lamps, benches, baskets, boxes, hydrants, bollards and poles at the map's nodes; bins that the seed adds.

use openbench_core::Pose2;
use rand_pcg::Pcg64Mcg;

use super::clearance::{BARRIER, BUILDING, DOOR, OBJECT, PATH, PAVED, ROAD, START, WATER};
use super::element_number;
use super::entrances::walls;
use super::facades::facing_out;
use super::lanes::ends;
use super::seeds::{Purpose, between, chance, pick, stream};
use super::shapes::{Surface, along, cuboid, prism};
use super::{Feature, Site};
use crate::material::SemanticClass;
use crate::scene::Layer;

/// A thing further than this from every road or path looks to the east, metres.
const FACING: f64 = 200.0;

/// A larger building has its bins inside, m².
const MOST_WITH_BINS: f64 = 500.0;

impl Site {
    pub(super) fn furniture(&mut self) {
        let features = std::mem::take(&mut self.features);
        let mut in_the_way = 0;
        for feature in &features {
            let Some((kind, build)) = build_of(feature)
                .filter(|_| self.extent.holds(feature.position, super::GROUND_MARGIN))
            else {
                continue;
            };
            let p = feature.position;
            if self.is_full() {
                break;
            }
            if !self.clearance.is_free(p, p, 0.3, BUILDING | DOOR | START) {
                in_the_way += 1;
                continue;
            }
            let pose = Pose2::new(p.x, p.y, self.facing(feature));
            self.builder.object(kind, SemanticClass::Furniture);
            build(self, pose, feature);
            self.clearance.add(p, p, 0.4, OBJECT);
        }
        if in_the_way > 0 {
            self.warnings.push(format!(
                "{in_the_way} pieces of furniture stand in front of doors or in buildings and were left out"
            ));
        }
        self.features = features;
    }

    /// Towards the nearest road or path, unless the map says otherwise.
    fn facing(&self, feature: &Feature) -> f64 {
        if let Some(degrees) = feature
            .tags
            .get("direction")
            .and_then(|d| d.parse::<f64>().ok())
            .filter(|d| d.is_finite())
        {
            return openbench_core::frames::wrap_angle(
                std::f64::consts::FRAC_PI_2 - degrees.to_radians(),
            );
        }
        let nearest = self
            .lanes
            .nearest(&self.map.roads, feature.position, FACING);
        let nearest = nearest.map(|(segment, _)| ends(&self.map.roads, segment));
        nearest.map_or(0.0, |(a, b)| {
            let length = a.distance(b).max(1e-9);
            let (run, _) =
                Pose2::new(a.x, a.y, a.bearing_to(b)).inverse_transform(feature.position);
            feature
                .position
                .bearing_to(along(a, b, (run / length).clamp(0.0, 1.0)))
        })
    }

    /// Wheelie bins at the walls of houses, where they stand in nobody's way.
    pub(super) fn bins(&mut self) {
        let buildings = std::mem::take(&mut self.map.buildings);
        let in_the_way = DOOR | PATH | ROAD | PAVED | START | BARRIER | OBJECT | WATER;
        for building in buildings
            .iter()
            .filter(|b| b.polygon.area() < MOST_WITH_BINS)
        {
            let mut rng = stream(
                self.seed,
                Purpose::Furniture,
                element_number(building.element) | 1 << 63,
            );
            let sides = walls(building);
            let (a, b) = pick(&mut rng, &sides);
            let (count, share) = (
                1 + usize::from(chance(&mut rng, 0.6)),
                between(&mut rng, 0.2, 0.8),
            );
            if a.distance(b) < 4.0 || !chance(&mut rng, self.options.planting) {
                continue;
            }
            let wall = facing_out(a, b, share);
            let near = self.extent.holds(wall.point(), super::GROUND_MARGIN);
            for i in 0..count {
                let p = wall.transform(0.5, 0.8 * i as f64);
                let before = wall.transform(1.9, 0.8 * i as f64);
                let free = self.clearance.is_free(p, p, 0.45, in_the_way)
                    && self
                        .clearance
                        .is_free(before, before, 1.0, BUILDING | BARRIER);
                if near && free && !self.is_full() {
                    self.bin(Pose2::new(p.x, p.y, wall.yaw), &mut rng);
                    self.clearance.add(p, p, 0.3, OBJECT);
                }
            }
        }
        self.map.buildings = buildings;
    }

    fn bin(&mut self, pose: Pose2, rng: &mut Pcg64Mcg) {
        self.builder.object("bin", SemanticClass::Furniture);
        let palette = &self.palette;
        let body = pick(
            rng,
            &[palette.dark_metal, palette.green, palette.dark_metal],
        );
        let lid = pick(
            rng,
            &[
                palette.green,
                palette.yellow,
                palette.dark_metal,
                palette.metal,
            ],
        );
        self.add_box(
            Layer::Both,
            body,
            pose,
            [-0.32, -0.28, 0.08],
            [0.32, 0.28, 0.95],
        );
        self.add_box(
            Layer::Visible,
            lid,
            pose,
            [-0.36, -0.31, 0.95],
            [0.36, 0.31, 1.03],
        );
    }

    fn add_box(
        &mut self,
        layer: Layer,
        surface: Surface,
        pose: Pose2,
        min: [f64; 3],
        max: [f64; 3],
    ) {
        cuboid(&mut self.builder, layer, surface, pose, (min, max));
    }

    fn lamp(&mut self, pose: Pose2, feature: &Feature) {
        let mut rng = stream(self.seed, Purpose::Furniture, feature.node as u64);
        let height = between(&mut rng, 4.6, 5.4);
        let (metal, glass) = (self.palette.dark_metal, self.palette.lamp_glass);
        let p = pose.point();
        prism(
            &mut self.builder,
            Layer::Both,
            metal,
            (p, 6),
            ((0.0, 0.6), (0.11, 0.10)),
        );
        prism(
            &mut self.builder,
            Layer::Both,
            metal,
            (p, 6),
            ((0.6, height), (0.06, 0.045)),
        );
        self.add_box(
            Layer::Visible,
            metal,
            pose,
            [0.0, -0.04, height - 0.06],
            [1.0, 0.04, height],
        );
        self.add_box(
            Layer::Visible,
            metal,
            pose,
            [0.7, -0.14, height],
            [1.3, 0.14, height + 0.08],
        );
        self.add_box(
            Layer::Visible,
            glass,
            pose,
            [0.78, -0.11, height - 0.09],
            [1.25, 0.11, height],
        );
    }

    fn bench(&mut self, pose: Pose2, _: &Feature) {
        let (wood, metal) = (self.palette.wood, self.palette.dark_metal);
        for x in [-0.18, 0.0, 0.18] {
            self.add_box(
                Layer::Both,
                wood,
                pose,
                [x - 0.075, -0.8, 0.42],
                [x + 0.075, 0.8, 0.46],
            );
        }
        for z in [0.58, 0.74] {
            self.add_box(
                Layer::Both,
                wood,
                pose,
                [-0.30, -0.8, z],
                [-0.26, 0.8, z + 0.12],
            );
        }
        for y in [-0.65, 0.6] {
            self.add_box(
                Layer::Both,
                metal,
                pose,
                [-0.25, y, 0.0],
                [0.22, y + 0.06, 0.42],
            );
            self.add_box(
                Layer::Visible,
                metal,
                pose,
                [-0.26, y, 0.42],
                [-0.22, y + 0.06, 0.86],
            );
        }
    }

    fn waste_basket(&mut self, pose: Pose2, _: &Feature) {
        let (green, metal) = (self.palette.green, self.palette.dark_metal);
        prism(
            &mut self.builder,
            Layer::Both,
            green,
            (pose.point(), 8),
            ((0.05, 0.85), (0.2, 0.24)),
        );
        prism(
            &mut self.builder,
            Layer::Visible,
            metal,
            (pose.point(), 8),
            ((0.85, 0.9), (0.26, 0.2)),
        );
    }

    fn post_box(&mut self, pose: Pose2, _: &Feature) {
        let (red, dark) = (self.palette.red, self.palette.dark_metal);
        self.add_box(
            Layer::Both,
            dark,
            pose,
            [-0.12, -0.12, 0.0],
            [0.12, 0.12, 0.7],
        );
        self.add_box(
            Layer::Both,
            red,
            pose,
            [-0.2, -0.25, 0.7],
            [0.2, 0.25, 1.35],
        );
        self.add_box(
            Layer::Visible,
            dark,
            pose,
            [0.2, -0.16, 1.15],
            [0.21, 0.16, 1.19],
        );
    }

    fn hydrant(&mut self, pose: Pose2, _: &Feature) {
        let (red, yellow) = (self.palette.red, self.palette.yellow);
        let p = pose.point();
        prism(
            &mut self.builder,
            Layer::Both,
            red,
            (p, 8),
            ((0.0, 0.55), (0.13, 0.12)),
        );
        prism(
            &mut self.builder,
            Layer::Both,
            yellow,
            (p, 8),
            ((0.55, 0.72), (0.15, 0.05)),
        );
        self.add_box(
            Layer::Visible,
            yellow,
            pose,
            [-0.05, -0.22, 0.36],
            [0.05, 0.22, 0.46],
        );
    }

    fn bollard(&mut self, pose: Pose2, _: &Feature) {
        let (metal, glass) = (self.palette.metal, self.palette.red);
        prism(
            &mut self.builder,
            Layer::Both,
            metal,
            (pose.point(), 8),
            ((0.0, 0.8), (0.09, 0.08)),
        );
        prism(
            &mut self.builder,
            Layer::Visible,
            glass,
            (pose.point(), 8),
            ((0.8, 0.9), (0.085, 0.03)),
        );
    }

    fn pole(&mut self, pose: Pose2, _: &Feature) {
        let wood = self.palette.bark;
        prism(
            &mut self.builder,
            Layer::Both,
            wood,
            (pose.point(), 8),
            ((0.0, 8.0), (0.15, 0.11)),
        );
        self.add_box(
            Layer::Visible,
            wood,
            pose,
            [-0.06, -0.9, 7.2],
            [0.06, 0.9, 7.35],
        );
    }

    fn container(&mut self, pose: Pose2, _: &Feature) {
        let (green, yellow) = (self.palette.green, self.palette.yellow);
        self.add_box(
            Layer::Both,
            green,
            pose,
            [-0.5, -1.3, 0.0],
            [0.5, -0.05, 1.4],
        );
        self.add_box(
            Layer::Both,
            yellow,
            pose,
            [-0.5, 0.05, 0.0],
            [0.5, 1.3, 1.4],
        );
    }

    fn stop_sign(&mut self, pose: Pose2, _: &Feature) {
        let (metal, glass, yellow) = (
            self.palette.metal,
            self.palette.lamp_glass,
            self.palette.yellow,
        );
        prism(
            &mut self.builder,
            Layer::Both,
            metal,
            (pose.point(), 6),
            ((0.0, 2.6), (0.04, 0.04)),
        );
        self.add_box(
            Layer::Visible,
            yellow,
            pose,
            [-0.03, -0.25, 2.2],
            [0.03, 0.25, 2.7],
        );
        self.add_box(
            Layer::Visible,
            glass,
            pose,
            [-0.03, -0.2, 1.3],
            [0.03, 0.2, 1.8],
        );
    }
}

type Build = fn(&mut Site, Pose2, &Feature);

/// The kind of thing, and how it is built.
fn build_of(feature: &Feature) -> Option<(&'static str, Build)> {
    let table: [((&str, &'static str), Build); 10] = [
        (("highway", "street_lamp"), Site::lamp),
        (("amenity", "bench"), Site::bench),
        (("amenity", "waste_basket"), Site::waste_basket),
        (("amenity", "waste_disposal"), Site::container),
        (("amenity", "recycling"), Site::container),
        (("amenity", "post_box"), Site::post_box),
        (("emergency", "fire_hydrant"), Site::hydrant),
        (("barrier", "bollard"), Site::bollard),
        (("power", "pole"), Site::pole),
        (("highway", "bus_stop"), Site::stop_sign),
    ];
    let found = table
        .into_iter()
        .find(|((key, value), _)| feature.tags.is(key, value))?;
    let underground = feature.tags.is("fire_hydrant:type", "underground");
    let ((_, kind), build) = found;
    (!underground).then_some((kind, build))
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
        assert!(build_of(&feature(&[("emergency", "fire_hydrant")])).is_some());
        let hidden = [
            ("emergency", "fire_hydrant"),
            ("fire_hydrant:type", "underground"),
        ];
        assert!(build_of(&feature(&hidden)).is_none());
        assert!(build_of(&feature(&[("amenity", "cafe")])).is_none());
    }
}
