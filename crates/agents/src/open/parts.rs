//! What OPEN is made of.

use openbench_language::Planner;
use openbench_localization::Localizer;
use openbench_models::Meter;
use openbench_motion::LocalPlanner;
use openbench_motion::costmap::ground::Preferences;
use openbench_osm::OsmData;
use openbench_vision::PlateReader;

/// The exchangeable parts of OPEN.
pub struct Parts {
    /// Turns the instruction into deliveries.
    pub planner: Box<dyn Planner>,
    /// Reads plates.
    pub reader: Box<dyn PlateReader>,
    /// Says where the robot is.
    pub localizer: Box<dyn Localizer>,
    /// Turns ways into velocities.
    pub motion: Box<dyn LocalPlanner>,
    /// Which ground is preferred to other.
    pub ground: Preferences,
    /// Doors found before, if any are to be remembered.
    pub memory: Option<OsmData>,
    /// Counts what planner and reader ask of models.
    pub meter: Meter,
    /// Whether the robot stands still for as long as models take to answer, as it would in life. What they take is measured by the clock on the
    /// wall, so that runs repeat with what was recorded only.
    pub thinks_in_simulated_time: bool,
}
