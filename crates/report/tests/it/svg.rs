//! Pictures hold what they are given, bounded in size, and are well formed.

use lostmotion_base::math;
use lostmotion_report::svg::{Series, SeriesPicture, series};
use std::f64::consts::TAU;

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
fn nothing_to_draw_is_said() {
    assert!(series(&SeriesPicture::default(), &[]).contains("no data"));
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
