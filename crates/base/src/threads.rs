//! The only place of the library that knows threads. Without the feature `threads` the same work is done
//! in its order on the caller's thread, and the results are the same to the bit.

#[cfg(feature = "threads")]
use rayon::prelude::*;

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

/// Does a piece of work that waits in the pool in force ([`pool`]), if there is one; the answer is whether there
/// was.
pub fn help() -> bool {
    #[cfg(feature = "threads")]
    return rayon::yield_now() == Some(rayon::Yield::Executed);
    #[cfg(not(feature = "threads"))]
    false
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
