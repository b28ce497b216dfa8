//! An agent: it reads the instruction with the grammar, drives straight at one building after the
//! other by wheel odometry and gyroscope, and declares the delivery a metre before the wall or where
//! an obstacle stops it. It does not look for the right door, so it is right by chance only.

use std::collections::VecDeque;

use openbench::{AgentError, AgentRequest};
use openbench_core::frames::wrap_angle;
use openbench_core::{
    Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, Goal, LidarPoint, LidarScan,
    MapPoint, Observation, Plan, Pose2, TravelTimes, Velocity, with_causes,
};
use openbench_language::{GrammarPlanner, PlanError, PlanRequest, Planner};
use openbench_localization::{DeadReckoning, Localizer};
use openbench_osm::{OsmData, OsmMap};

/// Speed, m/s.
const SPEED_MPS: f64 = 0.4;
/// Heading error above which the robot turns on the spot, radians.
const TURN_FIRST_RAD: f64 = 0.3;
/// Turn rate for each radian of heading error, 1/s.
const TURN_GAIN_PER_S: f64 = 1.0;
/// Distance from the wall at which the robot has arrived, metres.
const ARRIVED_M: f64 = 1.0;
/// Range of an obstacle that stops the robot, metres.
const STOP_M: f32 = 0.6;
/// Half of the width, and of the height, in which points ahead of the LiDAR are obstacles, metres.
const HALF_WIDTH_M: f32 = 0.25;
const HALF_HEIGHT_M: f32 = 0.1;

/// The agent by its name: `--agent beeline`.
pub fn make(_: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
    Ok(Box::new(Beeline { drive: None }))
}

/// Drives straight at each building.
struct Beeline {
    /// `None` until the briefing.
    drive: Option<Drive>,
}

/// The drive of an episode.
struct Drive {
    localizer: DeadReckoning,
    /// What is left, in order; the first one is at hand.
    stops: VecDeque<Stop>,
}

/// A delivery.
struct Stop {
    address: Address,
    /// The point of the building's wall that is nearest to the stop before.
    target: MapPoint,
}

/// Times of drives along straight lines.
struct StraightTimes;

impl TravelTimes for StraightTimes {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        let seconds = |from: &MapPoint, to: &MapPoint| from.distance(*to) / SPEED_MPS;
        places
            .iter()
            .flat_map(|from| places.iter().map(move |to| seconds(from, to)))
            .collect()
    }
}

impl Agent for Beeline {
    fn begin(&mut self, briefing: &Briefing, _events: &mut dyn Events) -> Result<(), GiveUp> {
        let Goal::Instruction(instruction) = &briefing.goal else {
            return Err(give_up(
                FailureCause::Briefing,
                "this agent takes instructions only",
            ));
        };
        let data = OsmData::from_bytes(&briefing.map_osm)
            .map_err(|error| give_up(FailureCause::Briefing, &with_causes(&error)))?;
        let map = OsmMap::new(&data, briefing.georeference);
        let start = briefing.start_pose()?;
        let plan = plan(instruction, &map, start)
            .map_err(|error| give_up(FailureCause::NotUnderstood, &with_causes(&error)))?;
        let mut localizer = DeadReckoning::new(briefing.robot.clone());
        localizer.reset(start);
        self.drive = Some(Drive {
            localizer,
            stops: stops(&plan, &map, start),
        });
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _events: &mut dyn Events) -> Action {
        match &mut self.drive {
            Some(drive) => drive.act(observation),
            None => Action::Drive(Velocity::ZERO),
        }
    }
}

impl Drive {
    fn act(&mut self, observation: &Observation<'_>) -> Action {
        self.localizer.update(observation);
        let pose = self.localizer.pose();
        let Some(stop) = self.stops.front() else {
            return Action::GiveUp(give_up(FailureCause::UnknownAddress, "no building is left"));
        };
        let error = wrap_angle(pose.point().bearing_to(stop.target) - pose.yaw);
        let is_facing = error.abs() < TURN_FIRST_RAD;
        // The wall of the building before may still be in front until the robot has turned.
        let is_stopped = is_facing && observation.scan.is_some_and(is_blocked);
        if is_stopped || pose.point().distance(stop.target) < ARRIVED_M {
            let address = stop.address.clone();
            self.stops.pop_front();
            return Action::Delivered(address);
        }
        if !self.localizer.ready() {
            return Action::Drive(Velocity::ZERO);
        }
        let forward = if is_facing { SPEED_MPS } else { 0.0 };
        Action::Drive(Velocity::new(forward, TURN_GAIN_PER_S * error))
    }
}

/// The deliveries that an instruction asks for.
fn plan(instruction: &str, map: &OsmMap, start: Pose2) -> Result<Plan, PlanError> {
    GrammarPlanner::new().plan(&PlanRequest {
        instruction,
        map,
        start: start.point(),
        times: &StraightTimes,
    })
}

/// The deliveries to buildings on the map.
fn stops(plan: &Plan, map: &OsmMap, start: Pose2) -> VecDeque<Stop> {
    let mut from = start.point();
    let mut stops = VecDeque::new();
    for delivery in &plan.deliveries {
        let name = Some(delivery.building.as_str());
        let building = map.buildings.iter().find(|b| b.name.as_deref() == name);
        let Some(building) = building else {
            // Unknown, or one of several of that name: `delivery.problem` says why. It is given up
            // after the others.
            continue;
        };
        let target = building.polygon.nearest_boundary_point(from).point;
        stops.push_back(Stop {
            address: delivery.address(),
            target,
        });
        from = target;
    }
    stops
}

/// Whether something stands close in front of the LiDAR.
fn is_blocked(scan: &LidarScan) -> bool {
    let mut ahead = scan.points.iter().filter(|point| is_ahead(point));
    ahead.any(|point| point.xyz[0] < STOP_M)
}

/// Whether a point lies in front of the robot; `xyz` is forward, left and up of the LiDAR.
fn is_ahead(point: &LidarPoint) -> bool {
    let [forward, left, up] = point.xyz;
    forward > 0.0 && left.abs() < HALF_WIDTH_M && up.abs() < HALF_HEIGHT_M
}

fn give_up(cause: FailureCause, detail: &str) -> GiveUp {
    GiveUp {
        address: None,
        cause,
        detail: detail.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_low_and_in_front_stops_the_robot() {
        let at = |xyz| LidarPoint {
            xyz,
            offset_ns: 0,
            reflectivity: 100,
            line: 0,
        };
        assert!(is_ahead(&at([0.5, 0.2, 0.0])));
        assert!(!is_ahead(&at([-0.5, 0.0, 0.0])));
        assert!(!is_ahead(&at([0.5, 0.3, 0.0])));
        assert!(!is_ahead(&at([0.5, 0.0, -0.2])));
    }
}
