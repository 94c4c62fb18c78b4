//! The page of a run: what it says without scripts, that its data is what the run measured, and that
//! no program breaks out of it.

use lostmotion_base::Plane;
use lostmotion_contour::Circle;
use lostmotion_drive::{Learned, Learning};
use lostmotion_report::page::{Gathered, PageRecorder, page};
use lostmotion_sim::options::SimulateOptions;
use lostmotion_sim::{ContourPoint, Machine, MotorPoint, Observer, Program, Run, Simulation};
use serde_json::Value;

/// Reversals, two full circles in both senses, a rapid, and two levels.
const PART: &str = "G21 G90 G17 G64 P0.01 F1500\nG0 X12 Y0\nG1 Z-1\nG3 I-12\nG2 I-12\nG1 X20 Y3\nX-4 Y9\nG1 Z-2\nG3 X12 Y0 R20\nG0 X0 Y0\nM2\n";

/// Keeps every tick beside what the page keeps.
pub(crate) struct All {
    pub(crate) page: PageRecorder,
    pub(crate) points: Vec<Vec<ContourPoint>>,
    pub(crate) motors: Vec<Vec<MotorPoint>>,
    /// Of the first drive.
    pub(crate) learning: Vec<Vec<(f64, Option<Learned>)>>,
}

impl All {
    pub(crate) fn new(methods: usize) -> All {
        All {
            page: PageRecorder::new(methods),
            points: vec![Vec::new(); methods],
            motors: vec![Vec::new(); methods],
            learning: vec![Vec::new(); methods],
        }
    }
}

impl Observer for All {
    fn wants_contour(&self) -> bool {
        true
    }

    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        self.page.contour(method, points);
        self.points[method].extend(points);
    }

    fn wants_limiters(&self) -> bool {
        self.page.wants_limiters()
    }

    fn wants_motors(&self) -> bool {
        true
    }

    fn motors(&mut self, method: usize, points: &[MotorPoint]) {
        self.page.motors(method, points);
        self.motors[method].extend(points);
    }

    fn wants_learning(&self) -> bool {
        true
    }

    fn learning(&mut self, method: usize, time_s: f64, drives: &[Option<Learning>]) {
        self.page.learning(method, time_s, drives);
        let known = drives.first().copied().flatten();
        self.learning[method].push((time_s, known.and_then(|known| known.learned)));
    }
}

fn machine() -> Machine {
    Machine::preset("vmc3-worn").unwrap()
}

fn run_with(text: &str, methods: &[&str], options: SimulateOptions) -> (Run, All, Program) {
    let program = Program::from_str("part <1>.ngc", text);
    let mut all = All::new(methods.len());
    let run = Simulation::new(&program, &machine())
        .methods(methods)
        .options(options)
        .observer(&mut all)
        .run()
        .unwrap();
    (run, all, program)
}

pub(crate) fn run(text: &str, methods: &[&str]) -> (Run, All, Program) {
    run_with(text, methods, SimulateOptions::default())
}

pub(crate) fn html(run: &Run, program: &Program, gathered: &Gathered) -> String {
    page(run, &machine(), program, gathered).unwrap()
}

/// The data of a page.
pub(crate) fn data(html: &str) -> Value {
    let (_, rest) = html.split_once("id=\"data\">").unwrap();
    let (json, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str(json).unwrap()
}

pub(crate) fn bytes(text: &str) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let mut out = Vec::new();
    for four in text.as_bytes().chunks(4) {
        let bits = four.iter().fold(0_u32, |bits, c| {
            bits << 6 | if *c == b'=' { 0 } else { u32::from(value(*c)) }
        });
        let padding = four.iter().filter(|c| **c == b'=').count();
        out.extend(&bits.to_be_bytes()[1..4 - padding]);
    }
    out
}

/// A packed signal and the value of half a step.
pub(crate) fn unpacked(packed: &Value) -> (Vec<f64>, f64) {
    let step = packed["step"].as_f64().unwrap();
    let all = bytes(packed["b"].as_str().unwrap());
    let value = |two: &[u8]| match i16::from_le_bytes([two[0], two[1]]) {
        i16::MIN => f64::NAN,
        steps => f64::from(steps) * step,
    };
    (all.chunks(2).map(value).collect(), 0.5 * step)
}

fn cuts(point: &ContourPoint) -> bool {
    point.moving && !point.rapid
}

/// The page without its scripts and data.
pub(crate) fn without_scripts(html: &str) -> String {
    html.split("<script").next().unwrap().to_owned()
}

#[test]
fn the_first_screen_needs_no_script() {
    let (one, all, program) = run(PART, &["none"]);
    let page = without_scripts(&html(&one, &program, &all.page.finish(&one)));
    let worst = &one.results[0].worst_blocks[0];
    for wanted in [
        "OUTSIDE tolerance".to_owned(),
        format!(">{}</a>", worst.block.span.line),
        worst.cause.to_string(),
        format!("tolerance {} \u{b5}m", one.tolerance_um),
        "cycle time".to_owned(),
        "Axes".to_owned(),
        "part &lt;1&gt;.ngc".to_owned(),
        // Two levels, and the three worst places.
        "Z -1 mm".to_owned(),
        "Z -2 mm".to_owned(),
        "errors 20\u{d7}".to_owned(),
        "circular deviation G".to_owned(),
    ] {
        assert!(page.contains(&wanted), "{wanted}\n{page}");
    }
    assert_eq!(page.matches("<figure class=\"place\">").count(), 3);

    let (several, all, program) = run(PART, &["none", "fixed"]);
    let page = without_scripts(&html(&several, &program, &all.page.finish(&several)));
    let name = several.recommended.as_deref().unwrap();
    assert!(page.contains(&format!("Recommended: {name}")), "{page}");
    assert!(page.contains("(no gap)"));
    assert!(page.contains("To set on the control") == (name == "fixed"));
}

#[test]
fn no_peak_is_lost() {
    let (run, all, program) = run(PART, &["none", "fixed"]);
    let (points, motors) = (all.points, all.motors);
    let data = data(&html(&run, &program, &all.page.finish(&run)));
    let starts: Vec<f64> = bytes(data["path"]["t"].as_str().unwrap())
        .chunks(4)
        .map(|four| f64::from(u32::from_le_bytes(four.try_into().unwrap())) * 1e-5)
        .collect();
    for (method, points) in points.iter().enumerate() {
        // The largest error of every stretch of the path is in it, and it is one that came there.
        let (path, half) = unpacked(&data["path"]["error"][method]);
        let mut worst = vec![0.0_f64; starts.len()];
        for point in points.iter().filter(|point| point.moving) {
            let time = point.time_s + 1e-5;
            let at = starts.partition_point(|start| *start <= time).max(1) - 1;
            if point.error_um.abs() > worst[at].abs() {
                worst[at] = point.error_um;
            }
        }
        for (at, worst) in worst.iter().enumerate().take(starts.len() - 1) {
            let seen = path[at];
            assert!(
                (seen.abs() - worst.abs()).abs() < 1.1 * half + 1e-4,
                "{at}: {seen} {worst}"
            );
        }
        // Every part of the time has the extremes of its ticks.
        let series = &data["methods"][method]["error"];
        let ticks = series["ticks"].as_u64().unwrap() as usize;
        let (low, half) = unpacked(&series["ends"]["low"]);
        let (high, _) = unpacked(&series["ends"]["high"]);
        for (part, ticks) in points.chunks(ticks).enumerate() {
            let errors = || {
                ticks
                    .iter()
                    .filter(|point| cuts(point))
                    .map(|point| point.error_um)
            };
            if errors().count() == 0 {
                assert!(low[part].is_nan() && high[part].is_nan());
                continue;
            }
            let largest = run.results[method].cutting.max * 1e-4;
            let near = |a: f64, b: f64| (a - b).abs() < 1.1 * half + largest;
            assert!(
                near(low[part], errors().fold(f64::INFINITY, f64::min)),
                "{part}"
            );
            assert!(
                near(high[part], errors().fold(f64::NEG_INFINITY, f64::max)),
                "{part}"
            );
        }
        // All cutting ticks are counted, and the largest error is the run's own.
        let counts = data["methods"][method]["histogram"]["counts"]
            .as_array()
            .unwrap();
        let counted: u64 = counts.iter().map(|count| count.as_u64().unwrap()).sum();
        assert_eq!(
            counted,
            points.iter().filter(|point| cuts(point)).count() as u64
        );
    }
    // The same of a motor's following error.
    let motor = &data["methods"][0]["motors"][1];
    let (high, half) = unpacked(&motor["signals"][0]["high"]);
    let ticks = motor["ticks"].as_u64().unwrap() as usize;
    let axes = motors[0]
        .iter()
        .take_while(|m| m.time_s.to_bits() == motors[0][0].time_s.to_bits());
    let y: Vec<&MotorPoint> = motors[0].iter().skip(1).step_by(axes.count()).collect();
    for (part, ticks) in y.chunks(ticks).enumerate() {
        let most = ticks
            .iter()
            .map(|m| m.reference - m.load)
            .fold(f64::NEG_INFINITY, f64::max);
        assert!((high[part] - most).abs() < 1.1 * half + 1e-9, "{part}");
    }
}

/// Radial deviations by hand, from every tick's actual place.
#[test]
fn circles_are_those_of_every_tick() {
    let (run, all, program) = run(PART, &["none"]);
    let points = all.points[0].clone();
    let data = data(&html(&run, &program, &all.page.finish(&run)));
    let circles = data["methods"][0]["circles"].as_array().unwrap();
    assert_eq!(circles.len(), 2, "{circles:?}");
    for circle in circles {
        let line = circle["line"].as_u64().unwrap();
        assert_eq!(circle["ccw"].as_bool().unwrap(), line == 4);
        assert_eq!((circle["r"].as_f64().unwrap() * 1e3).round(), 12_000.0);
        let radial: Vec<f64> = points
            .iter()
            .filter(|p| cuts(p) && u64::from(p.block.span.line) == line)
            .map(|p| ((p.actual_mm[0].powi(2) + p.actual_mm[1].powi(2)).sqrt() - 12.0) * 1e3)
            .collect();
        let low = radial.iter().copied().fold(f64::INFINITY, f64::min);
        let high = radial.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let f = |end: usize| circle["f"][end].as_f64().unwrap();
        assert!(
            (f(0) - low).abs() < 0.2 && (f(1) - high).abs() < 0.2,
            "{circle} {low} {high}"
        );
        // The ring about the least-squares centre of all ticks.
        let tips: Vec<[f64; 3]> = points
            .iter()
            .filter(|p| cuts(p) && u64::from(p.block.span.line) == line)
            .map(|p| p.actual_mm)
            .collect();
        let nominal = Circle {
            plane: Plane::Xy,
            center_mm: [0.0; 2],
            radius_mm: 12.0,
        };
        let g = 1e3 * nominal.deviation(&tips).unwrap().circular_mm;
        assert!(
            (circle["g"].as_f64().unwrap() - g).abs() < 0.5,
            "{circle} {g}"
        );
        // Both senses: the difference at one angle is at most that of the extremes of both.
        let h = circle["h"].as_f64().unwrap();
        assert!(h > 0.5 && h < 2.0 * (high - low), "{circle}");
    }
}

#[test]
fn programs_cannot_break_out() {
    let hostile = format!(
        "(</script><script>alert`1`</script>)\n(<!--<img src=x onerror=alert`1`>\u{1}\u{1b}[31m \u{202e})\nG21 G90 F900 ({})\nG1 X9 (\"'&)\nX0\nM2\n",
        "long ".repeat(12_000)
    );
    let (run, all, program) = run(&hostile, &["none"]);
    let page = html(&run, &program, &all.page.finish(&run));
    assert_eq!(page.matches("</script").count(), 2);
    assert_eq!(page.matches("<script").count(), 2);
    assert!(!page.contains("<img") && !page.contains("<!--"));
    let allowed = |c: char| c == '\n' || !c.is_control() && c != '\u{202e}';
    assert!(page.chars().all(allowed));
    let data = data(&page);
    let lines: Vec<&str> = data["source"][0][1].as_str().unwrap().split('\n').collect();
    assert_eq!(lines[0], "(</script><script>alert`1`</script>)");
    assert!(lines[2].chars().count() < 200 && lines[3].starts_with("G1 X9"));
    assert!(page.len() < 400_000, "{}", page.len());
}

/// Whatever the threads and chunks; what a method knows at the ends of chunks is told at those.
#[test]
fn the_same_run_gives_the_same_bytes() {
    let pages = [(1000, 1), (77, 2), (1000, 2)].map(|(chunk_samples, threads)| {
        let options = SimulateOptions {
            chunk_samples,
            threads,
            ..SimulateOptions::default()
        };
        let (run, all, program) = run_with(PART, &["none", "adaptive"], options);
        html(&run, &program, &all.page.finish(&run))
    });
    assert!(pages[0] == pages[2]);
    let without_estimates = |page: &str| {
        let mut data = data(page);
        let at = data["signals"].as_array().unwrap().len() - 1;
        for method in data["methods"].as_array_mut().unwrap() {
            for motor in method["motors"].as_array_mut().unwrap() {
                motor["signals"].as_array_mut().unwrap().truncate(at);
            }
        }
        let (before, rest) = page.split_once("id=\"data\">").unwrap();
        let (_, after) = rest.split_once("</script>").unwrap();
        (before.to_owned(), data, after.to_owned())
    };
    assert!(without_estimates(&pages[0]) == without_estimates(&pages[1]));
}

/// An hour of a program is its ticks again and again, elsewhere and later.
#[test]
fn a_page_has_at_most_5_mb() {
    let methods = [
        "none",
        "fixed",
        "adaptive",
        "reversal-pulse",
        "kalman",
        "fixed-fanuc",
    ];
    let (run, all, program) = run(PART, &methods);
    let mut recorder = PageRecorder::new(methods.len());
    let last = all.points[0].last().unwrap().time_s;
    for turn in 0..60_u32 {
        for method in 0..methods.len() {
            let mut points = all.points[method].clone();
            for (index, point) in points.iter_mut().enumerate() {
                point.time_s += f64::from(turn) * last;
                point.commanded_mm[2] += f64::from(turn) * 0.01;
                point.block.span.line = turn * 4000 + (index / 16) as u32;
                // Rough, so that nothing can be left out.
                point.error_um += f64::from((index as u32 * 7919 + turn) % 100);
            }
            recorder.contour(method, &points);
            recorder.motors(method, &all.motors[method]);
        }
    }
    let page = html(&run, &program, &recorder.finish(&run));
    assert!(
        (1_000_000..=5_000_000).contains(&page.len()),
        "{}",
        page.len()
    );
    let data = data(&page);
    assert!(data["path"]["n"].as_u64().unwrap() > 30_000);
}
