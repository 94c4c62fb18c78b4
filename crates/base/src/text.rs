//! Values in messages: what is too long to be read is cut, and how much was cut is said.

/// Digits in a row that a message shows. Derived: a number of 64 bits has at most 20.
const MOST_DIGITS: usize = 20;
/// Digits that are left of a longer row. A choice: enough to find it in the file.
const LEFT_DIGITS: usize = 8;
/// Longest word that a message shows, characters. A choice: paths are seldom longer.
const MOST_CHARACTERS: usize = 400;

/// The first `limit` characters of a text, with dots for the rest.
///
/// ```
/// assert_eq!(lostmotion_base::text::shortened("abcdef", 4), "abcd...");
/// ```
pub fn shortened(text: &str, limit: usize) -> String {
    match text.char_indices().nth(limit) {
        Some((end, _)) => format!("{}...", text.get(..end).unwrap_or(text)),
        None => text.to_owned(),
    }
}

/// A message with its endless numbers and words cut: a number that stands for 10^300 has 301 digits.
///
/// ```
/// let message = format!("X goes to {}", 1e300);
/// assert_eq!(
///     lostmotion_base::text::legible(&message),
///     "X goes to 10000000...(301 digits)"
/// );
/// ```
pub fn legible(message: &str) -> String {
    let mut out = String::with_capacity(message.len().min(4 * MOST_CHARACTERS));
    let mut rest = message;
    while let Some(first) = rest.chars().next() {
        // Runs of digits, of other characters that are no blanks, and of blanks, in turn.
        let kind = |c: char| (c.is_ascii_digit(), c.is_whitespace());
        let end = rest.find(|c| kind(c) != kind(first)).unwrap_or(rest.len());
        let (run, after) = rest.split_at(end);
        let long = run.chars().nth(MOST_CHARACTERS).is_some();
        if first.is_ascii_digit() && run.len() > MOST_DIGITS {
            out.push_str(&shortened(run, LEFT_DIGITS));
            out.push_str(&format!("({} digits)", run.len()));
        } else if !first.is_whitespace() && long {
            out.push_str(&shortened(run, MOST_CHARACTERS));
        } else {
            out.push_str(run);
        }
        rest = after;
    }
    out
}
