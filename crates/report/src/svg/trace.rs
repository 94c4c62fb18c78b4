//! What a picture of a contour is made of, in bounded memory for programs of any length.

use super::scale::Range;

/// A point of the programmed contour and how far the tool was from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TracePoint {
    /// Foot point on the programmed contour, mm.
    pub foot_mm: [f64; 3],
    /// Unit normal along which the error counts positive.
    pub normal: [f64; 3],
    /// Signed error along the normal, um.
    pub error_um: f64,
}

/// Contour errors of one method along a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContourTrace {
    /// Name of the method.
    pub name: String,
    /// Line below the name: its figures.
    pub caption: String,
    /// Stretches without a rapid between their points.
    pub runs: Vec<Vec<TracePoint>>,
}

impl ContourTrace {
    /// All points.
    pub fn points(&self) -> impl Iterator<Item = &TracePoint> {
        self.runs.iter().flatten()
    }
}

/// Collects a trace while a run is going on and never holds more than twice its capacity.
///
/// Of each group of neighbouring points only the one with the largest error is kept, so that no
/// peak is lost. The groups begin with one point and double whenever the memory is full.
#[derive(Clone, Debug)]
pub struct TraceRecorder {
    capacity: usize,
    group: u64,
    seen: u64,
    entries: Vec<Entry>,
    broken: bool,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    point: TracePoint,
    /// Whether a rapid lies between the entry before and this one.
    starts_run: bool,
}

impl TraceRecorder {
    /// A recorder that gives at most `2 * capacity` points.
    pub fn new(capacity: usize) -> TraceRecorder {
        TraceRecorder {
            capacity: capacity.max(2),
            group: 1,
            seen: 0,
            entries: Vec::new(),
            broken: true,
        }
    }

    /// Appends a point of a cutting move. Points with a number that is not finite are left out.
    pub fn push(&mut self, point: TracePoint) {
        let finite = point.error_um.is_finite()
            && point
                .foot_mm
                .iter()
                .chain(&point.normal)
                .all(|c| c.is_finite());
        if !finite {
            return;
        }
        let starts_run = std::mem::take(&mut self.broken);
        // A group ends where the next run begins: no line may be drawn across a rapid.
        let fresh = self.seen.is_multiple_of(self.group) || starts_run;
        match self.entries.last_mut() {
            Some(last) if !fresh => {
                if point.error_um.abs() > last.point.error_um.abs() {
                    last.point = point;
                }
            }
            _ => self.entries.push(Entry { point, starts_run }),
        }
        self.seen += 1;
        // Full: from here on groups are twice as large, those kept already included.
        if self.entries.len() >= 2 * self.capacity {
            self.merge();
        }
    }

    /// Ends a stretch: a rapid follows.
    pub fn lift(&mut self) {
        self.broken = true;
    }

    /// Halves the entries: of two neighbours the one with the larger error stays.
    fn merge(&mut self) {
        self.group *= 2;
        // Whether a rapid lies before the next entry that stays: the one behind it has gone.
        let mut lifted = false;
        let mut kept = Vec::with_capacity(self.entries.len().div_ceil(2));
        for pair in self.entries.chunks(2) {
            let (mut entry, before) = match *pair {
                [first, second] if second.point.error_um.abs() > first.point.error_um.abs() => {
                    let starts_run = first.starts_run || second.starts_run;
                    (
                        Entry {
                            starts_run,
                            ..second
                        },
                        false,
                    )
                }
                // The first stays in its own run: a break before the second is one before the next.
                [first, second] => (first, second.starts_run),
                [only] => (only, false),
                _ => continue,
            };
            entry.starts_run |= lifted;
            lifted = before;
            kept.push(entry);
        }
        self.broken |= lifted;
        self.entries = kept;
    }

    /// The trace.
    pub fn finish(self, name: &str, caption: &str) -> ContourTrace {
        let mut runs: Vec<Vec<TracePoint>> = Vec::new();
        for entry in self.entries {
            // A run ends where a rapid lay: no line may be drawn across it.
            match runs.last_mut() {
                Some(run) if !entry.starts_run => run.push(entry.point),
                _ => runs.push(vec![entry.point]),
            }
        }
        ContourTrace {
            name: name.to_owned(),
            caption: caption.to_owned(),
            runs,
        }
    }
}

/// A coordinate plane to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// X to the right, Y up.
    Xy,
    /// X to the right, Z up.
    Xz,
    /// Y to the right, Z up.
    Yz,
}

impl Plane {
    /// The plane that shows most of the traces: without the direction of smallest extent, XY when
    /// in doubt.
    pub fn of(traces: &[ContourTrace]) -> Plane {
        let extent = |axis: usize| {
            Range::of(
                traces
                    .iter()
                    .flat_map(ContourTrace::points)
                    .map(|p| p.foot_mm[axis]),
            )
            .map_or(0.0, |range| range.span())
        };
        // Without any point all extents are 0, and the plane is XY.
        Plane::of_extents([extent(0), extent(1), extent(2)])
    }

    /// The same by the extents along X, Y and Z.
    pub(crate) fn of_extents([x, y, z]: [f64; 3]) -> Plane {
        // XY unless Z clearly is larger than one of them: milled parts are looked at from above.
        if z <= x.min(y) * 1.5 || (z <= x && z <= y) {
            Plane::Xy
        } else if y <= x {
            Plane::Xz
        } else {
            Plane::Yz
        }
    }

    const fn indices(self) -> [usize; 2] {
        match self {
            Plane::Xy => [0, 1],
            Plane::Xz => [0, 2],
            Plane::Yz => [1, 2],
        }
    }

    /// The two coordinates seen.
    pub fn project(self, point: [f64; 3]) -> [f64; 2] {
        self.indices().map(|axis| point[axis])
    }

    /// Labels of the horizontal and the vertical direction.
    pub fn labels(self) -> [&'static str; 2] {
        self.indices().map(|axis| ["X, mm", "Y, mm", "Z, mm"][axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_bounded_and_peaks_stay() {
        let mut recorder = TraceRecorder::new(50);
        for i in 0..100_000 {
            let error_um = if i == 54_321 { -99.0 } else { f64::from(i % 7) };
            recorder.push(TracePoint {
                foot_mm: [f64::from(i), 0.0, 0.0],
                normal: [0.0, 1.0, 0.0],
                error_um,
            });
            assert!(recorder.entries.len() <= 100);
        }
        let trace = recorder.finish("none", "");
        assert_eq!(trace.runs.len(), 1);
        assert!(trace.points().any(|p| p.error_um < -98.0));
        assert!(
            trace.runs[0]
                .windows(2)
                .all(|pair| pair[0].foot_mm[0] < pair[1].foot_mm[0])
        );
    }

    #[test]
    fn rapids_end_runs_and_nonsense_is_left_out() {
        let mut recorder = TraceRecorder::new(50);
        let point = TracePoint {
            normal: [0.0, 1.0, 0.0],
            ..TracePoint::default()
        };
        recorder.lift();
        recorder.push(point);
        recorder.push(TracePoint {
            error_um: f64::NAN,
            ..point
        });
        recorder.lift();
        recorder.lift();
        recorder.push(point);
        recorder.push(point);
        let lengths: Vec<usize> = recorder
            .finish("none", "")
            .runs
            .iter()
            .map(Vec::len)
            .collect();
        assert_eq!(lengths, [1, 2]);
    }

    #[test]
    fn merging_draws_no_line_across_a_rapid() {
        // Runs of three points, each at its own height; the last of a run has the largest error.
        let mut recorder = TraceRecorder::new(8);
        for run in 0..40 {
            for point in 0..3 {
                recorder.push(TracePoint {
                    foot_mm: [f64::from(point), f64::from(run), 0.0],
                    normal: [0.0, 0.0, 1.0],
                    error_um: f64::from(point),
                });
            }
            recorder.lift();
            assert!(recorder.entries.len() <= 16);
        }
        let trace = recorder.finish("none", "");
        for run in &trace.runs {
            assert!(
                run.iter()
                    .all(|point| point.foot_mm[1] == run[0].foot_mm[1]),
                "{run:?}"
            );
        }
        assert!(trace.runs.len() > 2);
    }
}
