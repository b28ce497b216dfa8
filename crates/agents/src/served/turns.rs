//! Whose turn it is with a server that serves one robot at a time.

use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// Turns with one server. Clones are of the same server.
#[derive(Debug, Clone, Default)]
pub struct Turns(Arc<(Mutex<bool>, Condvar)>);

/// A turn, which ends when it is dropped.
#[derive(Debug)]
pub struct Turn(Turns);

impl Turns {
    /// Waits for the end of the turn of another episode.
    pub fn wait(&self) -> Turn {
        let (is_taken, ended) = &*self.0;
        let guard = is_taken.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = ended.wait_while(guard, |is_taken| *is_taken);
        *waited.unwrap_or_else(PoisonError::into_inner) = true;
        Turn(self.clone())
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        let (is_taken, ended) = &*self.0.0;
        *is_taken.lock().unwrap_or_else(PoisonError::into_inner) = false;
        ended.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn one_turn_follows_the_other() {
        let turns = Turns::default();
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..50 {
                        let _turn = turns.wait();
                        let others = now.fetch_add(1, Ordering::SeqCst);
                        most.fetch_max(others + 1, Ordering::SeqCst);
                        std::thread::yield_now();
                        now.fetch_sub(1, Ordering::SeqCst);
                    }
                });
            }
        });
        assert_eq!(most.into_inner(), 1);
    }
}
