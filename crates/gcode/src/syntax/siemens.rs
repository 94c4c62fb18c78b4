//! What gives programs of controls away that have a language of their own: Sinumerik, Heidenhain.

/// What a line has that only Sinumerik controls know; none if it has nothing of the kind.
pub(crate) fn siemens_word(line: &[u8]) -> Option<&'static str> {
    const WORDS: [&str; 27] = [
        "TRANS", "ATRANS", "ROT", "AROT", "SCALE", "ASCALE", "MIRROR", "AMIRROR", "CYCLE",
        "POCKET", "SLOT", "HOLES", "LONGHOLE", "MCALL", "EXTCALL", "MSG", "DEF", "PROC", "TRAORI",
        "TRAFOOF", "ORIWKS", "SUPA", "CIP", "GOTOF", "GOTOB", "STOPRE", "COMPON",
    ];
    let text = line.trim_ascii();
    let text = match text {
        [b'N' | b'n', rest @ ..] => rest.trim_ascii_start().trim_start_digits(),
        _ => text,
    };
    let letters = text
        .iter()
        .take_while(|byte| byte.is_ascii_alphabetic())
        .count();
    let name = text.get(..letters).unwrap_or_default();
    let matches = |word: &&&str| name.eq_ignore_ascii_case(word.as_bytes());
    if let Some(word) = WORDS.iter().find(matches) {
        return Some(word);
    }
    let comment = text
        .iter()
        .position(|byte| *byte == b';')
        .unwrap_or(text.len());
    let code = text.get(..comment).unwrap_or_default();
    let address = |pair: &[u8]| matches!(pair, [b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9', b'=']);
    let is_parameter = code.contains(&b'#') || code.first() == Some(&b'(');
    if !is_parameter && code.windows(2).any(address) {
        Some("an address with =")
    } else {
        None
    }
}

/// Whether a line is of Heidenhain's conversational language: its number without N, then what every
/// such program begins with.
pub(crate) fn is_heidenhain(line: &[u8]) -> bool {
    let text = line.trim_ascii().trim_start_digits();
    text.len() < line.trim_ascii().len()
        && [&b"BEGIN PGM"[..], b"TOOL CALL", b"BLK FORM"]
            .iter()
            .any(|word| text.starts_with(word))
}

trait Digits {
    fn trim_start_digits(&self) -> &[u8];
}

impl Digits for [u8] {
    fn trim_start_digits(&self) -> &[u8] {
        let digits = self.iter().take_while(|byte| byte.is_ascii_digit()).count();
        self.get(digits..).unwrap_or_default().trim_ascii_start()
    }
}
