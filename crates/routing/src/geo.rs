//! Places on the Earth as whole numbers, and distances between nearby ones.

use bytemuck::{Pod, Zeroable};
use openbench_core::LonLat;

/// Units of a [`Place`] around the Earth.
pub(crate) const TURN: i64 = 3_600_000_000;
/// Units of a [`Place`] in a degree.
const UNITS: f64 = 1e7;

/// A place, in units of 1e-7 degrees WGS 84 (at most 11 mm), the resolution of OSM.
///
/// ```
/// use openbench_core::LonLat;
/// use openbench_routing::geo::{Place, bearing, distance};
///
/// // From the casino of Monaco to the harbour.
/// let casino = Place::new(LonLat::new(7.4283, 43.7392)).unwrap();
/// let harbour = Place::new(LonLat::new(7.4246, 43.7350)).unwrap();
/// assert!((distance(casino, harbour) - 554.0).abs() < 1.0);
/// // South-west.
/// assert!((bearing(casino, harbour) - 212.5).abs() < 0.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Place {
    /// Longitude.
    pub lon: i32,
    /// Latitude.
    pub lat: i32,
}

impl Place {
    /// The place nearest to a position; `None` off the Earth.
    pub fn new(position: LonLat) -> Option<Self> {
        let on_earth = position.lon.abs() <= 180.0 && position.lat.abs() <= 90.0;
        let units = |degrees: f64| libm::round(degrees * UNITS) as i32;
        on_earth.then(|| Self {
            lon: units(position.lon),
            lat: units(position.lat),
        })
    }

    /// Its position along a Hilbert curve over an Earth of 2^32 by 2^32 cells. Places that are
    /// close on the curve are close on the Earth.
    pub(crate) fn hilbert(self) -> u64 {
        // Shifted so that the order of signed numbers becomes that of unsigned ones.
        let [mut x, mut y] = [self.lon, self.lat].map(|unit| (i64::from(unit) + (1 << 31)) as u32);
        let mut along = 0_u64;
        for bit in (0..32).rev() {
            let (right, up) = (x >> bit & 1, y >> bit & 1);
            // The quadrants in the order of the curve: south-west 0, north-west 1, north-east 2,
            // south-east 3.
            along = along << 2 | u64::from((3 * right) ^ up);
            // In the two southern quadrants the curve is mirrored at a diagonal. In the south-east
            // one it is also turned by 180 degrees, so that neighbouring quadrants join.
            if up == 0 {
                if right == 1 {
                    (x, y) = (!x, !y);
                }
                std::mem::swap(&mut x, &mut y);
            }
        }
        along
    }

    /// The position, degrees.
    pub fn position(self) -> LonLat {
        LonLat::new(f64::from(self.lon) / UNITS, f64::from(self.lat) / UNITS)
    }
}

/// Metres per unit of longitude and of latitude at a latitude, from the radii of curvature of the
/// WGS 84 ellipsoid.
///
/// Distances up to some kilometres between places near that latitude are accurate to 1e-6 or
/// better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// Metres per unit of longitude.
    pub lon: f64,
    /// Metres per unit of latitude.
    pub lat: f64,
}

impl Scale {
    /// The scale at a latitude, which is given in units of a [`Place`].
    pub(crate) fn at(lat: f64) -> Self {
        const EQUATOR: f64 = 6_378_137.0;
        const FLATTENING: f64 = 1.0 / 298.257_223_563;
        const E2: f64 = FLATTENING * (2.0 - FLATTENING);
        let (sine, cosine) = libm::sincos((lat / UNITS).to_radians());
        // Radii of curvature in the prime vertical (along the parallel) and in the meridian.
        let square = 1.0 - E2 * sine * sine;
        let normal = EQUATOR / square.sqrt();
        let meridian = normal * (1.0 - E2) / square;
        let unit = (1.0 / UNITS).to_radians();
        Self {
            lon: normal * cosine * unit,
            lat: meridian * unit,
        }
    }

    /// Metres eastwards and northwards from `a` to `b`, the short way around the Earth.
    pub(crate) fn offset(self, a: Place, b: Place) -> [f64; 2] {
        let mut lon = i64::from(b.lon) - i64::from(a.lon);
        if lon.abs() > TURN / 2 {
            lon -= lon.signum() * TURN;
        }
        [
            lon as f64 * self.lon,
            (i64::from(b.lat) - i64::from(a.lat)) as f64 * self.lat,
        ]
    }
}

/// Metres between two places that are near each other.
pub fn distance(a: Place, b: Place) -> f64 {
    // The scale half-way, which makes the distance the same in both directions.
    let middle = (f64::from(a.lat) + f64::from(b.lat)) / 2.0;
    let [east, north] = Scale::at(middle).offset(a, b);
    (east * east + north * north).sqrt()
}

/// The direction from `a` to `b`, degrees clockwise from north, 0 to 360; 0 if they are equal.
pub fn bearing(a: Place, b: Place) -> f64 {
    let [east, north] = Scale::at(f64::from(a.lat)).offset(a, b);
    let degrees = libm::atan2(east, north).to_degrees();
    if degrees < 0.0 {
        degrees + 360.0
    } else {
        degrees
    }
}

/// The turn from a bearing to another, degrees: positive to the right, at most 180.
pub(crate) fn turn(from: f64, to: f64) -> f64 {
    let turn = (to - from).rem_euclid(360.0);
    if turn > 180.0 { turn - 360.0 } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(lon: f64, lat: f64) -> Place {
        Place::new(LonLat::new(lon, lat)).unwrap()
    }

    /// Lengths of a degree from tables of the ellipsoid: 111.320 km along the equator, 110.574 km
    /// and 111.694 km of latitude.
    #[test]
    fn degrees_are_as_long_as_the_tables_say() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1.0, "{a} {b}");
        near(distance(place(10.0, 0.0), place(11.0, 0.0)), 111_319.5);
        near(
            100.0 * distance(place(0.0, -0.005), place(0.0, 0.005)),
            110_574.3,
        );
        near(
            100.0 * distance(place(0.0, 89.985), place(0.0, 89.995)),
            111_693.9,
        );
        near(
            100.0 * distance(place(7.0, 60.0), place(7.01, 60.0)),
            55_800.3,
        );
    }

    #[test]
    fn distances_across_the_date_line_are_short() {
        let metres = distance(place(179.999, 10.0), place(-179.999, 10.0));
        assert!((metres - 0.002 * 109_639.0).abs() < 1.0, "{metres}");
    }

    #[test]
    fn places_off_the_earth_are_refused() {
        for (lon, lat) in [
            (180.1, 0.0),
            (0.0, -90.1),
            (f64::NAN, 0.0),
            (0.0, f64::INFINITY),
        ] {
            assert_eq!(Place::new(LonLat::new(lon, lat)), None);
        }
        assert_eq!(place(-180.0, 90.0).position(), LonLat::new(-180.0, 90.0));
    }
}
