//! The figures of a traffic plan in a scene.

use openbench_scene::Scene;

use super::figures::{PEOPLE, person};
use super::gait::{PHASES, phase_of};
use super::mover::{Mover, MoverKind};
use super::plan::TrafficPlan;

/// Number of different cars in a world; greater numbers repeat them.
const CARS: u32 = 15;

/// The figures of a traffic plan in a scene.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gallery {
    plan: TrafficPlan,
    /// For each person, a figure for each phase of the gait.
    people: Vec<[usize; PHASES]>,
    cars: Vec<usize>,
}

impl Gallery {
    /// Adds to a scene as many figures as a plan needs.
    pub(crate) fn add(scene: &mut Scene, plan: TrafficPlan) -> Self {
        let mut phases = |look| std::array::from_fn(|phase| scene.add_figure(&person(look, phase)));
        let people = looks(plan.pedestrians, PEOPLE).map(&mut phases).collect();
        let cars = looks(plan.cars, CARS).map(|look| scene.add_figure(&car_figure(look)));
        let cars = cars.collect();
        Self { plan, people, cars }
    }

    /// Whether there are figures for all movers of a plan.
    pub(crate) fn suffices(&self, plan: TrafficPlan) -> bool {
        plan.pedestrians <= self.plan.pedestrians && plan.cars <= self.plan.cars
    }

    /// Number of a mover's figure in the scene.
    pub(crate) fn figure(&self, mover: &Mover) -> usize {
        let look = self.look(mover) as usize;
        match mover.kind {
            MoverKind::Pedestrian => self.people[look][phase_of(mover.gait)],
            MoverKind::Car => self.cars[look],
        }
    }

    /// Which of this gallery's people or cars a mover looks like.
    pub(crate) fn look(&self, mover: &Mover) -> u32 {
        let looks = match mover.kind {
            MoverKind::Pedestrian => self.people.len(),
            MoverKind::Car => self.cars.len(),
        };
        // Not zero: a stage without figures of a kind admits none of its movers (`suffices`).
        mover.look % looks as u32
    }
}

/// Numbers of the looks that so many movers need, out of `looks` different ones.
fn looks(wanted: usize, looks: u32) -> std::ops::Range<u32> {
    0..looks.min(u32::try_from(wanted).unwrap_or(looks))
}

/// A car; `look` selects shape and paint. Its solid part is body and tyres, as drawn.
pub(crate) fn car_figure(look: u32) -> Scene {
    openbench_scene::generate::car_figure(look)
}

#[cfg(test)]
mod tests {
    use openbench_scene::SemanticClass;
    use openbench_scene::bvh::Bounds3;

    use super::super::figures::bounds;
    use super::super::hull::{CAR_HALF_LENGTH_M, CAR_HALF_WIDTH_M};
    use super::*;

    #[test]
    fn cars_are_as_large_as_the_hull_that_others_avoid() {
        let (half_length, half_width) = (CAR_HALF_LENGTH_M as f32, CAR_HALF_WIDTH_M as f32);
        for look in 0..10 {
            let figure = car_figure(look);
            let Bounds3 {
                min: low,
                max: high,
            } = bounds(&figure);
            let long = high[0] <= half_length + 0.01 && low[0] >= -half_length - 0.01;
            let wide = high[1] <= half_width + 0.03;
            let tall = high[2] < 2.0 && low[2].abs() < 0.02;
            assert!(long && wide && tall, "{low:?} {high:?}");
            assert!(
                figure
                    .materials
                    .iter()
                    .all(|m| m.class == SemanticClass::Vehicle)
            );
        }
    }

    #[test]
    fn as_many_looks_as_movers_are_needed_up_to_all() {
        assert_eq!((looks(3, PEOPLE), looks(1_000, PEOPLE)), (0..3, 0..PEOPLE));
    }
}
