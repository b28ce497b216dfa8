//! SRTP, success rate of task planning: the share of instructions whose list of doors, in an admissible order, is
//! exactly right.

use openbench_core::Address;

/// What an instruction asks for.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExpectedPlan {
    /// The doors, each once.
    pub doors: Vec<Address>,
    /// Pairs of positions in `doors`: the first must be driven to before the second. Without pairs any order will do.
    pub before: Vec<(usize, usize)>,
}

impl ExpectedPlan {
    /// Whether `planned` names exactly the doors asked for, each once, in an admissible order.
    pub fn is_met_by(&self, planned: &[Address]) -> bool {
        let place = |door: &Address| planned.iter().position(|p| p.same_door(door));
        let places: Option<Vec<usize>> = self.doors.iter().map(place).collect();
        let ordered = |places: Vec<usize>| {
            let at = |i: usize| places.get(i);
            self.before
                .iter()
                .all(|&(first, second)| at(first) < at(second))
        };
        planned.len() == self.doors.len() && places.is_some_and(ordered)
    }
}

/// SRTP over pairs of what was asked for and what was planned; `None` without instructions. A plan that could not be
/// made is an empty one.
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
    fn an_order_that_was_asked_for_counts() {
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
