//! The doors of an episode, as the judge knows them.

use openbench_core::{Action, Address, FailureCause, GiveUp, MapPoint};

use crate::run::truth::Truth;

/// A door that gets a parcel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stop {
    /// Address as in the instruction.
    pub address: Address,
    /// Where a robot stands in front of the door; `None` if no place there can be reached, or the
    /// world has no such door.
    pub approach: Option<MapPoint>,
    /// Indices of the stops that come before this one.
    after: Vec<usize>,
}

/// The doors that are left.
#[derive(Debug, Clone)]
pub(super) struct Errands {
    stops: Vec<Stop>,
    is_done: Vec<bool>,
}

impl Errands {
    /// All doors of an episode.
    pub(super) fn of(truth: &Truth<'_>) -> Self {
        let episode = &truth.prepared.episodes[truth.episode];
        let before = |stop: usize| {
            let pairs = episode.before.iter();
            pairs.filter(move |(_, later)| *later == stop)
        };
        let stops = episode
            .targets
            .iter()
            .enumerate()
            .map(|(number, target)| Stop {
                address: target.address.clone(),
                approach: target.door.and_then(|door| truth.prepared.approach[door]),
                after: before(number).map(|(earlier, _)| *earlier).collect(),
            });
        Self::new(stops.collect())
    }

    fn new(stops: Vec<Stop>) -> Self {
        Self {
            is_done: vec![false; stops.len()],
            stops,
        }
    }

    /// All addresses.
    pub(super) fn addresses(&self) -> Vec<Address> {
        self.stops.iter().map(|stop| stop.address.clone()).collect()
    }

    /// Takes the next stop: the one nearest to `from` among those whose turn it may be; `None` if
    /// none is left.
    pub(super) fn take_nearest(&mut self, from: MapPoint) -> Option<Stop> {
        let open = (0..self.stops.len()).filter(|stop| self.may_be_next(*stop));
        let distance = |stop: &usize| {
            let approach = self.stops[*stop].approach;
            approach.map_or(f64::INFINITY, |at| at.distance(from))
        };
        let next = open.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        self.is_done[next] = true;
        Some(self.stops[next].clone())
    }

    fn may_be_next(&self, stop: usize) -> bool {
        !self.is_done[stop] && self.stops[stop].after.iter().all(|s| self.is_done[*s])
    }
}

/// Gives up one delivery, or all that are left.
pub(super) fn give_up(address: Option<Address>, cause: FailureCause, detail: &str) -> Action {
    Action::GiveUp(GiveUp {
        address,
        cause,
        detail: detail.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stop(unit: &str, x: f64, after: &[usize]) -> Stop {
        Stop {
            address: Address {
                building: "building1".into(),
                unit: Some(unit.to_owned()),
            },
            approach: x.is_finite().then(|| MapPoint::new(x, 0.0)),
            after: after.to_vec(),
        }
    }

    #[test]
    fn the_nearest_door_is_next_unless_another_one_comes_before_it() {
        let far_first = [stop("a", 50.0, &[]), stop("b", 10.0, &[0])];
        let unreachable = stop("c", f64::NAN, &[]);
        let mut errands = Errands::new([&far_first[..], &[unreachable]].concat());
        let mut taken = Vec::new();
        let mut at = MapPoint::default();
        while let Some(next) = errands.take_nearest(at) {
            at = next.approach.unwrap_or(at);
            taken.push(next.address.unit.unwrap());
        }
        assert_eq!(taken, ["a", "b", "c"]);
    }
}
