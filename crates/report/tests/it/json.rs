//! The numbers of results in JSON.

use crate::common::{simulation, stats, stop};
use lostmotion_base::AxisId;
use lostmotion_contour::ballbar::{BallbarSheet, Explained, ReversalMark, SenseValues};
use lostmotion_report::json;
use lostmotion_sim::recorded::results::{LimitUse, RecordCheck, RecordedAxisCheck, RecordedBlock};
use lostmotion_sim::results::{GantryResult, Run, Straightness};
use lostmotion_sim::testpart::BallbarAnswer;
use lostmotion_sim::time::results::{BlockTime, CycleTime, LimitShare, WhatIf};
use serde_json::Value;

/// Keys, each of which holds a number with a fraction or a list of them.
fn float_keys(key: &str, value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Number(number) if number.is_f64() && !found.iter().any(|known| known == key) => {
            found.push(key.to_owned());
        }
        Value::Array(list) => list.iter().for_each(|item| float_keys(key, item, found)),
        Value::Object(map) => map
            .iter()
            .for_each(|(key, item)| float_keys(key, item, found)),
        _ => {}
    }
}

/// A new field of a result gets its rounding by being put into the table: nothing is rounded by
/// chance.
#[test]
fn the_rounding_of_every_number_of_every_result_is_in_the_table() {
    let mut single = simulation();
    single.plan.bow = Some(Straightness::default());
    single.plan.bow_limit_um = Some(5.0);
    single.plan.unstraight = Some(Straightness::default());
    single.plan.cutting_force_n = 100.5;
    let mut gantry = made!(GantryResult { axis: AxisId::Y });
    gantry.skew_um = stats(2.0);
    single.result.gantry = Some(gantry);
    single.result.stop = Some(stop());
    let mut run = made!(Run { plan: single.plan });
    run.results = vec![single.result.clone()];
    let share = LimitShare::default();
    let mut block = BlockTime::default();
    block.limits = vec![share.clone()];
    let time = made!(CycleTime {
        limits: vec![share],
        blocks: vec![block],
        what_if: vec![WhatIf::default()],
    });
    let limit = LimitUse::default();
    let mut record_axis = RecordedAxisCheck::default();
    record_axis.limits = vec![limit.clone()];
    let mut recorded = RecordedBlock::default();
    (recorded.limit, recorded.allowed_um) = (Some(limit), Some(0.5));
    let record = made!(RecordCheck {
        axes: vec![record_axis],
        blocks: vec![recorded],
    });
    let told = Some(Explained::default());
    let mut sheet = BallbarSheet::default();
    sheet.senses = vec![SenseValues::default()];
    sheet.reversals = vec![ReversalMark {
        axis: AxisId::X,
        angle_deg: 0.5,
        counterclockwise: true,
        step_um: 0.5,
        spike_um: 0.5,
    }];
    (sheet.h_um, sheet.g_both_um, sheet.d_um) = (Some(0.5), Some(0.5), Some(0.5));
    (sheet.center_um, sheet.lost_motion_um) = (vec![told], vec![told]);
    (sheet.scale_um_m, sheet.squareness_um_m, sheet.mismatch_um) = (told, told, told);
    let ballbar = made!(BallbarAnswer {
        measured: sheet.clone(),
        simulated: Some(sheet),
        feed_mm_min: Some(0.5),
        apart_rms_um: Some(0.5),
    });
    let mut found = Vec::new();
    for value in [
        serde_json::to_value(record).unwrap(),
        serde_json::to_value(ballbar).unwrap(),
        serde_json::to_value(single).unwrap(),
        serde_json::to_value(run).unwrap(),
        serde_json::to_value(time).unwrap(),
    ] {
        float_keys("", &value, &mut found);
    }
    assert!(found.len() > 30, "{found:?}");
    found.retain(|key| !json::is_known_key(key));
    assert!(found.is_empty(), "not in json::KEYS: {found:?}");
}
