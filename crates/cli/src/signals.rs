//! SIGINT and SIGTERM end a run in order.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Whether the process was asked to stop, and by which signal. A second signal ends it at once.
pub struct StopSignal {
    asked: Arc<AtomicBool>,
    signal: Arc<AtomicUsize>,
}

impl StopSignal {
    /// Catches both signals from now on.
    ///
    /// # Errors
    /// A system that does not permit it.
    pub fn catch() -> io::Result<Self> {
        let (asked, signal) = (Arc::new(AtomicBool::new(false)), Arc::default());
        for number in [SIGINT, SIGTERM] {
            // In this order: the first signal finds the flag unset, the second one finds it set.
            flag::register_conditional_default(number, Arc::clone(&asked))?;
            flag::register(number, Arc::clone(&asked))?;
            flag::register_usize(number, Arc::clone(&signal), number as usize)?;
        }
        Ok(Self { asked, signal })
    }

    /// Set when the process was asked to stop.
    pub fn asked(&self) -> &AtomicBool {
        &self.asked
    }

    /// The number of the signal; that of SIGINT if there was none.
    pub fn number(&self) -> u8 {
        // Relaxed suffices: the handlers ran before the run ended.
        let number = self.signal.load(Ordering::Relaxed);
        u8::try_from(number)
            .ok()
            .filter(|n| *n > 0)
            .unwrap_or(SIGINT as u8)
    }
}
