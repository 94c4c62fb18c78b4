//! Printers: what their lines mean on a machine tool.

use super::super::Interpreter;
use super::Line;
use crate::code::whole;
use crate::dialect::Leniency;
use crate::syntax::Value;

/// G codes in tenths, and M codes, of printers that mean the same here.
const PRINTER_G: [u16; 25] = [
    0, 10, 20, 30, 40, 50, 170, 180, 190, 200, 210, 280, 530, 540, 550, 560, 570, 580, 590, 591,
    592, 593, 900, 910, 920,
];
const PRINTER_M: [f64; 11] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 30.0];

impl Interpreter {
    /// What a printer's line means on a machine tool.
    pub(super) fn printer_line(&mut self) -> Line {
        let accepted = self.config.leniencies;
        let foreign = self
            .block
            .words
            .iter()
            .any(|word| match (word.letter, word.value) {
                (b'G', Value::Number(number)) => whole(number * 10.0).is_none_or(|tenths| {
                    !PRINTER_G.iter().any(|known| f64::from(*known) == tenths)
                }),
                (b'M', Value::Number(number)) => !PRINTER_M.contains(&number),
                _ => false,
            });
        if foreign && accepted.has(Leniency::PrinterCodes) {
            self.tell(Leniency::PrinterCodes);
            return Line::Done;
        }
        if accepted.has(Leniency::ExtruderWords)
            && self.block.words.iter().any(|word| word.letter == b'E')
        {
            self.tell(Leniency::ExtruderWords);
            self.block.words.retain(|word| word.letter != b'E');
            let has_axis = self
                .block
                .words
                .iter()
                .any(|word| matches!(word.letter, b'X'..=b'Z' | b'A'..=b'C' | b'U'..=b'W'));
            self.block.words.retain(|word| {
                has_axis || word.letter != b'G' || word.value != Value::Number(92.0)
            });
        }
        self.printer_dwell();
        Line::Words
    }

    /// G4 of printers: P in milliseconds, S in seconds.
    fn printer_dwell(&mut self) {
        if !self
            .block
            .words
            .iter()
            .any(|word| word.letter == b'G' && word.value == Value::Number(4.0))
        {
            return;
        }
        let has_s = self.block.words.iter().any(|word| word.letter == b'S');
        self.block
            .words
            .retain(|word| !(has_s && word.letter == b'P'));
        for word in &mut self.block.words {
            match (word.letter, word.value) {
                (b'S', _) => word.letter = b'P',
                (b'P', Value::Number(ms)) => word.value = Value::Number(ms / 1000.0),
                _ => {}
            }
        }
    }
}
