//! The contract of planners, tested with each of them.

mod support;

use std::sync::Arc;

use openbench_language::{ChatPlanner, GrammarPlanner, PlanError, Planner};
use support::{Flat, Script, Straight, doors, numbered, plan};

/// Makes a planner; the lines are the model's answers, if it asks one.
type Make = fn(&[&str]) -> Box<dyn Planner>;

const PLANNERS: [(&str, Make); 2] = [
    ("grammar", |_| Box::new(GrammarPlanner::new())),
    ("chat:script", |lines| {
        Box::new(ChatPlanner::new(Box::new(Arc::new(Script::new(lines)))))
    }),
];

const ONE: &str =
    r#"{"deliveries": [{"item": "this box", "building": "building3", "unit": "unit1"}]}"#;
const TWO: &str = r#"{"deliveries": [
    {"item": "this box", "building": "building3", "unit": "unit1"},
    {"item": "this parcel", "building": "building2", "unit": "unit2"}]}"#;

#[test]
fn it_reports_its_name() {
    for (name, make) in PLANNERS {
        assert_eq!(make(&[]).name(), name);
        let plan = plan(
            &*make(&[ONE, ONE]),
            &numbered(3),
            &Flat,
            "This box to unit 1, building 3",
        )
        .unwrap();
        assert_eq!(plan.planner, name);
    }
}

#[test]
fn it_names_doors_items_and_steps() {
    for (name, make) in PLANNERS {
        let plan = plan(
            &*make(&[ONE, ONE]),
            &numbered(3),
            &Flat,
            "this box to unit 1, building 3",
        )
        .unwrap();
        let json = serde_json::to_value(&plan.deliveries).unwrap();
        let wanted = serde_json::json!([{
            "instruction_index": 0,
            "item": "this box",
            "building": "building3",
            "unit": "unit1",
            "confidence": 1.0,
            "problem": null,
            "steps": [
                {"mode": "navigate", "target": "building3"},
                {"mode": "explore", "target": "unit1"},
            ],
        }]);
        assert_eq!(json, wanted, "{name}");
    }
}

#[test]
fn it_visits_the_nearer_door_first_and_keeps_the_instructions_index() {
    for (name, make) in PLANNERS {
        let lines = [TWO, TWO, r#"{"order": [2, 1]}"#];
        let text = "this box to unit1, building3 and this parcel to unit 2, building 2";
        let plan = plan(&*make(&lines), &numbered(3), &Straight, text).unwrap();
        assert_eq!(doors(&plan), "building2/unit2 building3/unit1", "{name}");
        let indices: Vec<usize> = plan
            .deliveries
            .iter()
            .map(|d| d.instruction_index)
            .collect();
        assert_eq!(indices, [1, 0], "{name}");
    }
}

#[test]
fn it_delivers_to_each_door_once() {
    let twice = r#"{"deliveries": [
        {"item": "a box", "building": "building3", "unit": "1"},
        {"item": "a letter", "building": "Building 3", "unit": "unit1"}]}"#;
    for (name, make) in PLANNERS {
        let text = "a box to unit 1 of building 3 and a letter to unit 1 of building 3";
        let plan = plan(&*make(&[twice, twice]), &numbered(3), &Flat, text).unwrap();
        assert_eq!(doors(&plan), "building3/unit1", "{name}");
        assert_eq!(plan.deliveries[0].item, "a box, a letter", "{name}");
    }
}

#[test]
fn it_reports_what_the_map_lacks() {
    for (name, make) in PLANNERS {
        let plan = plan(
            &*make(&[ONE, ONE]),
            &numbered(2),
            &Flat,
            "this box to unit 1, building 3",
        )
        .unwrap();
        assert_eq!(doors(&plan), "building3/unit1", "{name}");
        assert!(
            plan.deliveries[0]
                .problem
                .as_deref()
                .is_some_and(|p| p.contains("building 3") || p.contains("building3")),
            "{name}"
        );
    }
}

#[test]
fn it_fails_if_there_is_nothing_to_deliver() {
    let nothing = r#"{"deliveries": []}"#;
    for (name, make) in PLANNERS {
        let error = plan(
            &*make(&[nothing, nothing]),
            &numbered(2),
            &Flat,
            "Sing me a song",
        )
        .unwrap_err();
        assert!(
            matches!(&error, PlanError::NotUnderstood { .. }),
            "{name}: {error}"
        );
        assert!(
            error.to_string().contains("Sing me a song") && error.to_string().contains("building"),
            "{name}"
        );
    }
}

#[test]
fn it_is_deterministic() {
    for (name, make) in PLANNERS {
        let run = || {
            plan(
                &*make(&[TWO, TWO, "[1, 2]"]),
                &numbered(3),
                &Straight,
                "this box to unit 1, building 3, this parcel to unit 2, building 2",
            )
        };
        assert_eq!(run(), run(), "{name}");
    }
}
