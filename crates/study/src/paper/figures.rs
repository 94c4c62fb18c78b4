//! The paper's figures, drawn from our runs.

use super::trial::{FORMS, Scan, Trials};
use lostmotion_base::{Clock, math};
use lostmotion_drive::AxisSample;
use lostmotion_methods::MethodId;
use lostmotion_report::svg::{Series, SeriesPicture, series};

/// A picture with the name of its file.
pub type Figure = (String, String);

/// A curve's value at a servo tick.
type Value = fn(&AxisSample) -> f64;

const REFERENCE: Value = |s| s.reference.position;
const MOTOR: Value = |s| s.motor_position;
const LOAD: Value = |s| s.load_position;

/// One curve of a picture: its name, its run, and the value that is drawn.
type Curve = (&'static str, usize, Value);

/// One picture.
struct Plot {
    file: &'static str,
    title: &'static str,
    y_label: &'static str,
    curves: Vec<Curve>,
    /// Around the first stop only, s before and after.
    zoom: Option<[f64; 2]>,
}

impl Plot {
    /// From the first stop on, until the load has settled.
    fn at_the_first_stop(self) -> Plot {
        Plot {
            zoom: Some([0.0, 0.4]),
            ..self
        }
    }
}

/// Inertias of the paper's Tables 2 and 3.
const MOTOR_KGM2: f64 = 0.00189;
const LOAD_KGM2: f64 = 0.0065;

/// Index of each method's run.
const NONE: usize = 0;
const PUBLISHED: usize = 1;
const LITERAL: usize = 2;

/// The pictures of the paper, in its order.
fn plots() -> Vec<Plot> {
    vec![
        position(
            "figure_03.svg",
            "Figure 3: the load stops off the motor by half the gap",
            NONE,
        )
        .at_the_first_stop(),
        position(
            "figure_07_position.svg",
            "Figure 7: without compensation, position",
            NONE,
        ),
        velocity(
            "figure_07_velocity.svg",
            "Figure 7: without compensation, velocity",
            NONE,
        ),
        current(
            "figure_07_current.svg",
            "Figure 7: without compensation, current",
            NONE,
        ),
        position(
            "figure_08_position.svg",
            "Figure 8: published compensation, position",
            PUBLISHED,
        ),
        velocity(
            "figure_08_velocity.svg",
            "Figure 8: published compensation, velocity",
            PUBLISHED,
        ),
        current(
            "figure_08_current.svg",
            "Figure 8: published compensation, current",
            PUBLISHED,
        ),
        load_of_each_method().at_the_first_stop(),
        error(),
        backlash_angle(),
        inertia(),
        engagement(),
    ]
}

/// Positions in a run.
fn position(file: &'static str, title: &'static str, run: usize) -> Plot {
    Plot {
        file,
        title,
        y_label: "position, rad",
        curves: vec![
            ("reference", run, REFERENCE),
            ("motor", run, MOTOR),
            ("load", run, LOAD),
        ],
        zoom: None,
    }
}

/// Velocities in a run.
fn velocity(file: &'static str, title: &'static str, run: usize) -> Plot {
    Plot {
        file,
        title,
        y_label: "velocity, rad/s",
        curves: vec![
            ("reference", run, |s| s.reference.velocity),
            ("motor", run, |s| s.motor_velocity),
            ("load", run, |s| s.load_velocity),
        ],
        zoom: None,
    }
}

/// The current in a run.
fn current(file: &'static str, title: &'static str, run: usize) -> Plot {
    Plot {
        file,
        title,
        y_label: "current, A",
        curves: vec![("i_q", run, |s| s.current)],
        zoom: None,
    }
}

fn load_of_each_method() -> Plot {
    Plot {
        file: "figure_09.svg",
        title: "Figure 9: position of the load at the first stop",
        y_label: "position, rad",
        curves: vec![
            // The reference is the same in every run.
            ("reference", NONE, REFERENCE),
            ("none", NONE, LOAD),
            ("published", PUBLISHED, LOAD),
            ("published-literal", LITERAL, LOAD),
        ],
        zoom: None,
    }
}

fn error() -> Plot {
    let error: Value = |s| s.reference.position - s.load_position;
    Plot {
        file: "figure_10_error.svg",
        title: "Figure 10, upper: reference minus load",
        y_label: "position error, rad",
        curves: vec![("none", NONE, error), ("published", PUBLISHED, error)],
        zoom: None,
    }
}

fn backlash_angle() -> Plot {
    let estimate: Value = |s| s.gap_angle_estimate;
    Plot {
        file: "figure_10_estimate.svg",
        title: "Figure 10, lower: backlash angle, true and estimated",
        y_label: "angle, rad",
        curves: vec![
            ("true", PUBLISHED, |s| s.motor_position - s.load_position),
            ("published", PUBLISHED, estimate),
            ("published-literal", LITERAL, estimate),
        ],
        zoom: None,
    }
}

fn inertia() -> Plot {
    Plot {
        file: "figure_11_inertia.svg",
        title: "Figure 11, upper: inertia at the motor, cut off at -0.005 and 0.020",
        y_label: "inertia, kg m\u{b2}",
        curves: vec![
            // Cut off: its excursions would press both true values flat.
            ("published", PUBLISHED, |s| {
                s.inertia_estimate.clamp(-0.005, 0.02)
            }),
            ("true: motor alone", PUBLISHED, |_| MOTOR_KGM2),
            ("true: motor and load", PUBLISHED, |_| {
                MOTOR_KGM2 + LOAD_KGM2
            }),
        ],
        zoom: None,
    }
}

fn engagement() -> Plot {
    Plot {
        file: "figure_11_engagement.svg",
        title: "Figure 11, lower: engagement, true and estimated",
        y_label: "flank (0 in the gap)",
        curves: vec![
            ("true", PUBLISHED, |s| f64::from(s.engagement.sign())),
            ("estimated", PUBLISHED, |s| {
                f64::from(s.engagement_estimate.sign())
            }),
        ],
        zoom: None,
    }
}

/// Figures 3 and 7 to 11.
pub fn figures(trials: &Trials) -> Vec<Figure> {
    plots()
        .iter()
        .map(|plot| (plot.file.to_owned(), draw(plot, trials)))
        .collect()
}

fn draw(plot: &Plot, trials: &Trials) -> String {
    let stop = trials.trial.motion.first_stop_s();
    // The paper zooms into the first stop, where the flank changes.
    let [from, to] = plot.zoom.map_or([0.0, f64::INFINITY], |[before, after]| {
        [stop - before, stop + after]
    });
    let curve = |(name, run, value): &Curve| {
        let samples = trials
            .runs
            .get(*run)
            .map_or(&[][..], |(_, _, samples)| samples);
        let points = samples
            .iter()
            .zip(0..)
            .map(|(sample, tick)| [Clock::SERVO.seconds(tick), value(sample)]);
        Series {
            name: (*name).to_owned(),
            points: points.filter(|[t, _]| (from..=to).contains(t)).collect(),
        }
    };
    let picture = SeriesPicture {
        title: plot.title.to_owned(),
        x_label: "time, s".to_owned(),
        y_label: plot.y_label.to_owned(),
    };
    series(&picture, &plot.curves.iter().map(curve).collect::<Vec<_>>())
}

/// Settled offset over P0, a curve a lambda, for both forms.
pub fn scan_figures(scan: &Scan) -> Vec<Figure> {
    FORMS
        .map(|form| (format!("scan_{form}.svg"), scan_figure(scan, form)))
        .into()
}

/// Lambdas drawn: as many as can be told apart.
const DRAWN_LAMBDAS: [f64; 4] = [0.3, 0.5, 0.6, 0.7];
/// Value at which the curves are cut off, per cent of half the gap: beyond it they have run away.
const HIGHEST_PERCENT: f64 = 250.0;

fn scan_figure(scan: &Scan, form: MethodId) -> String {
    let curve = |lambda: f64| {
        // Over the logarithm: P0 is scanned through eight decades.
        let points = scan
            .tuning
            .iter()
            .filter(|point| point.method == form && (point.trial.lambda - lambda).abs() < 1e-9);
        let points = points
            .map(|point| {
                [
                    math::log10(point.trial.p0),
                    (100.0 * point.offset).min(HIGHEST_PERCENT),
                ]
            })
            .collect();
        Series {
            name: format!("\u{3bb} {lambda}"),
            points,
        }
    };
    let picture = SeriesPicture {
        title: format!(
            "{form}: settled offset of the load over P0 (cut off at {HIGHEST_PERCENT} %)"
        ),
        x_label: "P0, as a power of ten".to_owned(),
        y_label: "offset, % of half the gap".to_owned(),
    };
    let mut curves: Vec<Series> = DRAWN_LAMBDAS.map(curve).into();
    // The paper's claim as a horizontal line.
    let ends = super::trial::P0
        .iter()
        .map(|p0| [math::log10(*p0), 100.0 * super::CLAIM])
        .collect();
    curves.push(Series {
        name: "15 %".to_owned(),
        points: ends,
    });
    series(&picture, &curves)
}
