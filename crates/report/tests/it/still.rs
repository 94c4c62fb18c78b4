//! The picture of a run: what it says, that its colours are those of the errors, and its size.

use crate::page::{All, html, run};
use lostmotion_report::page::still;
use lostmotion_sim::{ContourPoint, Run};

/// An outline, and a raster on a level below it.
fn part(step_mm: f64) -> String {
    let mut text = "G21 G90 G17 G64 P0.01 F1500\nG0 X0 Y0\nG1 Z-1\nG1 X30\nG3 X30 Y20 J10\nG1 X0\nG3 X0 Y0 J-10\nG0 Z5\nX30 Y20\nX0 Y0\nG1 Z-2\n".to_owned();
    let rows = (20.0 / step_mm) as u32;
    for row in 0..=rows {
        let x = if row % 2 == 0 { 30 } else { 0 };
        text.push_str(&format!("Y{}\nX{x}\n", f64::from(row) * step_mm));
    }
    text + "G0 Z5\nM2\n"
}

fn drawn(text: &str, methods: &[&str]) -> (Run, Vec<Vec<ContourPoint>>, String) {
    let (run, All { page, points, .. }, program) = run(text, methods);
    let gathered = page.finish(&run);
    // The page has the same drawings.
    assert!(html(&run, &program, &gathered).contains("<figure class=\"panel\">"));
    let svg = still(&run, &gathered);
    if let Some(folder) = std::env::var_os("LOSTMOTION_PICTURES") {
        let name = format!("still{}.svg", methods.len());
        std::fs::write(std::path::Path::new(&folder).join(name), &svg).unwrap();
    }
    (run, points, svg)
}

/// Tags are balanced and no number is NaN.
fn well_formed(svg: &str) {
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    assert!(!svg.contains("NaN") && !svg.contains("inf") && !svg.contains("<script"));
    for tag in ["svg", "text", "g", "style", "title"] {
        let opened =
            svg.matches(&format!("<{tag} ")).count() + svg.matches(&format!("<{tag}>")).count();
        assert_eq!(opened, svg.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

/// The frames of nested drawings: place, size, and what is in them.
fn frames(svg: &str) -> Vec<(f64, f64, &str)> {
    svg.split("<svg x=")
        .skip(1)
        .map(|rest| {
            let of = |name: &str| {
                let (_, rest) = rest.split_once(&format!("{name}=\"")).unwrap();
                rest.split('"').next().unwrap().parse().unwrap()
            };
            (
                of("width"),
                of("height"),
                rest.split("</svg>").next().unwrap(),
            )
        })
        .collect()
}

/// Stretches of each colour in a drawing: hue and ends, px.
fn stretches(drawing: &str, class: &str) -> Vec<(usize, [f64; 2], [f64; 2])> {
    let Some((_, rest)) = drawing.split_once(&format!("<g class=\"{class}\"")) else {
        return Vec::new();
    };
    let group = rest.split("</g>").next().unwrap();
    let mut all = Vec::new();
    for path in group.split("<path class=\"e").skip(1) {
        let hue: usize = path[..1].parse().unwrap();
        let data = path
            .split("d=\"")
            .nth(1)
            .unwrap()
            .split('"')
            .next()
            .unwrap();
        for chain in data.split('M').skip(1) {
            let points: Vec<[f64; 2]> = chain
                .split('L')
                .map(|p| {
                    let (x, y) = p.split_once(' ').unwrap();
                    [x.parse().unwrap(), y.parse().unwrap()]
                })
                .collect();
            all.extend(points.windows(2).map(|pair| (hue, pair[0], pair[1])));
        }
    }
    all
}

fn off(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let square = d[0] * d[0] + d[1] * d[1];
    let t = if square > 0.0 {
        (((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    ((p[0] - a[0] - t * d[0]).powi(2) + (p[1] - a[1] - t * d[1]).powi(2)).sqrt()
}

/// The colour of an error by the bounds that the documents name.
fn hue(error_um: f64, tolerance_um: f64) -> usize {
    let steps = [0.1, 0.3, 0.6, 1.0];
    let part = error_um / tolerance_um;
    let above = steps.iter().filter(|step| part.abs() >= **step).count();
    if part > 0.0 { 4 + above } else { 4 - above }
}

#[test]
fn it_says_what_a_reader_asks_first() {
    let (run, _, svg) = drawn(&part(4.0), &["none", "fixed"]);
    well_formed(&svg);
    let main = run.deciding().unwrap_or(&run.results[0]);
    let worst = main.worst_blocks.iter().find(|block| !block.rapid).unwrap();
    for wanted in [
        "part &lt;1&gt;.ngc on vmc3-worn".to_owned(),
        format!("the tolerance of {} \u{b5}m", run.tolerance_um),
        format!("in line {}: {}", worst.block.span.line, worst.cause),
        ">none: max ".to_owned(),
        "Z -1 mm: worst".to_owned(),
        "Z -2 mm: worst".to_owned(),
        "Worst places, enlarged".to_owned(),
        "class=\"rapid\"".to_owned(),
    ] {
        assert!(svg.contains(&wanted), "{wanted}\n{svg}");
    }
    // Two methods, two levels, three places.
    assert_eq!(frames(&svg).len(), 2 * 2 + 3);
    assert_eq!(svg, drawn(&part(4.0), &["none", "fixed"]).2);
}

/// Every cutting tick lies on a line that has its colour or one for a larger error, and every line
/// has the colour of a tick on it.
#[test]
fn colours_are_those_of_the_errors() {
    let (run, points, svg) = drawn(&part(4.0), &["none"]);
    let drawings = frames(&svg);
    let tolerance = run.tolerance_um;
    for (number, z) in [(0, -1.0), (1, -2.0)] {
        let (width, height, drawing) = drawings[number];
        let lines = stretches(drawing, "path");
        let cuts: Vec<&ContourPoint> = points[0]
            .iter()
            .filter(|p| p.moving && !p.rapid && (p.commanded_mm[2] - z).abs() < 1e-4)
            .collect();
        let range = |axis: usize| {
            let along = || cuts.iter().map(|p| p.commanded_mm[axis]);
            [
                along().fold(f64::INFINITY, f64::min),
                along().fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        let (x, y) = (range(0), range(1));
        // Both fill the width, within its margin of 22 px.
        let scale = (width - 44.0) / (x[1] - x[0]);
        assert!(height > scale * (y[1] - y[0]));
        let mut used = vec![false; lines.len()];
        for point in cuts {
            let at = [
                22.0 + (point.commanded_mm[0] - x[0]) * scale,
                22.0 + (y[1] - point.commanded_mm[1]) * scale,
            ];
            let own = hue(point.error_um, tolerance);
            let near: Vec<usize> = (0..lines.len())
                .filter(|line| off(at, lines[*line].1, lines[*line].2) < 0.5)
                .collect();
            let covers = |line: &usize| lines[*line].0.abs_diff(4) >= own.abs_diff(4);
            assert!(near.iter().any(covers), "{at:?} {own} {near:?}");
            for line in near {
                used[line] |= lines[line].0 == own;
            }
        }
        for (line, used) in lines.iter().zip(used) {
            // Detail below half a pixel may be joined into its neighbour.
            let length = (line.1[0] - line.2[0]).abs() + (line.1[1] - line.2[1]).abs();
            assert!(used || length < 1.0, "{line:?}");
        }
    }
}

/// A raster that would be a blob becomes squares; each has the colour of its largest error.
#[test]
fn a_surface_is_no_blob() {
    let (run, points, svg) = drawn(&part(0.25), &["none"]);
    well_formed(&svg);
    let drawings = frames(&svg);
    // The outline on its level stays lines.
    assert!(stretches(drawings[0].2, "squares").is_empty());
    let squares = stretches(drawings[1].2, "squares");
    assert!(stretches(drawings[1].2, "path").is_empty() && !squares.is_empty());
    let cuts: Vec<&ContourPoint> = points[0]
        .iter()
        .filter(|p| p.moving && !p.rapid && (p.commanded_mm[2] + 2.0).abs() < 1e-4)
        .collect();
    let range = |axis: usize| {
        let along = || cuts.iter().map(|p| p.commanded_mm[axis]);
        [
            along().fold(f64::INFINITY, f64::min),
            along().fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    let (x, y) = (range(0), range(1));
    let (width, _, drawing) = drawings[1];
    let scale = (width - 44.0) / (x[1] - x[0]);
    let side: f64 = drawing
        .split("stroke-width=\"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    // Each tick is in a square whose colour is for an error at least as large.
    for point in &cuts {
        let at = [
            22.0 + (point.commanded_mm[0] - x[0]) * scale,
            22.0 + (y[1] - point.commanded_mm[1]) * scale,
        ];
        let own = hue(point.error_um, run.tolerance_um);
        let covers = |(hue, from, to): &(usize, [f64; 2], [f64; 2])| {
            (at[1] - from[1]).abs() <= 0.5 * side + 0.2
                && (from[0] - 0.3..=to[0] + 0.3).contains(&at[0])
                && hue.abs_diff(4) >= own.abs_diff(4)
        };
        assert!(squares.iter().any(covers), "{at:?} {own}");
    }
    // All squares together are the raster's area, but for its edge.
    let area: f64 = squares
        .iter()
        .map(|(_, from, to)| (to[0] - from[0]) * (side - 0.3))
        .sum();
    let true_area = (x[1] - x[0]) * (y[1] - y[0]) * scale * scale;
    assert!((area / true_area - 1.0).abs() < 0.1, "{area} {true_area}");
    assert!(svg.len() < 400_000, "{}", svg.len());
}

#[test]
fn holes_are_dots_and_nothing_is_said() {
    let (_, _, svg) = drawn(
        "G21 G90 G17 F300\nG0 X0 Y0 Z2\nG1 Z-5\nG0 Z2\nX20 Y5\nG1 Z-5\nG0 Z2\nX5 Y20\nG1 Z-5\nG0 Z2\nM2\n",
        &["none"],
    );
    let dots: usize = frames(&svg)
        .iter()
        .map(|(_, _, drawing)| stretches(drawing, "dots").len())
        .sum();
    assert_eq!(dots, 3, "{svg}");
    let (run, all, _) = run("G21 G90\nG0 X5\nM2\n", &["none"]);
    let svg = still(&run, &all.page.finish(&run));
    well_formed(&svg);
    assert!(svg.contains("no cutting move"));
}
