//! The reference's files of true door positions: points in parentheses.

use openbench_core::MapPoint;

use crate::line_problem::LineProblem;

/// A line of a truth file.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthLine {
    /// Number of the line in its file, from 1; empty lines count.
    pub number: usize,
    /// The true positions.
    pub points: Vec<MapPoint>,
}

/// Parses the points of each line that is not empty, in the `map` frame.
///
/// # Errors
/// The first line that is not a row of `(x, y)`.
///
/// ```
/// use openbench_bench::suite::truth_file::parse_truth;
///
/// let lines = parse_truth("(1.66, -24.35)\n(-2.59, -27.03) (0.85, -27.57)\n").unwrap();
/// assert_eq!((lines[0].points.len(), lines[1].points.len()), (1, 2));
/// assert_eq!(parse_truth("(1.66; -24.35)").unwrap_err().line, 1);
/// ```
pub fn parse_truth(text: &str) -> Result<Vec<TruthLine>, LineProblem> {
    let lines = (1..)
        .zip(text.lines())
        .filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(number, line)| {
            let points = parse_line(line.trim()).ok_or_else(|| LineProblem {
                line: number,
                problem: problem(line),
            })?;
            Ok(TruthLine { number, points })
        })
        .collect()
}

fn problem(line: &str) -> String {
    // A file of another kind may have lines of any length.
    format!(
        "`{}` is not a row of `(x, y)`",
        line.trim().chars().take(60).collect::<String>()
    )
}

fn parse_line(line: &str) -> Option<Vec<MapPoint>> {
    let mut points = Vec::new();
    let mut rest = line;
    while !rest.is_empty() {
        let (point, after) = rest.strip_prefix('(')?.split_once(')')?;
        let (x, y) = point.split_once(',')?;
        points.push(MapPoint::new(number(x)?, number(y)?));
        // The published files separate points by spaces; other writers use commas or semicolons.
        rest = after.trim_start_matches([' ', '\t', ',', ';']);
    }
    Some(points)
}

fn number(text: &str) -> Option<f64> {
    // `parse` accepts `nan` and `inf` as well.
    text.trim().parse().ok().filter(|v: &f64| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_one_or_several_points() {
        let lines = parse_truth("(1.66, -24.35)\n\n(-2.59, -27.03) (0.85, -27.57)\n").unwrap();
        let first = TruthLine {
            number: 1,
            points: vec![MapPoint::new(1.66, -24.35)],
        };
        let second = TruthLine {
            number: 3,
            points: vec![MapPoint::new(-2.59, -27.03), MapPoint::new(0.85, -27.57)],
        };
        assert_eq!(lines, [first, second]);
        assert!(parse_truth("").unwrap().is_empty());
    }

    #[test]
    fn anything_else_is_reported_with_its_line() {
        for text in [
            "1, 2",
            "(1, 2",
            "(1 2)",
            "(1, inf)",
            "(1, 2) x",
            "(1, 2, 3)",
        ] {
            let LineProblem { line, problem } =
                parse_truth(&format!("(0, 0)\n{text}")).unwrap_err();
            assert!(line == 2 && problem.contains(text), "{problem}");
        }
    }
}
