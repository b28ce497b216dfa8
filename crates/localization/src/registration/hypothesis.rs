//! Poses that may be the robot's, remembered along its way, and when one of them is accepted.

use openbench_core::Pose2;

use super::candidates::Candidate;
use super::estimate::Measured;

/// A pose this probable is accepted at once.
const SURE: f64 = 0.9999;
/// One that was this probable at two places is accepted,
const LIKELY: f64 = 0.99;
/// and one that was this probable at three.
const PROBABLE: f64 = 0.98;
/// A pose that becomes less probable than this is confirmed anew from there: something contradicts
/// it, or speaks for another one.
const DOUBTFUL: f64 = 0.9;
/// Places are so far apart on the way, metres: what is seen from nearer ones is nearly the same;
const APART_M: f64 = 10.0;
/// and so far where fewer than [`FEW_BUILDINGS`] are seen, metres.
const FEW_APART_M: f64 = 15.0;
/// Two equal buildings, wrong on the map, may fit better the other way round, and three of another
/// place may lie as those that are seen.
const FEW_BUILDINGS: usize = 4;
/// Of fewer buildings no number of places says which they are: one that looks like another does so
/// all along the way.
const LEAST_BUILDINGS: usize = 2;
/// A pose with less information along some direction is not accepted, 1/m²: in a street of parallel
/// facades it may be anywhere along it.
const LEAST_INFORMATION: f64 = 0.15;
/// Confirmations are remembered for so long on the way, metres.
const REMEMBERED_M: f64 = 100.0;
/// Poses no farther apart than this are one hypothesis, metres,
const SAME_M: f64 = 3.0;
/// and turned against each other no more, radians.
const SAME_RAD: f64 = 0.1;

/// A pose of the robot on the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Located {
    /// The pose in `map`.
    pub pose: Pose2,
    /// The candidate, in the coordinates of the locator's chart. In a hypothesis its probability
    /// is that of all candidates at the same place.
    pub candidate: Candidate,
}

impl Located {
    /// What was measured.
    pub fn measured(&self) -> Measured {
        Measured {
            pose: self.pose,
            information: self.candidate.refined.information,
        }
    }
}

/// Poses of different places, the most probable one first. The best pose of each place stands for
/// all of them, with the sum of their probabilities: refinements that end a metre or two apart say
/// where the robot is, and do not contradict each other.
pub fn distinct(candidates: &[Located]) -> Vec<Located> {
    let mut ordered: Vec<&Located> = candidates.iter().collect();
    let probability = |one: &Located| one.candidate.probability;
    ordered.sort_by(|a, b| probability(b).total_cmp(&probability(a)));
    let mut places: Vec<Located> = Vec::new();
    for one in ordered {
        match places
            .iter_mut()
            .find(|place| is_same(place.pose, one.pose))
        {
            Some(place) => place.candidate.probability += one.candidate.probability,
            None => places.push(one.clone()),
        }
    }
    places.sort_by(|a, b| probability(b).total_cmp(&probability(a)));
    places
}

/// When a pose is accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Acceptance {
    /// Never: hypotheses only.
    Never,
    /// If it is nearly certain at one place.
    AtOnePlace,
    /// If it is nearly certain at one place, or probable at several.
    #[default]
    AtSeveralPlaces,
}

/// A pose that may be the robot's, and where it was confirmed.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// The newest pose.
    pub located: Located,
    /// Pose of the robot in `odom` there.
    here: Pose2,
    /// How probable it was, and after how many metres; the newest one is the last.
    confirmations: Vec<Confirmation>,
}

#[derive(Debug, Clone, Copy)]
struct Confirmation {
    driven_m: f64,
    probability: f64,
}

impl Hypothesis {
    /// Of a pose that was found after so many metres, with what confirmed it before: those of the
    /// `earlier` hypotheses that it continues. `here` is the robot's pose in `odom`.
    pub fn found(located: Located, here: Pose2, driven_m: f64, earlier: &[Self]) -> Self {
        let confirmed = earlier
            .iter()
            .find(|one| is_same(one.expected(here), located.pose));
        let mut confirmations = confirmed.map_or(Vec::new(), |one| one.confirmations.clone());
        confirmations.retain(|one| driven_m - one.driven_m < REMEMBERED_M);
        if located.candidate.probability < DOUBTFUL {
            confirmations.clear();
        }
        confirmations.push(Confirmation {
            driven_m,
            probability: located.candidate.probability,
        });
        Self {
            located,
            here,
            confirmations,
        }
    }

    /// Whether it is accepted.
    pub fn is_accepted(&self, acceptance: Acceptance) -> bool {
        let is_sure = self.located.candidate.probability >= SURE;
        let is_known = self.located.candidate.refined.weakest() >= LEAST_INFORMATION;
        is_known
            && match acceptance {
                Acceptance::Never => false,
                Acceptance::AtOnePlace => is_sure,
                Acceptance::AtSeveralPlaces => is_sure || self.is_confirmed(),
            }
    }

    /// Where the robot should be by it, once it is at this pose in `odom`.
    fn expected(&self, here: Pose2) -> Pose2 {
        self.located.pose.compose(here.seen_from(self.here))
    }

    /// Whether it was confirmed often enough, at places that lie apart.
    fn is_confirmed(&self) -> bool {
        let candidate = &self.located.candidate;
        let at_places = |count: usize, probability: f64| {
            candidate.probability >= probability && self.places(probability) >= count
        };
        candidate.refined.buildings.len() >= LEAST_BUILDINGS
            && (at_places(2, LIKELY) || at_places(3, PROBABLE))
    }

    /// At how many places apart it was at least so probable.
    fn places(&self, probability: f64) -> usize {
        let buildings = self.located.candidate.refined.buildings.len();
        let apart = if buildings < FEW_BUILDINGS {
            FEW_APART_M
        } else {
            APART_M
        };
        let mut last = f64::NEG_INFINITY;
        let mut count = 0;
        for one in &self.confirmations {
            if one.probability >= probability && one.driven_m - last >= apart {
                last = one.driven_m;
                count += 1;
            }
        }
        count
    }
}

fn is_same(a: Pose2, b: Pose2) -> bool {
    a.is_near(b, SAME_M, SAME_RAD)
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::super::explain::Explained;
    use super::super::matching::BuildingEvidence;
    use super::super::nearness::Nearness;
    use super::super::probability::FEATURES;
    use super::super::refine::Refined;
    use super::*;

    /// A pose on the map by so many buildings, this probable, and known this well along the
    /// direction in which it is known least.
    fn located(pose: Pose2, buildings: usize, probability: f64, weakest: f64) -> Located {
        let refined = Refined {
            pose,
            information: Matrix3::from_diagonal(&[10.0, weakest, 100.0].into()),
            building_m: 0.5,
            buildings: (0..buildings).map(BuildingEvidence::of).collect(),
            closeness: 0.9,
            misfit: 1.0,
            matched: 90,
            facades: 100,
        };
        let candidate = Candidate {
            refined,
            nearness: Nearness::default(),
            explained: Explained::default(),
            cost: 0.0,
            prior: 0.0,
            features: [0.0; FEATURES],
            probability,
        };
        Located { pose, candidate }
    }

    /// A robot that drives along x finds the same pose, this probable, after each of these metres.
    fn confirmed(buildings: usize, probability: f64, places: &[f64]) -> Hypothesis {
        let found: Vec<_> = places.iter().map(|metres| (*metres, probability)).collect();
        found_at(buildings, &found)
    }

    /// The same with a probability after each of the metres.
    fn found_at(buildings: usize, found: &[(f64, f64)]) -> Hypothesis {
        let mut bank = Vec::new();
        for (metres, probability) in found {
            // `odom` begins at its own origin.
            let pose = Pose2::new(100.0 + metres, 7.0, 0.0);
            let here = Pose2::new(*metres, 0.0, 0.0);
            let located = located(pose, buildings, *probability, 5.0);
            bank = vec![Hypothesis::found(located, here, *metres, &bank)];
        }
        bank.remove(0)
    }

    fn is_accepted(hypothesis: &Hypothesis) -> bool {
        hypothesis.is_accepted(Acceptance::AtSeveralPlaces)
    }

    #[test]
    fn the_less_probable_a_pose_is_the_more_places_have_to_confirm_it() {
        assert!(is_accepted(&confirmed(5, 0.99995, &[0.0])));
        assert!(!is_accepted(&confirmed(5, 0.995, &[0.0])));
        assert!(is_accepted(&confirmed(5, 0.995, &[0.0, 10.0])));
        assert!(!is_accepted(&confirmed(5, 0.98, &[0.0, 10.0])));
        assert!(is_accepted(&confirmed(5, 0.98, &[0.0, 10.0, 20.0])));
        let often: Vec<f64> = (0..20).map(|i| 5.0 * f64::from(i)).collect();
        assert!(!is_accepted(&confirmed(5, 0.95, &often)));
    }

    #[test]
    fn places_lie_apart_and_farther_apart_where_few_buildings_are_seen() {
        assert!(!is_accepted(&confirmed(5, 0.995, &[0.0, 5.0])));
        assert!(!is_accepted(&confirmed(2, 0.995, &[0.0, 10.0])));
        assert!(is_accepted(&confirmed(2, 0.995, &[0.0, 15.0])));
    }

    #[test]
    fn places_do_not_tell_which_building_a_single_one_is() {
        assert!(!is_accepted(&confirmed(1, 0.995, &[0.0, 20.0, 40.0, 60.0])));
        assert!(is_accepted(&confirmed(1, 0.99995, &[0.0])));
    }

    #[test]
    fn poses_of_one_place_are_one_hypothesis_with_the_probabilities_of_all() {
        let at = |x: f64, probability: f64| located(Pose2::new(x, 0.0, 0.0), 5, probability, 5.0);
        let found = distinct(&[at(50.0, 0.4), at(0.0, 0.3), at(2.0, 0.25)]);
        let said: Vec<_> = found
            .iter()
            .map(|one| (one.pose.x, one.candidate.probability))
            .collect();
        assert_eq!(said, [(0.0, 0.55), (50.0, 0.4)]);
        let turned = located(Pose2::new(0.0, 0.0, 0.2), 5, 0.2, 5.0);
        assert_eq!(distinct(&[at(0.0, 0.3), turned]).len(), 2);
        assert!(distinct(&[]).is_empty());
    }

    #[test]
    fn a_pose_that_was_doubtful_meanwhile_is_confirmed_anew() {
        let with =
            |probability: f64| found_at(5, &[(0.0, 0.995), (5.0, probability), (10.0, 0.995)]);
        assert!(is_accepted(&with(0.95)));
        assert!(!is_accepted(&with(0.8)));
    }

    #[test]
    fn confirmations_of_long_ago_are_forgotten() {
        assert!(!is_accepted(&confirmed(5, 0.995, &[0.0, 100.0])));
    }

    #[test]
    fn a_pose_elsewhere_confirms_nothing() {
        let before = [confirmed(5, 0.995, &[0.0])];
        let here = Pose2::new(10.0, 0.0, 0.0);
        let after = |x: f64, yaw: f64| {
            let located = located(Pose2::new(x, 7.0, yaw), 5, 0.995, 5.0);
            is_accepted(&Hypothesis::found(located, here, 10.0, &before))
        };
        assert!(after(110.0, 0.0));
        assert!(!after(114.0, 0.0));
        assert!(!after(110.0, 0.2));
    }

    #[test]
    fn a_pose_that_may_be_anywhere_along_a_street_is_not_accepted() {
        let known = |weakest: f64| {
            let located = located(Pose2::default(), 5, 0.99999, weakest);
            is_accepted(&Hypothesis::found(located, Pose2::default(), 0.0, &[]))
        };
        assert!(known(0.2));
        assert!(!known(0.1));
    }

    #[test]
    fn some_judgements_need_one_place_or_accept_nothing() {
        let twice = confirmed(5, 0.995, &[0.0, 10.0]);
        assert!(!twice.is_accepted(Acceptance::AtOnePlace));
        let sure = confirmed(5, 0.99995, &[0.0]);
        assert!(sure.is_accepted(Acceptance::AtOnePlace));
        assert!(!sure.is_accepted(Acceptance::Never));
    }
}
