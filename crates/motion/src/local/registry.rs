//! Local planners by name.

use std::error::Error;
use std::sync::Arc;

use openbench_core::registry::Entry;
use openbench_core::{Registry, RobotDescription};

use super::planner::LocalPlanner;

/// What every local planner is made from.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PlannerSettings {
    /// The robot that is driven.
    pub robot: RobotDescription,
    /// Seed of planners that draw random numbers.
    pub seed: u64,
}

impl PlannerSettings {
    /// For a robot, with seed 1.
    pub fn new(robot: RobotDescription) -> Self {
        Self { robot, seed: 1 }
    }

    /// The same with another seed.
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }
}

/// What a constructor of a local planner fails with.
pub type MakeError = Box<dyn Error + Send + Sync>;
/// Makes a local planner.
pub type MakePlanner =
    dyn Fn(&PlannerSettings) -> Result<Box<dyn LocalPlanner>, MakeError> + Send + Sync;
/// A local planner that can be asked for by its name.
pub type PlannerEntry = Entry<Arc<MakePlanner>>;

/// Local planners by name. [`built_in`](super::built_in::built_in) has those of this crate.
///
/// ```
/// use openbench_core::{RobotDescription, Velocity};
/// use openbench_motion::local::built_in::built_in;
/// use openbench_motion::local::{PlannerSettings, make_planner, planner_entry};
/// use openbench_motion::{Blocked, LocalPlanner, Progress, Situation};
///
/// /// Drives straight on, whatever comes.
/// struct Blind;
///
/// impl LocalPlanner for Blind {
///     fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
///         situation.check()?;
///         Ok(Progress::Drive(Velocity::new(0.2, 0.0)))
///     }
///
///     fn reset(&mut self) {}
/// }
///
/// let blind = planner_entry("blind", "Drives straight on", |_| Ok(Box::new(Blind)));
/// let planners = built_in().with_entry(blind);
/// assert!(planners.names().eq(["teb", "follower", "mppi", "blind"]));
/// let settings = PlannerSettings::new(RobotDescription::sentry());
/// assert!(make_planner(planners.find("blind")?.entry, &settings).is_ok());
/// # Ok::<(), openbench_core::UnknownName>(())
/// ```
pub type LocalPlanners = Registry<Arc<MakePlanner>>;

/// An entry from a name, one line that says what the planner is, and its constructor.
pub fn planner_entry<F>(name: &str, about: &str, make: F) -> PlannerEntry
where
    F: Fn(&PlannerSettings) -> Result<Box<dyn LocalPlanner>, MakeError> + Send + Sync + 'static,
{
    Entry::new(name, about, Arc::new(make))
}

/// A planner of an entry.
///
/// # Errors
/// [`PlannerError`] if the constructor fails.
pub fn make_planner(
    entry: &PlannerEntry,
    settings: &PlannerSettings,
) -> Result<Box<dyn LocalPlanner>, PlannerError> {
    (entry.part)(settings).map_err(|source| PlannerError {
        name: entry.name.clone(),
        source,
    })
}

/// A local planner cannot be made for this robot or with its settings.
#[derive(Debug, thiserror::Error)]
#[error("the local planner {name} cannot be made")]
pub struct PlannerError {
    /// Its name.
    pub name: String,
    /// Why.
    pub source: MakeError,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn why_a_planner_cannot_be_made_is_kept() {
        let broken = planner_entry("broken", "", |_| Err(std::fmt::Error.into()));
        let settings = PlannerSettings::new(RobotDescription::sentry());
        let Err(error) = make_planner(&broken, &settings) else {
            panic!("it was made")
        };
        let source = error.source().unwrap();
        assert!(source.is::<std::fmt::Error>());
        assert_eq!(error.to_string(), "the local planner broken cannot be made");
    }
}
