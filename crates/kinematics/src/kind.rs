//! What a kind of machine has to say of itself, and ways to use a kind whose name is known only at
//! run time.

use crate::{Kinematics, KinematicsError, KinematicsSpec, Reach};
use lostmotion_base::AxisId;
use serde::de::value::Error;
use serde::de::{DeserializeOwned, Deserializer, Error as _, Visitor};
use serde::{Deserialize, Serialize};
use std::cell::Cell;

/// The description of a machine of one kind: its fields are the keys of `[kinematics]` in a machine
/// file. A kind is one file that implements this and one line in `kinds!` of `lib.rs`.
pub trait KindSpec: DeserializeOwned + Into<KinematicsSpec> {
    /// The kind in one line, for lists.
    const SUMMARY: &'static str;

    /// The kinematics. `reach` is the travel of the joints, which the choice among several solutions
    /// keeps.
    ///
    /// # Errors
    /// Measures that no machine can have: key, value, and what is allowed.
    fn build(&self, reach: &Reach) -> Result<Box<dyn Kinematics>, String>;

    /// When X Y Z are the tool's tip.
    fn tip_control(&self) -> TipControl {
        TipControl::Always
    }

    /// Whether the joint of a letter is rotary.
    fn is_rotary(&self, joint: AxisId) -> bool {
        joint.is_rotary()
    }
}

/// A registered kind of machine.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct KindInfo {
    /// What kind of machine it is; the other keys of the table depend on it.
    pub kind: &'static str,
    /// The kind in one line.
    pub summary: &'static str,
    pub(crate) keys: fn() -> &'static [&'static str],
}

impl KindInfo {
    /// Keys of the kind in a machine file, besides `kind`.
    ///
    /// ```
    /// use lostmotion_kinematics::KINDS;
    ///
    /// let delta = KINDS.iter().find(|info| info.kind == "delta").ok_or("no delta")?;
    /// assert_eq!(delta.keys(), ["tower_radius_mm", "rod_mm", "tower_angles_deg"]);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn keys(&self) -> &'static [&'static str] {
        (self.keys)()
    }
}

/// Work on the type that describes a kind, for [`KinematicsSpec::visit_kind`].
pub trait KindVisitor {
    /// The result.
    type Output;

    /// Called with the type of the kind.
    fn visit<S: KindSpec>(self) -> Self::Output;
}

/// When X Y Z are the tool's tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TipControl {
    /// Always, as LinuxCNC's five-axis kinematics do; G43.4 is the tool's length then.
    #[default]
    Always,
    /// From G43.4 or G43.5 to G49, and in a plane that G53.1 has turned to; else X Y Z are the
    /// linear joints.
    Programmed,
}

/// Builds the kinematics that a machine file describes, for joints of any travel.
///
/// # Errors
/// Measures that no machine can have.
pub fn build(spec: &KinematicsSpec) -> Result<Box<dyn Kinematics>, KinematicsError> {
    build_within(spec, &Reach::default())
}

/// Builds the kinematics for joints with a travel, which the choice among several solutions keeps.
///
/// # Errors
/// As [`build`].
pub fn build_within(
    spec: &KinematicsSpec,
    reach: &Reach,
) -> Result<Box<dyn Kinematics>, KinematicsError> {
    spec.build_kind(reach)
        .map_err(|why| KinematicsError::Description {
            kind: spec.kind().to_owned(),
            why,
        })
}

/// Refuses numbers that are not finite.
pub(crate) fn finite(key: &str, values: &[f64]) -> Result<(), String> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("`{key}` is {value}; it has to be finite")),
        None => Ok(()),
    }
}

/// The names of a struct's fields in files.
pub(crate) fn keys_of<S: DeserializeOwned>() -> &'static [&'static str] {
    let found = Cell::new(&[][..]);
    // serde hands the names to the deserializer before it asks for a value; reading ends there.
    let _ = S::deserialize(FieldNames(&found));
    found.get()
}

/// Notes the names of the fields that a struct asks for.
struct FieldNames<'f>(&'f Cell<&'static [&'static str]>);

impl<'de> Deserializer<'de> for FieldNames<'_> {
    type Error = Error;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, Error> {
        self.0.set(fields);
        Err(Error::custom("the names are known"))
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Error> {
        Err(Error::custom("only structs have keys"))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}
