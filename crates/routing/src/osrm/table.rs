//! The service *table*: durations and distances between many places.

use super::failure::Failure;
use super::json::Json;
use super::request::TableRequest;
use super::service::{Service, ServiceMemory};
use crate::costs::UNITS_PER_SECOND;
use crate::geo::distance;
use crate::leg::{Leg, Measures};
use crate::position::Position;

impl Service {
    /// Answers *table*.
    ///
    /// # Errors
    /// If a place is far from all roads.
    pub fn table(
        &self,
        request: &TableRequest,
        memory: &mut ServiceMemory,
    ) -> Result<Vec<u8>, Failure> {
        let positions = self.positions(&request.places, &mut memory.nearest)?;
        let sources = chosen(&request.sources, positions.len());
        let targets = chosen(&request.destinations, positions.len());
        let table = self.measured(request, &positions, &sources, &targets, memory);
        let mut json = Json::default();
        json.object(|json| {
            json.key("code").string("Ok");
            if request.duration {
                rows(json.key("durations"), &table.durations, targets.len());
            }
            if request.distance {
                rows(json.key("distances"), &table.lengths, targets.len());
            }
            if request.fallback_speed.is_some() {
                json.key("fallback_speed_cells").array(|json| {
                    for cell in table.filled {
                        json.array(|json| {
                            json.whole(cell.row as i64);
                            json.whole(cell.column as i64);
                        });
                    }
                });
            }
            for (key, indices) in [("sources", &sources), ("destinations", &targets)] {
                if !request.places.skip_waypoints {
                    json.key(key).array(|json| {
                        for i in indices {
                            // All positions of a place are the same place on different edges, so
                            // the first stands for it.
                            self.waypoint(json, &positions[*i][0], request.places.hints, |_| {});
                        }
                    });
                }
            }
        });
        Ok(json.into_bytes())
    }

    /// The table between those positions that are its sources and targets, by their indices.
    fn measured(
        &self,
        request: &TableRequest,
        positions: &[Vec<Position>],
        sources: &[usize],
        targets: &[usize],
        memory: &mut ServiceMemory,
    ) -> Measured {
        let from: Vec<&[Position]> = sources.iter().map(|i| positions[*i].as_slice()).collect();
        let to: Vec<&[Position]> = targets.iter().map(|i| positions[*i].as_slice()).collect();
        let ServiceMemory { legs, tables, .. } = memory;
        let (roads, metric, lengths) = (&self.roads, &self.metric, request.distance);
        let cells = Leg::table(roads, metric, &from, &to, lengths, legs, tables);
        let mut measured = Measured::new(&cells);
        for (i, duration) in measured.durations.iter_mut().enumerate() {
            let cell = Cell {
                row: i / targets.len(),
                column: i % targets.len(),
            };
            if let (true, Some(speed)) = (duration.is_nan(), request.fallback_speed) {
                let ends = [sources[cell.row], targets[cell.column]];
                let metres = straight_line(request, positions, ends);
                (*duration, measured.lengths[i]) = (metres / speed, metres);
                measured.filled.push(cell);
            }
            // Estimates are scaled too. NaN stays NaN, which `rows` writes as `null`.
            *duration *= request.scale;
        }
        measured
    }
}

/// All indices below `count` if none are named.
fn chosen(indices: &[usize], count: usize) -> Vec<usize> {
    if indices.is_empty() {
        (0..count).collect()
    } else {
        indices.to_vec()
    }
}

/// Metres between two places of a request, or between those on the network that stand for them.
fn straight_line(request: &TableRequest, positions: &[Vec<Position>], ends: [usize; 2]) -> f64 {
    let [a, b] = if request.fallback_snapped {
        ends.map(|i| positions[i][0].place)
    } else {
        ends.map(|i| request.places.coordinates[i])
    };
    distance(a, b)
}

/// A cell of a table.
#[derive(Debug, Clone, Copy)]
struct Cell {
    row: usize,
    column: usize,
}

/// Metres and seconds, NaN where there is no route, and the cells that were filled in instead.
#[derive(Debug)]
struct Measured {
    lengths: Vec<f64>,
    durations: Vec<f64>,
    filled: Vec<Cell>,
}

impl Measured {
    fn new(cells: &[Option<Measures>]) -> Self {
        let length = |measures: Measures| measures.length;
        let seconds = |measures: Measures| f64::from(measures.duration) / UNITS_PER_SECOND;
        Self {
            lengths: cells
                .iter()
                .map(|cell| cell.map_or(f64::NAN, length))
                .collect(),
            durations: cells
                .iter()
                .map(|cell| cell.map_or(f64::NAN, seconds))
                .collect(),
            filled: Vec::new(),
        }
    }
}

/// An array of rows of so many values, with one decimal place.
fn rows(json: &mut Json, values: &[f64], width: usize) {
    json.array(|json| {
        for row in values.chunks(width.max(1)) {
            json.array(|json| {
                for value in row {
                    if value.is_nan() {
                        json.null()
                    } else {
                        json.decimal(*value, 1)
                    }
                }
            });
        }
    });
}
