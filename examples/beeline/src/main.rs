//! An agent of one's own in sixty lines: it drives straight at the building whose name the instruction holds, by counting wheel turns and
//! the gyroscope, and declares the delivery where it meets something.
//!
//! `cargo run --release -p beeline -- run --agent beeline` runs it beside the built-in ones.

use std::process::ExitCode;

use openbench::Registry;
use openbench_core::address::fold_name;
use openbench_core::frames::wrap_angle;
use openbench_core::{Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, Goal};
use openbench_core::{MapPoint, Observation, Velocity};
use openbench_localization::{DeadReckoning, Localizer};
use openbench_osm::{OsmData, OsmMap};

/// Drives straight at a building.
struct Beeline {
    localizer: DeadReckoning,
    target: Option<(Address, MapPoint)>,
}

impl Agent for Beeline {
    fn begin(&mut self, briefing: &Briefing, _events: &mut dyn Events) -> Result<(), GiveUp> {
        let give_up = |cause, detail: &str| GiveUp { address: None, cause, detail: detail.into() };
        let data = OsmData::from_bytes(&briefing.map_osm)
            .map_err(|e| give_up(FailureCause::Briefing, &e.to_string()))?;
        let map = OsmMap::new(&data, briefing.georeference);
        let Goal::Instruction(words) = &briefing.goal else {
            return Err(give_up(FailureCause::NotUnderstood, "words only"));
        };
        let named = |name: &&str| fold_name(words).contains(&fold_name(name));
        let building = map.buildings.iter().find(|b| b.name.as_deref().as_ref().is_some_and(named));
        let building = building.ok_or_else(|| give_up(FailureCause::UnknownAddress, "no building named"))?;
        let address = Address { building: building.name.clone().unwrap_or_default(), unit: None };
        let wall = building.polygon.nearest_boundary_point(briefing.start.point());
        self.target = Some((address, wall.point));
        self.localizer.reset(briefing.start);
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _events: &mut dyn Events) -> Action {
        self.localizer.update(observation);
        let Some((address, point)) = &self.target else { return Action::Drive(Velocity::ZERO) };
        let pose = self.localizer.pose();
        let ahead =
            |p: &&openbench_core::LidarPoint| p.xyz[0] > 0.0 && p.xyz[1].abs() < 0.25 && p.xyz[2].abs() < 0.1;
        let nearest =
            observation.scan.and_then(|s| s.points.iter().filter(ahead).map(|p| p.xyz[0]).reduce(f32::min));
        if pose.point().distance(*point) < 1.0 || nearest.is_some_and(|range| range < 0.6) {
            return Action::Delivered(address.clone());
        }
        let turn = wrap_angle(pose.point().bearing_to(*point) - pose.yaw);
        let forward = if turn.abs() < 0.3 && self.localizer.ready() { 0.4 } else { 0.0 };
        Action::Drive(if self.localizer.ready() { Velocity::new(forward, turn) } else { Velocity::ZERO })
    }
}

fn main() -> ExitCode {
    openbench::main_with(Registry::new().with(
        "beeline",
        Box::new(|_| {
            let localizer = DeadReckoning::new(openbench_core::RobotDescription::sentry());
            Ok(Box::new(Beeline { localizer, target: None }))
        }),
    ))
}
