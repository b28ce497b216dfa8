//! `livox_ros_driver2/CustomMsg`: LiDAR scans in the format of the Livox driver.

use openbench_core::{LidarPoint, LidarScan};

use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

/// `livox_ros_driver2/CustomPoint`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CustomPoint {
    /// Time since the time stamp of the scan, nanoseconds.
    pub offset_time: u32,
    /// Position in the frame of the sensor, metres.
    pub xyz: [f32; 3],
    /// Reflectivity, 0 to 255.
    pub reflectivity: u8,
    /// Quality of the return, as the sensor encodes it.
    pub tag: u8,
    /// Number of the laser line.
    pub line: u8,
}

/// `livox_ros_driver2/CustomMsg`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CustomMsg {
    /// Time stamp of the first point, and frame of the sensor.
    pub header: Header,
    /// Time of the first point by the clock of the sensor, nanoseconds.
    pub timebase: u64,
    /// Number of the sensor.
    pub lidar_id: u8,
    /// The points.
    pub points: Vec<CustomPoint>,
}

impl CustomMsg {
    /// The scan, without points that contain NaN or infinity, and without points at the origin,
    /// which stand for rays without a return.
    pub fn to_scan(&self) -> LidarScan {
        let points = self
            .points
            .iter()
            .filter(|point| point.is_return())
            .map(LidarPoint::from);
        LidarScan {
            stamp: self.header.stamp,
            points: points.collect(),
        }
    }
}

impl CustomPoint {
    /// Whether the ray has a return.
    fn is_return(&self) -> bool {
        self.xyz.iter().all(|x| x.is_finite()) && self.xyz != [0.0; 3]
    }
}

impl From<&CustomPoint> for LidarPoint {
    fn from(point: &CustomPoint) -> Self {
        Self {
            xyz: point.xyz,
            offset_ns: point.offset_time,
            reflectivity: point.reflectivity,
            line: point.line,
        }
    }
}

impl Message for CustomPoint {
    const DEFINITION: &'static Definition = &Definition {
        name: "livox_ros_driver2/CustomPoint",
        fields: "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\nuint8 reflectivity\n\
                 uint8 tag\nuint8 line\n",
        parts: &[],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.u32(self.offset_time);
        self.xyz.iter().for_each(|x| out.f32(*x));
        out.u8(self.reflectivity);
        out.u8(self.tag);
        out.u8(self.line);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            offset_time: input.u32()?,
            xyz: [input.f32()?, input.f32()?, input.f32()?],
            reflectivity: input.u8()?,
            tag: input.u8()?,
            line: input.u8()?,
        })
    }
}

impl Message for CustomMsg {
    const DEFINITION: &'static Definition = &Definition {
        name: "livox_ros_driver2/CustomMsg",
        fields: "std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\n\
                 uint8[3] rsvd\nlivox_ros_driver2/CustomPoint[] points\n",
        parts: &[Header::DEFINITION, CustomPoint::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.u64(self.timebase);
        out.u32(self.points.len() as u32);
        out.u8(self.lidar_id);
        // `rsvd`, reserved.
        (0..3).for_each(|_| out.u8(0));
        out.count(self.points.len());
        self.points.iter().for_each(|point| point.encode(out));
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        // `point_num` repeats the length of `points`, which is read.
        let (header, timebase, _) = (Header::decode(input)?, input.u64()?, input.u32()?);
        let lidar_id = input.u8()?;
        for _ in 0..3 {
            input.u8()?;
        }
        Ok(Self {
            header,
            timebase,
            lidar_id,
            // 19 bytes: one u32, three f32, three u8.
            points: input.sequence(19, CustomPoint::decode)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn scans_round_trip_without_rays_that_have_no_return() {
        let point = |x: f32, offset_time| CustomPoint {
            offset_time,
            xyz: [x, 0.0, 0.0],
            reflectivity: 7,
            tag: 16,
            line: 2,
        };
        let message = CustomMsg {
            header: Header::new(SimTime::from_millis(100), "livox_frame"),
            timebase: 5,
            lidar_id: 1,
            points: vec![
                point(1.5, 10),
                point(0.0, 20),
                point(f32::NAN, 30),
                point(-2.5, 40),
            ],
        };
        let bytes = message.to_cdr();
        let read = CustomMsg::from_cdr(&bytes).unwrap();
        assert_eq!(read.points.len(), 4);
        let scan = read.to_scan();
        assert_eq!(
            scan.points
                .iter()
                .map(|p| (p.xyz[0], p.offset_ns))
                .collect::<Vec<_>>(),
            [(1.5, 10), (-2.5, 40)]
        );
        assert!((0..bytes.len() - 1).all(|cut| CustomMsg::from_cdr(&bytes[..cut]).is_err()));
    }
}
