//! What years leave on carriageways: mended places, manholes, drains at the kerb.

use openbench_core::{MapPoint, Pose2};
use openbench_osm::Road;
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::seeds::{Purpose, between, chance, stream};
use super::shapes::{Surface, along, at, facet};
use super::streets::{Profile, profile};
use crate::scene::Layer;

/// Between carriageway and lines, metres.
const Z_PATCH: f64 = 0.013;
const Z_LID: f64 = 0.014;
/// One of each for so many metres of a street, in a neighbourhood and in a town.
const SPACING: (f64, f64) = (14.0, 40.0);
/// Places in one segment at most.
const MOST: usize = 200;

impl Site {
    pub(super) fn wear(&mut self) {
        let roads = std::mem::take(&mut self.map.roads);
        for road in &roads {
            let worn = profile(&road.tags).filter(|p| p.for_cars && p.width >= 4.5);
            if let Some(profile) = worn {
                self.wear_of(road, profile);
            }
        }
        self.map.roads = roads;
    }

    fn wear_of(&mut self, road: &Road, profile: Profile) {
        let mut rng = stream(self.seed, Purpose::Wear, road.way as u64);
        let spacing = if self.detailed { SPACING.0 } else { SPACING.1 };
        for pair in road.points.windows(2) {
            let (length, yaw) = (pair[0].distance(pair[1]), pair[0].bearing_to(pair[1]));
            for i in 0..((length / spacing) as usize).min(MOST) {
                let p = along(
                    pair[0],
                    pair[1],
                    (i as f64 + between(&mut rng, 0.2, 0.8)) * spacing / length,
                );
                let draws = [
                    chance(&mut rng, 0.5),
                    chance(&mut rng, 0.4),
                    chance(&mut rng, 0.5),
                ];
                if self.extent.holds(p, super::GROUND_MARGIN) && !self.is_full() {
                    self.worn_place(Pose2::new(p.x, p.y, yaw), profile, draws, &mut rng);
                }
            }
        }
    }

    fn worn_place(
        &mut self,
        pose: Pose2,
        profile: Profile,
        [mended, manhole, drain]: [bool; 3],
        rng: &mut Pcg64Mcg,
    ) {
        let half = profile.width / 2.0;
        let (patch, lid) = (self.palette.patch, self.palette.dark_metal);
        if mended {
            let size = (between(rng, 0.8, 3.5), between(rng, 0.5, 1.4));
            let place = pose.transform(
                between(rng, -3.0, 3.0),
                between(rng, -half + 1.0, half - 1.0),
            );
            self.covering(patch, Pose2::new(place.x, place.y, pose.yaw), size, Z_PATCH);
        }
        if manhole {
            let middle = pose.transform(1.5, half * if chance(rng, 0.5) { 0.45 } else { -0.45 });
            self.lid(lid, middle);
        }
        if drain {
            let place = pose.transform(
                -1.5,
                (half - 0.22) * if chance(rng, 0.5) { 1.0 } else { -1.0 },
            );
            self.covering(
                lid,
                Pose2::new(place.x, place.y, pose.yaw),
                (0.5, 0.32),
                Z_LID,
            );
        }
    }

    fn covering(&mut self, surface: Surface, pose: Pose2, (length, width): (f64, f64), z: f64) {
        let (x, y) = (length / 2.0, width / 2.0);
        let corners =
            [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| at(pose.transform(x, y), z));
        facet(&mut self.builder, Layer::Visible, surface, &corners);
    }

    fn lid(&mut self, surface: Surface, middle: MapPoint) {
        let corner = |i: i32| {
            at(
                middle.offset(std::f64::consts::FRAC_PI_4 * f64::from(i), 0.32),
                Z_LID,
            )
        };
        facet(
            &mut self.builder,
            Layer::Visible,
            surface,
            &[0, 1, 2, 3, 4, 5, 6, 7].map(corner),
        );
    }
}
