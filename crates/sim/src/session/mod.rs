//! The session: a machine in all its variants, stepped through a plan and judged.
//!
//! ```text
//! cutting  samples -> forces on the loads                          (cutting.rs)
//! variant  the machine with a compensator, or without a gap         (variant.rs)
//! lane     each drive of each variant at the start, and who is stepped with whom   (lane.rs)
//! bank     samples -> load positions, every axis, every variant    (bank.rs, outputs.rs)
//! crew     variants whose axes are stepped together                (crew.rs)
//! guard    what drives foresee -> whether they may correct        (guard.rs)
//! skips    where a correction would make the contour worse, to be left out        (skips.rs)
//! rehearsal the start of the program with what drives have learned -> how far they may correct (rehearsal.rs)
//! contours two contours of one motion, side by side               (contours.rs)
//! frame    servo ticks paired with the commands they answer to     (frame.rs)
//! ahead    program -> chunks of the plan, ahead of the axes        (ahead.rs)
//! stepper  chunk by chunk: plan, forces, axes, ticks               (stepper.rs)
//! monitor  following error, travel, overload: where the machine stops (monitor.rs)
//! references contour errors that methods are held against    (references.rs)
//! recorder load positions -> contour errors, added up              (recorder.rs)
//! run      the loop: step, judge, report                           (run.rs)
//! collect  sums -> results                                         (collect.rs, rows.rs)
//! advice   results -> the method to use                            (advice.rs)
//! ```

mod advice;
mod ahead;
mod bank;
mod collect;
mod contours;
mod crew;
mod cutting;
mod frame;
mod guard;
mod lane;
mod monitor;
mod outputs;
mod recorder;
mod references;
mod rehearsal;
mod rows;
mod run;
mod skips;
mod stepper;
mod variant;

pub(crate) use advice::{unsafe_but_for_gap, worse};
pub(crate) use ahead::Ahead;
pub(crate) use collect::unseen_gaps;
pub use frame::Frame;
pub(crate) use guard::Rehearsals;
pub use lane::SETTLE_S;
pub(crate) use outputs::Kept;
pub(crate) use rehearsal::Rehearser;
pub(crate) use stepper::Stepper;
pub use stepper::{TickSink, Ticks};
pub(crate) use variant::Variant;

use crate::error::SimError;
use crate::method::Choice;
use crate::motion::Checked;
use crate::observer::Audience;
use crate::results::Run;
use crate::setup::Setup;

/// Plans and simulates a checked program with every method and judges each.
pub(crate) fn run(
    setup: &Setup<'_>,
    choices: &[Choice],
    checked: Checked,
    audience: &mut Audience<'_>,
) -> Result<Run, SimError> {
    let share = setup.options.misled_share;
    let remembers = setup.options.learned.is_some();
    let misled = advice::misled_runs(choices, share, remembers);
    let files = checked.files.clone();
    let tally = run::run(setup, choices, &misled, &files, audience)?;
    let mut answer = collect::answer(setup, choices, checked, &tally);
    // One run of many axes at a time.
    drop(tally);
    // What is best where all is told right, and not safe where something is told wrong, runs once
    // more with less and less wrong.
    let refused = |choice: &Choice| advice::refusal(setup, choice);
    if let Some(doubt) = advice::doubt(&answer, choices, refused, share) {
        let choice = std::slice::from_ref(&choices[doubt.method]);
        // Rows and points were reported in the first run; the second can still be cancelled.
        let mut audience = Audience {
            observer: None,
            on_progress: audience.on_progress.take(),
        };
        let tally = run::run(setup, choice, &doubt.runs(), &files, &mut audience)?;
        answer.trust = Some(doubt.answer(&answer, choices, &collect::misled(&tally, 1)));
    }
    Ok(answer)
}
