//! Maps: buildings, addresses, routes and plans.

use std::path::PathBuf;
use std::sync::OnceLock;

use openbench_core::{Address, Georeference, LonLat, MapPoint, with_causes};
use openbench_language::{GrammarPlanner, PlanRequest, Planner, destination};
use openbench_osm::{OsmData, OsmMap, default_georeference};
use openbench_routing::{MapRouter, Profile, Router, RouterTimes};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Matrix, Rows, point_of, points_of, to_array};
use crate::errors::{InputError, PlanningError};

/// Longest file of a map, bytes.
const MOST_BYTES: u64 = 4 << 30;
/// Speed where there are no roads, m/s.
const OFF_ROAD_MPS: f64 = 0.5;

/// OpenStreetMap data in metres.
#[pyclass(frozen)]
pub struct Map {
    data: OsmData,
    pub(super) map: OsmMap,
    /// Made when it is first asked for.
    router: OnceLock<Result<MapRouter, String>>,
}

fn unusable(error: &(dyn std::error::Error + 'static)) -> PyErr {
    InputError::new_err(with_causes(error))
}

#[pymethods]
impl Map {
    /// The map of OSM XML or PBF; its frame is the usual one unless it is given.
    #[new]
    #[pyo3(signature = (data, georeference=None))]
    fn new(py: Python<'_>, data: Vec<u8>, georeference: Option<String>) -> PyResult<Self> {
        py.detach(|| {
            let data = OsmData::from_bytes(&data).map_err(|error| unusable(&error))?;
            let georeference: Georeference = match georeference {
                Some(text) => text.parse().map_err(|error| unusable(&error))?,
                None => default_georeference(&data).map_err(|error| unusable(&error))?,
            };
            Ok(Self {
                map: OsmMap::new(&data, georeference),
                data,
                router: OnceLock::new(),
            })
        })
    }

    /// The map of a file.
    #[staticmethod]
    #[pyo3(signature = (path, georeference=None))]
    fn read(py: Python<'_>, path: PathBuf, georeference: Option<String>) -> PyResult<Self> {
        let bytes = py.detach(|| openbench_core::input::read(&path, MOST_BYTES));
        let bytes = bytes.map_err(|e| InputError::new_err(format!("{}: {e}", path.display())))?;
        Self::new(py, bytes, georeference)
    }

    /// The frame of all coordinates, as `--georef` takes it.
    #[getter]
    fn georeference(&self) -> String {
        self.map.projection.georeference().to_string()
    }

    /// Names and outlines (n, 2) of the buildings.
    fn buildings<'py>(&self, py: Python<'py>) -> PyResult<Vec<(Option<String>, Matrix<'py>)>> {
        let building = |building: &openbench_osm::Building| {
            let outline = to_array(py, &building.polygon.outer)?;
            Ok((building.name.clone(), outline))
        };
        self.map.buildings.iter().map(building).collect()
    }

    /// The door of an address, or the middle of its building; `None` if the map has neither, or
    /// several.
    #[pyo3(signature = (building, unit=None))]
    fn locate(&self, building: String, unit: Option<String>) -> Option<(f64, f64)> {
        let at = destination(&self.map, &Address { building, unit })?;
        Some((at.x, at.y))
    }

    /// Degrees (n, 2), longitude first, as metres.
    fn to_map<'py>(&self, py: Python<'py>, lonlat: Rows<'py>) -> PyResult<Matrix<'py>> {
        let degrees = points_of(&lonlat, "lonlat")?.into_iter();
        let points = degrees.map(|at| self.map.projection.to_map(LonLat::new(at.x, at.y)));
        to_array(py, &points.collect::<Vec<_>>())
    }

    /// Metres (n, 2) as degrees, longitude first.
    fn to_lonlat<'py>(&self, py: Python<'py>, points: Rows<'py>) -> PyResult<Matrix<'py>> {
        let points = points_of(&points, "points")?.into_iter();
        let degrees = points.map(|point| {
            let at = self.map.projection.to_lonlat(point);
            MapPoint::new(at.lon, at.lat)
        });
        to_array(py, &degrees.collect::<Vec<_>>())
    }

    /// The fastest route for a delivery robot.
    fn route<'py>(
        &self,
        py: Python<'py>,
        start: (f64, f64),
        goal: (f64, f64),
    ) -> PyResult<Bound<'py, PyDict>> {
        let (start, goal) = (point_of(start, "start")?, point_of(goal, "goal")?);
        let route = py.detach(|| {
            let route = self.router()?.route(start, goal);
            route.map_err(|error| PlanningError::new_err(error.to_string()))
        })?;
        let dict = PyDict::new(py);
        dict.set_item("points", to_array(py, &route.points)?)?;
        dict.set_item("distance", route.distance)?;
        dict.set_item("duration", route.duration)?;
        dict.set_item("names", route.names)?;
        Ok(dict)
    }

    /// The plan of an instruction by the grammar, as JSON.
    fn plan(&self, py: Python<'_>, instruction: String, start: (f64, f64)) -> PyResult<String> {
        let start = point_of(start, "start")?;
        py.detach(|| {
            let times = RouterTimes {
                router: self.router()?,
                off_road_speed: OFF_ROAD_MPS,
            };
            let plan = GrammarPlanner::new().plan(&PlanRequest {
                instruction: &instruction,
                map: &self.map,
                start,
                times: &times,
            });
            let plan = plan.map_err(|error| PlanningError::new_err(with_causes(&error)))?;
            serde_json::to_string(&plan).map_err(|error| InputError::new_err(error.to_string()))
        })
    }
}

impl Map {
    fn router(&self) -> PyResult<&MapRouter> {
        let made = self.router.get_or_init(|| {
            MapRouter::new(&self.data, self.map.projection.clone(), Profile::delivery())
                .map_err(|error| with_causes(&error))
        });
        made.as_ref()
            .map_err(|error| InputError::new_err(error.clone()))
    }
}
