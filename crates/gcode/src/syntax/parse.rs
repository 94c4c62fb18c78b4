//! Lines of the grammar: N, words, settings, comments, O-lines (a label, a keyword and its arguments).
//! Words of a letter and a literal, most bytes of a program, are read without going through the
//! grammar.

use super::block::{Block, Fault, Keyword, Label, Parsed, Setting, Text, Value, Word, fail};
use super::expression::{PostfixCode, bracket_value, expected, name, target, word_value};
use super::number::{literal, skip};
use crate::limits::Limits;
use crate::problem::Problem;
use nom::Err;
use nom::bytes::complete::take_till;

/// Parses one line without its terminator into `block`, whose buffers are reused.
///
/// # Errors
/// The first fault of the line; the block then holds what stood before it.
pub fn parse_block(line: &[u8], block: &mut Block, limits: &Limits) -> Result<(), Fault> {
    block.clear();
    match items(line, block, limits) {
        Ok(_) => Ok(()),
        Err(Err::Error(fault) | Err::Failure(fault)) => Err(fault),
        Err(Err::Incomplete(_)) => Err(Fault {
            rest: 0,
            problem: Box::new(Problem::Expected { expected: "more" }),
        }),
    }
}

fn items<'a>(line: &'a [u8], block: &mut Block, limits: &Limits) -> Parsed<'a, ()> {
    let (mut rest, ()) = head(line, block, limits)?;
    loop {
        // Plain words first, without the grammar; then one item that needs it.
        rest = if block.flow.is_some() {
            skip(rest)
        } else {
            words(rest, line.len(), block, limits)
        };
        let Some(&first) = rest.first() else {
            return Ok((rest, ()));
        };
        let at = line.len() - rest.len();
        rest = match first {
            b'(' => {
                let (after, inside) = parenthesis(rest)?;
                block.comment = Some(Text {
                    start: at as u32 + 1,
                    len: inside.len() as u32,
                });
                after
            }
            b';' => {
                let (after, inside) = semicolon(rest)?;
                block.comment = Some(Text {
                    start: at as u32 + 1,
                    len: inside.len() as u32,
                });
                after
            }
            _ if block.flow.is_some() => return after_flow(rest, first),
            b'#' => setting(rest, at, block, limits)?.0,
            b'o' | b'O' if block.words.is_empty() && block.settings.is_empty() => {
                let (after, ()) = flow_line(
                    rest.get(1..).unwrap_or_default(),
                    line.len(),
                    block,
                    limits.expression_depth,
                )?;
                block.flow_text = between(line, rest, after);
                after
            }
            _ => word(rest, at, block, limits)?.0,
        };
        // Bounded, so that a line of megabytes cannot fill memory.
        if block.words.len() + block.settings.len() > limits.words {
            return fail(
                rest,
                Problem::TooManyWords {
                    limit: limits.words,
                },
            );
        }
    }
}

/// Block delete, line number, percent sign.
pub(crate) fn head<'a>(line: &'a [u8], block: &mut Block, limits: &Limits) -> Parsed<'a, ()> {
    let mut rest = skip(line);
    // A percent sign stands alone on its line, but for a comment.
    if let [b'%', after @ ..] = rest {
        let after = skip(after);
        block.percent = true;
        return match after.first() {
            None | Some(b'(' | b';') => Ok((&[], ())),
            Some(&byte) => fail(after, Problem::BadCharacter { byte }),
        };
    }
    if let [b'/', after @ ..] = rest {
        block.deletable = true;
        rest = skip(after);
    }
    // The number of a line is a label: it cannot be computed.
    if let [b'n' | b'N', after @ ..] = rest {
        let (after, value) = match number(after) {
            Some((after, number)) => (after, Value::Number(number)),
            None => word_value(after, &mut PostfixCode::of(block, limits.expression_depth))?,
        };
        match value {
            Value::Number(number) if number >= 0.0 => block.line_number = Some(number),
            Value::Number(number) => {
                return fail(
                    rest,
                    Problem::BadWordValue {
                        letter: 'N',
                        value: number,
                    },
                );
            }
            Value::Ops(..) => return expected(rest, "a plain number after N"),
        }
        block.line_number_text = between(line, rest, after);
        rest = after;
    }
    Ok((rest, ()))
}

/// What lies between two ends of a line, without blanks at its end.
fn between(line: &[u8], rest: &[u8], after: &[u8]) -> Text {
    let taken = rest.get(..rest.len() - after.len()).unwrap_or_default();
    Text {
        start: (line.len() - rest.len()) as u32,
        len: taken.trim_ascii_end().len() as u32,
    }
}

/// Where an item stands that begins at a byte of the line and goes from `input` up to `rest`.
pub(super) fn taken(at: usize, input: &[u8], rest: &[u8]) -> Text {
    Text {
        start: at as u32,
        len: (input.len() - rest.len()) as u32,
    }
}

#[cold]
fn after_flow(rest: &[u8], first: u8) -> Parsed<'_, ()> {
    if first == 0 {
        return fail(rest, Problem::Nul);
    }
    fail(
        rest,
        Problem::Flow {
            message: "only arguments in brackets and a comment may follow an O-word".to_owned(),
        },
    )
}

/// `#... = value`.
fn setting<'a>(input: &'a [u8], at: usize, block: &mut Block, limits: &Limits) -> Parsed<'a, ()> {
    let mut code = PostfixCode::of(block, limits.expression_depth);
    let (rest, target) = target(input, &mut code)?;
    let (rest, value) = word_value(rest, &mut code)?;
    let text = taken(at, input, rest);
    block.settings.push(Setting {
        target,
        value,
        text,
    });
    Ok((rest, ()))
}

/// A letter with its value.
pub(crate) fn word<'a>(
    input: &'a [u8],
    at: usize,
    block: &mut Block,
    limits: &Limits,
) -> Parsed<'a, ()> {
    let (letter, after) = match input {
        [letter, after @ ..]
            if letter.is_ascii_alphabetic() || matches!(letter, b'@' | b'^' | b'$') =>
        {
            (letter.to_ascii_uppercase(), after)
        }
        [0, ..] => return fail(input, Problem::Nul),
        [byte, ..] => return fail(input, Problem::BadCharacter { byte: *byte }),
        [] => return expected(input, "a word"),
    };
    match letter {
        b'N' => return fail(input, Problem::MisplacedLineNumber),
        b'O' => {
            return fail(
                input,
                Problem::Flow {
                    message: "an O-word has to stand first on its line".to_owned(),
                },
            );
        }
        _ => {}
    }
    let (rest, value) = word_value(after, &mut PostfixCode::of(block, limits.expression_depth))
        .map_err(|fault| missing(fault, letter))?;
    let text = taken(at, input, rest);
    // Habits are noted here, where the bytes are at hand, and reported by the interpreter.
    block.lower_case |= input.first().is_some_and(u8::is_ascii_lowercase);
    block.glued |= block
        .words
        .last()
        .is_some_and(|last| last.text.start + last.text.len == text.start);
    block.words.push(Word {
        letter,
        value,
        text,
    });
    Ok((rest, ()))
}

/// Words behind a fault at a byte of the line, in so far as they can be told: what a faulty line says
/// all the same. Comments and O-words end them.
#[cold]
pub(crate) fn words_behind(
    line: &[u8],
    item: usize,
    at: usize,
    block: &mut Block,
    limits: &Limits,
) {
    let text = |from: usize, to: usize| line.get(from..to).unwrap_or_default();
    // A fault inside brackets is over where they close.
    let depth = |bytes: &[u8]| {
        bytes.iter().fold(0_i32, |depth, byte| match byte {
            b'[' => depth + 1,
            b']' => depth - 1,
            _ => depth,
        })
    };
    let mut open = depth(text(item, at)).max(0);
    let mut next = at;
    // A letter right behind one without its number begins the next word.
    let after_letter = text(item, at).last().is_some_and(u8::is_ascii_alphabetic);
    while open > 0 || next < line.len() {
        let Some(&byte) = line.get(next) else { return };
        match byte {
            b'[' => open += 1,
            b']' => open -= 1,
            b'(' | b';' if open <= 0 => return,
            b' ' | b'\t' if open <= 0 => break,
            // Words without blanks between them: the next one begins with a letter, but O may be a
            // mistaken 0.
            _ if open <= 0
                && (next > at || after_letter)
                && byte.is_ascii_alphabetic()
                && !matches!(byte, b'o' | b'O') =>
            {
                break;
            }
            _ => {}
        }
        next += 1;
    }
    let mut rest = line.get(next..).unwrap_or_default();
    loop {
        rest = skip(rest);
        let is_letter = rest.first().is_some_and(u8::is_ascii_alphabetic);
        if !is_letter || block.words.len() >= limits.words {
            return;
        }
        let place = line.len() - rest.len();
        match word(rest, place, block, limits) {
            Ok((after, ())) => rest = after,
            Err(_) => return,
        }
    }
}

/// Names the letter whose number is missing.
#[cold]
fn missing(fault: Err<Fault>, letter: u8) -> Err<Fault> {
    fault.map(|mut fault| {
        if let Problem::MissingNumber { after } = fault.problem.as_mut() {
            *after = char::from(letter).to_string();
        }
        fault
    })
}

/// What the opening parenthesis of the input encloses.
pub(crate) fn parenthesis(input: &[u8]) -> Parsed<'_, &[u8]> {
    let inside = input.get(1..).unwrap_or_default();
    // A comment ends at the first closing parenthesis; an opening one inside is refused, as in
    // LinuxCNC.
    let (rest, text) = take_till(|byte| matches!(byte, b'(' | b')' | 0))(inside)?;
    match rest.first() {
        Some(b')') => Ok((rest.get(1..).unwrap_or_default(), text)),
        Some(b'(') => fail(rest, Problem::NestedComment),
        Some(_) => fail(rest, Problem::Nul),
        None => fail(input, Problem::UnclosedComment),
    }
}

/// What stands after the semicolon of the input.
pub(crate) fn semicolon(input: &[u8]) -> Parsed<'_, &[u8]> {
    let inside = input.get(1..).unwrap_or_default();
    let (rest, text) = take_till(|byte| byte == 0)(inside)?;
    if rest.is_empty() {
        Ok((rest, text))
    } else {
        fail(rest, Problem::Nul)
    }
}

/// Whether a number goes on after blanks, or has an exponent.
#[inline(always)]
fn goes_on(tail: &[u8], next: &[u8]) -> bool {
    match next.first() {
        Some(b'0'..=b'9' | b'.') => true,
        Some(b'E' | b'e') => next.len() == tail.len(),
        _ => false,
    }
}

/// A literal at the start of the input; `None` if the grammar has to look at it.
pub(crate) fn number(input: &[u8]) -> Option<(&[u8], f64)> {
    literal(input).filter(|(tail, _)| !goes_on(tail, skip(tail)))
}

/// Takes plain words off `input`, the end of a line of `length` bytes, up to the first item that is
/// not one.
pub(crate) fn words<'a>(
    input: &'a [u8],
    length: usize,
    block: &mut Block,
    limits: &Limits,
) -> &'a [u8] {
    let mut rest = skip(input);
    let (mut lower, mut glued, mut touches) = (0, false, false);
    let mut room = limits
        .words
        .saturating_sub(block.words.len() + block.settings.len());
    while let [first, after @ ..] = rest {
        // Clearing one bit makes ASCII letters upper case without a branch.
        let letter = first & !0x20;
        if !letter.is_ascii_uppercase() || matches!(letter, b'N' | b'O') || room == 0 {
            break;
        }
        let Some((tail, value)) = literal(after) else {
            break;
        };
        // `1 000` goes on after its blank and `1E3` has an exponent: both are left to the grammar.
        let next = skip(tail);
        if goes_on(tail, next) {
            break;
        }
        let text = Text {
            start: (length - rest.len()) as u32,
            len: (rest.len() - tail.len()) as u32,
        };
        block.words.push(Word {
            letter,
            value: Value::Number(value),
            text,
        });
        room -= 1;
        lower |= first & 0x20;
        glued |= touches;
        touches = next.len() == tail.len();
        rest = next;
    }
    block.lower_case |= lower != 0;
    block.glued |= glued;
    rest
}

/// Longest first, so that none hides another.
const KEYWORDS: [(&[u8], Keyword); 15] = [
    (b"endrepeat", Keyword::EndRepeat),
    (b"endwhile", Keyword::EndWhile),
    (b"continue", Keyword::Continue),
    (b"elseif", Keyword::ElseIf),
    (b"endsub", Keyword::EndSub),
    (b"return", Keyword::Return),
    (b"repeat", Keyword::Repeat),
    (b"endif", Keyword::EndIf),
    (b"while", Keyword::While),
    (b"break", Keyword::Break),
    (b"call", Keyword::Call),
    (b"else", Keyword::Else),
    (b"sub", Keyword::Sub),
    (b"do", Keyword::Do),
    (b"if", Keyword::If),
];

/// The rest of an O-line after its O; the line has `length` bytes, for the places of comments.
pub(crate) fn flow_line<'a>(
    input: &'a [u8],
    length: usize,
    block: &mut Block,
    limit: usize,
) -> Parsed<'a, ()> {
    let (rest, label) = label(skip(input), block, limit)?;
    let (mut rest, keyword) = keyword(skip(rest))?;
    block.flow = Some((label, keyword));
    while let Some(at) = argument(rest, length, keyword, block) {
        // A call may set #1 to #30.
        if block.arguments.len() >= limit.max(30) {
            return fail(at, Problem::TooManyWords { limit });
        }
        let (after, value) = bracket_value(at, &mut PostfixCode::of(block, limit))?;
        block.arguments.push(value);
        rest = after;
    }
    Ok((rest, ()))
}

/// Where the next argument of an O-line begins; `None` if there is none. Comments may stand before
/// the arguments of a call, as in LinuxCNC.
fn argument<'a>(
    input: &'a [u8],
    length: usize,
    keyword: Keyword,
    block: &mut Block,
) -> Option<&'a [u8]> {
    let (mut rest, mut comment) = (skip(input), None);
    while let (Keyword::Call, [b'(', ..]) = (keyword, rest) {
        // A comment that is not closed, or that ends the line, is the line's own.
        let (after, inside) = parenthesis(rest).ok()?;
        comment = Some(Text {
            start: (length - rest.len()) as u32 + 1,
            len: inside.len() as u32,
        });
        rest = skip(after);
    }
    if rest.first() != Some(&b'[') {
        return None;
    }
    block.comment = comment.or(block.comment);
    Some(rest)
}

fn label<'a>(input: &'a [u8], block: &mut Block, limit: usize) -> Parsed<'a, Label> {
    if input.first() == Some(&b'<') {
        let (rest, text) = name(input, &mut block.names)?;
        return Ok((rest, Label::Name(text)));
    }
    let (rest, value) = word_value(input, &mut PostfixCode::of(block, limit))?;
    Ok((rest, Label::Number(value)))
}

/// The keyword, in any case and with blanks inside; a line that ends after its label has none.
fn keyword(input: &[u8]) -> Parsed<'_, Keyword> {
    // A label alone is a subroutine that ends with M99, or the program's own number.
    if matches!(input.first(), None | Some(b'(' | b';')) {
        return Ok((input, Keyword::Bare));
    }
    for (text, keyword) in KEYWORDS {
        if let Some(rest) = starts_with(input, text) {
            return Ok((rest, keyword));
        }
    }
    fail(
        input,
        Problem::Flow {
            message: "an O-word keyword (sub, call, if, while, ...) expected after the label"
                .to_owned(),
        },
    )
}

fn starts_with<'a>(input: &'a [u8], text: &[u8]) -> Option<&'a [u8]> {
    let mut rest = input;
    for &letter in text {
        // RS274/NGC allows blanks anywhere outside names and comments.
        let (first, after) = skip(rest).split_first()?;
        if first.to_ascii_lowercase() != letter {
            return None;
        }
        rest = after;
    }
    Some(rest)
}
