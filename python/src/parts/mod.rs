//! The parts of the baseline as classes.
//!
//! | module | contents |
//! |---|---|
//! | `map` | `Map`: buildings, addresses, routes and plans |
//! | `motion` | `Costmap`, `Obstacle`, `LocalPlanner` |
//! | `odometry` | `Odometry`, `Estimate` |

mod map;
mod motion;
mod odometry;

use pyo3::prelude::*;

/// Adds the classes to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<map::Map>()?;
    module.add_class::<motion::Costmap>()?;
    module.add_class::<motion::PyObstacle>()?;
    module.add_class::<motion::PyLocalPlanner>()?;
    module.add_class::<odometry::Odometry>()?;
    module.add_class::<odometry::PyEstimate>()
}
