//! An agent: it drives straight at the building whose name the instruction contains, by wheel
//! odometry and gyroscope, and declares the delivery where an obstacle stops it.

use openbench::{AgentError, AgentRequest};
use openbench_core::address::fold_name;
use openbench_core::frames::wrap_angle;
use openbench_core::{Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, Goal};
use openbench_core::{LidarPoint, MapPoint, Observation, RobotDescription, Velocity, with_causes};
use openbench_localization::{DeadReckoning, Localizer};
use openbench_osm::{OsmData, OsmMap};

/// The agent by its name: `--agent beeline`.
pub fn make(_: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
    Ok(Box::new(Beeline::default()))
}

/// Drives straight at a building.
struct Beeline {
    localizer: DeadReckoning,
    target: Option<(Address, MapPoint)>,
}

impl Default for Beeline {
    fn default() -> Self {
        Self {
            localizer: DeadReckoning::new(RobotDescription::sentry()),
            target: None,
        }
    }
}

impl Agent for Beeline {
    fn begin(&mut self, briefing: &Briefing, _events: &mut dyn Events) -> Result<(), GiveUp> {
        let give_up = |cause, detail: &str| GiveUp {
            address: None,
            cause,
            detail: detail.into(),
        };
        let data = OsmData::from_bytes(&briefing.map_osm)
            .map_err(|e| give_up(FailureCause::Briefing, &with_causes(&e)))?;
        let map = OsmMap::new(&data, briefing.georeference);
        let Goal::Instruction(words) = &briefing.goal else {
            return Err(give_up(FailureCause::NotUnderstood, "words only"));
        };
        let named = |name: &&str| fold_name(words).contains(&fold_name(name));
        let building = map
            .buildings
            .iter()
            .find(|b| b.name.as_deref().as_ref().is_some_and(named));
        let building =
            building.ok_or_else(|| give_up(FailureCause::UnknownAddress, "no building named"))?;
        let address = Address {
            building: building.name.clone().unwrap_or_default(),
            unit: None,
        };
        self.target = Some((
            address,
            building
                .polygon
                .nearest_boundary_point(briefing.start.point())
                .point,
        ));
        self.localizer.reset(briefing.start);
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _events: &mut dyn Events) -> Action {
        self.localizer.update(observation);
        let Some((address, point)) = &self.target else {
            return Action::Drive(Velocity::ZERO);
        };
        let pose = self.localizer.pose();
        let ahead =
            |p: &&LidarPoint| p.xyz[0] > 0.0 && p.xyz[1].abs() < 0.25 && p.xyz[2].abs() < 0.1;
        let nearest = observation.scan.and_then(|s| {
            s.points
                .iter()
                .filter(ahead)
                .map(|p| p.xyz[0])
                .reduce(f32::min)
        });
        if pose.point().distance(*point) < 1.0 || nearest.is_some_and(|range| range < 0.6) {
            return Action::Delivered(address.clone());
        }
        let turn = wrap_angle(pose.point().bearing_to(*point) - pose.yaw);
        let forward = if turn.abs() < 0.3 && self.localizer.ready() {
            0.4
        } else {
            0.0
        };
        Action::Drive(if self.localizer.ready() {
            Velocity::new(forward, turn)
        } else {
            Velocity::ZERO
        })
    }
}
