//! Blocks of motions.

use super::word::{axes, changed, word};
use lostmotion_gcode::ops::{ArcFeed, CanonicalOp, NurbsFeed};
use lostmotion_gcode::state::State;

/// A straight move, an arc or a probing move, without its feed.
pub(super) fn motion(op: &CanonicalOp, state: &State) -> Option<String> {
    Some(match op {
        CanonicalOp::StraightTraverse(end) => format!("G0 {}", axes(&state.current, end)),
        CanonicalOp::StraightFeed(end) => format!("G1 {}", axes(&state.current, end)),
        CanonicalOp::ArcFeed(feed) => arc(feed, state),
        CanonicalOp::StraightProbe(probe) => {
            let code = match (probe.away, probe.must) {
                (false, true) => "G38.2",
                (false, false) => "G38.3",
                (true, true) => "G38.4",
                (true, false) => "G38.5",
            };
            format!("{code} {}", axes(&state.current, &probe.end))
        }
        _ => return None,
    })
}

fn arc(arc: &ArcFeed, state: &State) -> String {
    let [first, second, _] = arc.plane.axes();
    let letter = |axis: usize| ['I', 'J', 'K'].get(axis).copied().unwrap_or('I');
    let start = [state.current[first], state.current[second]];
    let offsets = [
        offset(start[0], arc.center[0]),
        offset(start[1], arc.center[1]),
    ];
    let (mode, center) = match offsets {
        [Some(one), Some(two)] => (if state.arc_absolute { "G91.1 " } else { "" }, [one, two]),
        _ => (if state.arc_absolute { "" } else { "G90.1 " }, arc.center),
    };
    let code = if arc.turns < 0 { "G2" } else { "G3" };
    let end = changed(&state.current, &arc.position());
    let end = if end.is_empty() {
        end
    } else {
        format!("{end} ")
    };
    let turns = if arc.turns.abs() > 1 {
        format!(" P{}", arc.turns.abs())
    } else {
        String::new()
    };
    format!(
        "{mode}{code} {end}{} {}{turns}",
        word(letter(first), center[0]),
        word(letter(second), center[1])
    )
}

/// The shortest offset that leads from a start to a centre exactly, if there is one.
fn offset(start: f64, center: f64) -> Option<f64> {
    let exact = center - start;
    let leads = |offset: &f64| (start + offset).to_bits() == center.to_bits();
    let rounded = (0..=12)
        .filter_map(|decimals| format!("{exact:.decimals$}").parse::<f64>().ok())
        .map(|offset| offset + 0.0);
    rounded
        .chain([exact, exact.next_up(), exact.next_down()])
        .find(leads)
}

/// A NURBS block by block.
pub(super) fn curve(curve: &NurbsFeed) -> Option<String> {
    let (first, rest) = curve.points.split_first()?;
    let mut text = format!("G5.2 P{} L{}\n", first.weight, curve.order);
    for point in rest {
        text.push_str(&format!(
            "G5.2 X{} Y{} P{}\n",
            point.at[0], point.at[1], point.weight
        ));
    }
    text.push_str("G5.3");
    Some(text)
}
