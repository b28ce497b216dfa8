//! `sensor_msgs/NavSatFix`: positions from satellite navigation.

use openbench_core::{GnssFix, LonLat};

use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

/// `NavSatStatus.STATUS_FIX`: without augmentation.
const STATUS_FIX: u8 = 0;
/// `NavSatStatus.SERVICE_GPS`.
const SERVICE_GPS: u16 = 1;
/// `NavSatFix.COVARIANCE_TYPE_KNOWN`.
const COVARIANCE_TYPE_KNOWN: u8 = 3;

const STATUS: &Definition = &Definition {
    name: "sensor_msgs/NavSatStatus",
    fields: "int8 status\nuint16 service\n",
    parts: &[],
};

/// `sensor_msgs/NavSatFix` with a fix. Its status is always that of GPS without augmentation.
///
/// ```
/// use openbench_core::{GnssFix, LonLat, SimTime};
/// use openbench_logs::messages::{Message, NavSatFix};
///
/// // A fix on the Place du Casino in Monaco, with a standard deviation of 2 m.
/// let covariance = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// let stamp = SimTime::from_millis(1000);
/// let fix = GnssFix { stamp, position: [120.0, 40.0, 0.0], covariance, satellites: 9 };
/// let message = NavSatFix::new(&fix, LonLat { lon: 7.4278, lat: 43.7392 });
///
/// let read = NavSatFix::from_cdr(&message.to_cdr())?;
/// assert_eq!((read.position.lat, read.position_covariance[4]), (43.7392, 4.0));
/// # Ok::<(), openbench_logs::CdrError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct NavSatFix {
    /// Time stamp and frame of the antenna.
    pub header: Header,
    /// Position, degrees, WGS 84.
    pub position: LonLat,
    /// Altitude, metres, above the zero level of the world, whose height above the ellipsoid is
    /// unknown.
    pub altitude: f64,
    /// Covariance of the position, m², over east, north, up, row by row.
    pub position_covariance: [f64; 9],
}

impl NavSatFix {
    /// The message for a fix that lies at `position` on the Earth.
    pub fn new(fix: &GnssFix, position: LonLat) -> Self {
        let position_covariance = std::array::from_fn(|i| fix.covariance[i / 3][i % 3]);
        let header = Header::new(fix.stamp, "gnss_link");
        Self {
            header,
            position,
            altitude: fix.position[2],
            position_covariance,
        }
    }
}

impl Message for NavSatFix {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/NavSatFix",
        fields: "std_msgs/Header header\nsensor_msgs/NavSatStatus status\nfloat64 latitude\n\
                 float64 longitude\nfloat64 altitude\nfloat64[9] position_covariance\n\
                 uint8 position_covariance_type\n",
        parts: &[Header::DEFINITION, STATUS],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        // `status` is an int8; zero has the same byte in both.
        out.u8(STATUS_FIX);
        out.u16(SERVICE_GPS);
        out.f64(self.position.lat);
        out.f64(self.position.lon);
        out.f64(self.altitude);
        out.f64_array(&self.position_covariance);
        out.u8(COVARIANCE_TYPE_KNOWN);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let header = Header::decode(input)?;
        let (_status, _service) = (input.u8()?, input.u16()?);
        let (lat, lon, altitude) = (input.f64()?, input.f64()?, input.f64()?);
        let position_covariance = input.f64_array()?;
        let _kind = input.u8()?;
        Ok(Self {
            header,
            position: LonLat { lon, lat },
            altitude,
            position_covariance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn fixes_round_trip() {
        let covariance = [[4.0, 1.0, 2.0], [1.0, 5.0, 3.0], [2.0, 3.0, 9.0]];
        let fix = GnssFix {
            stamp: SimTime(7),
            position: [1.0, 2.0, 3.0],
            covariance,
            satellites: 9,
        };
        let message = NavSatFix::new(
            &fix,
            LonLat {
                lon: 7.42,
                lat: 43.73,
            },
        );
        assert_eq!(
            message.position_covariance,
            [4.0, 1.0, 2.0, 1.0, 5.0, 3.0, 2.0, 3.0, 9.0]
        );
        assert_eq!(NavSatFix::from_cdr(&message.to_cdr()).unwrap(), message);
        // After the encapsulation: time stamp 8 bytes, frame 4 + 10, status 1, service 2 at an even
        // offset, latitude at the next multiple of 8.
        let latitude = &message.to_cdr()[4 + 32..4 + 40];
        assert_eq!(
            latitude,
            43.73_f64.to_le_bytes(),
            "where ROS 2 reads the latitude"
        );
    }
}
