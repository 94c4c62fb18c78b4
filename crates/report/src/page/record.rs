//! What a page shows of a run, gathered while it goes on.

use super::circles::{CircleRecorder, FullCircle};
use super::path::{Path, PathRecorder};
use super::places::{Place, PlaceRecorder};
use super::rests::{RestRecorder, ReversalValue};
use super::series::{Envelope, Histogram, Limits};
use lostmotion_base::AxisId;
use lostmotion_drive::Learning;
use lostmotion_drive::config::AxisUnit;
use lostmotion_sim::results::Run;
use lostmotion_sim::{ContourPoint, MotorPoint, Observer};

/// Room for the path in a page, bytes: with everything else it stays below 5 MB.
const PATH_BYTES: usize = 2_800_000;
/// Bytes of a stretch of the path, packed, and of each method's error on it.
const STRETCH_BYTES: usize = 19;
const ERROR_BYTES: usize = 2;
/// Bytes of the tool's direction, of a machine that turns it.
const TOOL_BYTES: usize = 3;
/// Colours cannot show less than this part of the tolerance. A choice: a fifth of the finest step.
const FLAT_SHARE: f64 = 0.02;
/// Stretches of the path that are held, twice as many just before they are joined. A choice: what
/// fits a page of 5 MB.
const MOST_STRETCHES: usize = 130_000;
/// Parts of the time that a series has, twice as many just before they are joined. A choice: more
/// than a screen has pixels across.
const MOST_PARTS: usize = 2_000;
/// Signals of all motors of a method that have the full number of parts; more share the room. Seven
/// of three axes.
const FULL_SIGNALS: usize = 21;
/// Methods from which on all have to share the room of these many.
const SHARED_METHODS: usize = 4;

/// Signals of a motor, in the order of [`Motor::series`].
pub(super) const SIGNALS: [&str; 9] = [
    "error",
    "current",
    "torque",
    "speed",
    "lost motion",
    "engagement",
    "reference",
    "motor",
    "load",
];

/// A motor's signals over time.
#[derive(Clone, Debug)]
pub(super) struct Motor {
    pub(super) axis: AxisId,
    pub(super) second: bool,
    pub(super) unit: AxisUnit,
    pub(super) series: Envelope,
    /// Estimates of the whole gap at the end of chunks of the run: time, s, and the angle at the
    /// motor, rad. Empty for a method that learns nothing.
    pub(super) gaps: Vec<(f64, f64)>,
    /// Where it stood still, and what that tells at the end.
    rests: RestRecorder,
    pub(super) reversal_value: Option<ReversalValue>,
    /// Reference at the tick before.
    last: Option<f64>,
}

/// What is kept of one method.
#[derive(Clone, Debug)]
struct Watch {
    error: Envelope,
    histogram: Histogram,
    places: PlaceRecorder,
    circles: CircleRecorder,
    motors: Vec<Motor>,
    /// Ticks so far.
    ticks: u64,
}

/// Gathers what a page shows while a run goes on, in memory that does not grow with the program.
///
/// ```
/// use lostmotion_report::page::{PageRecorder, page, still};
/// use lostmotion_sim::{Machine, Program, Simulation};
///
/// let program = Program::from_str("arc.ngc", "G21 G90 G17\nG0 X9 Y0\nG3 I-9 F900\nM2\n");
/// let machine = Machine::preset("vmc3")?;
/// let mut recorder = PageRecorder::new(1);
/// let run = Simulation::new(&program, &machine).observer(&mut recorder).run()?;
/// let gathered = recorder.finish(&run);
/// let html = page(&run, &machine, &program, &gathered)?;
/// assert!(html.starts_with("<!DOCTYPE html>") && html.contains("within tolerance"));
/// assert!(still(&run, &gathered).starts_with("<svg "));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PageRecorder {
    path: PathRecorder,
    methods: Vec<Watch>,
    /// What limits the motion, which all methods share.
    limits: Limits,
    parts: usize,
    /// Time between two ticks, s; 0 until two are known.
    tick_s: f64,
}

/// Parts of the series of each of so many motors.
fn motor_parts(parts: usize, motors: usize) -> usize {
    (parts * FULL_SIGNALS / (motors.max(1) * SIGNALS.len())).min(parts)
}

impl PageRecorder {
    /// For a run of this many methods.
    pub fn new(methods: usize) -> PageRecorder {
        // Many methods share the room of a few.
        let share = methods.div_ceil(SHARED_METHODS).max(1);
        let parts = MOST_PARTS / share;
        let watch = Watch {
            error: Envelope::new(1, parts),
            histogram: Histogram::default(),
            places: PlaceRecorder::default(),
            circles: CircleRecorder::default(),
            motors: Vec::new(),
            ticks: 0,
        };
        PageRecorder {
            path: PathRecorder::new(methods, MOST_STRETCHES),
            methods: vec![watch; methods],
            limits: Limits::new(MOST_PARTS),
            parts,
            tick_s: 0.0,
        }
    }

    /// What was gathered of the run that it observed.
    pub fn finish(mut self, run: &Run) -> Gathered {
        self.limits.fit(MOST_PARTS);
        let tick_s = self.tick_s;
        // Errors that differ by less look alike.
        let flat_um = FLAT_SHARE * run.tolerance_um;
        let tool = if self.path.leans() { TOOL_BYTES } else { 0 };
        let bytes = STRETCH_BYTES + tool + ERROR_BYTES * run.results.len();
        // Four characters for three bytes.
        let stretches = PATH_BYTES * 3 / 4 / bytes;
        Gathered {
            path: self.path.finish(flat_um as f32, stretches),
            tick_s,
            limits: self.limits,
            methods: self
                .methods
                .into_iter()
                .map(|mut watch| {
                    watch.error.fit(self.parts);
                    let parts = motor_parts(self.parts, watch.motors.len());
                    for motor in &mut watch.motors {
                        motor.series.fit(parts);
                        motor.reversal_value = std::mem::take(&mut motor.rests).finish();
                    }
                    Watched {
                        error: watch.error,
                        histogram: watch.histogram,
                        places: watch.places.finish(),
                        circles: watch.circles.finish(),
                        motors: watch.motors,
                    }
                })
                .collect(),
        }
    }
}

/// What was gathered of a run, for [`page`](super::page) and [`still`](super::still).
#[derive(Clone, Debug)]
pub struct Gathered {
    pub(super) path: Path,
    /// Time between two ticks, s.
    pub(super) tick_s: f64,
    pub(super) limits: Limits,
    pub(super) methods: Vec<Watched>,
}

/// What was gathered of one method.
#[derive(Clone, Debug)]
pub(super) struct Watched {
    pub(super) error: Envelope,
    pub(super) histogram: Histogram,
    pub(super) places: Vec<Place>,
    pub(super) circles: Vec<FullCircle>,
    pub(super) motors: Vec<Motor>,
}

impl Observer for PageRecorder {
    fn wants_contour(&self) -> bool {
        true
    }

    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        for point in points {
            self.path.push(method, point);
        }
        if let [first, second, ..] = points
            && self.tick_s <= 0.0
        {
            self.tick_s = second.time_s - first.time_s;
        }
        let Some(watch) = self.methods.get_mut(method) else {
            return;
        };
        for point in points {
            let cuts = point.moving && !point.rapid;
            let error = if cuts { point.error_um } else { f64::NAN };
            watch.error.push(&[error as f32]);
            watch.histogram.push(error);
            watch.places.push(point);
            watch.circles.push(point);
            // The command is the same for all methods: whoever is farthest tells what limits it.
            if watch.ticks == self.limits.ticks() {
                self.limits.push(point.limiter);
            }
            watch.ticks += 1;
        }
    }

    fn wants_limiters(&self) -> bool {
        true
    }

    fn wants_motors(&self) -> bool {
        true
    }

    fn motors(&mut self, method: usize, points: &[MotorPoint]) {
        let (parts, tick_s) = (self.parts, self.tick_s);
        let Some(watch) = self.methods.get_mut(method) else {
            return;
        };
        if watch.motors.is_empty() {
            // The first tick tells which motors there are.
            let first = points.first().map(|point| point.time_s.to_bits());
            let tick = points
                .iter()
                .take_while(|point| Some(point.time_s.to_bits()) == first);
            let tick: Vec<&MotorPoint> = tick.collect();
            let parts = motor_parts(parts, tick.len());
            watch.motors = tick
                .into_iter()
                .map(|point| Motor {
                    axis: point.axis,
                    second: point.second,
                    unit: point.unit,
                    series: Envelope::new(SIGNALS.len(), parts),
                    gaps: Vec::new(),
                    rests: RestRecorder::default(),
                    reversal_value: None,
                    last: None,
                })
                .collect();
        }
        let count = watch.motors.len().max(1);
        for tick in points.chunks(count) {
            for (motor, point) in watch.motors.iter_mut().zip(tick) {
                let speed = motor
                    .last
                    .map_or(f64::NAN, |last| (point.reference - last) / tick_s.max(1e-9));
                motor.last = Some(point.reference);
                motor.rests.push(point.reference, point.load, tick_s);
                let values = [
                    point.reference - point.load,
                    point.current_a,
                    point.torque_nm,
                    speed,
                    point.motor - point.load,
                    f64::from(point.engagement.sign()),
                    point.reference,
                    point.motor,
                    point.load,
                ];
                motor.series.push(&values.map(|value| value as f32));
            }
        }
    }

    fn wants_learning(&self) -> bool {
        true
    }

    fn learning(&mut self, method: usize, time_s: f64, drives: &[Option<Learning>]) {
        let parts = self.parts;
        let Some(watch) = self.methods.get_mut(method) else {
            return;
        };
        for (motor, learning) in watch.motors.iter_mut().zip(drives) {
            let Some(learned) = learning.map(|learning| learning.learned) else {
                continue;
            };
            // Nothing is known until readings agree.
            let gap = learned
                .filter(|learned| learned.gap_readings > 0)
                .map_or(f64::NAN, |learned| 2.0 * learned.half_gap_rad);
            if motor.gaps.len() >= 2 * parts {
                // Every other one: what is known changes slowly.
                let mut keep = false;
                motor.gaps.retain(|_| {
                    keep = !keep;
                    keep
                });
            }
            motor.gaps.push((time_s, gap));
        }
    }
}
