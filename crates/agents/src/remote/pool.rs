//! Links that episodes share one after the other.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::link::{Link, LinkError};

/// Makes a link when none is idle, no longer than the time given.
type Connect = dyn Fn(Duration) -> Result<Box<dyn Link>, LinkError> + Send + Sync;

/// Links that are idle, and what makes further ones: a process that loads a network for seconds is
/// used by many episodes.
#[derive(Clone)]
pub struct Pool {
    idle: Arc<Mutex<Vec<Box<dyn Link>>>>,
    connect: Arc<Connect>,
}

impl Pool {
    /// A pool without links.
    pub fn new(
        connect: impl Fn(Duration) -> Result<Box<dyn Link>, LinkError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            idle: Arc::default(),
            connect: Arc::new(connect),
        }
    }

    /// An idle link, or a new one that is made within this time.
    ///
    /// # Errors
    /// That of the connection.
    pub fn take(&self, within: Duration) -> Result<Box<dyn Link>, LinkError> {
        let idle = self.lock().pop();
        idle.map_or_else(|| (self.connect)(within), Ok)
    }

    /// Takes a link back that can be used again.
    pub fn give_back(&self, link: Box<dyn Link>) {
        self.lock().push(link);
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Box<dyn Link>>> {
        // A list of links is whole after each of its operations.
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
