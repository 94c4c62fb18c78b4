//! A look at every line of the file, whether it runs or not: names that are set, read, defined and
//! called.

use lostmotion_base::span::{BlockRef, Span};
use lostmotion_gcode::codes::whole;
use lostmotion_gcode::limits::Limits;
use lostmotion_gcode::syntax::{Block, Keyword, Label, Op, Target, Text, Value, Word, parse_block};
use std::collections::{BTreeMap, BTreeSet};

/// The P of a call may have its rounds before the last four digits, the number of the subroutine.
const PACKED_CALL_FACTOR: f64 = 10_000.0;

/// Line numbers may begin anew after one of at least this.
const LEAST_WRAPPING_NUMBER: u64 = 9000;
/// Most numbers that are remembered.
const MOST_NUMBERS: usize = 100_000;

/// Names with the place of their first mention.
pub(super) type Places = BTreeMap<String, BlockRef>;

/// What the lines mention.
#[derive(Debug)]
pub(super) struct Scan {
    limits: Limits,
    block: Block,
    /// Lines up to here have been looked at.
    last: u32,
    pub(super) set: Places,
    pub(super) read: BTreeSet<String>,
    /// Parameters are read by a computed number.
    pub(super) reads_computed: bool,
    pub(super) subs: Places,
    pub(super) called: BTreeSet<String>,
    /// A call computes its name.
    pub(super) calls_computed: bool,
    /// The subroutine that the lines belong to.
    inside: Option<String>,
    /// There are words outside subroutines.
    pub(super) has_main: bool,
    ended: bool,
    /// A block ends the main program or a subroutine before: a label alone then begins another.
    over: bool,
    begun: bool,
    pub(super) after_end: Option<BlockRef>,
    /// N numbers with their lines since they last began anew.
    numbers: BTreeMap<u64, u32>,
    last_number: u64,
    /// The line before had a number that another has too.
    repeats: bool,
    /// Lines whose number another line before them has: the number, that line, and where they are.
    pub(super) twice: Vec<(u64, u32, BlockRef)>,
}

impl Scan {
    pub(super) fn new(limits: Limits) -> Scan {
        Scan {
            limits,
            block: Block::default(),
            last: 0,
            set: Places::new(),
            read: BTreeSet::new(),
            reads_computed: false,
            subs: Places::new(),
            called: BTreeSet::new(),
            calls_computed: false,
            inside: None,
            has_main: false,
            ended: false,
            over: false,
            begun: false,
            after_end: None,
            numbers: BTreeMap::new(),
            last_number: 0,
            repeats: false,
            twice: Vec::new(),
        }
    }

    /// Says that the lines that follow come after the end of the program.
    pub(super) fn program_ended(&mut self, ended: bool) {
        self.ended = ended;
    }

    /// Looks at a line; one that has been looked at is not looked at again.
    pub(super) fn line(&mut self, line: &[u8], span: Span) {
        if span.line <= self.last {
            return;
        }
        self.last = span.line;
        let mut block = std::mem::take(&mut self.block);
        // Faults are the front end's to report; here only lines that can be read count.
        if parse_block(line, &mut block, &self.limits).is_ok() && !block.percent {
            self.block(
                &block,
                line,
                BlockRef {
                    span,
                    call_stack: 0,
                },
            );
        }
        self.block = block;
    }

    fn block(&mut self, block: &Block, line: &[u8], place: BlockRef) {
        // Reads first: `#1=[#1+1]` reads and sets.
        self.reads(&block.ops, block);
        self.comment_reads(line);
        for setting in &block.settings {
            match setting.target {
                Target::Numbered(Value::Number(number)) => {
                    self.set.entry(format!("#{number}")).or_insert(place);
                }
                Target::Numbered(Value::Ops(..)) => {}
                Target::Named(name) => {
                    self.set.entry(named(block, name)).or_insert(place);
                }
            }
        }
        self.m98(block);
        self.line_number(block, place);
        match block.flow {
            Some((label, keyword)) => self.flow(block, label, keyword, place),
            None => self.words(block, place),
        }
        self.begun |= !block.is_blank();
    }

    fn words(&mut self, block: &Block, place: BlockRef) {
        if block.words.is_empty() {
            return;
        }
        let is_return = |word: &Word| word.letter == b'M' && word.value == Value::Number(99.0);
        let is_end =
            |word: &Word| word.letter == b'M' && matches!(word.value, Value::Number(2.0 | 30.0));
        self.over |= block
            .words
            .iter()
            .any(|word| is_end(word) || is_return(word));
        if self.inside.is_none() {
            // A file of subroutines often ends with M2 all the same.
            self.has_main |= !block.words.iter().all(is_end);
            if self.ended {
                self.after_end.get_or_insert(place);
            }
        }
    }

    fn flow(&mut self, block: &Block, label: Label, keyword: Keyword, place: BlockRef) {
        let name = match label {
            Label::Name(text) => Some(String::from_utf8_lossy(block.name(text)).into_owned()),
            Label::Number(Value::Number(number)) => whole(number).map(|number| format!("{number}")),
            Label::Number(Value::Ops(..)) => None,
        };
        match (keyword, name) {
            // Line numbers may begin anew in each subroutine.
            (Keyword::Sub, Some(name)) => {
                self.subs.entry(name.clone()).or_insert(place);
                self.numbers.clear();
                self.inside = Some(name);
            }
            // Otherwise it is the program's own number, which blocks run through.
            (Keyword::Bare, Some(name)) if self.begun && self.over => {
                self.subs.entry(name.clone()).or_insert(place);
                self.numbers.clear();
                self.inside = Some(name);
            }
            (Keyword::EndSub, Some(name)) if self.inside.as_ref() == Some(&name) => {
                self.inside = None;
            }
            (Keyword::Call, Some(name)) => {
                self.called.insert(name);
            }
            (Keyword::Call, None) => self.calls_computed = true,
            _ => {}
        }
    }

    /// Whether the N number of a line has been there.
    fn line_number(&mut self, block: &Block, place: BlockRef) {
        let Some(number) = block.line_number.map(|number| number as u64) else {
            return;
        };
        // CAM systems count up to N9999 and begin anew: that is no repetition.
        if number < self.last_number && self.last_number >= LEAST_WRAPPING_NUMBER {
            self.numbers.clear();
        }
        self.last_number = number;
        let before = self.numbers.get(&number).copied();
        // Of a run of repeated numbers the first is told: the others follow from it.
        if let (Some(line), false, true) = (before, self.repeats, self.twice.len() < MOST_NUMBERS) {
            self.twice.push((number, line, place));
        }
        self.repeats = before.is_some();
        if self.numbers.len() < MOST_NUMBERS {
            self.numbers.insert(number, place.span.line);
        }
    }

    /// M98, G65 and G66 call the subroutine of their P, which may have rounds before it; lathe
    /// cycles take the contour of their Q.
    fn m98(&mut self, block: &Block) {
        let is = |letter: u8, number: f64| {
            block
                .words
                .iter()
                .any(|word| word.letter == letter && word.value == Value::Number(number))
        };
        let calls = is(b'M', 98.0) || is(b'G', 65.0) || is(b'G', 66.0);
        let letter = if calls { b'P' } else { b'Q' };
        if letter == b'P'
            || [70.0, 71.0, 71.1, 71.2, 72.0, 72.1, 72.2]
                .into_iter()
                .any(|number| is(b'G', number))
        {
            match block
                .words
                .iter()
                .find(|word| word.letter == letter)
                .map(|word| word.value)
            {
                Some(Value::Number(number)) => {
                    // Fanuc packs rounds and number into one P: both readings count as called.
                    self.called.insert(format!("{}", number.round()));
                    self.called
                        .insert(format!("{}", number.round() % PACKED_CALL_FACTOR));
                }
                _ => self.calls_computed = true,
            }
        }
    }

    fn reads(&mut self, ops: &[Op], block: &Block) {
        for (index, op) in ops.iter().enumerate() {
            match op {
                // `#n` is compiled to the number, then the access; anything else before it
                // computes the number.
                Op::Parameter => match index.checked_sub(1).and_then(|before| ops.get(before)) {
                    Some(Op::Push(number)) => {
                        self.read.insert(format!("#{number}"));
                    }
                    _ => self.reads_computed = true,
                },
                Op::Named(name) | Op::Exists(name) => {
                    self.read.insert(named(block, *name));
                }
                _ => {}
            }
        }
    }

    /// Parameters in comments such as `(DEBUG, #1)`.
    fn comment_reads(&mut self, line: &[u8]) {
        let text = String::from_utf8_lossy(line).to_lowercase();
        if !["debug,", "print,", "log,"]
            .iter()
            .any(|active| text.contains(active))
        {
            return;
        }
        for piece in text.split('#').skip(1) {
            let digits = piece.bytes().take_while(u8::is_ascii_digit).count();
            // `#<name>` or `#123`; blanks inside a name mean nothing.
            let name = match piece.find('>') {
                Some(end) if piece.starts_with('<') => {
                    piece.get(..=end).map(|name| name.replace([' ', '\t'], ""))
                }
                _ => piece.get(..digits).map(str::to_owned),
            };
            self.read.extend(name.map(|name| format!("#{name}")));
        }
    }
}

fn named(block: &Block, name: Text) -> String {
    format!("#<{}>", String::from_utf8_lossy(block.name(name)))
}
