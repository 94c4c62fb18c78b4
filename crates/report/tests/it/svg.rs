//! Pictures hold what they are given, bounded in size, and are well formed.

use lostmotion_base::math;
use lostmotion_report::svg::{
    ContourPicture, ContourTrace, Plane, Series, SeriesPicture, TracePoint, TraceRecorder, contour,
    series,
};
use std::f64::consts::TAU;

/// A circle whose error has a spike behind each quadrant.
fn circle(name: &str, spike_um: f64, samples: u32) -> ContourTrace {
    let mut recorder = TraceRecorder::new(1500);
    for i in 0..=samples {
        let angle = TAU * f64::from(i) / f64::from(samples);
        let (s, c) = math::sin_cos(angle);
        let since = (angle / (TAU / 4.0)).fract();
        let error_um =
            0.6 + spike_um * math::exp(-since * 12.0) * math::sin((since * 20.0).min(3.0));
        recorder.push(TracePoint {
            foot_mm: [25.0 * c, 25.0 * s, -1.0],
            normal: [-c, -s, 0.0],
            error_um,
        });
    }
    recorder.finish(
        name,
        &format!(
            "max {spike_um:.1} \u{b5}m, RMS {:.1} \u{b5}m",
            spike_um * 0.3
        ),
    )
}

fn picture() -> ContourPicture {
    ContourPicture {
        title: "Contour error of circle-r25.ngc".to_owned(),
        subtitle: "mill with a 10 \u{b5}m gap, F3000 <R25 & once>".to_owned(),
        tolerance_um: Some(5.0),
        plane: None,
    }
}

/// Where a picture is written if somebody wants to look at it.
fn show(name: &str, svg: &str) {
    if let Some(folder) = std::env::var_os("LOSTMOTION_PICTURES") {
        std::fs::write(std::path::Path::new(&folder).join(name), svg).unwrap();
    }
}

/// Tags are balanced and no number is NaN.
fn well_formed(svg: &str) {
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
    let stray = svg
        .replace("&amp;", "")
        .replace("&lt;", "")
        .replace("&gt;", "")
        .replace("&quot;", "");
    assert!(!stray.contains('&'));
}

#[test]
fn each_method_has_a_panel_and_the_error_a_scale() {
    let traces: Vec<ContourTrace> = [
        ("none", 9.5),
        ("fixed", 3.0),
        ("published", 19.0),
        ("load-feedback", 1.2),
    ]
    .map(|(n, s)| circle(n, s, 200_000))
    .to_vec();
    let svg = contour(&picture(), &traces);
    show("contour.svg", &svg);
    well_formed(&svg);
    for text in [
        ">none<",
        ">published<",
        "X, mm",
        "Y, mm",
        "magnified",
        "&lt;R25 &amp; once&gt;",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.len() < 200_000, "{}", svg.len());
}

#[test]
fn a_method_gone_wild_is_cut_off_and_said_to_be() {
    let svg = contour(
        &picture(),
        &[
            circle("none", 9.0, 2000),
            circle("fixed", 3.0, 2000),
            circle("wild", 4.0e7, 2000),
        ],
    );
    show("wild.svg", &svg);
    well_formed(&svg);
    assert_eq!(svg.matches("off the scale").count(), 1);
    assert!(svg.contains("magnified 1000 times"));
}

#[test]
fn any_number_of_panels_and_any_shape_fits() {
    let wide = |name: &str| {
        let mut recorder = TraceRecorder::new(100);
        for pass in 0..4 {
            for i in 0..100 {
                let foot_mm = [f64::from(i), f64::from(pass) * 2.0, 0.0];
                recorder.push(TracePoint {
                    foot_mm,
                    normal: [0.0, 1.0, 0.0],
                    error_um: f64::from(i % 10) - 5.0,
                });
            }
            recorder.lift();
        }
        recorder.finish(name, "max 5.0 \u{b5}m")
    };
    for count in 1..=7 {
        let traces: Vec<ContourTrace> = (0..count).map(|i| wide(&format!("method-{i}"))).collect();
        let svg = contour(
            &ContourPicture {
                title: "Raster".to_owned(),
                ..ContourPicture::default()
            },
            &traces,
        );
        show(&format!("raster{count}.svg"), &svg);
        well_formed(&svg);
    }
    let tall = ContourTrace {
        name: "none".to_owned(),
        caption: String::new(),
        runs: vec![
            (0..50)
                .map(|i| TracePoint {
                    foot_mm: [0.0, 0.0, f64::from(i)],
                    normal: [1.0, 0.0, 0.0],
                    error_um: 1.0,
                })
                .collect(),
        ],
    };
    let svg = contour(&picture(), &[tall]);
    show("tall.svg", &svg);
    well_formed(&svg);
}

#[test]
fn nothing_to_draw_is_said() {
    for traces in [vec![], vec![ContourTrace::default()]] {
        let svg = contour(&picture(), &traces);
        well_formed(&svg);
        assert!(svg.contains("no cutting move"));
    }
    assert!(series(&SeriesPicture::default(), &[]).contains("no data"));
}

#[test]
fn the_plane_is_the_one_that_shows_most() {
    let line = |to: [f64; 3]| ContourTrace {
        runs: vec![
            [[0.0; 3], to]
                .map(|foot_mm| TracePoint {
                    foot_mm,
                    ..TracePoint::default()
                })
                .to_vec(),
        ],
        ..ContourTrace::default()
    };
    assert_eq!(Plane::of(&[line([10.0, 10.0, 5.0])]), Plane::Xy);
    assert_eq!(Plane::of(&[line([10.0, 0.0, 5.0])]), Plane::Xz);
    assert_eq!(Plane::of(&[line([0.0, 10.0, 5.0])]), Plane::Yz);
    assert_eq!(Plane::of(&[line([10.0, 0.0, 0.0])]), Plane::Xy);
}

#[test]
fn curves_over_time() {
    let curve = |name: &str, phase: f64| Series {
        name: name.to_owned(),
        points: (0..4000)
            .map(|i| f64::from(i) * 250e-6)
            .map(|t| [t, 20.0 * math::sin(TAU * 2.0 * t + phase)])
            .collect(),
    };
    let mut interrupted = curve("estimate", 1.0);
    interrupted.points[1000][1] = f64::NAN;
    let labels = SeriesPicture {
        title: "Load position".to_owned(),
        x_label: "time, s".to_owned(),
        y_label: "position, rad".to_owned(),
    };
    let svg = series(
        &labels,
        &[curve("reference", 0.0), curve("load", 0.3), interrupted],
    );
    show("series.svg", &svg);
    well_formed(&svg);
    assert_eq!(svg.matches("<path").count(), 4);
    well_formed(&series(
        &labels,
        &[Series {
            name: "one".to_owned(),
            points: vec![[1.0, 1.0]],
        }],
    ));
}
