//! Solves a Moving AI scenario file with A* and compares each length with the published one:
//!
//! Prints the number of scenarios, how many paths are as short as published, and mean and longest
//! CPU time. Maps and scenarios: N. Sturtevant, *Benchmarks for Grid-Based Pathfinding*, 2012
//! (octile distances, no corners cut).

#![expect(clippy::print_stdout, reason = "this is what it is for")]

use std::error::Error;

use cpu_time::ThreadTime;
use openbench_motion::{Costs, Search};

/// Published lengths have eight decimals.
const EXACT: f64 = 1e-5;
/// So many of the longest are reported separately.
const LONGEST: usize = 20;

/// A line of a scenario file.
struct Scenario {
    start: usize,
    goal: usize,
    length: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let [map, scenarios] = &std::env::args().skip(1).collect::<Vec<_>>()[..] else {
        return Err("usage: movingai MAP SCEN".into());
    };
    let (width, cells) = read_map(&std::fs::read_to_string(map)?)?;
    let scenarios = read_scenarios(&std::fs::read_to_string(scenarios)?, width, cells.len())?;
    let costs = Costs::new(width, &cells)?;
    let mut search = Search::default();
    let (mut optimal, mut times) = (0, Vec::new());
    for scenario in &scenarios {
        let begin = ThreadTime::now();
        let found = search.cheapest(&costs, scenario.start, scenario.goal);
        times.push((scenario.length, begin.elapsed().as_secs_f64() * 1e3));
        let length = found.map_or(f64::INFINITY, |path| path.cost);
        if (length - scenario.length).abs() <= EXACT {
            optimal += 1;
        } else {
            println!(
                "{} to {}: {length}, published {}",
                scenario.start, scenario.goal, scenario.length
            );
        }
    }
    let mean =
        |times: &[(f64, f64)]| times.iter().map(|t| t.1).sum::<f64>() / times.len().max(1) as f64;
    let worst = times.iter().map(|t| t.1).fold(0.0, f64::max);
    println!(
        "{} scenarios, {optimal} optimal, mean {:.3} ms, max {worst:.3} ms",
        scenarios.len(),
        mean(&times)
    );
    times.sort_by(|a, b| b.0.total_cmp(&a.0));
    times.truncate(LONGEST);
    println!("the {} longest: mean {:.3} ms", times.len(), mean(&times));
    if optimal == scenarios.len() {
        Ok(())
    } else {
        Err("not all are optimal".into())
    }
}

/// Width, and 1 for each free cell, infinity for each that is not.
fn read_map(text: &str) -> Result<(usize, Vec<f32>), Box<dyn Error>> {
    let mut lines = text.lines();
    let mut number = |name: &str| -> Result<usize, Box<dyn Error>> {
        let line = lines
            .by_ref()
            .find(|line| line.starts_with(name))
            .ok_or(format!("the map has no {name}"))?;
        Ok(line[name.len()..].trim().parse()?)
    };
    let (height, width) = (number("height")?, number("width")?);
    let rows: Vec<&str> = lines
        .skip_while(|line| line.trim() != "map")
        .skip(1)
        .take(height)
        .collect();
    if rows.len() != height || rows.iter().any(|row| row.len() != width) {
        return Err(format!("the map has no {height} rows of {width} cells").into());
    }
    let cost = |byte: u8| {
        if matches!(byte, b'.' | b'G' | b'S') {
            1.0
        } else {
            f32::INFINITY
        }
    };
    Ok((
        width,
        rows.iter().flat_map(|row| row.bytes().map(cost)).collect(),
    ))
}

fn read_scenarios(text: &str, width: usize, cells: usize) -> Result<Vec<Scenario>, Box<dyn Error>> {
    let mut scenarios = Vec::new();
    for (number, line) in text
        .lines()
        .enumerate()
        .skip(1)
        .filter(|(_, line)| !line.trim().is_empty())
    {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, _, _, _, x, y, u, v, length] = words[..] else {
            return Err(format!("line {}: not nine columns", number + 1).into());
        };
        let cell = |x: &str, y: &str| -> Result<usize, Box<dyn Error>> {
            let (x, y): (usize, usize) = (x.parse()?, y.parse()?);
            let cell = y.checked_mul(width).and_then(|row| row.checked_add(x));
            let cell = cell.filter(|cell| x < width && *cell < cells);
            cell.ok_or_else(|| format!("line {}: ({x}, {y}) is off the map", number + 1).into())
        };
        scenarios.push(Scenario {
            start: cell(x, y)?,
            goal: cell(u, v)?,
            length: length.parse()?,
        });
    }
    Ok(scenarios)
}
