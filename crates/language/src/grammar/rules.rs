//! The tables of rules that a planner reads instructions with.

use super::intent::denial::{DENIALS, Denial};
use super::intent::{INTENTS, Intent};
use super::pairing::naming::{NAMINGS, Naming};
use super::pairing::sharing::{SHARINGS, Sharing};
use super::sequence::orderings::{ORDERINGS, Ordering};

/// The rules of each stage.
pub(crate) struct Rules {
    pub denials: Vec<Denial>,
    pub intents: Vec<Intent>,
    pub namings: Vec<Naming>,
    pub sharings: Vec<Sharing>,
    pub orderings: Vec<Ordering>,
}

impl Rules {
    /// All rules.
    pub(crate) fn all() -> Self {
        Self {
            denials: DENIALS.to_vec(),
            intents: INTENTS.to_vec(),
            namings: NAMINGS.to_vec(),
            sharings: SHARINGS.to_vec(),
            orderings: ORDERINGS.to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fmt::Write;

    use openbench_core::{Georeference, LonLat, MapPoint, TravelTimes};
    use openbench_osm::{OsmData, OsmMap};

    use super::*;
    use crate::grammar::GrammarPlanner;
    use crate::grammar::rule::Example;
    use crate::{PlanRequest, Planner};

    /// Name and examples of a rule.
    struct Row {
        name: &'static str,
        examples: &'static [Example],
    }

    fn rows() -> Vec<Row> {
        let Rules {
            denials,
            intents,
            namings,
            sharings,
            orderings,
        } = Rules::all();
        let mut rows = Vec::new();
        rows.extend(denials.iter().map(|rule| Row {
            name: rule.name,
            examples: rule.examples,
        }));
        rows.extend(intents.iter().map(|rule| Row {
            name: rule.name,
            examples: rule.examples,
        }));
        rows.extend(namings.iter().map(|rule| Row {
            name: rule.name,
            examples: rule.examples,
        }));
        rows.extend(sharings.iter().map(|rule| Row {
            name: rule.name,
            examples: rule.examples,
        }));
        rows.extend(orderings.iter().map(|rule| Row {
            name: rule.name,
            examples: rule.examples,
        }));
        rows
    }

    impl Rules {
        fn without(name: &str) -> Self {
            let mut rules = Self::all();
            rules.denials.retain(|rule| rule.name != name);
            rules.intents.retain(|rule| rule.name != name);
            rules.namings.retain(|rule| rule.name != name);
            rules.sharings.retain(|rule| rule.name != name);
            rules.orderings.retain(|rule| rule.name != name);
            rules
        }
    }

    /// One metre a second in a straight line.
    struct Straight;

    impl TravelTimes for Straight {
        fn matrix(&self, places: &[MapPoint]) -> Vec<f64> {
            places
                .iter()
                .flat_map(|a| places.iter().map(|b| a.distance(*b)))
                .collect()
        }
    }

    /// Corners of a house, in degrees.
    const CORNERS: [(f64, f64); 4] = [(0.0, 0.0), (1e-4, 0.0), (1e-4, 1e-4), (0.0, 1e-4)];

    /// `building1` to `building12` in a row east of the origin, `unit1` to `unit4` at the corners
    /// of each.
    fn estate() -> OsmMap {
        let mut xml = String::from(r#"<osm version="0.6">"#);
        for house in 1..=12 {
            let mut refs = String::new();
            for (corner, (x, y)) in CORNERS.into_iter().enumerate() {
                let id = house * 10 + corner;
                let lon = house as f64 * 2e-4 + x;
                let unit = corner + 1;
                write!(
                    xml,
                    r#"<node id="{id}" lat="{y}" lon="{lon}"><tag k="entrance" v="yes"/>"#
                )
                .unwrap();
                write!(xml, r#"<tag k="addr:unit" v="unit{unit}"/></node>"#).unwrap();
                write!(refs, r#"<nd ref="{id}"/>"#).unwrap();
            }
            write!(xml, r#"<way id="{house}">{refs}<nd ref="{}"/>"#, house * 10).unwrap();
            write!(xml, r#"<tag k="building" v="yes"/>"#).unwrap();
            write!(xml, r#"<tag k="name" v="building{house}"/></way>"#).unwrap();
        }
        xml.push_str("</osm>");
        let data = OsmData::from_xml(xml.as_bytes()).unwrap();
        OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)))
    }

    /// `building3/unit1 building5`: the doors that are planned, in driving order.
    fn planned(planner: &GrammarPlanner, map: &OsmMap, instruction: &str) -> String {
        let request = PlanRequest {
            instruction,
            map,
            start: MapPoint::default(),
            times: &Straight,
        };
        let Ok(plan) = planner.plan(&request) else {
            return "nothing".to_owned();
        };
        let doors = plan.deliveries.iter().map(|delivery| match &delivery.unit {
            Some(unit) => format!("{}/{unit}", delivery.building),
            None => delivery.building.clone(),
        });
        doors.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn every_rule_has_a_name_of_its_own() {
        let names: BTreeSet<&str> = rows().iter().map(|row| row.name).collect();
        assert_eq!(names.len(), rows().len());
    }

    #[test]
    fn examples_are_planned_as_their_rules_say() {
        let planner = GrammarPlanner::new();
        let map = estate();
        let mut wrong = Vec::new();
        for row in rows() {
            for Example(instruction, doors) in row.examples {
                let found = planned(&planner, &map, instruction);
                if found != *doors {
                    wrong.push(format!("{}: {instruction}: {found}", row.name));
                }
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn without_its_rule_each_example_is_planned_otherwise() {
        let map = estate();
        let mut same = Vec::new();
        for row in rows() {
            let planner = GrammarPlanner::with_rules(Rules::without(row.name));
            for Example(instruction, doors) in row.examples {
                if planned(&planner, &map, instruction) == *doors {
                    same.push(format!("{}: {instruction}", row.name));
                }
            }
        }
        assert!(same.is_empty(), "{}", same.join("\n"));
    }

    #[test]
    fn every_rule_has_an_example() {
        let without: Vec<&str> = rows()
            .iter()
            .filter(|row| row.examples.is_empty())
            .map(|row| row.name)
            .collect();
        assert!(without.is_empty(), "{without:?}");
    }
}
