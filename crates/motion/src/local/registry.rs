//! Local planners by name.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use openbench_core::RobotDescription;

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
type AnyError = Box<dyn Error + Send + Sync>;
/// Makes a local planner.
type Make = dyn Fn(&PlannerSettings) -> Result<Box<dyn LocalPlanner>, AnyError> + Send + Sync;

/// A local planner that can be asked for by its name.
#[derive(Clone)]
pub struct Entry {
    name: &'static str,
    description: &'static str,
    make: Arc<Make>,
}

impl Entry {
    /// An entry from a name, one line that says what the planner is, and its constructor.
    pub fn new<P, E>(
        name: &'static str,
        description: &'static str,
        make: impl Fn(&PlannerSettings) -> Result<P, E> + Send + Sync + 'static,
    ) -> Self
    where
        P: LocalPlanner + 'static,
        E: Into<AnyError>,
    {
        let make = move |settings: &PlannerSettings| match make(settings) {
            Ok(planner) => Ok(Box::new(planner) as Box<dyn LocalPlanner>),
            Err(error) => Err(error.into()),
        };
        Self {
            name,
            description,
            make: Arc::new(make),
        }
    }

    /// Its name, as users write it.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// One line that says what it is.
    pub fn description(&self) -> &'static str {
        self.description
    }

    /// A planner of this kind.
    pub fn make(&self, settings: &PlannerSettings) -> Result<Box<dyn LocalPlanner>, PlannerError> {
        (self.make)(settings).map_err(|source| PlannerError::Unfit {
            name: self.name,
            source,
        })
    }
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name, description, ..
        } = self;
        f.debug_struct("Entry")
            .field("name", name)
            .field("description", description)
            .finish()
    }
}

/// A local planner cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlannerError {
    /// There is none of that name.
    #[error("there is no such local planner; there are {}", known.join(", "))]
    Unknown {
        /// The name that was asked for.
        name: String,
        /// The names that there are.
        known: Vec<&'static str>,
    },
    /// It cannot be made for this robot or with its settings.
    #[error("the local planner {name} cannot be made")]
    Unfit {
        /// Its name.
        name: &'static str,
        /// Why.
        source: AnyError,
    },
}

/// Local planners by name, in the order in which they are listed.
///
/// [`built_in`](super::built_in::built_in) has those of this crate; [`LocalPlanners::with`] adds
/// others, from wherever they come, or replaces one by the same with other settings.
///
/// ```
/// use openbench_core::{RobotDescription, Velocity};
/// use openbench_motion::local::built_in::built_in;
/// use openbench_motion::local::{Entry, PlannerSettings};
/// use openbench_motion::{Blocked, LocalPlanner, Progress, ShapeError, Situation};
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
/// let blind = Entry::new("blind", "Drives straight on", |_: &PlannerSettings| {
///     Ok::<_, ShapeError>(Blind)
/// });
/// let planners = built_in().with(blind);
/// assert_eq!(planners.names(), ["teb", "follower", "mppi", "blind"]);
/// let settings = PlannerSettings::new(RobotDescription::sentry());
/// assert!(planners.make("blind", &settings).is_ok());
/// ```
#[derive(Debug, Clone, Default)]
pub struct LocalPlanners {
    entries: Vec<Entry>,
}

impl LocalPlanners {
    /// Planners in an order; of two with the same name the later one counts.
    pub fn new(entries: impl IntoIterator<Item = Entry>) -> Self {
        entries.into_iter().fold(Self::default(), Self::with)
    }

    /// These and one more; an entry of the same name is replaced and keeps its place.
    pub fn with(mut self, entry: Entry) -> Self {
        match self
            .entries
            .iter_mut()
            .find(|known| known.name == entry.name)
        {
            Some(known) => *known = entry,
            None => self.entries.push(entry),
        }
        self
    }

    /// The entries, in their order.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Their names, in their order.
    pub fn names(&self) -> Vec<&'static str> {
        self.entries.iter().map(|entry| entry.name).collect()
    }

    /// Those of some names, in the order of this list; all of them if no name is given.
    pub fn select(&self, names: &[impl AsRef<str>]) -> Result<Self, PlannerError> {
        names
            .iter()
            .try_for_each(|name| self.get(name.as_ref()).map(drop))?;
        let is_wanted = |entry: &&Entry| {
            names.is_empty() || names.iter().any(|name| name.as_ref() == entry.name)
        };
        Ok(Self {
            entries: self.entries.iter().filter(is_wanted).cloned().collect(),
        })
    }

    /// The entry of a name.
    pub fn get(&self, name: &str) -> Result<&Entry, PlannerError> {
        self.entries
            .iter()
            .find(|entry| entry.name == name)
            .ok_or_else(|| PlannerError::Unknown {
                name: name.to_owned(),
                known: self.names(),
            })
    }

    /// The planner of a name.
    pub fn make(
        &self,
        name: &str,
        settings: &PlannerSettings,
    ) -> Result<Box<dyn LocalPlanner>, PlannerError> {
        self.get(name)?.make(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local::planner::{Blocked, Progress, Situation};

    struct Parked;

    impl LocalPlanner for Parked {
        fn plan(&mut self, _situation: &Situation<'_>) -> Result<Progress, Blocked> {
            Err(Blocked::NoGap)
        }

        fn reset(&mut self) {}
    }

    fn parked(name: &'static str, description: &'static str) -> Entry {
        Entry::new(name, description, |_: &PlannerSettings| {
            Ok::<_, std::fmt::Error>(Parked)
        })
    }

    fn settings() -> PlannerSettings {
        PlannerSettings::new(RobotDescription::sentry())
    }

    #[test]
    fn a_planner_is_added_after_the_others_and_replaced_in_its_place() {
        let planners = LocalPlanners::new([parked("a", ""), parked("b", "")]);
        let planners = planners.with(parked("c", "new")).with(parked("a", "other"));
        let listed: Vec<_> = planners
            .entries()
            .iter()
            .map(|e| (e.name(), e.description()))
            .collect();
        assert_eq!(listed, [("a", "other"), ("b", ""), ("c", "new")]);
        assert!(planners.make("c", &settings()).is_ok());
    }

    #[test]
    fn planners_are_selected_in_the_order_of_the_list() {
        let planners = LocalPlanners::new([parked("a", ""), parked("b", ""), parked("c", "")]);
        let names = |wanted: &[&str]| planners.select(wanted).map(|some| some.names());
        assert_eq!(names(&["c", "a", "c"]).unwrap(), ["a", "c"]);
        assert_eq!(names(&[]).unwrap(), ["a", "b", "c"]);
        assert!(names(&["a", "x"]).is_err());
    }

    #[test]
    fn an_unknown_name_is_refused_with_those_that_there_are() {
        let planners = LocalPlanners::new([parked("a", ""), parked("b", "")]);
        let error = planners.get("x").unwrap_err();
        assert!(error.to_string().ends_with("there are a, b"), "{error}");
    }

    #[test]
    fn why_a_planner_cannot_be_made_is_kept() {
        let broken = Entry::new("broken", "", |_: &PlannerSettings| {
            Err::<Parked, _>(std::fmt::Error)
        });
        let Err(error) = broken.make(&settings()) else {
            panic!("it was made")
        };
        assert!(
            error
                .source()
                .is_some_and(|source| source.is::<std::fmt::Error>())
        );
    }
}
