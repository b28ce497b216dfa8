//! Points of facades aligned with the outlines of buildings: the iterative closest point method
//! with distances from points to lines (Y. Chen and G. Medioni, *Object modelling by registration
//! of multiple range images*, 1992).

use std::collections::VecDeque;
use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use openbench_core::{MapPoint, Pose2, Start};
use openbench_geometry::Segment;
use openbench_localization::registration::Stretch;
use openbench_osm::OsmMap;

use super::peer::{Peer, PeerError, guess, seen_from, walls};

/// So many stretches are aligned together: 40 m.
const STRETCHES: usize = 8;
/// Most points.
const MOST_POINTS: usize = 400;
/// Walls farther away are not compared, metres.
const REACH_M: f64 = 80.0;
/// Points farther from every wall are left out, metres: less from round to round.
const GATES_M: [f64; 4] = [8.0, 4.0, 2.0, 1.0];
/// Steps with each of these.
const STEPS: usize = 6;
/// Headings that are tried where none is known.
const HEADINGS: usize = 12;

/// Aligns points with outlines from the last pose on.
pub(super) struct Icp {
    walls: Vec<Segment>,
    start: Pose2,
    knows_heading: bool,
    /// Pose of the robot on the map, and in the frame of odometry.
    last: Option<(Pose2, Pose2)>,
    stretches: VecDeque<Stretch>,
}

impl Icp {
    /// On a map, from a start.
    pub(super) fn new(map: &OsmMap, start: &Start) -> Self {
        Self {
            walls: walls(map),
            start: guess(map, start),
            knows_heading: start.pose().is_some(),
            last: None,
            stretches: VecDeque::new(),
        }
    }

    /// What was seen, in the frame of the robot.
    fn points(&self, here: Pose2) -> Vec<MapPoint> {
        let facades = self.stretches.iter().flat_map(|one| &one.facades);
        let all: Vec<MapPoint> = facades.map(|one| seen_from(here, one.at)).collect();
        let stride = all.len().div_ceil(MOST_POINTS).max(1);
        all.into_iter().step_by(stride).collect()
    }

    /// Aligns points with the walls around a pose.
    fn align(&self, points: &[MapPoint], from: Pose2) -> Pose2 {
        let here = from.point();
        let is_near = |wall: &&Segment| wall.distance_to_point(here) < REACH_M;
        let near: Vec<Segment> = self.walls.iter().filter(is_near).copied().collect();
        let mut pose = from;
        for gate in GATES_M {
            for _ in 0..STEPS {
                pose = step(&near, points, pose, gate).unwrap_or(pose);
            }
        }
        pose
    }

    /// Mean distance of points from walls, where the last gate counts as the most.
    fn misfit(&self, points: &[MapPoint], pose: Pose2) -> f64 {
        let most = GATES_M[GATES_M.len() - 1];
        let distance = |point: &MapPoint| {
            let at = pose.transform(point.x, point.y);
            let distances = self.walls.iter().map(|wall| wall.distance_to_point(at));
            distances.fold(most, f64::min)
        };
        points.iter().map(distance).sum::<f64>() / points.len().max(1) as f64
    }
}

impl Peer for Icp {
    fn take(&mut self, stretch: &Stretch) -> Result<Pose2, PeerError> {
        let here = stretch.end;
        self.stretches.push_back(stretch.clone());
        if self.stretches.len() > STRETCHES {
            self.stretches.pop_front();
        }
        let points = self.points(here);
        let pose = match self.last {
            Some((pose, there)) => self.align(&points, pose.compose(here.seen_from(there))),
            None if self.knows_heading => self.align(&points, self.start),
            None => {
                let turned = (0..HEADINGS).map(|i| {
                    let yaw = i as f64 * TAU / HEADINGS as f64;
                    self.align(&points, Pose2::new(self.start.x, self.start.y, yaw))
                });
                let found = turned.map(|pose| (self.misfit(&points, pose), pose));
                let best = found.reduce(|a, b| if b.0 < a.0 { b } else { a });
                best.map_or(self.start, |(_, pose)| pose)
            }
        };
        self.last = Some((pose, here));
        Ok(pose)
    }
}

/// A step of Gauss and Newton; `None` where the points say nothing.
fn step(walls: &[Segment], points: &[MapPoint], pose: Pose2, gate: f64) -> Option<Pose2> {
    let mut information = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for point in points {
        let at = pose.transform(point.x, point.y);
        let nearest = walls
            .iter()
            .map(|wall| (wall.distance_to_point(at), wall))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(distance, _)| *distance < gate);
        let Some((_, wall)) = nearest else { continue };
        let (sine, cosine) = libm::sincos(wall.outward());
        let off = (at.x - wall.start.x) * cosine + (at.y - wall.start.y) * sine;
        let (rx, ry) = (at.x - pose.x, at.y - pose.y);
        let row = Vector3::new(cosine, sine, rx * sine - ry * cosine);
        information += row * row.transpose();
        right -= row * off;
    }
    // What no wall measures stays as it is.
    information += Matrix3::identity() * 1e-3;
    let moved = information.try_inverse()? * right;
    Some(Pose2::new(
        pose.x + moved.x,
        pose.y + moved.y,
        pose.yaw + moved.z,
    ))
}
