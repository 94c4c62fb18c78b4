//! What a block's words and codes have to do with each other, before anything is carried out.

use super::words::{AXIS_BITS, UsedCode, Words};
use crate::code::Code;
use crate::codes::row::bit;
use crate::codes::{AxisUse, Group, find, users};
use crate::problem::Problem;
use crate::state::{State, TipControl};
use crate::syntax::Text;

/// Words that need no code.
const FREE: u32 = bit(b'F') | bit(b'S') | bit(b'T');
const ARC_OFFSETS: u32 = bit(b'I') | bit(b'J') | bit(b'K');
const CORNERS: u32 = bit(b'r') | bit(b'c');
const POLAR: u32 = bit(b'@') | bit(b'^');

/// A problem with the place of the word that has it.
type Placed = (Problem, Option<Text>);

/// Finds the motion of the block and checks that every word is used.
pub(crate) fn check(words: &mut Words, state: &State) -> Result<(), Placed> {
    find_motion(words, state)?;
    let mut taken = if state.motion_unknown { !0 } else { FREE };
    if words.has(b'S') {
        // Which spindle the speed is for.
        taken |= bit(b'$');
    }
    for used in words.codes() {
        taken |= used.row.takes;
        if used.row.axes != AxisUse::None {
            taken |= AXIS_BITS;
        }
    }
    if let Some(row) = words.motion {
        taken |= row.takes | AXIS_BITS | POLAR;
        if row.code.tenths == 10 {
            taken |= CORNERS;
        }
        if row.code.tenths <= 10 && state.tip_control == TipControl::WithVector {
            taken |= ARC_OFFSETS;
        }
    }
    let unused = words.mask & !taken;
    if unused == 0 {
        return Ok(());
    }
    let letter = (b'@'..=b'^')
        .chain(*b"$rc")
        .find(|&letter| unused & bit(letter) != 0)
        .unwrap_or(b'?');
    let value = words.get(letter).unwrap_or_default();
    let letter_char = char::from(letter);
    Err((
        Problem::UnusedWord {
            letter: letter_char,
            value,
            users: users(letter_char),
        },
        Some(words.text(letter)),
    ))
}

fn find_motion(words: &mut Words, state: &State) -> Result<(), Placed> {
    let has_axes = words.mask & (AXIS_BITS | POLAR) != 0;
    let explicit = words
        .codes()
        .iter()
        .find(|used| used.row.group == Group::Motion)
        .copied();
    let other = words
        .codes()
        .iter()
        .find(|used| used.row.group != Group::Motion && used.row.axes != AxisUse::None)
        .copied();
    if let Some(other) = other {
        if words.mask & POLAR != 0 {
            return Err((
                Problem::PolarWithoutMotion {
                    code: other.row.code,
                },
                Some(other.text),
            ));
        }
        check_user(other, has_axes)?;
    }
    match (explicit, other) {
        (Some(motion), Some(other)) if motion.row.axes != AxisUse::None => {
            return Err((
                Problem::TwoAxisUsers {
                    code: other.row.code,
                    other: motion.row.code,
                },
                Some(motion.text),
            ));
        }
        (Some(motion), None) if has_axes && motion.row.axes == AxisUse::None => {
            return Err((
                Problem::AxesNotAllowed {
                    code: motion.row.code,
                },
                Some(motion.text),
            ));
        }
        (Some(motion), _) => {
            if motion.row.axes == AxisUse::Needs && !has_axes {
                return Err((
                    Problem::AxesMissing {
                        code: motion.row.code,
                    },
                    Some(motion.text),
                ));
            }
            words.motion = Some(motion.row);
        }
        (None, Some(_)) => {}
        (None, None) => words.motion = modal_motion(words, state, has_axes)?,
    }
    Ok(())
}

fn check_user(user: UsedCode, has_axes: bool) -> Result<(), Placed> {
    if user.row.axes == AxisUse::Needs && !has_axes {
        return Err((
            Problem::AxesMissing {
                code: user.row.code,
            },
            Some(user.text),
        ));
    }
    Ok(())
}

/// The motion mode in force, if the block's words call for motion.
fn modal_motion(
    words: &Words,
    state: &State,
    has_axes: bool,
) -> Result<Option<&'static crate::codes::CodeRow>, Placed> {
    let modal = state.motion.and_then(find);
    let is_arc = matches!(
        state.motion,
        Some(Code {
            letter: 'G',
            tenths: 20 | 30
        })
    );
    if has_axes {
        let axis = super::words::AXIS_LETTERS
            .into_iter()
            .chain(*b"@^")
            .find(|&letter| words.has(letter));
        return match modal {
            Some(row) => Ok(Some(row)),
            _ if state.motion_unknown => Ok(None),
            _ => Err((
                Problem::AxisWithoutCode,
                axis.map(|letter| words.text(letter)),
            )),
        };
    }
    Ok(if is_arc && words.mask & ARC_OFFSETS != 0 {
        modal
    } else {
        None
    })
}
