//! The path to a goal, searched again when it is old or blocked.

use std::time::Duration;

use openbench_core::{MapPoint, SimTime};

use crate::astar::PlanError;
use crate::surroundings::Surroundings;

/// A path is searched again after this long, since more has been seen.
const REPLAN: Duration = Duration::from_millis(2500);
/// A path is not searched again more often than this.
const REPLAN_EARLIEST: Duration = Duration::from_millis(300);

/// Finds paths over the ground.
pub trait Guide {
    /// The path from one place to another, both included; where one of them is blocked, from or to
    /// the nearest place that is not.
    fn path(&mut self, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError>;

    /// Whether the next metres of a path are known to be blocked by now.
    fn is_blocked(&self, path: &[MapPoint], from: MapPoint) -> bool;
}

/// The path that is followed.
#[derive(Debug, Clone, Default)]
pub(crate) struct Route {
    path: Vec<MapPoint>,
    /// When the path was last searched.
    searched: Option<SimTime>,
    /// Why the last search found none, if it did not.
    failure: Option<PlanError>,
}

impl Route {
    /// The path; empty if none was found yet.
    pub(crate) fn path(&self) -> &[MapPoint] {
        &self.path
    }

    /// Searches the path to `goal` again if it is old or blocked. The error of a search stands
    /// until the next one.
    pub(crate) fn refresh(
        &mut self,
        now: &Surroundings<'_>,
        goal: MapPoint,
        guide: &mut dyn Guide,
    ) -> Result<(), PlanError> {
        if self.is_stale(now, guide) {
            self.searched = Some(now.time);
            let found = guide.path(now.pose.point(), goal);
            self.failure = found.as_ref().err().copied();
            // An old path is not followed once a search has failed.
            self.path = found.unwrap_or_default();
        }
        self.failure.map_or(Ok(()), Err)
    }

    fn is_stale(&self, now: &Surroundings<'_>, guide: &dyn Guide) -> bool {
        let Some(searched) = self.searched else {
            return true;
        };
        let age = now.time.since(searched);
        if age >= REPLAN {
            return true;
        }
        age >= REPLAN_EARLIEST
            && (self.path.is_empty() || guide.is_blocked(&self.path, now.pose.point()))
    }

    /// Has the path searched again by the next refresh, however new it is.
    pub(crate) fn expire(&mut self) {
        self.searched = None;
    }
}
