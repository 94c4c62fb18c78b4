//! Axes of TwinCAT NC: files `.xti` of one axis or a whole NC, and projects `.tsproj` (XML).
//!
//! `Axis` has its name in `Name`; below `AxisPara` are `Velo Maximum` and `Dynamic
//! AccelerationMaximum`, `Acceleration` and `Jerk`, below `EncPara` `SoftEndMinControl` and
//! `SoftEndMaxControl` with `Enable` and `Range`. Attributes that have their usual value are not
//! written, so most files tell little. Seen in files of `_Config/NC/Axes` of
//! <https://github.com/pcdshub/lcls-twincat-motion>; lengths are in the axis' unit, mm or degrees
//! unless the user chose another. Of axes with one letter (`X-Axis`, `X2`) the first is taken: the file
//! does not say which of them move one slide.

use super::draft::{Draft, Fate, Quantity, Told};
use super::{Format, ImportOptions, lettered, number, positive, problem, xml};
use crate::machine::Problem;
use lostmotion_base::AxisId;
use roxmltree::Node;
use std::collections::BTreeMap;

/// The format's row.
pub(super) const FORMAT: Format = Format {
    name: "twincat",
    extensions: &["xti", "tsproj"],
    looks_like: |text| text.contains("<TcSmItem") || text.contains("<TcSmProject"),
    is_lines: false,
    read,
};

/// Most nodes of a description: an axis has some thousand, of its types most.
const MOST_NODES: u32 = 1_000_000;

/// Element and attribute below `Axis`, and what they are. Of two the later one counts.
const LIMITS: &[(&str, &str, Quantity)] = &[
    ("Velo", "Maximum", Quantity::Velocity),
    ("Dynamic", "Acceleration", Quantity::Acceleration),
    ("Dynamic", "AccelerationMaximum", Quantity::Acceleration),
    ("Dynamic", "Jerk", Quantity::Jerk),
    ("SoftEndMinControl", "Range", Quantity::Min),
    ("SoftEndMaxControl", "Range", Quantity::Max),
];

/// Further attributes of an axis that are known and change nothing here.
const KNOWN: &[(&str, &str, &str)] = &[
    (
        "EncPara",
        "ScaleFactorNumerator",
        "the encoder's resolution: the machine file has none",
    ),
    (
        "EncPara",
        "ScaleFactorDenominator",
        "the encoder's resolution: the machine file has none",
    ),
    ("EncPara", "Offset", "of the encoder"),
    (
        "CtrPara",
        "PriorControlFactor",
        "velocity feed-forward of the position loop: see [drive]",
    ),
    ("Analog", "VeloReferenz", "scale of the drive's command"),
];

/// Of a limit in a version that is not known.
const NOT_READ: &str = "not read: compare it with what was taken";

/// Reads the axes.
fn read(text: &str, _: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let document = xml(text, MOST_NODES)?;
    let line = |node: Node<'_, '_>| document.text_pos_at(node.range().start).row as usize;
    let named =
        |node: &Node<'_, '_>, name: &str| node.is_element() && node.tag_name().name() == name;
    let mut draft = Draft::new("TwinCAT NC");
    let mut problems = Vec::new();
    let mut seen = 0;
    // Which name has an axis' letter: two of them would be blended into one axis.
    let mut taken: BTreeMap<AxisId, &str> = BTreeMap::new();
    for node in document.descendants().filter(|node| named(node, "Axis")) {
        seen += 1;
        let name = node.children().find(|child| named(child, "Name"));
        let name = name.and_then(|name| name.text()).unwrap_or_default().trim();
        let Some(axis) = letter(name) else {
            draft.row(
                format!("Axis {name}"),
                "",
                Fate::Ignored,
                "its name tells no axis",
            );
            continue;
        };
        if let Some(first) = taken.get(&axis) {
            let note =
                format!("{axis} is `{first}` already: no second axis and no second motor of it");
            draft.row(format!("Axis {name}"), "", Fate::Ignored, note);
            continue;
        }
        taken.insert(axis, name);
        draft.axis(axis, axis.is_rotary());
        draft.row(
            format!("Axis {name}"),
            "",
            Fate::Used,
            format!("axis {axis}"),
        );
        for part in node.descendants().filter(Node::is_element) {
            let tag = part.tag_name().name();
            if tag.starts_with("SoftEnd") && part.attribute("Enable") != Some("true") {
                if let Some(text) = part.attribute("Range") {
                    draft.row(
                        format!("{axis} {tag} Range"),
                        text,
                        Fate::Ignored,
                        "the end is switched off",
                    );
                }
                continue;
            }
            if let Err(found) = limits(&mut draft, part, axis, line(part)) {
                problems.push(found);
            }
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        let what = format!("{seen} axes, none with a name that tells its letter");
        let hint = "name them X, Y1 or Axis Z in TwinCAT; a file of one axis has the axis' name as its own";
        problems.push(problem(1, "", what, hint));
    }
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

/// The axis that a name tells: a word of one letter, with digits behind it or none.
fn letter(name: &str) -> Option<AxisId> {
    name.split(|c: char| !c.is_alphanumeric())
        .find_map(lettered)
}

/// Takes over what one element of an axis tells.
fn limits(draft: &mut Draft, part: Node<'_, '_>, axis: AxisId, line: usize) -> Result<(), Problem> {
    let tag = part.tag_name().name();
    for (element, attribute, quantity) in LIMITS {
        let Some(text) = part.attribute(*attribute).filter(|_| tag == *element) else {
            continue;
        };
        let from = format!("{axis} {tag} {attribute}");
        let value = if matches!(quantity, Quantity::Min | Quantity::Max) {
            number(line, &from, text)?
        } else {
            positive(line, &from, text)?
        };
        draft.tell(axis, *quantity, Told { value, from, line }, text);
    }
    for attribute in part.attributes() {
        if let Some(why) = why_ignored(part, attribute.name()) {
            draft.row(
                format!("{axis} {tag} {}", attribute.name()),
                attribute.value(),
                Fate::Ignored,
                why,
            );
        }
    }
    Ok(())
}

/// Why an attribute is not taken over; `None` if it is, or is no parameter.
fn why_ignored(part: Node<'_, '_>, attribute: &str) -> Option<&'static str> {
    let tag = part.tag_name().name();
    if LIMITS
        .iter()
        .any(|(element, taken, _)| (*element, *taken) == (tag, attribute))
    {
        return None;
    }
    // In which unit and with which sign has no source here.
    let says = |name: &str| name.to_ascii_lowercase().contains("backlash");
    if says(tag) || says(attribute) {
        return Some(
            "backlash, not carried: as gap_um in the axis' load, with compensation.method",
        );
    }
    if let Some((_, _, why)) = KNOWN
        .iter()
        .find(|(element, known, _)| (*element, *known) == (tag, attribute))
    {
        return Some(why);
    }
    // What else is about limits, in whichever version it is written.
    if tag.starts_with("SoftEnd") {
        return (attribute != "Enable").then_some(NOT_READ);
    }
    if matches!(tag, "Dynamic" | "Velo") {
        return Some(NOT_READ);
    }
    // Parameters stand below AxisPara, EncPara, DrvPara and CtrPara.
    part.ancestors()
        .any(|node| node.tag_name().name().ends_with("Para"))
        .then_some("not read")
}
