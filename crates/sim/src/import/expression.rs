//! Expressions of C headers: conditions of `#if`, and values such as `(X_BED_SIZE + X_MIN_POS)`.
//!
//! Numbers, names, `! - * / % + == != < > <= >= && ||`, parentheses, `defined` and functions of
//! names. What a name or a function is comes from outside; a part that is not known leaves the whole
//! unknown unless the rest decides it.

/// Deepest nesting of parentheses and of signs. A choice: headers have some three.
const DEEPEST: usize = 32;

/// Most tokens. A choice: the longest conditions of Marlin's headers have about a hundred.
const MOST_TOKENS: usize = 1000;

/// A number, with whether C counts it as a whole one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) is_whole: bool,
}

impl Number {
    fn truth(is_true: bool) -> Number {
        Number {
            value: f64::from(u8::from(is_true)),
            is_whole: true,
        }
    }

    fn is_true(self) -> bool {
        self.value != 0.0
    }
}

/// Why there is no number.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Untold {
    /// It depends on this, which the header does not tell.
    Unknown(String),
    /// This is no part of an expression.
    Bad(String),
}

/// A number, or why there is none.
pub(super) type Worth = Result<Number, Untold>;

/// What names and functions of names stand for.
pub(super) trait Names {
    /// The number of a name, whose chain of names is so deep already.
    fn name(&self, name: &str, depth: usize) -> Worth;

    /// The number of a function of names: `ENABLED(A, B)`, `defined(A)`.
    fn function(&self, name: &str, words: &[&str]) -> Worth;
}

/// The number of a text.
///
/// # Errors
/// What is not known, and what is no expression.
pub(super) fn number(text: &str, names: &dyn Names, depth: usize) -> Worth {
    let mut reader = ExpressionReader {
        tokens: tokens(text)?,
        at: 0,
        names,
        depth,
        nested: 0,
    };
    let found = reader.binary(0)?;
    match reader.next() {
        Some(token) => Err(Untold::Bad(token.to_owned())),
        None => found,
    }
}

/// Words, numbers and signs.
fn tokens(text: &str) -> Result<Vec<&str>, Untold> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
    let (mut rest, mut found) = (text.trim_start(), Vec::new());
    while let Some(first) = rest.chars().next() {
        let end = if is_word(first) {
            // The sign of an exponent is a part of its number.
            let is_number = first.is_ascii_digit() || first == '.';
            let mut before = first;
            rest.find(|c: char| {
                let is_exponent =
                    is_number && matches!(before, 'e' | 'E') && matches!(c, '+' | '-');
                before = c;
                !is_word(c) && !is_exponent
            })
        } else {
            let two = ["&&", "||", "==", "!=", "<=", ">=", "--", "++"];
            let is_two = two.iter().any(|sign| rest.starts_with(sign));
            Some(if is_two { 2 } else { first.len_utf8() })
        };
        let (token, behind) = rest.split_at(end.unwrap_or(rest.len()));
        found.push(token);
        rest = behind.trim_start();
    }
    if found.len() > MOST_TOKENS {
        return Err(Untold::Bad(format!("{} words and signs", found.len())));
    }
    Ok(found)
}

/// Signs between two numbers, those that bind least first.
const SIGNS: [&[&str]; 6] = [
    &["||"],
    &["&&"],
    &["==", "!="],
    &["<", ">", "<=", ">="],
    &["+", "-"],
    &["*", "/", "%"],
];

/// Tokens as they are read. A `Untold::Bad` ends the reading; an unknown part is a value.
struct ExpressionReader<'a> {
    tokens: Vec<&'a str>,
    at: usize,
    names: &'a dyn Names,
    /// Of the chain of names.
    depth: usize,
    /// Of parentheses and signs.
    nested: usize,
}

impl<'a> ExpressionReader<'a> {
    fn peek(&self) -> Option<&'a str> {
        self.tokens.get(self.at).copied()
    }

    fn next(&mut self) -> Option<&'a str> {
        let token = self.peek();
        self.at += 1;
        token
    }

    fn expect(&mut self, wanted: &str) -> Result<(), Untold> {
        match self.next() {
            Some(token) if token == wanted => Ok(()),
            other => Err(Untold::Bad(other.unwrap_or_default().to_owned())),
        }
    }

    /// Numbers joined by signs that bind at least as much as those of a level.
    fn binary(&mut self, level: usize) -> Result<Worth, Untold> {
        let Some(signs) = SIGNS.get(level) else {
            return self.unary();
        };
        let mut left = self.binary(level + 1)?;
        while let Some(sign) = self.peek().filter(|token| signs.contains(token)) {
            self.at += 1;
            let right = self.binary(level + 1)?;
            left = joined(sign, left, right)?;
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Worth, Untold> {
        self.nested += 1;
        if self.nested > DEEPEST {
            return Err(Untold::Bad(format!("nested more than {DEEPEST} deep")));
        }
        let token = self.next().unwrap_or_default();
        let found = match token {
            "!" => self.unary()?.map(|it| Number::truth(!it.is_true())),
            "-" => self.unary()?.map(|it| Number {
                value: -it.value,
                ..it
            }),
            "(" => {
                let inner = self.binary(0)?;
                self.expect(")")?;
                inner
            }
            _ => self.word(token)?,
        };
        self.nested -= 1;
        Ok(found)
    }

    fn word(&mut self, token: &'a str) -> Result<Worth, Untold> {
        let bad = || Untold::Bad(token.to_owned());
        let first = token.chars().next().ok_or_else(bad)?;
        if first.is_ascii_digit() || first == '.' {
            // 0.5f and 16UL are numbers of C.
            let digits = token.trim_end_matches(['f', 'F', 'u', 'U', 'l', 'L']);
            let value: f64 = digits.parse().map_err(|_| bad())?;
            if !value.is_finite() {
                return Err(bad());
            }
            let is_whole = digits.bytes().all(|b| b.is_ascii_digit());
            return Ok(Ok(Number { value, is_whole }));
        }
        if !(first.is_ascii_alphabetic() || first == '_') {
            return Err(bad());
        }
        if self.peek() == Some("(") {
            self.at += 1;
            let words = self.words()?;
            return settled(self.names.function(token, &words));
        }
        if token == "defined" {
            let word = self.next().ok_or_else(bad)?;
            return settled(self.names.function(token, &[word]));
        }
        settled(self.names.name(token, self.depth))
    }

    /// The words of a function, up to its end.
    fn words(&mut self) -> Result<Vec<&'a str>, Untold> {
        let (mut words, mut open) = (Vec::new(), 1);
        while open > 0 {
            match self.next() {
                Some("(") => open += 1,
                Some(")") => open -= 1,
                Some(",") => {}
                Some(word) => words.push(word),
                None => return Err(Untold::Bad(String::new())),
            }
        }
        Ok(words)
    }
}

/// An unknown number is one of those that an expression goes on with.
fn settled(found: Worth) -> Result<Worth, Untold> {
    match found {
        Err(Untold::Bad(what)) => Err(Untold::Bad(what)),
        found => Ok(found),
    }
}

/// Two numbers and the sign between them.
fn joined(sign: &str, left: Worth, right: Worth) -> Result<Worth, Untold> {
    // One side may decide.
    if matches!(sign, "&&" | "||") {
        let decides = sign == "||";
        let decided = |side: &Worth| matches!(side, Ok(it) if it.is_true() == decides);
        if decided(&left) || decided(&right) {
            return Ok(Ok(Number::truth(decides)));
        }
        return Ok(left.and(right).map(|_| Number::truth(!decides)));
    }
    let (a, b) = match (left, right) {
        (Ok(a), Ok(b)) => (a, b),
        (Err(why), _) | (_, Err(why)) => return Ok(Err(why)),
    };
    let is_whole = a.is_whole && b.is_whole;
    let value = match sign {
        "==" => return Ok(Ok(Number::truth(a.value == b.value))),
        "!=" => return Ok(Ok(Number::truth(a.value != b.value))),
        "<" => return Ok(Ok(Number::truth(a.value < b.value))),
        ">" => return Ok(Ok(Number::truth(a.value > b.value))),
        "<=" => return Ok(Ok(Number::truth(a.value <= b.value))),
        ">=" => return Ok(Ok(Number::truth(a.value >= b.value))),
        "+" => a.value + b.value,
        "-" => a.value - b.value,
        "*" => a.value * b.value,
        // C drops what is behind the point of whole numbers.
        "/" if is_whole => (a.value / b.value).trunc(),
        "/" => a.value / b.value,
        _ => a.value % b.value,
    };
    if value.is_finite() {
        Ok(Ok(Number { value, is_whole }))
    } else {
        Err(Untold::Bad(format!("{} {sign} {}", a.value, b.value)))
    }
}
