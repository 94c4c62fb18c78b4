//! Statistics, reversals, causes and ledgers against sorting, hand counts and round trips.

use lostmotion_base::{AxisId, BlockRef, Coords, math};
use lostmotion_contour::{
    BlockLedger, Cause, CauseRule, ContourSample, ErrorRecord, Place, Reversal, ReversalConfig,
    ReversalLedger, ReversalState, Shares, Statistics,
};
use proptest::prelude::*;

fn at(tick: u64) -> Place {
    Place {
        tick,
        segment: tick / 10,
        s: 0.0,
    }
}

fn record(tick: u64, segment: u64, shares: Shares) -> ErrorRecord {
    let sample = ContourSample {
        tick,
        segment,
        error_mm: shares.total_mm(),
        ..ContourSample::default()
    };
    ErrorRecord {
        sample,
        shares,
        cause: Cause::ServoLag,
        commanded_tip_mm: [0.0; 3],
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn statistics_agree_with_sorting(values in prop::collection::vec((-7.0..3.0_f64, any::<bool>()), 1..2000), cut in 0.0..1.0_f64) {
        let values: Vec<f64> = values.into_iter().map(|(exponent, sign)| if sign { 1.0 } else { -1.0 } * math::pow(10.0, exponent)).collect();
        let mut all = Statistics::default();
        let mut halves = [Statistics::default(), Statistics::default()];
        let middle = (cut * values.len() as f64) as usize;
        for (tick, value) in values.iter().enumerate() {
            all.push(*value, at(tick as u64));
            halves[usize::from(tick >= middle)].push(*value, at(tick as u64));
        }
        let [mut first, second] = halves;
        first.merge(&second);
        let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        for part in [0.0, 0.5, 0.95, 0.99, 0.999, 1.0] {
            let rank = ((part * sizes.len() as f64).ceil() as usize).max(1);
            let (exact, found) = (sizes[rank - 1], all.percentile(part));
            prop_assert!((found - exact).abs() <= exact / 250.0, "{part}: {found} {exact}");
            prop_assert!((first.percentile(part) - found).abs() < 1e-300);
        }
        let square = values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
        prop_assert!((all.rms() - square.sqrt()).abs() < 1e-12 * all.rms() && (first.rms() - all.rms()).abs() < 1e-12 * all.rms());
        let (max, place) = all.max();
        prop_assert!((max.abs() - sizes[sizes.len() - 1]).abs() < 1e-300);
        prop_assert!((values[place.tick as usize] - max).abs() < 1e-300);
        prop_assert_eq!(first.max(), all.max());
        let text = serde_json::to_string(&all).unwrap();
        prop_assert_eq!(serde_json::from_str::<Statistics>(&text).unwrap().summary().samples, all.samples());
    }

    #[test]
    fn a_reversal_is_a_change_of_the_last_sign(signs in prop::collection::vec(-1..=1_i32, 1..200)) {
        let (config, mut state) = (ReversalConfig::default(), ReversalState::default());
        let mut found = Vec::new();
        for (tick, sign) in signs.iter().enumerate() {
            let velocity = Coords::xyz(0.0, f64::from(*sign) * 3.0, 1e-7 * f64::from(*sign));
            found.extend(config.step(&mut state, tick as u64, &velocity));
        }
        let moving: Vec<(u64, i32)> = signs.iter().enumerate().filter(|(_, sign)| **sign != 0).map(|(tick, sign)| (tick as u64, *sign)).collect();
        let meant: Vec<Reversal> = moving
            .windows(2)
            .filter(|pair| pair[0].1 != pair[1].1)
            .map(|pair| Reversal { axis: AxisId::Y, tick: pair[1].0, direction: pair[1].1 as i8 })
            .collect();
        prop_assert_eq!(found, meant);
    }
}

#[test]
fn empty_and_odd_statistics() {
    let mut statistics = Statistics::default();
    assert_eq!(statistics.summary(), Statistics::default().summary());
    for value in [0.0, f64::NAN, f64::INFINITY, 1e-12, 5000.0] {
        statistics.push(value, at(1));
    }
    assert_eq!((statistics.samples(), statistics.not_finite()), (3, 2));
    assert_eq!(statistics.percentile(0.5).to_bits(), 0.0_f64.to_bits());
    assert!((statistics.max().0 - 5000.0).abs() < 1e-12 && statistics.percentile(1.0) >= 1020.0);
}

#[test]
fn the_largest_share_names_the_cause() {
    let rule = CauseRule {
        reversal_window_ticks: 100,
    };
    let mut state = ReversalState::default();
    let config = ReversalConfig::default();
    for (tick, x) in [(0, 1.0), (50, -1.0)] {
        assert_eq!(
            config
                .step(&mut state, tick, &Coords::xyz(x, 1.0, 0.0))
                .count(),
            usize::from(tick == 50)
        );
    }
    let sample = |tick, near_corner| ContourSample {
        tick,
        near_corner,
        ..ContourSample::default()
    };
    let shares = |command_mm, servo_mm, backlash_mm| Shares {
        command_mm,
        servo_mm,
        backlash_mm,
        ..Shares::default()
    };
    let cases = [
        (
            shares(0.001, 0.002, -0.005),
            60,
            false,
            Cause::Reversal(AxisId::X),
        ),
        (
            shares(0.001, 0.002, -0.005),
            150,
            false,
            Cause::Reversal(AxisId::X),
        ),
        (shares(0.001, 0.002, -0.005), 151, false, Cause::Gap),
        (
            shares(0.001, -0.006, 0.005),
            60,
            true,
            Cause::Reversal(AxisId::X),
        ),
        (shares(0.001, -0.006, 0.005), 151, false, Cause::ServoLag),
        (shares(0.001, -0.006, 0.005), 151, true, Cause::Corner),
        (shares(0.009, -0.006, 0.005), 60, true, Cause::Blend),
    ];
    for (shares, tick, corner, cause) in cases {
        assert_eq!(rule.cause(&shares, &sample(tick, corner), &state), cause);
    }
    // Errors to the left (positive) and to the right of a line along X.
    let off = |error_mm: f64| ContourSample {
        error_mm,
        distance_mm: error_mm.abs(),
        tip_mm: [7.0, error_mm, 0.0],
        off_mm: [0.0, error_mm, 0.0],
        travel: [1.0, 0.0, 0.0],
        ..ContourSample::default()
    };
    let parts = Shares::of(&off(0.003), &off(-0.001), &off(0.010));
    assert!(
        (parts.servo_mm + 0.004).abs() < 1e-15
            && (parts.backlash_mm - 0.011).abs() < 1e-15
            && (parts.total_mm() - 0.010).abs() < 1e-15
    );
    assert_eq!(
        serde_json::to_string(&Cause::Reversal(AxisId::Y)).unwrap(),
        r#"{"kind":"reversal","axis":"Y"}"#
    );
    assert_eq!(
        serde_json::to_string(&Cause::ServoLag).unwrap(),
        r#"{"kind":"servo-lag"}"#
    );
}

#[test]
fn blocks_are_handed_out_and_the_worst_are_kept() {
    let mut ledger = BlockLedger::new(3);
    let mut rows = Vec::new();
    for tick in 0..1000_u64 {
        let size = 1e-3 * ((tick / 10 * 37) % 100) as f64 * if tick % 10 == 4 { -1.0 } else { 0.5 };
        // Feet go a little back and forth over joints.
        ledger.record(&record(
            tick,
            (tick / 10).saturating_sub(u64::from(tick % 10 == 0)),
            Shares {
                servo_mm: size,
                ..Shares::default()
            },
        ));
        rows.extend(ledger.finish_before((tick / 10).saturating_sub(2)));
    }
    rows.extend(ledger.finish());
    assert!(
        rows.iter()
            .enumerate()
            .all(|(i, row)| row.segment == i as u64)
            && rows.len() == 100
    );
    assert_eq!(rows.iter().map(|row| row.samples).sum::<u64>(), 1000);
    let mut sizes: Vec<f64> = rows.iter().map(|row| row.max_mm().abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let worst: Vec<f64> = ledger.worst().map(|row| row.max_mm().abs()).collect();
    assert_eq!(
        worst,
        sizes.iter().rev().take(3).copied().collect::<Vec<_>>()
    );
    let row = rows[40];
    let (half, full) = (0.5 * row.max_mm(), row.max_mm());
    // Nine of its samples are half as large; its first has its foot on the block before, and the
    // next block's on it.
    let neighbour = 0.5 * 1e-3 * f64::from((41 * 37) % 100);
    let square = 8.0 * half * half + full * full + neighbour * neighbour;
    assert!((row.rms_mm() - (square / 10.0).sqrt()).abs() < 1e-15);
    assert!(row.max_mm() < 0.0 && row.backlash_rms_mm() < 1e-300);
    let text = serde_json::to_string(&ledger).unwrap();
    assert_eq!(serde_json::from_str::<BlockLedger>(&text).unwrap(), ledger);
}

#[test]
fn reversals_collect_what_follows_them() {
    let mut ledger = ReversalLedger::new(20, 2);
    let mut rows = Vec::new();
    for tick in 0..200_u64 {
        if tick % 50 == 10 {
            let reversal = Reversal {
                axis: AxisId::X,
                tick,
                direction: if tick % 100 == 10 { 1 } else { -1 },
            };
            assert!(
                ledger
                    .open(reversal, tick / 50, BlockRef::default(), false)
                    .is_none()
            );
        }
        // A spike of 1 um a reversal, growing, five ticks after it, and a larger error outside of
        // the window.
        let spike = if tick % 50 == 15 {
            -1e-3 * (1 + tick / 50) as f64
        } else {
            0.0
        };
        let outside = if tick % 50 == 45 { 1.0 } else { 0.0 };
        rows.extend(ledger.record(&record(
            tick,
            0,
            Shares {
                servo_mm: outside,
                backlash_mm: spike,
                backlash_size_mm: spike.abs(),
                command_mm: 0.0,
            },
        )));
    }
    rows.extend(ledger.finish());
    assert_eq!(rows.len(), 4);
    for (i, row) in rows.iter().enumerate() {
        assert!(
            (row.peak_mm + 1e-3 * (i + 1) as f64).abs() < 1e-15
                && row.peak_tick == 50 * i as u64 + 15
        );
        assert!(
            (row.peak_backlash_mm - row.peak_mm.abs()).abs() < 1e-15 && row.segment == i as u64
        );
    }
    assert_eq!(
        ledger.worst().map(|row| row.segment).collect::<Vec<_>>(),
        [3, 2]
    );
    assert_eq!(ledger.counts()[0], 4);
    // A reversal within the window of the one before ends it.
    let reversal = |tick| Reversal {
        axis: AxisId::X,
        tick,
        direction: 1,
    };
    assert!(
        ledger
            .open(reversal(300), 0, BlockRef::default(), false)
            .is_none()
    );
    assert_eq!(
        ledger
            .open(reversal(305), 0, BlockRef::default(), false)
            .unwrap()
            .reversal
            .tick,
        300
    );
}
