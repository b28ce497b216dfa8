//! Conversion between LiDAR scans and `sensor_msgs/PointCloud2`.
//!
//! Written clouds have the fields of the Livox driver, 21 bytes for each point: `x y z intensity`
//! (f32), `offset_time` (u32, nanoseconds since the time stamp) and `line` (u8).
//!
//! In clouds of other sources, `x y z` must be f32; the other fields are read if they have these
//! types. The time of a point may also be in one of the fields that drivers of other sensors use:
//!
//! | field | type | meaning |
//! |---|---|---|
//! | `t` | u32 | nanoseconds since the time stamp |
//! | `time` | f32 | seconds from the time stamp, negative before it |
//! | `timestamp` | f64 | seconds since 1970, or from 10¹² on nanoseconds |

use openbench_core::{LidarPoint, LidarScan, SimTime};

use super::Header;
use super::point_cloud::{FLOAT32, FLOAT64, PointCloud2, PointField, UINT8, UINT32};

/// Length of a point in written clouds, bytes.
const POINT_STEP_BYTES: u32 = 21;
/// Fields of a point in written clouds.
const FIELDS: [Field; 6] = [
    Field {
        name: "x",
        offset: 0,
        datatype: FLOAT32,
    },
    Field {
        name: "y",
        offset: 4,
        datatype: FLOAT32,
    },
    Field {
        name: "z",
        offset: 8,
        datatype: FLOAT32,
    },
    Field {
        name: "intensity",
        offset: 12,
        datatype: FLOAT32,
    },
    Field {
        name: "offset_time",
        offset: 16,
        datatype: UINT32,
    },
    Field {
        name: "line",
        offset: 20,
        datatype: UINT8,
    },
];

struct Field {
    name: &'static str,
    offset: u32,
    datatype: u8,
}

impl From<&Field> for PointField {
    fn from(field: &Field) -> Self {
        let name = field.name.to_owned();
        Self {
            name,
            offset: field.offset,
            datatype: field.datatype,
            count: 1,
        }
    }
}

/// Why a cloud cannot be read as a scan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CloudError {
    /// A coordinate is missing or has another type than f32.
    #[error("the cloud has no field `{0}` of 32-bit floats")]
    MissingField(&'static str),
    /// The numbers are big-endian.
    #[error("the cloud is big-endian")]
    BigEndian,
    /// Width, height, steps and data are inconsistent.
    #[error(
        "the cloud declares {points} points of {step} bytes in rows of {row} bytes but has {bytes} \
         bytes"
    )]
    Layout {
        /// Width times height.
        points: u64,
        /// Length of a point, bytes.
        step: u32,
        /// Length of a row, bytes.
        row: u32,
        /// Length of the data, bytes.
        bytes: usize,
    },
    /// Times of points are NaN or infinite, or more than four seconds apart.
    #[error(
        "the times of points in field `{0}` contain NaN or infinity or are more than four seconds \
         apart"
    )]
    Times(&'static str),
}

impl From<&LidarScan> for PointCloud2 {
    fn from(scan: &LidarScan) -> Self {
        let width = scan.points.len() as u32;
        Self {
            header: Header::new(scan.stamp, "livox_frame"),
            height: 1,
            width,
            fields: FIELDS.iter().map(PointField::from).collect(),
            is_bigendian: false,
            point_step: POINT_STEP_BYTES,
            row_step: width * POINT_STEP_BYTES,
            data: scan.points.iter().flat_map(point_bytes).collect(),
            is_dense: true,
        }
    }
}

fn point_bytes(point: &LidarPoint) -> [u8; POINT_STEP_BYTES as usize] {
    let mut bytes = [0; POINT_STEP_BYTES as usize];
    let [x, y, z] = point.xyz;
    for (i, value) in [x, y, z, f32::from(point.reflectivity)]
        .into_iter()
        .enumerate()
    {
        bytes[4 * i..4 * i + 4].copy_from_slice(&value.to_le_bytes());
    }
    bytes[16..20].copy_from_slice(&point.offset_ns.to_le_bytes());
    bytes[20] = point.line;
    bytes
}

impl PointCloud2 {
    /// The scan, without points that contain NaN or infinity. Fields that the cloud lacks are zero.
    ///
    /// # Errors
    /// [`CloudError`].
    pub fn to_scan(&self) -> Result<LidarScan, CloudError> {
        if self.is_bigendian {
            return Err(CloudError::BigEndian);
        }
        self.check_layout()?;
        let layout = Layout::of(self)?;
        let mut scan = LidarScan {
            stamp: self.header.stamp,
            points: Vec::new(),
        };
        let mut times = Vec::new();
        for bytes in self.points() {
            let point = layout.point(bytes);
            // Drivers write NaN for rays without a return. Such a point is dropped, so its time
            // need not be valid.
            if !point.xyz.iter().all(|v| v.is_finite()) {
                continue;
            }
            if let Some(clock) = layout.clock {
                times.push(
                    clock
                        .read(bytes, scan.stamp)
                        .ok_or(CloudError::Times(clock.field))?,
                );
            }
            scan.points.push(point);
        }
        if let Some(clock) = layout.clock {
            set_times(&mut scan, &times).ok_or(CloudError::Times(clock.field))?;
        }
        Ok(scan)
    }

    fn check_layout(&self) -> Result<(), CloudError> {
        let points = u64::from(self.width) * u64::from(self.height);
        let needed = u64::from(self.row_step).checked_mul(u64::from(self.height));
        // Rows may be padded, so their length may exceed that of their points.
        let row = u64::from(self.width) * u64::from(self.point_step) <= u64::from(self.row_step);
        if row && needed.is_some_and(|n| n <= self.data.len() as u64) {
            return Ok(());
        }
        let (step, row) = (self.point_step, self.row_step);
        Err(CloudError::Layout {
            points,
            step,
            row,
            bytes: self.data.len(),
        })
    }
}

/// Offsets of the numbers in a point, bytes.
struct Layout {
    xyz: [usize; 3],
    intensity: Option<usize>,
    line: Option<usize>,
    clock: Option<Clock>,
}

impl Layout {
    fn of(cloud: &PointCloud2) -> Result<Self, CloudError> {
        Ok(Self {
            xyz: [
                coordinate(cloud, "x")?,
                coordinate(cloud, "y")?,
                coordinate(cloud, "z")?,
            ],
            intensity: cloud.offset("intensity", FLOAT32),
            line: cloud.offset("line", UINT8),
            clock: Clock::of(cloud),
        })
    }

    /// The point in these bytes, without its time.
    fn point(&self, bytes: &[u8]) -> LidarPoint {
        LidarPoint {
            xyz: self.xyz.map(|at| f32::from_bits(word(bytes, at))),
            reflectivity: self
                .intensity
                // The conversion saturates, and NaN becomes 0.
                .map_or(0, |at| f32::from_bits(word(bytes, at)) as u8),
            offset_ns: 0,
            line: self.line.map_or(0, |at| bytes[at]),
        }
    }
}

fn coordinate(cloud: &PointCloud2, name: &'static str) -> Result<usize, CloudError> {
    cloud
        .offset(name, FLOAT32)
        .ok_or(CloudError::MissingField(name))
}

/// Where a point has its time, and in which unit.
#[derive(Debug, Clone, Copy)]
struct Clock {
    /// Name of the field.
    field: &'static str,
    /// Offset from the beginning of the point, bytes.
    at: usize,
    unit: TimeUnit,
}

#[derive(Debug, Clone, Copy)]
enum TimeUnit {
    /// Nanoseconds since the time stamp, u32.
    Nanoseconds,
    /// Seconds from the time stamp, f32.
    Seconds,
    /// Seconds or nanoseconds since 1970, f64.
    Epoch,
}

impl Clock {
    /// The first of the known fields for times that the cloud has.
    fn of(cloud: &PointCloud2) -> Option<Self> {
        use TimeUnit::{Epoch, Nanoseconds, Seconds};
        // By name and type: `time` and `timestamp` have other meanings in other types.
        let known = [
            ("offset_time", UINT32, Nanoseconds),
            ("t", UINT32, Nanoseconds),
            ("time", FLOAT32, Seconds),
            ("timestamp", FLOAT64, Epoch),
        ];
        known.into_iter().find_map(|(field, datatype, unit)| {
            Some(Self {
                field,
                at: cloud.offset(field, datatype)?,
                unit,
            })
        })
    }

    /// Time of a point from the time stamp on, nanoseconds; `None` if it is 100 s or more.
    fn read(self, bytes: &[u8], stamp: SimTime) -> Option<i64> {
        let nanoseconds = match self.unit {
            TimeUnit::Nanoseconds => return Some(i64::from(word(bytes, self.at))),
            TimeUnit::Seconds => f64::from(f32::from_bits(word(bytes, self.at))) * 1e9,
            TimeUnit::Epoch => since_stamp(long_word(bytes, self.at), stamp),
        };
        // Also false for NaN. The bound keeps the differences in `set_times` far from overflow.
        (nanoseconds.abs() < 1e11).then_some(nanoseconds as i64)
    }
}

/// Nanoseconds from the time stamp to a time since 1970 in seconds or nanoseconds.
fn since_stamp(time: f64, stamp: SimTime) -> f64 {
    /// From here on a number means nanoseconds: as seconds it would lie 30,000 years ahead.
    const MIN_NANOSECONDS: f64 = 1e12;
    // Subtracted as seconds: nanoseconds since 1970 exceed the precision of an f64.
    let (seconds, scale) = if time.abs() < MIN_NANOSECONDS {
        (stamp.0 as f64 * 1e-9, 1e9)
    } else {
        (stamp.0 as f64, 1.0)
    };
    (time - seconds) * scale
}

/// Sets the times of the points. The time stamp moves to the first point if that lies before it.
fn set_times(scan: &mut LidarScan, times: &[i64]) -> Option<()> {
    // Offsets are unsigned. Some drivers stamp a scan with its last point, so others lie before it.
    let first = times.iter().copied().min().unwrap_or_default().min(0);
    scan.stamp = SimTime(scan.stamp.0.checked_add_signed(first)?);
    for (point, time) in scan.points.iter_mut().zip(times) {
        // 32 bits of nanoseconds are 4.29 s, hence the limit in the error.
        point.offset_ns = u32::try_from(time - first).ok()?;
    }
    Some(())
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn long_word(bytes: &[u8], at: usize) -> f64 {
    f64::from_bits(u64::from(word(bytes, at)) | u64::from(word(bytes, at + 4)) << 32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::Message;

    fn scan() -> LidarScan {
        let point = |i: u8| LidarPoint {
            xyz: [f32::from(i), -0.5, 0.25],
            offset_ns: 5_000 * u32::from(i),
            reflectivity: 10 + i,
            line: i % 4,
        };
        LidarScan {
            stamp: SimTime::from_millis(100),
            points: (0..9).map(point).collect(),
        }
    }

    #[test]
    fn scans_round_trip() {
        let cloud = PointCloud2::from_cdr(&PointCloud2::from(&scan()).to_cdr()).unwrap();
        assert_eq!(cloud.data.len(), 9 * 21);
        assert_eq!(cloud.to_scan().unwrap(), scan());
        let empty = LidarScan::default();
        assert_eq!(PointCloud2::from(&empty).to_scan().unwrap(), empty);
    }

    /// A scan of two points whose times are in a field of this name and type.
    fn timed(name: &str, datatype: u8, times: [&[u8]; 2]) -> Result<LidarScan, CloudError> {
        let field = |name: &str, offset, datatype| PointField {
            name: name.into(),
            offset,
            datatype,
            count: 1,
        };
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
    fn times_are_read_from_the_fields_of_other_drivers() {
        const STAMP: u64 = 1_700_000_000_000_000_000;
        let check = |scan: Result<LidarScan, CloudError>, stamp: u64, apart: u32| {
            let scan = scan.unwrap();
            assert!(
                scan.stamp.0.abs_diff(stamp) < 1_000,
                "{} {stamp}",
                scan.stamp.0
            );
            assert!(
                scan.points[1]
                    .offset_ns
                    .abs_diff(scan.points[0].offset_ns + apart)
                    < 1_000
            );
        };
        let ms50 = 50_000_000_u32;
        check(
            timed("t", UINT32, [&0_u32.to_le_bytes(), &ms50.to_le_bytes()]),
            STAMP,
            ms50,
        );
        check(
            timed(
                "time",
                FLOAT32,
                [&(-0.05_f32).to_le_bytes(), &0_f32.to_le_bytes()],
            ),
            STAMP - u64::from(ms50),
            ms50,
        );
        let (first, second) = (STAMP as f64 * 1e-9, STAMP as f64 * 1e-9 + 0.05);
        check(
            timed(
                "timestamp",
                FLOAT64,
                [&first.to_le_bytes(), &second.to_le_bytes()],
            ),
            STAMP,
            ms50,
        );
        let (first, second) = (STAMP as f64, STAMP as f64 + 5e7);
        check(
            timed(
                "timestamp",
                FLOAT64,
                [&first.to_le_bytes(), &second.to_le_bytes()],
            ),
            STAMP,
            ms50,
        );
        for bad in [f64::NAN, 0.0, 1e300] {
            assert_eq!(
                timed(
                    "timestamp",
                    FLOAT64,
                    [&first.to_le_bytes(), &bad.to_le_bytes()]
                ),
                Err(CloudError::Times("timestamp"))
            );
        }
        assert_eq!(
            timed(
                "time",
                FLOAT32,
                [&9_f32.to_le_bytes(), &0_f32.to_le_bytes()]
            ),
            Err(CloudError::Times("time"))
        );
    }

    #[test]
    fn inconsistent_clouds_are_refused() {
        let good = PointCloud2::from(&scan());
        for (width, point_step, row_step) in
            [(10, 21, 189), (9, 22, 189), (u32::MAX, u32::MAX, u32::MAX)]
        {
            let cloud = PointCloud2 {
                width,
                point_step,
                row_step,
                ..good.clone()
            };
            assert!(matches!(cloud.to_scan(), Err(CloudError::Layout { .. })));
        }
        let mut cloud = good.clone();
        cloud.fields[1].offset = u32::MAX;
        assert_eq!(cloud.to_scan(), Err(CloudError::MissingField("y")));
        let cloud = PointCloud2 {
            is_bigendian: true,
            ..good
        };
        assert_eq!(cloud.to_scan(), Err(CloudError::BigEndian));
    }

    #[test]
    fn an_excessive_height_is_refused() {
        let cloud = PointCloud2 {
            height: u32::MAX,
            width: 0,
            row_step: 0,
            point_step: 0,
            ..PointCloud2::default()
        };
        assert!(cloud.to_scan().is_err());
    }
}
