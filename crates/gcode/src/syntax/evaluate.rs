//! Running the postfix code of a value.

use super::block::{Binary, Block, Op, Unary, Value};
use crate::problem::Problem;
use lostmotion_base::math;
use lostmotion_base::units::{deg, rad};

/// Largest difference of numbers that EQ takes for equal. Published: LinuxCNC.
const EQUALITY_TOLERANCE: f64 = 1e-5;

/// What expressions read.
pub(crate) trait Lookup {
    /// The value of a numbered parameter; NaN for one that is vacant.
    fn numbered(&mut self, number: f64) -> Result<f64, Problem>;
    /// Whether there is a parameter of that number.
    fn numbered_exists(&self, number: f64) -> bool;
    /// The value of a named parameter; `None` if it does not exist.
    fn named(&self, name: &[u8]) -> Option<f64>;
}

/// The value of a word, setting or argument; NaN if it is a vacant parameter alone. `stack` is
/// scratch.
pub(crate) fn evaluate(
    block: &Block,
    value: Value,
    lookup: &mut impl Lookup,
    stack: &mut Vec<f64>,
) -> Result<f64, Problem> {
    // Literals need no stack.
    let (from, to) = match value {
        Value::Number(number) => return Ok(number),
        Value::Ops(from, to) => (from as usize, to as usize),
    };
    stack.clear();
    for op in block.ops.get(from..to).unwrap_or_default() {
        step(block, *op, lookup, stack)?;
    }
    Ok(pop(stack))
}

/// What a value counts for where it is computed with: 0 if it is vacant.
pub(crate) const fn valued(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}

fn pop(stack: &mut Vec<f64>) -> f64 {
    stack.pop().unwrap_or(f64::NAN)
}

fn finite(value: f64) -> Result<f64, Problem> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Problem::NotFinite)
    }
}

fn step(
    block: &Block,
    op: Op,
    lookup: &mut impl Lookup,
    stack: &mut Vec<f64>,
) -> Result<(), Problem> {
    let result = match op {
        Op::Push(number) => number,
        Op::Parameter => {
            // The only value that may be vacant.
            let value = lookup.numbered(valued(pop(stack)))?;
            stack.push(value);
            return Ok(());
        }
        Op::Named(text) => {
            let name = block.name(text);
            lookup.named(name).ok_or_else(|| unknown(name))?
        }
        Op::Exists(text) => truth(lookup.named(block.name(text)).is_some()),
        Op::ExistsNumber => truth(lookup.numbered_exists(valued(pop(stack)))),
        Op::Negate => -valued(pop(stack)),
        Op::Unary(function) => unary(function, valued(pop(stack)))?,
        Op::Atan => {
            // ATAN[y]/[x]: x was pushed last.
            let x = valued(pop(stack));
            deg(math::atan2(valued(pop(stack)), x))
        }
        Op::Binary(operator) => {
            // The right operand was pushed last.
            let right = pop(stack);
            let left = pop(stack);
            match operator {
                // What is vacant equals only what is vacant, not 0.
                Binary::Equal if left.is_nan() || right.is_nan() => {
                    truth(left.is_nan() && right.is_nan())
                }
                Binary::NotEqual if left.is_nan() || right.is_nan() => {
                    truth(left.is_nan() != right.is_nan())
                }
                _ => binary(operator, valued(left), valued(right))?,
            }
        }
    };
    stack.push(finite(result)?);
    Ok(())
}

/// A name without a value; those of the machine's HAL and INI file are told, not set.
#[cold]
fn unknown(name: &[u8]) -> Problem {
    let outside = name.starts_with(b"_hal[") || name.starts_with(b"_ini[");
    let name = String::from_utf8_lossy(name).into_owned();
    if outside {
        Problem::HalValue { name }
    } else {
        Problem::UnknownParameter { name, near: None }
    }
}

fn truth(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

fn unary(function: Unary, x: f64) -> Result<f64, Problem> {
    let outside = |what| Err(Problem::Domain { what, value: x });
    Ok(match function {
        Unary::Acos if x.abs() > 1.0 => return outside("ACOS"),
        Unary::Asin if x.abs() > 1.0 => return outside("ASIN"),
        Unary::Ln if x <= 0.0 => return outside("LN"),
        Unary::Sqrt if x < 0.0 => return outside("SQRT"),
        Unary::Abs => x.abs(),
        Unary::Acos => deg(math::acos(x)),
        Unary::Asin => deg(math::asin(x)),
        Unary::Cos => math::cos(rad(x)),
        Unary::Exp => math::exp(x),
        Unary::Fix => x.floor(),
        Unary::Fup => x.ceil(),
        Unary::Ln => math::log(x),
        Unary::Round => x.round(),
        Unary::Sin => math::sin(rad(x)),
        Unary::Sqrt => x.sqrt(),
        Unary::Tan => math::tan(rad(x)),
    })
}

fn binary(operator: Binary, left: f64, right: f64) -> Result<f64, Problem> {
    Ok(match operator {
        Binary::Power if left < 0.0 && right.fract() != 0.0 => {
            return Err(Problem::Domain {
                what: "a fractional power of a negative number, exponent",
                value: right,
            });
        }
        Binary::Power => math::pow(left, right),
        Binary::Times => left * right,
        Binary::Divide | Binary::Modulo if right == 0.0 => return Err(Problem::DivisionByZero),
        Binary::Divide => left / right,
        Binary::Modulo => {
            // The result of MOD is never negative, as in LinuxCNC.
            let remainder = left % right;
            if remainder < 0.0 {
                remainder + right.abs()
            } else {
                remainder
            }
        }
        Binary::Plus => left + right,
        Binary::Minus => left - right,
        Binary::Equal => truth((left - right).abs() < EQUALITY_TOLERANCE),
        Binary::NotEqual => truth((left - right).abs() >= EQUALITY_TOLERANCE),
        Binary::Greater => truth(left > right),
        Binary::GreaterEqual => truth(left >= right),
        Binary::Less => truth(left < right),
        Binary::LessEqual => truth(left <= right),
        Binary::And => truth(left != 0.0 && right != 0.0),
        Binary::Or => truth(left != 0.0 || right != 0.0),
        Binary::Xor => truth((left != 0.0) != (right != 0.0)),
    })
}
