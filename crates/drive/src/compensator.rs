//! What a compensator is: a block that runs at the servo rate (250 us).
//!
//! Its configuration is immutable and shared, its state is small, cloneable and serialisable. It
//! sees only what a drive has; [`MethodInfo::knows`] says what it needs beyond that.

use crate::learned::{Learned, Learning};
use crate::signal::{Correction, Signals};
use crate::twin::Twinned;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// What a method may know beyond the signals that every drive has (motor encoder, current,
/// references, motor data sheet).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Knowledge {
    /// It measures the load (a linear scale or a second encoder).
    pub load_scale: bool,
    /// It is told the gap.
    pub gap: bool,
    /// It is told the load's inertia and friction.
    pub load: bool,
}

/// What every compensator declares about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodInfo {
    /// Name on the command line and in files.
    pub name: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// What it may know.
    pub knows: Knowledge,
    /// Where the method comes from.
    pub source: &'static str,
}

impl MethodInfo {
    /// That of a compensator whose name is known at run time only; it lives as long as the process,
    /// one for each different content.
    pub fn kept(name: &str, summary: &'static str, knows: Knowledge) -> &'static MethodInfo {
        static KEPT: Mutex<Vec<&'static MethodInfo>> = Mutex::new(Vec::new());
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |info: &&&MethodInfo| {
            info.name == name && info.summary == summary && info.knows == knows
        };
        if let Some(info) = kept.iter().find(same) {
            return info;
        }
        let info: &'static MethodInfo = Box::leak(Box::new(MethodInfo {
            name: Box::leak(name.to_owned().into_boxed_str()),
            summary,
            knows,
            source: "the caller",
        }));
        kept.push(info);
        info
    }
}

/// How far a compensator may correct beside what it knows itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heeded {
    /// What the control allows, 0 (nothing) to 1 (all of it).
    pub allowed: f64,
    /// Whether it waits for something, and lets none correct but who rests aside.
    pub waits: bool,
    /// Whether this axis rests while others come and go.
    pub aside: bool,
    /// The least [`Compensator::readiness`] of the machine's other axes; `None` where none of them matters now.
    pub others: Option<f64>,
}

/// A backlash compensator.
pub trait Compensator: Send + Sync + 'static {
    /// What it carries from tick to tick.
    type State: Clone + Send + Sync + Serialize + for<'de> Deserialize<'de>;

    /// Whether it answers [`Correction::NONE`] to whatever it sees, so that nobody needs to ask.
    const PASSIVE: bool = false;

    /// Whether its [`Correction::inertia_estimate`] is motor and load together, learned for good,
    /// and not what the motor carries at the moment.
    const LEARNS_LOAD: bool = false;

    /// Whether it has to be told how ready the other axes are ([`Compensator::heed`]).
    const HEEDS_OTHERS: bool = false;

    /// What it says of itself.
    fn info(&self) -> &'static MethodInfo;

    /// State before the first tick, standing still at `motor_position` rad.
    fn initial(&self, motor_position: f64) -> Self::State;

    /// Takes the memory that the state may ever need, so that no later tick allocates: told once of a
    /// state that is new, copied or read back. Nothing for a state of a fixed size.
    fn make_room(&self, _state: &mut Self::State) {}

    /// One servo tick.
    fn step(&self, state: &mut Self::State, signals: &Signals) -> Correction;

    /// What a tick does before the method's own model of the axis is stepped, and that model;
    /// nothing for a method that has none. [`Compensator::step`] is this, the model's step, and
    /// [`Compensator::finish`]; who runs many axes steps their models side by side.
    fn begin<'a>(&'a self, _state: &'a mut Self::State, _signals: &Signals) -> Option<Twinned<'a>> {
        None
    }

    /// What it has learned of its axis for good; `None` for a method that learns nothing, and while
    /// it knows nothing.
    fn learned(&self, _state: &Self::State) -> Option<Learned> {
        None
    }

    /// What it knows now, for traces; `None` for a method that learns nothing.
    fn learning(&self, _state: &Self::State) -> Option<Learning> {
        None
    }

    /// The rest of a tick that was begun.
    fn finish(&self, state: &mut Self::State, signals: &Signals) -> Correction {
        self.step(state, signals)
    }

    /// How far it compensates the axis as it is moved now, 0 (not at all) to 1 (as well as it can);
    /// `None` where the other axes of a contour need not care: it does not learn, or the axis
    /// stands, or nothing of it needs compensation.
    fn readiness(&self, _state: &Self::State) -> Option<f64> {
        None
    }

    /// Told some times a second: what the control allows, and what the machine's other axes are ready for.
    fn heed(&self, _state: &mut Self::State, _heeded: Heeded) {}

    /// Where the load would be without a correction, and with the whole of it, rad: at the first servo
    /// tick of each command cycle since the last [`Compensator::heed`], up to a bound; of cycles
    /// before it, too, once the method knows what it did not know then. The last is the newest.
    /// `None` while the method does not know; nothing where it never says.
    fn foreseen<'a>(&self, _state: &'a Self::State) -> &'a [Option<[f64; 2]>] {
        &[]
    }
}
