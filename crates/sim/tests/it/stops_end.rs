//! What has stopped is simulated no further, and how near the others came to being stopped.

use lostmotion_base::AxisId;
use lostmotion_drive::config::{Load, Monitoring};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use lostmotion_sim::results::{Run, StopLimit};
use lostmotion_sim::{Machine, Program, Simulation};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Pulls the motor away from its command from a time on, and counts how often it is asked.
struct RunsAway {
    from_s: f64,
    asked: Arc<AtomicU64>,
}

static RUNS_AWAY: MethodInfo = MethodInfo {
    name: "runs-away",
    summary: "pulls the motor away",
    source: "this test",
    knows: Knowledge {
        load_scale: false,
        gap: false,
        load: false,
    },
};

impl Compensator for RunsAway {
    /// Servo ticks so far.
    type State = u64;

    fn info(&self) -> &'static MethodInfo {
        &RUNS_AWAY
    }

    fn initial(&self, _start: f64) -> u64 {
        0
    }

    fn step(&self, ticks: &mut u64, _signals: &Signals) -> Correction {
        *ticks += 1;
        self.asked.fetch_add(1, Ordering::Relaxed);
        // It settles for 0.5 s before the program.
        let time_s = *ticks as f64 * 250e-6 - 0.5;
        Correction {
            position: if time_s > self.from_s { 1e3 } else { 0.0 },
            ..Correction::NONE
        }
    }
}

const LONG: &str = "G21 G90 G17\nG0 X10 Y0\nG3 I-10 J0 P8 F1500\nM2\n";

/// A run of `none` and of a method that runs away, and how often that one was asked.
fn run(from_s: f64, threads: usize) -> (Run, u64) {
    let asked = Arc::new(AtomicU64::new(0));
    let machine = Machine::preset("vmc3").unwrap();
    let program = Program::from_str("long.ngc", LONG);
    let counts = Arc::clone(&asked);
    let run = Simulation::new(&program, &machine)
        .methods(["none"])
        .compensator("runs-away", move |_| RunsAway {
            from_s,
            asked: Arc::clone(&counts),
        })
        .threads(threads)
        .run()
        .unwrap();
    (run, asked.load(Ordering::Relaxed))
}

#[test]
fn a_method_that_stops_is_simulated_no_further() {
    let (free, all) = run(1e9, 1);
    assert_eq!(free.result("runs-away").unwrap().stop, None);
    for threads in [1, 2] {
        let (stopped, asked) = run(2.0, threads);
        let found = stopped.result("runs-away").unwrap();
        let stop = found.stop.as_ref().expect("it does not stop");
        assert_eq!(stop.limit, StopLimit::FollowingError);
        assert!(stop.time_s > 2.0 && stop.time_s < 2.1, "{stop:?}");
        // Three axes, four servo ticks a millisecond; to the end of the chunk of a second in which
        // it stops, and what the other axes do in it.
        let most = 3.0 * 4e3 * (0.5 + stop.time_s + 1.1);
        assert!((asked as f64) < most && asked < all / 4, "{asked} of {all}");
        // The plan, the machine without a gap and the other method go on to the end.
        assert_eq!(stopped.plan, free.plan);
        assert_eq!(stopped.without_gap, free.without_gap);
        assert_eq!(stopped.result("none"), free.result("none"));
        // Up to the stop the figures are those of a method that does nothing.
        let backlash = free.result("none").unwrap().backlash;
        assert!(found.backlash.samples < backlash.samples);
    }
}

/// What a run uses of its limits by closed forms: a weight F on a screw of the lead p warms the motor
/// to `(i/ic)^2 (1 - exp(-t/T))` with `i = F p/(2 pi Kt)`; a motor held `e` ahead uses `e` of its
/// following error.
#[test]
fn the_parts_of_the_limits_are_those_of_the_closed_forms() {
    let (force_n, lead_m) = (3000.0, 0.016);
    let current_a = force_n * lead_m / TAU / 1.08;
    let (ratio, time_s) = (0.9, 2.0);
    let machine = Machine::preset("vmc3")
        .unwrap()
        .edit(|m| {
            let z = m.axis("z");
            z.motor.coulomb_nm = 0.0;
            z.drive.encoder_counts_per_rev = None;
            z.monitoring = Monitoring {
                continuous_current_a: Some(current_a / ratio),
                overload_time_s: time_s,
                following_error_units: Some(0.5),
                overtravel_units: Some(1.0),
                ..Monitoring::OFF
            };
            if let Load::Slide(slide) = &mut z.config.load {
                slide.constant_n = force_n;
                slide.coulomb_n = 0.0;
            }
        })
        .unwrap();
    let program = Program::from_str("weight.ngc", "G21 G90\nG1 X0.001 F3000\nG4 P5\nM2\n");
    let run = Simulation::new(&program, &machine).run().unwrap();
    let used = &run.first().unwrap().limits_used;
    let z = used.iter().find(|used| used.axis == AxisId::Z).unwrap();
    let duration_s = run.plan.duration_s;
    let heat = ratio * ratio * (1.0 - f64::exp(-duration_s / time_s));
    assert!((z.overload - heat).abs() < 2e-3, "{z:?}: {heat}");
    assert!(z.following_error < 0.1 && z.at_limit == 0.0, "{z:?}");
    // Z stands where the program starts, within what the weight winds the shaft up by.
    let limits = machine.axis(AxisId::Z).unwrap().limits;
    let from_middle = (machine.start()[AxisId::Z] - 0.5 * (limits.min + limits.max)).abs();
    let share = from_middle / (0.5 * (limits.max - limits.min) + 1.0);
    assert!((z.travel - share).abs() < 1e-3, "{z:?}: {share}");
}
