//! What a sweep file says.

use crate::design::{Design, Level, MOST_DIMENSIONS, Scale, Span};
use crate::error::SweepError;
use lostmotion_methods::MethodId;
use lostmotion_sim::machine::DEFAULT_MACHINE;
use lostmotion_sim::request::{ReadingRequest, RunRequest};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeSet;

/// Most cells of a sweep whose file does not say another number. A choice: what two cores do in a
/// night.
pub const MOST_CELLS: usize = 100_000;

/// A sweep file, checked as far as that goes without its programs and machines.
///
/// ```
/// use lostmotion_sweep::file::SweepFile;
///
/// let text = r#"
///     programs = ["parts/*.ngc"]
///     methods = ["none", "fixed"]
///
///     [[vary]]
///     name = "gap_um"
///     keys = ["axis.x.load.slide.gap_um", "axis.y.load.slide.gap_um"]
///     values = [0, 10, 20, 40]
/// "#;
/// let file = SweepFile::from_toml("gaps.toml", text)?;
/// assert_eq!(file.spans()[0].count(), 4);
/// # Ok::<(), lostmotion_sweep::SweepError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SweepFile {
    name: String,
    settings: Settings,
    spans: Vec<Span>,
}

/// The tables of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    programs: Vec<String>,
    #[serde(default = "usual_machines")]
    machines: Vec<String>,
    #[serde(default = "usual_methods")]
    methods: Vec<String>,
    #[serde(default)]
    design: Design,
    points: Option<usize>,
    seed: Option<u64>,
    most_cells: Option<usize>,
    #[serde(default)]
    vary: Vec<Vary>,
    #[serde(default = "nothing")]
    reading: Value,
    #[serde(default = "nothing")]
    run: Value,
}

/// What is varied: keys that get the same value, and which values.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Vary {
    name: Option<String>,
    keys: Vec<String>,
    values: Option<Vec<Level>>,
    from: Option<f64>,
    to: Option<f64>,
    steps: Option<usize>,
    #[serde(default)]
    scale: Scale,
}

fn usual_machines() -> Vec<String> {
    vec![DEFAULT_MACHINE.to_owned()]
}

fn usual_methods() -> Vec<String> {
    vec![MethodId::NONE.name().to_owned()]
}

fn nothing() -> Value {
    Value::Object(serde_json::Map::new())
}

/// The first of some texts that stands there twice.
fn twice<'a>(texts: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = BTreeSet::new();
    texts.into_iter().find(|text| !seen.insert(*text))
}

/// What is wrong with a value, and what to do.
type Wrong = (String, String);

fn wrong(message: impl Into<String>, hint: &str) -> Wrong {
    (message.into(), hint.to_owned())
}

impl SweepFile {
    /// Reads a sweep file. `name` is the file's name, for messages only.
    ///
    /// # Errors
    /// What is wrong first: syntax, unknown and missing keys, lists that are empty or name something
    /// twice, ranges without ends.
    pub fn from_toml(name: &str, text: &str) -> Result<SweepFile, SweepError> {
        let refused = |(message, hint): Wrong| SweepError::File {
            file: name.to_owned(),
            message,
            hint,
        };
        let settings: Settings = toml::from_str(text)
            .map_err(|error| refused(wrong(error.to_string().trim_end(), "")))?;
        settings.check().map_err(refused)?;
        let spans = settings.vary.iter().map(|vary| vary.span(settings.design));
        let spans = spans.collect::<Result<Vec<_>, _>>().map_err(refused)?;
        Ok(SweepFile {
            name: name.to_owned(),
            settings,
            spans,
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Patterns of the programs' names.
    pub fn programs(&self) -> &[String] {
        &self.settings.programs
    }

    /// Names of machines, and of machine files.
    pub fn machines(&self) -> &[String] {
        &self.settings.machines
    }

    /// Names of compensation methods, run side by side in each cell.
    pub fn methods(&self) -> &[String] {
        &self.settings.methods
    }

    /// How points are chosen.
    pub fn design(&self) -> Design {
        self.settings.design
    }

    /// Number of points; what a grid has is not told.
    pub fn points(&self) -> usize {
        self.settings.points.unwrap_or_default()
    }

    /// Seed of random points.
    pub fn seed(&self) -> u64 {
        self.settings.seed.unwrap_or(1)
    }

    /// Most cells that it may have.
    pub fn most_cells(&self) -> usize {
        self.settings.most_cells.unwrap_or(MOST_CELLS)
    }

    /// What is varied: for each coordinate its name and the keys that get its value.
    pub fn coordinates(&self) -> impl Iterator<Item = (&str, &[String])> {
        let vary = self.settings.vary.iter();
        vary.map(|vary| (vary.name(), vary.keys.as_slice()))
    }

    /// The values of each coordinate.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// How programs are read and run, as the file has it.
    pub fn requests(&self) -> (&Value, &Value) {
        (&self.settings.reading, &self.settings.run)
    }
}

impl Settings {
    fn check(&self) -> Result<(), Wrong> {
        if self.programs.is_empty() {
            return Err(wrong(
                "`programs` is empty: there is nothing to run",
                "for example: programs = [\"parts/*.ngc\"]",
            ));
        }
        for (key, list) in [
            ("programs", &self.programs),
            ("machines", &self.machines),
            ("methods", &self.methods),
        ] {
            if list.is_empty() {
                let hint = "leave it out for the usual one";
                return Err(wrong(format!("`{key}` is empty"), hint));
            }
            if let Some(name) = twice(list.iter().map(String::as_str)) {
                return Err(wrong(format!("`{key}` names \"{name}\" twice"), ""));
            }
        }
        for name in &self.methods {
            name.parse::<MethodId>()
                .map_err(|error| wrong(format!("`methods`: {error}"), ""))?;
        }
        self.check_design()?;
        // Two names of one coordinate could not be told apart in the table.
        if let Some(name) = twice(self.vary.iter().map(Vary::name)) {
            return Err(wrong(
                format!("two [[vary]] are named \"{name}\""),
                "`name` gives each a name of its own",
            ));
        }
        let keys = self.vary.iter().flat_map(|vary| &vary.keys);
        if let Some(key) = twice(keys.map(|key| key.trim())) {
            return Err(wrong(
                format!("the key {key} is varied twice"),
                "name each key in one [[vary]] alone",
            ));
        }
        check_request::<ReadingRequest>("reading", &self.reading)?;
        check_request::<RunRequest>("run", &self.run)?;
        if self.run.get("threads").is_some() {
            return Err(wrong(
                "`run.threads`: cells run side by side, each on one thread",
                "`study sweep run --threads` says how many",
            ));
        }
        Ok(())
    }

    fn check_design(&self) -> Result<(), Wrong> {
        let is_grid = self.design == Design::Grid;
        match self.points {
            Some(_) if is_grid => Err(wrong(
                "`points` is given, but a grid has as many as its levels make",
                "design = \"random\" or \"sobol\" takes a number of points",
            )),
            None | Some(0) if !is_grid => Err(wrong(
                "`points` is missing or 0: how many points are to be drawn?",
                "for example: points = 256",
            )),
            _ if self.seed.is_some() && self.design != Design::Random => Err(wrong(
                "`seed` is given, but only random points have one",
                "leave it out, or take design = \"random\"",
            )),
            _ if !is_grid && self.vary.is_empty() => Err(wrong(
                "there is no [[vary]]: all points would be the same",
                "a grid without [[vary]] runs every program on every machine once",
            )),
            _ if self.design == Design::Sobol && self.vary.len() > MOST_DIMENSIONS => Err(wrong(
                format!(
                    "{} [[vary]] with design = \"sobol\", which takes {MOST_DIMENSIONS}",
                    self.vary.len()
                ),
                "design = \"random\" takes any number",
            )),
            _ => Ok(()),
        }
    }
}

/// Whether a table is a request of this kind; what its values mean is seen with a machine.
fn check_request<T: for<'de> Deserialize<'de>>(key: &str, table: &Value) -> Result<(), Wrong> {
    match T::deserialize(table) {
        Ok(_) => Ok(()),
        Err(error) => Err(wrong(format!("[{key}]: {error}"), "")),
    }
}

impl Vary {
    /// Its name: the one it is given, or its first key.
    fn name(&self) -> &str {
        let first = self.keys.first().map_or("", |key| key.trim());
        self.name.as_deref().map_or(first, str::trim)
    }

    fn span(&self, design: Design) -> Result<Span, Wrong> {
        let name = self.name();
        let refused =
            |message: &str, hint: &str| Err(wrong(format!("[[vary]] \"{name}\": {message}"), hint));
        if name.is_empty() || self.keys.iter().any(|key| key.trim().is_empty()) {
            return refused(
                "it names no key",
                "for example: keys = [\"axis.x.load.slide.gap_um\"]",
            );
        }
        match (&self.values, self.from, self.to) {
            (Some(values), None, None) => {
                if self.steps.is_some() || self.scale != Scale::Linear {
                    return refused(
                        "`steps` and `scale` are of a range",
                        "leave out `values`, or these",
                    );
                }
                if values.is_empty() {
                    return refused("`values` is empty: there would be no cells", "");
                }
                let unfit =
                    |level: &&Level| matches!(level, Level::Number(number) if !number.is_finite());
                if let Some(level) = values.iter().find(unfit) {
                    return refused(&format!("{level} is not a finite number"), "");
                }
                let shown: Vec<String> = values.iter().map(ToString::to_string).collect();
                if let Some(value) = twice(shown.iter().map(String::as_str)) {
                    return refused(&format!("`values` has {value} twice"), "");
                }
                Ok(Span::Levels(values.clone()))
            }
            (None, Some(from), Some(to)) => {
                if !from.is_finite() || !to.is_finite() || from.to_bits() == to.to_bits() {
                    return refused(
                        &format!("from {from} to {to} is no range"),
                        "both have to be finite, and different",
                    );
                }
                if self.scale == Scale::Log && !(from > 0.0 && to > 0.0) {
                    return refused(
                        &format!("from {from} to {to} has no logarithm"),
                        "both ends have to be above 0, or scale = \"linear\"",
                    );
                }
                let steps = match (design, self.steps) {
                    (Design::Grid, Some(steps)) if steps >= 2 => steps,
                    (Design::Grid, _) => {
                        return refused(
                            "a range in a grid needs `steps`, 2 or more",
                            "for example: steps = 5, both ends among them",
                        );
                    }
                    (_, Some(_)) => {
                        return refused(
                            "`steps` is of a grid; points are drawn from the range",
                            "",
                        );
                    }
                    (_, None) => 0,
                };
                Ok(Span::Range {
                    from,
                    to,
                    scale: self.scale,
                    steps,
                })
            }
            _ => refused(
                "it needs either `values`, or `from` and `to`",
                "for example: values = [0, 10, 20]",
            ),
        }
    }
}
