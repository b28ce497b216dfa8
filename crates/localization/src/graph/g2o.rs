//! Pose graphs as g2o's text files.
//!
//! R. Kümmerle, G. Grisetti, H. Strasdat, K. Konolige, W. Burgard, *g2o: A General Framework for
//! Graph Optimization*, 2011. Read and written are `VERTEX_SE2`, `EDGE_SE2`, `VERTEX_SE3:QUAT`,
//! `EDGE_SE3:QUAT` and `FIX`. As in GTSAM, the information about a rotation in space is that about
//! its logarithm.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::num::{ParseFloatError, ParseIntError};

use nalgebra::{Isometry2, Isometry3, Quaternion, SMatrix, Translation3, UnitQuaternion, Vector2};

use super::pose::Pose;
use super::problem::{Edge, Graph, is_information};
use super::solve::{SolveError, Solved};

/// A graph of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum PoseGraph {
    /// In the plane.
    Plane(NumberedGraph<Isometry2<f64>, 3>),
    /// In space.
    Space(NumberedGraph<Isometry3<f64>, 6>),
}

/// A graph, and the numbers that its poses have in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberedGraph<P, const D: usize> {
    /// The graph.
    pub graph: Graph<P, D>,
    /// One for each pose.
    pub numbers: Vec<u64>,
}

/// How large a graph is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraphSize {
    /// Number of poses.
    pub poses: usize,
    /// Number of edges.
    pub edges: usize,
}

/// What is wrong with a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum G2oError {
    /// A line cannot be read.
    #[error("line {line}")]
    Line {
        /// Which, from 1.
        line: usize,
        /// What is wrong with it.
        #[source]
        problem: LineError,
    },
    /// Poses in the plane and in space.
    #[error("the file has poses in the plane and in space; keep one kind")]
    Mixed,
    /// No pose.
    #[error("the file has no pose: neither VERTEX_SE2 nor VERTEX_SE3:QUAT")]
    Empty,
}

/// What is wrong with a line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// The first word is unknown.
    #[error(
        "unknown tag `{0}`; expected VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT, EDGE_SE3:QUAT or FIX"
    )]
    Tag(String),
    /// A pose has no number.
    #[error("the pose has no number")]
    NoNumber,
    /// An edge does not name two poses.
    #[error("the edge does not name two poses")]
    NoEnds,
    /// A word is not the number of a pose.
    #[error("`{word}` is not the number of a pose")]
    PoseNumber {
        /// The word.
        word: String,
        /// Why.
        source: ParseIntError,
    },
    /// Too few or too many numbers.
    #[error("expected {wanted} numbers, found {found}")]
    Count {
        /// How many there are.
        found: usize,
        /// How many there should be.
        wanted: usize,
    },
    /// A word is not a number.
    #[error("`{word}` is not a number")]
    NotANumber {
        /// The word.
        word: String,
        /// Why.
        source: ParseFloatError,
    },
    /// A number is NaN or infinite.
    #[error("`{0}` is not a finite number")]
    NotFinite(String),
    /// A pose has the number of an earlier one.
    #[error("pose {0} is defined twice")]
    Repeated(u64),
    /// A quaternion has no direction.
    #[error("not a pose: the quaternion has no direction")]
    Quaternion,
    /// Information that is not that of a covariance.
    #[error("not the inverse of a covariance: the information matrix is not positive semidefinite")]
    Information,
    /// An edge or `FIX` names a pose that is not there.
    #[error("there is no pose {0}")]
    NoSuchPose(u64),
}

impl PoseGraph {
    /// Reads the text of a file.
    ///
    /// # Errors
    ///
    /// The first line that cannot be read, or what the file lacks.
    pub fn parse(text: &str) -> Result<Self, G2oError> {
        let mut plane = Part::default();
        let mut space = Part::default();
        let mut held = Vec::new();
        for (index, text) in text.lines().enumerate() {
            let line = index + 1;
            read_line(text, line, &mut plane, &mut space, &mut held)
                .map_err(|problem| G2oError::Line { line, problem })?;
        }
        match (plane.is_empty(), space.is_empty()) {
            (false, true) => plane.finish(&held).map(Self::Plane),
            (true, false) => space.finish(&held).map(Self::Space),
            (true, true) => Err(G2oError::Empty),
            (false, false) => Err(G2oError::Mixed),
        }
    }

    /// Numbers of poses and of edges.
    pub fn size(&self) -> GraphSize {
        match self {
            Self::Plane(numbered) => numbered.size(),
            Self::Space(numbered) => numbered.size(),
        }
    }

    /// Solves it, see [`Graph::solve`].
    ///
    /// # Errors
    ///
    /// Those of [`Graph::solve`].
    pub fn solve(&mut self) -> Result<Solved, SolveError> {
        match self {
            Self::Plane(numbered) => numbered.graph.solve(),
            Self::Space(numbered) => numbered.graph.solve(),
        }
    }

    /// The text of a file.
    pub fn to_text(&self) -> String {
        match self {
            Self::Plane(numbered) => text_of(numbered),
            Self::Space(numbered) => text_of(numbered),
        }
    }
}

/// A pose as it is written in a file.
trait Entry<const D: usize>: Pose<D> {
    /// First word of the line of a pose.
    const VERTEX: &'static str;
    /// First word of the line of an edge.
    const EDGE: &'static str;
    /// How many numbers describe a pose.
    const SIZE: usize;

    /// The pose of [`SIZE`](Self::SIZE) numbers; `None` if they describe none.
    fn from_numbers(numbers: &[f64]) -> Option<Self>;

    /// The numbers of the pose.
    fn to_numbers(&self) -> Vec<f64>;
}

impl Entry<3> for Isometry2<f64> {
    const VERTEX: &'static str = "VERTEX_SE2";
    const EDGE: &'static str = "EDGE_SE2";
    const SIZE: usize = 3;

    fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let &[x, y, yaw] = numbers else { return None };
        Some(Self::new(Vector2::new(x, y), yaw))
    }

    fn to_numbers(&self) -> Vec<f64> {
        self.distance().iter().copied().collect()
    }
}

impl Entry<6> for Isometry3<f64> {
    const VERTEX: &'static str = "VERTEX_SE3:QUAT";
    const EDGE: &'static str = "EDGE_SE3:QUAT";
    const SIZE: usize = 7;

    fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let &[x, y, z, i, j, k, w] = numbers else {
            return None;
        };
        let rotation = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-6)?;
        // The square of a large number overflows.
        let is_unit = (rotation.norm() - 1.0).abs() < 1e-6;
        is_unit.then(|| Self::from_parts(Translation3::new(x, y, z), rotation))
    }

    fn to_numbers(&self) -> Vec<f64> {
        self.translation
            .vector
            .iter()
            .chain(self.rotation.coords.iter())
            .copied()
            .collect()
    }
}

impl<P, const D: usize> NumberedGraph<P, D> {
    fn size(&self) -> GraphSize {
        GraphSize {
            poses: self.graph.poses.len(),
            edges: self.graph.edges.len(),
        }
    }
}

/// The text of a file: poses, `FIX` lines, edges.
fn text_of<P: Entry<D>, const D: usize>(numbered: &NumberedGraph<P, D>) -> String {
    let NumberedGraph { graph, numbers } = numbered;
    let mut text = String::new();
    for (pose, number) in graph.poses.iter().zip(numbers) {
        // Writing to a `String` cannot fail.
        let _ = write!(text, "{} {number}", P::VERTEX);
        push_numbers(&mut text, &pose.to_numbers());
        text.push('\n');
    }
    for held in &graph.held {
        let _ = writeln!(text, "FIX {}", numbers[*held]);
    }
    for edge in &graph.edges {
        let _ = write!(
            text,
            "{} {} {}",
            P::EDGE,
            numbers[edge.from],
            numbers[edge.to]
        );
        push_numbers(&mut text, &edge.measured.to_numbers());
        let upper: Vec<f64> = upper_triangle::<D>()
            .map(|at| edge.information[at])
            .collect();
        push_numbers(&mut text, &upper);
        text.push('\n');
    }
    text
}

fn push_numbers(text: &mut String, numbers: &[f64]) {
    for number in numbers {
        // `Display` writes the shortest text that reads back as the same number.
        let _ = write!(text, " {number}");
    }
}

/// Row and column of each entry of the upper triangle of a matrix, row by row.
fn upper_triangle<const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..D).flat_map(|row| (row..D).map(move |column| (row, column)))
}

/// A pose that a line of a file names.
#[derive(Debug, Clone, Copy)]
struct Reference {
    number: u64,
    line: usize,
}

/// An edge as it is written in a file; the indices of its poses are not known yet.
struct FileEdge<P, const D: usize> {
    from: Reference,
    to: Reference,
    measured: P,
    information: SMatrix<f64, D, D>,
}

/// Poses and edges of one kind.
struct Part<P, const D: usize> {
    /// Index of each pose by its number.
    indices: BTreeMap<u64, usize>,
    poses: Vec<P>,
    edges: Vec<FileEdge<P, D>>,
}

impl<P, const D: usize> Default for Part<P, D> {
    fn default() -> Self {
        Self {
            indices: BTreeMap::new(),
            poses: Vec::new(),
            edges: Vec::new(),
        }
    }
}

/// Reads a line into the part that it belongs to.
fn read_line(
    text: &str,
    line: usize,
    plane: &mut Part<Isometry2<f64>, 3>,
    space: &mut Part<Isometry3<f64>, 6>,
    held: &mut Vec<Reference>,
) -> Result<(), LineError> {
    let mut words = text.split_whitespace();
    let Some(tag) = words.next().filter(|tag| !tag.starts_with('#')) else {
        return Ok(());
    };
    let words: Vec<&str> = words.collect();
    match tag {
        Isometry2::<f64>::VERTEX => plane.read_vertex(&words),
        Isometry3::<f64>::VERTEX => space.read_vertex(&words),
        Isometry2::<f64>::EDGE => plane.read_edge(&words, line),
        Isometry3::<f64>::EDGE => space.read_edge(&words, line),
        "FIX" => read_held(&words, line, held),
        _ => Err(LineError::Tag(tag.to_owned())),
    }
}

fn read_held(words: &[&str], line: usize, held: &mut Vec<Reference>) -> Result<(), LineError> {
    for word in words {
        held.push(Reference {
            number: pose_number(word)?,
            line,
        });
    }
    Ok(())
}

impl<P: Entry<D>, const D: usize> Part<P, D> {
    fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    fn read_vertex(&mut self, words: &[&str]) -> Result<(), LineError> {
        let [number, rest @ ..] = words else {
            return Err(LineError::NoNumber);
        };
        let number = pose_number(number)?;
        let numbers = numbers(rest, P::SIZE)?;
        if self.indices.insert(number, self.poses.len()).is_some() {
            return Err(LineError::Repeated(number));
        }
        self.poses
            .push(P::from_numbers(&numbers).ok_or(LineError::Quaternion)?);
        Ok(())
    }

    fn read_edge(&mut self, words: &[&str], line: usize) -> Result<(), LineError> {
        let [from, to, rest @ ..] = words else {
            return Err(LineError::NoEnds);
        };
        let from = Reference {
            number: pose_number(from)?,
            line,
        };
        let to = Reference {
            number: pose_number(to)?,
            line,
        };
        // The measured pose, then the upper triangle of the information matrix.
        let numbers = numbers(rest, P::SIZE + D * (D + 1) / 2)?;
        let (pose, upper) = numbers.split_at(P::SIZE);
        let measured = P::from_numbers(pose).ok_or(LineError::Quaternion)?;
        let information = symmetric(upper);
        if !is_information(&information) {
            return Err(LineError::Information);
        }
        // A file may define poses after the edges that name them, so `finish` looks them up.
        self.edges.push(FileEdge {
            from,
            to,
            measured,
            information,
        });
        Ok(())
    }

    /// The graph, once all poses are known.
    fn finish(self, held: &[Reference]) -> Result<NumberedGraph<P, D>, G2oError> {
        let held = held.iter().map(|pose| index_of(*pose, &self.indices));
        let held = held.collect::<Result<_, _>>();
        let mut edges = Vec::with_capacity(self.edges.len());
        for FileEdge {
            from,
            to,
            measured,
            information,
        } in self.edges
        {
            let from = index_of(from, &self.indices)?;
            let to = index_of(to, &self.indices)?;
            edges.push(Edge {
                from,
                to,
                measured,
                information,
            });
        }
        let mut numbers = vec![0; self.poses.len()];
        for (number, index) in &self.indices {
            numbers[*index] = *number;
        }
        let graph = Graph {
            poses: self.poses,
            edges,
            priors: Vec::new(),
            held: held?,
        };
        Ok(NumberedGraph { graph, numbers })
    }
}

/// Index of a pose that a line names.
fn index_of(pose: Reference, indices: &BTreeMap<u64, usize>) -> Result<usize, G2oError> {
    let Reference { number, line } = pose;
    let problem = LineError::NoSuchPose(number);
    indices
        .get(&number)
        .copied()
        .ok_or(G2oError::Line { line, problem })
}

/// The symmetric matrix with an upper triangle, row by row.
fn symmetric<const D: usize>(upper: &[f64]) -> SMatrix<f64, D, D> {
    let mut matrix = SMatrix::zeros();
    for ((row, column), value) in upper_triangle::<D>().zip(upper) {
        matrix[(row, column)] = *value;
        matrix[(column, row)] = *value;
    }
    matrix
}

fn pose_number(word: &str) -> Result<u64, LineError> {
    word.parse().map_err(|source| LineError::PoseNumber {
        word: word.to_owned(),
        source,
    })
}

/// The finite numbers of words, of which there must be `wanted`.
fn numbers(words: &[&str], wanted: usize) -> Result<Vec<f64>, LineError> {
    if words.len() != wanted {
        return Err(LineError::Count {
            found: words.len(),
            wanted,
        });
    }
    words.iter().map(|word| finite_number(word)).collect()
}

fn finite_number(word: &str) -> Result<f64, LineError> {
    let number: f64 = word.parse().map_err(|source| LineError::NotANumber {
        word: word.to_owned(),
        source,
    })?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(LineError::NotFinite(word.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::error::Error;

    /// An error with its sources.
    fn message(error: &G2oError) -> String {
        let problem = error.source().map(|source| format!(": {source}"));
        format!("{error}{}", problem.unwrap_or_default())
    }

    fn refused(text: &str) -> String {
        message(&PoseGraph::parse(text).unwrap_err())
    }

    #[test]
    fn a_quaternion_that_overflows_is_refused() {
        let error = refused("VERTEX_SE3:QUAT 0 5 0 5 0 96e256 0.1 0");
        assert!(error.contains("the quaternion has no direction"), "{error}");
    }

    const FILE: &str = "\
# two poses
VERTEX_SE2 7 0 0 0
VERTEX_SE2 3 1.5 0 0.1
FIX 7
EDGE_SE2 7 3 1 0 0.25 2 0.5 0 2 0 3
";

    /// The file with another information matrix.
    fn with_information(numbers: &str) -> String {
        FILE.replace("2 0.5 0 2 0 3", numbers)
    }

    #[test]
    fn information_is_the_inverse_of_a_covariance() {
        assert!(PoseGraph::parse(&with_information("0 0 0 0 0 0")).is_ok());
        assert!(PoseGraph::parse(&with_information("2 0 0 2 0 0")).is_ok());
        for bad in ["2 3 0 2 0 3", "-1 0 0 2 0 3"] {
            let error = refused(&with_information(bad));
            assert!(error.starts_with("line 5: not the inverse"), "{error}");
        }
        let huge = with_information("1e308 0 0 1e308 0 1e308");
        let solved = PoseGraph::parse(&huge).unwrap().solve();
        assert!(
            solved.is_ok() || solved == Err(SolveError::NotFinite),
            "{solved:?}"
        );
    }

    #[test]
    fn a_file_is_read_solved_and_written() {
        let mut graph = PoseGraph::parse(FILE).unwrap();
        let size = GraphSize { poses: 2, edges: 1 };
        assert_eq!(graph.size(), size);
        assert!(graph.solve().unwrap().chi2 < 1e-12);
        let text = graph.to_text();
        assert!(
            text.starts_with("VERTEX_SE2 7 0 0 0\nVERTEX_SE2 3 "),
            "{text}"
        );
        assert!(
            text.ends_with("FIX 7\nEDGE_SE2 7 3 1 0 0.25 2 0.5 0 2 0 3\n"),
            "{text}"
        );
        // Sine and cosine keep an angle except for its last digit.
        let mut again = PoseGraph::parse(&text).unwrap();
        assert_eq!(again.size(), size);
        assert!(again.solve().unwrap().chi2 < 1e-12);
    }

    #[test]
    fn poses_in_space_are_written_as_they_were_read() {
        let text = "\
VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1
VERTEX_SE3:QUAT 1 1 2 3 0 0 0 1
EDGE_SE3:QUAT 0 1 1 2 3.5 0 0 0.6 0.8 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1
";
        let graph = PoseGraph::parse(text).unwrap();
        assert_eq!(graph.to_text(), text);
    }

    #[test]
    fn errors_name_the_line() {
        let mixed = "VERTEX_SE2 0 0 0 0\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0 1";
        let unknown_pose = "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 4 1 0 0 1 0 0 1 0 1";
        for (text, expected) in [
            ("VERTEX_SE2 0 0 0", "line 1: expected 3 numbers, found 2"),
            (
                "VERTEX_SE2 0 0 0 nan",
                "line 1: `nan` is not a finite number",
            ),
            ("VERTEX_SE2 0 0 0 one", "line 1: `one` is not a number"),
            (
                "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0",
                "line 2: pose 0 is defined twice",
            ),
            ("\nVERTEX_XY 0 0 0", "line 2: unknown tag `VERTEX_XY`"),
            (unknown_pose, "line 2: there is no pose 4"),
            ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0", "line 1: not a pose"),
            (mixed, "the file has poses in the plane and in space"),
            ("FIX -1", "line 1: `-1` is not the number of a pose"),
            ("", "the file has no pose"),
        ] {
            let error = refused(text);
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }

    /// Numbers that parsers and solvers fail at.
    const DIFFICULT: [&str; 7] = [
        "1e308",
        "-1e308",
        "1e-320",
        "0.5",
        "inf",
        "-0",
        "99999999999999999999",
    ];

    /// A line of a kind, mostly with the right count of numbers.
    fn line() -> impl Strategy<Value = String> {
        let number = prop_oneof![
            4 => (-3_i32..4).prop_map(|n| n.to_string()),
            1 => prop::sample::select(DIFFICULT.to_vec()).prop_map(str::to_owned),
        ];
        let kind = prop::sample::select(vec![
            ("VERTEX_SE2", 4),
            ("VERTEX_SE3:QUAT", 8),
            ("EDGE_SE2", 11),
            ("EDGE_SE3:QUAT", 30),
            ("FIX", 1),
        ]);
        let numbers = prop::collection::vec(number, 31);
        let missing = prop_oneof![9 => Just(0_usize), 1 => 0..3_usize];
        (kind, numbers, missing).prop_map(|((kind, count), numbers, missing)| {
            let count = count - missing.min(count);
            format!("{kind} {}", numbers[..count].join(" "))
        })
    }

    proptest! {
        /// Any file is read, solved and written, or refused. What was read once is read again.
        #[test]
        fn any_file_is_solved_or_refused(lines in prop::collection::vec(line(), 0..4)) {
            let lines = lines.join("\n");
            let text = format!("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n{lines}");
            if let Ok(mut graph) = PoseGraph::parse(&text) {
                let again = PoseGraph::parse(&graph.to_text());
                prop_assert_eq!(again.map(|again| again.size()), Ok(graph.size()));
                let _ = graph.solve();
            }
        }
    }
}
