//! Several runs side by side.
use lostmotion_report::page::runs_page;
use lostmotion_report::runs::{NamedRun, short_names, worst_blocks};
use lostmotion_report::text::{TextOptions, runs};
use lostmotion_sim::results::{BlockResult, MethodResult, Run};

fn block(line: u32, text: &str, max_um: f64) -> BlockResult {
    let text = text.to_owned();
    let mut block = made!(BlockResult { text, max_um });
    block.block.span.line = line;
    block
}

fn named(name: &str, blocks: Vec<BlockResult>) -> NamedRun {
    let method = "none".to_owned();
    let result = made!(MethodResult {
        method,
        worst_blocks: blocks
    });
    let run = made!(Run {
        results: vec![result],
        tolerance_um: 10.0
    });
    let name = name.to_owned();
    NamedRun { name, run }
}

#[test]
fn blocks_of_one_line_and_text_are_one_row_with_the_worst_pass_of_each_run() {
    let mut rapid = block(9, "G0 X0", 99.0);
    rapid.rapid = true;
    let all = [
        named(
            "a",
            vec![block(3, "G1 X1", 4.0), block(3, "G1 X1", -6.0), rapid],
        ),
        named(
            "b",
            vec![
                block(5, "G1 X2", -20.0),
                block(3, "G1 X1", 5.0),
                block(3, "G1 X7", 1.0),
            ],
        ),
    ];
    let rows = worst_blocks(&all, 10);
    let shown: Vec<_> = rows
        .iter()
        .map(|row| (row.line.as_str(), row.text.as_str(), row.max_um.as_slice()))
        .collect();
    assert_eq!(
        shown,
        [
            ("5", "G1 X2", &[None, Some(-20.0)][..]),
            ("3", "G1 X1", &[Some(-6.0), Some(5.0)]),
            ("3", "G1 X7", &[None, Some(1.0)]),
        ]
    );
    assert_eq!(worst_blocks(&all, 1).len(), 1);
    assert!(runs(&all, &TextOptions::default()).starts_with("2 runs side by side\n"));
}

#[test]
fn names_are_as_short_as_they_can_be_told_apart() {
    for (names, short) in [
        (&["x/a/s.json", "x/b/s.json"][..], &["a", "b"][..]),
        (&["a.json", "b.json"], &["a.json", "b.json"]),
        (&["a/s.json", "s.json"], &["a", "s.json"]),
        (&["p/q/s.json", "p/s.json"], &["q", "s.json"]),
        (&["only/s.json"], &["only/s.json"]),
    ] {
        assert_eq!(short_names(names), short, "{names:?}");
    }
}

#[test]
fn names_and_texts_that_look_like_markup_do_no_harm_to_the_page() {
    let hostile = "<script>alert(1)</script>";
    let mut run = named(hostile, vec![block(1, hostile, 12.0)]);
    run.run.machine = hostile.to_owned();
    run.run.program.name = hostile.to_owned();
    let page = runs_page(&[run.clone(), run]);
    assert!(!page.contains("<script"), "{page}");
    assert!(page.contains("&lt;script&gt;"));
}
