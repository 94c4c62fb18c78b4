//! `lostmotion study`: the test matrix, single cells, couplers, endurance, the paper, and sweeps.

mod drawn;
mod matrix;
mod sweep;

use crate::options::{methods as known_methods, number, whole};
use crate::output::{self, DONE, Failure};
use clap::{Args, Subcommand, ValueHint};
use lostmotion::base::{Clock, units};
use lostmotion::drive::AxisSample;
use lostmotion::identify::{
    BacklashFit, BacklashLog, FitError, FitSettings, MotorLog, fit_backlash, fit_motor_only,
};
use lostmotion::methods::{MethodId, UnknownMethod};
use lostmotion::report::WriteError;
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::number::{fixed, percent};
use lostmotion::report::page::study_page;
use lostmotion_study::StudyError;
use lostmotion_study::bench::{COUPLERS, Coupler, Recording, run as record};
use lostmotion_study::endurance::run as endure;
use lostmotion_study::matrix::motion::program as motion_program;
use lostmotion_study::matrix::{Cell, CellResult, Traced, run_cell, table};
use lostmotion_study::paper::{FORMS, Trial, figures, outlook, scan, shaft_trials, text, trials};
use std::io::{self, BufWriter, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

pub(crate) use sweep::ends_after_cells;

/// `study`.
#[derive(Debug, Subcommand)]
pub(crate) enum StudyCommand {
    /// Run the test matrix: motions, gaps, friction, inertia and encoders, with every method
    Matrix(matrix::MatrixArgs),
    /// Run machines and programs drawn at random: what methods do where nobody has tuned them
    Drawn(drawn::Drawn),
    /// Run one cell, of the matrix or drawn: its figures, its trace, and why a method that learns
    /// leaves what it leaves
    Cell(CellArgs),
    /// Two motors back to back, a coupler with a known gap and stiffness: what the fits and
    /// `adaptive` find of it
    Bench(Bench),
    /// An axis for an hour of motion and rest: whether what a method has learned stays
    Endurance(Endurance),
    /// The experiments of Gan, Wang, Huang, Machines 2023, 11(2), 193: figures 3 and 7 to 11, and
    /// what the paper does not say, scanned
    Paper(Paper),
    /// Many part programs, machines, methods and values of machine keys: planned, run on any number
    /// of machines, put together
    #[command(subcommand)]
    Sweep(sweep::SweepCommand),
}

/// `study cell`.
#[derive(Debug, Args)]
pub(crate) struct CellArgs {
    /// Name of the cell, from a table of the matrix or of `study drawn` (7-3-square20-f900, or 7-3)
    #[arg(required_unless_present_all = ["seed", "number"])]
    pub(crate) name: Option<String>,
    /// Seed of a drawn cell, in place of its name
    #[arg(long, value_name = "S", requires = "number", conflicts_with = "name", allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub(crate) seed: Option<u64>,
    /// Number of a drawn cell, from 0
    #[arg(long = "cell", id = "number", value_name = "N", requires = "seed", allow_negative_numbers = true, value_parser = whole::<u32>)]
    pub(crate) number: Option<u32>,
    /// Compensation method; `none`, and for a drawn cell `adaptive`, if left out
    #[arg(long, value_name = "NAME", value_parser = known_methods())]
    pub(crate) method: Option<String>,
    /// CSV to write: error and both axes, a row every 250 us; of a drawn cell what a method that learns
    /// believed, did and missed, and what is true, a row every 50 ms
    #[arg(long, short, value_name = "FILE.csv", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Also write the cell's part program
    #[arg(long, value_name = "FILE.ngc")]
    pub(crate) program: Option<PathBuf>,
}

/// `study bench`.
#[derive(Debug, Args)]
pub(crate) struct Bench {
    /// Total gap of the coupler in radian; five couplers, if left out
    #[arg(long, value_name = "N", requires = "stiffness_nm_per_rad", allow_negative_numbers = true, value_parser = number)]
    pub(crate) gap_rad: Option<f64>,
    /// Its stiffness in N m/rad
    #[arg(long, value_name = "N", requires = "gap_rad", allow_negative_numbers = true, value_parser = number)]
    pub(crate) stiffness_nm_per_rad: Option<f64>,
    #[command(flatten)]
    pub(crate) page: Page,
}

/// `study endurance`.
#[derive(Debug, Args)]
pub(crate) struct Endurance {
    /// Cell of the matrix whose axis runs, with drift over the whole time if its name ends so
    #[arg(long, value_name = "NAME", default_value = lostmotion_study::endurance::USUAL)]
    pub(crate) cell: String,
    /// Compensation method
    #[arg(long, value_name = "NAME", default_value = MethodId::ADAPTIVE.name(), value_parser = known_methods())]
    pub(crate) method: String,
    /// How long, in minutes of the machine's time
    #[arg(long, value_name = "N", default_value_t = 60.0, allow_negative_numbers = true, value_parser = number)]
    pub(crate) minutes: f64,
    #[command(flatten)]
    pub(crate) page: Page,
}

/// `study paper`.
#[derive(Debug, Args)]
pub(crate) struct Paper {
    /// Folder for table, scan and figures; made if it does not exist
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) page: Page,
}

/// The page of a study.
#[derive(Debug, Args)]
pub(crate) struct Page {
    /// Also write the answer as a page for a browser
    #[arg(long, value_name = "FILE.html", value_hint = ValueHint::FilePath)]
    html: Option<PathBuf>,
}

impl Page {
    /// Opens the file, if one was asked for: one that cannot be made is reported before the work is
    /// done.
    fn open(&self) -> Result<Option<AtomicFile>, Failure> {
        self.html.as_deref().map(output::create).transpose()
    }
}

/// Writes a page into a file that was opened for it.
fn write_page(file: Option<AtomicFile>, page: &str) -> Result<(), Failure> {
    if let Some(mut file) = file {
        let written = file.write_all(page.as_bytes());
        written.map_err(|error| WriteError::io("write", file.path(), error))?;
        file.commit()?;
    }
    Ok(())
}

/// Writes the page of an answer that has no chart into a file that was opened for it, and prints the
/// answer.
fn tell(file: Option<AtomicFile>, title: &str, markdown: &str) -> Result<(), Failure> {
    write_page(file, &study_page(title, &[], markdown))?;
    output::print(markdown)
}

/// Runs the study asked for.
pub(crate) fn run(study: &StudyCommand, quiet: bool) -> Result<u8, Failure> {
    match study {
        StudyCommand::Matrix(args) => matrix::run(args, quiet),
        StudyCommand::Drawn(args) => drawn::run(args),
        StudyCommand::Cell(args) => cell(args),
        StudyCommand::Bench(args) => bench(args),
        StudyCommand::Endurance(args) => endurance(args),
        StudyCommand::Paper(args) => paper(args),
        StudyCommand::Sweep(command) => sweep::run(command, quiet),
    }
}

fn failure(error: &StudyError) -> Failure {
    Failure::message(error.to_string())
}

/// The methods asked for, each once, without the baseline. If none is named: all but those that
/// need a fit, which a study does not have.
fn methods(asked: &[String]) -> Result<Vec<String>, Failure> {
    let mut methods: Vec<String> = Vec::new();
    let mut named = false;
    for name in asked.iter().filter(|name| !name.is_empty()) {
        // Twice the same hides that another was meant.
        if methods.contains(name) {
            return Err(Failure::message(format!(
                "--methods names \"{name}\" twice"
            )));
        }
        named = true;
        let method: MethodId = name
            .parse()
            .map_err(|error: UnknownMethod| Failure::message(error.to_string()))?;
        // `none` is run in every cell, since ratios refer to it.
        if !method.is_baseline() {
            methods.push(name.clone());
        }
    }
    // `none` alone was asked for if a name was given and the list is still empty.
    if !named {
        methods = MethodId::all()
            .filter(|method| !method.is_baseline() && !method.needs_fit())
            .map(|method| method.to_string())
            .collect();
    }
    Ok(methods)
}

fn same_file(path: &Path) -> Failure {
    Failure::with_hint(
        format!("--out and --program are both {}", path.display()),
        "name a file for each",
    )
}

/// Runs one cell of the matrix, whose trace is that of the method, or a drawn one.
fn cell(args: &CellArgs) -> Result<u8, Failure> {
    if let Some((seed, number)) = drawn::of_cell(args)? {
        return drawn::cell(args, seed, number);
    }
    let name = args.name.as_deref().unwrap_or_default();
    let cell = Cell::parse(name).map_err(|error| failure(&error))?;
    let none = MethodId::NONE.name().to_owned();
    let methods = methods(&[args.method.clone().unwrap_or(none)])?;
    if let Some(path) = args.out.as_ref().filter(|_| args.out == args.program) {
        return Err(same_file(path));
    }
    if let Some(path) = &args.program {
        let mut file = output::create(path)?;
        file.write_all(motion_program(&cell).as_bytes())
            .map_err(|error| WriteError::io("write", path, error))?;
        file.commit()?;
    }
    let result = match &args.out {
        None => run_cell(&cell, &methods, None).map_err(|error| failure(&error))?,
        Some(path) => traced(&cell, &methods, path)?,
    };
    output::print(&table::csv(&[result]))?;
    Ok(DONE)
}

fn traced(cell: &Cell, methods: &[String], path: &Path) -> Result<CellResult, Failure> {
    let unwritten = |error| Failure::from(WriteError::io("write", path, error));
    let mut file = BufWriter::new(output::create(path)?);
    writeln!(
        file,
        "t_s,error_um,error_without_gap_um,measured{}{}",
        columns("x"),
        columns("y")
    )
    .map_err(unwritten)?;
    // The sink cannot fail: the first error is kept, and told when the cell is done.
    let mut written = Ok(());
    let result = run_cell(
        cell,
        methods,
        Some(&mut |row| {
            if written.is_ok() {
                written = write_row(&mut file, row);
            }
        }),
    );
    let result = result.map_err(|error| failure(&error))?;
    written.map_err(unwritten)?;
    // The buffer is emptied before the file takes its name.
    let file = file
        .into_inner()
        .map_err(|error| unwritten(error.into_error()))?;
    file.commit()?;
    Ok(result)
}

/// Columns of an axis; angles at the motor.
fn columns(axis: &str) -> String {
    let names = [
        "reference_rad",
        "reference_rad_s",
        "reference_rad_s2",
        "motor_rad",
        "load_rad",
        "torque_nm",
        "engagement",
        "gap_estimate_rad",
        "inertia_estimate_kgm2",
        "engagement_estimate",
        "stiffness_estimate_nm_per_rad",
        "damping_estimate_nm_s_per_rad",
    ];
    names.map(|name| format!(",{axis}_{name}")).concat()
}

fn write_row(out: &mut impl Write, row: &Traced) -> io::Result<()> {
    let [error, without] = row.error_um;
    write!(
        out,
        "{},{error:.4},{without:.4},{}",
        Clock::SERVO.seconds(row.tick),
        u8::from(row.measured)
    )?;
    for sample in &row.axes {
        let AxisSample {
            reference,
            motor_position,
            load_position,
            torque,
            engagement,
            engagement_estimate,
            ..
        } = sample;
        write!(
            out,
            ",{:.9},{:.6},{:.4}",
            reference.position, reference.velocity, reference.acceleration
        )?;
        write!(
            out,
            ",{motor_position:.9},{load_position:.9},{torque:.6},{}",
            engagement.sign()
        )?;
        // An estimate that a method does not make is an empty cell.
        for estimate in [sample.gap_angle_estimate, sample.inertia_estimate] {
            if estimate.is_finite() {
                write!(out, ",{estimate:.9}")?;
            } else {
                write!(out, ",")?;
            }
        }
        write!(out, ",{}", engagement_estimate.sign())?;
        for estimate in [sample.stiffness_estimate, sample.damping_estimate] {
            if estimate.is_finite() {
                write!(out, ",{estimate:.4}")?;
            } else {
                write!(out, ",")?;
            }
        }
    }
    writeln!(out)
}

/// Gaps that a coupler may have, rad. From far below what an encoder sees up to half a turn.
const COUPLER_GAPS_RAD: RangeInclusive<f64> = 1e-6..=3.0;

/// Prints what was set, and what was found by each that looked.
fn bench(args: &Bench) -> Result<u8, Failure> {
    // Asked for the good range, which NaN is outside of.
    if let Some(gap_rad) = args.gap_rad
        && !COUPLER_GAPS_RAD.contains(&gap_rad)
    {
        return Err(Failure::with_hint(
            format!(
                "--gap-rad is {}; it has to be from {} to {}",
                units::number(gap_rad),
                COUPLER_GAPS_RAD.start(),
                COUPLER_GAPS_RAD.end()
            ),
            "what is found is held against it, in per cent",
        ));
    }
    let couplers = match (args.gap_rad, args.stiffness_nm_per_rad) {
        (Some(gap_rad), Some(stiffness_nm_per_rad)) => vec![Coupler {
            gap_rad,
            stiffness_nm_per_rad,
        }],
        _ => COUPLERS.to_vec(),
    };
    let page = args.page.open()?;
    let mut out =
        "| gap, rad | stiffness, N m/rad | `fit`: gap | stiffness | `fit --motor-only`: gap | stiffness | `adaptive`: gap | stiffness | damping |\n"
            .to_owned();
    out.push_str("|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for coupler in couplers {
        let recording = record(&coupler).map_err(|error| failure(&error))?;
        // Three looks at one recording: both fits afterwards, and what `adaptive` learned on the
        // way.
        let found = [with_load(&recording), motor_only(&recording)].map(|fit| shown(&coupler, fit));
        let learned = recording
            .adaptive_gap_rad
            .map_or("-".to_owned(), |gap| off(gap, coupler.gap_rad));
        let (gap, stiffness) = (coupler.gap_rad, coupler.stiffness_nm_per_rad);
        let online = online(
            &coupler,
            recording.axis.motor.inertia_kgm2,
            recording.online,
        );
        out.push_str(&format!(
            "| {gap} | {stiffness} | {} | {learned} | {online} |\n",
            found.join(" | ")
        ));
    }
    tell(page, "Couplers with a known gap", &out)?;
    Ok(DONE)
}

fn with_load(recording: &Recording) -> Result<BacklashFit, FitError> {
    let log = BacklashLog::from_samples(Clock::SERVO.period_s(), &recording.loaded)?;
    fit_backlash(&log, &FitSettings::for_axis(&recording.axis))
}

fn motor_only(recording: &Recording) -> Result<BacklashFit, FitError> {
    // The towed run: without the load's position the fit assumes that only friction and inertia act
    // on it, which a second motor that pulls and pushes would violate.
    let motor = recording
        .towed
        .iter()
        .map(|sample| sample.motor_position)
        .collect();
    let current = recording
        .towed
        .iter()
        .map(|sample| sample.current)
        .collect();
    let log = MotorLog::new(Clock::SERVO.period_s(), motor, current)?;
    fit_motor_only(&log, &FitSettings::for_axis(&recording.axis).motor_only())
}

/// Gap and stiffness off what was set; why there is none.
fn shown(coupler: &Coupler, fit: Result<BacklashFit, FitError>) -> String {
    match fit {
        Ok(fit) => {
            // The fit is convex in the compliance; people think in its reciprocal.
            let stiffness = 1.0 / fit.compliance_rad_per_nm;
            format!(
                "{} | {}",
                off(2.0 * fit.half_gap_rad, coupler.gap_rad),
                off(stiffness, coupler.stiffness_nm_per_rad)
            )
        }
        Err(error) => format!("{error} | -"),
    }
}

/// Stiffness and damping off what was set.
fn online(coupler: &Coupler, rotor_kgm2: f64, found: Option<[f64; 2]>) -> String {
    found.map_or("not excited | -".to_owned(), |[stiffness, damping]| {
        let known = if damping.is_finite() {
            off(damping, coupler.damping_nm_s_per_rad(rotor_kgm2))
        } else {
            "not known".to_owned()
        };
        format!("{} | {known}", off(stiffness, coupler.stiffness_nm_per_rad))
    })
}

fn off(found: f64, set: f64) -> String {
    format!("{:+.2} %", 100.0 * (found / set - 1.0))
}

/// Longest run, minutes: a day.
const MOST_MINUTES: f64 = 1440.0;

/// Runs an axis and prints what each stretch of the time showed.
fn endurance(args: &Endurance) -> Result<u8, Failure> {
    // Asked for the good range, which NaN is outside of.
    if !(args.minutes > 0.0 && args.minutes <= MOST_MINUTES) {
        return Err(Failure::with_hint(
            format!(
                "--minutes is {}; it has to be above 0, up to {MOST_MINUTES}",
                args.minutes
            ),
            "",
        ));
    }
    let cell = Cell::parse(&args.cell).map_err(|error| failure(&error))?;
    let method: MethodId = args
        .method
        .parse()
        .map_err(|error: UnknownMethod| Failure::message(error.to_string()))?;
    let page = args.page.open()?;
    let stretches = endure(&cell, method, 60.0 * args.minutes).map_err(|error| failure(&error))?;
    let mut out = format!(
        "what the gap adds to the load's place, X of {cell}\n\n| until min | `none`: RMS, um | max, um | `{0}`: RMS, um | max, um | RMS of none | gap off by |\n|--:|--:|--:|--:|--:|--:|--:|\n",
        args.method
    );
    for stretch in &stretches {
        let ([none, rms], [none_max, max]) = (stretch.rms_um, stretch.max_um);
        let gap = stretch
            .gap_error
            .map_or("-".to_owned(), |error| format!("{:.2} %", 100.0 * error));
        let columns = [none, none_max, rms, max]
            .map(|um| fixed(um, 3))
            .join(" | ");
        // An axis that has not moved has no error to leave a part of.
        let left = match (none > 0.0, rms > 0.0) {
            (true, _) => percent(rms / none),
            (false, true) => "-".to_owned(),
            (false, false) => "no motion".to_owned(),
        };
        out.push_str(&format!(
            "| {} | {columns} | {} | {gap} |\n",
            fixed(stretch.until_s / 60.0, 1),
            left
        ));
    }
    let title = format!(
        "{} for {} minutes",
        args.method,
        units::number(args.minutes)
    );
    tell(page, &title, &out)?;
    Ok(DONE)
}

/// Runs the paper's experiments again.
pub(crate) fn paper(args: &Paper) -> Result<u8, Failure> {
    let failed = |error: StudyError| Failure::message(error.to_string());
    // A folder that cannot be made is reported before the work is done.
    let folder = args.out.as_deref().map(output::create_folder).transpose()?;
    let page = args.page.open()?;
    let trials = trials(&Trial::CHOSEN, &FORMS).map_err(failed)?;
    let scanned = scan().map_err(failed)?;
    let shafts = shaft_trials().map_err(failed)?;
    let markdown = text::markdown(&trials, &scanned, &shafts);
    if let Some(mut folder) = folder {
        let mut files = vec![
            ("paper.md".to_owned(), markdown.clone()),
            ("scan.csv".to_owned(), text::csv(&scanned)),
        ];
        files.extend(figures::figures(&trials));
        files.extend(figures::scan_figures(&scanned));
        files.extend(outlook::figures(&shafts));
        for (name, content) in files {
            let mut file = folder.file(&name)?;
            file.write_all(content.as_bytes())
                .map_err(|error| WriteError::io("write into", folder.path(), error))?;
            folder.add(file);
        }
        folder.commit()?;
    }
    tell(page, "The experiments of the paper", &markdown)?;
    Ok(DONE)
}
