//! The interpreter: lines in, canonical operations out, one block per step.
//!
//! Memory is constant in the program's length: a line is held only while a loop is open that may
//! run it again, or as the body of a subroutine.

mod calls;
mod control;
mod dialects;
mod ending;
mod flow;
mod lines;
mod profile;
mod quick;
mod run;
mod salvage;
mod start;

use crate::codes::CodeRow;
use crate::config::{InterpreterConfig, MCodeUse};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::dialect::{Dialect, Leniencies, Leniency};
use crate::exec::Jump;
use crate::exec::words::Words;
use crate::limits::Limits;
use crate::ops::{CanonicalOp, SourcedOp};
use crate::parameters::{Parameters, View};
use crate::problem::Problem;
use crate::provenance::{CallStacks, SubroutineLoader};
use crate::source::Place;
use crate::state::{Saved, State};
use crate::syntax::evaluate::{evaluate, valued};
use crate::syntax::{Block, Text, Value, Word};
use crate::tool_table::ToolTable;
use flow::Flow;
use lostmotion_base::span::{BlockRef, Span};
use std::collections::BTreeSet;
use std::sync::Arc;

/// State of the interpreter after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A block has run; more may follow without further input.
    Ran,
    /// It needs the next line ([`Interpreter::push_line`]) or the end of the source
    /// ([`Interpreter::end_of_source`]).
    NeedsLine,
    /// The program is over.
    Ended,
}

/// Whether the program is enclosed in percent signs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Percent {
    Unknown,
    Absent,
    Open,
}

/// A modal interpreter of RS274/NGC. Drive it with [`Interpreter::push_line`] and
/// [`Interpreter::step`], or let [`crate::Program`] do it.
#[derive(Debug)]
pub struct Interpreter {
    config: InterpreterConfig,
    state: State,
    parameters: Parameters,
    /// The tool table, with what G10 has changed.
    tools: Option<ToolTable>,
    diagnostics: Diagnostics,
    flow: Flow,
    block: Block,
    words: Words,
    line: Vec<u8>,
    place: Place,
    span: Span,
    stack: Vec<f64>,
    warnings: Vec<Problem>,
    jump: Option<Jump>,
    loader: Option<Arc<dyn SubroutineLoader>>,
    /// Bytes of the files of subroutines.
    loaded_bytes: usize,
    /// Index of the call that is running.
    stack_index: u32,
    /// What each level of calls has saved, the main program first.
    saved: Vec<Saved>,
    /// Modes to be brought back because a level has been left.
    returning: Option<Box<State>>,
    percent: Percent,
    /// Line of the opening percent sign.
    opened: u32,
    /// Whether a block with words has been seen.
    begun: bool,
    at_end: bool,
    executed: u64,
    /// Blocks run since the last line was read, and those since the last motion.
    looped: u64,
    made: u64,
    idle: u64,
    missing_sub: Option<String>,
    /// Leniencies made use of so far.
    told: Leniencies,
    /// What else is told once: M codes that are not known, system variables that are doubtful.
    told_once: std::collections::BTreeSet<dialects::Once>,
    /// Number of the main program.
    program_number: f64,
    /// States that Klipper's SAVE_GCODE_STATE has saved, and its offset.
    klipper: dialects::Klipper,
    habits: dialects::Habits,
    /// Lines are looked at for another dialect's sake.
    special: bool,
    modal_macro: Option<dialects::ModalMacro>,
    /// What the builder's M codes of the line do after the rest of it.
    foreign: Vec<MCodeUse>,
    /// The profile of a turning cycle that is being read.
    profile: Option<Box<profile::Collecting>>,
    /// How far the current block has come.
    stage: salvage::Stage,
    /// Byte of the current line where its fault was found.
    fault: Option<usize>,
    /// Parameters whose setting was refused: `#5`, `#<name>`.
    refused_settings: BTreeSet<String>,
}

impl Interpreter {
    /// An interpreter in its initial state.
    pub fn new(config: InterpreterConfig) -> Interpreter {
        let mut parameters = start::parameters(&config);
        let state = start::state(&config, &parameters);
        dialects::note_start(&mut parameters, &config, &state);
        let accepted = config.leniencies;
        // RS274/NGC with its own leniencies takes the fast path.
        let special = config.dialect != Dialect::LinuxCnc
            || config.leniencies != Dialect::LinuxCnc.leniencies();
        // GOTO and M97 may lead back to any line: these dialects keep the program's text.
        let keeps = [Leniency::MacroFlow, Leniency::LocalCalls]
            .into_iter()
            .any(|leniency| config.leniencies.has(leniency));
        Interpreter {
            diagnostics: Diagnostics::new(config.limits.diagnostics),
            tools: config.tool_table.clone(),
            config,
            state,
            parameters,
            flow: Flow {
                keeps,
                ..Flow::default()
            },
            block: Block::default(),
            words: Words::accepting(accepted),
            line: Vec::new(),
            place: Place::default(),
            span: Span::default(),
            stack: Vec::new(),
            warnings: Vec::new(),
            jump: None,
            loader: None,
            loaded_bytes: 0,
            stack_index: 0,
            saved: vec![Saved::default()],
            returning: None,
            percent: Percent::Unknown,
            opened: 0,
            begun: false,
            at_end: false,
            executed: 0,
            looped: 0,
            made: 0,
            idle: 0,
            missing_sub: None,
            told: Leniencies::default(),
            told_once: std::collections::BTreeSet::new(),
            program_number: 0.0,
            klipper: dialects::Klipper::default(),
            habits: dialects::Habits::default(),
            special,
            modal_macro: None,
            foreign: Vec::new(),
            profile: None,
            stage: salvage::Stage::Read,
            fault: None,
            refused_settings: BTreeSet::new(),
        }
    }

    /// Tells where the controlled point is after a move that is not in the program: where it is in program coordinates and units.
    pub(crate) fn moved_to(&mut self, place: crate::ops::Position) {
        self.state.current = place;
    }

    /// Operations that state what is in force before the first line: units and offsets.
    pub fn begin(&self, out: &mut Vec<SourcedOp>) {
        let offsets = &self.state.offsets;
        let ops = [
            CanonicalOp::UseLengthUnits(self.state.units),
            CanonicalOp::SetG5xOffset {
                system: self.state.system,
                offset: offsets.g5x,
            },
            CanonicalOp::SetG92Offset(offsets.g92),
            CanonicalOp::SetXyRotation(offsets.rotation_deg),
        ];
        out.extend(ops.map(|op| SourcedOp {
            op,
            block: BlockRef::default(),
            named: 0,
        }));
    }

    /// Loads subroutines that the program does not define.
    #[must_use]
    pub fn with_loader(mut self, loader: Arc<dyn SubroutineLoader>) -> Interpreter {
        self.loader = Some(loader);
        self
    }

    /// Adds the next line of the program, without its terminator, when a step needs it.
    pub fn push_line(&mut self, line: &[u8], place: Place) {
        // Lines that cannot run again make room for the new one.
        self.flow.forget();
        (self.looped, self.made, self.idle) = (0, 0, 0);
        if let Err(problem) = self.flow.main.push(
            line,
            place,
            self.config
                .limits
                .held_bytes
                .max(self.config.limits.line_bytes),
        ) {
            self.place = place;
            self.span = Span {
                file: place.file,
                line: place.line,
                column: 1,
                start: place.start,
                len: 0,
            };
            self.report(problem);
            self.state.ended = true;
        }
    }

    /// States that no line follows.
    pub fn end_of_source(&mut self) {
        self.at_end = true;
    }

    /// Reports something about the source as a whole or about the place given.
    pub(crate) fn report_at(&mut self, problem: Problem, span: Span) {
        self.diagnostics.push(Diagnostic {
            problem,
            place: BlockRef {
                span,
                call_stack: self.stack_index,
            },
        });
    }

    /// Reports a byte order mark.
    pub(crate) fn report_mark(&mut self, span: Span) {
        self.span = span;
        self.forgive(Problem::ByteOrderMark, Leniency::ByteOrderMark);
    }

    fn report(&mut self, problem: Problem) {
        self.report_at(problem, self.span);
    }

    /// The value of an argument of the current O-line.
    fn argument(&mut self, index: usize) -> Result<Option<f64>, Problem> {
        match self.block.arguments.get(index) {
            Some(&value) => self.value(value).map(Some),
            None => Ok(None),
        }
    }

    fn value(&mut self, value: Value) -> Result<f64, Problem> {
        self.value_or_vacant(value).map(valued)
    }

    /// A value, or NaN for a vacant parameter.
    pub(crate) fn value_or_vacant(&mut self, value: Value) -> Result<f64, Problem> {
        let mut view = View {
            parameters: &mut self.parameters,
            state: &self.state,
            tools: self.tools.as_ref(),
            config: &self.config,
        };
        evaluate(&self.block, value, &mut view, &mut self.stack)
    }
}

impl Interpreter {
    /// The calls that [`BlockRef::call_stack`] points to.
    pub fn call_stacks(&self) -> &CallStacks {
        self.diagnostics.provenance().call_stacks()
    }

    /// Name of the file of an index in a span; `None` for the program itself, which is 0.
    pub fn file_name(&self, index: u32) -> Option<&str> {
        self.diagnostics.file(index).map(|file| file.name.as_str())
    }

    /// The modes, offsets and position after the blocks run so far.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The dialect that the program is read in.
    pub fn dialect(&self) -> Dialect {
        self.config.dialect
    }

    /// All parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The bounds it runs under.
    pub fn limits(&self) -> &Limits {
        &self.config.limits
    }

    /// What has been found so far.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// Takes the kept findings out and goes on: as many again can be kept.
    pub fn take_diagnostics(&mut self) -> Vec<Diagnostic> {
        self.diagnostics.take_kept()
    }

    /// Takes the findings out.
    pub fn into_diagnostics(self) -> Diagnostics {
        self.diagnostics
    }

    /// The last block, as it was parsed. After a block that could not be parsed, what stood before
    /// the fault.
    pub fn block(&self) -> &Block {
        &self.block
    }

    /// The state without what may be large: the moves that cutter compensation holds, the points of
    /// an open curve.
    pub(crate) fn light_state(&mut self) -> State {
        let (compensation, nurbs) = (self.state.compensation.take(), self.state.nurbs.take());
        let light = self.state.clone();
        (self.state.compensation, self.state.nurbs) = (compensation, nurbs);
        light
    }

    /// The bytes of the last block's line.
    pub fn line(&self) -> &[u8] {
        &self.line
    }

    /// Where the last block stands, with the call that is running now.
    pub fn place(&self) -> BlockRef {
        BlockRef {
            span: self.span,
            call_stack: self.stack_index,
        }
    }

    /// Whether the next line will only be looked at: it lies in a branch that is not taken, in the
    /// definition of a subroutine, or is passed on the way to one.
    pub fn passes_over(&self) -> bool {
        self.is_passing()
    }

    /// The value that a word of the last block had, where it has been evaluated and is not a code.
    pub fn value_of(&self, word: &Word) -> Option<f64> {
        self.words
            .get(word.letter)
            .filter(|_| self.words.text(word.letter) == word.text)
    }

    /// The codes of the last block in the order in which they are carried out, with their places on
    /// the line.
    pub fn codes(&self) -> impl Iterator<Item = (&'static CodeRow, Text)> + '_ {
        self.words.codes().iter().map(|used| (used.row, used.text))
    }
}
