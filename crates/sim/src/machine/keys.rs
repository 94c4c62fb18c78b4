//! The keys that machine files may have, found from the reader itself.
//!
//! Names and types come from what the types that are read ask of serde, so that no key can be
//! missing; what is allowed comes from what the reader answers to a value that is far out; defaults
//! are what a machine has where its file says nothing.

use super::gantry::GantryFile;
use super::limits::{LinearLimits, RotaryLimits};
use super::preset::presets;
use super::read::Head;
use super::settings::{Homes, PlannerSettings, Position, SimulateSettings, ToolEntry, WorkOffsets};
use super::{Change, Machine};
use lostmotion_drive::config::Cycles;
use lostmotion_kinematics::{KINDS, KindSpec, KindVisitor, KinematicsSpec};
use lostmotion_methods::AxisConfig;
use serde::de::value::{Error, StrDeserializer};
use serde::de::{
    self, Deserialize, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess,
    SeqAccess, VariantAccess, Visitor,
};
use std::cell::Cell;
use std::collections::BTreeSet;

/// A key of machine files.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct KeyInfo {
    /// With the tables it stands in; `axis.x` stands for any axis, `axis.a.limits` for one that
    /// turns, `tool[]` for any element of a list.
    pub key: String,
    /// What its value is: `number`, `whole number`, `text`, `true or false`, `list of 3 numbers`,
    /// `one of a, b`.
    pub kind: String,
    /// Type and field that it is read into.
    pub field: String,
}

/// Tables below each other that are followed; no machine file has half as many.
const MAX_KEY_DEPTH: usize = 12;

/// Every key that the reader accepts, in the order of the types.
pub fn keys() -> Vec<KeyInfo> {
    let mut all = Vec::new();
    walk::<Head>("", &mut all);
    walk::<Cycles>("cycles", &mut all);
    walk_kinematics(&mut all);
    walk::<PlannerSettings>("planner", &mut all);
    walk::<SimulateSettings>("simulate", &mut all);
    walk::<Position>("start", &mut all);
    walk::<WorkOffsets>("work_offset", &mut all);
    walk::<Homes>("home", &mut all);
    walk::<Vec<ToolEntry>>("tool", &mut all);
    walk::<LinearLimits>("axis.x.limits", &mut all);
    walk::<RotaryLimits>("axis.a.limits", &mut all);
    walk::<AxisConfig>("axis.x", &mut all);
    walk::<GantryFile>("gantry", &mut all);
    // cycles are the machine's, whichever axis is asked
    all.retain(|info| {
        !info.key.starts_with("axis.x.cycles") && !info.key.contains("second.cycles")
    });
    all
}

/// Lists the keys of `[kinematics]`: `kind`, and those of every kind, each once.
fn walk_kinematics(all: &mut Vec<KeyInfo>) {
    struct Walk<'a>(&'a mut Vec<KeyInfo>);
    impl KindVisitor for Walk<'_> {
        type Output = ();

        fn visit<S: KindSpec>(self) {
            walk::<S>("kinematics", self.0);
        }
    }
    let kinds: Vec<&str> = KINDS.iter().map(|info| info.kind).collect();
    let mut found = vec![KeyInfo {
        key: "kinematics.kind".to_owned(),
        kind: format!("one of {}", kinds.join(", ")),
        field: "KindInfo.kind".to_owned(),
    }];
    for kind in kinds {
        // Every name of the table is a kind.
        let _ = KinematicsSpec::visit_kind(kind, Walk(&mut found));
    }
    let mut seen = BTreeSet::new();
    found.retain(|info| seen.insert(info.key.clone()));
    // Keys of the table itself come before those of the tables in it.
    found.sort_by_key(|info| info.key.matches('.').count() > 1);
    all.append(&mut found);
}

/// One step from a type into what it is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Field(&'static str),
    Variant(&'static str),
    Element,
}

/// What a type asks for at the end of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    Fields(&'static str, &'static [&'static str]),
    Variants(&'static str, &'static [&'static str]),
    Unit,
    List(Option<usize>),
    Value(&'static str),
}

/// What a type asks for at the end of a path of steps; `None` if the path leads nowhere.
fn asked<T: for<'de> Deserialize<'de>>(path: &[Step]) -> Option<Asked> {
    let found = Cell::new(None);
    // The type never comes about: reading stops with an error once the end of the path is found.
    let _ = T::deserialize(Probe {
        path,
        found: &found,
    });
    found.get()
}

/// Lists the keys of a type that stands under a key.
fn walk<T: for<'de> Deserialize<'de>>(key: &str, all: &mut Vec<KeyInfo>) {
    descend::<T>(key, &[], "", all);
}

/// Lists the keys of what a path leads to; `field` is the type and field that it is read into.
fn descend<T: for<'de> Deserialize<'de>>(
    key: &str,
    path: &[Step],
    field: &str,
    all: &mut Vec<KeyInfo>,
) {
    // A type that contains itself would never end.
    if path.len() > MAX_KEY_DEPTH {
        return;
    }
    let below = |step: Step| [path, &[step]].concat();
    let info = |kind: String| KeyInfo {
        field: field.to_owned(),
        key: key.to_owned(),
        kind,
    };
    match asked::<T>(path) {
        Some(Asked::Fields(name, fields)) => {
            for inner in fields {
                let key = if key.is_empty() {
                    (*inner).to_owned()
                } else {
                    format!("{key}.{inner}")
                };
                descend::<T>(
                    &key,
                    &below(Step::Field(inner)),
                    &format!("{name}.{inner}"),
                    all,
                );
            }
        }
        Some(Asked::Variants(name, variants)) => {
            // Variants without content are words of one key; the others are tables below it.
            let is_unit = |variant: &&'static str| {
                asked::<T>(&below(Step::Variant(variant))) == Some(Asked::Unit)
            };
            let (units, tables): (Vec<&str>, Vec<&str>) =
                variants.iter().copied().partition(is_unit);
            if !units.is_empty() {
                all.push(info(format!("one of {}", units.join(", "))));
            }
            for variant in tables {
                let key = format!("{key}.{variant}");
                let field = format!("{name}.{variant}");
                descend::<T>(&key, &below(Step::Variant(variant)), &field, all);
            }
        }
        Some(Asked::List(length)) => {
            let element = below(Step::Element);
            let count = length.map_or(String::new(), |length| format!("{length} "));
            match asked::<T>(&element) {
                Some(Asked::Value(kind)) => all.push(info(format!("list of {count}{kind}s"))),
                Some(Asked::List(_)) => all.push(info(format!("list of {count}lists"))),
                _ => descend::<T>(&format!("{key}[]"), &element, field, all),
            }
        }
        Some(Asked::Value(kind)) => all.push(info(kind.to_owned())),
        Some(Asked::Unit) | None => {}
    }
}

/// Units by the ends of keys, longer ones first.
const UNITS: [(&str, &str); 49] = [
    ("_a_s_per_rad", "A s/rad"),
    ("_nm_s_per_rad", "N m s/rad"),
    ("_nm_per_rad", "N m/rad"),
    ("_nm_per_a", "N m/A"),
    ("_n_s_per_mm", "N s/mm"),
    ("_n_s_per_m", "N s/m"),
    ("_n_per_um", "N/um"),
    ("_n_per_m", "N/m"),
    ("_v_per_a", "V/A"),
    ("_counts_per_rev", "1/rev"),
    ("_per_rev", "1/rev"),
    ("_per_rad", "1/rad"),
    ("_per_mm", "1/mm"),
    ("_per_k", "1/K"),
    ("_per_s", "1/s"),
    ("_units_s2", "mm/s2 or deg/s2"),
    ("_units_s", "mm/s or deg/s"),
    ("_mm_s3", "mm/s3"),
    ("_mm_s2", "mm/s2"),
    ("_mm_s", "mm/s"),
    ("_deg_s3", "deg/s3"),
    ("_deg_s2", "deg/s2"),
    ("_deg_s", "deg/s"),
    ("_rad_s2", "rad/s2"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_kgm2", "kg m2"),
    ("_kg", "kg"),
    ("_nm_rad", "N m rad"),
    ("_nm", "N m"),
    ("_arcsec", "arcsec"),
    ("_mdeg", "mdeg"),
    ("_motor_rad", "rad"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_ohm", "ohm"),
    ("_mm", "mm"),
    ("_um", "um"),
    ("_ms", "ms"),
    ("_us", "us"),
    ("_hz", "Hz"),
    ("_rpm", "1/min"),
    ("_m", "m"),
    ("_n", "N"),
    ("_a", "A"),
    ("_v", "V"),
    ("_h", "H"),
    ("_s", "s"),
    ("_k", "K"),
];

/// Machine and axis in which a key is tried out: a linear axis, a rotary one, a gantry.
const TRIAL_AXES: [(&str, &str); 3] = [("vmc3", "x"), ("vmc4", "a"), ("gantry3", "y")];

/// Values beyond any range that a key may have: the refusal tells the range.
const OUT_OF_RANGE_VALUES: [&str; 2] = ["-1e300", "1e300"];

impl KeyInfo {
    /// The unit that the key's name carries; empty for none.
    pub fn unit(&self) -> &'static str {
        let name = self.key.rsplit('.').next().unwrap_or_default();
        // A key may be its unit alone, as `um` is.
        let name = format!("_{name}");
        let found = UNITS.iter().find(|(end, _)| name.ends_with(end));
        found.map_or("", |(_, unit)| unit)
    }

    /// The key in a machine that has an axis of this letter.
    fn of_axis(&self, letter: &str) -> String {
        match self.key.strip_prefix("axis.x.") {
            Some(rest) => format!("axis.{letter}.{rest}"),
            None => self.key.replace("[]", "[0]"),
        }
    }

    /// Which values are allowed, in the words of the reader; `None` if it does not say.
    pub fn allowed(&self) -> Option<String> {
        if self.kind != "number" {
            return None;
        }
        TRIAL_AXES.iter().find_map(|(machine, letter)| {
            let toml = presets()
                .iter()
                .find(|preset| preset.name == *machine)?
                .toml;
            // The reader itself is asked: its refusal names the range.
            OUT_OF_RANGE_VALUES.iter().find_map(|value| {
                let change = Change {
                    key: self.of_axis(letter),
                    value: (*value).to_owned(),
                    name: String::new(),
                };
                let key = change.key.clone();
                let error = Machine::from_changed_toml(machine, toml, &[change]).err()?;
                let problem = error.problems.iter().find(|problem| problem.key == key)?;
                let (_, allowed) = problem.message.split_once("it has to be ")?;
                Some(allowed.to_owned())
            })
        })
    }

    /// The value where a file says nothing; `None` if the key is needed or has no value then.
    pub fn default(&self) -> Option<String> {
        TRIAL_AXES.iter().find_map(|(name, letter)| {
            let preset = presets().iter().find(|preset| preset.name == *name)?;
            let file: toml::Table = toml::from_str(preset.toml).ok()?;
            let key = self.of_axis(letter);
            // A value that the file sets is not a default.
            if stands_in(&file, &key) {
                return None;
            }
            let machine = Machine::preset(name).ok()?;
            let text = match key.strip_prefix(&format!("axis.{letter}.")) {
                Some(rest) => debug_value(&format!("{:?}", machine.drive(letter)?), rest),
                None => debug_value(&format!("{:?}", machine.general), &key),
            }?;
            self.in_words(&text)
        })
    }

    /// A value of a type's Debug form as a file has it.
    fn in_words(&self, text: &str) -> Option<String> {
        // Debug spells variants as the code does, files in a case of their own.
        let plain = |word: &str| word.to_lowercase().replace(['-', '_'], "");
        match self.kind.strip_prefix("one of ") {
            Some(names) => names
                .split(", ")
                .find(|name| plain(name) == plain(text))
                .map(str::to_owned),
            None if text.starts_with("Some(") || text == "None" || text.contains('{') => None,
            None => Some(text.to_owned()),
        }
    }
}

/// Whether a file has a key.
fn stands_in(file: &toml::Table, key: &str) -> bool {
    let mut parts = key.split('.');
    let Some(mut value) = parts.next().and_then(|part| file.get(part)) else {
        return false;
    };
    for part in parts {
        match value.get(part) {
            Some(inner) => value = inner,
            None => return false,
        }
    }
    true
}

/// The value at a dotted path in the Debug form of a type made of structs and enums.
fn debug_value(text: &str, path: &str) -> Option<String> {
    let mut text = text;
    for part in path.split('.') {
        // One level of braces a part of the path.
        text = fields(text).find_map(|field| {
            let (name, value) = field.split_once(": ")?;
            (name.trim() == part).then_some(value)
        })?;
    }
    Some(text.trim().trim_matches('"').to_owned())
}

/// The fields between the outermost braces of a Debug form.
fn fields(text: &str) -> impl Iterator<Item = &str> {
    let inner = text
        .split_once('{')
        .and_then(|(_, rest)| rest.rsplit_once('}'))
        .map_or("", |(inner, _)| inner);
    let mut depth = 0_i32;
    inner.split(move |c: char| {
        match c {
            '{' | '(' | '[' => depth += 1,
            '}' | ')' | ']' => depth -= 1,
            _ => {}
        }
        // Commas within braces belong to an inner value.
        c == ',' && depth == 0
    })
}

/// Follows a path into a type, and notes what it asks for at the end.
#[derive(Clone, Copy)]
struct Probe<'p> {
    path: &'p [Step],
    found: &'p Cell<Option<Asked>>,
}

impl<'p> Probe<'p> {
    /// The first step and the probe behind it; at the end of the path what is asked is noted.
    fn step(self, asked: Asked) -> Result<(Step, Probe<'p>), Error> {
        match self.path.split_first() {
            Some((step, path)) => Ok((*step, Probe { path, ..self })),
            None => Err(self.end(asked)),
        }
    }

    fn end(self, asked: Asked) -> Error {
        if self.path.is_empty() && self.found.get().is_none() {
            self.found.set(Some(asked));
        }
        de::Error::custom("the end of the path")
    }
}

macro_rules! values {
    ($($method:ident: $kind:literal,)*) => {
        $(fn $method<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Error> {
            Err(self.end(Asked::Value($kind)))
        })*
    };
}

impl<'de> Deserializer<'de> for Probe<'_> {
    type Error = Error;

    values! {
        deserialize_any: "value",
        deserialize_bool: "true or false",
        deserialize_i8: "whole number",
        deserialize_i16: "whole number",
        deserialize_i32: "whole number",
        deserialize_i64: "whole number",
        deserialize_u8: "whole number",
        deserialize_u16: "whole number",
        deserialize_u32: "whole number",
        deserialize_u64: "whole number",
        deserialize_f32: "number",
        deserialize_f64: "number",
        deserialize_char: "letter",
        deserialize_str: "text",
        deserialize_string: "text",
        deserialize_bytes: "text",
        deserialize_byte_buf: "text",
        deserialize_unit: "value",
        deserialize_map: "table",
        deserialize_identifier: "text",
        deserialize_ignored_any: "value",
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _visitor: V,
    ) -> Result<V::Value, Error> {
        Err(self.end(Asked::Unit))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let (_, behind) = self.step(Asked::List(None))?;
        visitor.visit_seq(Only(behind))
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        let (_, behind) = self.step(Asked::List(Some(length)))?;
        visitor.visit_seq(Only(behind))
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let (step, behind) = self.step(Asked::Fields(name, fields))?;
        visitor.visit_map(OneField(Some(step), behind))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let (step, behind) = self.step(Asked::Variants(name, variants))?;
        visitor.visit_enum(OneVariant(step, name, behind))
    }
}

/// A list whose first element is looked at.
struct Only<'p>(Probe<'p>);

impl<'de> SeqAccess<'de> for Only<'_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        seed.deserialize(self.0).map(Some)
    }
}

/// A table of which one field is looked at.
struct OneField<'p>(Option<Step>, Probe<'p>);

impl<'de> MapAccess<'de> for OneField<'_> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Error> {
        match self.0.take() {
            Some(Step::Field(name)) => {
                let name: StrDeserializer<'_, Error> = name.into_deserializer();
                seed.deserialize(name).map(Some)
            }
            _ => Ok(None),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Error> {
        seed.deserialize(self.1)
    }
}

/// An enum of which one variant is looked at.
struct OneVariant<'p>(Step, &'static str, Probe<'p>);

impl<'de, 'p> EnumAccess<'de> for OneVariant<'p> {
    type Error = Error;
    type Variant = OneVariant<'p>;

    fn variant_seed<V: DeserializeSeed<'de>>(
        self,
        seed: V,
    ) -> Result<(V::Value, OneVariant<'p>), Error> {
        let Step::Variant(name) = self.0 else {
            return Err(de::Error::custom("the path does not lead into a variant"));
        };
        let name: StrDeserializer<'_, Error> = name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for OneVariant<'_> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Err(self.2.end(Asked::Unit))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Error> {
        seed.deserialize(self.2)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Error> {
        self.2.deserialize_tuple(length, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.2.deserialize_struct(self.1, fields, visitor)
    }
}
