//! An agent: it drives straight at the building whose name the instruction contains, by wheel
//! odometry and gyroscope, and declares the delivery where an obstacle stops it.

use openbench::{AgentError, AgentRequest};
use openbench_core::address::fold_name;
use openbench_core::frames::wrap_angle;
use openbench_core::{
    Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, Goal, LidarPoint, LidarScan,
    MapPoint, Observation, Velocity, with_causes,
};
use openbench_localization::{DeadReckoning, Localizer};
use openbench_osm::{Building, OsmData, OsmMap};

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

/// Drives straight at a building.
struct Beeline {
    /// `None` until the briefing.
    drive: Option<Drive>,
}

/// The drive of an episode.
struct Drive {
    localizer: DeadReckoning,
    address: Address,
    /// The point of the building's wall that is nearest to the start.
    target: MapPoint,
}

impl Agent for Beeline {
    fn begin(&mut self, briefing: &Briefing, _events: &mut dyn Events) -> Result<(), GiveUp> {
        let Goal::Instruction(words) = &briefing.goal else {
            return Err(give_up(FailureCause::NotUnderstood, "words only"));
        };
        let data = OsmData::from_bytes(&briefing.map_osm)
            .map_err(|error| give_up(FailureCause::Briefing, &with_causes(&error)))?;
        let map = OsmMap::new(&data, briefing.georeference);
        let building = building_in(words, &map)
            .ok_or_else(|| give_up(FailureCause::UnknownAddress, "no building named"))?;
        let mut localizer = DeadReckoning::new(briefing.robot.clone());
        localizer.reset(briefing.start);
        let wall = building
            .polygon
            .nearest_boundary_point(briefing.start.point());
        self.drive = Some(Drive {
            localizer,
            address: Address {
                building: building.name.clone().unwrap_or_default(),
                unit: None,
            },
            target: wall.point,
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
        let is_stopped = observation.scan.is_some_and(is_blocked);
        if is_stopped || pose.point().distance(self.target) < ARRIVED_M {
            return Action::Delivered(self.address.clone());
        }
        if !self.localizer.ready() {
            return Action::Drive(Velocity::ZERO);
        }
        let error = wrap_angle(pose.point().bearing_to(self.target) - pose.yaw);
        let is_ahead = error.abs() < TURN_FIRST_RAD;
        let forward = if is_ahead { SPEED_MPS } else { 0.0 };
        Action::Drive(Velocity::new(forward, TURN_GAIN_PER_S * error))
    }
}

/// The building whose name a text contains.
fn building_in<'m>(text: &str, map: &'m OsmMap) -> Option<&'m Building> {
    let text = fold_name(text);
    map.buildings.iter().find(|building| {
        let name = building.name.as_deref();
        name.is_some_and(|name| text.contains(&fold_name(name)))
    })
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
