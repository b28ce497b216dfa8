//! A town for tests, and a LiDAR in it.

use std::f64::consts::TAU;

use openbench_core::{Georeference, LidarPoint, LidarScan, MapPoint, Pose2, Pose3, SimTime};
use openbench_geometry::{Polygon, Segment};
use openbench_osm::{OsmData, OsmMap, Projection};

use super::chart::{Chart, Wall};
use super::stretch::{Gatherer, Stretch};
use crate::track::Track;

/// Height of all houses, metres.
const HEIGHT_M: f64 = 6.0;
/// Where the LiDAR is on the robot, metres above the ground.
pub(super) const SENSOR_M: f64 = 0.3;

/// A house about a point.
pub(super) fn block(x: f64, y: f64, width: f64, depth: f64) -> Polygon {
    let (w, d) = (width / 2.0, depth / 2.0);
    let corners = [(-w, -d), (w, -d), (w, d), (-w, d)];
    let outline = corners.map(|(dx, dy)| MapPoint::new(x + dx, y + dy));
    Polygon::new(outline.to_vec(), Vec::new()).unwrap()
}

/// Houses that differ enough to be told apart.
pub(super) fn town() -> Vec<Polygon> {
    vec![
        block(-20.0, 14.0, 12.0, 9.0),
        block(-3.0, 16.0, 9.0, 14.0),
        block(15.0, 13.0, 16.0, 8.0),
        block(-17.0, -13.0, 18.0, 7.0),
        block(4.0, -15.0, 8.0, 12.0),
        block(24.0, -12.0, 14.0, 10.0),
        block(40.0, 5.0, 8.0, 20.0),
    ]
}

/// Thirty houses along three roads, another town for each number.
pub(super) fn village(number: u64) -> Vec<Polygon> {
    let mut state = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut between = move |low: f64, high: f64| {
        // A xorshift generator (G. Marsaglia, 2003).
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut houses = Vec::new();
    for row in 0..6 {
        // Two rows along each road, which are 16 m wide.
        let y = f64::from(row / 2) * 50.0 + if row % 2 == 0 { -16.0 } else { 16.0 };
        let mut x = -70.0;
        while x < 60.0 {
            let (width, depth) = (between(7.0, 18.0), between(7.0, 14.0));
            let away = between(-2.0, 2.0);
            houses.push(block(x + width / 2.0, y + away, width, depth));
            x += width + between(3.0, 12.0);
        }
    }
    houses
}

/// A map of houses.
pub(super) fn map(houses: &[Polygon]) -> OsmMap {
    let place: Georeference = "utm:31N,-500000,0".parse().unwrap();
    let projection = Projection::new(place);
    let mut xml = String::from("<osm version=\"0.6\">");
    for (house, polygon) in houses.iter().enumerate() {
        let mut nodes = String::new();
        for (corner, at) in polygon.outer.iter().enumerate() {
            let at = projection.to_lonlat(*at);
            let id = 10 * house + corner + 1;
            xml += &format!(
                "<node id=\"{id}\" lat=\"{:.9}\" lon=\"{:.9}\"/>",
                at.lat, at.lon
            );
            nodes += &format!("<nd ref=\"{id}\"/>");
        }
        let first = 10 * house + 1;
        xml += &format!("<way id=\"{}\">{nodes}<nd ref=\"{first}\"/>", house + 1);
        xml += "<tag k=\"building\" v=\"house\"/></way>";
    }
    let data = OsmData::from_xml((xml + "</osm>").as_bytes()).unwrap();
    OsmMap::new(&data, place)
}

/// A chart of houses that stand apart from each other.
pub(super) fn chart(houses: &[Polygon]) -> Chart {
    let walls = houses
        .iter()
        .enumerate()
        .flat_map(|(building, house)| house.sides().map(move |segment| Wall { segment, building }));
    Chart {
        origin: MapPoint::default(),
        walls: walls.collect(),
        outlines: houses.to_vec(),
        buildings: (0..houses.len()).collect(),
    }
}

/// A robot that stands.
pub(super) struct Still(pub(super) Pose2);

impl Track for Still {
    fn pose3_at(&self, _: SimTime) -> Pose3 {
        self.0.to_pose3(0.0)
    }
}

/// A scan of houses and level ground.
pub(super) fn scan(houses: &[Polygon], pose: Pose2, stamp: SimTime) -> LidarScan {
    let walls: Vec<Segment> = houses.iter().flat_map(Polygon::sides).collect();
    let mut points = Vec::new();
    for i in 0..900 {
        let azimuth = f64::from(i) * TAU / 900.0;
        let end = pose.transform(80.0 * libm::cos(azimuth), 80.0 * libm::sin(azimuth));
        let ray = Segment::new(pose.point(), end);
        let shares = walls.iter().filter_map(|wall| ray.crossing(*wall));
        let nearest = shares.map(|crossing| crossing.share).fold(1.0, f64::min) * 80.0;
        for j in -7..40 {
            let slope = libm::tan(f64::from(j).to_radians());
            let to_ground = if slope < 0.0 {
                -SENSOR_M / slope
            } else {
                f64::MAX
            };
            let range = nearest.min(to_ground);
            let height = SENSOR_M + range * slope;
            if range < 45.0 && height < HEIGHT_M {
                let xyz = [
                    range * libm::cos(azimuth),
                    range * libm::sin(azimuth),
                    height - SENSOR_M,
                ];
                points.push(LidarPoint {
                    xyz: xyz.map(|value| value as f32),
                    offset_ns: 0,
                    reflectivity: 0,
                    line: 0,
                });
            }
        }
    }
    LidarScan { stamp, points }
}

/// What a robot sees at each of these poses, in an `odom` that begins at the first one.
pub(super) fn way(houses: &[Polygon], poses: &[Pose2]) -> Vec<Stretch> {
    let in_odom = |pose: Pose2| pose.seen_from(poses[0]);
    let seen = |(i, pose): (usize, &Pose2)| {
        let mut gatherer = Gatherer::new(Pose3::translation(0.0, 0.0, SENSOR_M));
        let scan = scan(houses, *pose, SimTime::ZERO);
        for _ in 0..2 {
            gatherer.take(&scan, &Still(in_odom(*pose)));
        }
        let mut stretch = gatherer.end().unwrap();
        stretch.metres = if i == 0 {
            0.0
        } else {
            poses[i - 1].point().distance(pose.point())
        };
        stretch
    };
    poses.iter().enumerate().map(seen).collect()
}

/// What a robot sees from a pose, in an `odom` that begins there.
pub(super) fn stretch_at(houses: &[Polygon], pose: Pose2) -> Stretch {
    way(houses, &[pose]).remove(0)
}
