//! Tables of samples, blocks and reversals: columns that numpy, Arrow, pandas and polars take
//! without a copy.

use crate::error::Refusal;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{
    ArrayRef, DictionaryArray, Float64Array, Int32Array, Int64Array, RecordBatch,
    RecordBatchIterator, StringArray,
};
use arrow_buffer::ScalarBuffer;
use arrow_schema::{ArrowError, DataType, Field, Schema};
use lostmotion::report::columns::{ColumnCells, FilledColumn};
use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyCapsule, PyDict, PyList, PyTuple};
use std::sync::Arc;

/// Cells of a column, shared by all who look at them.
#[derive(Clone)]
enum Data {
    Number(ScalarBuffer<f64>),
    Integer(ScalarBuffer<i64>),
    /// Texts that repeat: a place in the list of different ones for each row.
    Text(ScalarBuffer<i32>, Arc<Vec<String>>),
}

impl Data {
    fn of(cells: ColumnCells) -> Data {
        match cells {
            ColumnCells::Number(values) => Data::Number(values.into()),
            ColumnCells::Integer(values) => Data::Integer(values.into()),
            ColumnCells::Text { places, texts } => Data::Text(places.into(), Arc::new(texts)),
        }
    }

    fn len(&self) -> usize {
        match self {
            Data::Number(values) => values.len(),
            Data::Integer(values) => values.len(),
            Data::Text(places, _) => places.len(),
        }
    }

    /// Memory address and numpy's name of the type.
    fn place(&self) -> (usize, &'static str) {
        match self {
            Data::Number(values) => (values.as_ptr().addr(), "<f8"),
            Data::Integer(values) => (values.as_ptr().addr(), "<i8"),
            Data::Text(places, _) => (places.as_ptr().addr(), "<i4"),
        }
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Data::Number(values) => values.inner(),
            Data::Integer(values) => values.inner(),
            Data::Text(places, _) => places.inner(),
        }
    }

    fn arrow(&self) -> Result<(DataType, ArrayRef), Refusal> {
        Ok(match self {
            Data::Number(values) => (
                DataType::Float64,
                Arc::new(Float64Array::new(values.clone(), None)),
            ),
            Data::Integer(values) => (
                DataType::Int64,
                Arc::new(Int64Array::new(values.clone(), None)),
            ),
            Data::Text(places, texts) => {
                let keys = Int32Array::new(places.clone(), None);
                let texts = Arc::new(StringArray::from_iter_values(texts.iter()));
                let array =
                    DictionaryArray::try_new(keys, texts).map_err(|error| unmade(&error))?;
                let kind = DataType::Dictionary(DataType::Int32.into(), DataType::Utf8.into());
                (kind, Arc::new(array))
            }
        })
    }
}

fn unmade(error: &ArrowError) -> Refusal {
    Refusal::data(format!("cannot make an Arrow table: {error}"), "")
}

/// A column, whose memory numpy reads in place.
#[pyclass(frozen, module = "lostmotion._native")]
pub(crate) struct Column(Data);

#[pymethods]
impl Column {
    fn __len__(&self) -> usize {
        self.0.len()
    }

    /// numpy's array interface, version 3: read-only, and kept alive by whoever holds this column.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (address, kind) = self.0.place();
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("shape", (self.0.len(),))?;
        interface.set_item("typestr", kind)?;
        interface.set_item("data", (address, true))?;
        Ok(interface)
    }
}

/// A table of columns of equal length.
#[pyclass(frozen, mapping, from_py_object, module = "lostmotion")]
#[derive(Clone)]
pub(crate) struct Table {
    columns: Arc<Vec<(String, Data)>>,
}

impl Table {
    /// Of columns that a writer has filled.
    pub(crate) fn of(columns: Vec<FilledColumn>) -> Table {
        let data = |column: FilledColumn| (column.name, Data::of(column.cells));
        Table {
            columns: Arc::new(columns.into_iter().map(data).collect()),
        }
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, data)| data.len())
    }

    fn find(&self, name: &str) -> PyResult<&Data> {
        let found = self.columns.iter().find(|(known, _)| known == name);
        found.map(|(_, data)| data).ok_or_else(|| {
            let known: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
            PyKeyError::new_err(format!(
                "there is no column \"{name}\"; the columns are {}",
                known.join(", ")
            ))
        })
    }

    fn batch(&self) -> Result<RecordBatch, Refusal> {
        let mut fields = Vec::new();
        let mut arrays = Vec::new();
        for (name, data) in self.columns.iter() {
            let (kind, array) = data.arrow()?;
            fields.push(Field::new(name, kind, false));
            arrays.push(array);
        }
        RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays).map_err(|error| unmade(&error))
    }
}

/// Name, kind, memory, and texts of a column of texts.
type PickledColumn = (String, String, PyBackedBytes, Option<Vec<String>>);

/// A package that is needed for this form alone.
fn package<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyModule>> {
    py.import(name).map_err(|_| {
        let message = format!("{name} is not installed");
        let hint = format!("pip install {name}");
        Refusal::new("MissingPackage", "missing-package", message, &hint).raised(py)
    })
}

#[pymethods]
impl Table {
    /// Names of the columns, each with its unit.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.columns.iter().map(|(name, _)| name.as_str()).collect()
    }

    fn __len__(&self) -> usize {
        self.rows()
    }

    fn __contains__(&self, name: &str) -> bool {
        self.columns.iter().any(|(known, _)| known == name)
    }

    fn keys(&self) -> Vec<&str> {
        self.columns()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyTuple::new(py, self.columns())?
            .into_any()
            .call_method0("__iter__")
    }

    /// The column of a name as a numpy array: numbers in place, texts as objects.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let data = self.find(name)?.clone();
        let numpy = package(py, "numpy")?;
        let texts = match &data {
            Data::Text(_, texts) => Some(Arc::clone(texts)),
            _ => None,
        };
        let array = numpy.call_method1("asarray", (Column(data),))?;
        match texts {
            None => Ok(array),
            Some(texts) => {
                let named = PyDict::new(py);
                named.set_item("dtype", py.import("builtins")?.getattr("object")?)?;
                let texts = numpy.call_method("array", (texts.as_slice(),), Some(&named))?;
                texts.call_method1("__getitem__", (array,))
            }
        }
    }

    /// The row of a number, as a dictionary; from the end where it is below 0.
    fn row<'py>(&self, py: Python<'py>, index: isize) -> PyResult<Bound<'py, PyDict>> {
        let rows = self.rows();
        let place = if index < 0 {
            rows.checked_add_signed(index)
        } else {
            usize::try_from(index).ok()
        };
        let place = place.filter(|place| *place < rows).ok_or_else(|| {
            PyIndexError::new_err(format!("there is no row {index}; the table has {rows}"))
        })?;
        let row = PyDict::new(py);
        for (name, data) in self.columns.iter() {
            match data {
                Data::Number(values) => row.set_item(name, values.get(place))?,
                Data::Integer(values) => row.set_item(name, values.get(place))?,
                Data::Text(places, texts) => {
                    let text = places.get(place).and_then(|at| texts.get(*at as usize));
                    row.set_item(name, text)?;
                }
            }
        }
        Ok(row)
    }

    /// Arrow's PyCapsule interface: a stream of one batch, whose memory is this table's.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A producer may give its own schema whatever is asked for.
        let _ = requested_schema;
        let batch = self.batch()?;
        let schema = batch.schema();
        let batches = RecordBatchIterator::new([Ok(batch)], schema);
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }

    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let pandas = package(py, "pandas")?;
        let columns = PyDict::new(py);
        for (name, data) in self.columns.iter() {
            let column = match data {
                Data::Text(places, texts) => {
                    let codes = package(py, "numpy")?.call_method1(
                        "asarray",
                        (Column(Data::Text(places.clone(), Arc::clone(texts))),),
                    )?;
                    let class = pandas.getattr("Categorical")?;
                    class.call_method1("from_codes", (codes, texts.as_slice()))?
                }
                _ => self.__getitem__(py, name)?,
            };
            columns.set_item(name, column)?;
        }
        let named = PyDict::new(py);
        named.set_item("copy", false)?;
        pandas.call_method("DataFrame", (columns,), Some(&named))
    }

    fn to_polars<'py>(slf: &Bound<'py, Table>) -> PyResult<Bound<'py, PyAny>> {
        package(slf.py(), "polars")?.call_method1("DataFrame", (slf,))
    }

    fn to_arrow<'py>(slf: &Bound<'py, Table>) -> PyResult<Bound<'py, PyAny>> {
        package(slf.py(), "pyarrow")?.call_method1("table", (slf,))
    }

    fn __repr__(&self) -> String {
        format!("Table({} rows: {})", self.rows(), self.columns().join(", "))
    }

    /// What `_restore` takes.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let columns = PyList::empty(py);
        for (name, data) in self.columns.iter() {
            let bytes = PyBytes::new(py, data.bytes());
            let texts = match data {
                Data::Text(_, texts) => Some(texts.as_slice()),
                _ => None,
            };
            columns.append((name, data.place().1, bytes, texts))?;
        }
        let restore = py.get_type::<Table>().getattr("_restore")?;
        Ok((restore, PyTuple::new(py, [columns])?.into_any()))
    }

    #[staticmethod]
    fn _restore(columns: Vec<PickledColumn>) -> PyResult<Table> {
        let data = |(name, kind, bytes, texts): PickledColumn| {
            let data = match (kind.as_str(), texts) {
                ("<f8", None) => Data::Number(eights(&bytes, f64::from_ne_bytes).into()),
                ("<i8", None) => Data::Integer(eights(&bytes, i64::from_ne_bytes).into()),
                ("<i4", Some(texts)) => {
                    let fours = bytes.chunks_exact(4);
                    let places: Vec<i32> = fours
                        .map(|four| i32::from_ne_bytes([four[0], four[1], four[2], four[3]]))
                        .collect();
                    Data::Text(places.into(), Arc::new(texts))
                }
                _ => return Err(Refusal::data("this is no pickled table", "").into()),
            };
            Ok((name, data))
        };
        let columns: PyResult<Vec<(String, Data)>> = columns.into_iter().map(data).collect();
        let columns = columns?;
        let rows = columns.first().map_or(0, |(_, data)| data.len());
        if columns.iter().any(|(_, data)| data.len() != rows) {
            return Err(Refusal::data("this is no pickled table", "").into());
        }
        Ok(Table {
            columns: Arc::new(columns),
        })
    }
}

/// Numbers of eight bytes.
pub(crate) fn eights<T>(bytes: &[u8], of: impl Fn([u8; 8]) -> T) -> Vec<T> {
    let eights = bytes.chunks_exact(8);
    eights
        .map(|eight| {
            let mut number = [0; 8];
            number.copy_from_slice(eight);
            of(number)
        })
        .collect()
}
