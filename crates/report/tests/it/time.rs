//! Where the time goes, as people and programs read it.

use lostmotion_base::{BlockRef, Span};
use lostmotion_report::csv::TimeWriter;
use lostmotion_report::text;
use lostmotion_sim::results::ProgramInfo;
use lostmotion_sim::time::results::{
    BlockTime, CycleTime, KindTimes, LimitShare, TIME_SCHEMA, TimeKind, WhatIf,
};

fn share(limit: &str, time_s: f64, share: f64) -> LimitShare {
    made!(LimitShare {
        limit: limit.to_owned(),
        time_s,
        share,
    })
}

fn block(
    line: u32,
    kind: TimeKind,
    start_s: f64,
    time_s: f64,
    limits: Vec<LimitShare>,
    text: &str,
) -> BlockTime {
    let block = BlockRef {
        span: Span {
            line,
            ..Span::default()
        },
        call_stack: 0,
    };
    made!(BlockTime {
        block,
        text: text.to_owned(),
        segment: u64::from(line),
        kind,
        start_s,
        time_s,
        limits,
    })
}

/// Figures that were chosen.
fn answer() -> CycleTime {
    let program = made!(ProgramInfo {
        name: "pocket.ngc".to_owned(),
        bytes: 99,
        lines: 9,
        moves: 5,
    });
    let feed = vec![
        share("feed", 7.5, 0.9375),
        share("jerk X", 0.3, 0.0375),
        share("acceleration Y", 0.15, 0.018_75),
        share("look-ahead", 0.05, 0.006_25),
    ];
    made!(CycleTime {
        schema: TIME_SCHEMA,
        program,
        machine: "mill".to_owned(),
        total_s: 16.0,
        plan_s: 10.0,
        kinds: made!(KindTimes {
            cutting_s: 8.0,
            rapid_s: 1.5,
            dwell_s: 0.5,
            tool_changes: 1,
            tool_change_s: 4.0,
            spindle_events: 2,
            spindle_event_s: 1.0,
        }),
        limits: vec![
            share("feed", 7.5, 0.75),
            share("velocity X", 2.0, 0.2),
            share("dwell", 0.5, 0.05),
        ],
        blocks: vec![
            block(4, TimeKind::Cutting, 2.0, 8.0, feed, "G3 I-25 F600"),
            block(
                3,
                TimeKind::Dwell,
                1.5,
                0.5,
                vec![share("dwell", 0.5, 1.0)],
                "G4 P0.5",
            ),
        ],
        block_count: 3,
        what_if: vec![
            made!(WhatIf {
                change: "feed +20 %".to_owned(),
                plan_s: 8.75,
                saved_s: 1.25,
                saved_share: 0.125,
            }),
            made!(WhatIf {
                change: "jerk limits +20 %".to_owned(),
                plan_s: 10.0,
                saved_s: 0.0,
                saved_share: 0.0,
            }),
        ],
    })
}

#[test]
fn a_cycle_time_in_a_terminal() {
    insta::assert_snapshot!(text::time(&answer(), &text::TextOptions::default()));
}

#[test]
fn blocks_as_a_table() {
    let mut writer = TimeWriter::new(Vec::new()).expect("writes");
    writer.push(&answer().blocks).expect("writes");
    let table = String::from_utf8(writer.finish().expect("writes")).expect("text");
    assert_eq!(
        table,
        "segment,file,line,kind,start_s,time_s,limit,limit_share\n\
         4,0,4,cutting,2.000000,8.000000,feed,0.9375\n\
         3,0,3,dwell,1.500000,0.500000,dwell,1.0000\n"
    );
}
