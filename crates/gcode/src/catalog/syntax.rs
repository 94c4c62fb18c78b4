//! Rows about how a program is written: bytes, words, expressions, O-words.

use super::{CatalogRow, error, warning};

pub(super) const ROWS: &[CatalogRow] = &[
    error(
        "line-too-long",
        "A line is longer than the limit.",
        "Raise the limit `line_bytes`, or look whether the file is a program.",
    ),
    error(
        "source-too-long",
        "The program is longer than the limit.",
        "Raise the limit `source_bytes`.",
    ),
    error(
        "too-many-words",
        "A line has more words than the limit.",
        "Spread them over several lines, or raise the limit `words`.",
    ),
    error(
        "too-deep",
        "Brackets, signs or `#` are nested too deep.",
        "Compute parts of the expression in parameters first.",
    ),
    error(
        "unreadable",
        "The source could not be read to its end.",
        "Check the file or the connection it comes from.",
    ),
    error(
        "nul-byte",
        "The program contains a NUL byte.",
        "The file is damaged, or not a text file.",
    ),
    error(
        "bad-character",
        "A character cannot stand where it does.",
        "Remove it, or put it into a comment.",
    ),
    error(
        "missing-number",
        "A letter or operator is not followed by a number.",
        "Write the number, or remove the letter.",
    ),
    error(
        "bad-number",
        "A number cannot be read.",
        "A number has digits and at most one point.",
    ),
    error(
        "syntax",
        "Something else was expected here.",
        "See the message for what.",
    ),
    error(
        "unknown-name",
        "A name is neither a function nor an operator.",
        "Known are ABS ACOS ASIN ATAN COS EXP FIX FUP LN ROUND SIN SQRT TAN EXISTS and the operators.",
    ),
    error(
        "unclosed-comment",
        "A comment is not closed on its line.",
        "Add the closing parenthesis, or begin the comment with a semicolon.",
    ),
    error(
        "nested-comment",
        "A comment contains an opening parenthesis.",
        "Use other brackets inside the comment.",
    ),
    error(
        "text-before-percent",
        "There is text before the first `%`.",
        "Move the `%` to the first line.",
    ),
    error(
        "misplaced-line-number",
        "N does not stand first on its line.",
        "Move it to the start of the line.",
    ),
    error(
        "repeated-word",
        "A letter is given twice on one line.",
        "Remove one of the two, or put them on two lines.",
    ),
    error(
        "bad-word-value",
        "The value of a letter is not possible.",
        "See the message for what the letter takes.",
    ),
    error(
        "unsupported-code",
        "The code is not known.",
        "Check it against the table of codes; take out what only another control understands.",
    ),
    error(
        "control-cycle",
        "The code is a cycle of another control that is not read.",
        "Have the CAM system write it out as moves.",
    ),
    error(
        "not-a-code",
        "The number after G or M is not that of a code.",
        "Codes have at most one decimal.",
    ),
    error(
        "unsupported",
        "The program uses something that is recognised, but not supported.",
        "See the message for what it is.",
    ),
    error(
        "modal-conflict",
        "Two codes of one line set the same mode.",
        "Keep one of them, or put them on two lines.",
    ),
    error(
        "unused-word",
        "No code of the line uses the word.",
        "Remove it, or add the code that it belongs to.",
    ),
    error(
        "two-axis-users",
        "Two codes of one line want the axis words.",
        "Put them on two lines.",
    ),
    error(
        "axis-without-code",
        "Axis words stand without a motion mode.",
        "Start the line with G0 or G1.",
    ),
    error(
        "axes-missing",
        "A code lacks its axis words.",
        "Name at least one axis.",
    ),
    error(
        "axes-not-allowed",
        "A code that takes no axis words has some.",
        "Put the motion on a line of its own.",
    ),
    error(
        "word-missing",
        "A code lacks a word that it needs.",
        "See the message for which.",
    ),
    error(
        "word-out-of-range",
        "A word has a value that its code does not allow.",
        "See the message for what is allowed.",
    ),
    error(
        "outside-domain",
        "A function gets a value it is not defined for.",
        "Check the values that lead here.",
    ),
    error(
        "not-finite",
        "An expression overflows.",
        "Check the values that lead here.",
    ),
    error(
        "division-by-zero",
        "An expression divides by zero.",
        "Check the values that lead here.",
    ),
    error(
        "parameter-range",
        "A parameter number is out of range.",
        "Parameters go from #1 to #5602.",
    ),
    error(
        "read-only-parameter",
        "A parameter that shows the machine's state is set.",
        "Use another parameter.",
    ),
    error(
        "unknown-parameter",
        "A named parameter is read that is not set.",
        "Set it first, or ask with EXISTS. Names without a leading underscore belong to one subroutine.",
    ),
    error(
        "too-many-parameters",
        "More named parameters than the limit.",
        "Raise the limit `named_parameters`.",
    ),
    warning(
        "unset-parameter",
        "A numbered parameter is read before it is set; it counts as 0.",
        "Set it first.",
    ),
    error(
        "flow",
        "O-words are not nested as they have to be.",
        "See the message for the line that is concerned.",
    ),
    warning(
        "unclosed-sub",
        "A subroutine has no end.",
        "Add its endsub, or its M99.",
    ),
    error(
        "no-such-sub",
        "A subroutine is called that is not defined.",
        "Define it in the program, or put its file into the folder that subroutines come from.",
    ),
    error(
        "sub-file",
        "The file of a subroutine cannot be used.",
        "See the message for the reason.",
    ),
    error(
        "too-many-files",
        "More files of subroutines than the limit.",
        "Look for calls whose name is computed.",
    ),
    error(
        "calls-too-deep",
        "Calls are nested deeper than the limit.",
        "Look for a subroutine that calls itself, or raise the limit `call_depth`.",
    ),
    error(
        "too-many-open",
        "More branches and loops are open than the limit.",
        "Look for an if or a loop that is never closed, or raise the limit.",
    ),
    error(
        "too-much-held",
        "Loops and subroutines hold more source than the limit.",
        "Raise the limit `held_bytes`.",
    ),
    error(
        "too-many-blocks",
        "More blocks have run than the limit.",
        "Look for a loop that does not end, or raise the limit `executed_blocks`.",
    ),
    error(
        "too-many-looped-blocks",
        "Loops and subroutines run more blocks at a stretch than the limit.",
        "Look for a loop that does not end, or raise the limit `looped_blocks`.",
    ),
    error(
        "idle-loop",
        "A loop goes on without any motion.",
        "Look at the condition of the loop.",
    ),
    warning(
        "no-program-end",
        "The program ends without M2 or M30.",
        "End it with M2; without it the spindle and the coolant stay on.",
    ),
    warning(
        "no-closing-percent",
        "The program begins with `%`, but does not end with it.",
        "Add a last line with `%`; the file may have been cut off.",
    ),
    warning(
        "byte-order-mark",
        "The file begins with a byte order mark, which is skipped.",
        "Save it as plain text; many controls stumble over the mark.",
    ),
];
