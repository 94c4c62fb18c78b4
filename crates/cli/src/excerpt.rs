//! The lines of a source text that messages point at.

use lostmotion::base::Span;
use std::io::BufRead;

/// Longest piece of a line that is shown.
const WIDTH: usize = 160;

/// A line, or the part of a long one around a span.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Excerpt {
    /// Printable text, one byte of it for each byte of the source.
    pub(crate) text: String,
    /// Where the span lies in it.
    pub(crate) range: std::ops::Range<usize>,
}

/// Fetches the lines of spans in one pass over the source. Spans that lie beyond its end get an
/// empty text. The answer is in the order of the spans.
pub(crate) fn excerpts(source: &mut dyn BufRead, spans: &[Span]) -> std::io::Result<Vec<Excerpt>> {
    let mut order: Vec<usize> = (0..spans.len()).collect();
    order.sort_by_key(|index| window_start(&spans[*index]));
    let mut found = vec![Excerpt::default(); spans.len()];
    let mut window: Vec<u8> = Vec::new();
    let mut window_at = 0_u64;
    for index in order {
        let span = &spans[index];
        let start = window_start(span);
        let skip = start - window_at;
        if skip <= window.len() as u64 {
            window.drain(..skip as usize);
        } else {
            let missing = skip - window.len() as u64;
            window.clear();
            std::io::copy(
                &mut std::io::Read::take(&mut *source, missing),
                &mut std::io::sink(),
            )?;
        }
        window_at = start;
        let wanted = (WIDTH - window.len().min(WIDTH)) as u64;
        std::io::Read::read_to_end(&mut std::io::Read::take(&mut *source, wanted), &mut window)?;
        found[index] = excerpt(&window, (span.start - start) as usize, span.len as usize);
    }
    Ok(found)
}

/// Where the shown part of a span's line begins: at the line's start, or a third of the width
/// before the span.
fn window_start(span: &Span) -> u64 {
    let before = u64::from(span.column.saturating_sub(1)).min(span.start);
    let shown = if before as usize > WIDTH * 2 / 3 {
        (WIDTH / 3) as u64
    } else {
        before
    };
    span.start - shown
}

fn excerpt(window: &[u8], offset: usize, length: usize) -> Excerpt {
    let window = &window[..window.len().min(WIDTH)];
    let end = window
        .iter()
        .position(|b| matches!(b, b'\n' | b'\r'))
        .unwrap_or(window.len());
    let text: String = window[..end]
        .iter()
        .map(|b| {
            if matches!(b, b' '..=b'~') {
                char::from(*b)
            } else {
                ' '
            }
        })
        .collect();
    let from = offset.min(text.len());
    Excerpt {
        range: from..(from + length).min(text.len()),
        text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(line: u32, column: u32, start: u64, len: u32) -> Span {
        Span {
            file: 0,
            line,
            column,
            start,
            len,
        }
    }

    #[test]
    fn lines_are_found_in_any_order() {
        let text = b"G0 X1\r\nG1 Y2 F3\nM2";
        let spans = [
            span(2, 4, 10, 2),
            span(1, 1, 0, 2),
            span(3, 1, 16, 2),
            span(2, 7, 13, 2),
            span(9, 1, 99, 2),
        ];
        let found = excerpts(&mut &text[..], &spans).unwrap();
        let seen: Vec<(&str, &str)> = found
            .iter()
            .map(|e| (e.text.as_str(), &e.text[e.range.clone()]))
            .collect();
        assert_eq!(
            seen,
            [
                ("G1 Y2 F3", "Y2"),
                ("G0 X1", "G0"),
                ("M2", "M2"),
                ("G1 Y2 F3", "F3"),
                ("", "")
            ]
        );
    }

    #[test]
    fn of_a_long_line_only_the_neighbourhood_is_shown() {
        let mut text = vec![b'('; 5_000_000];
        text[4_000_000] = b'G';
        let found = excerpts(&mut text.as_slice(), &[span(1, 4_000_001, 4_000_000, 1)]).unwrap();
        assert_eq!(found[0].text.len(), WIDTH);
        assert_eq!(&found[0].text[found[0].range.clone()], "G");
    }

    #[test]
    fn bytes_that_are_no_text_become_blanks() {
        let found = excerpts(&mut &b"G1\0\xff X1"[..], &[span(1, 6, 5, 2)]).unwrap();
        assert_eq!(found[0].text, "G1   X1");
        assert_eq!(&found[0].text[found[0].range.clone()], "X1");
    }
}
