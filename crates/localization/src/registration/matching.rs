//! Pieces of facades on walls of the map, as linear equations.
//!
//! Each piece measures how far it is in front of the nearest wall that faces the same way. That
//! depends on the pose of the robot, and on the offset of the wall's building.

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};

use super::chart::{Chart, Wall};
use super::columns::Facade;
use super::submap::REACH_M;

/// Facades match walls that face the same way up to this, radians,
pub(super) const FACING_RAD: f64 = 0.45;
/// and reach beyond their ends by no more than this share of the gate.
const BEYOND_END: f64 = 0.5;
/// Most views that a piece of a facade counts for.
const MOST_VIEWS: u8 = 4;

/// How exactly a piece of a facade is on its wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacadeNoise {
    /// Standard deviation, metres.
    pub metres: f64,
    /// Information of a piece relative to an independent one: neighbours have the same errors.
    pub independence: f64,
}

impl FacadeNoise {
    fn information(self) -> f64 {
        self.independence / (self.metres * self.metres)
    }
}

/// What the facades of one building say, linear about the refined pose: information about pose and
/// offset, and the gradient of half the squared error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuildingEvidence {
    /// Index of the building in the chart.
    pub building: usize,
    /// Estimated offset of its outline on the ground from that in the map, metres.
    pub offset: Vector2<f64>,
    /// Information about the pose.
    pub pose: Matrix3<f64>,
    /// Between pose and offset.
    pub mixed: Matrix3x2<f64>,
    /// Information about the offset, without its prior.
    pub own: Matrix2<f64>,
    /// Gradient along the pose.
    pub pose_gradient: Vector3<f64>,
    /// Gradient along the offset.
    pub own_gradient: Vector2<f64>,
    /// Facades that match its walls.
    pub facades: usize,
}

impl BuildingEvidence {
    pub(super) fn of(building: usize) -> Self {
        Self {
            building,
            offset: Vector2::zeros(),
            pose: Matrix3::zeros(),
            mixed: Matrix3x2::zeros(),
            own: Matrix2::zeros(),
            pose_gradient: Vector3::zeros(),
            own_gradient: Vector2::zeros(),
            facades: 0,
        }
    }

    fn forget(&mut self) {
        *self = Self {
            offset: self.offset,
            ..Self::of(self.building)
        };
    }
}

/// Walls near a pose, and what facades say about them.
pub(super) struct Matching {
    walls: Vec<Line>,
    /// What each building says, and its offset, which the equations are about.
    pub(super) buildings: Vec<BuildingEvidence>,
}

/// A wall as the equations need it.
struct Line {
    start: Vector2<f64>,
    along: Vector2<f64>,
    /// Away from the building.
    normal: Vector2<f64>,
    /// The direction of the normal, radians.
    facing: f64,
    length: f64,
    /// Of its building in the matching.
    place: usize,
}

impl Line {
    fn of(wall: &Wall, place: usize) -> Self {
        let (a, b) = (wall.segment.start, wall.segment.end);
        let length = wall.segment.length();
        let along = Vector2::new(b.x - a.x, b.y - a.y) / length;
        // The building lies to the left.
        let normal = Vector2::new(along.y, -along.x);
        Self {
            start: Vector2::new(a.x, a.y),
            along,
            normal,
            facing: libm::atan2(normal.y, normal.x),
            length,
            place,
        }
    }
}

impl Matching {
    /// The walls near a pose; no building has an offset yet.
    pub(super) fn about(chart: &Chart, pose: Pose2) -> Self {
        let mut places = vec![None; chart.outlines.len()];
        let mut matching = Self {
            walls: Vec::new(),
            buildings: Vec::new(),
        };
        for wall in &chart.walls {
            if wall.segment.distance_to_point(pose.point()) > REACH_M {
                continue;
            }
            let buildings = &mut matching.buildings;
            let place = *places[wall.building].get_or_insert_with(|| {
                buildings.push(BuildingEvidence::of(wall.building));
                buildings.len() - 1
            });
            matching.walls.push(Line::of(wall, place));
        }
        matching
    }

    /// Moves all buildings: each by what `offset` gives for its index in the chart.
    pub(super) fn displace(&mut self, offset: impl Fn(usize) -> Vector2<f64>) {
        for building in &mut self.buildings {
            building.offset = offset(building.building);
        }
    }

    /// Sums up the equations at a pose. Facades match walls within the gate, metres.
    pub(super) fn linearise(
        &mut self,
        facades: &[Facade],
        pose: Pose2,
        gate: f64,
        noise: FacadeNoise,
    ) -> Matches {
        self.buildings.iter_mut().for_each(BuildingEvidence::forget);
        let mut matches = Matches::default();
        for facade in facades {
            let at = pose.transform(facade.at.x, facade.at.y);
            let views = f64::from(facade.views.min(MOST_VIEWS)) / f64::from(MOST_VIEWS);
            let information = views * noise.information();
            let fit = self.fit(at, facade.facing + pose.yaw, gate);
            // Tukey's biweight: nothing jumps when a facade leaves the gate.
            let scaled = fit.map_or(1.0, |fit| fit.away / gate);
            let inside = 1.0 - scaled * scaled;
            matches.misfit += information * gate * gate / 6.0 * (1.0 - inside.powi(3));
            let Some(fit) = fit else {
                continue;
            };
            let robust = inside * inside;
            matches.count += 1;
            matches.closeness += robust;
            let weight = robust * information;
            let normal = fit.normal;
            // The facade moves with the heading about the robot.
            let lever = Vector2::new(-(at.y - pose.y), at.x - pose.x);
            let by_pose = Vector3::new(normal.x, normal.y, normal.dot(&lever));
            let building = &mut self.buildings[fit.place];
            building.pose += by_pose * by_pose.transpose() * weight;
            building.mixed -= by_pose * normal.transpose() * weight;
            building.own += normal * normal.transpose() * weight;
            building.pose_gradient += by_pose * (fit.away * weight);
            building.own_gradient -= normal * (fit.away * weight);
            building.facades += 1;
        }
        matches
    }

    /// What the buildings say that have facades.
    pub(super) fn matched(self) -> Vec<BuildingEvidence> {
        let mut matched = self.buildings;
        matched.retain(|building| building.facades > 0);
        matched
    }

    /// The nearest wall that a facade can be on.
    fn fit(&self, at: MapPoint, facing: f64, gate: f64) -> Option<Fit> {
        let beyond = BEYOND_END * gate;
        let mut nearest = gate;
        let mut best = None;
        for line in &self.walls {
            let offset = self.buildings[line.place].offset;
            let from = Vector2::new(at.x, at.y) - line.start - offset;
            let away = line.normal.dot(&from);
            if away.abs() >= nearest {
                continue;
            }
            let on = line.along.dot(&from);
            let is_on = on > -beyond && on < line.length + beyond;
            if is_on && wrap_angle(line.facing - facing).abs() < FACING_RAD {
                nearest = away.abs();
                best = Some(Fit {
                    place: line.place,
                    normal: line.normal,
                    away,
                });
            }
        }
        best
    }
}

/// Facades that match walls.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Matches {
    pub(super) count: usize,
    /// Sum of their closeness, 0 at the gate and 1 on the wall.
    pub(super) closeness: f64,
    /// Tukey's loss of all facades, nats; of one that matches none as at the gate.
    pub(super) misfit: f64,
}

/// A facade on a wall.
#[derive(Debug, Clone, Copy)]
struct Fit {
    /// Of the building in the matching.
    place: usize,
    normal: Vector2<f64>,
    /// In front of the wall, metres.
    away: f64,
}
