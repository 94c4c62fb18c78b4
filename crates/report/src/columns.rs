//! Tables in memory, column by column: what a binding hands to a data tool without a copy.
//!
//! The columns are those of the CSV form, typed. Numbers are in full, not rounded to decimals; one
//! that is not known is NaN.

use crate::csv::{ColumnKind, TableCells, TableColumn};
use std::collections::HashMap;
use std::io;

/// What stands in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum ColumnCells {
    /// Texts that repeat: for each row the place of its text in the list of different ones.
    Text {
        /// Places, a row each.
        places: Vec<i32>,
        /// Different texts, in the order in which they came.
        texts: Vec<String>,
    },
    /// Numbers.
    Number(Vec<f64>),
    /// Whole numbers.
    Integer(Vec<i64>),
}

/// A column with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledColumn {
    /// Its name, with the unit.
    pub name: String,
    /// What stands in it, a row each.
    pub cells: ColumnCells,
}

/// A table in memory; any writer of [`crate::csv`] fills one.
///
/// ```
/// use lostmotion_report::columns::{ColumnCells, ColumnTable};
/// use lostmotion_report::csv::BlockWriter;
/// use lostmotion_sim::results::BlockResult;
///
/// let mut writer = BlockWriter::<ColumnTable>::start(Vec::new())?;
/// writer.push("none", &[BlockResult::default()])?;
/// let columns = writer.finish()?;
/// assert_eq!(columns[5].name, "time_s");
/// assert_eq!(columns[5].cells, ColumnCells::Number(vec![0.0]));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColumnTable {
    columns: Vec<FilledColumn>,
    /// For each column of texts where its texts stand.
    known: Vec<HashMap<String, i32>>,
    /// Place of the next cell's column.
    next: usize,
}

impl ColumnTable {
    fn cell(&mut self) -> Option<(&mut ColumnCells, &mut HashMap<String, i32>)> {
        let at = self.next;
        self.next += 1;
        let cells = &mut self.columns.get_mut(at)?.cells;
        Some((cells, self.known.get_mut(at)?))
    }
}

impl TableCells for ColumnTable {
    type Out = Vec<FilledColumn>;

    /// The list given is where the columns go; what stands in it is forgotten.
    fn start(_out: Vec<FilledColumn>, columns: &[TableColumn]) -> io::Result<ColumnTable> {
        let empty = |column: &TableColumn| FilledColumn {
            name: column.name.clone(),
            cells: match column.kind {
                ColumnKind::Text => ColumnCells::Text {
                    places: Vec::new(),
                    texts: Vec::new(),
                },
                ColumnKind::Number => ColumnCells::Number(Vec::new()),
                ColumnKind::Integer => ColumnCells::Integer(Vec::new()),
            },
        };
        Ok(ColumnTable {
            columns: columns.iter().map(empty).collect(),
            known: vec![HashMap::new(); columns.len()],
            next: 0,
        })
    }

    fn text(&mut self, text: &str) {
        let Some((ColumnCells::Text { places, texts }, known)) = self.cell() else {
            return;
        };
        let place = known.get(text).copied().unwrap_or_else(|| {
            let place = i32::try_from(texts.len()).unwrap_or(i32::MAX);
            texts.push(text.to_owned());
            known.insert(text.to_owned(), place);
            place
        });
        places.push(place);
    }

    fn number(&mut self, value: f64, _decimals: usize) {
        if let Some((ColumnCells::Number(values), _)) = self.cell() {
            values.push(value);
        }
    }

    fn integer(&mut self, value: i64) {
        if let Some((ColumnCells::Integer(values), _)) = self.cell() {
            values.push(value);
        }
    }

    fn end(&mut self) -> io::Result<()> {
        self.next = 0;
        Ok(())
    }

    fn finish(self) -> io::Result<Vec<FilledColumn>> {
        Ok(self.columns)
    }
}
