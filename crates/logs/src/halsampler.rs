//! The text of LinuxCNC's `halsampler`: numbers with a blank behind each, no header, no period.

use crate::error::LogError;
use crate::source::{
    Channel, FileColumns, Format, Head, Header, MAX_CHANNELS, ReadOptions, Row, Source,
};
use crate::text::{Lines, no_number, number};
use std::io::BufRead;

/// Steps by one for each jump of a column that still counts samples. A choice: lost samples are few.
const JUMP_SHARE: usize = 10;

/// What stands alone on a line where samples were lost.
const OVERRUN: &str = "overrun";

/// Whether the text can only be that of `halsampler`: every row ends in a blank, as no spreadsheet
/// writes it, or there is a mark of lost samples.
pub(crate) fn is_one(head: &Head) -> bool {
    let mut rows = 0;
    for line in head.rows() {
        if line.trim() == OVERRUN {
            continue;
        }
        let numbers = line
            .split_whitespace()
            .all(|cell| number(cell, '.').is_some());
        if !numbers || !line.ends_with(' ') || line.contains(['\t', ';', ',']) {
            // The last line of a recording that was killed may be cut anywhere.
            return rows > 1 && head.rows().last() == Some(line);
        }
        rows += 1;
    }
    rows > 0
}

/// Whether the first column counts samples: whole numbers that rise by one, but where rows were lost.
fn counts(head: &Head) -> bool {
    let mut before: Option<u64> = None;
    let (mut steps, mut jumps) = (0, 0);
    for line in head.rows() {
        if line.trim() == OVERRUN {
            before = None;
            continue;
        }
        let mut cells = line.split_whitespace();
        let Some(tag) = cells.next().and_then(|cell| cell.parse::<u64>().ok()) else {
            return false;
        };
        // A counter alone is no log.
        if cells.next().is_none() {
            return false;
        }
        if let Some(before) = before {
            if tag <= before {
                return false;
            }
            if tag == before + 1 {
                steps += 1;
            } else {
                jumps += 1;
            }
        }
        before = Some(tag);
    }
    steps > 0 && JUMP_SHARE * jumps <= steps
}

pub(crate) fn open<'a, R: BufRead + 'a>(
    lines: Lines<R>,
    head: &Head,
    options: &ReadOptions,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    let Some(period_s) = options.period_s else {
        return Err(LogError::file(
            lines.name(),
            "a halsampler text does not tell its period",
            "give the period of the thread that sampled, such as --period-ms 1",
        ));
    };
    let tagged = options.tagged.unwrap_or_else(|| counts(head));
    let first = head.rows().find(|line| line.trim() != OVERRUN);
    let cells = first.map_or(0, |line| line.split_whitespace().count());
    if cells <= usize::from(tagged) || cells > MAX_CHANNELS {
        return Err(LogError::file(lines.name(), "there are no channels", ""));
    }
    let channels = (1..=cells - usize::from(tagged))
        .map(|pin| Channel {
            name: format!("pin{pin}"),
            unit: None,
            group: 0,
        })
        .collect();
    let said = vec![
        if tagged {
            "the first column rises by one and is taken for the number of the sample".to_owned()
        } else {
            "no column counts samples: where rows were lost, time is lost without a mark".to_owned()
        },
        "channels have no names and no units here: pin1 is the first".to_owned(),
    ];
    let header = Header {
        columns: Some(FileColumns::behind(
            usize::from(tagged),
            cells - usize::from(tagged),
        )),
        format: Format::Halsampler,
        channels,
        groups: 1,
        said,
        guessed_time: None,
    };
    let source = Halsampler {
        wanted: vec![true; header.channels.len()],
        lines,
        cells,
        tagged,
        period_s,
        row: 0,
        wraps: 0,
        last_tag: None,
        part: 0,
        lost: 0,
        marks: 0,
        remarks: Vec::new(),
    };
    Ok((header, Box::new(source)))
}

struct Halsampler<R> {
    lines: Lines<R>,
    cells: usize,
    wanted: Vec<bool>,
    tagged: bool,
    period_s: f64,
    row: u64,
    wraps: u64,
    last_tag: Option<u64>,
    part: u32,
    lost: u64,
    marks: u64,
    remarks: Vec<String>,
}

impl<R: BufRead> Halsampler<R> {
    /// The number of the sample from its tag, counted through the 32 bits that it has.
    fn sample(&mut self, cell: &str) -> Result<u64, LogError> {
        let line = self.lines.line();
        let Ok(tag) = cell.parse::<u32>() else {
            let (what, hint) = (
                "is not the number of a sample",
                "the first column counts samples",
            );
            return Err(LogError::cell(
                self.lines.name(),
                line,
                "tag",
                cell,
                what,
                hint,
            ));
        };
        let mut sample = self.wraps * (1 << 32) + u64::from(tag);
        if let Some(last) = self.last_tag {
            let half = 1 << 31;
            if sample < last && last - sample > half {
                self.wraps += 1;
                sample += 1 << 32;
            } else if sample <= last {
                // Counting began anew: another recording, at an unknown time.
                self.part += 1;
                self.wraps = 0;
                sample = u64::from(tag);
            } else {
                self.lost += sample - last - 1;
            }
        }
        self.last_tag = Some(sample);
        Ok(sample)
    }
}

impl<R> Halsampler<R> {
    /// Says what is missing.
    fn end(&mut self) {
        let (lost, marks) = (self.lost, self.marks);
        if lost > 0 {
            self.remarks
                .push(format!("{lost} samples are missing by their numbers"));
        }
        if marks > 0 {
            self.remarks
                .push(format!("`overrun` stands {marks} times in the text"));
        }
        (self.lost, self.marks) = (0, 0);
    }
}

impl<R: BufRead> Source for Halsampler<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        loop {
            if !self.lines.advance()? {
                self.end();
                return Ok(false);
            }
            if !self.lines.ended() {
                // halsampler ends every line: what has no end was cut, perhaps within a number.
                let line = self.lines.line();
                self.remarks
                    .push(format!("line {line} is cut and was left out"));
                self.end();
                return Ok(false);
            }
            let text = self.lines.text();
            if text.trim().is_empty() {
                continue;
            }
            if text.trim() == OVERRUN {
                self.marks += 1;
                // Without numbers nobody knows how much time went by.
                if !self.tagged && self.row > 0 {
                    self.part += 1;
                }
                continue;
            }
            break;
        }
        let line = self.lines.line();
        let text = self.lines.text().to_owned();
        let found = text.split_whitespace().count();
        if found != self.cells {
            let what = format!("{found} values where the first row has {}", self.cells);
            return Err(LogError::line(self.lines.name(), line, what, ""));
        }
        row.values.clear();
        let mut cells = text.split_whitespace();
        let sample = if self.tagged {
            self.sample(cells.next().unwrap_or_default())?
        } else {
            self.row
        };
        for (index, cell) in cells.enumerate() {
            match number(cell, '.') {
                Some(value) => row.values.push(value),
                None if self.wanted.get(index) == Some(&false) => row.values.push(f64::NAN),
                None => {
                    let (what, hint) = no_number(cell, '.');
                    let column = format!("pin{}", index + 1);
                    return Err(LogError::cell(
                        self.lines.name(),
                        line,
                        &column,
                        cell,
                        what,
                        hint,
                    ));
                }
            }
        }
        row.line = line;
        row.group = 0;
        row.part = self.part;
        row.time_s = sample as f64 * self.period_s;
        self.row += 1;
        Ok(true)
    }

    fn select(&mut self, wanted: &[bool]) {
        self.wanted = wanted.to_vec();
    }

    fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }
}
