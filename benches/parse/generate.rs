//! Programs of any size.

use lostmotion::base::math;
use std::fmt::Write;

/// A three-axis finishing raster over a wavy surface as CAM systems post it: `G1 X Y Z`, no line
/// numbers.
pub(crate) fn surfacing(bytes: usize) -> String {
    let mut text = String::from(
        "(three-axis finishing raster)\nG21 G17 G90 G94 G40 G49 G80 G54\nG64 P0.02 Q0.005\nM3 S12000\nG0 Z10\nF3000\n",
    );
    let (mut row, mut forward) = (0u32, true);
    while text.len() < bytes {
        let y = -75.0 + 0.4 * f64::from(row % 375);
        for point in 0..=300 {
            let along = -75.0 + 0.5 * f64::from(point);
            let x = if forward { along } else { -along };
            let z = 2.0 * math::sin(x / 9.0) * math::cos(y / 13.0) - 5.0;
            let _ = writeln!(text, "G1 X{x:.3} Y{y:.3} Z{z:.4}");
        }
        (row, forward) = (row + 1, !forward);
    }
    text + "G0 Z10\nM5\nM2\n"
}

/// What real programs have beside long runs of lines: line numbers, arcs, cycles, comments,
/// parameters, several styles of spacing.
pub(crate) fn mixed(bytes: usize) -> String {
    let mut part = Mixed {
        text: String::from("%\n(T1 D10 end mill)\nG21 G17 G90 G94 G54\nT1 M6\nS9000 M3\nG0 Z10\n"),
        number: 0,
    };
    let mut feature = 0u32;
    while part.text.len() < bytes {
        part.feature(feature);
        feature += 1;
    }
    part.text + "M9\nM5\nM2\n%\n"
}

struct Mixed {
    text: String,
    number: u32,
}

impl Mixed {
    /// Starts a numbered line.
    fn numbered(&mut self) {
        self.number = self.number % 99_990 + 10;
        let _ = write!(self.text, "N{} ", self.number);
    }

    fn feature(&mut self, index: u32) {
        let (x, y) = (f64::from(index * 7 % 90), -f64::from(index * 11 % 70));
        let round = |i: u32| (0.3 * f64::from(i), 0.3 * f64::from(i));
        let _ = writeln!(self.text, "(contour {index} at X{x} Y{y})");
        self.numbered();
        let _ = writeln!(self.text, "G0 X{x:.3} Y{y:.3} M8");
        self.numbered();
        self.text.push_str("G1 Z-1.5 F300.\n");
        for i in 0..20 {
            let (a, b) = round(i);
            self.numbered();
            let _ = writeln!(
                self.text,
                "G1 X{:.4} Y{:.4} F1200.",
                x + 10.0 * math::cos(a),
                y + 10.0 * math::sin(b)
            );
        }
        self.numbered();
        let _ = writeln!(self.text, "X{x:.3} Y{y:.3}");
        for i in 1..=10 {
            self.numbered();
            let _ = writeln!(
                self.text,
                "G{} X{:.3} Y{y:.3} I5. J0.",
                2 + i % 2,
                x + 10.0 * f64::from(i)
            );
        }
        self.text.push_str("G1\n");
        for i in 0..20 {
            let (a, b) = round(i);
            let _ = writeln!(
                self.text,
                "X{:.4}Y{:.4}Z{:.4}",
                x + 10.0 * math::cos(a),
                y + 10.0 * math::sin(b),
                -1.5 - 0.01 * f64::from(i)
            );
        }
        let _ = writeln!(
            self.text,
            "g0 z10. ; clear\n#1 = {index}\n#<step> = 0.001\nG1 X[#1 * #<step> + 2] Y[-#1 * 0.002] F800\nG0 Z5."
        );
        let _ = writeln!(self.text, "G98 G81 X{x:.2} Y0. Z-8. R2. F200");
        for i in 1..6 {
            let _ = writeln!(self.text, "X{:.2}", x + 5.0 * f64::from(i));
        }
        self.text.push_str("G80\nM9\n\n");
    }
}
