//! What differs between controls in a program of straight moves, arcs and dwells.

use lostmotion_gcode::Dialect;

/// A program being written.
#[derive(Clone, Debug)]
pub(super) struct Writer {
    dialect: Dialect,
    text: String,
    lines: u32,
}

impl Writer {
    /// Begins a program, with a remark on what it is.
    pub(super) fn new(dialect: Dialect, about: &str) -> Writer {
        let mut writer = Writer {
            dialect,
            text: String::new(),
            lines: 0,
        };
        if writer.is_production() {
            writer.line("%");
            writer.line("O0001");
        }
        writer.remark(about);
        // Exact words: what other programs have left on the control plays no part.
        writer.line(match dialect {
            Dialect::Marlin | Dialect::Klipper => "G21\nG90",
            Dialect::LinuxCnc => "G21 G90 G17 G40 G49 G80 G94 G54 G64 P0.001",
            // Lengths and feeds in mm, tool length off, no exact stop between tangential blocks.
            Dialect::Siemens => "G710 G90 G17 G40 D0 G94 G54 G64",
            _ => "G21 G90 G17 G40 G49 G80 G94 G54",
        });
        writer
    }

    /// Fanuc and its kin.
    fn is_production(&self) -> bool {
        matches!(self.dialect, Dialect::Fanuc | Dialect::Haas)
    }

    /// Whether a remark runs from a semicolon to the end of the line.
    fn has_semicolons(&self) -> bool {
        matches!(
            self.dialect,
            Dialect::Marlin | Dialect::Klipper | Dialect::Siemens
        )
    }

    /// Adds a block; returns its line. A line feed in it makes it several.
    pub(super) fn line(&mut self, block: &str) -> u32 {
        for line in block.lines() {
            self.text.push_str(line);
            self.text.push('\n');
            self.lines += 1;
        }
        self.lines
    }

    /// Adds a remark.
    pub(super) fn remark(&mut self, text: &str) {
        let plain = text.replace(['(', ')', '\n'], " ").replace(';', ",");
        if self.has_semicolons() {
            self.line(&format!("; {plain}"));
        } else {
            self.line(&format!("({plain})"));
        }
    }

    /// Adds a dwell, s.
    pub(super) fn dwell(&mut self, seconds: f64) {
        let block = match self.dialect {
            // Seconds whatever the control's increment.
            Dialect::Fanuc => format!("G4 X{seconds:.3}"),
            Dialect::Haas => format!("G4 P{seconds:.3}"),
            Dialect::Siemens => format!("G4 F{seconds}"),
            Dialect::Marlin | Dialect::Klipper => format!("G4 P{:.0}", 1e3 * seconds),
            _ => format!("G4 P{seconds}"),
        };
        self.line(&block);
    }

    /// The whole program.
    pub(super) fn finish(mut self) -> String {
        match self.dialect {
            // Printers have no code for the end.
            Dialect::Marlin | Dialect::Klipper => {}
            Dialect::Fanuc | Dialect::Haas => {
                self.line("M30\n%");
            }
            Dialect::Siemens => {
                self.line("M30");
            }
            Dialect::LinuxCnc => {
                self.line("M2");
            }
        }
        self.text
    }
}

/// A number of mm or deg as every control reads it: with a decimal point.
pub(super) fn word(value: f64) -> String {
    let text = format!("{value:.4}");
    let short = text.trim_end_matches('0');
    let short = if short == "-0." { "0." } else { short };
    short.to_owned()
}

/// A number of mm or deg as people write it.
pub(super) fn plain(value: f64) -> String {
    word(value).trim_end_matches('.').to_owned()
}
