//! How far places are from each other.

use super::failure::Failure;
use super::json::Json;
use super::request::TableRequest;
use super::service::{Service, ServiceMemory};
use crate::geo::distance;
use crate::leg::{Leg, Measures};
use crate::metric::UNITS;
use crate::position::Position;

impl Service {
    /// Answers *table*.
    pub fn table(
        &self,
        request: &TableRequest,
        memory: &mut ServiceMemory,
    ) -> Result<Vec<u8>, Failure> {
        let positions = self.positions(&request.places, &mut memory.nearest)?;
        let all: Vec<usize> = (0..positions.len()).collect();
        let chosen = |indices: &Vec<usize>| {
            if indices.is_empty() {
                all.clone()
            } else {
                indices.clone()
            }
        };
        let [sources, targets] = [&request.sources, &request.destinations].map(chosen);
        let of = |indices: &[usize]| {
            indices
                .iter()
                .map(|i| positions[*i].as_slice())
                .collect::<Vec<_>>()
        };
        let (from, to) = (of(&sources), of(&targets));
        let measures = self.measured(&from, &to, request, [&sources, &targets], memory);
        let mut json = Json::default();
        json.object(|json| {
            json.key("code").string("Ok");
            if request.duration {
                rows(json.key("durations"), &measures.durations, to.len(), 1);
            }
            if request.distance {
                rows(json.key("distances"), &measures.lengths, to.len(), 1);
            }
            if request.fallback_speed.is_some() {
                json.key("fallback_speed_cells").array(|json| {
                    for (row, column) in measures.filled {
                        json.array(|json| {
                            json.whole(row as i64);
                            json.whole(column as i64);
                        });
                    }
                });
            }
            for (key, indices) in [("sources", &sources), ("destinations", &targets)] {
                if !request.places.skip_waypoints {
                    json.key(key).array(|json| {
                        for i in indices {
                            self.waypoint(json, &positions[*i][0], request.places.hints, |_| {});
                        }
                    });
                }
            }
        });
        Ok(json.into_bytes())
    }

    fn measured(
        &self,
        from: &[&[Position]],
        to: &[&[Position]],
        request: &TableRequest,
        asked: [&[usize]; 2],
        memory: &mut ServiceMemory,
    ) -> Measured {
        let ServiceMemory { legs, tables, .. } = memory;
        let table = Leg::table(
            &self.roads,
            &self.metric,
            from,
            to,
            request.distance,
            legs,
            tables,
        );
        let seconds = |measures: &Measures| f64::from(measures.duration) / UNITS;
        let mut measured = Measured {
            lengths: table
                .iter()
                .map(|cell| cell.map_or(f64::NAN, |measures| measures.length))
                .collect(),
            durations: table
                .iter()
                .map(|cell| cell.as_ref().map_or(f64::NAN, seconds))
                .collect(),
            filled: Vec::new(),
        };
        for (i, duration) in measured.durations.iter_mut().enumerate() {
            let (row, column) = (i / to.len(), i % to.len());
            if let (true, Some(speed)) = (duration.is_nan(), request.fallback_speed) {
                let [a, b] = if request.fallback_snapped {
                    [from[row][0].place, to[column][0].place]
                } else {
                    [asked[0][row], asked[1][column]].map(|i| request.places.places[i])
                };
                let metres = distance(a, b);
                (*duration, measured.lengths[i]) = (metres / speed, metres);
                measured.filled.push((row, column));
            }
            *duration *= request.scale;
        }
        measured
    }
}

/// Metres and seconds, not numbers where there is no way, and which of them are filled in.
#[derive(Debug)]
struct Measured {
    lengths: Vec<f64>,
    durations: Vec<f64>,
    filled: Vec<(usize, usize)>,
}

fn rows(json: &mut Json, values: &[f64], width: usize, places: u32) {
    json.array(|json| {
        for row in values.chunks(width.max(1)) {
            json.array(|json| {
                for value in row {
                    if value.is_nan() {
                        json.null()
                    } else {
                        json.decimal(*value, places)
                    }
                }
            });
        }
    });
}
