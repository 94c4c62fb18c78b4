//! Blocks as text.

use lostmotion_gcode::syntax::block::{Binary, Unary};
use lostmotion_gcode::syntax::{Block, Keyword, Label, Op, Target, Text, Value};

/// A block as a line that is parsed to the same block. Its comment is not part of a block and has
/// to be given with it.
pub fn block_text(block: &Block, comment: Option<&str>) -> String {
    if block.percent {
        return "%".to_owned();
    }
    let mut parts: Vec<String> = Vec::new();
    if let Some(number) = block.line_number {
        parts.push(format!("N{number}"));
    }
    if let Some((label, keyword)) = block.flow {
        // O-words: the label, the keyword, and each argument in brackets of its own.
        let label = match label {
            Label::Number(value) => value_text(block, value),
            Label::Name(name) => name_text(block, name),
        };
        parts.push(
            format!("o{label} {}", keyword_text(keyword))
                .trim_end()
                .to_owned(),
        );
        parts.extend(block.arguments.iter().map(|value| bracketed(block, *value)));
    }
    // Words and settings in the order in which they stood.
    let mut items: Vec<(u32, String)> = Vec::new();
    for word in &block.words {
        items.push((
            word.text.start,
            format!(
                "{}{}",
                char::from(word.letter),
                value_text(block, word.value)
            ),
        ));
    }
    for setting in &block.settings {
        let target = match setting.target {
            Target::Numbered(value) => value_text(block, value),
            Target::Named(name) => name_text(block, name),
        };
        items.push((
            setting.text.start,
            format!("#{target} = {}", value_text(block, setting.value)),
        ));
    }
    items.sort_by_key(|(start, _)| *start);
    parts.extend(items.into_iter().map(|(_, text)| text));
    // A comment in parentheses cannot hold parentheses: such a text runs to the end of the line.
    parts.extend(comment.map(|text| {
        if text.contains(['(', ')']) {
            format!(";{text}")
        } else {
            format!("({text})")
        }
    }));
    format!(
        "{}{}",
        if block.deletable { "/" } else { "" },
        parts.join(" ")
    )
}

/// Rank of what is no operation of two arguments.
const OPERAND: u8 = u8::MAX;

fn name_text(block: &Block, name: Text) -> String {
    format!("<{}>", String::from_utf8_lossy(block.name(name)))
}

fn bracketed(block: &Block, value: Value) -> String {
    let text = value_text(block, value);
    if text.starts_with('[') {
        text
    } else {
        format!("[{text}]")
    }
}

/// A value as it may stand after a letter: a number, a parameter, a function or an expression in
/// brackets.
fn value_text(block: &Block, value: Value) -> String {
    let (from, to) = match value {
        Value::Number(number) => return number.to_string(),
        Value::Ops(from, to) => (from as usize, to as usize),
    };
    let mut stack: Vec<(String, u8)> = Vec::new();
    // Postfix to infix: each operation takes its operands from the stack and pushes its text back.
    for op in block.ops.get(from..to).unwrap_or_default() {
        let top = match op {
            Op::Binary(operator) => {
                let (right, left) = (
                    stack.pop().unwrap_or_default(),
                    stack.pop().unwrap_or_default(),
                );
                let own = operator.precedence();
                // From left to right: of equal rank only the right side needs its brackets.
                let left = if left.1 != OPERAND && left.1 >= own {
                    inside(left.0)
                } else {
                    left.0
                };
                let right = if right.1 != OPERAND && right.1 > own {
                    inside(right.0)
                } else {
                    right.0
                };
                stack.push((format!("[{left} {} {right}]", binary(*operator)), own));
                continue;
            }
            Op::Push(number) => number.to_string(),
            Op::Parameter => format!("#{}", pop(&mut stack)),
            Op::Named(name) => format!("#{}", name_text(block, *name)),
            Op::Exists(name) => format!("EXISTS[#{}]", name_text(block, *name)),
            Op::ExistsNumber => format!("EXISTS[#{}]", pop(&mut stack)),
            Op::Negate => format!("-{}", pop(&mut stack)),
            Op::Unary(function) => format!("{}[{}]", unary(*function), inside(pop(&mut stack))),
            Op::Atan => {
                // ATAN[y]/[x] pushes y first.
                let x = pop(&mut stack);
                format!("ATAN[{}]/[{}]", inside(pop(&mut stack)), inside(x))
            }
        };
        stack.push((top, OPERAND));
    }
    pop(&mut stack)
}

fn pop(stack: &mut Vec<(String, u8)>) -> String {
    stack.pop().unwrap_or_default().0
}

/// An argument without brackets of its own. `[a][b]`, which is no single pair, cannot come about.
fn inside(text: String) -> String {
    text.strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'))
        .map(str::to_owned)
        .unwrap_or(text)
}

const fn unary(function: Unary) -> &'static str {
    match function {
        Unary::Abs => "ABS",
        Unary::Acos => "ACOS",
        Unary::Asin => "ASIN",
        Unary::Cos => "COS",
        Unary::Exp => "EXP",
        Unary::Fix => "FIX",
        Unary::Fup => "FUP",
        Unary::Ln => "LN",
        Unary::Round => "ROUND",
        Unary::Sin => "SIN",
        Unary::Sqrt => "SQRT",
        Unary::Tan => "TAN",
    }
}

const fn binary(operator: Binary) -> &'static str {
    match operator {
        Binary::Power => "**",
        Binary::Times => "*",
        Binary::Divide => "/",
        Binary::Modulo => "MOD",
        Binary::Plus => "+",
        Binary::Minus => "-",
        Binary::Equal => "EQ",
        Binary::NotEqual => "NE",
        Binary::Greater => "GT",
        Binary::GreaterEqual => "GE",
        Binary::Less => "LT",
        Binary::LessEqual => "LE",
        Binary::And => "AND",
        Binary::Or => "OR",
        Binary::Xor => "XOR",
    }
}

const fn keyword_text(keyword: Keyword) -> &'static str {
    match keyword {
        Keyword::Sub => "sub",
        Keyword::EndSub => "endsub",
        Keyword::Call => "call",
        Keyword::Return => "return",
        Keyword::If => "if",
        Keyword::ElseIf => "elseif",
        Keyword::Else => "else",
        Keyword::EndIf => "endif",
        Keyword::While => "while",
        Keyword::EndWhile => "endwhile",
        Keyword::Do => "do",
        Keyword::Repeat => "repeat",
        Keyword::EndRepeat => "endrepeat",
        Keyword::Break => "break",
        Keyword::Continue => "continue",
        Keyword::Goto => "goto",
        Keyword::Then => "then",
        Keyword::Bare => "",
    }
}
