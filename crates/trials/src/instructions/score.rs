//! SRTP of a planner: the share of instructions with exactly the right plan, with 95 % Wilson
//! intervals, by language and difficulty.
//!
//! A plan is right by the definition of the benchmark's SRTP,
//! [`ExpectedPlan::is_met_by`](openbench_bench::score::metrics::ExpectedPlan::is_met_by). For an
//! ambiguous instruction it is right if it is one delivery with a question. For an instruction
//! without a map, the positions of the doors may be unknown to the plan.

use std::collections::BTreeMap;
use std::time::Instant;

use openbench_core::{Address, Georeference, LonLat, MapPoint, ModelUse, Plan, TravelTimes};
use openbench_language::{PlanRequest, Planner};
use openbench_osm::{OsmData, OsmMap};
use serde::Serialize;

use super::{Case, Difficulty, MapName};
use openbench_bench::score::statistics::{Proportion, rate_interval};

/// The SRTP of a group of instructions.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Share {
    /// Number of instructions.
    pub instructions: usize,
    /// Number of right plans.
    pub right: usize,
    /// Share of right plans; null without instructions.
    pub srtp: Option<f64>,
    /// 95 % Wilson interval of the share; null below five instructions.
    pub interval: Option<[f64; 2]>,
}

impl Share {
    fn add(&mut self, right: bool) {
        self.instructions += 1;
        self.right += usize::from(right);
        self.srtp = Some(self.right as f64 / self.instructions as f64);
        self.interval = rate_interval(Proportion {
            successes: self.right,
            trials: self.instructions,
        });
    }
}

/// An instruction with a wrong plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wrong {
    /// Name of the case.
    pub id: String,
    /// The instruction.
    pub instruction: String,
    /// The requested doors; empty for an ambiguous instruction.
    pub expected: Vec<Address>,
    /// The planned doors.
    pub planned: Vec<Address>,
    /// The planner's error or question, if any.
    pub said: Option<String>,
}

/// The scores of a planner.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// Name of the planner.
    pub planner: String,
    /// Score over all instructions: plans that the planner made alone.
    pub all: Share,
    /// The same with plans that were partly made by another planner.
    pub with_fallback: Share,
    /// Scores by language.
    pub languages: BTreeMap<String, Share>,
    /// Scores by difficulty.
    pub difficulties: BTreeMap<Difficulty, Share>,
    /// Mean wall-clock time of a plan, milliseconds, waiting for models included.
    pub mean_ms: f64,
    /// Maximum wall-clock time of a plan, milliseconds.
    pub max_ms: f64,
    /// Number of plans that were partly made by another planner.
    pub fallbacks: usize,
    /// Use of models, where it was counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub models: Option<ModelUse>,
    /// The instructions with a wrong plan.
    pub wrong: Vec<Wrong>,
}

/// Lets a planner plan all instructions and scores the plans.
///
/// `map` is used for cases without a map of their own; `done` is called after each case.
///
/// ```
/// use openbench_language::GrammarPlanner;
/// use openbench_trials::instructions::{Split, built_in, score::score};
///
/// let cases: Vec<_> = built_in(Split::Development)
///     .into_iter()
///     .filter(|case| case.id.starts_with("en-made"))
///     .collect();
/// let scores = score(&GrammarPlanner::new(), &cases, None, || {});
/// assert_eq!(scores.all.instructions, cases.len());
/// assert!(scores.all.srtp > Some(0.9));
/// ```
pub fn score(
    planner: &dyn Planner,
    cases: &[Case],
    map: Option<&OsmMap>,
    mut done: impl FnMut(),
) -> Scores {
    // A case without any map is planned on an empty one.
    let nowhere = OsmMap::new(
        &OsmData::default(),
        Georeference::tangent_plane(LonLat::default()),
    );
    let mut built_in: BTreeMap<MapName, OsmMap> = BTreeMap::new();
    for name in cases.iter().filter_map(|case| case.map) {
        built_in.entry(name).or_insert_with(|| name.open());
    }
    let mut scores = Scores {
        planner: planner.name().to_owned(),
        all: Share::default(),
        with_fallback: Share::default(),
        languages: BTreeMap::new(),
        difficulties: BTreeMap::new(),
        mean_ms: 0.0,
        max_ms: 0.0,
        fallbacks: 0,
        models: None,
        wrong: Vec::new(),
    };
    let mut total = 0.0;
    // One after the other: parallel plans would disturb each other's times.
    for case in cases {
        let known = case.map.map(|name| &built_in[&name]).or(map);
        let request = PlanRequest {
            instruction: &case.instruction,
            map: known.unwrap_or(&nowhere),
            start: MapPoint::default(),
            times: &StraightLineTimes,
        };
        let began = Instant::now();
        let planned = planner.plan(&request);
        let took = began.elapsed().as_secs_f64() * 1e3;
        total += took;
        scores.max_ms = scores.max_ms.max(took);
        let said = planned.as_ref().err().map(ToString::to_string);
        let plan = planned.unwrap_or_else(|_| Plan {
            planner: String::new(),
            deliveries: Vec::new(),
            fallbacks: Vec::new(),
        });
        scores.fallbacks += usize::from(!plan.fallbacks.is_empty());
        scores.add(case, &plan, said, known);
        done();
    }
    scores.mean_ms = total / cases.len().max(1) as f64;
    scores
}

impl Scores {
    fn add(&mut self, case: &Case, plan: &Plan, said: Option<String>, map: Option<&OsmMap>) {
        let right_with_fallback = is_right(case, plan, map);
        self.with_fallback.add(right_with_fallback);
        let right = right_with_fallback && plan.fallbacks.is_empty();
        self.all.add(right);
        if !case.lang.is_empty() {
            self.languages
                .entry(case.lang.clone())
                .or_default()
                .add(right);
        }
        if let Some(difficulty) = case.difficulty {
            self.difficulties.entry(difficulty).or_default().add(right);
        }
        if !right {
            let problem = || plan.deliveries.iter().find_map(|d| d.problem.clone());
            self.wrong.push(Wrong {
                id: case.id.clone(),
                instruction: case.instruction.clone(),
                expected: case.deliveries.clone(),
                planned: plan.deliveries.iter().map(|d| d.address()).collect(),
                said: said.or_else(problem),
            });
        }
    }
}

/// Whether a plan is right, see the [module](self).
fn is_right(case: &Case, plan: &Plan, map: Option<&OsmMap>) -> bool {
    if case.ambiguous {
        return matches!(&plan.deliveries[..], [one] if one.problem.is_some());
    }
    case.expected().is_met_by(plan, map)
}

/// Travel times along straight lines at 0.5 m/s. They only affect orders that the instruction
/// leaves open, which are all admissible.
struct StraightLineTimes;

impl TravelTimes for StraightLineTimes {
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
        places
            .iter()
            .flat_map(|a| places.iter().map(|b| 2.0 * a.distance(*b)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::PlannedDelivery;
    use openbench_language::{GrammarPlanner, PlanError};

    /// A planner that always plans the same doors, with the same question.
    struct Always(Vec<Address>, Option<String>);

    impl Planner for Always {
        fn name(&self) -> &str {
            "always"
        }

        fn plan(&self, _: &PlanRequest<'_>) -> Result<Plan, PlanError> {
            let delivery = |address: &Address| PlannedDelivery {
                instruction_index: 0,
                item: String::new(),
                building: address.building.clone(),
                unit: address.unit.clone(),
                levels: Vec::new(),
                steps: Vec::new(),
                confidence: 1.0,
                problem: self.1.clone(),
                deadline: None,
            };
            Ok(Plan {
                planner: "always".into(),
                deliveries: self.0.iter().map(delivery).collect(),
                fallbacks: Vec::new(),
            })
        }
    }

    fn case(deliveries: &[Address], before: &[(usize, usize)]) -> Case {
        Case {
            id: "a".into(),
            lang: "en".into(),
            difficulty: Some(Difficulty::Easy),
            map: Some(MapName::Estate),
            instruction: "?".into(),
            deliveries: deliveries.to_vec(),
            before: before.to_vec(),
            ambiguous: deliveries.is_empty(),
        }
    }

    fn right(doors: &[Address], problem: Option<&str>, case: &Case) -> bool {
        let planner = Always(doors.to_vec(), problem.map(str::to_owned));
        score(&planner, std::slice::from_ref(case), None, || {})
            .all
            .right
            == 1
    }

    #[test]
    fn doors_order_and_questions_are_scored() {
        let (a, b) = (
            Address::new("building1", "unit1"),
            Address::new("building2", "unit1"),
        );
        let both = [a.clone(), b.clone()];
        assert!(right(&[b.clone(), a.clone()], None, &case(&both, &[])));
        assert!(!right(
            &[b.clone(), a.clone()],
            None,
            &case(&both, &[(0, 1)])
        ));
        assert!(!right(&both, Some("which?"), &case(&both, &[])));
        assert!(!right(&both[..1], None, &case(&both, &[])));
        let unclear = case(&[], &[]);
        assert!(right(&both[..1], Some("which?"), &unclear) && !right(&both[..1], None, &unclear));
        let anywhere = Case {
            map: None,
            ..case(&both[..1], &[])
        };
        assert!(right(&both[..1], Some("the map lacks it"), &anywhere));
    }

    #[test]
    fn the_grammar_is_scored_by_language_and_difficulty() {
        let cases = super::super::built_in(super::super::Split::Development);
        let mut count = 0;
        let scores = score(&GrammarPlanner::new(), &cases, None, || count += 1);
        assert_eq!((scores.all.instructions, count), (cases.len(), cases.len()));
        assert_eq!(scores.languages.len(), 6);
        assert_eq!(
            scores
                .difficulties
                .values()
                .map(|s| s.instructions)
                .sum::<usize>(),
            cases.len()
        );
        assert_eq!(scores.wrong.len(), cases.len() - scores.all.right);
    }

    #[test]
    fn the_grammar_keeps_its_srtp() {
        use super::super::Split::{Development, Test, Unseen};
        for (split, least) in [(Development, 0.94), (Test, 0.97), (Unseen, 0.85)] {
            let scores = score(
                &GrammarPlanner::new(),
                &super::super::built_in(split),
                None,
                || {},
            );
            assert!(
                scores.all.srtp >= Some(least),
                "{split:?}: {:?}",
                scores.all
            );
        }
    }
}
