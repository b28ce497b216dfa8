//! Lines on the ground: dashed middle lines, zebra crossings.

use std::collections::BTreeMap;

use openbench_core::{MapPoint, Pose2};
use openbench_osm::Road;

use super::Site;
use super::shapes::{along, at, facet};
use super::streets::profile;
use crate::material::SemanticClass;
use crate::scene::Layer;

const Z_MARKING: f64 = 0.015;
/// Dash, and dash with gap, metres.
const DASH: (f64, f64) = (2.0, 5.0);
/// No dashes within this distance of a junction or crossing, metres.
const JUNCTION: f64 = 6.0;
/// Length of a zebra along the road, width of a stripe, stripe with gap, metres.
const ZEBRA: (f64, f64, f64) = (2.8, 0.5, 1.0);

impl Site {
    pub(super) fn markings(&mut self) {
        let roads = std::mem::take(&mut self.map.roads);
        let breaks = self.breaks(&roads);
        self.builder.object("road markings", SemanticClass::Road);
        for road in &roads {
            if profile(&road.tags).is_some_and(|p| p.marked) {
                self.middle_line(&road.points, &breaks);
            }
        }
        self.zebras(&roads);
        self.map.roads = roads;
    }

    /// Junctions of carriageways and crossings, by cell of the size of [`JUNCTION`].
    fn breaks(&self, roads: &[Road]) -> BTreeMap<(i64, i64), Vec<MapPoint>> {
        let mut uses: BTreeMap<i64, (u32, MapPoint)> = BTreeMap::new();
        for road in roads
            .iter()
            .filter(|r| profile(&r.tags).is_some_and(|p| p.for_cars))
        {
            for (i, (node, point)) in road.nodes.iter().zip(&road.points).enumerate() {
                // A way that runs through a node has two arms there.
                let inner = i > 0 && i + 1 < road.points.len();
                uses.entry(*node).or_insert((0, *point)).0 += if inner { 2 } else { 1 };
            }
        }
        let junctions = uses.values().filter(|(arms, _)| *arms > 2).map(|(_, p)| *p);
        let crossings = self
            .features
            .iter()
            .filter(|f| f.tags.is("highway", "crossing"))
            .map(|f| f.position);
        let mut cells: BTreeMap<(i64, i64), Vec<MapPoint>> = BTreeMap::new();
        for p in junctions.chain(crossings) {
            cells.entry(cell(p)).or_default().push(p);
        }
        cells
    }

    fn middle_line(&mut self, line: &[MapPoint], breaks: &BTreeMap<(i64, i64), Vec<MapPoint>>) {
        for pair in line.windows(2) {
            let length = pair[0].distance(pair[1]);
            let dashes = ((length / DASH.1) as usize).min(2_000);
            for i in 0..dashes {
                let start = (length - dashes as f64 * DASH.1) / 2.0
                    + i as f64 * DASH.1
                    + (DASH.1 - DASH.0) / 2.0;
                let (a, b) = (
                    along(pair[0], pair[1], start / length),
                    along(pair[0], pair[1], (start + DASH.0) / length),
                );
                let middle = along(a, b, 0.5);
                if !is_near(breaks, middle) && self.extent.holds(middle, super::GROUND_MARGIN) {
                    let yaw = a.bearing_to(b);
                    self.stripe(Pose2::new(middle.x, middle.y, yaw), DASH.0, 0.12);
                }
            }
        }
    }

    fn zebras(&mut self, roads: &[Road]) {
        let mut carriageways: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
        for road in roads {
            let Some(profile) = profile(&road.tags).filter(|p| p.for_cars && p.width >= 4.5) else {
                continue;
            };
            for (i, node) in road.nodes.iter().enumerate() {
                let (before, after) = (i.saturating_sub(1), (i + 1).min(road.points.len() - 1));
                carriageways.insert(
                    *node,
                    (
                        road.points[before].bearing_to(road.points[after]),
                        profile.width,
                    ),
                );
            }
        }
        let crossings: Vec<(i64, MapPoint)> = self
            .features
            .iter()
            .filter(|f| f.tags.is("highway", "crossing") && !f.tags.is("crossing:markings", "no"))
            .map(|f| (f.node, f.position))
            .collect();
        for (node, position) in crossings {
            let Some((yaw, width)) = carriageways.get(&node).copied() else {
                continue;
            };
            let stripes = ((width - 0.3) / ZEBRA.2) as usize;
            for i in 0..stripes {
                let left = (i as f64 - (stripes as f64 - 1.0) / 2.0) * ZEBRA.2;
                let at = Pose2::new(position.x, position.y, yaw).transform(0.0, left);
                self.stripe(Pose2::new(at.x, at.y, yaw), ZEBRA.0, ZEBRA.1);
            }
        }
    }

    /// A painted rectangle around a pose.
    pub(super) fn stripe(&mut self, pose: Pose2, length: f64, width: f64) {
        if self.is_full() {
            return;
        }
        let (x, y) = (length / 2.0, width / 2.0);
        let corners =
            [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| at(pose.transform(x, y), Z_MARKING));
        facet(
            &mut self.builder,
            Layer::Visible,
            self.palette.marking,
            &corners,
        );
    }
}

fn cell(p: MapPoint) -> (i64, i64) {
    (
        (p.x / JUNCTION).floor() as i64,
        (p.y / JUNCTION).floor() as i64,
    )
}

fn is_near(breaks: &BTreeMap<(i64, i64), Vec<MapPoint>>, point: MapPoint) -> bool {
    let (x, y) = cell(point);
    let around = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)));
    around
        .filter_map(|c| breaks.get(&c))
        .flatten()
        .any(|p| p.distance(point) < JUNCTION)
}
