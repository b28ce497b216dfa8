//! Exceptions by kind.

use openbench_bench::BenchError;
use openbench_core::with_causes;
use openbench_environment::EnvironmentError;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    _openbench,
    OpenBenchError,
    PyException,
    "Any error of this package."
);
create_exception!(
    _openbench,
    InputError,
    OpenBenchError,
    "A suite, a setting or a file that cannot be used."
);
create_exception!(
    _openbench,
    PlanningError,
    OpenBenchError,
    "No plan, no route, no path, or no way on."
);
create_exception!(
    _openbench,
    ProtocolError,
    OpenBenchError,
    "Benchmark and policy do not understand each other."
);

/// Adds the exceptions to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("OpenBenchError", py.get_type::<OpenBenchError>())?;
    module.add("InputError", py.get_type::<InputError>())?;
    module.add("PlanningError", py.get_type::<PlanningError>())?;
    module.add("ProtocolError", py.get_type::<ProtocolError>())
}

/// An error of the benchmark as an exception.
pub fn raised(error: &BenchError) -> PyErr {
    match error {
        BenchError::Interrupted => PyKeyboardInterrupt::new_err(()),
        error => InputError::new_err(with_causes(error)),
    }
}

/// An error of an environment as an exception.
pub fn of_environment(error: &EnvironmentError) -> PyErr {
    match error {
        EnvironmentError::Bench(error) => raised(error),
        EnvironmentError::Action(_) => PyValueError::new_err(error.to_string()),
        EnvironmentError::NoEpisode
        | EnvironmentError::AtWork(_)
        | EnvironmentError::Idle { .. }
        | EnvironmentError::Panicked => PyRuntimeError::new_err(error.to_string()),
        error => InputError::new_err(with_causes(error)),
    }
}
