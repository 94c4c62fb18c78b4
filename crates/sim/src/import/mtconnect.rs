//! MTConnect's device description (XML): which axes there are, and of agents of version 1.7 and
//! later their limits.
//!
//! `Linear` and `Rotary` below `Axes`, by their `name` or `nativeName`; a `Rotary` that is a spindle
//! is none. `Specification` (and `Constraints` of a `DataItem`) of POSITION and AXIS_FEEDRATE or
//! VELOCITY with `Maximum` and `Minimum`, in `units`. Names are compared without namespace, which
//! changes with every version. See <https://docs.mtconnect.org>.

use super::draft::{Draft, Fate, Quantity, Told};
use super::{Format, ImportOptions, lettered, number, positive, problem, xml};
use crate::machine::Problem;
use lostmotion_base::AxisId;
use roxmltree::Node;

/// The format's row. Its files are named .xml, as many are.
pub(super) const FORMAT: Format = Format {
    name: "mtconnect",
    extensions: &[],
    looks_like: |text| text.contains("MTConnectDevices"),
    is_lines: false,
    read,
};

/// Most nodes of a description: devices have some thousand.
const MOST_NODES: u32 = 20_000;

/// Reads the description.
fn read(text: &str, _: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let document = xml(text, MOST_NODES)?;
    let mut draft = Draft::new("MTConnect");
    let mut problems = Vec::new();
    let line = |node: Node<'_, '_>| document.text_pos_at(node.range().start).row as usize;
    let mut devices = document
        .descendants()
        .filter(|node| node.has_tag_name_of("Device"));
    let Some(device) = devices.next() else {
        return Err(vec![problem(1, "", "there is no Device", "")]);
    };
    if let Some(name) = device.attribute("name") {
        name.clone_into(&mut draft.name);
        draft.row("Device name", name, Fate::Used, "general");
    }
    for other in devices {
        let name = other.attribute("name").unwrap_or_default();
        draft.row(
            "Device",
            name,
            Fate::Ignored,
            "a further device: the first counts",
        );
    }
    for node in device.descendants() {
        let turns = match node.tag_name().name() {
            "Linear" => false,
            "Rotary" => true,
            _ => continue,
        };
        let kind = node.tag_name().name();
        let name = node.attribute("name").unwrap_or_default();
        // X1 is X; Xerror is no axis.
        let axis = lettered(name).or_else(|| node.attribute("nativeName").and_then(lettered));
        let is_spindle = node.descendants().any(|item| {
            item.has_tag_name_of("Value") && item.text().map(str::trim) == Some("SPINDLE")
        });
        match axis.filter(|axis| axis.is_rotary() == turns && !is_spindle) {
            Some(axis) => {
                draft.axis(axis, turns);
                draft.row(
                    format!("{kind} {name}"),
                    "",
                    Fate::Used,
                    format!("axis {axis}"),
                );
                if let Err(found) = limits(&mut draft, node, axis, &line) {
                    problems.push(found);
                }
            }
            None => {
                let why = if is_spindle {
                    "a spindle"
                } else {
                    "its name is no axis of its kind"
                };
                draft.row(format!("{kind} {name}"), "", Fate::Ignored, why);
            }
        }
    }
    if draft.axes.is_empty() && problems.is_empty() {
        problems.push(problem(
            1,
            "",
            "there is no Linear or Rotary with the name of an axis",
            "",
        ));
    }
    if problems.is_empty() {
        Ok(draft)
    } else {
        Err(problems)
    }
}

/// A node by its name without namespace.
trait LocalName {
    fn has_tag_name_of(&self, name: &str) -> bool;
}

impl LocalName for Node<'_, '_> {
    fn has_tag_name_of(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

/// What an axis' items say of travel and speed.
fn limits(
    draft: &mut Draft,
    component: Node<'_, '_>,
    axis: AxisId,
    line: &dyn Fn(Node<'_, '_>) -> usize,
) -> Result<(), Problem> {
    for item in component.descendants() {
        let tag = item.tag_name().name();
        if tag != "Specification" && tag != "DataItem" {
            continue;
        }
        let kind = item.attribute("type").unwrap_or_default();
        let speed = matches!(kind, "AXIS_FEEDRATE" | "VELOCITY");
        if kind != "POSITION" && kind != "ANGLE" && !speed {
            continue;
        }
        let units = item.attribute("units").unwrap_or_default();
        for end in item.descendants() {
            let quantity = match (end.tag_name().name(), speed) {
                ("Maximum", true) => Quantity::Velocity,
                ("Maximum", false) => Quantity::Max,
                ("Minimum", false) => Quantity::Min,
                _ => continue,
            };
            let text = end.text().unwrap_or_default().trim();
            let name = format!("{tag} {kind} {}", end.tag_name().name());
            let key = format!("{axis} {name}");
            let value = if speed {
                positive(line(end), &key, text)?
            } else {
                number(line(end), &key, text)?
            };
            let factor = match units {
                "MILLIMETER" | "MILLIMETER/SECOND" | "DEGREE" | "DEGREE/SECOND" | "" => 1.0,
                "INCH" | "INCH/SECOND" => 25.4,
                "METER" | "METER/SECOND" => 1e3,
                other => {
                    let message = format!("unit `{other}` is not known here");
                    return Err(problem(
                        line(item),
                        &key,
                        message,
                        "MILLIMETER, DEGREE, per SECOND",
                    ));
                }
            };
            let told = Told {
                value: value * factor,
                from: key,
                line: line(end),
            };
            draft.tell(axis, quantity, told, text);
        }
    }
    Ok(())
}
