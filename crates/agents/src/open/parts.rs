//! What OPEN is made of.

use std::error::Error;
use std::sync::Arc;

use openbench_core::{Pose2, RobotDescription, Start};
use openbench_language::Planner;
use openbench_localization::{FixSource, Localizer};
use openbench_models::Meter;
use openbench_motion::costmap::Preferences;
use openbench_motion::local::PlannerEntry;
use openbench_osm::{OsmData, OsmMap};
use openbench_vision::PlateReader;

/// Why a part cannot be made.
pub type PartError = Box<dyn Error + Send + Sync>;
/// The sources of fixes of a localizer.
pub type Fixes = Vec<Box<dyn FixSource>>;

/// What a localizer is made for.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// The robot.
    pub robot: &'a RobotDescription,
    /// The public map, if there is one.
    pub map: Option<&'a OsmMap>,
    /// What is known about the start, in the `map` frame.
    pub start: Start,
}

impl<'a> Situation<'a> {
    /// A robot without a map, at the origin.
    pub const fn without_map(robot: &'a RobotDescription) -> Self {
        Self {
            robot,
            map: None,
            start: Start::exact(Pose2::new(0.0, 0.0, 0.0)),
        }
    }
}

/// Makes the sources of fixes of a robot.
pub type MakeFixes = dyn Fn(&Situation<'_>) -> Fixes + Send + Sync;
/// Makes the localizer of a robot, with its fixes.
pub type MakeSituated = dyn Fn(&Situation<'_>) -> Box<dyn Localizer> + Send + Sync;
/// Reads the argument of a source of fixes: what follows the colon in `fixes=NAME:ARGUMENT`, else
/// nothing.
pub type ReadFixes = dyn Fn(&str) -> Result<Box<MakeFixes>, PartError> + Send + Sync;
/// Makes the localizer of a robot.
pub type MakeLocalizer = dyn Fn(&RobotDescription) -> Box<dyn Localizer> + Send + Sync;
/// Makes the localizer of a robot, with fixes.
pub type MakeFused = dyn Fn(&RobotDescription, Fixes) -> Box<dyn Localizer> + Send + Sync;

/// A registered localizer.
#[derive(Clone)]
pub enum LocalizerPart {
    /// Takes no fixes.
    WithoutFixes(Arc<MakeLocalizer>),
    /// Takes fixes.
    WithFixes(Arc<MakeFused>),
}

impl LocalizerPart {
    /// A localizer that takes no fixes.
    pub fn without_fixes(
        make: impl Fn(&RobotDescription) -> Box<dyn Localizer> + Send + Sync + 'static,
    ) -> Self {
        Self::WithoutFixes(Arc::new(make))
    }

    /// A localizer that takes fixes.
    pub fn with_fixes(
        make: impl Fn(&RobotDescription, Fixes) -> Box<dyn Localizer> + Send + Sync + 'static,
    ) -> Self {
        Self::WithFixes(Arc::new(make))
    }
}

/// A registered source of fixes.
#[derive(Clone)]
pub struct FixesPart(Arc<ReadFixes>);

impl FixesPart {
    /// A source that takes no argument.
    pub fn new(make: impl Fn(&RobotDescription) -> Fixes + Send + Sync + 'static) -> Self {
        Self::on_map(move |situation| make(situation.robot))
    }

    /// A source that takes no argument and uses the public map.
    pub fn on_map(make: impl Fn(&Situation<'_>) -> Fixes + Send + Sync + 'static) -> Self {
        let make = Arc::new(make);
        Self::with_argument(move |_| {
            let make = make.clone();
            Ok(Box::new(move |situation| make(situation)))
        })
    }

    /// A source that takes an argument. It is read, and refused, before a robot is known.
    pub fn with_argument(
        read: impl Fn(&str) -> Result<Box<MakeFixes>, PartError> + Send + Sync + 'static,
    ) -> Self {
        Self(Arc::new(read))
    }

    /// What makes the source with this argument.
    ///
    /// # Errors
    /// Why the argument is refused.
    pub fn read(&self, argument: &str) -> Result<Box<MakeFixes>, PartError> {
        (self.0)(argument)
    }
}

/// The exchangeable parts of OPEN. Those that depend on the robot are made when the briefing
/// describes it.
pub struct Parts {
    /// Turns the instruction into deliveries.
    pub planner: Box<dyn Planner>,
    /// Reads plates.
    pub reader: Box<dyn PlateReader>,
    /// Makes what estimates the robot's pose.
    pub localizer: Box<MakeSituated>,
    /// Makes what turns paths into velocities.
    pub motion: PlannerEntry,
    /// Which ground is preferred to other.
    pub ground: Preferences,
    /// Doors found in earlier runs, if any are to be remembered.
    pub memory: Option<OsmData>,
    /// Counts what planner and reader ask of models.
    pub meter: Meter,
    /// Whether the robot stands still for as long as models take to answer, as a real one would.
    /// The time is measured by the wall clock, so runs repeat only with recorded answers.
    pub thinks_in_simulated_time: bool,
}
