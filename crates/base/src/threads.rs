//! The only place of the library that knows threads. Without the feature `threads` the same work is done
//! in its order on the caller's thread, and the results are the same to the bit.

#[cfg(feature = "threads")]
use rayon::prelude::*;
#[cfg(feature = "threads")]
use std::sync::PoisonError;
use std::sync::{Condvar, Mutex, MutexGuard};

/// What `work` makes of each item, in their order: on the caller's thread for one thread, else on those of
/// the pool in force ([`pool`]).
#[cfg_attr(
    not(feature = "threads"),
    allow(unused_variables, reason = "one thread")
)]
pub fn map<T: Send, R: Send>(
    threads: usize,
    items: impl ExactSizeIterator<Item = T>,
    work: impl Fn(T) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "threads")]
    if threads > 1 {
        let items: Vec<T> = items.collect();
        return items.into_par_iter().map(work).collect();
    }
    items.map(work).collect()
}

/// Two pieces of work that share nothing: one after the other on the caller's thread for one thread, else an
/// idle one of the pool in force ([`pool`]) may take the second.
#[cfg_attr(
    not(feature = "threads"),
    allow(unused_variables, reason = "one thread")
)]
pub fn join<A: Send, B: Send>(
    threads: usize,
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "threads")]
    if threads > 1 {
        return rayon::join(first, second);
    }
    (first(), second())
}

/// Work that an idle thread of the pool in force ([`pool`]) takes at some time; without the feature it is done
/// at once.
pub fn spawn(work: impl FnOnce() + Send + 'static) {
    #[cfg(feature = "threads")]
    rayon::spawn(work);
    #[cfg(not(feature = "threads"))]
    work();
}

/// Waits for something of another thread, but for a moment only: lets go of what a mutex holds, does a piece of work
/// that waits in the pool in force ([`pool`]) if there is one, and else waits for news unless it is there already.
/// A worker of the pool that only waited would take one of its threads away from the others.
#[cfg_attr(
    not(feature = "threads"),
    allow(unused_variables, reason = "one thread")
)]
pub fn help_or_wait<'a, T>(
    of: &'a Mutex<T>,
    held: MutexGuard<'a, T>,
    news: &Condvar,
    is_there: impl Fn(&T) -> bool,
) -> MutexGuard<'a, T> {
    #[cfg(feature = "threads")]
    {
        // A choice: a thousandth of what bursts of planning take.
        const LOOK_AGAIN: std::time::Duration = std::time::Duration::from_micros(50);
        drop(held);
        let helped = rayon::yield_now() == Some(rayon::Yield::Executed);
        let held = of.lock().unwrap_or_else(PoisonError::into_inner);
        if helped || is_there(&held) {
            return held;
        }
        let waited = news.wait_timeout(held, LOOK_AGAIN);
        waited.unwrap_or_else(PoisonError::into_inner).0
    }
    #[cfg(not(feature = "threads"))]
    held
}

/// Calls `work` inside a pool of its own with so many threads (0: one per core), and with their number; without the
/// feature on the caller's thread, with 1.
///
/// # Errors
/// Why there is no pool.
#[cfg_attr(
    not(feature = "threads"),
    allow(unused_variables, reason = "one thread")
)]
pub fn pool<T: Send>(threads: usize, work: impl FnOnce(usize) -> T + Send) -> Result<T, String> {
    #[cfg(feature = "threads")]
    {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|why| why.to_string())?;
        let inside = || pool.install(|| work(pool.current_num_threads()));
        if rayon::current_thread_index().is_none() {
            return Ok(inside());
        }
        // A worker of another pool that waits for this one runs further jobs of its own pool on top of
        // its stack, each of which may do the same. A plain thread in between only waits.
        std::thread::scope(|scope| match scope.spawn(inside).join() {
            Ok(result) => Ok(result),
            Err(panic) => std::panic::resume_unwind(panic),
        })
    }
    #[cfg(not(feature = "threads"))]
    Ok(work(1))
}
