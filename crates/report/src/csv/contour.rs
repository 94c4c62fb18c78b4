//! Contour error: a row a servo tick while the tool moves.

use super::rows::{ERROR_DECIMALS, Rows};
use lostmotion_sim::ContourPoint;
use std::io::{self, Write};

const COLUMNS: [&str; 13] = [
    "method",
    "t_s",
    "foot_x_mm",
    "foot_y_mm",
    "foot_z_mm",
    "normal_x",
    "normal_y",
    "normal_z",
    "error_um",
    "backlash_um",
    "rapid",
    "file",
    "line",
];

/// Writes the fields of [`ContourPoint`] with the method's name before them.
#[derive(Debug)]
pub struct ContourWriter<W> {
    rows: Rows<W>,
}

impl<W: Write> ContourWriter<W> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<ContourWriter<W>> {
        Ok(ContourWriter {
            rows: Rows::new(out, COLUMNS)?,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, method: &str, points: &[ContourPoint]) -> io::Result<()> {
        for point in points {
            let rows = &mut self.rows;
            rows.text(method);
            rows.number(point.time_s, 6);
            for coordinate in point.foot_mm {
                rows.number(coordinate, 6);
            }
            for component in point.normal {
                rows.number(component, 6);
            }
            rows.number(point.error_um, ERROR_DECIMALS);
            rows.number(point.backlash_um, ERROR_DECIMALS);
            rows.integer(u64::from(point.rapid));
            rows.integer(u64::from(point.block.span.file));
            rows.integer(u64::from(point.block.span.line));
            rows.end()?;
        }
        Ok(())
    }

    /// Writes what is left and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<W> {
        self.rows.finish()
    }
}
