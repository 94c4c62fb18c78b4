//! Work on a thread of its own while Python goes on: progress is told, Ctrl-C is heard, an exception
//! of the caller's ends the work.

use crate::error::Refusal;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often Python is asked for signals. A choice: a fifth of the tenth of a second in which people
/// expect Ctrl-C to act.
const POLL: Duration = Duration::from_millis(20);

/// How far a run is.
#[pyclass(frozen, get_all, module = "lostmotion")]
pub(crate) struct Progress {
    /// Bytes of the program read so far.
    done_bytes: u64,
    /// Bytes of the program.
    total_bytes: u64,
    /// Machine time simulated so far, s.
    simulated_s: f64,
    /// Part of the program that has been read, 0 to 1.
    share: f64,
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        format!(
            "Progress(share={:.3}, simulated_s={:?})",
            self.share, self.simulated_s
        )
    }
}

/// What the work tells the caller, and the caller the work.
#[derive(Clone)]
pub(crate) struct Watch {
    shared: Arc<Shared>,
    /// Wakes the caller; full while it has not looked.
    wake: SyncSender<()>,
}

#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    /// The newest that the caller has not seen.
    progress: Mutex<Option<Progress>>,
    /// The first exception of the caller's own code.
    raised: Mutex<Option<PyErr>>,
}

/// A lock whose holder cannot have left it half done.
fn held<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watch {
    /// Of work on the caller's own thread: nobody waits.
    pub(crate) fn alone() -> Watch {
        Watch {
            shared: Arc::default(),
            wake: sync_channel(1).0,
        }
    }

    /// The exception that has ended the work, once.
    pub(crate) fn raised(&self) -> Option<PyErr> {
        held(&self.shared.raised).take()
    }

    /// Whether nobody waits for the result any more.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.shared.cancelled.load(Ordering::Relaxed)
    }

    /// Tells how far the work is; breaks where nobody waits any more.
    pub(crate) fn progress(&self, progress: lostmotion::Progress) -> ControlFlow<()> {
        *held(&self.shared.progress) = Some(Progress {
            done_bytes: progress.done_bytes,
            total_bytes: progress.total_bytes,
            simulated_s: progress.simulated_s,
            share: progress.share(),
        });
        // A caller that has not looked yet finds the newest when it does.
        let _ = self.wake.try_send(());
        if self.is_cancelled() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Ends the work with an exception of the caller's own code; the first one counts.
    pub(crate) fn raise(&self, error: PyErr) {
        held(&self.shared.raised).get_or_insert(error);
        self.shared.cancelled.store(true, Ordering::Relaxed);
        let _ = self.wake.try_send(());
    }
}

/// Ends the work when the caller leaves, however it does.
struct Leaving(Arc<Shared>);

impl Drop for Leaving {
    fn drop(&mut self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
    }
}

/// Does work on a thread of its own. Work that is left (Ctrl-C, an exception) ends at its next
/// progress, and the caller does not wait for that.
pub(crate) fn apart<T: Send + 'static>(
    py: Python<'_>,
    on_progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T, Refusal> + Send + 'static,
) -> PyResult<T> {
    // One that is pending ends the call before it starts.
    py.check_signals()?;
    let shared = Arc::new(Shared::default());
    let _leaving = Leaving(Arc::clone(&shared));
    let (wake, woken) = sync_channel(1);
    let result = Arc::new(Mutex::new(None));
    let (watch, slot) = (
        Watch {
            shared: Arc::clone(&shared),
            wake,
        },
        Arc::clone(&result),
    );
    std::thread::Builder::new()
        .name("lostmotion".to_owned())
        .spawn(move || {
            let answer = work(&watch);
            *held(&slot) = Some(answer);
            // The caller is woken by the sender that goes with the watch.
        })
        .map_err(|error| {
            Refusal::new(
                "Error",
                "threads",
                format!("cannot start a thread: {error}"),
                "",
            )
        })?;
    let woken = Mutex::new(woken);
    loop {
        let ended = py.detach(|| waited(&held(&woken)));
        let raised = held(&shared.raised).take();
        if let Some(error) = raised {
            return Err(error);
        }
        // Out of the lock before the callback: the work does not wait for it.
        let progress = held(&shared.progress).take();
        if let (Some(progress), Some(tell)) = (progress, on_progress) {
            let answer = tell.call1((progress,))?;
            // `False` alone ends a run: callbacks that answer nothing, or a number, go on.
            // numpy's `False` is one, too.
            if matches!(answer.extract::<bool>(), Ok(false)) {
                return Err(
                    Refusal::new("Cancelled", "cancelled", "the run was cancelled", "").into(),
                );
            }
        }
        if ended {
            let answer = held(&result).take();
            return match answer {
                Some(answer) => answer.map_err(|refusal| refusal.raised(py)),
                None => Err(Refusal::new(
                    "Error",
                    "internal",
                    "the work ended without a result",
                    "please report this",
                )
                .into()),
            };
        }
        py.check_signals()?;
    }
}

/// Waits for a word, for at most [`POLL`]; whether the work has ended.
fn waited(woken: &Receiver<()>) -> bool {
    matches!(
        woken.recv_timeout(POLL),
        Err(RecvTimeoutError::Disconnected)
    )
}
