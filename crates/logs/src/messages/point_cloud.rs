//! `sensor_msgs/PointCloud2`, with the fields that a Livox driver fills: position, intensity, line, and the time of
//! each point.
//!
//! Written clouds have points of 21 bytes: `x y z intensity` (f32), `offset_time` (u32, nanoseconds since the stamp),
//! `line` (u8). Of clouds from elsewhere `x y z` must be f32; the other fields are taken where they have these types. The time of a point may also stand, as drivers of other
//! sensors have it, in `t` (u32, nanoseconds since the stamp), in `time` (f32, seconds from the stamp, before it below 0) or in `timestamp` (f64, since 1970, in seconds
//! or, from 10¹² on, in nanoseconds).

use openbench_core::{LidarPoint, LidarScan, SimTime};

use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

const UINT8: u8 = 2;
const UINT32: u8 = 6;
const FLOAT32: u8 = 7;
const FLOAT64: u8 = 8;
const POINT_STEP: u32 = 21;
const FIELDS: [(&str, u32, u8); 6] = [
    ("x", 0, FLOAT32),
    ("y", 4, FLOAT32),
    ("z", 8, FLOAT32),
    ("intensity", 12, FLOAT32),
    ("offset_time", 16, UINT32),
    ("line", 20, UINT8),
];

/// A cloud that is no scan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CloudError {
    /// A field is missing or has another type.
    #[error("the cloud has no field `{0}` of 32-bit floats")]
    MissingField(&'static str),
    /// Big-endian numbers.
    #[error("the cloud is big-endian")]
    BigEndian,
    /// Width, height, steps, offsets and data contradict each other.
    #[error(
        "the cloud claims {points} points of {step} bytes with rows of {row} bytes but has {bytes} bytes"
    )]
    Layout {
        /// Width times height.
        points: u64,
        /// Bytes a point.
        step: u32,
        /// Bytes a row.
        row: u32,
        /// Bytes there are.
        bytes: usize,
    },
    /// Points of a scan that took longer than four seconds, or have no time.
    #[error("the points' times in field `{0}` are no numbers or lie more than four seconds apart")]
    Times(&'static str),
}

/// Where the time of a point stands, and how.
#[derive(Debug, Clone, Copy)]
enum Clock {
    /// Nanoseconds since the stamp.
    Nanoseconds(usize),
    /// Seconds from the stamp.
    Seconds(usize),
    /// Seconds or nanoseconds since 1970.
    Epoch(usize),
}

impl Clock {
    /// Nanoseconds from the stamp to a point.
    fn read(self, bytes: &[u8], stamp: SimTime) -> Option<i64> {
        /// More is no number of seconds since 1970.
        const NOT_SECONDS: f64 = 1e12;
        let nanoseconds = match self {
            Self::Nanoseconds(at) => return Some(i64::from(word(bytes, at))),
            Self::Seconds(at) => f64::from(f32::from_bits(word(bytes, at))) * 1e9,
            Self::Epoch(at) => {
                let time = f64::from_bits(u64::from(word(bytes, at)) | u64::from(word(bytes, at + 4)) << 32);
                // Seconds are taken apart first: as nanoseconds they do not fit into a float's digits.
                let (seconds, scale) = if time.abs() < NOT_SECONDS {
                    (stamp.0 as f64 * 1e-9, 1e9)
                } else {
                    (stamp.0 as f64, 1.0)
                };
                (time - seconds) * scale
            }
        };
        (nanoseconds.abs() < 1e11).then_some(nanoseconds as i64)
    }
}

/// `sensor_msgs/PointField`: where in a point a number stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointField {
    /// What the number is.
    pub name: String,
    /// Bytes from the beginning of the point.
    pub offset: u32,
    /// Type of the number, 1 to 8 as in the interface definition.
    pub datatype: u8,
    /// How many numbers.
    pub count: u32,
}

impl Message for PointField {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/PointField",
        fields: "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n\
                 uint8 FLOAT32=7\nuint8 FLOAT64=8\n\
                 string name\nuint32 offset\nuint8 datatype\nuint32 count\n",
        parts: &[],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.string(&self.name);
        out.u32(self.offset);
        out.u8(self.datatype);
        out.u32(self.count);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self { name: input.string()?, offset: input.u32()?, datatype: input.u8()?, count: input.u32()? })
    }
}

/// `sensor_msgs/PointCloud2`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PointCloud2 {
    /// When, and the sensor's frame.
    pub header: Header,
    /// Rows; 1 for an unordered cloud.
    pub height: u32,
    /// Points a row.
    pub width: u32,
    /// What a point is made of.
    pub fields: Vec<PointField>,
    /// Whether numbers are big-endian.
    pub is_bigendian: bool,
    /// Bytes a point.
    pub point_step: u32,
    /// Bytes a row.
    pub row_step: u32,
    /// The points.
    pub data: Vec<u8>,
    /// Whether all points are finite.
    pub is_dense: bool,
}

impl From<&LidarScan> for PointCloud2 {
    fn from(scan: &LidarScan) -> Self {
        let field = |&(name, offset, datatype): &(&str, u32, u8)| PointField {
            name: name.to_owned(),
            offset,
            datatype,
            count: 1,
        };
        let width = scan.points.len() as u32;
        Self {
            header: Header::new(scan.stamp, "livox_frame"),
            height: 1,
            width,
            fields: FIELDS.iter().map(field).collect(),
            is_bigendian: false,
            point_step: POINT_STEP,
            row_step: width * POINT_STEP,
            data: scan.points.iter().flat_map(point_bytes).collect(),
            is_dense: true,
        }
    }
}

fn point_bytes(point: &LidarPoint) -> [u8; POINT_STEP as usize] {
    let mut bytes = [0; POINT_STEP as usize];
    let [x, y, z] = point.xyz;
    for (i, value) in [x, y, z, f32::from(point.reflectivity)].into_iter().enumerate() {
        bytes[4 * i..4 * i + 4].copy_from_slice(&value.to_le_bytes());
    }
    bytes[16..20].copy_from_slice(&point.offset_ns.to_le_bytes());
    bytes[20] = point.line;
    bytes
}

impl PointCloud2 {
    /// The scan. Points that are not finite are left out; fields that the cloud lacks are zero.
    pub fn to_scan(&self) -> Result<LidarScan, CloudError> {
        if self.is_bigendian {
            return Err(CloudError::BigEndian);
        }
        self.check_layout()?;
        let coordinate = |name| self.offset(name, FLOAT32).ok_or(CloudError::MissingField(name));
        let xyz = [coordinate("x")?, coordinate("y")?, coordinate("z")?];
        let intensity = self.offset("intensity", FLOAT32);
        let (clock, line) = (self.clock(), self.offset("line", UINT8));
        let rows = self.data.chunks(self.row_step.max(1) as usize).take(self.height as usize);
        let points =
            rows.flat_map(|row| row.chunks_exact(self.point_step.max(1) as usize).take(self.width as usize));
        let (mut scan, mut times) = (LidarScan { stamp: self.header.stamp, points: Vec::new() }, Vec::new());
        for bytes in points {
            let xyz = xyz.map(|at| f32::from_bits(word(bytes, at)));
            if !xyz.iter().all(|v| v.is_finite()) {
                continue;
            }
            if let Some((name, clock)) = clock {
                times.push(clock.read(bytes, scan.stamp).ok_or(CloudError::Times(name))?);
            }
            scan.points.push(LidarPoint {
                xyz,
                reflectivity: intensity.map_or(0, |at| f32::from_bits(word(bytes, at)) as u8),
                offset_ns: 0,
                line: line.map_or(0, |at| bytes[at]),
            });
        }
        if let Some((name, _)) = clock {
            set_times(&mut scan, &times).ok_or(CloudError::Times(name))?;
        }
        Ok(scan)
    }

    /// Where points' times stand.
    fn clock(&self) -> Option<(&'static str, Clock)> {
        let nanoseconds = |name| Some((name, Clock::Nanoseconds(self.offset(name, UINT32)?)));
        nanoseconds("offset_time")
            .or_else(|| nanoseconds("t"))
            .or_else(|| Some(("time", Clock::Seconds(self.offset("time", FLOAT32)?))))
            .or_else(|| Some(("timestamp", Clock::Epoch(self.offset("timestamp", FLOAT64)?))))
    }

    fn check_layout(&self) -> Result<(), CloudError> {
        let points = u64::from(self.width) * u64::from(self.height);
        let needed = u64::from(self.row_step).checked_mul(u64::from(self.height));
        let row = u64::from(self.width) * u64::from(self.point_step) <= u64::from(self.row_step);
        if row && needed.is_some_and(|n| n <= self.data.len() as u64) {
            return Ok(());
        }
        let (step, row) = (self.point_step, self.row_step);
        Err(CloudError::Layout { points, step, row, bytes: self.data.len() })
    }

    /// Where in a point the field stands, if it has this type and lies inside the point.
    fn offset(&self, name: &str, datatype: u8) -> Option<usize> {
        let field = self.fields.iter().find(|f| f.name == name && f.datatype == datatype)?;
        let size = match datatype {
            UINT8 => 1,
            FLOAT64 => 8,
            _ => 4,
        };
        let inside = field.offset.checked_add(size)? <= self.point_step;
        inside.then_some(field.offset as usize)
    }
}

/// Gives points their times from the stamp, which moves to the first of them where that was before it.
fn set_times(scan: &mut LidarScan, times: &[i64]) -> Option<()> {
    let first = times.iter().copied().min().unwrap_or_default().min(0);
    scan.stamp = SimTime(scan.stamp.0.checked_add_signed(first)?);
    for (point, time) in scan.points.iter_mut().zip(times) {
        point.offset_ns = u32::try_from(time - first).ok()?;
    }
    Some(())
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

impl Message for PointCloud2 {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/PointCloud2",
        fields: "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n\
                 bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
        parts: &[Header::DEFINITION, PointField::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.u32(self.height);
        out.u32(self.width);
        out.count(self.fields.len());
        self.fields.iter().for_each(|f| f.encode(out));
        out.bool(self.is_bigendian);
        out.u32(self.point_step);
        out.u32(self.row_step);
        out.octets(&self.data);
        out.bool(self.is_dense);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            height: input.u32()?,
            width: input.u32()?,
            fields: input.sequence(13, PointField::decode)?,
            is_bigendian: input.bool()?,
            point_step: input.u32()?,
            row_step: input.u32()?,
            data: input.octets()?.to_vec(),
            is_dense: input.bool()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan() -> LidarScan {
        let point = |i: u8| LidarPoint {
            xyz: [f32::from(i), -0.5, 0.25],
            offset_ns: 5_000 * u32::from(i),
            reflectivity: 10 + i,
            line: i % 4,
        };
        LidarScan { stamp: SimTime::from_millis(100), points: (0..9).map(point).collect() }
    }

    #[test]
    fn scans_survive() {
        let cloud = PointCloud2::from_cdr(&PointCloud2::from(&scan()).to_cdr()).unwrap();
        assert_eq!(cloud.data.len(), 9 * 21);
        assert_eq!(cloud.to_scan().unwrap(), scan());
        let empty = LidarScan::default();
        assert_eq!(PointCloud2::from(&empty).to_scan().unwrap(), empty);
    }

    /// Two points, 50 ms apart, whose times stand in a field of this name and type.
    fn timed(name: &str, datatype: u8, times: [&[u8]; 2]) -> Result<LidarScan, CloudError> {
        let field =
            |name: &str, offset, datatype| PointField { name: name.into(), offset, datatype, count: 1 };
        let mut data = Vec::new();
        for time in times {
            (0..3).for_each(|i| data.extend((i as f32).to_le_bytes()));
            data.extend(time);
        }
        let step = data.len() as u32 / 2;
        let fields = vec![
            field("x", 0, FLOAT32),
            field("y", 4, FLOAT32),
            field("z", 8, FLOAT32),
            field(name, 12, datatype),
        ];
        let header = Header::new(SimTime(1_700_000_000_000_000_000), "lidar");
        let cloud = PointCloud2 {
            header,
            height: 1,
            width: 2,
            fields,
            point_step: step,
            row_step: 2 * step,
            data,
            ..PointCloud2::default()
        };
        cloud.to_scan()
    }

    #[test]
    fn points_times_are_read_as_other_drivers_write_them() {
        const STAMP: u64 = 1_700_000_000_000_000_000;
        let check = |scan: Result<LidarScan, CloudError>, stamp: u64, apart: u32| {
            let scan = scan.unwrap();
            assert!(scan.stamp.0.abs_diff(stamp) < 1_000, "{} {stamp}", scan.stamp.0);
            assert!(scan.points[1].offset_ns.abs_diff(scan.points[0].offset_ns + apart) < 1_000);
        };
        let ms50 = 50_000_000_u32;
        check(timed("t", UINT32, [&0_u32.to_le_bytes(), &ms50.to_le_bytes()]), STAMP, ms50);
        check(
            timed("time", FLOAT32, [&(-0.05_f32).to_le_bytes(), &0_f32.to_le_bytes()]),
            STAMP - u64::from(ms50),
            ms50,
        );
        let (first, second) = (STAMP as f64 * 1e-9, STAMP as f64 * 1e-9 + 0.05);
        check(timed("timestamp", FLOAT64, [&first.to_le_bytes(), &second.to_le_bytes()]), STAMP, ms50);
        let (first, second) = (STAMP as f64, STAMP as f64 + 5e7);
        check(timed("timestamp", FLOAT64, [&first.to_le_bytes(), &second.to_le_bytes()]), STAMP, ms50);
        for bad in [f64::NAN, 0.0, 1e300] {
            assert_eq!(
                timed("timestamp", FLOAT64, [&first.to_le_bytes(), &bad.to_le_bytes()]),
                Err(CloudError::Times("timestamp"))
            );
        }
        assert_eq!(
            timed("time", FLOAT32, [&9_f32.to_le_bytes(), &0_f32.to_le_bytes()]),
            Err(CloudError::Times("time"))
        );
    }

    #[test]
    fn clouds_that_contradict_themselves_are_refused() {
        let good = PointCloud2::from(&scan());
        for (width, point_step, row_step) in [(10, 21, 189), (9, 22, 189), (u32::MAX, u32::MAX, u32::MAX)] {
            let cloud = PointCloud2 { width, point_step, row_step, ..good.clone() };
            assert!(matches!(cloud.to_scan(), Err(CloudError::Layout { .. })));
        }
        let mut cloud = good.clone();
        cloud.fields[1].offset = u32::MAX;
        assert_eq!(cloud.to_scan(), Err(CloudError::MissingField("y")));
        let cloud = PointCloud2 { is_bigendian: true, ..good };
        assert_eq!(cloud.to_scan(), Err(CloudError::BigEndian));
    }

    #[test]
    fn a_hostile_height_ends() {
        let cloud =
            PointCloud2 { height: u32::MAX, width: 0, row_step: 0, point_step: 0, ..PointCloud2::default() };
        assert!(cloud.to_scan().is_err());
    }
}
