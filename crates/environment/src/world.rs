//! A suite ready for many environments.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use openbench_bench::suite::{Condition, GoalKind};
use openbench_bench::{Prepared, Suite};

use crate::error::EnvironmentError;
use crate::options::Options;
use crate::progress::WayField;

/// A suite with its world, shared by any number of environments.
#[derive(Clone)]
pub struct World {
    shared: Arc<Shared>,
}

struct Shared {
    prepared: Prepared,
    /// The way fields that were needed so far, by door.
    fields: Mutex<BTreeMap<usize, Arc<WayField>>>,
}

impl World {
    /// Builds the world of a suite. Where the goal is a point, or episodes have a start of their
    /// own, those with several deliveries are left out.
    ///
    /// # Errors
    /// [`EnvironmentError::Bench`] of a world that cannot be built;
    /// [`EnvironmentError::Option`] of a suite in which no episode is left, or that charges for
    /// computing.
    pub fn new(mut suite: Suite, options: &Options) -> Result<Self, EnvironmentError> {
        suite.goal = options.goal;
        if options.goal == GoalKind::Point || options.start.is_some() {
            suite
                .episodes
                .retain(|episode| episode.deliveries.len() == 1);
        }
        if suite.episodes.is_empty() {
            return Err(EnvironmentError::Option {
                option: "suite",
                problem: format!("{} has no episode with one delivery", suite.name),
            });
        }
        if !suite.conditions.compute.is_off() {
            return Err(EnvironmentError::Option {
                option: "conditions",
                problem: "a learner does not say what it computes and is not charged; write \
                          compute = free"
                    .to_owned(),
            });
        }
        Ok(Self {
            shared: Arc::new(Shared {
                prepared: Prepared::new(suite, None)?,
                fields: Mutex::default(),
            }),
        })
    }

    /// The suite.
    pub fn prepared(&self) -> &Prepared {
        &self.shared.prepared
    }

    /// How far it is from anywhere to the place before a door; `None` if that cannot be reached.
    pub fn way_field(&self, door: usize) -> Option<Arc<WayField>> {
        let goal = self.prepared().approach[door]?;
        let fields = &self.shared.fields;
        // A map of finished fields is whole after each of its operations.
        let mut fields = fields.lock().unwrap_or_else(PoisonError::into_inner);
        let field = fields
            .entry(door)
            .or_insert_with(|| Arc::new(WayField::new(&self.prepared().free_space, goal)));
        Some(Arc::clone(field))
    }
}
