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

/// Inertias of the paper's Tables 2 and 3.
const MOTOR_KGM2: f64 = 0.00189;
const LOAD_KGM2: f64 = 0.0065;

/// Index of each method's run.
const NONE: usize = 0;
const PUBLISHED: usize = 1;
const LITERAL: usize = 2;

/// The pictures of the paper, in its order.
fn plots() -> Vec<Plot> {
    let plot = |file, title, y_label, curves: &[Curve], zoom| Plot {
        file,
        title,
        y_label,
        curves: curves.to_vec(),
        zoom,
    };
    let position = |run| {
        [
            ("reference", run, REFERENCE),
            ("motor", run, MOTOR),
            ("load", run, LOAD),
        ]
    };
    let velocity = |run| -> [Curve; 3] {
        [
            ("reference", run, |s| s.reference.velocity),
            ("motor", run, |s| s.motor_velocity),
            ("load", run, |s| s.load_velocity),
        ]
    };
    let current = |run| -> [Curve; 1] { [("i_q", run, |s| s.current)] };
    // From the first stop on, until the load has settled.
    let near = Some([0.0, 0.4]);
    let error: Value = |s| s.reference.position - s.load_position;
    let angle: Value = |s| s.motor_position - s.load_position;
    let (rad, rad_s, a) = ("position, rad", "velocity, rad/s", "current, A");
    vec![
        plot(
            "figure_03.svg",
            "Figure 3: the load stops off the motor by half the gap",
            rad,
            &position(NONE),
            near,
        ),
        plot(
            "figure_07_position.svg",
            "Figure 7: without compensation, position",
            rad,
            &position(NONE),
            None,
        ),
        plot(
            "figure_07_velocity.svg",
            "Figure 7: without compensation, velocity",
            rad_s,
            &velocity(NONE),
            None,
        ),
        plot(
            "figure_07_current.svg",
            "Figure 7: without compensation, current",
            a,
            &current(NONE),
            None,
        ),
        plot(
            "figure_08_position.svg",
            "Figure 8: published compensation, position",
            rad,
            &position(PUBLISHED),
            None,
        ),
        plot(
            "figure_08_velocity.svg",
            "Figure 8: published compensation, velocity",
            rad_s,
            &velocity(PUBLISHED),
            None,
        ),
        plot(
            "figure_08_current.svg",
            "Figure 8: published compensation, current",
            a,
            &current(PUBLISHED),
            None,
        ),
        plot(
            "figure_09.svg",
            "Figure 9: position of the load at the first stop",
            rad,
            &[
                // The reference is the same in every run.
                ("reference", NONE, REFERENCE),
                ("none", NONE, LOAD),
                ("published", PUBLISHED, LOAD),
                ("published-literal", LITERAL, LOAD),
            ],
            near,
        ),
        plot(
            "figure_10_error.svg",
            "Figure 10, upper: reference minus load",
            "position error, rad",
            &[("none", NONE, error), ("published", PUBLISHED, error)],
            None,
        ),
        plot(
            "figure_10_estimate.svg",
            "Figure 10, lower: backlash angle, true and estimated",
            "angle, rad",
            &[
                ("true", PUBLISHED, angle),
                ("published", PUBLISHED, |s| s.gap_angle_estimate),
                ("published-literal", LITERAL, |s| s.gap_angle_estimate),
            ],
            None,
        ),
        plot(
            "figure_11_inertia.svg",
            "Figure 11, upper: inertia at the motor, cut off at -0.005 and 0.020",
            "inertia, kg m\u{b2}",
            &[
                // Cut off: its excursions would press both true values flat.
                ("published", PUBLISHED, |s| {
                    s.inertia_estimate.clamp(-0.005, 0.02)
                }),
                ("true: motor alone", PUBLISHED, |_| MOTOR_KGM2),
                ("true: motor and load", PUBLISHED, |_| {
                    MOTOR_KGM2 + LOAD_KGM2
                }),
            ],
            None,
        ),
        plot(
            "figure_11_engagement.svg",
            "Figure 11, lower: engagement, true and estimated",
            "flank (0 in the gap)",
            &[
                ("true", PUBLISHED, |s| f64::from(s.engagement.sign())),
                ("estimated", PUBLISHED, |s| {
                    f64::from(s.engagement_estimate.sign())
                }),
            ],
            None,
        ),
    ]
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
