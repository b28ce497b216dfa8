//! Numbered jobs on several threads; the outcome does not depend on the number of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

/// Runs `work` for each number on several threads.
///
/// `collect` receives each outcome on the calling thread, in the order of completion. Its outputs
/// are returned in the order of the numbers.
///
/// # Errors
/// The error of the lowest number that fails. After an error no further number is started. Numbers
/// are started in ascending order, so the returned error does not depend on the number of threads.
pub fn each<T, U, W, E>(
    numbers: Range<usize>,
    threads: usize,
    work: impl Fn(usize) -> Result<T, W> + Sync,
    mut collect: impl FnMut(T) -> Result<U, E>,
) -> Result<Vec<U>, E>
where
    T: Send,
    W: Send,
    E: From<W>,
{
    let (next, ends) = (AtomicUsize::new(numbers.start), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    let mut done: Vec<(usize, Result<U, E>)> = std::thread::scope(|scope| {
        // `clamp` panics if its bounds cross, so the upper one is 1 where there are no numbers.
        for _ in 0..threads.clamp(1, numbers.len().max(1)) {
            let (sender, work, next, ends) = (sender.clone(), &work, &next, &ends);
            scope.spawn(move || {
                while !ends.load(Ordering::Relaxed) {
                    // Relaxed suffices: each number is taken once, and no other memory depends on
                    // it.
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= numbers.end {
                        break;
                    }
                    let outcome = work(number);
                    // Relaxed suffices: the channel synchronizes the outcomes themselves.
                    ends.fetch_or(outcome.is_err(), Ordering::Relaxed);
                    // The receiver is gone if `collect` panicked.
                    if sender.send((number, outcome)).is_err() {
                        break;
                    }
                }
            });
        }
        // The receiver ends when the last sender is dropped.
        drop(sender);
        let see = |(number, outcome): (usize, Result<T, W>)| {
            let outcome = outcome.map_err(E::from).and_then(&mut collect);
            ends.fetch_or(outcome.is_err(), Ordering::Relaxed);
            (number, outcome)
        };
        receiver.into_iter().map(see).collect()
    });
    // All numbers below a failed one were started, and each started one has an outcome here. The
    // first error in this order is therefore that of the lowest failing number.
    done.sort_by_key(|(number, _)| *number);
    done.into_iter().map(|(_, outcome)| outcome).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_in_order_on_any_number_of_threads() {
        for threads in [0, 1, 3, 99] {
            let mut sum = 0;
            let seen = |square: usize| {
                sum += square;
                Ok::<_, ()>(square + 1)
            };
            let squares = each(3..40, threads, |n| Ok::<_, ()>(n * n), seen);
            assert_eq!(
                squares,
                Ok((3..40).map(|n| n * n + 1).collect::<Vec<_>>()),
                "{threads}"
            );
            assert_eq!(sum, (3..40).map(|n| n * n).sum::<usize>());
        }
        assert_eq!(each(5..5, 2, Ok::<_, ()>, Ok::<_, ()>), Ok(vec![]));
    }

    #[test]
    fn the_error_of_the_lowest_number_is_returned_and_stops_the_work() {
        for threads in [1, 4] {
            let begun = AtomicUsize::new(0);
            let work = |n: usize| {
                begun.fetch_add(1, Ordering::Relaxed);
                if n == 7 || n == 8 { Err(n) } else { Ok(n) }
            };
            assert_eq!(
                each(0..100_000, threads, work, Ok::<_, usize>),
                Err(7),
                "{threads}"
            );
            assert!(begun.load(Ordering::Relaxed) < 100_000);
            let seen = |n: usize| if n < 3 { Ok(n) } else { Err(n) };
            assert_eq!(each(0..50, threads, Ok::<_, usize>, seen), Err(3));
        }
    }
}
