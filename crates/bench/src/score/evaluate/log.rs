//! Logs of the recorder of the paper, CSV.

use openbench_core::MapPoint;

use crate::line_problem::LineProblem;

/// One task of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct LoggedTask {
    /// The address as logged.
    pub address: String,
    /// Position of the robot in the last row.
    pub end: MapPoint,
    /// Sum of the straight lines between rows, in three dimensions as in the reference, metres.
    pub path_m: f64,
}

/// Parses a log into its tasks.
///
/// # Errors
/// The first line that is not in the format of the module [`evaluate`](super).
pub fn parse_log(text: &str) -> Result<Vec<LoggedTask>, LineProblem> {
    let mut tasks = Vec::<LoggedTask>::new();
    let mut last = [0.0; 3];
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim().is_empty() || (number == 1 && line.trim_start().starts_with("timestamp")) {
            continue;
        }
        let row = parse_row(line).map_err(|problem| LineProblem {
            line: number,
            problem: problem.to_string(),
        })?;
        let end = MapPoint::new(row.at[0], row.at[1]);
        match (row.status.as_str(), tasks.last_mut()) {
            // A new task starts with an empty path: the distance from the end of the previous task
            // belongs to neither.
            ("start", _) => tasks.push(LoggedTask {
                address: row.address,
                end,
                path_m: 0.0,
            }),
            (_, Some(task)) => {
                task.path_m += distance(last, row.at);
                task.end = end;
            }
            (_, None) => return Err(first_row_is_no_start(number)),
        }
        last = row.at;
    }
    Ok(tasks)
}

struct Row {
    status: String,
    address: String,
    at: [f64; 3],
}

/// Why a row is not one of a log.
#[derive(Debug, thiserror::Error)]
enum RowError {
    #[error("{count} fields, but 6 are expected: timestamp,status,address,robot_x,robot_y,robot_z")]
    FieldCount { count: usize },
    #[error("status `{status}` is none of start, running, end")]
    Status { status: String },
    #[error("`{text}` is no coordinate")]
    Coordinate { text: String },
    #[error("a double quote is not closed")]
    OpenQuote,
}

fn parse_row(line: &str) -> Result<Row, RowError> {
    let fields = split_fields(line)?;
    let [_, status, first, others @ .., x, y, z] = fields.as_slice() else {
        let count = fields.len();
        return Err(RowError::FieldCount { count });
    };
    if !["start", "running", "end"].contains(&status.trim()) {
        let status = status.clone();
        return Err(RowError::Status { status });
    }
    let at = [coordinate(x)?, coordinate(y)?, coordinate(z)?];
    // Some writers do not quote: the commas of an address then divide it into several fields.
    Ok(Row {
        status: status.trim().to_owned(),
        address: [std::slice::from_ref(first), others].concat().join(","),
        at,
    })
}

fn coordinate(text: &str) -> Result<f64, RowError> {
    let number = text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    number.ok_or_else(|| RowError::Coordinate { text: text.into() })
}

/// The fields of a CSV row; a field in double quotes may contain commas and doubled quotes.
fn split_fields(line: &str) -> Result<Vec<String>, RowError> {
    let (mut fields, mut field, mut quoted) = (Vec::new(), String::new(), false);
    let mut rest = line.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            // As in RFC 4180: within quotes, a doubled quote stands for one.
            '"' if quoted && rest.next_if_eq(&'"').is_some() => field.push('"'),
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(std::mem::take(&mut field)),
            c => field.push(c),
        }
    }
    fields.push(field);
    if quoted {
        Err(RowError::OpenQuote)
    } else {
        Ok(fields)
    }
}

fn first_row_is_no_start(line: usize) -> LineProblem {
    LineProblem {
        line,
        problem: "the first row must have the status `start`".to_owned(),
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::sqrt(a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(text: &str) -> LineProblem {
        parse_log(text).unwrap_err()
    }

    #[test]
    fn each_row_with_status_start_begins_a_task() {
        let tasks = parse_log("1,start,a,0,0,0\n2,running,a,3,4,12\n3,start,b,9,9,9\n").unwrap();
        assert_eq!(tasks.len(), 2);
        assert_eq!(
            (tasks[0].path_m, tasks[0].end),
            (13.0, MapPoint::new(3.0, 4.0))
        );
        assert_eq!((tasks[1].path_m, tasks[1].address.as_str()), (0.0, "b"));
    }

    #[test]
    fn commas_in_addresses_are_kept() {
        for line in ["1,start,\"unit1, b3\",0,0,0", "1,start,unit1, b3,0,0,0"] {
            assert_eq!(parse_log(line).unwrap()[0].address, "unit1, b3");
        }
        assert_eq!(
            parse_log("1,start,\"a\"\"b\",0,0,0").unwrap()[0].address,
            "a\"b"
        );
    }

    #[test]
    fn invalid_rows_are_reported_with_their_line() {
        let head = "timestamp,status,address,robot_x,robot_y,robot_z\n";
        assert_eq!(problem(&format!("{head}1,running,a,0,0,0")).line, 2);
        assert!(
            problem(&format!("{head}1,start,a,0,0"))
                .problem
                .contains("5 fields")
        );
        assert!(
            problem(&format!("{head}1,start,a,0,0,0\n2,runing,a,0,0,0"))
                .problem
                .contains("`runing`")
        );
        assert!(problem("1,start,a,0,nan,0").problem.contains("`nan`"));
        assert!(problem("1,start,\"a,0,0,0").problem.contains("quote"));
    }
}
