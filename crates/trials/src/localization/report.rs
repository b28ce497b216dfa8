//! What trials found, in numbers.

use std::collections::BTreeMap;

use serde::Serialize;

use super::trial::{FixErrors, Moment, PoseErrors};

/// Places of a drive at which is asked where the robot is, metres.
const AFTER_M: [f64; 4] = [0.0, 20.0, 40.0, 60.0];
/// Legs are a little longer than five metres: of several ends, the nearest one counts.
const HALF_A_LEG_M: f64 = 2.5;
/// Limits of errors of the position, metres,
const WITHIN_M: [f64; 4] = [0.5, 1.0, 3.0, 5.0];
/// of the heading, degrees,
const WITHIN_DEG: [f64; 3] = [1.0, 2.0, 5.0];
/// and of the distance to a wall, metres.
const WITHIN_OF_WALL_M: [f64; 2] = [0.3, 0.5];
/// A fix off by more than this is wrong, metres.
const WRONG_M: f64 = 5.0;
/// 95 % quantile of chi² with three degrees of freedom.
const CHI2_95: f64 = 7.815;

/// What trials on one kind of map found. Rates are fractions of 1, null without what they count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Number of drives.
    pub n: usize,
    /// Rate of drives on which the position is right within so many metres after so many metres.
    /// A drive without an accepted fix counts as a miss.
    pub recall: BTreeMap<String, BTreeMap<String, Option<f64>>>,
    /// Rate of drives on which the heading is right within so many degrees at the end.
    pub yaw: BTreeMap<String, Option<f64>>,
    /// Errors of the position all along.
    pub along: Along,
    /// Rate of drives with an accepted pose at the end.
    pub accepted: Option<f64>,
    /// Number of accepted fixes.
    pub fixes: usize,
    /// Number of those that are off by more than 5 m.
    pub wrong_5m: usize,
    /// Rate of drives beside the map without any accepted fix; null on the map.
    pub rejected_off_map: Option<f64>,
    /// Rate of fixes inside their ellipsoid of 95 %.
    pub inside_95: Option<f64>,
    /// Mean normalized estimation error squared of fixes; 3 where covariances are right.
    pub nees_mean: Option<f64>,
    /// Rate of fixes with the distance to the nearest wall right within so many metres.
    pub wall_relative: BTreeMap<String, Option<f64>>,
    /// Computing time of an attempt while the robot is localized, milliseconds: median,
    pub ms_p50: Option<f64>,
    /// and 99 % quantile.
    pub ms_p99: Option<f64>,
    /// Computing time of an attempt while it is not, milliseconds: median,
    pub find_ms_p50: Option<f64>,
    /// and 99 % quantile.
    pub find_ms_p99: Option<f64>,
}

/// Errors of the position after all legs of all drives.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Along {
    /// Rate of legs after which a pose is accepted,
    pub located: Option<f64>,
    /// and of those after which it is right within a metre.
    pub within_1m: Option<f64>,
    /// Error of the accepted poses, metres: median,
    pub p50_m: Option<f64>,
    /// 95 % quantile,
    pub p95_m: Option<f64>,
    /// and the largest one. Null beside the map.
    pub max_m: Option<f64>,
}

impl Along {
    fn of(drives: &[Vec<Moment>]) -> Self {
        let moments = drives.iter().flatten();
        let errors: Vec<Option<f64>> = moments
            .map(|moment| moment.error.map(|error| error.metres))
            .collect();
        let known: Vec<f64> = errors.iter().copied().flatten().collect();
        let within = known.iter().filter(|error| **error <= 1.0).count();
        let finite = |error: &f64| error.is_finite();
        Self {
            located: rate(known.len(), errors.len()),
            within_1m: rate(within, errors.len()),
            p50_m: quantile(&known, 0.5).filter(finite),
            p95_m: quantile(&known, 0.95).filter(finite),
            max_m: quantile(&known, 1.0).filter(finite),
        }
    }
}

impl Report {
    /// From the moments of each drive.
    pub fn of(drives: &[Vec<Moment>], is_on_map: bool) -> Self {
        let n = drives.len();
        let at = |after: f64| {
            let last = move |drive: &Vec<Moment>| -> Option<PoseErrors> {
                let reached = drive
                    .iter()
                    .take_while(|moment| moment.metres < after + HALF_A_LEG_M);
                reached.last()?.error
            };
            drives.iter().map(last).collect::<Vec<_>>()
        };
        let recall = AFTER_M.map(|after| {
            let errors = at(after);
            let within = WITHIN_M.map(|limit| {
                let is_right = |error: &PoseErrors| error.metres <= limit;
                let count = errors
                    .iter()
                    .flatten()
                    .filter(|error| is_right(error))
                    .count();
                (limit.to_string(), rate(count, n))
            });
            (format!("{after}m"), BTreeMap::from(within))
        });
        let ends: Vec<Option<PoseErrors>> =
            drives.iter().map(|drive| drive.last()?.error).collect();
        let yaw = WITHIN_DEG.map(|limit| {
            let is_right = |error: &&PoseErrors| error.radians.to_degrees() <= limit;
            let count = ends.iter().flatten().filter(is_right).count();
            (limit.to_string(), rate(count, n))
        });
        let moments = || drives.iter().flatten();
        let fixes: Vec<FixErrors> = moments().filter_map(|moment| moment.fix).collect();
        let rejected = drives
            .iter()
            .filter(|drive| drive.iter().all(|one| one.fix.is_none()));
        let walls: Vec<f64> = fixes.iter().filter_map(|fix| fix.wall_m).collect();
        let wall_relative = WITHIN_OF_WALL_M.map(|limit| {
            let count = walls.iter().filter(|error| **error <= limit).count();
            (limit.to_string(), rate(count, walls.len()))
        });
        let sound: Vec<f64> = fixes.iter().map(|fix| fix.nees).collect();
        let (tracking, finding): (Vec<&Moment>, Vec<&Moment>) =
            moments().partition(|moment| moment.was_located);
        Self {
            n,
            recall: BTreeMap::from(recall),
            yaw: BTreeMap::from(yaw),
            along: Along::of(drives),
            accepted: rate(ends.iter().flatten().count(), n),
            fixes: fixes.len(),
            wrong_5m: fixes.iter().filter(|fix| fix.pose.metres > WRONG_M).count(),
            rejected_off_map: if is_on_map {
                None
            } else {
                rate(rejected.count(), n)
            },
            inside_95: rate(
                sound.iter().filter(|nees| **nees <= CHI2_95).count(),
                sound.len(),
            ),
            nees_mean: (is_on_map && !sound.is_empty())
                .then(|| sound.iter().sum::<f64>() / sound.len() as f64),
            wall_relative: BTreeMap::from(wall_relative),
            ms_p50: quantile(&times(&tracking), 0.5),
            ms_p99: quantile(&times(&tracking), 0.99),
            find_ms_p50: quantile(&times(&finding), 0.5),
            find_ms_p99: quantile(&times(&finding), 0.99),
        }
    }
}

impl Report {
    /// Of a method that always gives some pose: it accepts none, and rejects no map.
    pub fn of_peer(drives: &[Vec<Moment>]) -> Self {
        Self {
            rejected_off_map: None,
            ..Self::of(drives, true)
        }
    }
}

fn rate(count: usize, of: usize) -> Option<f64> {
    (of > 0).then(|| count as f64 / of as f64)
}

/// Computing times, milliseconds.
fn times(moments: &[&Moment]) -> Vec<f64> {
    moments.iter().map(|moment| moment.ms).collect()
}

/// The value that a share of them does not exceed.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let index = (share * values.len() as f64).ceil() as usize;
    values.get(index.max(1) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A moment at which the accepted pose, which is a fix, is off by so many metres.
    fn moment(metres: f64, error: Option<f64>) -> Moment {
        let pose = error.map(|metres| PoseErrors {
            metres,
            radians: 0.03,
        });
        Moment {
            metres,
            error: pose,
            fix: pose.map(|pose| FixErrors {
                pose,
                nees: pose.metres,
                wall_m: Some(0.4),
            }),
            was_located: false,
            ms: 1.0 + metres,
        }
    }

    #[test]
    fn a_drive_counts_with_the_pose_that_it_has_at_each_place() {
        let good = vec![
            moment(0.0, None),
            moment(20.2, Some(0.6)),
            moment(60.1, Some(2.0)),
        ];
        let wrong = vec![moment(0.0, Some(9.0)), moment(60.1, Some(9.0))];
        let report = Report::of(&[good, wrong], true);
        let recall = |after: &str, limit: &str| report.recall[after][limit].unwrap();
        assert_eq!(recall("0m", "5"), 0.0);
        // A pose counts until there is a newer one.
        assert_eq!((recall("20m", "1"), recall("40m", "1")), (0.5, 0.5));
        assert_eq!((recall("60m", "1"), recall("60m", "3")), (0.0, 0.5));
        assert_eq!((report.n, report.fixes, report.wrong_5m), (2, 4, 2));
        assert_eq!(
            (report.inside_95, report.nees_mean),
            (Some(0.5), Some(5.15))
        );
        let walls = (report.wall_relative["0.3"], report.wall_relative["0.5"]);
        assert_eq!(walls, (Some(0.0), Some(1.0)));
        assert_eq!((report.yaw["1"], report.yaw["2"]), (Some(0.0), Some(1.0)));
        assert_eq!((report.ms_p50, report.find_ms_p99), (None, Some(61.1)));
        // Four of five legs have a pose, and one of them is right.
        let along = Along {
            located: Some(0.8),
            within_1m: Some(0.2),
            p50_m: Some(2.0),
            p95_m: Some(9.0),
            max_m: Some(9.0),
        };
        assert_eq!(report.along, along);
    }

    #[test]
    fn beside_the_map_drives_without_a_fix_count() {
        let refused = vec![moment(0.0, None), moment(60.0, None)];
        let accepted = vec![moment(0.0, None), moment(60.0, Some(f64::INFINITY))];
        let report = Report::of(&[refused, accepted], false);
        assert_eq!((report.rejected_off_map, report.wrong_5m), (Some(0.5), 1));
        assert_eq!((report.accepted, report.nees_mean), (Some(0.5), None));
        assert_eq!(Report::of(&[], true).accepted, None);
        let peer = Report::of_peer(&[vec![moment(0.0, None), moment(60.0, None)]]);
        assert_eq!(peer.rejected_off_map, None);
    }
}
