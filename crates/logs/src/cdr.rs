//! Encoding of a message: OMG CDR version 1, plain, little-endian, as ROS 2 writes it.
//!
//! A message begins with the encapsulation header `00 01 00 00`. Numbers are aligned to their own
//! size, counted from the end of that header. Strings have their length in front, including the
//! terminating zero byte. Sequences have their number of elements in front; arrays do not.
//!
//! Big-endian encodings, parameter lists and XCDR2 are refused: no ROS 2 middleware writes them by
//! default.

const ENCAPSULATION: [u8; 4] = [0x00, 0x01, 0x00, 0x00];

/// Why bytes are not a message of the expected type.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CdrError {
    /// The message ends before its last field.
    #[error("{wanted} more bytes were expected at byte {at}, but the message has {len}")]
    UnexpectedEnd {
        /// Position of the read, including the encapsulation header, bytes.
        at: usize,
        /// Number of bytes needed.
        wanted: usize,
        /// Length of the message, bytes.
        len: usize,
    },
    /// The encoding is not plain little-endian CDR.
    #[error("encapsulation {0:02x?} is not plain little-endian CDR (00 01)")]
    Encapsulation([u8; 2]),
    /// A sequence declares more elements than the rest of the message can contain.
    #[error(
        "the sequence at byte {at} declares {count} elements, more than the message can contain"
    )]
    SequenceTooLong {
        /// Where the sequence begins, bytes.
        at: usize,
        /// The declared number of elements.
        count: u32,
    },
    /// A string is not UTF-8 or lacks its terminating zero byte.
    #[error("the string at byte {at} is not UTF-8 with a terminating zero byte")]
    String {
        /// Where the string begins, bytes.
        at: usize,
    },
    /// A value is outside the range of its type.
    #[error("{0}")]
    Value(String),
}

/// Writes the fields of one message in order.
#[derive(Debug, Clone)]
pub struct CdrWriter {
    bytes: Vec<u8>,
}

macro_rules! write_number {
    ($($name:ident: $t:ty),*) => {$(
        #[doc = concat!("Writes one `", stringify!($t), "`, aligned to its size.")]
        pub fn $name(&mut self, value: $t) {
            self.align(size_of::<$t>());
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
    )*};
}

impl Default for CdrWriter {
    fn default() -> Self {
        Self::new()
    }
}

impl CdrWriter {
    /// A message that contains only its encapsulation header.
    pub fn new() -> Self {
        Self {
            bytes: ENCAPSULATION.to_vec(),
        }
    }

    /// Removes all fields and keeps the allocated memory.
    pub fn clear(&mut self) {
        self.bytes.truncate(ENCAPSULATION.len());
    }

    /// The message written so far, including its encapsulation header.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn align(&mut self, size: usize) {
        // Alignment is counted behind the encapsulation header, whose length of 4 would shift
        // numbers of 8 bytes.
        let position = self.bytes.len() - ENCAPSULATION.len();
        self.bytes
            .resize(ENCAPSULATION.len() + position.next_multiple_of(size), 0);
    }

    write_number!(u8: u8, u16: u16, u32: u32, i32: i32, u64: u64, f32: f32, f64: f64);

    /// Writes a boolean as one byte.
    pub fn bool(&mut self, value: bool) {
        self.u8(u8::from(value));
    }

    /// Writes the number of elements of the sequence that follows.
    ///
    /// CDR cannot express more than 2³² - 1 elements; a larger number is written as that.
    pub fn count(&mut self, elements: usize) {
        self.u32(u32::try_from(elements).unwrap_or(u32::MAX));
    }

    /// Writes a string: its length including the terminating zero byte, its bytes, the zero byte.
    pub fn string(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
    }

    /// Writes a sequence of bytes.
    pub fn octets(&mut self, octets: &[u8]) {
        self.count(octets.len());
        self.bytes.extend_from_slice(octets);
    }

    /// Writes the elements of an array, without their number.
    pub fn f64_array(&mut self, values: &[f64]) {
        values.iter().for_each(|&v| self.f64(v));
    }

    /// Writes a sequence of numbers, with its length.
    pub fn f64_sequence(&mut self, values: &[f64]) {
        self.count(values.len());
        self.f64_array(values);
    }
}

/// Reads the fields of one message in order.
///
/// Each length is checked against the remaining bytes before memory is allocated.
#[derive(Debug, Clone)]
pub struct CdrReader<'a> {
    bytes: &'a [u8],
    position: usize,
}

macro_rules! read_number {
    ($($name:ident: $t:ty),*) => {$(
        #[doc = concat!("Reads one `", stringify!($t), "`, aligned to its size.")]
        pub fn $name(&mut self) -> Result<$t, CdrError> {
            self.align(size_of::<$t>());
            let mut raw = [0; size_of::<$t>()];
            raw.copy_from_slice(self.take(size_of::<$t>())?);
            Ok(<$t>::from_le_bytes(raw))
        }
    )*};
}

impl<'a> CdrReader<'a> {
    /// Checks the encapsulation header and begins at the first field.
    ///
    /// # Errors
    /// [`CdrError::Encapsulation`], [`CdrError::UnexpectedEnd`].
    pub fn new(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let mut reader = Self { bytes, position: 0 };
        let header = reader.take(ENCAPSULATION.len())?;
        // The other two bytes are options, which plain CDR does not use.
        if header[..2] != ENCAPSULATION[..2] {
            return Err(CdrError::Encapsulation([header[0], header[1]]));
        }
        Ok(reader)
    }

    fn align(&mut self, size: usize) {
        let position = self.position - ENCAPSULATION.len();
        self.position = ENCAPSULATION.len() + position.next_multiple_of(size);
    }

    fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.position)
    }

    fn take(&mut self, wanted: usize) -> Result<&'a [u8], CdrError> {
        // `align` may have moved the position behind the end, hence the `min` below; the slice is
        // only made if `end` is valid.
        let end = self
            .position
            .checked_add(wanted)
            .filter(|&end| end <= self.bytes.len());
        let error = CdrError::UnexpectedEnd {
            at: self.position,
            wanted,
            len: self.bytes.len(),
        };
        let taken = &self.bytes[self.position.min(self.bytes.len())..end.ok_or(error)?];
        self.position += wanted;
        Ok(taken)
    }

    read_number!(u8: u8, u16: u16, u32: u32, i32: i32, u64: u64, f32: f32, f64: f64);

    /// Reads a boolean; every byte except zero is true.
    pub fn bool(&mut self) -> Result<bool, CdrError> {
        Ok(self.u8()? != 0)
    }

    /// Reads the number of elements of a sequence, each of which takes at least `smallest` bytes.
    ///
    /// # Errors
    /// [`CdrError::SequenceTooLong`] if that many do not fit into the remaining bytes.
    pub fn count(&mut self, smallest: usize) -> Result<usize, CdrError> {
        let at = self.position;
        let count = self.u32()?;
        // At least one byte for each element, so that the count bounds the memory. In u64 the
        // product cannot overflow for sizes of a few bytes.
        let fits = u64::from(count) * smallest.max(1) as u64 <= self.remaining() as u64;
        if fits {
            Ok(count as usize)
        } else {
            Err(CdrError::SequenceTooLong { at, count })
        }
    }

    /// Reads a string.
    pub fn string(&mut self) -> Result<String, CdrError> {
        let at = self.position;
        let len = self.count(1)?;
        let raw = self.take(len)?;
        let text = match raw {
            // Some writers omit the zero byte of an empty string.
            [] => Some(""),
            [text @ .., 0] => std::str::from_utf8(text).ok(),
            _ => None,
        };
        text.map(str::to_owned).ok_or(CdrError::String { at })
    }

    /// Reads a sequence of bytes.
    pub fn octets(&mut self) -> Result<&'a [u8], CdrError> {
        let len = self.count(1)?;
        self.take(len)
    }

    /// Reads an array of numbers, whose length is not in the message.
    pub fn f64_array<const N: usize>(&mut self) -> Result<[f64; N], CdrError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// Reads a sequence, each element of which takes at least `smallest` bytes.
    pub fn sequence<T>(
        &mut self,
        smallest: usize,
        mut element: impl FnMut(&mut Self) -> Result<T, CdrError>,
    ) -> Result<Vec<T>, CdrError> {
        let count = self.count(smallest)?;
        (0..count).map(|_| element(self)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_are_aligned_from_the_end_of_the_header() {
        let mut w = CdrWriter::new();
        w.u8(7);
        w.f64(1.0);
        w.u8(8);
        w.u16(0x0201);
        let mut expected = vec![0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
        expected.extend(1.0f64.to_le_bytes());
        expected.extend([8, 0, 1, 2]);
        assert_eq!(w.as_bytes(), expected);
    }

    #[test]
    fn strings_end_with_a_zero_byte() {
        let mut w = CdrWriter::new();
        w.string("map");
        assert_eq!(w.as_bytes(), [0, 1, 0, 0, 4, 0, 0, 0, b'm', b'a', b'p', 0]);
        assert_eq!(
            CdrReader::new(w.as_bytes()).unwrap().string().unwrap(),
            "map"
        );
    }

    #[test]
    fn a_string_without_zero_byte_is_refused() {
        let bytes = [0, 1, 0, 0, 3, 0, 0, 0, b'm', b'a', b'p'];
        assert_eq!(
            CdrReader::new(&bytes).unwrap().string(),
            Err(CdrError::String { at: 4 })
        );
    }

    #[test]
    fn hostile_lengths_allocate_no_memory() {
        let bytes = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 0, 0];
        let error = CdrReader::new(&bytes)
            .unwrap()
            .sequence(8, CdrReader::f64)
            .unwrap_err();
        assert_eq!(
            error,
            CdrError::SequenceTooLong {
                at: 4,
                count: u32::MAX
            }
        );
        assert!(CdrReader::new(&bytes).unwrap().octets().is_err());
    }

    #[test]
    fn other_encapsulations_are_refused() {
        let error = CdrReader::new(&[0, 0, 0, 0]).unwrap_err();
        assert_eq!(error, CdrError::Encapsulation([0, 0]));
        assert!(matches!(
            CdrReader::new(&[0, 1]),
            Err(CdrError::UnexpectedEnd { .. })
        ));
    }

    proptest! {
        #[test]
        fn written_fields_are_read_back(
            a: u8,
            text in ".{0,12}",
            b: f64,
            c: Vec<u8>,
            d: Vec<f64>,
            e: i32,
        ) {
            let mut w = CdrWriter::new();
            w.u8(a);
            w.string(&text);
            w.f64(b);
            w.octets(&c);
            w.f64_sequence(&d);
            w.i32(e);
            let mut r = CdrReader::new(w.as_bytes()).unwrap();
            prop_assert_eq!(r.u8().unwrap(), a);
            prop_assert_eq!(r.string().unwrap(), text);
            prop_assert_eq!(r.f64().unwrap().to_bits(), b.to_bits());
            prop_assert_eq!(r.octets().unwrap(), &c[..]);
            let read = r.sequence(8, CdrReader::f64).unwrap();
            prop_assert!(read.iter().map(|v| v.to_bits()).eq(d.iter().map(|v| v.to_bits())));
            prop_assert_eq!(r.i32().unwrap(), e);
            prop_assert_eq!(r.remaining(), 0);
        }
    }
}
