//! SRTP, success rate of task planning: the share of instructions with exactly the right list of
//! doors, in an admissible order.

use openbench_core::{Address, Plan};
use openbench_osm::{Location, OsmMap, locate};

use crate::score::statistics::Proportion;

/// What the paper reports: a model, and its SRTP over 60 runs.
pub const PAPER_SRTP: [(&str, f64); 6] = [
    ("Gemini-1.5-pro", 0.27),
    ("Qwen-turbo", 0.5),
    ("WenXinYiYan", 0.6),
    ("GPT-3.5-turbo", 0.9),
    ("Claude-3.5", 0.97),
    ("GPT-4o-mini", 1.0),
];

/// Instructions that were understood, among all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Understood {
    /// By the planner that was asked.
    pub by_planner: Proportion,
    /// By that planner or by another one that had to make a part of the plan.
    pub with_fallbacks: Proportion,
}

/// The correct plan of an instruction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExpectedPlan {
    /// The requested doors, each once.
    pub doors: Vec<Address>,
    /// Pairs of indices into `doors`: the first must be visited before the second. Without pairs
    /// every order is admissible.
    pub before: Vec<(usize, usize)>,
}

impl ExpectedPlan {
    /// Whether a plan is right: it has exactly the requested doors, each once, in an admissible
    /// order, and asks nothing about a building that the map has. It may report that the map lacks
    /// one.
    pub fn is_met_by(&self, plan: &Plan, map: Option<&OsmMap>) -> bool {
        let planned: Vec<Address> = plan.deliveries.iter().map(|d| d.address()).collect();
        let questions = plan.deliveries.iter().filter(|d| d.problem.is_some());
        let mut asked = questions.map(|delivery| &delivery.building);
        self.has_doors(&planned) && !asked.any(|building| has_building(map, building))
    }

    /// Whether `planned` has exactly the requested doors, each once, in an admissible order.
    ///
    /// ```
    /// use openbench_bench::score::metrics::ExpectedPlan;
    /// use openbench_core::Address;
    ///
    /// // "First to unit 2 of building 3, then to unit 1 of building 5."
    /// let first = Address::new("building3", "unit2");
    /// let second = Address::new("building5", "unit1");
    /// let expected = ExpectedPlan {
    ///     doors: vec![first.clone(), second.clone()],
    ///     before: vec![(0, 1)],
    /// };
    /// assert!(expected.has_doors(&[first.clone(), second.clone()]));
    /// assert!(!expected.has_doors(&[second, first.clone()]));
    /// assert!(!expected.has_doors(&[first]));
    /// ```
    pub fn has_doors(&self, planned: &[Address]) -> bool {
        let place = |door: &Address| planned.iter().position(|p| p.same_door(door));
        let places: Option<Vec<usize>> = self.doors.iter().map(place).collect();
        let ordered = |places: Vec<usize>| {
            let at = |i: usize| places.get(i);
            self.before
                .iter()
                .all(|&(first, second)| at(first) < at(second))
        };
        // Equally many doors, with each requested one among them: none is planned twice.
        planned.len() == self.doors.len() && places.is_some_and(ordered)
    }
}

/// Whether a map has a building of that name, whatever its units.
fn has_building(map: Option<&OsmMap>, name: &str) -> bool {
    let building = Address {
        building: name.to_owned(),
        unit: None,
    };
    map.is_some_and(|map| locate(map, &building) != Location::Unknown)
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Georeference, LonLat, PlannedDelivery};
    use openbench_osm::OsmData;

    fn doors(names: &[&str]) -> Vec<Address> {
        names
            .iter()
            .map(|n| Address::new("building1", *n))
            .collect()
    }

    #[test]
    fn the_list_must_be_exactly_right() {
        let expected = ExpectedPlan {
            doors: doors(&["unit1", "unit2"]),
            before: vec![],
        };
        assert!(expected.has_doors(&doors(&["Unit 2", "unit1"])));
        for wrong in [
            &["unit1"][..],
            &["unit1", "unit3"],
            &["unit1", "unit2", "unit2"],
            &["unit1", "unit1"],
            &[],
        ] {
            assert!(!expected.has_doors(&doors(wrong)), "{wrong:?}");
        }
    }

    #[test]
    fn a_requested_order_is_required() {
        let expected = ExpectedPlan {
            doors: doors(&["a", "b", "c"]),
            before: vec![(2, 0)],
        };
        assert!(expected.has_doors(&doors(&["c", "b", "a"])));
        assert!(!expected.has_doors(&doors(&["a", "b", "c"])));
    }

    #[test]
    fn a_question_is_right_only_about_a_building_that_the_map_lacks() {
        let xml = b"<osm><node id='1' lat='0' lon='0'/><node id='2' lat='0.0001' lon='0'/>\
            <node id='3' lat='0' lon='0.0001'/><way id='4'><nd ref='1'/><nd ref='2'/>\
            <nd ref='3'/><nd ref='1'/><tag k='building' v='yes'/><tag k='name' v='building1'/>\
            </way></osm>";
        let data = OsmData::from_xml(xml).unwrap();
        let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::default()));
        let right = |building: &str, problem: Option<&str>| {
            let door = Address::new(building, "unit1");
            let plan = Plan {
                planner: "test".into(),
                deliveries: vec![PlannedDelivery {
                    problem: problem.map(str::to_owned),
                    ..PlannedDelivery::to(0, door.clone())
                }],
                fallbacks: Vec::new(),
            };
            let expected = ExpectedPlan {
                doors: vec![door],
                before: vec![],
            };
            expected.is_met_by(&plan, Some(&map))
        };
        assert!(right("building1", None));
        assert!(!right("building1", Some("which one?")));
        assert!(right("building2", Some("the map has no building2")));
    }
}
