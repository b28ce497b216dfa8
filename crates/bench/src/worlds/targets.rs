//! The doors that an episode requests, by address or by true position.

use std::path::Path;

use openbench_core::{Address, MapPoint, input};
use openbench_scene::Door;

use crate::BenchError;
use crate::line_problem::LineProblem;
use crate::plural::count;
use crate::suite::truth_file::{TruthLine, parse_truth};
use crate::suite::{Episode, Suite};

/// Maximum distance between a true position and the plate of its door.
const TRUTH_TOLERANCE_M: f64 = 1.0;

/// The door of a delivery.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Address as in the instruction.
    pub address: Address,
    /// Index into the world's doors; `None` if the world has no such door, so that the delivery
    /// cannot succeed.
    pub door: Option<usize>,
}

/// The doors with the addresses of an episode.
pub(super) fn find_doors(episode: &Episode, doors: &[Door]) -> Vec<Target> {
    episode
        .deliveries
        .iter()
        .map(|address| Target {
            address: address.clone(),
            door: doors
                .iter()
                .position(|door| door.address.same_door(address))
                .or_else(|| only_door(address, doors)),
        })
        .collect()
}

/// The door of a building that has one, if an address names no unit.
fn only_door(address: &Address, doors: &[Door]) -> Option<usize> {
    if address.unit.is_some() {
        return None;
    }
    let mut there = (0..doors.len()).filter(|&i| doors[i].address.same_building(address));
    there.next().filter(|_| there.next().is_none())
}

/// The doors at the true positions (`truths`: indices into `doors`).
///
/// Without annotation each has its own address, in the order of the positions. With one, the order
/// and the addresses are the annotation's: files of true positions need not have the order of the
/// instruction, and may contain doors with another address. Equal addresses are matched first;
/// what is left follows in order.
pub(super) fn match_doors(episode: &Episode, truths: &[usize], doors: &[Door]) -> Vec<Target> {
    if episode.deliveries.is_empty() {
        return truths.iter().map(|&door| own_target(door, doors)).collect();
    }
    let mut unmatched: Vec<usize> = truths.to_vec();
    let equal: Vec<Option<usize>> = episode
        .deliveries
        .iter()
        .map(|address| take_door(&mut unmatched, address, doors))
        .collect();
    let mut unmatched = unmatched.into_iter();
    episode
        .deliveries
        .iter()
        .zip(equal)
        .map(|(address, equal)| Target {
            address: address.clone(),
            door: equal.or_else(|| unmatched.next()),
        })
        .collect()
}

fn own_target(door: usize, doors: &[Door]) -> Target {
    Target {
        address: doors[door].address.clone(),
        door: Some(door),
    }
}

/// Removes the first of `unmatched` (indices into `doors`) that has an address.
fn take_door(unmatched: &mut Vec<usize>, address: &Address, doors: &[Door]) -> Option<usize> {
    let found = unmatched
        .iter()
        .position(|&door| doors[door].address.same_door(address))?;
    Some(unmatched.remove(found))
}

/// Reads a truth file: for each episode the doors at its true positions, as indices into `doors`.
pub(super) fn read_truths(
    path: &Path,
    suite: &Suite,
    doors: &[Door],
) -> Result<Vec<Vec<usize>>, BenchError> {
    let text = input::read_text(path).map_err(|e| BenchError::file(path, e))?;
    let lines = parse_truth(&text).map_err(|LineProblem { line, problem }| {
        BenchError::bad_file(path, format!("line {line}: {problem}"))
    })?;
    if lines.len() != suite.episodes.len() {
        let problem = format!(
            "there are {} of true positions for {} of deliveries; write one for each",
            count(lines.len(), "line", "lines"),
            count(suite.episodes.len(), "line", "lines")
        );
        return Err(BenchError::bad_file(path, problem));
    }
    lines
        .iter()
        .zip(&suite.episodes)
        .map(|(line, episode)| doors_of_line(path, line, episode, doors))
        .collect()
}

/// The doors at the true positions in a line of a truth file.
fn doors_of_line(
    path: &Path,
    line: &TruthLine,
    episode: &Episode,
    doors: &[Door],
) -> Result<Vec<usize>, BenchError> {
    let TruthLine { number, points } = line;
    let found: Vec<usize> = points
        .iter()
        .map(|&point| door_at(path, *number, point, doors))
        .collect::<Result<_, _>>()?;
    // Without annotation the file alone says how many doors there are.
    if episode.deliveries.is_empty() || found.len() == episode.deliveries.len() {
        return Ok(found);
    }
    let named: Vec<String> = episode.deliveries.iter().map(Address::to_string).collect();
    let problem = format!(
        "line {number}: {} true positions, but the annotation names {} doors ({})",
        found.len(),
        named.len(),
        named.join("; ")
    );
    Err(BenchError::bad_file(path, problem))
}

fn door_at(path: &Path, line: usize, at: MapPoint, doors: &[Door]) -> Result<usize, BenchError> {
    let distance = |i: &usize| doors[*i].point().distance(at);
    let nearest = (0..doors.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    match nearest {
        Some(door) if distance(&door) <= TRUTH_TOLERANCE_M => Ok(door),
        _ => Err(BenchError::NoSuchTruth {
            path: path.to_owned(),
            line,
            at,
            nearest: nearest.map_or("none".into(), |d| doors[d].address.to_string()),
            away: nearest.map_or(f64::INFINITY, |d| distance(&d)),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::{Conditions, Sensors, TargetSource, WorldSource};
    use openbench_core::with_causes;
    use openbench_sim::traffic::TrafficPlan;

    /// Doors `unit1` to `unit3` of `building1`, 10 m apart.
    fn doors() -> Vec<Door> {
        (1..=3)
            .map(|unit| Door {
                address: Address::new("building1", format!("unit{unit}")),
                text: format!("unit {unit}"),
                plate: [10.0 * f64::from(unit), 0.0, 1.5],
                facing: 0.0,
                lettering: openbench_scene::plate::USUAL_LETTERING,
                doorway: None,
            })
            .collect()
    }

    fn episode(units: &[&str]) -> Episode {
        Episode {
            instruction: "?".into(),
            deliveries: units
                .iter()
                .map(|unit| Address::new("building1", *unit))
                .collect(),
            before: Vec::new(),
        }
    }

    #[test]
    fn without_a_unit_the_only_door_of_a_building_is_meant() {
        let without_unit = Episode {
            deliveries: vec![Address {
                building: "Building 1".into(),
                unit: None,
            }],
            ..episode(&[])
        };
        let door = |doors: &[Door]| find_doors(&without_unit, doors)[0].door;
        assert_eq!(door(&doors()[1..2]), Some(0));
        assert_eq!(door(&doors()), None);
    }

    fn targets(targets: &[Target]) -> Vec<(&str, Option<usize>)> {
        targets
            .iter()
            .map(|target| (target.address.unit.as_deref().unwrap_or(""), target.door))
            .collect()
    }

    #[test]
    fn doors_are_found_by_address_and_missing_ones_are_kept() {
        let found = find_doors(&episode(&["Unit 2", "unit9"]), &doors());
        assert_eq!(targets(&found), [("Unit 2", Some(1)), ("unit9", None)]);
    }

    #[test]
    fn true_positions_in_another_order_keep_their_addresses() {
        let found = match_doors(&episode(&["unit2", "unit1"]), &[0, 1], &doors());
        assert_eq!(targets(&found), [("unit2", Some(1)), ("unit1", Some(0))]);
    }

    #[test]
    fn true_positions_of_other_doors_get_the_addresses_that_are_left() {
        let doors = doors();
        let found = match_doors(&episode(&["unit8", "unit2", "unit9"]), &[2, 1, 0], &doors);
        let expected = [("unit8", Some(2)), ("unit2", Some(1)), ("unit9", Some(0))];
        assert_eq!(targets(&found), expected);
    }

    #[test]
    fn true_positions_without_annotation_have_the_addresses_of_their_doors() {
        let doors = doors();
        let found = match_doors(&episode(&[]), &[2], &doors);
        assert_eq!(targets(&found), [("unit3", Some(2))]);
    }

    fn read(text: &str, episodes: &[&[&str]]) -> Result<Vec<Vec<usize>>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.txt");
        std::fs::write(&path, text).unwrap();
        let suite = Suite {
            goal: Default::default(),
            name: "street".into(),
            world: WorldSource::Folder { path: ".".into() },
            targets: TargetSource::Annotation,
            traffic: TrafficPlan::default(),
            episodes: episodes.iter().map(|units| episode(units)).collect(),
            sensors: Sensors::default(),
            conditions: Conditions::default(),
            seed: 0,
        };
        read_truths(&path, &suite, &doors()).map_err(|e| with_causes(&e))
    }

    #[test]
    fn a_truth_file_names_the_doors_at_its_positions() {
        let found = read("(10.3, 0)\n(30, 0.4) (20, 0)\n", &[&["unit1"], &[]]);
        assert_eq!(found, Ok(vec![vec![0], vec![2, 1]]));
    }

    #[test]
    fn a_truth_file_that_does_not_fit_is_reported_with_its_line() {
        let problem = |text: &str| read(text, &[&["unit1"], &["unit2"]]).unwrap_err();
        assert!(problem("(10, 0)\n").contains("1 line of true positions for 2 lines"));
        assert!(problem("(10, 0)\n(20; 0)\n").contains("line 2"));
        let far = problem("(10, 0)\n(20, 1.1)\n");
        assert!(far.contains(":2: (20, 1.1) is no door"), "{far}");
        assert!(far.contains("unit2, building1, 1.10 m away"), "{far}");
        let several = problem("(10, 0)\n(20, 0) (30, 0)\n");
        assert!(several.contains("line 2: 2 true positions"), "{several}");
    }
}
