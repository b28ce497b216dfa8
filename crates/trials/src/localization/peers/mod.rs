//! Other ways to find out where the robot is, for comparison. Each gets the same stretches, map and
//! start as the locator, and always says some pose.
//!
//! | module | the way |
//! |---|---|
//! | `peer` | what every way has, and what they share |
//! | `odometry` | the start as it is given, carried on by odometry |
//! | `icp` | points of facades aligned with outlines, from the start on |
//! | `particles` | Monte Carlo localization with a likelihood field, as in AMCL |
//! | `program` | a program of one's own, which gets lines of JSON |
//!
//! Their constants are first values from the literature and were not tuned.

mod icp;
mod odometry;
mod particles;
mod peer;
mod program;

use std::path::PathBuf;
use std::time::Instant;

use openbench_bench::run::threads;
use openbench_core::Start;
use openbench_osm::OsmMap;

use self::icp::Icp;
use self::odometry::Odometry;
use self::particles::Particles;
pub use self::peer::PeerError;
use self::peer::{Peer, guess};
use self::program::Program;
use super::cases::Case;
use super::trial::{Moment, PoseErrors, pose_errors};

/// The ways that there are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PeerKind {
    /// The start, carried on by odometry.
    Odometry,
    /// Points aligned with outlines.
    Icp,
    /// Monte Carlo localization.
    Particles,
    /// A program of one's own.
    Program(PathBuf),
}

impl PeerKind {
    /// Those that are no programs of one's own.
    pub const BUILT_IN: [Self; 3] = [Self::Odometry, Self::Icp, Self::Particles];

    /// As in results.
    pub fn name(&self) -> String {
        match self {
            Self::Odometry => "odometry".into(),
            Self::Icp => "icp".into(),
            Self::Particles => "particles".into(),
            Self::Program(path) => {
                let stem = path.file_stem().unwrap_or_default();
                format!("program:{}", stem.to_string_lossy())
            }
        }
    }

    fn begin(&self, map: &OsmMap, start: &Start, seed: u64) -> Result<Box<dyn Peer>, PeerError> {
        Ok(match self {
            Self::Odometry => Box::new(Odometry::new(guess(map, start))),
            Self::Icp => Box::new(Icp::new(map, start)),
            Self::Particles => Box::new(Particles::new(map, start, seed)),
            Self::Program(path) => Box::new(Program::new(path, map, start)?),
        })
    }
}

/// Localizes the robot on the drives of all cases in this way.
///
/// # Errors
/// [`PeerError`] of a program of one's own.
pub fn peer_trials(
    kind: &PeerKind,
    cases: &[Case<'_>],
    threads: usize,
) -> Result<Vec<Vec<Moment>>, PeerError> {
    let one = |i: usize| trial(kind, &cases[i], i as u64);
    threads::each(0..cases.len(), threads, one, Ok)
}

fn trial(kind: &PeerKind, case: &Case<'_>, seed: u64) -> Result<Vec<Moment>, PeerError> {
    let mut peer = kind.begin(&case.map.map, &case.start, seed)?;
    let mut moments = Vec::new();
    for shown in case.drive.shown() {
        let began = Instant::now();
        let pose = peer.take(&shown.seen.stretch)?;
        let ms = began.elapsed().as_secs_f64() * 1e3;
        let truth = case.on_map(shown.seen.truth);
        let error = truth.map_or(PoseErrors::ELSEWHERE, |truth| pose_errors(pose, truth));
        moments.push(Moment {
            metres: shown.metres,
            error: Some(error),
            fix: None,
            was_located: !shown.is_first,
            ms,
        });
    }
    Ok(moments)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use openbench_core::{Georeference, LonLat, MapPoint, Pose2};
    use openbench_localization::registration::{Facade, Stretch};
    use openbench_osm::OsmData;

    use super::*;

    /// An L of two houses, 20 m by 10 m and 10 m by 20 m, south of the equator's origin.
    fn map() -> OsmMap {
        let node = |id: u32, x: f64, y: f64| {
            let degrees = |metres: f64| metres / 111_319.49;
            let (lat, lon) = (degrees(y), degrees(x));
            format!(r#"<node id="{id}" lat="{lat:.9}" lon="{lon:.9}"/>"#)
        };
        let house = |id: u32, x: f64, y: f64, width: f64, depth: f64| {
            let corners = [
                (x, y),
                (x + width, y),
                (x + width, y + depth),
                (x, y + depth),
            ];
            let nodes = (id..).zip(corners).map(|(id, (x, y))| node(id, x, y));
            let refs = (id..id + 4)
                .chain([id])
                .map(|id| format!(r#"<nd ref="{id}"/>"#));
            format!(
                r#"{}<way id="{id}">{}<tag k="building" v="yes"/></way>"#,
                nodes.collect::<String>(),
                refs.collect::<String>()
            )
        };
        let houses = house(10, 0.0, 10.0, 20.0, 10.0) + &house(20, 30.0, -10.0, 10.0, 17.0);
        let xml = format!(r#"<osm version="0.6">{houses}</osm>"#);
        let data = OsmData::from_xml(xml.as_bytes()).unwrap();
        let origin = LonLat::new(0.0, 0.0);
        OsmMap::new(&data, Georeference::tangent_plane(origin))
    }

    /// What a robot sees of the walls that face it; its odometry is turned by a quarter.
    fn stretch(map: &OsmMap, truth: Pose2, metres: f64) -> Stretch {
        let south = |i: u32| MapPoint::new(0.25 + 0.5 * f64::from(i), 10.0);
        let west = |i: u32| MapPoint::new(30.0, -9.75 + 0.5 * f64::from(i));
        let turned = |at: MapPoint| MapPoint::new(at.y, -at.x);
        let facade = |at: MapPoint| Facade {
            at: turned(at),
            facing: 0.0,
            views: 1,
        };
        assert_eq!(map.buildings.len(), 2);
        let end = turned(truth.point());
        Stretch {
            end: Pose2::new(end.x, end.y, truth.yaw - FRAC_PI_2),
            metres,
            drift: [[0.0; 3]; 3],
            facades: (0..40)
                .map(south)
                .chain((0..34).map(west))
                .map(facade)
                .collect(),
            panoramas: Vec::new(),
        }
    }

    #[test]
    fn both_peers_correct_a_start_that_is_off_and_odometry_does_not() {
        let map = map();
        let start = Start::Pose {
            pose: Pose2::new(6.5, 3.5, 0.05),
            covariance: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 0.01]],
        };
        let error = |kind: PeerKind| {
            let mut peer = kind.begin(&map, &start, 1).unwrap();
            let mut error = f64::INFINITY;
            for i in 0..4 {
                let truth = Pose2::new(5.0 + 5.0 * f64::from(i), 2.0, 0.0);
                let pose = peer.take(&stretch(&map, truth, 5.0)).unwrap();
                error = pose.point().distance(truth.point());
            }
            error
        };
        assert!(error(PeerKind::Odometry) > 2.0);
        let (icp, particles) = (error(PeerKind::Icp), error(PeerKind::Particles));
        assert!(icp < 0.1, "{icp}");
        assert!(particles < 0.8, "{particles}");
    }

    #[cfg(unix)]
    #[test]
    fn a_program_says_the_pose_or_what_it_did_instead() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.sh");
        let said = |script: &str| {
            std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
            std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).unwrap();
            let kind = PeerKind::Program(path.clone());
            assert_eq!(kind.name(), "program:mine");
            let mut peer = kind.begin(&map(), &Start::Anywhere, 1)?;
            peer.take(&stretch(&map(), Pose2::default(), 5.0))
        };
        let pose = said("read begin; echo; read stretch; echo '{\"pose\": [1, 2, 0.5]}'; read end");
        assert_eq!(pose.unwrap(), Pose2::new(1.0, 2.0, 0.5));
        let error = said("read begin; echo; read stretch; echo here; read end").unwrap_err();
        assert!(error.to_string().contains("`here` is no pose"), "{error}");
        let error = said("read begin").unwrap_err();
        assert!(error.to_string().contains("mine.sh: no answer"), "{error}");
        let missing = PeerKind::Program(folder.path().join("nothing"));
        assert!(missing.begin(&map(), &Start::Anywhere, 1).is_err());
    }

    #[test]
    fn without_buildings_they_stay_with_the_start() {
        let nothing = OsmMap::new(
            &OsmData::default(),
            Georeference::tangent_plane(LonLat::new(0.0, 0.0)),
        );
        let start = Pose2::new(5.0, 2.0, 0.0);
        for kind in PeerKind::BUILT_IN {
            let mut peer = kind.begin(&nothing, &Start::exact(start), 1).unwrap();
            let pose = peer.take(&stretch(&map(), start, 0.0)).unwrap();
            assert!(
                pose.point().distance(start.point()) < 0.5,
                "{}",
                kind.name()
            );
        }
    }
}
