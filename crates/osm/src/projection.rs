//! Projections between degrees and metres of the `map` frame.
//!
//! Universal Transverse Mercator uses Krüger's series to the sixth power of the third flattening
//! (C. F. F. Karney, *Transverse Mercator with an accuracy of a few nanometers*, J. Geodesy 85,
//! 2011, equations 7 to 36). Errors stay below a micrometre within a zone and far beyond it. UTM
//! zones are plain six-degree strips; the wider ones off Norway and Svalbard must be requested by
//! name.
//!
//! The tangent plane is the plane of the local east-north-up frame that touches the WGS 84
//! ellipsoid at the map's origin. Positions on the ellipsoid are projected along the origin's
//! vertical, so that lengths shrink by one part in a million some 9 km away.

use openbench_core::{Georeference, LonLat, MapPoint};

use crate::data::OsmData;

/// Equatorial radius of WGS 84, metres.
const EQUATORIAL_RADIUS_M: f64 = 6_378_137.0;
/// Flattening of WGS 84.
const F: f64 = 1.0 / 298.257_223_563;
/// Squared eccentricity.
const E2: f64 = F * (2.0 - F);
/// UTM's scale on the central meridian.
const SCALE: f64 = 0.9996;
/// UTM's easting of the central meridian, metres.
const FALSE_EASTING_M: f64 = 500_000.0;
/// UTM's northing of the equator in the southern hemisphere, metres.
const FALSE_NORTHING_SOUTH_M: f64 = 10_000_000.0;

/// Projects positions on the Earth into the `map` frame of one georeference.
///
/// ```
/// use openbench_core::{Georeference, LonLat};
/// use openbench_osm::Projection;
///
/// // A pavement on the Ajou campus, 1 km from the origin of the frame.
/// let georeference = Georeference::tangent_plane(LonLat::new(127.0457, 37.2823));
/// let projection = Projection::new(georeference);
/// let pavement = LonLat::new(127.05, 37.29);
/// let point = projection.to_map(pavement);
/// assert!((point.x - 381.2917).abs() < 1e-4 && (point.y - 854.5779).abs() < 1e-4);
/// let back = projection.to_lonlat(point);
/// assert!((back.lon - pavement.lon).abs() < 1e-9 && (back.lat - pavement.lat).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Projection {
    georeference: Georeference,
    plane: Plane,
}

#[derive(Debug, Clone, PartialEq)]
enum Plane {
    Utm(Utm),
    Tangent(Tangent),
}

/// A map without a position on the Earth.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectionError {
    /// The map has no nodes.
    #[error(
        "the map has no nodes, so its position is unknown; \
         give a georeference such as `utm:50N,-500000,-4483000`"
    )]
    Empty,
}

impl Projection {
    /// The projection that `georeference` describes.
    pub fn new(georeference: Georeference) -> Self {
        let plane = match georeference {
            Georeference::Utm {
                zone,
                north,
                offset_x,
                offset_y,
            } => {
                let south = if north { 0.0 } else { FALSE_NORTHING_SOUTH_M };
                Plane::Utm(Utm::new(zone, FALSE_EASTING_M + offset_x, south + offset_y))
            }
            Georeference::TangentPlane {
                at,
                offset_x,
                offset_y,
            } => Plane::Tangent(Tangent::new(at, MapPoint::new(offset_x, offset_y))),
        };
        Self {
            georeference,
            plane,
        }
    }

    /// The georeference that it was made from.
    pub fn georeference(&self) -> Georeference {
        self.georeference
    }

    /// The point of the `map` frame at a position on the Earth.
    pub fn to_map(&self, position: LonLat) -> MapPoint {
        match &self.plane {
            Plane::Utm(utm) => utm.forward(position),
            Plane::Tangent(tangent) => tangent.forward(position),
        }
    }

    /// The position on the ellipsoid at a point of the `map` frame.
    pub fn to_lonlat(&self, point: MapPoint) -> LonLat {
        match &self.plane {
            Plane::Utm(utm) => utm.inverse(point),
            Plane::Tangent(tangent) => tangent.inverse(point),
        }
    }
}

/// The default georeference of a map: the UTM zone of the centre of its nodes' bounding box, with
/// that centre, rounded to the nearest kilometre, as false origin.
///
/// # Errors
/// If the map has no nodes.
pub fn default_georeference(data: &OsmData) -> Result<Georeference, ProjectionError> {
    let middle = middle(data).ok_or(ProjectionError::Empty)?;
    // 180 degrees east would be zone 61.
    let zone = (libm::floor((middle.lon + 180.0) / 6.0) as u8 + 1).min(60);
    let north = middle.lat >= 0.0;
    let utm = Projection::new(Georeference::Utm {
        zone,
        north,
        offset_x: 0.0,
        offset_y: 0.0,
    })
    .to_map(middle);
    // Near the origin coordinates are short to read, and whole kilometres keep UTM's digits below
    // them.
    let offset_x = to_nearest_kilometre(utm.x);
    let offset_y = to_nearest_kilometre(utm.y);
    Ok(Georeference::Utm {
        zone,
        north,
        offset_x,
        offset_y,
    })
}

/// The centre of the bounding box of all nodes.
fn middle(data: &OsmData) -> Option<LonLat> {
    let lon = middle_of(data.nodes.values().map(|node| node.position.lon))?;
    let lat = middle_of(data.nodes.values().map(|node| node.position.lat))?;
    Some(LonLat::new(lon, lat))
}

/// Half-way between the least and the greatest value; `None` if there are no values.
fn middle_of(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let low = values.clone().reduce(|low, value| value.min(low))?;
    let high = values.reduce(|high, value| value.max(high))?;
    Some((low + high) / 2.0)
}

/// The multiple of 1,000 m whose addition moves `metres` to within 500 m of zero.
fn to_nearest_kilometre(metres: f64) -> f64 {
    -libm::round(metres / 1000.0) * 1000.0
}

/// One UTM zone with a false origin.
#[derive(Debug, Clone, PartialEq)]
struct Utm {
    central_meridian: f64,
    origin: MapPoint,
    /// Rectifying radius times the scale, metres.
    radius: f64,
    alpha: [f64; 6],
    beta: [f64; 6],
}

impl Utm {
    fn new(zone: u8, x: f64, y: f64) -> Self {
        // The third flattening, in whose powers the series are.
        let n = F / (2.0 - F);
        let n2 = n * n;
        // Equation (14)
        let rectifying = EQUATORIAL_RADIUS_M / (1.0 + n)
            * (1.0 + n2 * (1.0 / 4.0 + n2 * (1.0 / 64.0 + n2 / 256.0)));
        Self {
            // Zone 1 begins at 180 degrees west; its middle is 3 degrees on.
            central_meridian: f64::from(zone) * 6.0 - 183.0,
            origin: MapPoint::new(x, y),
            radius: SCALE * rectifying,
            alpha: polynomials(&ALPHA, n),
            beta: polynomials(&BETA, n),
        }
    }

    fn forward(&self, position: LonLat) -> MapPoint {
        let (sin_lon, cos_lon) = libm::sincos((position.lon - self.central_meridian).to_radians());
        // At a pole the tangent is large but finite, because pi / 2 is no `f64`.
        let tau = conformal(libm::tan(position.lat.to_radians()));
        // Equation (10)
        let xi = libm::atan2(tau, cos_lon);
        let eta = libm::asinh(sin_lon / libm::hypot(tau, cos_lon));
        // Equation (11)
        let [dx, dy] = series(&self.alpha, xi, eta);
        MapPoint::new(
            self.radius * (eta + dx) + self.origin.x,
            self.radius * (xi + dy) + self.origin.y,
        )
    }

    fn inverse(&self, point: MapPoint) -> LonLat {
        let eta = (point.x - self.origin.x) / self.radius;
        let xi = (point.y - self.origin.y) / self.radius;
        // Equation (15)
        let [dx, dy] = series(&self.beta, xi, eta);
        // Equation (18)
        let (sin, cos) = libm::sincos(xi - dy);
        let sinh = libm::sinh(eta - dx);
        let tau = geographic(sin / libm::hypot(sinh, cos));
        let lon = libm::atan2(sinh, cos).to_degrees() + self.central_meridian;
        LonLat::new(lon, libm::atan(tau).to_degrees())
    }
}

/// The sums over j of `c_j cos(2 j xi) sinh(2 j eta)` and `c_j sin(2 j xi) cosh(2 j eta)`. The
/// multiples come from the addition theorems, at a fifth of the cost of calling the functions for
/// each.
fn series(coefficients: &[f64; 6], xi: f64, eta: f64) -> [f64; 2] {
    let (sin1, cos1) = libm::sincos(2.0 * xi);
    let (sinh1, cosh1) = (libm::sinh(2.0 * eta), libm::cosh(2.0 * eta));
    let (mut sin, mut cos, mut sinh, mut cosh) = (sin1, cos1, sinh1, cosh1);
    let (mut x, mut y) = (0.0, 0.0);
    for c in coefficients {
        x += c * cos * sinh;
        y += c * sin * cosh;
        // From the multiple 2j to 2(j + 1).
        (sin, cos) = (sin * cos1 + cos * sin1, cos * cos1 - sin * sin1);
        (sinh, cosh) = (sinh * cosh1 + cosh * sinh1, cosh * cosh1 + sinh * sinh1);
    }
    [x, y]
}

/// Tangent of the conformal latitude from that of the geographic latitude, equations (7) to (9).
fn conformal(tau: f64) -> f64 {
    let e = E2.sqrt();
    let hypotenuse = libm::hypot(1.0, tau);
    let sigma = libm::sinh(e * libm::atanh(e * tau / hypotenuse));
    tau * libm::hypot(1.0, sigma) - sigma * hypotenuse
}

/// The inverse of [`conformal`] by Newton's method, equations (19) to (21). Two or three steps
/// reach the last bit.
fn geographic(conformal_tau: f64) -> f64 {
    let mut tau = conformal_tau;
    for _ in 0..5 {
        let now = conformal(tau);
        let slope = (1.0 + (1.0 - E2) * tau * tau) / ((1.0 - E2) * libm::hypot(1.0, tau));
        tau += (conformal_tau - now) / libm::hypot(1.0, now) * slope;
    }
    tau
}

/// The values at `n` of polynomials that begin with `n`, `n²`, …
fn polynomials(coefficients: &[&[f64]; 6], n: f64) -> [f64; 6] {
    let mut power = 1.0;
    coefficients.map(|row| {
        power *= n;
        // Horner's scheme.
        power * row.iter().rev().fold(0.0, |sum, c| sum * n + c)
    })
}

/// Equation (35).
const ALPHA: [&[f64]; 6] = [
    &[
        1.0 / 2.0,
        -2.0 / 3.0,
        5.0 / 16.0,
        41.0 / 180.0,
        -127.0 / 288.0,
        7891.0 / 37800.0,
    ],
    &[
        13.0 / 48.0,
        -3.0 / 5.0,
        557.0 / 1440.0,
        281.0 / 630.0,
        -1983433.0 / 1935360.0,
    ],
    &[
        61.0 / 240.0,
        -103.0 / 140.0,
        15061.0 / 26880.0,
        167603.0 / 181440.0,
    ],
    &[49561.0 / 161280.0, -179.0 / 168.0, 6601661.0 / 7257600.0],
    &[34729.0 / 80640.0, -3418889.0 / 1995840.0],
    &[212378941.0 / 319334400.0],
];

/// Equation (36).
const BETA: [&[f64]; 6] = [
    &[
        1.0 / 2.0,
        -2.0 / 3.0,
        37.0 / 96.0,
        -1.0 / 360.0,
        -81.0 / 512.0,
        96199.0 / 604800.0,
    ],
    &[
        1.0 / 48.0,
        1.0 / 15.0,
        -437.0 / 1440.0,
        46.0 / 105.0,
        -1118711.0 / 3870720.0,
    ],
    &[
        17.0 / 480.0,
        -37.0 / 840.0,
        -209.0 / 4480.0,
        5569.0 / 90720.0,
    ],
    &[4397.0 / 161280.0, -11.0 / 504.0, -830251.0 / 7257600.0],
    &[4583.0 / 161280.0, -108847.0 / 3991680.0],
    &[20648693.0 / 638668800.0],
];

/// The plane that touches the ellipsoid at `origin`.
#[derive(Debug, Clone, PartialEq)]
struct Tangent {
    offset: MapPoint,
    origin: [f64; 3],
    east: [f64; 3],
    north: [f64; 3],
    up: [f64; 3],
}

impl Tangent {
    fn new(origin: LonLat, offset: MapPoint) -> Self {
        let (sin_lon, cos_lon) = libm::sincos(origin.lon.to_radians());
        let (sin_lat, cos_lat) = libm::sincos(origin.lat.to_radians());
        Self {
            offset,
            origin: on_ellipsoid(origin),
            east: [-sin_lon, cos_lon, 0.0],
            north: [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
            up: [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
        }
    }

    fn forward(&self, position: LonLat) -> MapPoint {
        let p = on_ellipsoid(position);
        let d = [
            p[0] - self.origin[0],
            p[1] - self.origin[1],
            p[2] - self.origin[2],
        ];
        MapPoint::new(
            dot(d, self.east) + self.offset.x,
            dot(d, self.north) + self.offset.y,
        )
    }

    /// Follows the origin's vertical from the plane down to the ellipsoid. A point beyond the
    /// Earth's limb is mapped to the limb.
    fn inverse(&self, point: MapPoint) -> LonLat {
        // With z stretched so that the ellipsoid is a sphere, the line meets it at the larger root.
        let stretch = 1.0 / (1.0 - F);
        let (x, y) = (point.x - self.offset.x, point.y - self.offset.y);
        let start = std::array::from_fn(|i| self.origin[i] + x * self.east[i] + y * self.north[i]);
        let [p, v] = [start, self.up].map(|[x, y, z]: [f64; 3]| [x, y, z * stretch]);
        // |p + t v|^2 = R^2 as a t^2 + 2 b t + c = 0.
        let (a, b, c) = (
            dot(v, v),
            dot(p, v),
            dot(p, p) - EQUATORIAL_RADIUS_M * EQUATORIAL_RADIUS_M,
        );
        // -c / (b + root) instead of (root - b) / a: no digits cancel near the origin.
        let t = -c / (b + (b * b - a * c).max(0.0).sqrt());
        let [x, y, z] = std::array::from_fn(|i| start[i] + t * self.up[i]);
        // On the ellipsoid the tangent of the geodetic latitude is z / ((1 - e^2) * distance from
        // the axis).
        let lat = libm::atan2(z, (1.0 - E2) * libm::hypot(x, y));
        LonLat::new(libm::atan2(y, x).to_degrees(), lat.to_degrees())
    }
}

/// Earth-centred coordinates of a position on the ellipsoid, metres.
fn on_ellipsoid(position: LonLat) -> [f64; 3] {
    let (sin_lon, cos_lon) = libm::sincos(position.lon.to_radians());
    let (sin_lat, cos_lat) = libm::sincos(position.lat.to_radians());
    let normal = EQUATORIAL_RADIUS_M / (1.0 - E2 * sin_lat * sin_lat).sqrt();
    [
        normal * cos_lat * cos_lon,
        normal * cos_lat * sin_lon,
        normal * (1.0 - E2) * sin_lat,
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::element::Node;

    fn utm(zone: u8, north: bool) -> Projection {
        Projection::new(Georeference::Utm {
            zone,
            north,
            offset_x: 0.0,
            offset_y: 0.0,
        })
    }

    fn near(a: MapPoint, b: MapPoint, metres: f64) {
        assert!(a.distance(b) < metres, "{a:?} is not {b:?}");
    }

    /// Computed with 40 digits from the definition: the meridian arc, integrated numerically,
    /// continued to complex latitudes.
    #[test]
    fn utm_agrees_with_the_definition_of_the_projection() {
        let golden = [
            (117.0, 40.4976, 50, true, 500000.0, 4482988.332259791),
            (
                116.9999411,
                40.497769,
                50,
                true,
                499995.0090105285,
                4483007.091226624,
            ),
            (7.42, 43.735, 32, true, 372761.711753707, 4843653.558798204),
            (-8.61, 41.15, 29, true, 532725.1591872805, 4555481.992291499),
            (
                127.0457,
                37.2823,
                52,
                true,
                326750.0012784884,
                4127979.7524615,
            ),
            (
                151.2153,
                -33.8568,
                56,
                false,
                334900.5696522619,
                6252288.752888292,
            ),
            (
                -0.1276,
                51.5072,
                31,
                true,
                282963.1398403319,
                5710868.344320089,
            ),
            (9.0, 0.0, 31, true, 1168881.688527472, 0.0),
            (20.5, 78.2, 33, true, 625380.7555463414, 8686585.42884636),
        ];
        for (lon, lat, zone, north, x, y) in golden {
            near(
                utm(zone, north).to_map(LonLat::new(lon, lat)),
                MapPoint::new(x, y),
                1e-7,
            );
        }
    }

    #[test]
    fn the_tangent_plane_is_east_and_north_of_its_point() {
        let plane = Projection::new(Georeference::tangent_plane(LonLat::new(127.0457, 37.2823)));
        assert_eq!(
            plane.to_map(LonLat::new(127.0457, 37.2823)),
            MapPoint::default()
        );
        near(
            plane.to_map(LonLat::new(127.05, 37.29)),
            MapPoint::new(381.29168539135, 854.57786434398),
            1e-7,
        );
        near(
            plane.to_map(LonLat::new(127.5, 36.9)),
            MapPoint::new(40490.472813773, -42329.854243405),
            1e-6,
        );
    }

    #[test]
    fn offsets_are_added() {
        let offset = "utm:50N,-500000,-4483000".parse().unwrap();
        let point = Projection::new(offset).to_map(LonLat::new(116.9999411, 40.497769));
        near(point, MapPoint::new(-4.9909894715, 7.091226624), 1e-7);
    }

    #[test]
    fn a_map_without_nodes_has_no_georeference() {
        let error = default_georeference(&OsmData::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains("utm:50N"), "{error}");
    }

    #[test]
    fn the_default_zone_is_that_of_the_centre() {
        let georeference = |places: &[(f64, f64)]| {
            let mut data = OsmData::default();
            for (id, (lon, lat)) in (1..).zip(places) {
                data.nodes.insert(
                    id,
                    Node {
                        id,
                        position: LonLat::new(*lon, *lat),
                        ..Node::default()
                    },
                );
            }
            default_georeference(&data).unwrap().to_string()
        };
        assert_eq!(
            georeference(&[(116.9999411, 40.497769), (117.0, 40.4976)]),
            "utm:50N,-500000,-4483000"
        );
        assert_eq!(
            georeference(&[(151.2153, -33.8568)]),
            "utm:56S,-335000,-6252000"
        );
        assert!(georeference(&[(180.0, 0.0)]).starts_with("utm:60N,"));
    }

    proptest! {
        #[test]
        fn utm_there_and_back(zone in 1u8..=60, dlon in -8.0f64..8.0, lat in -84.0f64..84.0) {
            let position = LonLat::new(f64::from(zone) * 6.0 - 183.0 + dlon, lat);
            let projection = utm(zone, lat > 0.0);
            let back = projection.to_lonlat(projection.to_map(position));
            // A tenth of a micrometre.
            let tolerance = 1e-12 / lat.to_radians().abs().max(0.1);
            prop_assert!((back.lon - position.lon).abs() < tolerance, "{back:?}");
            prop_assert!((back.lat - position.lat).abs() < 1e-12, "{back:?}");
        }

        #[test]
        fn tangent_plane_there_and_back(
            lon in -179.0f64..179.0,
            lat in -89.0f64..89.0,
            x in -2e5f64..2e5,
            y in -2e5f64..2e5,
            offset in -5e6f64..5e6,
        ) {
            let at = LonLat::new(lon, lat);
            let plane = Georeference::TangentPlane { at, offset_x: offset, offset_y: -offset };
            let projection = Projection::new(plane);
            let point = MapPoint::new(x + offset, y - offset);
            prop_assert!(projection.to_map(projection.to_lonlat(point)).distance(point) < 1e-7);
        }
    }
}
