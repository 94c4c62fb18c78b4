//! The extension module `lostmotion._native` of the Python package `lostmotion`: values of the
//! library as Python's, and nothing else. What a user meets is `python/lostmotion`, whose stubs say
//! shapes and units.
//!
//! Whatever may take long runs on a thread of its own without Python's lock ([`apart`]), so that
//! other Python threads go on and Ctrl-C is heard.

mod apart;
mod axis;
mod compensator;
mod error;
mod fit;
mod machine;
mod options;
mod plan;
mod program;
mod run;
mod sweep;
mod table;

use pyo3::prelude::*;

/// Classes and functions of the module.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::apart::Progress;
    #[pymodule_export]
    use crate::axis::Axis;
    #[pymodule_export]
    use crate::compensator::Tick;
    #[pymodule_export]
    use crate::fit::{fit, identify};
    #[pymodule_export]
    use crate::machine::{Imported, Machine, import_machine, machine_keys, presets};
    #[pymodule_export]
    use crate::plan::{Plan, plan};
    #[pymodule_export]
    use crate::program::{Operations, Program};
    #[pymodule_export]
    use crate::run::{Run, methods, schema, simulate};
    #[pymodule_export]
    use crate::sweep::{SweepDriver, sweep_collect, sweep_plan, sweep_work};
    #[pymodule_export]
    use crate::table::{Column, Table};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
