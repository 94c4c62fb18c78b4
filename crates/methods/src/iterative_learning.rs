//! Iterative learning for motions that repeat: what the load did wrong last time is corrected this
//! time.
//!
//! ```text
//! stroke:      from one reversal of the reference to the next, in cells of 1 ms from the instant of the reversal (found between ticks)
//! repetition:  a stroke that begins like a stored one (position within 5e-4 rad, acceleration within a fiftieth, same direction), as long as its
//!              reference stays within 5e-4 rad and 1e-4 of the travelled way of the stored one; where it leaves, another stored stroke may follow
//! error:       e(n) = theta_ref - theta_L in cell n, rad, the load read from its scale
//! learning:    u(n) <- Q (u(n) + gamma e(n + lead)), after each run of a stroke; u: the correction that was applied, rad
//! Q:           running mean over 2 m + 1 cells, three times: no phase shift
//! correction:  u at the present time within the stroke, linear between cells, blended in over 4 ms; its slope goes to the velocity
//! ```
//! P-type learning with lead and zero-phase filter. The lead stands for the delay from a change of
//! the reference to the load. A run whose error is a tenth above that of the first one drops the
//! correction and halves gamma for that stroke. |u| stays below a twentieth of a turn.
//!
//! **It needs a scale at the load** (ideal on a machine without one), and the same stroke again:
//! series of parts, circles, pockets in many passes. Repetitions are recognised from the reference
//! alone; the program marks nothing. It learns the whole error of the load, the servo's share and
//! the wind-up as well as the gap's.
//!
//! Signals: reference position, velocity and acceleration, load position (rad at the motor).
//! Settings: gamma (0 to 1), lead (ms), filter m (ms), memory (s of strokes; 45 bytes a ms with the
//! stroke under way, all taken before the first tick: 2.7 MB for 60 s). When the memory is full, the
//! stroke that was not used for the longest time is dropped; a stroke longer than the memory is not
//! learned.
//!
//! Fails: without repetition it does nothing. A load without friction bounces differently after
//! each landing, so that learning stops at what the filter lets through. A stroke that shares its
//! beginning with another one gets the wrong correction until they part.
//!
//! Source: Arimoto, Kawamura, Miyazaki, J. Robotic Systems 1 (1984); Bristow, Tharayil, Alleyne,
//! IEEE Control Syst. Mag. 26 (2006). The recognition of strokes is this project's.

use crate::AxisConfig;
use crate::registry::{Registered, Settings};
use crate::strokes::{Beginning, Law, Run, Strokes};
use crate::traverse::direction;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Settings of `iterative-learning`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IterativeLearningSettings {
    /// Part of the error that a repetition corrects, 0 to 1.
    pub rate: f64,
    /// How far ahead of the error its correction comes, ms.
    pub lead_ms: f64,
    /// Half the width of the filter's running mean, whole ms.
    pub filter_ms: f64,
    /// Strokes that are stored, s of motion.
    pub memory_s: f64,
}

impl Default for IterativeLearningSettings {
    fn default() -> IterativeLearningSettings {
        IterativeLearningSettings {
            rate: 0.5,
            lead_ms: 4.0,
            filter_ms: 2.0,
            memory_s: 60.0,
        }
    }
}

impl Settings for IterativeLearningSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("rate", self.rate, 0.0, 1.0)?;
        between("lead_ms", self.lead_ms, 0.0, 100.0)?;
        between("filter_ms", self.filter_ms, 0.0, 100.0)?;
        between("memory_s", self.memory_s, 0.0, 3600.0)
    }
}

/// Length of a cell, s: the usual period of the commands.
const CELL_S: f64 = 1e-3;
/// Cells over which one correction is blended into the next: 4 ms. A choice: shorter steps the
/// loops' reference, longer smears one stroke's correction into the next.
const BLEND_CELLS: f64 = 4.0;
/// Largest correction, rad: a twentieth of a turn, 1 mm on a screw of 20 mm. A choice.
const LARGEST_CORRECTION_RAD: f64 = TAU / 20.0;

/// The method `iterative-learning`.
#[derive(Clone, Copy, Debug)]
pub struct IterativeLearning {
    law: Law,
    period_s: f64,
    /// Servo ticks of a cell.
    cell: f64,
    /// Servo ticks of a blend.
    blend: f64,
}

/// The stored strokes, and the stroke under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IterativeLearningState {
    strokes: Strokes,
    run: Run,
    /// Stored stroke that is repeated; `None` for a new one.
    known: Option<usize>,
    /// Ticks since the reversal.
    age: f64,
    /// Ticks since the blend from one correction to the next began, and their difference then, rad.
    blend: [f64; 2],
    /// Reference position and velocity, error and correction of the tick before; `None` at the start.
    before: Option<[f64; 4]>,
}

impl Registered for IterativeLearning {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "iterative-learning",
        summary: "strokes that come again are corrected by what the load's scale showed last time",
        knows: Knowledge {
            load_scale: true,
            gap: false,
            load: false,
        },
        source: "Arimoto et al. (1984); Bristow, Tharayil, Alleyne (2006)",
    };

    fn from_axis(config: &AxisConfig) -> IterativeLearning {
        let settings = &config.compensation.iterative_learning;
        // a cell is 1 ms, so that times in ms are numbers of cells
        let law = Law {
            rate: settings.rate,
            lead_cells: settings.lead_ms,
            filter_cells: settings.filter_ms as usize,
            most_cells: (settings.memory_s * 1e3) as usize,
            largest: LARGEST_CORRECTION_RAD,
        };
        let period_s = config.servo_period_s();
        let cell = CELL_S / period_s;
        IterativeLearning {
            law,
            period_s,
            cell,
            blend: BLEND_CELLS * cell,
        }
    }
}

impl IterativeLearning {
    /// Ends a stroke at a reversal `since` ticks ago, and begins the next one.
    fn turn(
        &self,
        state: &mut IterativeLearningState,
        signals: &Signals,
        direction: i8,
        since: f64,
    ) {
        // what came before the first reversal is no stroke; one that is longer than the memory is
        // not whole
        let mut run = std::mem::take(&mut state.run);
        let whole = run.ways.len() <= self.law.most_cells;
        if run.beginning.direction != 0 && whole {
            state.strokes.learn(&mut run, state.known, &self.law);
        }
        let reference = &signals.reference;
        // back to the instant of the reversal, where the velocity was zero: half of velocity times
        // time
        let way_since = reference.velocity * since * self.period_s * 0.5;
        run.beginning = Beginning {
            position: reference.position - way_since,
            acceleration: reference.acceleration,
            direction,
        };
        for cells in [&mut run.ways, &mut run.applied, &mut run.errors] {
            cells.clear();
        }
        state.run = run;
        state.age = since;
        // a stored stroke may begin alike; its reference is compared as it goes on
        let known = state.strokes.find(&state.run.beginning, &[]);
        self.switch(state, known);
    }

    /// Changes to another stored stroke, or to none.
    fn switch(&self, state: &mut IterativeLearningState, known: Option<usize>) {
        let last = state.before.map_or(0.0, |before| before[3]);
        state.known = known;
        // start the blend at the present correction: no step of the position
        state.blend = [0.0, last - state.planned(self.cell)];
    }

    /// Records the cell whose time lies between the last tick and this one, if there is one.
    fn record(
        &self,
        state: &mut IterativeLearningState,
        before: [f64; 4],
        position: f64,
        error: f64,
        correction: f64,
    ) {
        let cell = state.run.ways.len();
        if cell > self.law.most_cells || state.age < self.cell * cell as f64 {
            return;
        }
        // the cell's instant lies this part of a tick back: linear interpolation
        let share = (state.age - self.cell * cell as f64).clamp(0.0, 1.0);
        let at = |now: f64, before: f64| now + (before - now) * share;
        let way = at(position, before[0]) - state.run.beginning.position;
        state.run.ways.push(way);
        state.run.errors.push(at(error, before[2]));
        state.run.applied.push(at(correction, before[3]));
        if state
            .known
            .is_some_and(|known| !state.strokes.goes_on(known, cell, way))
        {
            // the reference leaves the stored one: another stored stroke may have gone the same way
            // so far
            let other = state.strokes.find(&state.run.beginning, &state.run.ways);
            self.switch(state, other);
        }
    }
}

impl IterativeLearningState {
    /// Correction of the stored stroke at the present time, rad; `cell` in ticks.
    fn planned(&self, cell: f64) -> f64 {
        self.known
            .map_or(0.0, |known| self.strokes.correction(known, self.age / cell))
    }
}

impl Compensator for IterativeLearning {
    type State = IterativeLearningState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> IterativeLearningState {
        IterativeLearningState {
            strokes: Strokes::default(),
            run: Run::default(),
            known: None,
            age: 0.0,
            blend: [self.blend, 0.0],
            before: None,
        }
    }

    fn make_room(&self, state: &mut IterativeLearningState) {
        state.strokes.make_room(&self.law);
        state.run.make_room(&self.law);
    }

    fn step(&self, state: &mut IterativeLearningState, signals: &Signals) -> Correction {
        // nothing to learn from without a scale
        let Some(load) = signals.load_position else {
            return Correction::NONE;
        };
        let (position, velocity) = (signals.reference.position, signals.reference.velocity);
        let before = state
            .before
            .unwrap_or([position, velocity, position - load, 0.0]);
        let now = direction(velocity, state.run.beginning.direction);
        // time within the stroke, in servo ticks
        state.age += 1.0;
        if now != state.run.beginning.direction {
            // the instant of the reversal, by a straight line through both velocities
            let since = if before[1] * velocity < 0.0 {
                velocity / (velocity - before[1])
            } else {
                1.0
            };
            self.turn(state, signals, now, since);
        }
        // planned correction, with what is left of the difference to the one before
        state.blend[0] = (state.blend[0] + 1.0).min(self.blend);
        let correction = (state.planned(self.cell)
            + state.blend[1] * (1.0 - state.blend[0] / self.blend))
            .clamp(-LARGEST_CORRECTION_RAD, LARGEST_CORRECTION_RAD);
        let error = position - load;
        self.record(state, before, position, error, correction);
        state.before = Some([position, velocity, error, correction]);
        Correction {
            position: correction,
            velocity: (correction - before[3]) / self.period_s,
            ..Correction::NONE
        }
    }
}
