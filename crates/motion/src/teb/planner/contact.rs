//! Leaving near contact with an obstacle, where soft penalties are no help.

use crate::feasible::clearance;
use crate::local::{Blocked, Progress, Situation};
use crate::recovery::leave::{KEEP_M, leave};
use crate::shape::standing;
use crate::trajectory::Trajectory;

use super::{End, Planned, TOO_LATE_S, Teb};

/// A robot that is nearer to an obstacle than this leaves it before it plans on, metres,
const TOUCHING_M: f64 = 0.004;
/// until it is this far away, metres.
const FREE_M: f64 = 0.01;
/// Seconds of a motion out of near contact that need not be driven to their end.
const DONE_S: f64 = 0.03;

impl Teb {
    /// Leaves an obstacle in near contact; `None` if there is none, or no motion that leaves it.
    pub(super) fn leave_contact(
        &mut self,
        situation: &Situation<'_>,
        end: &End,
    ) -> Option<Progress> {
        self.is_touching = self.touches(situation);
        if !self.is_touching {
            self.way_out = None;
            return None;
        }
        let progress = self.drive_out(situation, end)?;
        // The bands do not begin where this motion leads.
        self.candidates.clear();
        self.hesitation.forget();
        self.last = Some(Planned {
            time: situation.time,
            end: end.point,
        });
        Some(progress)
    }

    /// Whether the robot is in near contact, or not far enough from it yet.
    fn touches(&self, situation: &Situation<'_>) -> bool {
        let standing = standing(situation.obstacles);
        let near = clearance(&self.footprint, standing, situation.pose, 0.0, FREE_M);
        near < if self.is_touching { FREE_M } else { TOUCHING_M }
    }

    /// Drives by a maneuver to the end as it was found or, where there is none, by the small motion
    /// that gains most room.
    fn drive_out(&mut self, situation: &Situation<'_>, end: &End) -> Option<Progress> {
        let elapsed = self.elapsed(situation.time);
        if let Some(band) = &mut self.way_out {
            band.keep_up(situation.pose, elapsed);
        }
        let known = self
            .way_out
            .take()
            .filter(|band| self.keeps(situation, band));
        self.way_out = known.or_else(|| self.search(situation, end));
        self.driven_out(situation).or_else(|| {
            self.way_out = leave(&self.footprint, &self.limits, situation);
            self.driven_out(situation)
        })
    }

    /// Whether a motion out of contact is still to be driven, and meets no obstacle soon.
    fn keeps(&self, situation: &Situation<'_>, band: &Trajectory) -> bool {
        let conflict = self.check(situation.obstacles, KEEP_M).first_conflict(band);
        band.duration() > DONE_S && conflict.is_none_or(|at| at > TOO_LATE_S)
    }

    /// The velocity along the motion out of contact, if it can be driven.
    fn driven_out(&self, situation: &Situation<'_>) -> Option<Progress> {
        let band = self
            .way_out
            .as_ref()
            .filter(|band| self.keeps(situation, band))?;
        let wanted = band.command(&self.limits);
        let velocity = self
            .secured(situation, wanted, Some(band))
            .ok()?
            .velocity()?;
        Some(Progress::Slowed(velocity, Blocked::Touching))
    }
}
