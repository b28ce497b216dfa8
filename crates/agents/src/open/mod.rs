//! OPEN's mission, after Fig. 2 of the paper. The instruction becomes ordered deliveries. Each is
//! looked up in the map: a mapped door is driven to, an unmapped one is searched for around its
//! building. A door that was found is written into the map.
//!
//! | module | its part |
//! |---|---|
//! | [`settings`] | [`Settings`]: what can be set, defaults, the constants of the tuning |
//! | [`parts`] | what can be exchanged: planner, reader, localizer, local planner |
//! | [`catalogue`] | [`Catalogue`]: the parts that there are, by name |
//! | [`choices`] | [`Choices`]: the values that each setting takes, for help texts |
//! | [`models`] | [`Models`]: the language and vision models of a mission |
//! | [`mission`] | deliveries one after another, and the stages of each |
//! | [`locating`] | finding out where the robot is |
//! | [`caution`] | what the robot does when its pose cannot be trusted |
//! | [`driving`] | costmaps, navigator, and when a target is given up |
//! | [`terrain`] | the ground nearby, and corridors to distant goals |
//! | [`exploration`] | waypoints around a building |
//! | [`doorstep`] | where a parcel is put down in front of a door |
//! | [`sighting`] | the position of a plate, by LiDAR |
//! | [`senses`] | where the robot is, and what its LiDAR shows there |
//! | [`perception`] | LiDAR scans in the `map` frame |
//! | [`memory`] | the agent's own copy of the map |
//! | `thinking` | how long the robot stands while models compute |

pub mod catalogue;
pub mod caution;
pub mod choices;
pub mod doorstep;
pub mod driving;
pub mod exploration;
pub mod locating;
pub mod memory;
pub mod mission;
pub mod models;
pub mod parts;
pub mod perception;
pub mod senses;
pub mod settings;
pub mod sighting;
pub mod terrain;
mod thinking;

use openbench_core::{Action, Agent, Briefing, Events, FailureCause, GiveUp, Observation, SimTime};

use crate::Border;
pub use catalogue::Catalogue;
pub use choices::Choices;
use mission::Mission;
pub use models::{Models, ModelsError};
pub use parts::Parts;
pub use settings::{Settings, SettingsError};
use thinking::Thinking;

/// The baseline agent.
pub struct Open {
    parts: Option<Parts>,
    mission: Option<Mission>,
    thinking: Thinking,
    border: Border,
}

impl Open {
    /// An agent made of these parts.
    pub fn new(parts: Parts) -> Self {
        let thinking = Thinking::new(parts.meter.clone(), parts.thinks_in_simulated_time);
        Self {
            parts: Some(parts),
            mission: None,
            thinking,
            border: Border::default(),
        }
    }
}

impl Agent for Open {
    fn begin(&mut self, briefing: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp> {
        let parts = self.parts.take().ok_or_else(|| GiveUp {
            address: None,
            cause: FailureCause::AgentError,
            detail: "the agent was begun twice; make a new one for each episode".into(),
        })?;
        let (border, briefing) = Border::of(briefing);
        self.border = border;
        let events = &mut border.events(events);
        let begun = Mission::begin(parts, &briefing, events);
        // Before `begun?`: what was asked of models is reported even if the mission cannot begin.
        self.thinking.account(SimTime::ZERO, events);
        self.mission = Some(begun?);
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        let fix = self.border.fix(observation);
        let observation = &Observation {
            gnss: fix.as_ref(),
            ..*observation
        };
        let events = &mut self.border.events(events);
        match &mut self.mission {
            // The robot stands, but takes in its sensors: localizer and costmaps must not miss a
            // scan.
            Some(mission) if self.thinking.lasts(observation.time) => {
                mission.wait(observation, events)
            }
            Some(mission) => {
                if let Some(stood) = self.thinking.ended() {
                    // Before the mission acts, so that no timeout counts the time that models took.
                    mission.resume(stood);
                }
                let action = mission.act(observation, events);
                self.thinking.account(observation.time, events);
                action
            }
            None => Action::GiveUp(GiveUp {
                address: None,
                cause: FailureCause::AgentError,
                detail: "the agent was not begun".into(),
            }),
        }
    }

    fn finish(&mut self, _events: &mut dyn Events) -> Option<Vec<u8>> {
        self.mission.as_ref().map(Mission::map_osm)
    }
}
