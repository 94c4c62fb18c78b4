//! Tables whose columns are known only at run time.

use super::rows::{ColumnKind, ERROR_DECIMALS, TableCells, TableColumn};
use std::io;

/// What stands in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TableCell<'a> {
    /// Text.
    Text(&'a str),
    /// A measure in um, s or mm, to 1e-4 of its unit; nothing if it is not finite.
    Measure(f64),
    /// A number in all its digits; nothing if it is not finite.
    Exact(f64),
    /// A whole number.
    Integer(i64),
}

impl TableCell<'_> {
    /// Kind of the column that it fits.
    fn kind(self) -> ColumnKind {
        match self {
            TableCell::Text(_) => ColumnKind::Text,
            TableCell::Measure(_) | TableCell::Exact(_) => ColumnKind::Number,
            TableCell::Integer(_) => ColumnKind::Integer,
        }
    }
}

/// Writes rows of any columns.
///
/// ```
/// use lostmotion_report::csv::{ColumnKind, Rows, TableCell, TableColumn, TableWriter};
///
/// let columns = [
///     TableColumn::new("part", ColumnKind::Text),
///     TableColumn::new("max_um", ColumnKind::Number),
/// ];
/// let mut table = TableWriter::<Rows<_>>::start(Vec::new(), &columns)?;
/// table.push(&[TableCell::Text("a, b"), TableCell::Measure(1.0 / 3.0)])?;
/// assert_eq!(table.finish()?, b"part,max_um\n\"a, b\",0.3333\n");
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct TableWriter<T> {
    rows: T,
    kinds: Vec<ColumnKind>,
}

impl<T: TableCells> TableWriter<T> {
    /// Starts a table in its form.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start(out: T::Out, columns: &[TableColumn]) -> io::Result<TableWriter<T>> {
        Ok(TableWriter {
            rows: T::start(out, columns)?,
            kinds: columns.iter().map(|column| column.kind).collect(),
        })
    }

    /// Appends a row.
    ///
    /// # Errors
    /// Those of the writer; cells that do not fit the columns, as [`io::ErrorKind::InvalidInput`].
    pub fn push(&mut self, cells: &[TableCell<'_>]) -> io::Result<()> {
        if !cells
            .iter()
            .map(|cell| cell.kind())
            .eq(self.kinds.iter().copied())
        {
            let message = "the cells of a row do not fit the columns of its table";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        for cell in cells {
            match cell {
                TableCell::Text(text) => self.rows.text(text),
                TableCell::Measure(number) => self.rows.number(*number, ERROR_DECIMALS),
                TableCell::Exact(number) => self.rows.exact(*number),
                TableCell::Integer(number) => self.rows.integer(*number),
            }
        }
        self.rows.end()
    }

    /// Writes what is left and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<T::Out> {
        self.rows.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::csv::Rows;

    #[test]
    fn rows_that_do_not_fit_are_refused_and_numbers_keep_their_digits() {
        let columns = [
            TableColumn::new("n", ColumnKind::Integer),
            TableColumn::new("x", ColumnKind::Number),
        ];
        let mut table = TableWriter::<Rows<_>>::start(Vec::new(), &columns).unwrap();
        use TableCell::{Exact, Integer, Measure};
        for wrong in [
            &[Integer(1)][..],
            &[Integer(1), Integer(2)],
            &[Exact(1.0), Exact(2.0)],
        ] {
            let error = table.push(wrong).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
        }
        table.push(&[Integer(-7), Exact(0.1 + 0.2)]).unwrap();
        table.push(&[Integer(8), Exact(20.0)]).unwrap();
        table.push(&[Integer(9), Measure(f64::NAN)]).unwrap();
        let text = String::from_utf8(table.finish().unwrap()).unwrap();
        assert_eq!(text, "n,x\n-7,0.30000000000000004\n8,20\n9,\n");
    }
}
