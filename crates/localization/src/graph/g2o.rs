//! Pose graphs as g2o's text files.
//!
//! R. Kümmerle, G. Grisetti, H. Strasdat, K. Konolige, W. Burgard, *g2o: A General Framework for Graph Optimization*, 2011. Read and written are `VERTEX_SE2`, `EDGE_SE2`,
//! `VERTEX_SE3:QUAT`, `EDGE_SE3:QUAT` and `FIX`. As GTSAM reads them, the information about a rotation in space is that about its logarithm.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use nalgebra::{Isometry2, Isometry3, Quaternion, SMatrix, Translation3, UnitQuaternion, Vector2};

use super::pose::Pose;
use super::problem::{Edge, Graph, is_information};

/// A graph of a file, with the numbers that its poses have there.
#[derive(Debug, Clone, PartialEq)]
pub enum PoseGraph {
    /// In the plane.
    Plane(Graph<Isometry2<f64>, 3>, Vec<u64>),
    /// In space.
    Space(Graph<Isometry3<f64>, 6>, Vec<u64>),
}

/// What is wrong with a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum G2oError {
    /// A line is not as it should be.
    #[error("line {line}: {what}")]
    Line {
        /// Which, from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// Poses in the plane and in space.
    #[error("the file has poses in the plane and in space; give one of them")]
    Mixed,
    /// No pose.
    #[error("the file has no VERTEX_SE2 and no VERTEX_SE3:QUAT")]
    Empty,
}

impl PoseGraph {
    /// Reads a file's text.
    pub fn parse(text: &str) -> Result<Self, G2oError> {
        let (mut plane, mut space) = (Part::default(), Part::default());
        let mut held = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let error = |what: String| G2oError::Line {
                line: number + 1,
                what,
            };
            let mut words = line.split_whitespace();
            let Some(tag) = words.next().filter(|tag| !tag.starts_with('#')) else {
                continue;
            };
            let words: Vec<&str> = words.collect();
            match tag {
                "VERTEX_SE2" => plane.vertex(&words, 3, flat),
                "VERTEX_SE3:QUAT" => space.vertex(&words, 7, solid),
                "EDGE_SE2" => plane.edge(&words, 3, flat, number + 1),
                "EDGE_SE3:QUAT" => space.edge(&words, 7, solid, number + 1),
                "FIX" => words
                    .iter()
                    .try_for_each(|word| id(word).map(|id| held.push((id, number + 1)))),
                _ => Err(format!(
                    "`{tag}` is none of VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX"
                )),
            }
            .map_err(error)?;
        }
        match (plane.ids.is_empty(), space.ids.is_empty()) {
            (false, true) => plane
                .finish(&held)
                .map(|(graph, ids)| Self::Plane(graph, ids)),
            (true, false) => space
                .finish(&held)
                .map(|(graph, ids)| Self::Space(graph, ids)),
            (true, true) => Err(G2oError::Empty),
            (false, false) => Err(G2oError::Mixed),
        }
    }

    /// Numbers of poses and of edges.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Plane(graph, _) => (graph.poses.len(), graph.edges.len()),
            Self::Space(graph, _) => (graph.poses.len(), graph.edges.len()),
        }
    }

    /// Solves it, see [`Graph::solve`].
    pub fn solve(&mut self) -> Result<super::Solved, super::SolveError> {
        match self {
            Self::Plane(graph, _) => graph.solve(),
            Self::Space(graph, _) => graph.solve(),
        }
    }

    /// The text of a file.
    pub fn to_text(&self) -> String {
        match self {
            Self::Plane(graph, ids) => write(graph, ids, ["VERTEX_SE2", "EDGE_SE2"], |pose| {
                let distance = pose.distance();
                distance.iter().copied().collect()
            }),
            Self::Space(graph, ids) => {
                write(graph, ids, ["VERTEX_SE3:QUAT", "EDGE_SE3:QUAT"], |pose| {
                    pose.translation
                        .vector
                        .iter()
                        .chain(pose.rotation.coords.iter())
                        .copied()
                        .collect()
                })
            }
        }
    }
}

fn write<P, const D: usize>(
    graph: &Graph<P, D>,
    ids: &[u64],
    tags: [&str; 2],
    numbers: impl Fn(&P) -> Vec<f64>,
) -> String {
    let mut text = String::new();
    let put = |text: &mut String, values: &[f64]| {
        values.iter().for_each(|x| {
            let _ = write!(text, " {x}");
        })
    };
    for (pose, id) in graph.poses.iter().zip(ids) {
        let _ = write!(text, "{} {id}", tags[0]);
        put(&mut text, &numbers(pose));
        text.push('\n');
    }
    for held in &graph.held {
        let _ = writeln!(text, "FIX {}", ids[*held]);
    }
    for edge in &graph.edges {
        let _ = write!(text, "{} {} {}", tags[1], ids[edge.from], ids[edge.to]);
        put(&mut text, &numbers(&edge.measured));
        let upper: Vec<f64> = (0..D)
            .flat_map(|i| (i..D).map(move |j| (i, j)))
            .map(|at| edge.information[at])
            .collect();
        put(&mut text, &upper);
        text.push('\n');
    }
    text
}

/// An edge as it stands in a file: the numbers of its poses, and its line.
type Named<P, const D: usize> = (Edge<P, D>, [u64; 2], usize);

/// Poses and edges of one kind.
struct Part<P, const D: usize> {
    ids: BTreeMap<u64, usize>,
    poses: Vec<P>,
    edges: Vec<Named<P, D>>,
}

impl<P, const D: usize> Default for Part<P, D> {
    fn default() -> Self {
        Self {
            ids: BTreeMap::new(),
            poses: Vec::new(),
            edges: Vec::new(),
        }
    }
}

impl<P: Pose<D>, const D: usize> Part<P, D> {
    fn vertex(
        &mut self,
        words: &[&str],
        size: usize,
        pose: fn(&[f64]) -> Option<P>,
    ) -> Result<(), String> {
        let [name, rest @ ..] = words else {
            return Err("the pose has no number".into());
        };
        let id = id(name)?;
        let numbers = numbers(rest, size)?;
        if self.ids.insert(id, self.poses.len()).is_some() {
            return Err(format!("pose {id} was there before"));
        }
        self.poses
            .push(pose(&numbers).ok_or("that is no pose: the quaternion is none")?);
        Ok(())
    }

    fn edge(
        &mut self,
        words: &[&str],
        size: usize,
        pose: fn(&[f64]) -> Option<P>,
        line: usize,
    ) -> Result<(), String> {
        let [from, to, rest @ ..] = words else {
            return Err("the edge does not say between which poses".into());
        };
        let ends = [id(from)?, id(to)?];
        let numbers = numbers(rest, size + D * (D + 1) / 2)?;
        let measured = pose(&numbers[..size]).ok_or("that is no pose: the quaternion is none")?;
        let mut information = SMatrix::<f64, D, D>::zeros();
        let upper = (0..D).flat_map(|i| (i..D).map(move |j| (i, j)));
        for ((i, j), value) in upper.zip(&numbers[size..]) {
            (information[(i, j)], information[(j, i)]) = (*value, *value);
        }
        if !is_information(&information) {
            return Err("that is no information: it is not positive along all directions".into());
        }
        self.edges.push((
            Edge {
                from: 0,
                to: 0,
                measured,
                information,
            },
            ends,
            line,
        ));
        Ok(())
    }

    fn finish(self, held: &[(u64, usize)]) -> Result<(Graph<P, D>, Vec<u64>), G2oError> {
        let find = |id: u64, line: usize| {
            let what = || format!("pose {id} is named, but the file has none of that number");
            self.ids
                .get(&id)
                .copied()
                .ok_or_else(|| G2oError::Line { line, what: what() })
        };
        let edges = self.edges.into_iter().map(|(edge, [from, to], line)| {
            Ok(Edge {
                from: find(from, line)?,
                to: find(to, line)?,
                ..edge
            })
        });
        let edges = edges.collect::<Result<_, G2oError>>()?;
        let held = held
            .iter()
            .map(|(id, line)| find(*id, *line))
            .collect::<Result<_, _>>()?;
        let mut ids = vec![0; self.poses.len()];
        self.ids.iter().for_each(|(id, at)| ids[*at] = *id);
        Ok((
            Graph {
                poses: self.poses,
                edges,
                priors: Vec::new(),
                held,
            },
            ids,
        ))
    }
}

fn id(word: &str) -> Result<u64, String> {
    word.parse()
        .map_err(|_| format!("`{word}` is no number of a pose"))
}

fn numbers(words: &[&str], size: usize) -> Result<Vec<f64>, String> {
    if words.len() != size {
        return Err(format!(
            "there are {} numbers where {size} are wanted",
            words.len()
        ));
    }
    let number = |word: &&str| {
        word.parse()
            .ok()
            .filter(|x: &f64| x.is_finite())
            .ok_or_else(|| format!("`{word}` is no number"))
    };
    words.iter().map(number).collect()
}

fn flat(n: &[f64]) -> Option<Isometry2<f64>> {
    Some(Isometry2::new(Vector2::new(n[0], n[1]), n[2]))
}

fn solid(n: &[f64]) -> Option<Isometry3<f64>> {
    let rotation = UnitQuaternion::try_new(Quaternion::new(n[6], n[3], n[4], n[5]), 1e-6)?;
    // The square of a large number is none.
    let rotation = Some(rotation).filter(|rotation| (rotation.norm() - 1.0).abs() < 1e-6)?;
    Some(Isometry3::from_parts(
        Translation3::new(n[0], n[1], n[2]),
        rotation,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_quaternion_that_overflows_is_refused() {
        let error = PoseGraph::parse("VERTEX_SE3:QUAT 0 5 0 5 0 96e256 0.1 0").unwrap_err();
        assert!(
            error.to_string().contains("the quaternion is none"),
            "{error}"
        );
    }

    #[test]
    fn information_is_of_a_covariance() {
        let file = |numbers: &str| FILE.replace("2 0.5 0 2 0 3", numbers);
        assert!(
            PoseGraph::parse(&file("0 0 0 0 0 0")).is_ok()
                && PoseGraph::parse(&file("2 0 0 2 0 0")).is_ok()
        );
        for bad in ["2 3 0 2 0 3", "-1 0 0 2 0 3"] {
            let error = PoseGraph::parse(&file(bad)).unwrap_err().to_string();
            assert!(
                error.contains("line 5") && error.contains("not positive"),
                "{error}"
            );
        }
        let error = PoseGraph::parse(&file("1e308 0 0 1e308 0 1e308"))
            .unwrap()
            .solve();
        assert!(
            error.is_ok() || error == Err(super::super::SolveError::NotFinite),
            "{error:?}"
        );
    }

    const FILE: &str = "\
# two poses
VERTEX_SE2 7 0 0 0
VERTEX_SE2 3 1.5 0 0.1
FIX 7
EDGE_SE2 7 3 1 0 0.25 2 0.5 0 2 0 3
";

    #[test]
    fn a_file_is_read_solved_and_written() {
        let mut graph = PoseGraph::parse(FILE).unwrap();
        assert_eq!(graph.size(), (2, 1));
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
        // Through sine and cosine an angle comes back but for its last digit.
        let mut again = PoseGraph::parse(&text).unwrap();
        assert_eq!(
            (again.size(), again.solve().unwrap().chi2 < 1e-12),
            ((2, 1), true)
        );
    }

    #[test]
    fn poses_in_space_come_back_as_they_were() {
        let identity = "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
        let text = format!(
            "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 2 3 0 0 0 1\nEDGE_SE3:QUAT 0 1 1 2 3.5 0 0 0.6 0.8 {identity}\n"
        );
        let graph = PoseGraph::parse(&text).unwrap();
        assert_eq!(graph.to_text(), text);
    }

    #[test]
    fn bad_files_are_told_by_line() {
        for (text, what) in [
            (
                "VERTEX_SE2 0 0 0",
                "line 1: there are 2 numbers where 3 are wanted",
            ),
            ("VERTEX_SE2 0 0 0 nan", "line 1: `nan` is no number"),
            (
                "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0",
                "line 2: pose 0 was there before",
            ),
            ("\nVERTEX_XY 0 0 0", "line 2: `VERTEX_XY` is none of"),
            (
                "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 4 1 0 0 1 0 0 1 0 1",
                "line 2: pose 4 is named",
            ),
            ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0", "line 1: that is no pose"),
            (
                "VERTEX_SE2 0 0 0 0\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0 1",
                "the file has poses in the plane and in space",
            ),
            ("FIX -1", "line 1: `-1` is no number of a pose"),
            ("", "the file has no VERTEX_SE2"),
        ] {
            let told = PoseGraph::parse(text).unwrap_err().to_string();
            assert!(told.starts_with(what), "{text}: {told}");
        }
    }

    /// A line of a kind with numbers that are mostly of the right count.
    fn line() -> impl Strategy<Value = String> {
        let number = prop_oneof![
            4 => (-3_i32..4).prop_map(|n| n.to_string()),
            1 => prop::sample::select(vec!["1e308", "-1e308", "1e-320", "0.5", "inf", "-0", "99999999999999999999"]).prop_map(str::to_owned),
        ];
        let kind = prop::sample::select(vec![
            ("VERTEX_SE2", 4),
            ("VERTEX_SE3:QUAT", 8),
            ("EDGE_SE2", 11),
            ("EDGE_SE3:QUAT", 30),
            ("FIX", 1),
        ]);
        (
            kind,
            prop::collection::vec(number, 31),
            prop_oneof![9 => Just(0_usize), 1 => 0..3_usize],
        )
            .prop_map(|((kind, count), numbers, off)| {
                format!("{kind} {}", numbers[..count - off.min(count)].join(" "))
            })
    }

    proptest! {
        /// Whatever stands in a file, it is read, solved and written, or refused; what was read once is read again.
        #[test]
        fn no_file_breaks_it(lines in prop::collection::vec(line(), 0..4)) {
            let text = format!("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n{}", lines.join("\n"));
            if let Ok(mut graph) = PoseGraph::parse(&text) {
                let size = graph.size();
                prop_assert_eq!(PoseGraph::parse(&graph.to_text()).map(|again| again.size()), Ok(size));
                let _ = graph.solve();
            }
        }
    }
}
