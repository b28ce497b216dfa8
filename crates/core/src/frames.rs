//! Frames and poses, named as in ROS REP 103 and REP 105.
//!
//! - `map`: metres, x east, y north, z up, of one world. A [`Georeference`] ties it to the Earth.
//! - `odom`: like `map`, but continuous and with drift.
//! - `base_link`: x forward, y left, z up; its origin is on the ground in the middle of the robot.
//! - `livox_frame`, `camera_link`, `imu_link`, `gnss_link`: fixed to `base_link` as in
//!   [`RobotDescription`](crate::RobotDescription). `camera_link` has x forward (it is not the
//!   optical frame).

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A rigid transform in three dimensions: metres and a unit quaternion.
pub type Pose3 = nalgebra::Isometry3<f64>;

/// A point on the ground in the `map` frame, in metres.
///
/// ```
/// use openbench_core::MapPoint;
///
/// let corner = MapPoint::new(3.0, 4.0);
/// assert_eq!(corner.distance(MapPoint::new(0.0, 0.0)), 5.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct MapPoint {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
}

impl MapPoint {
    /// A point from its coordinates in metres.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Straight-line distance to `other` in metres.
    pub fn distance(self, other: Self) -> f64 {
        libm::hypot(other.x - self.x, other.y - self.y)
    }

    /// Direction from this point to `other`: radians, counter-clockwise from east.
    pub fn bearing_to(self, other: Self) -> f64 {
        libm::atan2(other.y - self.y, other.x - self.x)
    }

    /// The point `distance` metres from this one in the direction `bearing` (radians,
    /// counter-clockwise from east).
    pub fn offset(self, bearing: f64, distance: f64) -> Self {
        Self::new(
            self.x + distance * libm::cos(bearing),
            self.y + distance * libm::sin(bearing),
        )
    }
}

impl fmt::Display for MapPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:.2}, {:.2})", self.x, self.y)
    }
}

/// A position on the Earth in WGS 84, degrees.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct LonLat {
    /// Longitude, degrees east.
    pub lon: f64,
    /// Latitude, degrees north.
    pub lat: f64,
}

impl LonLat {
    /// A position from degrees east and degrees north.
    pub const fn new(lon: f64, lat: f64) -> Self {
        Self { lon, lat }
    }
}

/// A position and heading on the ground.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose2 {
    /// Metres along x of the parent frame.
    pub x: f64,
    /// Metres along y of the parent frame.
    pub y: f64,
    /// Heading, radians, counter-clockwise from the parent's x axis.
    pub yaw: f64,
}

impl Pose2 {
    /// A pose from metres, metres and radians.
    pub const fn new(x: f64, y: f64, yaw: f64) -> Self {
        Self { x, y, yaw }
    }

    /// The position without the heading.
    pub const fn point(self) -> MapPoint {
        MapPoint::new(self.x, self.y)
    }

    /// Transforms a point from this pose's frame (`forward` and `left`, metres) into the parent
    /// frame.
    pub fn transform(self, forward: f64, left: f64) -> MapPoint {
        let (sin, cos) = libm::sincos(self.yaw);
        MapPoint::new(
            self.x + cos * forward - sin * left,
            self.y + sin * forward + cos * left,
        )
    }

    /// Transforms a point from the parent frame into this pose's frame: (forward, left), metres.
    pub fn inverse_transform(self, point: MapPoint) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.yaw);
        let (dx, dy) = (point.x - self.x, point.y - self.y);
        (cos * dx + sin * dy, -sin * dx + cos * dy)
    }

    /// The composition of this pose with `relative`, which is given in this pose's frame.
    pub fn compose(self, relative: Self) -> Self {
        let p = self.transform(relative.x, relative.y);
        Self::new(p.x, p.y, wrap_angle(self.yaw + relative.yaw))
    }

    /// This pose in the frame of another one, with the same parent: the inverse of
    /// [`Pose2::compose`].
    ///
    /// ```
    /// use openbench_core::Pose2;
    ///
    /// let (robot, door) = (Pose2::new(3.0, 4.0, 0.5), Pose2::new(6.0, 8.0, 2.0));
    /// let back = robot.compose(door.seen_from(robot));
    /// assert!(back.point().distance(door.point()) < 1e-9);
    /// ```
    pub fn seen_from(self, frame: Self) -> Self {
        let (x, y) = frame.inverse_transform(self.point());
        Self::new(x, y, wrap_angle(self.yaw - frame.yaw))
    }

    /// Whether another pose is nearer than so many metres, and turned by less than so many radians.
    pub fn is_near(self, other: Self, metres: f64, radians: f64) -> bool {
        self.point().distance(other.point()) < metres
            && wrap_angle(self.yaw - other.yaw).abs() < radians
    }

    /// This pose as a transform in three dimensions, at height `z` in metres.
    pub fn to_pose3(self, z: f64) -> Pose3 {
        Pose3::new(
            nalgebra::Vector3::new(self.x, self.y, z),
            nalgebra::Vector3::z() * self.yaw,
        )
    }

    /// The horizontal part of `pose`.
    pub fn from_pose3(pose: &Pose3) -> Self {
        let t = &pose.translation.vector;
        // The heading is the direction of the x axis seen from above, whatever the tilt.
        let x_axis = pose.rotation * nalgebra::Vector3::x();
        Self::new(t.x, t.y, libm::atan2(x_axis.y, x_axis.x))
    }
}

/// The equivalent of `angle` in (-pi, pi], radians.
pub fn wrap_angle(angle: f64) -> f64 {
    let turns = libm::round(angle / std::f64::consts::TAU);
    let wrapped = angle - turns * std::f64::consts::TAU;
    // Rounding to the nearest turn leaves [-pi, pi]; -pi itself is pi.
    if wrapped <= -std::f64::consts::PI {
        wrapped + std::f64::consts::TAU
    } else {
        wrapped
    }
}

/// Projection and origin of a `map` frame on the Earth. The projections are implemented in
/// `openbench-osm`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Georeference {
    /// UTM on WGS 84: `map = (easting, northing) + offset`.
    Utm {
        /// Zone, 1 to 60.
        zone: u8,
        /// Whether northings count from the equator (northern hemisphere) or from 10,000 km south
        /// of it.
        north: bool,
        /// Added to the easting, metres.
        offset_x: f64,
        /// Added to the northing, metres.
        offset_y: f64,
    },
    /// The plane tangent to the WGS 84 ellipsoid at a point: `map = (east, north) + offset`.
    TangentPlane {
        /// The point of tangency.
        at: LonLat,
        /// Added to the metres east of that point.
        offset_x: f64,
        /// Added to the metres north of that point.
        offset_y: f64,
    },
}

/// Local origins lie on a lattice of this spacing in the plane of the projection, metres. They
/// depend on the place alone, not on the false origin of the map.
const LATTICE_M: f64 = 100.0;

impl Georeference {
    /// The tangent plane with its origin at the point of tangency.
    pub const fn tangent_plane(at: LonLat) -> Self {
        Self::TangentPlane {
            at,
            offset_x: 0.0,
            offset_y: 0.0,
        }
    }

    /// The false origin: metres that are added to the coordinates of the projection.
    pub const fn offset(&self) -> MapPoint {
        match *self {
            Self::Utm {
                offset_x, offset_y, ..
            }
            | Self::TangentPlane {
                offset_x, offset_y, ..
            } => MapPoint::new(offset_x, offset_y),
        }
    }

    /// The same projection with its origin within 71 m of `point`, which is given in this frame.
    ///
    /// Monaco in raw UTM coordinates, and the local frame near it:
    ///
    /// ```
    /// use openbench_core::{Georeference, MapPoint};
    ///
    /// let raw: Georeference = "utm:32N,0,0".parse().unwrap();
    /// let local = raw.about(MapPoint::new(373_012.0, 4_843_960.0));
    /// assert_eq!(local.to_string(), "utm:32N,-373000,-4844000");
    /// ```
    #[must_use]
    pub fn about(self, point: MapPoint) -> Self {
        let offset = self.offset();
        // Subtracted from zero, since -0 would be printed with its sign.
        let nearest = |metres: f64| 0.0 - libm::round(metres / LATTICE_M) * LATTICE_M;
        self.with_offset(MapPoint::new(
            nearest(point.x - offset.x),
            nearest(point.y - offset.y),
        ))
    }

    /// The same projection with another false origin: metres that are added to its coordinates.
    #[must_use]
    pub const fn with_offset(self, offset: MapPoint) -> Self {
        let (offset_x, offset_y) = (offset.x, offset.y);
        match self {
            Self::Utm { zone, north, .. } => Self::Utm {
                zone,
                north,
                offset_x,
                offset_y,
            },
            Self::TangentPlane { at, .. } => Self::TangentPlane {
                at,
                offset_x,
                offset_y,
            },
        }
    }

    /// The same if `point` is within `metres` of the origin, else with its origin
    /// [about](Self::about) `point`.
    #[must_use]
    pub fn near(self, point: MapPoint, metres: f64) -> Self {
        if point.distance(MapPoint::default()) <= metres {
            self
        } else {
            self.about(point)
        }
    }

    /// Distance of `point`, given in this frame, from where the projection keeps lengths, metres:
    /// from UTM's central meridian, or from the point of tangency.
    pub fn distance_from_true_scale(&self, point: MapPoint) -> f64 {
        /// Easting of UTM's central meridian, metres.
        const CENTRAL_EASTING_M: f64 = 500_000.0;
        let offset = self.offset();
        // Without the false origin, for example UTM's own easting and northing.
        let plane = MapPoint::new(point.x - offset.x, point.y - offset.y);
        match self {
            Self::Utm { .. } => (plane.x - CENTRAL_EASTING_M).abs(),
            Self::TangentPlane { .. } => plane.distance(MapPoint::default()),
        }
    }
}

/// A text that is no georeference.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "`{0}` is not a georeference; write `utm:50N,-500000,-4483000` (zone, offset added to easting \
     and northing), `tangent:LON,LAT` or `tangent:LON,LAT,X,Y` (offset added to metres east and \
     north)"
)]
pub struct GeoreferenceError(pub String);

impl FromStr for Georeference {
    type Err = GeoreferenceError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        parse_georeference(text).ok_or_else(|| GeoreferenceError(text.to_owned()))
    }
}

fn parse_georeference(text: &str) -> Option<Georeference> {
    let (kind, rest) = text.split_once(':')?;
    let fields: Vec<&str> = rest.split(',').map(str::trim).collect();
    let number = |s: &str| s.parse::<f64>().ok().filter(|v| v.is_finite());
    match (kind, fields.as_slice()) {
        ("utm", [zone, dx, dy]) => {
            let north = match zone.chars().last()? {
                'N' => true,
                'S' => false,
                _ => return None,
            };
            // The last character is `N` or `S`, one byte, so the cut is between characters.
            let zone: u8 = zone[..zone.len() - 1]
                .parse()
                .ok()
                .filter(|z| (1..=60).contains(z))?;
            Some(Georeference::Utm {
                zone,
                north,
                offset_x: number(dx)?,
                offset_y: number(dy)?,
            })
        }
        ("tangent", [lon, lat, offset @ ..]) => {
            let at = LonLat::new(number(lon)?, number(lat)?);
            let (offset_x, offset_y) = match offset {
                [] => (0.0, 0.0),
                [x, y] => (number(x)?, number(y)?),
                _ => return None,
            };
            // At a pole east and north have no direction, so the plane would have no axes.
            let on_earth = at.lon.abs() <= 180.0 && at.lat.abs() < 90.0;
            on_earth.then_some(Georeference::TangentPlane {
                at,
                offset_x,
                offset_y,
            })
        }
        _ => None,
    }
}

impl fmt::Display for Georeference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Utm {
                zone,
                north,
                offset_x,
                offset_y,
            } => {
                write!(
                    f,
                    "utm:{zone}{},{offset_x},{offset_y}",
                    if *north { 'N' } else { 'S' }
                )
            }
            // The short form without an offset, which reads back as the same.
            Self::TangentPlane {
                at,
                offset_x: 0.0,
                offset_y: 0.0,
            } => {
                write!(f, "tangent:{},{}", at.lon, at.lat)
            }
            Self::TangentPlane {
                at,
                offset_x,
                offset_y,
            } => {
                write!(f, "tangent:{},{},{offset_x},{offset_y}", at.lon, at.lat)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn georeferences_are_printed_as_they_are_parsed() {
        for text in [
            "utm:50N,-500000,-4483000",
            "utm:1S,0,0.5",
            "tangent:127.04,37.28",
            "tangent:127.04,37.28,5,-0.25",
        ] {
            assert_eq!(text.parse::<Georeference>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn broken_georeferences_are_refused_with_an_example() {
        for text in [
            "",
            "utm",
            "utm:61N,0,0",
            "utm:50,0,0",
            "utm:N,0,0",
            "utm:50N,0",
            "tangent:0,90",
            "tangent:0,9,1",
            "tangent:0,9,1,2,3",
            "utm:50N,nan,0",
            "utm:é,0,0",
        ] {
            let error = text.parse::<Georeference>().unwrap_err().to_string();
            assert!(error.contains("utm:50N"), "{error}");
        }
    }

    #[test]
    fn a_local_origin_depends_on_the_place_and_not_on_the_false_origin() {
        for moved in [0.0, 5e3, 5e5, 5e6] {
            for text in ["utm:33N,0,0", "tangent:15.6,48.4"] {
                let plane: Georeference = text.parse().unwrap();
                let shifted = plane.about(MapPoint::new(moved, -moved));
                let offset = shifted.offset();
                let point = MapPoint::new(544_633.0 + offset.x, 5_362_345.0 + offset.y);
                let local = shifted.about(point);
                assert_eq!(local, plane.about(MapPoint::new(544_633.0, 5_362_345.0)));
                let near =
                    MapPoint::new(544_633.0 + local.offset().x, 5_362_345.0 + local.offset().y);
                assert!(near.distance(MapPoint::default()) < 71.0, "{near}");
            }
        }
    }

    #[test]
    fn a_pose_and_its_inverse_cancel() {
        let pose = Pose2::new(3.0, -2.0, 2.5);
        let p = pose.transform(1.0, 0.25);
        let (forward, left) = pose.inverse_transform(p);
        assert!((forward - 1.0).abs() < 1e-12 && (left - 0.25).abs() < 1e-12);
        let back = Pose2::from_pose3(&pose.to_pose3(0.4));
        assert!((back.yaw - pose.yaw).abs() < 1e-12);
    }

    #[test]
    fn angles_wrap_into_one_turn() {
        use std::f64::consts::PI;
        assert!((wrap_angle(3.0 * PI) - PI).abs() < 1e-12);
        assert!((wrap_angle(-PI) - PI).abs() < 1e-12);
        assert!((wrap_angle(-7.0) - (-7.0 + 2.0 * PI)).abs() < 1e-12);
    }
}
