//! How far places are from each other.

use super::failure::Failure;
use super::json::Json;
use super::request::TableRequest;
use super::service::{Service, ServiceMemory};
use crate::geo::distance;
use crate::leg::Leg;
use crate::metric::UNITS;
use crate::overlay::FAR;
use crate::position::Position;

impl Service {
    /// Answers *table*.
    pub fn table(&self, request: &TableRequest, memory: &mut ServiceMemory) -> Result<Vec<u8>, Failure> {
        let positions = self.positions(&request.places, &mut memory.nearest)?;
        let all: Vec<usize> = (0..positions.len()).collect();
        let chosen = |indices: &Vec<usize>| if indices.is_empty() { all.clone() } else { indices.clone() };
        let [sources, targets] = [&request.sources, &request.destinations].map(chosen);
        let of = |indices: &[usize]| indices.iter().map(|i| positions[*i].as_slice()).collect::<Vec<_>>();
        let (from, to) = (of(&sources), of(&targets));
        let measures = self.measured(&from, &to, request, memory);
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
        memory: &mut ServiceMemory,
    ) -> Measured {
        let mut measured = Measured::default();
        if request.distance || !self.metric.weight_is_duration() {
            self.measure_each(from, to, memory, &mut measured);
        } else {
            let weights =
                Leg::weights(&self.roads, &self.metric, from, to, &mut memory.legs, &mut memory.tables);
            let seconds = |weight: u32| if weight < FAR { f64::from(weight) / UNITS } else { f64::NAN };
            measured.durations = weights.into_iter().map(seconds).collect();
            measured.lengths = vec![f64::NAN; measured.durations.len()];
        }
        for (i, duration) in measured.durations.iter_mut().enumerate() {
            let (row, column) = (i / to.len(), i % to.len());
            if let (true, Some(speed)) = (duration.is_nan(), request.fallback_speed) {
                let metres = distance(from[row][0].place, to[column][0].place);
                (*duration, measured.lengths[i]) = (metres / speed, metres);
                measured.filled.push((row, column));
            }
            *duration *= request.scale;
        }
        measured
    }

    /// One way after another.
    fn measure_each(
        &self,
        from: &[&[Position]],
        to: &[&[Position]],
        memory: &mut ServiceMemory,
        measured: &mut Measured,
    ) {
        for a in from {
            for b in to {
                let leg = Leg::find(&self.roads, &self.metric, a, b, &mut memory.legs);
                let measures = leg.map(|leg| leg.length_and_duration(&self.roads, &self.metric));
                let (length, duration) =
                    measures.map_or((f64::NAN, f64::NAN), |(l, d)| (l, f64::from(d) / UNITS));
                measured.lengths.push(length);
                measured.durations.push(duration);
            }
        }
    }
}

/// Metres and seconds, not numbers where there is no way, and which of them are filled in.
#[derive(Debug, Default)]
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
                    if value.is_nan() { json.null() } else { json.decimal(*value, places) }
                }
            });
        }
    });
}
