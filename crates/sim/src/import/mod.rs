//! Machine descriptions of other programs, turned into machine files.
//!
//! Other formats tell axes, travel and speeds at best; drive, motor and load, gap and jerk come
//! from a machine that is named. Every key that was read, ignored or filled in is reported, and the
//! file says behind every value where it is from.
//!
//! A format is one file, which reads text into a `Draft` and says how the format is recognised, and
//! one line in `formats!` below.

mod dh;
mod draft;
mod expression;
mod fill;
mod freecad_chain;
mod gantry;
mod hal;
mod header;
mod ini;
mod kins;
mod linuxcnc_files;
mod linuxcnc_motors;
mod mcodes;
mod places;
mod stepper;
mod wildcards;

pub use draft::{Fate, Row};

use crate::machine::MachineError;
use crate::machine::Problem;
use draft::Draft;
use lostmotion_base::AxisId;
use roxmltree::{Document, ParsingOptions};
use std::borrow::Cow;

/// A format, as its file describes it.
struct Format {
    /// Its name for people.
    name: &'static str,
    /// Extensions of file names, in lower case, that only this format has.
    extensions: &'static [&'static str],
    /// Whether a text of unknown extension is in this format.
    looks_like: fn(&str) -> bool,
    /// Whether it is lines, of which a cut leaves some: what is nested does not read then.
    is_lines: bool,
    /// Reads a text, by the file's name without its folder.
    read: fn(&str, &ImportOptions<'_>, &str) -> Result<Draft, Vec<Problem>>,
}

/// Makes, from one line a format, the module, the variant of [`ImportFormat`] and its row:
/// `file: Variant "what it is";`. The file has a constant `FORMAT`.
macro_rules! formats {
    ($($file:ident: $format:ident $about:literal;)*) => {
        $(mod $file;)*

        /// A format that can be imported.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum ImportFormat {
            $(
                #[doc = $about]
                $format,
            )*
        }

        /// How many formats there are.
        const FORMATS: usize = [$(ImportFormat::$format),*].len();

        impl ImportFormat {
            /// All of them, by the names that people give.
            pub const NAMES: [(&'static str, ImportFormat); FORMATS] =
                [$(($file::FORMAT.name, ImportFormat::$format)),*];

            fn format(self) -> &'static Format {
                match self {
                    $(ImportFormat::$format => &$file::FORMAT,)*
                }
            }
        }
    };
}

formats! {
    linuxcnc: LinuxCnc "LinuxCNC's INI file.";
    grbl: Grbl "What grbl and grblHAL answer to `$$`.";
    freecad: FreeCad "FreeCAD's machine library (JSON).";
    urdf: Urdf "Unified robot description (XML).";
    klipper: Klipper "Klipper's printer.cfg.";
    fluidnc: FluidNc "FluidNC's configuration (YAML).";
    duet: Duet "RepRapFirmware's config.g.";
    marlin: Marlin "What Marlin answers to M503, or its Configuration.h.";
    sinumerik: Sinumerik "Machine data of a Sinumerik archive as text.";
    fanuc: Fanuc "Fanuc's parameters as punched out.";
    twincat: TwinCat "Axes of TwinCAT NC (XML).";
    mtconnect: MtConnect "MTConnect's device description (XML).";
}

impl ImportFormat {
    /// By extension, then by what the text looks like; `None` if no format claims it.
    pub fn recognise(name: &str, text: &str) -> Option<ImportFormat> {
        let text = without_mark(text);
        let all = || ImportFormat::NAMES.into_iter().map(|(_, format)| format);
        let extension = name
            .rsplit_once('.')
            .map(|(_, extension)| extension.to_ascii_lowercase())
            .unwrap_or_default();
        all()
            .find(|format| format.format().extensions.contains(&extension.as_str()))
            // Extensions go first: a text may look like more than one format.
            .or_else(|| all().find(|format| (format.format().looks_like)(text)))
    }
}

/// Axes that machines of controls for three axes have.
const XYZ: [AxisId; 3] = [AxisId::X, AxisId::Y, AxisId::Z];

/// Longest text that is read unless more is allowed, bytes: a description of a machine has some
/// thousand.
pub const MAX_BYTES: usize = 4 * 1024 * 1024;

/// The machine that lends what a description does not say if none is named.
pub const USUAL_PRESET: &str = crate::machine::DEFAULT_MACHINE;

/// What came of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// A machine file that [`Machine::from_toml`](crate::Machine::from_toml) accepts.
    pub toml: String,
    /// Every key, in the order of the file, then what was filled in.
    pub rows: Vec<Row>,
}

/// Where other files come from that a description names. Any function from a name to a text is one.
pub trait FileSource {
    /// The text of a file, by the name as it stands there, or why it cannot be had.
    ///
    /// # Errors
    /// The reason, for people.
    fn text(&self, name: &str) -> Result<String, String>;

    /// The names of the files in a folder, by the folder's name as it stands there, empty for that
    /// of the description; for names with wildcards.
    ///
    /// # Errors
    /// Why it cannot be had, for people.
    fn names(&self, folder: &str) -> Result<Vec<String>, String> {
        let _ = folder;
        Err("folders are not looked into here".to_owned())
    }
}

impl<F: Fn(&str) -> Result<String, String>> FileSource for F {
    fn text(&self, name: &str) -> Result<String, String> {
        self(name)
    }
}

/// A source of files that is borrowed.
pub type Files<'a> = &'a dyn FileSource;

/// What an import needs besides the text.
#[derive(Clone, Copy)]
pub struct ImportOptions<'a> {
    /// The machine that lends what the description does not say. If left out, [`USUAL_PRESET`]; axes
    /// that steppers move get a stepper's drive then, not one of its servos.
    pub preset: Option<&'a str>,
    /// Longest text that is read, with all files that it names, bytes.
    pub max_bytes: usize,
    /// The link at which the tool is, of a URDF tree that ends in several.
    pub tip: Option<&'a str>,
    /// Where other files come from that the description names (a LinuxCNC INI's `#INCLUDE` and
    /// HALFILE, Klipper's `[include]`).
    pub files: Files<'a>,
}

impl Default for ImportOptions<'_> {
    /// Of a description that stands alone: other files that it names are reported as not read.
    fn default() -> Self {
        ImportOptions {
            preset: None,
            max_bytes: MAX_BYTES,
            tip: None,
            files: &|_: &str| Err("other files are not read here".to_owned()),
        }
    }
}

impl ImportOptions<'_> {
    /// Of a description that stands alone, with the machine that lends the rest.
    pub fn new(preset: &str) -> ImportOptions<'_> {
        ImportOptions {
            preset: Some(preset),
            ..ImportOptions::default()
        }
    }
}

/// Turns a description into a machine file. `name` is the file's name.
///
/// ```
/// use lostmotion_sim::import::{ImportFormat, ImportOptions, import};
///
/// let ini = "[KINS]\nKINEMATICS = trivkins\n#INCLUDE x.inc\n";
/// let files = |name: &str| match name {
///     "x.inc" => Ok("[JOINT_0]\nMAX_VELOCITY = 50\n[AXIS_X]\nMAX_VELOCITY = 40\n".to_owned()),
///     _ => Err("there is no such file".to_owned()),
/// };
/// let options = ImportOptions { files: &files, ..ImportOptions::new("vmc3") };
/// let machine = import("mill.ini", ini, ImportFormat::LinuxCnc, &options)?;
/// assert!(machine.toml.contains("velocity_mm_s = 40.0 # [AXIS_X] MAX_VELOCITY"));
/// # Ok::<(), lostmotion_sim::machine::MachineError>(())
/// ```
///
/// # Errors
/// Everything that is wrong with the text, with its line; a machine that would not hold together;
/// an unknown preset.
pub fn import(
    name: &str,
    text: &str,
    format: ImportFormat,
    options: &ImportOptions<'_>,
) -> Result<Imported, MachineError> {
    let draft = read(name, text, format, options)?;
    fill::machine(name, draft, options.preset).map_err(|problems| MachineError::new(name, problems))
}

/// What a description tells, without a machine made of it.
///
/// ```
/// use lostmotion_sim::import::{Fate, ImportFormat, ImportOptions, rows};
///
/// let found = rows("grbl.txt", "$110=3000\n$32=1\n", ImportFormat::Grbl, &ImportOptions::default())?;
/// let rate = found.iter().find(|row| row.key == "$110").expect("a rate");
/// assert_eq!((rate.value.as_str(), rate.fate), ("3000", Fate::Used));
/// # Ok::<(), lostmotion_sim::machine::MachineError>(())
/// ```
///
/// # Errors
/// Everything that is wrong with the text, with its line.
pub fn rows(
    name: &str,
    text: &str,
    format: ImportFormat,
    options: &ImportOptions<'_>,
) -> Result<Vec<Row>, MachineError> {
    Ok(read(name, text, format, options)?.rows)
}

/// Reads the description in its format.
fn read(
    name: &str,
    text: &str,
    format: ImportFormat,
    options: &ImportOptions<'_>,
) -> Result<Draft, MachineError> {
    let fail = |problems| MachineError::new(name, problems);
    if text.len() > options.max_bytes {
        let message = format!(
            "has {} bytes; more than {} are no description of a machine",
            text.len(),
            options.max_bytes
        );
        return Err(fail(vec![problem(
            1,
            "",
            message,
            "allow more if it is one",
        )]));
    }
    let text = with_name(name, without_mark(text));
    let format = format.format();
    let files = WithoutMarks(options.files);
    let options = ImportOptions {
        files: &files,
        ..*options
    };
    let mut draft = (format.read)(&text, &options, file_name(name)).map_err(fail)?;
    if format.is_lines {
        draft.report_open_end(&text);
    }
    draft.report_missing();
    draft.forget_zero_gaps();
    draft.report_wide_gaps();
    gantry::settle(&mut draft);
    Ok(draft)
}

/// The mark of the order of bytes that editors of Windows put before a text in UTF-8.
const MARK: char = '\u{feff}';

/// A text without the mark before it, which would hide what its first line is.
fn without_mark(text: &str) -> &str {
    text.strip_prefix(MARK).unwrap_or(text)
}

/// Files without the marks before them.
struct WithoutMarks<'a>(Files<'a>);

impl FileSource for WithoutMarks<'_> {
    fn text(&self, name: &str) -> Result<String, String> {
        let mut text = self.0.text(name)?;
        if text.starts_with(MARK) {
            text.remove(0);
        }
        Ok(text)
    }

    fn names(&self, folder: &str) -> Result<Vec<String>, String> {
        self.0.names(folder)
    }
}

/// A file's name without its folder.
fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or_default()
}

/// TwinCAT writes this word into a file of one axis in the place of the axis' name, which is that of
/// the file.
const FILE_NAME: &str = "__FILENAME__";

/// The text with the file's name where it belongs.
fn with_name<'a>(name: &str, text: &'a str) -> Cow<'a, str> {
    if !text.contains(FILE_NAME) {
        return text.into();
    }
    let file = file_name(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    // Nothing that means something in XML.
    let plain: String = stem.chars().filter(|c| !"<>&\"'".contains(*c)).collect();
    text.replace(FILE_NAME, &plain).into()
}

/// An XML document of at most so many nodes.
fn xml(text: &str, nodes_limit: u32) -> Result<Document<'_>, Vec<Problem>> {
    let options = ParsingOptions {
        nodes_limit,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|error| {
        let line = usize::try_from(error.pos().row).unwrap_or(1);
        // It may cite the end of a line.
        let said = error.to_string().replace('\n', "\\n");
        vec![problem(line, "", format!("not XML: {said}"), "")]
    })
}

/// The axis of a name that is a letter with digits behind it or none: X, X1. ATC is none.
fn lettered(name: &str) -> Option<AxisId> {
    let mut letters = name.chars();
    let axis = letters.next().and_then(AxisId::from_letter)?;
    letters.all(|c| c.is_ascii_digit()).then_some(axis)
}

/// Why a position gain, 1/s, is not taken over alone.
fn untaken_gain(gain: f64) -> String {
    format!(
        "position_gain_per_s = {gain:.1}: the other gains come from the preset, set it with them"
    )
}

/// A problem at a line.
fn problem(line: usize, key: &str, message: impl Into<String>, hint: &str) -> Problem {
    Problem {
        line: u32::try_from(line).unwrap_or(u32::MAX),
        column: 1,
        key: key.to_owned(),
        message: message.into(),
        hint: hint.to_owned(),
        option: None,
    }
}

/// A finite number above 0.
fn positive(line: usize, key: &str, text: &str) -> Result<f64, Problem> {
    match number(line, key, text)? {
        value if value > 0.0 => Ok(value),
        _ => Err(problem(
            line,
            key,
            format!("is {}; it has to be above 0", text.trim()),
            "leave it out if it is not known",
        )),
    }
}

/// A finite number, 0 or above.
fn not_negative(line: usize, key: &str, text: &str) -> Result<f64, Problem> {
    match number(line, key, text)? {
        value if value >= 0.0 => Ok(value),
        _ => Err(problem(
            line,
            key,
            format!("is {}; it has to be 0 or above", text.trim()),
            "0 if there is none",
        )),
    }
}

/// A finite number.
fn number(line: usize, key: &str, text: &str) -> Result<f64, Problem> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(problem(
            line,
            key,
            format!("`{}` is not a number", text.trim()),
            "write a decimal number, such as 1500.0",
        )),
    }
}
