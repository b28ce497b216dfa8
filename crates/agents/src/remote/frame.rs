//! Messages on a stream of bytes: a length, four bytes little-endian, and as many bytes of
//! MessagePack.

use std::io::Read;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::link::{LinkError, MAX_FRAME_BYTES};

/// Bytes of the length before a message.
const LENGTH_BYTES: usize = 4;
/// Room that is made for a message at once: an image of the camera needs no more.
const EXPECTED_BYTES: usize = 1 << 20;
/// Depth of nested values of a message.
const MAX_DEPTH: usize = 32;

/// A message as it is written: its length, and its MessagePack.
///
/// # Errors
/// [`LinkError::TooLong`].
pub fn frame(message: &impl Serialize) -> Result<Vec<u8>, LinkError> {
    // The length is filled in when it is known.
    let mut bytes = vec![0; LENGTH_BYTES];
    let mut encoder = rmp_serde::Serializer::new(&mut bytes).with_struct_map();
    message.serialize(&mut encoder).map_err(unreadable)?;
    let length = bytes.len() - LENGTH_BYTES;
    if length > MAX_FRAME_BYTES {
        return Err(LinkError::TooLong { bytes: length });
    }
    bytes[..LENGTH_BYTES].copy_from_slice(&(length as u32).to_le_bytes());
    Ok(bytes)
}

/// Reads a message; `None` at the end of the stream.
///
/// Beyond a mebibyte memory grows with what arrives, not with the length that is announced.
///
/// # Errors
/// [`LinkError::TooLong`], [`LinkError::Unreadable`], or [`LinkError::Ended`] in the midst of a
/// message.
pub fn read_frame<M: DeserializeOwned>(reader: &mut impl Read) -> Result<Option<M>, LinkError> {
    let mut length = [0; LENGTH_BYTES];
    match read_up_to(reader, &mut length)? {
        0 => return Ok(None),
        LENGTH_BYTES => {}
        _ => return Err(LinkError::ended("in the midst of a message")),
    }
    let length = u32::from_le_bytes(length) as usize;
    if length > MAX_FRAME_BYTES {
        return Err(LinkError::TooLong { bytes: length });
    }
    let mut body = Vec::with_capacity(length.min(EXPECTED_BYTES));
    reader.take(length as u64).read_to_end(&mut body)?;
    if body.len() < length {
        return Err(LinkError::ended("in the midst of a message"));
    }
    from_bytes(&body).map(Some)
}

/// A message from MessagePack.
///
/// # Errors
/// [`LinkError::Unreadable`]; also if bytes follow the message.
pub fn from_bytes<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, LinkError> {
    let mut decoder = rmp_serde::Deserializer::new(bytes);
    decoder.set_max_depth(MAX_DEPTH);
    let message = M::deserialize(&mut decoder).map_err(unreadable)?;
    match decoder.get_ref().len() {
        0 => Ok(message),
        left => Err(unreadable(format!("{left} bytes follow it"))),
    }
}

fn unreadable(error: impl std::fmt::Display) -> LinkError {
    LinkError::Unreadable {
        detail: error.to_string(),
    }
}

/// Reads until `buffer` is full or the stream ends; returns the number of bytes.
fn read_up_to(reader: &mut impl Read, buffer: &mut [u8]) -> Result<usize, LinkError> {
    let mut got = 0;
    while got < buffer.len() {
        match reader.read(&mut buffer[got..]) {
            Ok(0) => break,
            Ok(more) => got += more,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(got)
}

#[cfg(test)]
mod tests {
    use openbench_core::{Action, LidarPoint, LidarScan, SimTime, Velocity};
    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;
    use crate::remote::message::{Reply, Report, Request, Scan};

    #[test]
    fn messages_come_back_as_they_were_sent() {
        let scan = LidarScan {
            stamp: SimTime::from_millis(100),
            points: vec![
                LidarPoint {
                    xyz: [1.5, -2.0, 0.1],
                    offset_ns: 70_000,
                    reflectivity: 200,
                    line: 3,
                };
                3
            ],
        };
        let requests = [
            Request::Scan(Some(Scan::from(&scan))),
            Request::Scan(None),
            Request::Finish,
        ];
        let mut stream = Vec::new();
        for request in &requests {
            stream.extend(frame(request).unwrap());
        }
        let mut reader = &stream[..];
        for request in requests {
            assert_eq!(read_frame(&mut reader).unwrap(), Some(request));
        }
        assert_eq!(read_frame::<Request>(&mut reader).unwrap(), None);
    }

    #[test]
    fn numbers_keep_each_bit() {
        let velocity = Velocity::new(0.1 + 0.2, f64::MIN_POSITIVE);
        let reply = Reply::Action {
            action: Action::Drive(velocity),
            reports: vec![Report::Note("näher".into())],
        };
        let bytes = frame(&reply).unwrap();
        assert_eq!(read_frame(&mut &bytes[..]).unwrap(), Some(reply));
    }

    #[test]
    fn a_length_that_is_announced_takes_no_memory() {
        let huge = u32::MAX.to_le_bytes();
        let error = read_frame::<Reply>(&mut &huge[..]).unwrap_err();
        assert!(matches!(error, LinkError::TooLong { .. }), "{error}");
        let mut short = 1_000_u32.to_le_bytes().to_vec();
        short.extend([0; 10]);
        let error = read_frame::<Reply>(&mut &short[..]).unwrap_err();
        assert!(matches!(error, LinkError::Ended { .. }), "{error}");
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_message_or_an_error(bytes in vec(any::<u8>(), 0..200)) {
            let _ = from_bytes::<Reply>(&bytes);
            let _ = read_frame::<Request>(&mut &bytes[..]);
        }
    }
}
