//! A plan: a row a tick.

use super::rows::{POSITION_DECIMALS, Rows};
use lostmotion_base::{AxisId, AxisSet, Clock, units};
use lostmotion_plan::Sample;
use std::io::{self, Write};

/// Writes the columns `t_s`, a position for each axis of the machine (`x_mm` ... `c_deg`), and
/// `line`, the source line.
#[derive(Debug)]
pub struct PlanWriter<W> {
    rows: Rows<W>,
    axes: AxisSet,
    rotary: AxisSet,
    clock: Clock,
}

impl<W: Write> PlanWriter<W> {
    /// Starts the table. `rotary` are the joints that turn; where these are not A, B and C (arms),
    /// columns are named `x_deg`, too. `clock` is the one that the samples' ticks count.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W, axes: AxisSet, rotary: AxisSet, clock: Clock) -> io::Result<PlanWriter<W>> {
        let unit = |axis: AxisId| if rotary.contains(axis) { "deg" } else { "mm" };
        let names: Vec<String> = axes
            .iter()
            .map(|axis| format!("{}_{}", axis.letter().to_ascii_lowercase(), unit(axis)))
            .collect();
        let names = names.iter().map(String::as_str);
        let rows = Rows::new(
            out,
            std::iter::once("t_s")
                .chain(names)
                .chain(std::iter::once("line")),
        )?;
        Ok(PlanWriter {
            rows,
            axes,
            rotary,
            clock,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, samples: &[Sample]) -> io::Result<()> {
        for sample in samples {
            self.rows.seconds(sample.tick, self.clock.period_ns());
            for axis in self.axes.iter() {
                let position = sample.position[axis];
                self.rows.number(
                    if self.rotary.contains(axis) {
                        units::deg(position)
                    } else {
                        position
                    },
                    POSITION_DECIMALS,
                );
            }
            self.rows.integer(u64::from(sample.block.span.line));
            self.rows.end()?;
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
