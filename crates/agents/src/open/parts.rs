//! What OPEN is made of.

use std::error::Error;
use std::sync::Arc;

use openbench_core::RobotDescription;
use openbench_language::Planner;
use openbench_localization::{FixSource, Localizer};
use openbench_models::Meter;
use openbench_motion::costmap::Preferences;
use openbench_motion::local::Entry;
use openbench_osm::OsmData;
use openbench_vision::PlateReader;

/// Why a part cannot be made.
pub type PartError = Box<dyn Error + Send + Sync>;
/// Reads the argument of a source of fixes: what follows the colon in `fixes=NAME:ARGUMENT`, else
/// nothing.
pub type ReadFixes = dyn Fn(&str) -> Result<MakeFixes, PartError> + Send + Sync;
/// Makes sources of fixes for a robot.
pub type MakeFixes = Box<dyn Fn(&RobotDescription) -> Vec<Box<dyn FixSource>>>;
/// The sources of fixes of a localizer.
pub type Fixes = Vec<Box<dyn FixSource>>;

/// Makes a localizer of a robot, without fixes.
pub type MakeOdometry = dyn Fn(&RobotDescription) -> Box<dyn Localizer> + Send + Sync;
/// Makes a localizer of a robot, with fixes.
pub type MakeFused = dyn Fn(&RobotDescription, Fixes) -> Box<dyn Localizer> + Send + Sync;

/// A registered localizer.
#[derive(Clone)]
pub enum LocalizerPart {
    /// Takes no fixes.
    WithoutFixes(Arc<MakeOdometry>),
    /// Takes fixes.
    WithFixes(Arc<MakeFused>),
}

/// Makes the localizer of a robot.
pub type MakeLocalizer = Box<dyn FnOnce(&RobotDescription) -> Box<dyn Localizer>>;

/// The exchangeable parts of OPEN. Those that depend on the robot are made when the briefing
/// describes it.
pub struct Parts {
    /// Turns the instruction into deliveries.
    pub planner: Box<dyn Planner>,
    /// Reads plates.
    pub reader: Box<dyn PlateReader>,
    /// Makes what estimates the robot's pose.
    pub localizer: MakeLocalizer,
    /// Makes what turns paths into velocities.
    pub motion: Entry,
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
