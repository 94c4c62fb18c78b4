//! Looking on while a run goes.

use crate::error::SimError;
use crate::limiter::Limiter;
use crate::results::{BlockResult, ReversalResult};
use lostmotion_base::{AxisId, BlockRef};
use lostmotion_drive::config::AxisUnit;
use lostmotion_drive::{Engagement, Learning};
use std::ops::ControlFlow;

/// One servo tick of the contour as a machine cut it.
///
/// Places are from the program's zero that was in force for [`Self::block`], on which the foot point
/// lies: so `actual_mm` is `error_um` away from `foot_mm` where a program changes its zero, too.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContourPoint {
    /// Time, s.
    pub time_s: f64,
    /// Foot point on the programmed path from the program's zero, mm.
    pub foot_mm: [f64; 3],
    /// Unit vector to the left of travel in the plane in force.
    pub normal: [f64; 3],
    /// Contour error, signed, um.
    pub error_um: f64,
    /// What backlash adds to it, um: the length of a vector across the path, with the sign of the
    /// side to which it moves the error. It is at most how far the gaps move the tool, but can be
    /// more than its part of the error.
    pub backlash_um: f64,
    /// Commanded tip, mm.
    pub commanded_mm: [f64; 3],
    /// Actual tip, mm.
    pub actual_mm: [f64; 3],
    /// Unit vector along the commanded tool, from its tip to the spindle: in the part's directions
    /// under control of the tool's centre point, in the machine's without it, as the places are.
    pub tool: [f64; 3],
    /// Whether any joint is commanded to move; the others are not judged.
    pub moving: bool,
    /// Whether the tool is on a G0 move.
    pub rapid: bool,
    /// What keeps the commanded motion from going faster; `None` at the first command, and unless
    /// [`Observer::wants_limiters`].
    pub limiter: Option<Limiter>,
    /// The block.
    pub block: BlockRef,
}

/// One motor of an axis at one servo tick, in the unit of its description (mm, deg or rad).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MotorPoint {
    /// Time, s.
    pub time_s: f64,
    /// The axis.
    pub axis: AxisId,
    /// Whether it is the second motor of a gantry.
    pub second: bool,
    /// Unit of the positions.
    pub unit: AxisUnit,
    /// Reference of the servo, which is behind the command by the interpolator's delay.
    pub reference: f64,
    /// Motor position, at the load's side of the transmission.
    pub motor: f64,
    /// Load position.
    pub load: f64,
    /// Torque-forming current, A.
    pub current_a: f64,
    /// Motor torque, N m.
    pub torque_nm: f64,
    /// Which flank of the gap is in contact.
    pub engagement: Engagement,
}

/// The contours that the control foresees from what the drives of a method have learned: without a
/// correction and with it. See [`Observer::foreseen`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ForeseenContour {
    /// Whether the control lets the drives correct.
    pub corrects: bool,
    /// Whether an axis that comes back and is not known holds the others back.
    pub waits: bool,
    /// Time that was measured, s.
    pub measured_s: f64,
    /// RMS of the contour error over that time, um.
    pub rms_um: [f64; 2],
    /// Its largest magnitude, um.
    pub max_um: [f64; 2],
}

/// How far a run is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Bytes of the program read so far.
    pub done_bytes: u64,
    /// Bytes of the program.
    pub total_bytes: u64,
    /// Machine time simulated so far, s.
    pub simulated_s: f64,
}

impl Progress {
    /// Part of the program that has been read, 0 to 1.
    pub fn share(&self) -> f64 {
        self.done_bytes as f64 / self.total_bytes.max(1) as f64
    }
}

/// Takes rows as they are finished, so that memory does not grow with the program. Every method
/// does nothing unless overridden.
///
/// `method` is the index in the list of methods compared; 0 if there is one. Rows come in a fixed
/// order, whatever the number of threads.
///
/// ```
/// use lostmotion_sim::results::ReversalResult;
/// use lostmotion_sim::{Machine, Observer, Program, Simulation};
///
/// #[derive(Default)]
/// struct Reversals(usize);
///
/// impl Observer for Reversals {
///     fn reversals(&mut self, _method: usize, rows: &[ReversalResult]) {
///         self.0 += rows.len();
///     }
/// }
///
/// let program = Program::from_str("zigzag.ngc", "G21 G90 G61\nG1 X9 F900\nG1 X0\nG1 X9\nM2\n");
/// let machine = Machine::preset("bench3")?;
/// let mut reversals = Reversals::default();
/// Simulation::new(&program, &machine).observer(&mut reversals).run()?;
/// assert_eq!(reversals.0, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Observer: Send {
    /// How far the run is, once a chunk of the plan. [`ControlFlow::Break`] ends the run with
    /// [`SimError::Cancelled`].
    fn progress(&mut self, _progress: Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Finished blocks.
    fn blocks(&mut self, _method: usize, _rows: &[BlockResult]) {}

    /// Finished reversals.
    fn reversals(&mut self, _method: usize, _rows: &[ReversalResult]) {}

    /// Points of all servo ticks. Only called if [`Observer::wants_contour`].
    fn contour(&mut self, _method: usize, _points: &[ContourPoint]) {}

    /// Whether contour points are wanted; making them costs time.
    fn wants_contour(&self) -> bool {
        false
    }

    /// Whether points are to say what limits the motion; finding it costs time.
    fn wants_limiters(&self) -> bool {
        false
    }

    /// Signals of all motors at all servo ticks: for each tick the motors of the axes in their
    /// order, then the second motor of a gantry. Only called if [`Observer::wants_motors`].
    fn motors(&mut self, _method: usize, _points: &[MotorPoint]) {}

    /// Whether the signals of the motors are wanted; keeping them costs time.
    fn wants_motors(&self) -> bool {
        false
    }

    /// What the drives of a method know at the end of a chunk of the plan, in the order of
    /// [`Machine::drives`](crate::Machine::drives); `None` for a method that learns nothing. Only
    /// called if [`Observer::wants_learning`].
    fn learning(&mut self, _method: usize, _time_s: f64, _drives: &[Option<Learning>]) {}

    /// What the control foresees of a method at the end of a chunk of the plan; `None` for a method
    /// that corrects without asking. Only called if [`Observer::wants_learning`].
    fn foreseen(&mut self, _method: usize, _time_s: f64, _contour: Option<&ForeseenContour>) {}

    /// Whether what methods learn is wanted.
    fn wants_learning(&self) -> bool {
        false
    }
}

/// A function that is told the progress and says whether to go on.
pub(crate) type OnProgress<'a> = Box<dyn FnMut(Progress) -> ControlFlow<()> + Send + 'a>;

/// Everyone who looks on.
#[derive(Default)]
pub(crate) struct Audience<'a> {
    pub(crate) observer: Option<&'a mut dyn Observer>,
    pub(crate) on_progress: Option<OnProgress<'a>>,
}

impl Audience<'_> {
    /// Tells the progress.
    ///
    /// # Errors
    /// [`SimError::Cancelled`] if one of them has had enough.
    pub(crate) fn progress(&mut self, progress: Progress) -> Result<(), SimError> {
        let observed = self
            .observer
            .as_mut()
            .map_or(ControlFlow::Continue(()), |observer| {
                observer.progress(progress)
            });
        // Both are told, even where the first one ends the run.
        let told = self
            .on_progress
            .as_mut()
            .map_or(ControlFlow::Continue(()), |tell| tell(progress));
        if observed.is_break() || told.is_break() {
            return Err(SimError::Cancelled);
        }
        Ok(())
    }

    /// Whether contour points are wanted.
    pub(crate) fn wants_contour(&self) -> bool {
        self.observer
            .as_ref()
            .is_some_and(|observer| observer.wants_contour())
    }

    /// Whether what limits the motion is wanted.
    pub(crate) fn wants_limiters(&self) -> bool {
        self.observer
            .as_ref()
            .is_some_and(|observer| observer.wants_limiters())
    }

    /// Whether the signals of the motors are wanted.
    pub(crate) fn wants_motors(&self) -> bool {
        self.observer
            .as_ref()
            .is_some_and(|observer| observer.wants_motors())
    }

    /// Whether what the drives know is wanted.
    pub(crate) fn wants_learning(&self) -> bool {
        self.observer
            .as_ref()
            .is_some_and(|observer| observer.wants_learning())
    }
}
