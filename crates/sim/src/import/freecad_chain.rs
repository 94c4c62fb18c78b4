//! Where FreeCAD's axes sit: `role` says on which side (`table_...`, `head_...`), `parent` what
//! carries it, `joint` a point on the axis and its direction, as two lists or as `origin` and `axis`.

use lostmotion_base::AxisId;
use lostmotion_kinematics::chain::{JointSpec, Side};
use serde_json::{Map, Value};

/// An axis and what the file says of its place.
#[derive(Clone, Debug)]
pub(super) struct Place {
    id: AxisId,
    rotary: bool,
    side: Option<Side>,
    parent: Option<String>,
    /// A point and a direction.
    joint: Option<[[f64; 3]; 2]>,
}

impl Place {
    /// What an axis tells; the key that cannot be read and why.
    pub(super) fn of(
        id: AxisId,
        rotary: bool,
        axis: &Map<String, Value>,
    ) -> Result<Place, (&'static str, String)> {
        let joint = axis
            .get("joint")
            .filter(|joint| !joint.is_null())
            .map(|joint| vectors(joint).ok_or(("joint", format!("is {joint}, not two vectors"))));
        let joint = match joint.transpose()? {
            // A linear axis passes through no point of its own; early files have its direction
            // first.
            Some([direction, [0.0, 0.0, 0.0]]) if !rotary => Some([[0.0; 3], direction]),
            Some([_, [0.0, 0.0, 0.0]]) => return Err(("joint", "has no direction".into())),
            joint => joint,
        };
        let role = axis.get("role").and_then(Value::as_str).unwrap_or_default();
        let side = match role.split('_').next() {
            Some("table") => Some(Side::Table),
            Some("head") => Some(Side::Head),
            _ => None,
        };
        Ok(Place {
            id,
            rotary,
            side,
            parent: axis
                .get("parent")
                .and_then(Value::as_str)
                .map(str::to_owned),
            joint,
        })
    }

    /// How many axes carry it.
    fn depth(&self, all: &[Place]) -> usize {
        let (mut depth, mut at) = (0, self);
        while let Some(parent) = at.parent.as_ref().and_then(|name| {
            all.iter()
                .find(|place| name.starts_with(place.id.letter()) && name.len() == 1)
        }) {
            depth += 1;
            // Axes that name each other as parents would go round for ever.
            if depth > all.len() {
                break;
            }
            at = parent;
        }
        depth
    }

    fn spec(&self, side: Side, [point, direction]: [[f64; 3]; 2]) -> JointSpec {
        if self.rotary {
            return JointSpec::rotary(self.id, side, direction, point);
        }
        JointSpec {
            side: Some(side),
            ..JointSpec::linear(self.id, direction)
        }
    }
}

fn vectors(value: &Value) -> Option<[[f64; 3]; 2]> {
    let vector = |value: &Value| {
        let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
        <[f64; 3]>::try_from(numbers?).ok()
    };
    // FreeCAD writes both forms: two lists, and an object of the two by name.
    let pair = match value {
        Value::Object(named) => [named.get("origin")?, named.get("axis")?]
            .into_iter()
            .map(vector)
            .collect(),
        _ => value
            .as_array()?
            .iter()
            .map(vector)
            .collect::<Option<Vec<_>>>(),
    };
    <[[f64; 3]; 2]>::try_from(pair?).ok()
}

/// Joints from the workpiece to the tool: on the table what is carried comes before what carries
/// it, on the head after; linear axes are nearer to the base where the file does not say.
pub(super) fn chain(places: &[Place]) -> Result<Vec<JointSpec>, String> {
    let mut out = Vec::new();
    for side in [Side::Table, Side::Head] {
        let mut own = Vec::new();
        for place in places {
            match (place.side, place.joint) {
                (Some(told), Some(joint)) if told == side => {
                    own.push((place.depth(places), place, joint));
                }
                (Some(_), Some(_)) => {}
                _ => {
                    return Err(format!(
                        "where axis {} sits is not told in full (`role`, `joint`)",
                        place.id
                    ));
                }
            }
        }
        // From the base outwards: what more axes carry comes later, rotary after linear.
        own.sort_by_key(|(depth, place, _)| (*depth, place.rotary));
        if let Some(pair) = own
            .windows(2)
            .find(|pair| pair[0].1.rotary && pair[1].1.rotary && pair[0].0 == pair[1].0)
        {
            return Err(format!(
                "which of {} and {} carries the other is not told (`parent`)",
                pair[0].1.id, pair[1].1.id
            ));
        }
        // A chain goes from the workpiece, which the table's outermost axis carries.
        if side == Side::Table {
            own.reverse();
        }
        out.extend(
            own.into_iter()
                .map(|(_, place, joint)| place.spec(side, joint)),
        );
    }
    Ok(out)
}
