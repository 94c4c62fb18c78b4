//! What a page says of the limits of the motion: held against the account of time and every tick.

use crate::page::{All, bytes, data, html, run};
use lostmotion_report::page::page;
use lostmotion_sim::machine::Change;
use lostmotion_sim::time::TimeOptions;
use lostmotion_sim::{ContourPoint, Limiter, Machine, Program, Simulation, presets};
use serde_json::Value;

/// Feed, rapids, corners, a circle at its limit, a dwell.
const PART: &str = "G21 G90 G17 G64 P0.02 F900\nG0 X12 Y0\nG1 Z-1\nG3 I-12\nG1 X20 Y3 F6000\nX-4 Y9\n\
    G4 P0.3\nG2 I3\nG1 X4 Y2\nG0 X0 Y0\nM2\n";

fn moving(points: &[ContourPoint]) -> Vec<&ContourPoint> {
    points.iter().filter(|point| point.moving).collect()
}

/// The page's parts of the whole are those that `time` says, which counts command cycles without any
/// axis in between.
#[test]
fn shares_are_those_of_the_account_of_time() {
    let (one, all, program) = run(PART, &["none"]);
    let shown = data(&html(&one, &program, &all.page.finish(&one)));
    let machine = Machine::preset("vmc3-worn").unwrap();
    let time = Simulation::new(&program, &machine)
        .time(&TimeOptions::default(), &mut |_| Ok(()))
        .unwrap();
    let every = shown["limits"]["every"].as_array().unwrap();
    assert!(every.len() >= 6, "{every:?}");
    for limit in &time.limits {
        let of = every.iter().find(|of| of["name"] == limit.limit.as_str());
        let share = of.map_or(0.0, |of| of["share"].as_f64().unwrap());
        // The command at rest before and after counts for a few ticks more.
        assert!((share - limit.share).abs() < 2e-3, "{limit:?}: {share}");
    }
    let sum: f64 = every.iter().map(|of| of["share"].as_f64().unwrap()).sum();
    assert!((0.99..=1.0).contains(&sum), "{sum}");
}

/// Each part of the time has the ticks that limit it, whatever the chunks and the threads are.
#[test]
fn parts_of_the_time_are_the_ticks_in_them() {
    let (one, all, program) = run(PART, &["none", "fixed"]);
    let points = all.points[0].clone();
    let shown = data(&html(&one, &program, &all.page.finish(&one)));
    let limits = &shown["limits"];
    let ticks = limits["ticks"].as_u64().unwrap() as usize;
    assert_eq!(
        limits["n"].as_u64().unwrap() as usize,
        points.len().div_ceil(ticks)
    );
    for limit in limits["every"].as_array().unwrap() {
        let index = limit["limiter"].as_u64().unwrap() as usize;
        let parts = bytes(limit["parts"].as_str().unwrap());
        for (part, (shown, ticks)) in parts.iter().zip(points.chunks(ticks)).enumerate() {
            let has = |point: &&ContourPoint| point.limiter == Some(Limiter::ALL[index]);
            let share = ticks.iter().filter(has).count() as f64 / ticks.len() as f64;
            let shown = f64::from(*shown) / 255.0;
            assert!((shown - share).abs() <= 0.002, "{limit} {part}: {share}");
        }
    }
}

/// A stretch of the path has the limit that holds for more than half of it.
#[test]
fn stretches_have_the_limit_that_holds_longest() {
    let (one, all, program) = run(PART, &["none"]);
    let points = all.points[0].clone();
    let shown = data(&html(&one, &program, &all.page.finish(&one)));
    let path = &shown["path"];
    let times: Vec<f64> = bytes(path["t"].as_str().unwrap())
        .chunks(4)
        .map(|four| f64::from(u32::from_le_bytes(four.try_into().unwrap())))
        .map(|steps| steps * path["time_step"].as_f64().unwrap())
        .collect();
    let limiters = bytes(path["limiter"].as_str().unwrap());
    assert_eq!(limiters.len(), times.len());
    let (moving, half) = (moving(&points), 0.5 * path["time_step"].as_f64().unwrap());
    let mut judged = 0;
    for (stretch, span) in times.windows(2).enumerate() {
        let inside =
            |point: &&&ContourPoint| (span[0] - half..span[1] - half).contains(&point.time_s);
        let ticks: Vec<_> = moving.iter().filter(inside).collect();
        for limiter in Limiter::ALL {
            let has = ticks.iter().filter(|point| point.limiter == Some(limiter));
            if 2 * has.count() > ticks.len() {
                judged += 1;
                let shown = usize::from(limiters[stretch]);
                assert_eq!(shown, limiter.index(), "{stretch} at {span:?}: {limiter}");
            }
        }
    }
    assert!(2 * judged > times.len(), "{judged} of {}", times.len());
}

fn changed(preset: &str, changes: &[(&str, &str)]) -> Machine {
    let changes: Vec<Change> = changes
        .iter()
        .map(|(key, value)| Change {
            key: (*key).to_owned(),
            value: (*value).to_owned(),
            name: "test".to_owned(),
        })
        .collect();
    let info = presets().iter().find(|info| info.name == preset).unwrap();
    Machine::from_changed_toml(preset, info.toml, &changes).unwrap()
}

/// Circles whose feed asks for half of the acceleration that there is, and for more than all of it
/// (v^2 / r, by hand). At a steady speed each axis uses 97 % of its limit or more for 4 acos(0.97) of
/// a turn, which are 31 % of it for both; more where the motion is faster between the axes, where both
/// share what the circle asks for.
#[test]
fn a_circle_is_limited_by_what_it_asks_for() {
    let machine = changed(
        "vmc3",
        &[
            ("axis.x.limits.jerk_mm_s3", "2e6"),
            ("axis.y.limits.jerk_mm_s3", "2e6"),
        ],
    );
    let most = machine.axes()[0].limits.acceleration;
    for (part, feeds, accelerates) in [(0.5, 0.85..1.0, 0.0..0.1), (1.6, 0.0..0.05, 0.31..1.0)] {
        let feed = (part * most * 10.0_f64).sqrt() * 60.0;
        let turns = "G3 I-10\n".repeat(20);
        let text = format!("G21 G90 G17 G64 P0.01 F{feed:.1}\nG0 X10\n{turns}M2\n");
        let program = Program::from_str("turns.ngc", &text);
        let mut all = All::new(1);
        let one = Simulation::new(&program, &machine)
            .observer(&mut all)
            .run()
            .unwrap();
        let shown: Value = data(&page(&one, &machine, &program, &all.page.finish(&one)).unwrap());
        let every = shown["limits"]["every"].as_array().unwrap();
        let share = |kind: &str| -> f64 {
            let of = every.iter();
            let of = of.filter(|of| of["name"].as_str().unwrap().starts_with(kind));
            of.map(|of| of["share"].as_f64().unwrap()).sum()
        };
        let found = [share("feed"), share("acceleration")];
        assert!(feeds.contains(&found[0]), "{part}: {found:?}");
        assert!(accelerates.contains(&found[1]), "{part}: {found:?}");
    }
}

/// Without control of the tool's centre point the path is drawn in the machine's frame: there a head
/// turns the tool, a table does not.
#[test]
fn a_head_turns_the_tool_without_control_of_its_tip() {
    let plain = [("kinematics.tip_control", "programmed")];
    for (preset, words, lean) in [("fork5", "B30", 0.5), ("trunnion5", "A30", 0.0)] {
        let machine = changed(preset, &plain);
        let text = format!("G21 G90 G94 F2000\nG1 X10 Y5 {words}\nX20\nM2\n");
        let program = Program::from_str("plain.ngc", text);
        let mut all = All::new(1);
        Simulation::new(&program, &machine)
            .observer(&mut all)
            .run()
            .unwrap();
        let [x, y, z] = all.points[0].last().unwrap().tool;
        let upright = (1.0_f64 - lean * lean).sqrt();
        let off = [x.abs() - lean, y, z - upright];
        assert!(off.iter().all(|off| off.abs() < 1e-6), "{preset}: {off:?}");
    }
}
