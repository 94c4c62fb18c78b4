//! Bounds that keep any input from taking unbounded time or memory.

use serde::{Deserialize, Serialize};

/// What a program may use. Every bound is settable; exceeding one is an error that names it.
///
/// ```
/// use lostmotion_gcode::{InterpreterConfig, Limits, Program};
///
/// let mut limits = Limits::default();
/// limits.set("line_bytes", "20")?;
/// let config = InterpreterConfig { limits, ..InterpreterConfig::default() };
/// let found = Program::new(&b"G1 X10 (a comment that is too long) F200\nM2\n"[..], config).finish();
/// assert_eq!(found.kept()[0].problem.limit(), Some("line_bytes"));
/// # Ok::<(), lostmotion_gcode::LimitError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Bytes of one line.
    pub line_bytes: usize,
    /// Bytes of the whole source.
    pub source_bytes: u64,
    /// Words on one line.
    pub words: usize,
    /// Nesting of brackets, signs and `#` in one value.
    pub expression_depth: usize,
    /// Executed blocks, repetitions counted.
    pub executed_blocks: u64,
    /// Executed blocks without reading a further line: what loops and subroutines may do at a
    /// stretch.
    pub looped_blocks: u64,
    /// Operations that they may make at a stretch: a canned cycle can make many with one block.
    pub looped_operations: u64,
    /// Of those, blocks in a row that neither move nor dwell.
    pub idle_blocks: u64,
    /// Nesting of subroutine calls.
    pub call_depth: usize,
    /// Branches and loops open at once.
    pub open_structures: usize,
    /// Bytes of source held for loops and subroutines.
    /// Every line counts 32 bytes more than it has, every subroutine 256.
    pub held_bytes: usize,
    /// Largest absolute coordinate, in mm or degrees.
    pub coordinate: f64,
    /// Largest radius of an arc, in mm.
    pub radius_mm: f64,
    /// Largest feed rate, in mm or degrees per minute (or per revolution).
    pub feed: f64,
    /// Largest dwell in seconds.
    pub dwell_s: f64,
    /// Moves that one canned cycle block may make.
    pub cycle_moves: u32,
    /// Control points of one curve.
    pub curve_points: usize,
    /// Diagnostics kept; the others are only counted.
    pub diagnostics: usize,
    /// Named parameters alive at once.
    pub named_parameters: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            line_bytes: 65_536,
            source_bytes: 1 << 40,
            words: 64,
            expression_depth: 64,
            executed_blocks: 1_000_000_000,
            looped_blocks: 2_500_000,
            looped_operations: 2_500_000,
            idle_blocks: 1_000_000,
            call_depth: 30,
            open_structures: 1000,
            held_bytes: 64 << 20,
            coordinate: 1e9,
            radius_mm: 1e9,
            feed: 1e9,
            dwell_s: 1e6,
            cycle_moves: 1_000_000,
            curve_points: 100_000,
            diagnostics: 100,
            named_parameters: 10_000,
        }
    }
}

/// One limit.
#[derive(Clone, Copy)]
pub struct LimitRow {
    /// Name of the field.
    pub name: &'static str,
    /// What it bounds, with its unit.
    pub meaning: &'static str,
    whole: bool,
    get: fn(&Limits) -> f64,
    set: fn(&mut Limits, f64),
}

impl LimitRow {
    /// Its value; whole numbers beyond 2^53 are rounded.
    pub fn value(&self, limits: &Limits) -> f64 {
        (self.get)(limits)
    }
}

impl std::fmt::Debug for LimitRow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.name, self.meaning)
    }
}

/// Why a limit cannot be set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LimitError {
    /// No limit of that name.
    #[error("there is no limit `{name}`; known are {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// Not a value for it.
    #[error("the limit `{name}` is `{value}`; it has to be {condition}")]
    Value {
        /// The limit.
        name: &'static str,
        /// What was given.
        value: String,
        /// What it has to be.
        condition: &'static str,
    },
}

macro_rules! whole {
    ($field:ident, $type:ty, $meaning:literal) => {
        LimitRow {
            name: stringify!($field),
            meaning: $meaning,
            whole: true,
            get: |limits| limits.$field as f64,
            set: |limits, value| limits.$field = value as $type,
        }
    };
}

macro_rules! real {
    ($field:ident, $meaning:literal) => {
        LimitRow {
            name: stringify!($field),
            meaning: $meaning,
            whole: false,
            get: |limits| limits.$field,
            set: |limits, value| limits.$field = value,
        }
    };
}

const ROWS: [LimitRow; 19] = [
    whole!(line_bytes, usize, "bytes of one line"),
    whole!(source_bytes, u64, "bytes of the whole source"),
    whole!(words, usize, "words on one line"),
    whole!(
        expression_depth,
        usize,
        "nesting of brackets, signs and # in one value"
    ),
    whole!(executed_blocks, u64, "executed blocks, repetitions counted"),
    whole!(
        looped_blocks,
        u64,
        "executed blocks without reading a further line"
    ),
    whole!(
        looped_operations,
        u64,
        "operations made without reading a further line"
    ),
    whole!(
        idle_blocks,
        u64,
        "executed blocks in a row that neither move nor dwell, without reading a further line"
    ),
    whole!(call_depth, usize, "nesting of subroutine calls"),
    whole!(open_structures, usize, "branches and loops open at once"),
    whole!(
        held_bytes,
        usize,
        "bytes of source held for loops and subroutines"
    ),
    real!(coordinate, "largest coordinate, mm or degrees"),
    real!(radius_mm, "largest radius of an arc, mm"),
    real!(feed, "largest feed rate, mm or degrees per minute"),
    real!(dwell_s, "largest dwell, s"),
    whole!(cycle_moves, u32, "moves of one canned cycle block"),
    whole!(curve_points, usize, "control points of one curve"),
    whole!(
        diagnostics,
        usize,
        "diagnostics kept; the others are counted"
    ),
    whole!(named_parameters, usize, "named parameters alive at once"),
];

impl Limits {
    /// All limits.
    pub const fn rows() -> &'static [LimitRow] {
        &ROWS
    }

    /// Sets a limit by its name. Values are decimal numbers, `1e6` included.
    ///
    /// # Errors
    /// No such limit, or not a number that it can have.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), LimitError> {
        // An unknown name is answered with all known ones.
        let Some(row) = ROWS.iter().find(|row| row.name == name) else {
            let known = ROWS
                .iter()
                .map(|row| row.name)
                .collect::<Vec<_>>()
                .join(", ");
            return Err(LimitError::Unknown {
                name: name.to_owned(),
                known,
            });
        };
        let condition = if row.whole {
            "a whole number from 1"
        } else {
            "a positive number"
        };
        // Whole numbers up to 9e15 are exact in an f64.
        let highest = if row.whole { 9e15 } else { f64::MAX };
        let number = value.parse::<f64>().ok().filter(|number| {
            *number > 0.0 && *number <= highest && (!row.whole || number.fract() == 0.0)
        });
        let number = number.ok_or_else(|| LimitError::Value {
            name: row.name,
            value: value.to_owned(),
            condition,
        })?;
        (row.set)(self, number);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_has_a_row_that_sets_it() {
        let expected = fields();
        let rows: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
        assert_eq!(rows, expected);
        for row in &ROWS {
            let mut limits = Limits::default();
            limits.set(row.name, "7").unwrap();
            assert_eq!(row.value(&limits), 7.0, "{}", row.name);
            assert!(limits.set(row.name, "0").is_err());
            assert!(limits.set(row.name, "NaN").is_err());
            assert!(limits.set(row.name, "-1").is_err());
        }
        assert_eq!(
            Limits::default()
                .set("words", "abc")
                .unwrap_err()
                .to_string(),
            "the limit `words` is `abc`; it has to be a whole number from 1"
        );
        assert!(matches!(
            Limits::default().set("words", "1.5"),
            Err(LimitError::Value { .. })
        ));
        assert!(matches!(
            Limits::default().set("word", "1"),
            Err(LimitError::Unknown { .. })
        ));
    }

    /// The fields of the struct in their order, from its debug text.
    fn fields() -> Vec<String> {
        let text = format!("{:?}", Limits::default());
        let inside = text.split_once('{').unwrap().1;
        inside
            .split(',')
            .map(|field| field.split(':').next().unwrap().trim().to_owned())
            .collect()
    }
}
