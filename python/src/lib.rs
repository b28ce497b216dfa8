//! The Python module `openbench._openbench`, on which the package `openbench` is built.
//!
//! | module | contents |
//! |---|---|
//! | `policy` | `PolicyEnd`: the end of a connection at which a policy in Python sits |
//! | `evaluation` | runs suites with policies of this process |
//! | `environment` | environments for learners |
//! | `adapter` | what a policy sees and does in a run, as in an environment |
//! | `arrays` | points and poses from and to arrays |
//! | `parts` | maps, costmaps, planners and odometry |
//! | `errors` | exceptions by kind |

mod adapter;
mod arrays;
mod environment;
mod errors;
mod evaluation;
mod parts;
mod policy;
mod suite;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;

/// Names the file of this module, whose hash is in results.
#[pyfunction]
fn set_module(file: PathBuf) {
    openbench::set_module(file);
}

/// Runs the command line; returns the exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| openbench::main_of(arguments, openbench::Extensions::new()))
}

#[pymodule]
fn _openbench(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(set_module, module)?)?;
    module.add_class::<policy::PolicyEnd>()?;
    module.add_class::<evaluation::Run>()?;
    module.add_class::<environment::PyOptions>()?;
    module.add_class::<environment::PyEnvironments>()?;
    module.add_class::<adapter::PyAdapter>()?;
    parts::add(module)?;
    errors::add(module)
}
