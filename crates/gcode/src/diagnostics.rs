//! What the front end has to say about a program.

use crate::dialect::Leniency;
use crate::finding::Severity;
use crate::problem::Problem;
use crate::provenance::Provenance;
use crate::provenance::{LoadedFile, SourceFiles};
use lostmotion_base::span::BlockRef;
use lostmotion_base::text::legible;

/// One finding, with its place in the source.
///
/// ```
/// use lostmotion_gcode::{InterpreterConfig, Program, Severity};
///
/// let found = Program::new(&b"G21 F200 G0 X10\nG2 X20 I15 J0\nM2\n"[..], InterpreterConfig::default()).finish();
/// let diagnostic = &found.kept()[0];
/// assert_eq!(diagnostic.code(), "arc-radii");
/// assert_eq!(diagnostic.severity(), Severity::Error);
/// assert_eq!(diagnostic.place.span.line, 2);
/// assert_eq!(diagnostic.hint().as_deref(), Some("did you mean G90.1, absolute arc centres?"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// What is wrong, with the values it was seen with.
    pub problem: Problem,
    /// Where: the offending word where it is known, the block otherwise.
    pub place: BlockRef,
}

impl Diagnostic {
    /// Stable name of the kind of finding, in kebab case.
    pub fn code(&self) -> &'static str {
        self.problem.code()
    }

    /// Error, warning or note.
    pub fn severity(&self) -> Severity {
        self.problem.severity()
    }

    /// What is wrong, as text; endless numbers and names are cut.
    pub fn message(&self) -> String {
        legible(&self.problem.to_string())
    }

    /// What to try, if there is something.
    pub fn hint(&self) -> Option<String> {
        self.problem.hint().map(|hint| legible(&hint))
    }
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let severity = self.severity().name();
        write!(
            f,
            "{severity}[{}]: {}: {}",
            self.code(),
            self.place.span,
            self.message()
        )?;
        self.hint().map_or(Ok(()), |hint| write!(f, " ({hint})"))
    }
}

/// The findings of one run: a bounded number is kept, all are counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    kept: Vec<Diagnostic>,
    limit: usize,
    errors: u64,
    warnings: u64,
    notes: u64,
    provenance: Provenance,
    /// Findings that were kept and have been taken out.
    taken: u64,
}

impl Diagnostics {
    /// Keeps up to `limit` findings.
    pub fn new(limit: usize) -> Diagnostics {
        Diagnostics {
            limit,
            ..Diagnostics::default()
        }
    }

    /// Adds a finding. One that a loop repeats at the same place is only counted. When the limit is
    /// reached, an error displaces a kept note or warning.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let is_error = diagnostic.severity() == Severity::Error;
        match diagnostic.severity() {
            Severity::Error => self.errors += 1,
            Severity::Warning => self.warnings += 1,
            Severity::Note => self.notes += 1,
        }
        // A loop finds the same thing at the same place each round.
        if self
            .kept
            .iter()
            .any(|kept| kept.place == diagnostic.place && kept.code() == diagnostic.code())
        {
            return;
        }
        // Room for errors is made at the cost of the mildest finding: errors refuse the program.
        if self.kept.len() < self.limit {
            self.kept.push(diagnostic);
        } else if let (true, Some(index)) = (is_error, self.last_mild()) {
            self.kept.remove(index);
            self.kept.push(diagnostic);
        }
    }

    /// The files of subroutines that were read; a span's file 1 is the first of them.
    pub fn files(&self) -> &SourceFiles {
        self.provenance.files()
    }

    /// The file of a span's index; `None` for the program itself, which is 0.
    pub fn file(&self, index: u32) -> Option<&LoadedFile> {
        self.provenance.file(index)
    }

    /// What the places of the findings point into.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    pub(crate) fn provenance_mut(&mut self) -> &mut Provenance {
        &mut self.provenance
    }

    /// The same, for findings about the blocks of a reading.
    #[must_use]
    pub fn with_provenance(self, provenance: Provenance) -> Diagnostics {
        Diagnostics { provenance, ..self }
    }

    /// The kept finding that an error displaces: the last of the mildest.
    fn last_mild(&self) -> Option<usize> {
        let last = |severity| {
            self.kept
                .iter()
                .rposition(|kept| kept.severity() == severity)
        };
        last(Severity::Note).or_else(|| last(Severity::Warning))
    }

    /// Updates the count of a habit; does nothing if its finding is not kept any more.
    pub(crate) fn recount(&mut self, file: u32, leniency: Leniency, times: u64) {
        for kept in self
            .kept
            .iter_mut()
            .filter(|kept| kept.place.span.file == file)
        {
            match &mut kept.problem {
                Problem::Habit {
                    leniency: habit,
                    count,
                } if *habit == leniency => *count = times,
                _ => {}
            }
        }
    }

    /// The findings that were kept, in the order they were made.
    pub fn kept(&self) -> &[Diagnostic] {
        &self.kept
    }

    /// Takes the kept findings out, so that as many again can be kept. The counts go on.
    pub fn take_kept(&mut self) -> Vec<Diagnostic> {
        self.taken += self.kept.len() as u64;
        std::mem::take(&mut self.kept)
    }

    /// How many errors there were.
    pub fn errors(&self) -> u64 {
        self.errors
    }

    /// How many warnings there were.
    pub fn warnings(&self) -> u64 {
        self.warnings
    }

    /// How many notes there were.
    pub fn notes(&self) -> u64 {
        self.notes
    }

    /// How many findings were counted but not kept.
    pub fn dropped(&self) -> u64 {
        self.errors + self.warnings + self.notes - self.taken - self.kept.len() as u64
    }
}
