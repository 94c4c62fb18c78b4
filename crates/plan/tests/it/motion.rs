//! Times and states that have closed forms or follow from the contract.

use crate::common::{
    LIMITS, Program, assert_limits, cartesian, continuous, deviation, generate, run, three_axes,
};
use lostmotion_base::units::rad;
use lostmotion_base::{AxisId, BlockRef, Coords, math};
use lostmotion_plan::{
    Dwell, FeedLimit, Halt, Move, PathControl, PlanError, PlanItem, Planner, PlannerConfig, Sample,
    TravelCheck,
};
use std::f64::consts::TAU;

/// Seconds that the samples span.
fn seconds(samples: &[Sample]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}

/// The time-optimal rest-to-rest time over a distance with limits of velocity, acceleration and
/// jerk (Lambrechts 2005).
fn s_curve(d: f64, v: f64, a: f64, j: f64) -> f64 {
    let mut tj = math::cbrt(d / (2.0 * j)).min((v / j).sqrt());
    if tj <= a / j {
        return 4.0 * tj + (d / (j * tj * tj) - 2.0 * tj);
    }
    tj = a / j;
    let ta = (0.5 * (-tj + (tj * tj + 4.0 * d / a).sqrt()) - tj)
        .max(0.0)
        .min(v / a - tj);
    let reached = a * (tj + ta);
    4.0 * tj + 2.0 * ta + (d - reached * (2.0 * tj + ta)) / reached
}

#[test]
fn single_moves_take_the_optimal_time() {
    for distance in [
        1e-4, 0.003, 0.05, 0.4, 1.0, 2.5, 4.0, 8.0, 14.0, 50.0, 500.0,
    ] {
        for feed in [2.0, 10.0, 60.0, 100.0] {
            let mut program = Program::new(PathControl::ExactPath, feed);
            program.line(distance, 0.0, 0.0);
            let samples = program.run();
            let optimum = s_curve(distance, feed, 1000.0, 30_000.0);
            let time = seconds(&samples);
            assert!(
                time >= optimum - 1e-9 && time <= optimum * 1.000_01 + 1.01e-3,
                "{distance} mm at {feed}: {time} s, optimum {optimum} s"
            );
            assert_limits(&samples, &[Some(LIMITS); 3]);
        }
    }
}

#[test]
fn a_diagonal_uses_both_axes_in_full() {
    let mut program = Program::new(PathControl::ExactPath, 1000.0);
    program.line(100.0, 100.0, 0.0);
    let optimum = s_curve(100.0, 100.0, 1000.0, 30_000.0);
    assert!((seconds(&program.run()) - optimum).abs() < 2e-3);
}

#[test]
fn a_circle_takes_its_length_over_the_feed_and_a_start_and_stop() {
    let mut program = Program::new(continuous(0.01), 50.0);
    program.arc(25.0, 0.0, TAU);
    let samples = program.run();
    let along = TAU * 25.0 / 50.0 + 50.0 / 1000.0 + 1.0 / 30.0;
    assert!(
        (seconds(&samples) - along).abs() < 0.002 * along,
        "{} {along}",
        seconds(&samples)
    );
    assert!(deviation(&samples, &program.moves) < 1e-9);
}

#[test]
fn exact_path_stops_in_corners_and_reaches_them() {
    let mut program = Program::new(PathControl::ExactPath, 100.0);
    for (x, y) in [(20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)] {
        program.line(x, y, 0.0);
    }
    let samples = program.run();
    assert!(deviation(&samples, &program.moves) < 1e-9);
    let optimum = 4.0 * s_curve(20.0, 100.0, 1000.0, 30_000.0);
    assert!((seconds(&samples) - optimum).abs() < 1.1e-3);
    let nearest = |x, y| {
        samples
            .iter()
            .map(|s| (s.position - Coords::xyz(x, y, 0.0)).linear_norm())
            .fold(f64::INFINITY, f64::min)
    };
    // The tail J t^3 / 6 within half a millisecond of the corner.
    assert!(nearest(20.0, 20.0) < 30_000.0 * 1.25e-10);
}

#[test]
fn exact_stop_comes_to_rest_after_every_move() {
    let straight = |control| {
        let mut program = Program::new(control, 100.0);
        program.line(20.0, 0.0, 0.0);
        program.line(40.0, 0.0, 0.0);
        seconds(&program.run())
    };
    let (through, stops) = (
        straight(PathControl::ExactPath),
        straight(PathControl::ExactStop),
    );
    assert!((through - s_curve(40.0, 100.0, 1000.0, 30_000.0)).abs() < 1.1e-3);
    assert!((stops - 2.0 * s_curve(20.0, 100.0, 1000.0, 30_000.0)).abs() < 1.1e-3);
}

#[test]
fn blending_is_never_slower_than_stopping() {
    for angle in [2.0, 5.0, 10.0, 20.0, 45.0, 90.0, 150.0] {
        let time = |control| {
            let mut program = Program::new(control, 50.0);
            program.line(30.0, 0.0, 0.0);
            let (sin, cos) = math::sin_cos(rad(angle));
            program.line(30.0 + 30.0 * cos, 30.0 * sin, 0.0);
            seconds(&program.run())
        };
        let (exact, tight, wide) = (
            time(PathControl::ExactPath),
            time(continuous(0.01)),
            time(continuous(0.1)),
        );
        assert!(
            tight <= exact + 1e-9 && wide <= tight + 1e-9,
            "{angle} degrees: {exact} {tight} {wide}"
        );
    }
}

#[test]
fn dwells_and_halts_stand_still_as_long_as_they_say() {
    let mut program = Program::new(continuous(0.01), 100.0);
    program.line(10.0, 0.0, 0.0);
    program.line(20.0, 0.0, 0.0);
    let moves: Vec<PlanItem> = program.moves.iter().map(|m| PlanItem::Move(*m)).collect();
    let block = BlockRef::default();
    let time = |middle: PlanItem| {
        seconds(&run(
            three_axes(),
            cartesian(),
            Coords::ZERO,
            [moves[0], middle, moves[1]].into_iter(),
        ))
    };
    let two = 2.0 * s_curve(10.0, 100.0, 1000.0, 30_000.0);
    assert!((time(PlanItem::Halt(Halt { block })) - two).abs() < 1.1e-3);
    let samples = run(
        three_axes(),
        cartesian(),
        Coords::ZERO,
        [
            moves[0],
            PlanItem::Dwell(Dwell {
                seconds: 0.25,
                block,
            }),
            moves[1],
        ]
        .into_iter(),
    );
    assert!((seconds(&samples) - two - 0.25).abs() < 1.1e-3);
    let still = samples
        .iter()
        .filter(|s| (s.position[AxisId::X] - 10.0).abs() < 1e-12 && s.velocity == Coords::ZERO)
        .count();
    assert!(still >= 250, "{still}");
    let only = run(
        three_axes(),
        cartesian(),
        Coords::ZERO,
        [PlanItem::Dwell(Dwell {
            seconds: 0.1,
            block,
        })]
        .into_iter(),
    );
    assert_eq!(only.len(), 101);
}

#[test]
fn nothing_to_do_is_one_sample_at_rest() {
    let samples = run(
        three_axes(),
        cartesian(),
        Coords::xyz(1.0, 2.0, 3.0),
        std::iter::empty(),
    );
    assert_eq!(samples.len(), 1);
    assert_eq!(samples[0].position, Coords::xyz(1.0, 2.0, 3.0));
}

#[test]
fn inverse_time_moves_take_at_least_their_time_and_little_more() {
    let mut program = Program::new(PathControl::ExactPath, 1.0);
    program.feed = FeedLimit::Duration(2.0);
    program.line(20.0, 0.0, 0.0);
    let time = seconds(&program.run());
    assert!(
        (time - 2.0 - 10.0 / 1000.0 - 1.0 / 30.0).abs() < 0.03,
        "{time}"
    );
}

#[test]
fn states_are_derivatives_of_each_other() {
    let mut program = Program::new(continuous(0.05), 60.0);
    program.arc(5.0, 0.0, 2.0);
    program.arc(0.0, 3.0, -1.0);
    program.line(40.0, 10.0, 3.0);
    for w in program.run().windows(3) {
        for joint in 0..3 {
            let q = [0, 1, 2].map(|i: usize| w[i].position.0[joint]);
            let (v, a) = ((q[2] - q[0]) / 2e-3, (q[2] - 2.0 * q[1] + q[0]) / 1e-6);
            // Differences miss h^2/6 and h/3 of the jerk.
            assert!((v - w[1].velocity.0[joint]).abs() < 30_000.0 * 1e-6 / 6.0 * 1.01 + 1e-6);
            assert!((a - w[1].acceleration.0[joint]).abs() < 30_000.0 * 1e-3 / 3.0 * 1.01 + 1e-3);
        }
    }
}

#[test]
fn segments_and_parameters_follow_the_programmed_curves() {
    let mut program = Program::new(continuous(0.05), 60.0);
    program.line(10.0, 0.0, 0.0);
    program.line(10.0, 0.0, 0.0);
    program.line(20.0, 1.0, 0.0);
    program.arc(0.0, 4.0, 2.0);
    for sample in program.run() {
        let item = &program.moves[sample.segment as usize];
        assert_eq!(item.block, sample.block);
        let off = (item.curve.point(sample.s) - sample.position).linear_norm();
        assert!(off < 0.06, "{off} {sample:?}");
    }
}

/// A wavy polyline of any length, without holding it.
fn wave(count: usize) -> impl Iterator<Item = PlanItem> {
    let point = |i: usize| {
        Coords::xyz(
            0.05 * i as f64 % 5000.0,
            3.0 * math::sin(0.05 * i as f64 * 0.4),
            0.0,
        )
    };
    (0..count).map(move |i| {
        let mut block = BlockRef::default();
        block.span.line = i as u32;
        let curve = lostmotion_path::Curve::line(point(i), point(i + 1));
        PlanItem::Move(Move {
            curve,
            feed: FeedLimit::PerSecond(80.0),
            control: continuous(0.01),
            tool_mm: [0.0; 3],
            block,
        })
    })
}

#[test]
fn samples_do_not_depend_on_how_they_are_taken() {
    let config = PlannerConfig {
        window_intervals: 200,
        window_pieces: 600,
        ..three_axes()
    };
    let take = |every: usize, chunk: usize| {
        let mut planner = Planner::new(config.clone(), cartesian(), Coords::ZERO).unwrap();
        let mut samples = Vec::new();
        for (i, item) in wave(4000).enumerate() {
            planner.push(item).unwrap();
            if i % every == 0 {
                planner.take(chunk, &mut samples);
            }
        }
        planner.finish().unwrap();
        while planner.take(chunk, &mut samples) > 0 {}
        samples
    };
    let all = take(usize::MAX, usize::MAX);
    assert!(all == take(1, 7));
    assert!(all == take(13, usize::MAX));
    assert_limits(&all, &[Some(LIMITS); 3]);
}

/// One half takes items on a thread of its own while the other plans what it took before.
#[test]
fn halves_at_work_at_the_same_time_give_the_samples_of_pushing() {
    let varied = (0..40).map(|seed| {
        let case = generate::varied(seed);
        let items = case.program.moves.iter().map(|item| PlanItem::Move(*item));
        (case.config, items.collect::<Vec<PlanItem>>())
    });
    let wave = (three_axes(), wave(3000).collect());
    for (case, (config, items)) in varied.chain([wave]).enumerate() {
        let planner = || Planner::new(config.clone(), cartesian(), Coords::ZERO).unwrap();
        let (mut one, mut expected) = (planner(), Vec::new());
        for item in &items {
            one.push(*item).unwrap();
        }
        one.finish().unwrap();
        while one.take(1000, &mut expected) > 0 {}
        for lot in [1, 7, 400] {
            let (mut two, mut samples) = (planner(), Vec::new());
            let mut lots = items.chunks(lot);
            let mut over = false;
            while !over || two.is_behind() {
                let (mut items, path) = two.halves();
                std::thread::scope(|scope| {
                    let planned = scope.spawn(|| path.plan());
                    match lots.next() {
                        Some(lot) => lot.iter().for_each(|item| items.push(*item).unwrap()),
                        None => {
                            items.finish();
                            over = true;
                        }
                    }
                    planned.join().unwrap().unwrap();
                });
                two.take(usize::MAX, &mut samples);
            }
            assert!(samples == expected, "case {case}, lots of {lot}");
            assert_eq!(two.shortfalls(), one.shortfalls());
            assert_eq!(two.held_pieces(), one.held_pieces());
        }
    }
}

#[test]
fn memory_stays_within_the_window_on_long_programs() {
    let config = PlannerConfig {
        window_intervals: 256,
        window_pieces: 1024,
        ..three_axes()
    };
    let mut planner = Planner::new(config, cartesian(), Coords::ZERO).unwrap();
    let (mut samples, mut held, mut count) = (Vec::new(), 0, 0);
    for item in wave(60_000) {
        planner.push(item).unwrap();
        held = held.max(planner.held_pieces());
        samples.clear();
        count += planner.take(usize::MAX, &mut samples);
    }
    planner.finish().unwrap();
    count += planner.take(usize::MAX, &mut samples);
    assert!(held <= 2 * 1024 + 200, "{held}");
    assert!(count > 40_000, "{count}");
    assert_eq!(planner.shortfalls().window_stops, 0);
}

#[test]
fn a_window_too_short_for_the_path_stops_but_keeps_the_limits() {
    let config = PlannerConfig {
        window_intervals: 64,
        window_pieces: 64,
        ..three_axes()
    };
    let control = PathControl::Continuous {
        tolerance_mm: Some(0.01),
        merge_tolerance_mm: Some(0.0),
    };
    let mut planner = Planner::new(config, cartesian(), Coords::ZERO).unwrap();
    let mut samples = Vec::new();
    for i in 0..800 {
        let point = |i: usize| Coords::xyz(0.01 * i as f64, 0.0, 0.0);
        let (curve, block) = (
            lostmotion_path::Curve::line(point(i), point(i + 1)),
            BlockRef::default(),
        );
        planner
            .push(PlanItem::Move(Move {
                curve,
                feed: FeedLimit::Rapid,
                control,
                tool_mm: [0.0; 3],
                block,
            }))
            .unwrap();
        planner.take(usize::MAX, &mut samples);
    }
    planner.finish().unwrap();
    planner.take(usize::MAX, &mut samples);
    assert!(planner.shortfalls().window_stops > 0);
    assert_limits(&samples, &[Some(LIMITS); 3]);
    assert!((samples.last().unwrap().position[AxisId::X] - 8.0).abs() < 1e-9);
}

#[test]
fn what_cannot_be_planned_is_refused_with_its_values() {
    let mut config = three_axes();
    config.limits[0] = Some(lostmotion_base::AxisLimits {
        min: -5.0,
        max: 15.0,
        ..LIMITS
    });
    let mut planner = Planner::new(config.clone(), cartesian(), Coords::ZERO).unwrap();
    let mut program = Program::new(PathControl::ExactPath, 10.0);
    program.line(10.0, 0.0, 0.0);
    program.arc(0.0, 10.0, 3.0);
    planner.push(PlanItem::Move(program.moves[0])).unwrap();
    let error = planner.push(PlanItem::Move(program.moves[1])).unwrap_err();
    let PlanError::Travel(violation) = error else {
        panic!("{error}")
    };
    assert_eq!((violation.joint, violation.block.span.line), (AxisId::X, 2));
    assert!((violation.value - 20.0).abs() < 1e-9 && (violation.limit - 15.0).abs() < 1e-12);
    let mut check = TravelCheck::new(&config, cartesian());
    for item in &program.moves {
        check.push(item).unwrap();
    }
    assert_eq!(check.violations(), [violation]);

    let apart = Move {
        curve: lostmotion_path::Curve::line(Coords::xyz(10.0, 0.5, 0.0), Coords::ZERO),
        ..program.moves[0]
    };
    assert!(matches!(
        planner.push(PlanItem::Move(apart)),
        Err(PlanError::Jump {
            axis: AxisId::Y,
            ..
        })
    ));
    let mut turned = program.here;
    turned[AxisId::A] = 1.0;
    let start = program.moves[0].curve.end();
    let rotary = Move {
        curve: lostmotion_path::Curve::line(
            start,
            start + Coords([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ),
        ..apart
    };
    assert!(matches!(
        planner.push(PlanItem::Move(rotary)),
        Err(PlanError::NoLimits {
            joint: AxisId::A,
            ..
        })
    ));
    let nowhere = Move {
        curve: lostmotion_path::Curve::line(start, Coords::xyz(f64::NAN, 0.0, 0.0)),
        ..apart
    };
    assert!(matches!(
        planner.push(PlanItem::Move(nowhere)),
        Err(PlanError::Number { .. })
    ));
    let slow = Move {
        curve: lostmotion_path::Curve::line(start, Coords::ZERO),
        feed: FeedLimit::PerSecond(0.0),
        ..apart
    };
    assert!(matches!(
        planner.push(PlanItem::Move(slow)),
        Err(PlanError::Number { .. })
    ));
}
