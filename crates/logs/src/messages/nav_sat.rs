//! `sensor_msgs/NavSatFix`: where satellites say that the antenna is.

use openbench_core::{GnssFix, LonLat};

use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

/// Status of a fix without corrections, from GPS; covariance known.
const FIX: u8 = 0;
const GPS: u16 = 1;
const KNOWN: u8 = 3;

const STATUS: &Definition =
    &Definition { name: "sensor_msgs/NavSatStatus", fields: "int8 status\nuint16 service\n", parts: &[] };

/// `sensor_msgs/NavSatFix`, of fixes only: its status is always that of a plain one from GPS.
#[derive(Debug, Clone, PartialEq)]
pub struct NavSatFix {
    /// When, and the antenna's frame.
    pub header: Header,
    /// Degrees, WGS 84.
    pub position: LonLat,
    /// Metres. Worlds do not say how high they lie above the ellipsoid: above their own zero.
    pub altitude: f64,
    /// Covariance, m², east, north, up, row by row.
    pub position_covariance: [f64; 9],
}

impl NavSatFix {
    /// The message of a fix whose place on the Earth is `position`.
    pub fn new(fix: &GnssFix, position: LonLat) -> Self {
        let position_covariance = std::array::from_fn(|i| fix.covariance[i / 3][i % 3]);
        let header = Header::new(fix.stamp, "gnss_link");
        Self { header, position, altitude: fix.position[2], position_covariance }
    }
}

impl Message for NavSatFix {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/NavSatFix",
        fields: "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\nfloat64 longitude\n\
                 float64 altitude\nfloat64[9] position_covariance\nuint8 position_covariance_type\n",
        parts: &[Header::DEFINITION, STATUS],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.u8(FIX);
        out.u16(GPS);
        out.f64(self.position.lat);
        out.f64(self.position.lon);
        out.f64(self.altitude);
        out.f64_array(&self.position_covariance);
        out.u8(KNOWN);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let header = Header::decode(input)?;
        let (_status, _service) = (input.u8()?, input.u16()?);
        let (lat, lon, altitude) = (input.f64()?, input.f64()?, input.f64()?);
        let position_covariance = input.f64_array()?;
        let _kind = input.u8()?;
        Ok(Self { header, position: LonLat { lon, lat }, altitude, position_covariance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn fixes_survive() {
        let covariance = [[4.0, 1.0, 2.0], [1.0, 5.0, 3.0], [2.0, 3.0, 9.0]];
        let fix = GnssFix { stamp: SimTime(7), position: [1.0, 2.0, 3.0], covariance, satellites: 9 };
        let message = NavSatFix::new(&fix, LonLat { lon: 7.42, lat: 43.73 });
        assert_eq!(message.position_covariance, [4.0, 1.0, 2.0, 1.0, 5.0, 3.0, 2.0, 3.0, 9.0]);
        assert_eq!(NavSatFix::from_cdr(&message.to_cdr()).unwrap(), message);
        // After the encapsulation: stamp 8, frame 4 + 10, status 1, service 2 at an even place, latitude at the next multiple of 8.
        let latitude = &message.to_cdr()[4 + 32..4 + 40];
        assert_eq!(latitude, 43.73_f64.to_le_bytes(), "where ROS 2 looks for it");
    }
}
