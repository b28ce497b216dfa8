//! Points and poses from and to arrays.

use numpy::{AllowTypeChange, IntoPyArray, PyArray2, PyArrayLike2, PyArrayMethods};
use openbench_core::MapPoint;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Rows of numbers: an array, or what can be made into one.
pub type Rows<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;

/// A matrix of Python.
pub type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// The rows of an array with so many columns.
///
/// # Errors
/// `ValueError` that names the argument.
pub fn rows_of<const N: usize>(rows: &Rows<'_>, name: &str) -> PyResult<Vec<[f64; N]>> {
    let array = rows.as_array();
    if array.ncols() != N {
        return Err(PyValueError::new_err(format!(
            "{name}: the shape is {:?} instead of (n, {N})",
            array.shape()
        )));
    }
    let row = |row: numpy::ndarray::ArrayView1<'_, f64>| std::array::from_fn(|i| row[i]);
    Ok(array.rows().into_iter().map(row).collect())
}

/// Points of an array (n, 2).
///
/// # Errors
/// `ValueError` that names the argument: another shape, or numbers that are not finite.
pub fn points_of(rows: &Rows<'_>, name: &str) -> PyResult<Vec<MapPoint>> {
    let rows = rows_of::<2>(rows, name)?;
    if !rows.iter().flatten().all(|number| number.is_finite()) {
        return Err(PyValueError::new_err(format!("{name}: NaN or infinity")));
    }
    Ok(rows.into_iter().map(|[x, y]| MapPoint::new(x, y)).collect())
}

/// A point of two numbers.
///
/// # Errors
/// `ValueError` that names the argument, if they are not finite.
pub fn point_of((x, y): (f64, f64), name: &str) -> PyResult<MapPoint> {
    if x.is_finite() && y.is_finite() {
        Ok(MapPoint::new(x, y))
    } else {
        Err(PyValueError::new_err(format!("{name}: NaN or infinity")))
    }
}

/// Points as an array (n, 2).
pub fn to_array<'py>(py: Python<'py>, points: &[MapPoint]) -> PyResult<Matrix<'py>> {
    let numbers: Vec<f64> = points.iter().flat_map(|point| [point.x, point.y]).collect();
    numbers.into_pyarray(py).reshape([points.len(), 2])
}
