//! What a binary of one's own adds to the built-in agents and parts.

use std::sync::Arc;

use openbench_agents::open::Catalogue;
use openbench_agents::open::parts::{Fixes, FixesPart, LocalizerPart, PartError};
use openbench_bench::run::registry::AgentError;
use openbench_bench::{AgentFactory, AgentRequest, Agents, yardsticks};
use openbench_core::registry::Entry;
use openbench_core::{Agent, Registry, RobotDescription};
use openbench_localization::Localizer;
use openbench_motion::local::{LocalPlanners, planner_entry};
use openbench_motion::{LocalPlanner, PlannerSettings};
use openbench_vision::{PlateReader, ReaderContext, ReaderPart};

use crate::open_agent::{self, OpenFactory};
use crate::policy_agents;
use crate::served_agents;

/// Agents, and parts of OPEN, beside the built-in ones.
///
/// Each is registered by its name, one line that says what it is, and what makes it. A name that a
/// part already has is replaced: `with_localizer("fused", …)` is what OPEN then localizes with. The
/// names of results that must not change their meaning are reserved; see [`ExtensionError`].
///
/// | kind | with a function | with all that the kind can do |
/// |---|---|---|
/// | agent | [`with_agent`](Self::with_agent) | [`with_agent_factory`](Self::with_agent_factory) |
/// | plate reader | [`with_reader`](Self::with_reader) | [`with_reader_part`](Self::with_reader_part) |
/// | localizer | [`with_localizer`](Self::with_localizer) | [`with_localizer_part`](Self::with_localizer_part) |
/// | source of fixes | [`with_fixes`](Self::with_fixes) | [`with_fixes_part`](Self::with_fixes_part) |
/// | local planner | [`with_local_planner`](Self::with_local_planner) | |
///
/// ```no_run
/// use openbench::Extensions;
/// use openbench_core::RobotDescription;
/// use openbench_localization::{DeadReckoning, Localizer};
///
/// fn wheels(robot: &RobotDescription) -> Box<dyn Localizer> {
///     Box::new(DeadReckoning::new(robot.clone()))
/// }
///
/// fn main() -> std::process::ExitCode {
///     let extensions = Extensions::new().with_localizer("wheels", "my own odometry", wheels);
///     openbench::main_with(extensions)
/// }
/// ```
#[derive(Clone)]
pub struct Extensions {
    agents: Agents,
    parts: Catalogue,
    /// The local planners from outside alone, for commands that compare planners with settings of
    /// their own instead of those of OPEN.
    added_planners: LocalPlanners,
    refused: Option<ExtensionError>,
}

/// A name under which nothing can be registered.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtensionError {
    /// The name has a meaning in results.
    #[error(
        "the {kind} `{name}` cannot be replaced: in results this name means {meaning}; register \
         yours under another name"
    )]
    Reserved {
        /// What kind of part it is.
        kind: &'static str,
        /// The name.
        name: String,
        /// What it means.
        meaning: &'static str,
    },
    /// The name cannot be written on the command line.
    #[error(
        "`{name}` cannot be the name of a {kind}: use letters, digits and hyphens, such as my-part"
    )]
    BadName {
        /// What kind of part it is.
        kind: &'static str,
        /// The name.
        name: String,
    },
}

impl Default for Extensions {
    fn default() -> Self {
        Self::new()
    }
}

impl Extensions {
    /// The built-in agents and parts alone.
    pub fn new() -> Self {
        let parts = Catalogue::default();
        Self {
            agents: Agents::default(),
            added_planners: Registry::new(parts.local_planners.kind()),
            parts,
            refused: None,
        }
    }

    /// Adds an agent that a function makes for each episode: `--agent NAME`.
    #[must_use]
    pub fn with_agent<F>(self, name: &str, about: &str, make: F) -> Self
    where
        F: Fn(&AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> + Send + Sync + 'static,
    {
        self.with_agent_factory(name, about, make)
    }

    /// Adds an agent with a factory, which can check settings before a run and download files.
    #[must_use]
    pub fn with_agent_factory(
        mut self,
        name: &str,
        about: &str,
        factory: impl AgentFactory + 'static,
    ) -> Self {
        self.check(self.agents.kind(), name, Arguments::None);
        self.agents = self.agents.with(name, about, Arc::new(factory));
        self
    }

    /// Adds a plate reader: `--set reader=NAME`. The function gets the settings of all readers, the
    /// folder of model files, and what opens chat models.
    #[must_use]
    pub fn with_reader<F>(self, name: &str, about: &str, make: F) -> Self
    where
        F: Fn(&mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, PartError>
            + Send
            + Sync
            + 'static,
    {
        let part = ReaderPart::new(move |_, context: &mut ReaderContext<'_>| make(context));
        self.with_reader_part(name, about, part)
    }

    /// Adds a plate reader that requires model files, or takes an argument: the name
    /// `mine:MODEL` is for `--set reader=mine:ARGUMENT`.
    #[must_use]
    pub fn with_reader_part(mut self, name: &str, about: &str, part: ReaderPart) -> Self {
        self.check(self.parts.readers.kind(), name, Arguments::Possible);
        self.parts.readers = self.parts.readers.with(name, about, part);
        self
    }

    /// Adds a localizer: `--set localizer=NAME`.
    #[must_use]
    pub fn with_localizer(
        self,
        name: &str,
        about: &str,
        make: impl Fn(&RobotDescription) -> Box<dyn Localizer> + Send + Sync + 'static,
    ) -> Self {
        self.with_localizer_part(name, about, LocalizerPart::without_fixes(make))
    }

    /// Adds a localizer that may take fixes: `--set localizer=NAME --set fixes=SOURCE`.
    #[must_use]
    pub fn with_localizer_part(mut self, name: &str, about: &str, part: LocalizerPart) -> Self {
        self.check(self.parts.localizers.kind(), name, Arguments::None);
        self.parts.localizers = self.parts.localizers.with(name, about, part);
        self
    }

    /// Adds a source of fixes: `--set fixes=NAME`.
    #[must_use]
    pub fn with_fixes(
        self,
        name: &str,
        about: &str,
        make: impl Fn(&RobotDescription) -> Fixes + Send + Sync + 'static,
    ) -> Self {
        self.with_fixes_part(name, about, FixesPart::new(make))
    }

    /// Adds a source of fixes that may take an argument: the name `log:FILE` is for
    /// `--set fixes=log:ARGUMENT`.
    #[must_use]
    pub fn with_fixes_part(mut self, name: &str, about: &str, part: FixesPart) -> Self {
        self.check(self.parts.fixes.kind(), name, Arguments::Possible);
        self.parts.fixes = self.parts.fixes.with(name, about, part);
        self
    }

    /// Adds a local planner: `--set motion=NAME`, `bench motion --planner NAME` and
    /// `bench people --planner NAME`.
    #[must_use]
    pub fn with_local_planner<F>(mut self, name: &str, about: &str, make: F) -> Self
    where
        F: Fn(&PlannerSettings) -> Result<Box<dyn LocalPlanner>, PartError> + Send + Sync + 'static,
    {
        self.check(self.added_planners.kind(), name, Arguments::None);
        let entry = planner_entry(name, about, make);
        // In both: OPEN takes the planner from its parts, and `bench motion` from the added ones.
        self.added_planners = self.added_planners.with_entry(entry.clone());
        self.parts.local_planners = self.parts.local_planners.with_entry(entry);
        self
    }

    /// Whether everything can be registered under its name. [`main_with`](crate::main_with) asks
    /// first.
    ///
    /// # Errors
    /// [`ExtensionError`] of the first name that cannot be used.
    pub fn checked(&self) -> Result<(), ExtensionError> {
        self.refused.clone().map_or(Ok(()), Err)
    }

    /// All agents, OPEN among them.
    pub(crate) fn agents(&self) -> Agents {
        // Made on request, when all parts have been added.
        let open: Arc<dyn AgentFactory> = Arc::new(OpenFactory::new(self.parts.clone()));
        self.agents
            .clone()
            .with(open_agent::NAME, "the baseline of the paper", open)
            .with_argument(
                "python:FILE:CLASS",
                "a class in a Python file",
                policy_agents::python,
            )
            .with_argument(
                "program:COMMAND",
                "a program that speaks the policy protocol",
                policy_agents::program,
            )
            .with_argument(
                "openpi:ws://HOST:PORT",
                "a policy server of openpi",
                served_agents::openpi,
            )
            .with_argument(
                "vla-eval:ws://HOST:PORT",
                "a model server of vla-eval",
                served_agents::vla_eval,
            )
            .with_argument(
                "navdp:http://HOST:PORT",
                "a server of NavDP",
                served_agents::navdp,
            )
            .with_all(&yardsticks::agents())
    }

    /// The parts that OPEN can be made of.
    pub(crate) fn parts(&self) -> &Catalogue {
        &self.parts
    }

    /// These local planners, with those from outside added to them or in their places.
    pub(crate) fn planners_beside(&self, built_in: LocalPlanners) -> LocalPlanners {
        built_in.with_entries(self.added_planners.entries().cloned())
    }

    /// Keeps the error of a name that cannot be used, if it is the first.
    fn check(&mut self, kind: &'static str, name: &str, arguments: Arguments) {
        // Builder methods return `Self`, so the error waits until `checked` is called.
        if self.refused.is_none() {
            self.refused = refusal(kind, name, arguments);
        }
    }
}

/// Whether parts of a kind can take an argument after a colon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Arguments {
    None,
    Possible,
}

/// Why a name cannot be used.
fn refusal(kind: &'static str, name: &str, arguments: Arguments) -> Option<ExtensionError> {
    let entry = Entry::new(name, "", ());
    let word = entry.word();
    // A comma separates names of a list, and blanks around a name are removed.
    let is_plain =
        !word.is_empty() && !word.contains([',', '=']) && !word.contains(char::is_whitespace);
    if !is_plain || entry.takes_argument() && arguments == Arguments::None {
        return Some(ExtensionError::BadName {
            kind,
            name: name.to_owned(),
        });
    }
    let reserved = open_agent::RESERVED
        .iter()
        .find(|reserved| reserved.kind == kind && reserved.name == word)?;
    Some(ExtensionError::Reserved {
        kind,
        name: word.to_owned(),
        meaning: reserved.meaning,
    })
}

#[cfg(test)]
mod tests {
    use openbench_localization::DeadReckoning;

    use super::*;

    fn wheels(robot: &RobotDescription) -> Box<dyn Localizer> {
        Box::new(DeadReckoning::new(robot.clone()))
    }

    fn no_agent(_: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        Err("there is none".into())
    }

    fn no_planner(_: &PlannerSettings) -> Result<Box<dyn LocalPlanner>, PartError> {
        Err("there is none".into())
    }

    fn no_fixes(_: &RobotDescription) -> Fixes {
        Vec::new()
    }

    #[test]
    fn names_with_a_meaning_in_results_are_reserved() {
        let new = Extensions::new;
        let all = [
            (new().with_agent("open", "", no_agent), "the baseline agent"),
            (new().with_localizer("truth", "", wheels), "the true pose"),
            (
                new().with_fixes("disturbed-truth", "", no_fixes),
                "the true pose with",
            ),
            (new().with_fixes("none", "", no_fixes), "no fixes"),
        ];
        for (extensions, meaning) in all {
            let error = extensions.checked().unwrap_err();
            assert!(matches!(error, ExtensionError::Reserved { .. }), "{error}");
            assert!(error.to_string().contains(meaning), "{error}");
        }
        // What is reserved for one kind is free for others.
        let others = new()
            .with_agent("truth", "", no_agent)
            .with_localizer("open", "", wheels);
        assert_eq!(others.checked(), Ok(()));
    }

    #[test]
    fn names_that_cannot_be_written_are_refused() {
        for name in ["", "my wheels", "a,b", "wheels:"] {
            let extensions = Extensions::new().with_localizer(name, "", wheels);
            let bad = ExtensionError::BadName {
                kind: "localizer",
                name: name.to_owned(),
            };
            assert_eq!(extensions.checked(), Err(bad));
        }
    }

    #[test]
    fn a_part_replaces_the_built_in_one_of_its_name_in_every_list() {
        let extensions = Extensions::new()
            .with_local_planner("follower", "mine", no_planner)
            .with_local_planner("dwa", "mine", no_planner);
        assert_eq!(extensions.checked(), Ok(()));
        let built_in = Extensions::new().parts().local_planners.clone();
        for planners in [
            extensions.parts().local_planners.clone(),
            extensions.planners_beside(built_in),
        ] {
            let names: Vec<&str> = planners.names().collect();
            assert_eq!(names, ["teb", "follower", "mppi", "dwa"]);
            assert_eq!(planners.find("follower").unwrap().entry.about, "mine");
        }
    }

    #[test]
    fn a_source_of_fixes_takes_its_argument() {
        let log = FixesPart::with_argument(|file| match file {
            "" => Err("write fixes=log:FILE".into()),
            _ => Ok(Box::new(|_| Vec::new())),
        });
        let extensions = Extensions::new().with_fixes_part("log:FILE", "recorded fixes", log);
        let localizer = |fixes| extensions.parts().localizer("fused", Some(fixes));
        assert!(localizer("log:fixes.csv").is_ok());
        assert!(localizer("log").is_err());
    }
}
