//! SRTP, success rate of task planning: the share of instructions with exactly the right list of
//! doors, in an admissible order.

use openbench_core::Address;

use crate::score::statistics::Proportion;

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
    /// assert!(expected.is_met_by(&[first.clone(), second.clone()]));
    /// assert!(!expected.is_met_by(&[second, first.clone()]));
    /// assert!(!expected.is_met_by(&[first]));
    /// ```
    pub fn is_met_by(&self, planned: &[Address]) -> bool {
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

/// SRTP over pairs of the expected and the made plan; `None` without instructions. A planner that
/// fails has an empty plan.
pub fn srtp(plans: &[(ExpectedPlan, Vec<Address>)]) -> Option<f64> {
    let right = plans
        .iter()
        .filter(|(expected, planned)| expected.is_met_by(planned))
        .count();
    (!plans.is_empty()).then(|| right as f64 / plans.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(expected.is_met_by(&doors(&["Unit 2", "unit1"])));
        for wrong in [
            &["unit1"][..],
            &["unit1", "unit3"],
            &["unit1", "unit2", "unit2"],
            &["unit1", "unit1"],
            &[],
        ] {
            assert!(!expected.is_met_by(&doors(wrong)), "{wrong:?}");
        }
    }

    #[test]
    fn a_requested_order_is_required() {
        let expected = ExpectedPlan {
            doors: doors(&["a", "b", "c"]),
            before: vec![(2, 0)],
        };
        assert!(expected.is_met_by(&doors(&["c", "b", "a"])));
        assert!(!expected.is_met_by(&doors(&["a", "b", "c"])));
    }

    #[test]
    fn srtp_is_a_share() {
        let expected = ExpectedPlan {
            doors: doors(&["a"]),
            before: vec![],
        };
        let plans = [(expected.clone(), doors(&["a"])), (expected, vec![])];
        assert_eq!(srtp(&plans), Some(0.5));
        assert_eq!(srtp(&[]), None);
    }
}
