//! A picture of the vote: how well each place fits, with its best heading.

use openbench_core::{MapPoint, PlaceScores, Pose2};
use openbench_geometry::Bounds;
use openbench_geometry::grid::GridGeometry;

use super::chart::Chart;
use super::field::{CELL_M, Field, UNITS_PER_NAT};
use super::prior::Prior;

/// Most cells along each side: a picture needs no more.
const MOST_CELLS: usize = 40;
/// Headings for which the prior is asked at each cell, about: a picture needs no more.
const HEADINGS: usize = 12;
/// Score of the best place.
const BEST: f64 = 100.0;

/// Costs of the places of an area.
#[derive(Debug, Clone, PartialEq)]
pub struct Landscape {
    /// In the chart's coordinates.
    grid: GridGeometry,
    /// The least cost in each cell, nats, without the prior; infinite where no robot stands.
    nats: Vec<f64>,
}

impl Landscape {
    /// Of an area about which nothing was asked yet.
    pub fn over(area: Bounds) -> Self {
        let longest = (area.high.x - area.low.x).max(area.high.y - area.low.y);
        let cell = (longest / MOST_CELLS as f64).max(CELL_M);
        let grid = GridGeometry::covering(area.low, area.high, cell, MOST_CELLS);
        Self {
            nats: vec![f64::INFINITY; grid.len()],
            grid,
        }
    }

    /// Takes in what the places of a field cost, as [`Voted::least`](super::modes::Voted::least).
    pub fn take(&mut self, field: &Field, least: &[u16]) {
        for (row, costs) in least.chunks(field.columns).enumerate() {
            for (column, cost) in costs.iter().enumerate() {
                let cell = self.grid.cell_at(field.place(column, row));
                let Some(cell) = cell.filter(|_| *cost < u16::MAX) else {
                    continue;
                };
                self.nats[cell] = self.nats[cell].min(f64::from(*cost) / UNITS_PER_NAT);
            }
        }
    }

    /// The scores of all places, with what the prior says about the middles of cells; `None` if the
    /// robot can be nowhere.
    pub fn scores(&self, chart: &Chart, prior: &Prior) -> Option<PlaceScores> {
        let headings = prior.headings();
        let beforehand = |at: MapPoint| {
            let some = (0..headings.count).step_by((headings.count / HEADINGS).max(1));
            let yaws = some.map(|i| headings.first + i as f64 * headings.step);
            let costs = yaws.map(|yaw| prior.cost(Pose2::new(at.x, at.y, yaw)));
            costs.fold(f64::INFINITY, f64::min)
        };
        let (x, y) = (chart.origin.x, chart.origin.y);
        let costs = self.nats.iter().enumerate().map(|(cell, nats)| {
            let at = self.grid.center(cell);
            nats + beforehand(MapPoint::new(at.x + x, at.y + y))
        });
        let costs: Vec<f64> = costs.collect();
        let possible = || costs.iter().copied().filter(|cost| cost.is_finite());
        let best = possible().reduce(f64::min)?;
        let worst = possible().fold(best, f64::max);
        let score = |cost: &f64| {
            if !cost.is_finite() {
                return -1;
            }
            // All places are the best if all fit equally well.
            let worse = (cost - best) / (worst - best).max(f64::MIN_POSITIVE);
            (BEST * (1.0 - worse)).round() as i8
        };
        Some(PlaceScores {
            origin: MapPoint::new(self.grid.origin.x + x, self.grid.origin.y + y),
            cell_m: self.grid.cell,
            width: self.grid.width,
            cells: costs.iter().map(score).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::Start;

    use super::super::modes::modes;
    use super::super::submap::Submap;
    use super::super::town::{chart, stretch_at, town};
    use super::super::vote::Evidence;
    use super::*;

    fn square(middle: MapPoint, half: f64) -> Bounds {
        Bounds::of_point(middle).grown(half)
    }

    /// The scores of a robot that sees the town from a pose.
    fn scores(seen_from: Pose2, prior: &Prior, area: Bounds) -> Option<PlaceScores> {
        let mut chart = chart(&town());
        chart.origin = MapPoint::new(3000.0, -500.0);
        let field = Field::over(&chart, area);
        let evidence = Evidence::of(&Submap::of(&[stretch_at(&town(), seen_from)]));
        let voted = modes(&field, &evidence, &prior.headings(), &|_| 0.0, 1);
        let mut landscape = Landscape::over(area);
        landscape.take(&field, &voted.least);
        landscape.scores(&chart, prior)
    }

    #[test]
    fn the_best_place_is_where_the_robot_is() {
        let truth = Pose2::new(12.0, 3.0, 0.4);
        let anywhere = Prior::new(&Start::Anywhere).unwrap();
        let scores = scores(truth, &anywhere, square(MapPoint::default(), 50.0)).unwrap();
        assert_eq!(
            (scores.cell_m, scores.width, scores.cells.len()),
            (2.5, 40, 1600)
        );
        let best = scores.cells.iter().position(|score| *score == 100).unwrap();
        let (column, row) = (best % scores.width, best / scores.width);
        let at = |index: usize, origin: f64| origin + (index as f64 + 0.5) * scores.cell_m;
        let (x, y) = (at(column, scores.origin.x), at(row, scores.origin.y));
        assert!(
            (x - 3012.0).abs() < 2.6 && (y + 497.0).abs() < 2.6,
            "{x}, {y}"
        );
        assert!(scores.cells.contains(&0));
        // No robot stands in the middle of a house.
        assert!(scores.cells.contains(&-1));
    }

    #[test]
    fn what_the_prior_excludes_has_no_score() {
        let centre = MapPoint::new(3000.0, -500.0);
        let near = Start::Area {
            centre,
            radius_m: 4.0,
        };
        let prior = Prior::new(&near).unwrap();
        let area = square(MapPoint::default(), 20.0);
        let found = scores(Pose2::new(1.0, 1.0, 0.0), &prior, area).unwrap();
        assert_eq!(found.cells[0], -1);
        assert!(found.cells.contains(&100));
        let elsewhere = Start::Area {
            centre: MapPoint::default(),
            radius_m: 4.0,
        };
        let prior = Prior::new(&elsewhere).unwrap();
        assert_eq!(scores(Pose2::default(), &prior, area), None);
    }
}
