//! `builtin_interfaces/Time`, `rosgraph_msgs/Clock`, `std_msgs/Header`, `std_msgs/String`.

use openbench_core::SimTime;

use super::{Definition, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

/// `builtin_interfaces/Time`: simulated time since the beginning of the episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Time(pub SimTime);

impl Message for Time {
    const DEFINITION: &'static Definition = &Definition {
        name: "builtin_interfaces/Time",
        fields: "int32 sec\nuint32 nanosec\n",
        parts: &[],
    };

    /// Seconds that the type cannot express (more than 68 years) are written as its maximum.
    fn encode(&self, out: &mut CdrWriter) {
        out.i32(i32::try_from(self.0.0 / 1_000_000_000).unwrap_or(i32::MAX));
        out.u32((self.0.0 % 1_000_000_000) as u32);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let (seconds, nanos) = (input.i32()?, input.u32()?);
        let seconds = u64::try_from(seconds)
            .map_err(|_| CdrError::Value(format!("the time stamp of {seconds} s is negative")))?;
        Ok(Self(SimTime(seconds * 1_000_000_000 + u64::from(nanos))))
    }
}

/// `rosgraph_msgs/Clock`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Clock(pub SimTime);

impl Message for Clock {
    const DEFINITION: &'static Definition = &Definition {
        name: "rosgraph_msgs/Clock",
        fields: "builtin_interfaces/Time clock\n",
        parts: &[Time::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        Time(self.0).encode(out);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self(Time::decode(input)?.0))
    }
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Header {
    /// Time to which the message refers.
    pub stamp: SimTime,
    /// Frame of the data: `map`, `odom`, `base_link`, `livox_frame`, `camera_optical`, …
    pub frame_id: String,
}

impl Header {
    /// A header with this time stamp and frame.
    pub fn new(stamp: SimTime, frame_id: impl Into<String>) -> Self {
        Self {
            stamp,
            frame_id: frame_id.into(),
        }
    }
}

impl Message for Header {
    const DEFINITION: &'static Definition = &Definition {
        name: "std_msgs/Header",
        fields: "builtin_interfaces/Time stamp\nstring frame_id\n",
        parts: &[Time::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        Time(self.stamp).encode(out);
        out.string(&self.frame_id);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            stamp: Time::decode(input)?.0,
            frame_id: input.string()?,
        })
    }
}

/// `std_msgs/String`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StringMessage(pub String);

impl Message for StringMessage {
    const DEFINITION: &'static Definition = &Definition {
        name: "std_msgs/String",
        fields: "string data\n",
        parts: &[],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.string(&self.0);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self(input.string()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_encoded_as_in_ros() {
        let bytes = Header::new(SimTime(1_500_000_000), "map").to_cdr();
        let expected = [
            0, 1, 0, 0, 1, 0, 0, 0, 0, 0x65, 0xcd, 0x1d, 4, 0, 0, 0, b'm', b'a', b'p', 0,
        ];
        assert_eq!(bytes, expected);
        assert_eq!(
            Header::from_cdr(&bytes).unwrap(),
            Header::new(SimTime(1_500_000_000), "map")
        );
    }

    #[test]
    fn a_negative_time_stamp_is_refused() {
        let bytes = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0];
        assert!(matches!(Time::from_cdr(&bytes), Err(CdrError::Value(_))));
    }
}
