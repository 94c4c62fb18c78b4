//! Backlash compensators: one file each, one line in the registry.
//!
//! What a compensator is stands in [`lostmotion_drive::compensator`]; [`MethodId`] names a
//! registered one, [`build_runner`] makes an axis with it, [`run_with`] one with a compensator of
//! your own.
//!
//! ```
//! use lostmotion_methods::{AxisConfig, AxisOutput, MethodId, Setpoint, build_runner};
//!
//! let method: MethodId = "published".parse()?;
//! let mut axis = build_runner(&AxisConfig::paper(), method, 0.0)?;
//! let mut out = AxisOutput::new(false);
//! let slow = |n: u32| Setpoint::moving(1e-3 * f64::from(n), 1.0, 0.0);
//! for n in 0..100 {
//!     out.clear();
//!     axis.push(&[slow(n)], &mut out)?;
//!     assert_eq!(out.load.len(), 4);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Adding a compensator
#![doc = include_str!("../docs/adding.md")]

mod crossing;
mod filter;
mod memory;
mod passage;
mod readings;
pub mod registry;
pub mod shaft;
mod strokes;
mod told;
mod traverse;

pub use adaptive::LONG_REST_S;
pub use lostmotion_drive::{AxisOutput, AxisStart, Setpoint};
pub use memory::{AxisMemory, LearnedOn};
pub use registry::{
    Method, MethodId, Registered, Settings, UnknownMethod, alone, build_misled, build_runner,
    build_runner_from, run_with,
};
pub use shaft::{Observed, ShaftEstimate, ShaftEstimator, ShaftState};
pub use told::{Misled, Told, USUAL_SHARE};

use lostmotion_drive::config::check::AxisConfigError;
use lostmotion_drive::config::{CompensatorSettings, Gap, Transmission};
use serde::{Deserialize, Serialize};

/// The description of an axis, with the settings of every registered method.
pub type AxisConfig = lostmotion_drive::AxisConfig<CompensationConfig>;

/// Makes, from one line a file, the module, the rows of [`METHODS`] and the table of settings:
/// `file(its settings): its compensators;`.
macro_rules! methods {
    ($($file:ident $(($settings:ident))?: $($compensator:ident),+;)*) => {
        $(pub mod $file;)*

        /// Every registered method.
        pub static METHODS: &[Method] = &[
            $($(Method::of::<$file::$compensator>(stringify!($file)),)+)*
        ];

        /// The names of [`METHODS`].
        static NAMES: &[&str] = &[
            $($(<$file::$compensator as Registered>::INFO.name,)+)*
        ];

        /// The keys of the tables of settings.
        static SETTINGS: &[&str] = &[
            $($({ let _: Option<$file::$settings> = None; stringify!($file) },)?)*
        ];

        /// The compensator of an axis: which method it uses by itself, and the settings of each
        /// method.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct CompensationConfig {
            /// The method that the axis uses unless a run names another for all axes.
            pub method: MethodId,
            /// Whether the drive estimates stiffness and damping of its shaft while it runs,
            /// whatever the method; it changes nothing but traces.
            #[serde(skip_serializing_if = "is_default")]
            pub estimate_shaft: bool,
            /// How far off a gap that a method is told may be, as a part of it, below 1. A method
            /// that is told too much moves the tool beyond where it left it, one that is told too
            /// little leaves some of the gap; so methods take the least that the gap may be.
            #[serde(skip_serializing_if = "is_default")]
            pub gap_uncertainty: f64,
            /// What a method that learns starts from; not in machine files.
            #[serde(skip)]
            pub learned: Option<AxisMemory>,
            $($(
                #[doc = concat!("Settings of the methods of `", stringify!($file), "`.")]
                #[serde(skip_serializing_if = "is_default")]
                pub $file: $file::$settings,
            )?)*
        }

        impl CompensationConfig {
            /// Tells a total gap (a fit's result) to every method that may know it: `fixed`,
            /// `fixed-linuxcnc`, `fixed-fanuc` for cutting, `lookup`, `fitted-lookup`.
            pub fn tell_gap(&mut self, gap: Gap) {
                $($({
                    let _: Option<$file::$settings> = None;
                    if let Some(told) = Settings::gaps(&mut self.$file).into_iter().next() {
                        *told = Some(gap);
                    }
                })?)*
            }

            /// As [`CompensationConfig::tell_gap`], of those methods alone that are told none yet.
            pub fn tell_missing_gap(&mut self, gap: Gap) {
                $($({
                    let _: Option<$file::$settings> = None;
                    if let Some(told) = Settings::gaps(&mut self.$file).into_iter().next() {
                        told.get_or_insert(gap);
                    }
                })?)*
            }

            /// Every gap that a method is told, times a factor. Methods that are told none by
            /// their settings take the description's.
            fn scale_gaps(&mut self, factor: f64) {
                $($({
                    let _: Option<$file::$settings> = None;
                    for told in Settings::gaps(&mut self.$file) {
                        *told = told.map(|gap| gap.times(factor));
                    }
                })?)*
            }
        }

        impl CompensatorSettings for CompensationConfig {
            /// Checks the settings of every method, whichever is used.
            fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
                if !(0.0..1.0).contains(&self.gap_uncertainty) {
                    return Err(AxisConfigError::Range {
                        key: "gap_uncertainty".to_owned(),
                        value: self.gap_uncertainty,
                        allowed: "0 (the gap is known) or more, and below 1".to_owned(),
                    });
                }
                $($(<$file::$settings as Settings>::check(&self.$file, transmission)
                    .map_err(|error| error.within(stringify!($file)))?;)?)*
                Ok(())
            }
        }
    };
}

methods! {
    none: Uncompensated;
    fixed(FixedSettings): Fixed;
    published(PublishedSettings): UsualGain, GainAsPrinted;
    load_feedback: LoadFeedback;
    reversal_pulse(ReversalPulseSettings): ReversalPulse;
    lookup(LookupSettings): Lookup;
    fixed_linuxcnc(FixedLinuxcncSettings): FixedLinuxcnc;
    fixed_fanuc(FixedFanucSettings): FixedFanuc;
    adaptive_inverse(AdaptiveInverseSettings): AdaptiveInverse;
    disturbance_observer(DisturbanceObserverSettings): DisturbanceObserver;
    kalman(KalmanSettings): Kalman;
    multiple_models(MultipleModelsSettings): MultipleModels;
    iterative_learning(IterativeLearningSettings): IterativeLearning;
    fitted_lookup(FittedLookupSettings): FittedLookup;
    adaptive(AdaptiveSettings): Adaptive;
    actual_value(ActualValueSettings): ActualValue;
    fixed_isg(FixedIsgSettings): FixedIsg;
    fixed_by_travel(FixedByTravelSettings): FixedByTravel;
    fixed_mach3(FixedMach3Settings): FixedMach3;
    fixed_mitsubishi(FixedMitsubishiSettings): FixedMitsubishi;
    decaying_pulse(DecayingPulseSettings): DecayingPulse;
    friction_torque(FrictionTorqueSettings): FrictionTorque;
}

impl MethodId {
    /// No compensation: the baseline of every comparison.
    pub const NONE: MethodId = MethodId::at(position("none"));

    /// The method that learns all it needs from the motor alone.
    pub const ADAPTIVE: MethodId = MethodId::at(position("adaptive"));

    /// The method that is told everything: the benchmark of the methods on the motor.
    pub const LOOKUP: MethodId = MethodId::at(position("lookup"));

    /// The paper's method with the usual gain of the least squares.
    pub const PUBLISHED: MethodId = MethodId::at(position("published"));

    /// The paper's method with the gain as printed.
    pub const PUBLISHED_LITERAL: MethodId = MethodId::at(position("published-literal"));
}

/// Row of a name in [`METHODS`]; a name that is in none does not compile, since the row is then
/// beyond the end.
const fn position(name: &str) -> usize {
    // constant functions know no iterators
    let mut row = 0;
    while row < NAMES.len() {
        if same(NAMES[row].as_bytes(), name.as_bytes()) {
            return row;
        }
        row += 1;
    }
    row
}

/// Equality of bytes, which `==` is not in a constant.
const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}

fn is_default<T: Default + PartialEq>(settings: &T) -> bool {
    *settings == T::default()
}
