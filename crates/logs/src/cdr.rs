//! The bytes of a message: OMG CDR version 1, plain, little-endian (encapsulation `00 01 00 00`), as ROS 2 writes it.
//!
//! Numbers are aligned to their own size, counted from the end of the encapsulation header. Strings carry their length,
//! the terminating zero included; sequences carry their number of elements; arrays carry nothing.
//!
//! Not done: big-endian, parameter lists and XCDR2, which no ROS 2 middleware writes by default; they are refused.

const ENCAPSULATION: [u8; 4] = [0x00, 0x01, 0x00, 0x00];

/// Bytes that are no message of the type that was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// The message ends before its last field.
    #[error("{wanted} more bytes were expected at byte {at}, but the message has {len}")]
    UnexpectedEnd {
        /// Where reading stood, the encapsulation header included.
        at: usize,
        /// How many bytes were wanted.
        wanted: usize,
        /// How many bytes there are.
        len: usize,
    },
    /// Not little-endian plain CDR.
    #[error("encapsulation {0:02x?} is not plain little-endian CDR (00 01)")]
    Encapsulation([u8; 2]),
    /// A sequence that claims more elements than the message can hold.
    #[error("a sequence at byte {at} claims {count} elements, more than the message can hold")]
    SequenceTooLong {
        /// Where the sequence begins.
        at: usize,
        /// What it claims.
        count: u32,
    },
    /// A string that is not UTF-8 or lacks its terminating zero.
    #[error("the string at byte {at} is not UTF-8 with a terminating zero")]
    String {
        /// Where the string begins.
        at: usize,
    },
    /// A value that the type does not allow.
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
    /// A message that has nothing but its encapsulation header.
    pub fn new() -> Self {
        Self { bytes: ENCAPSULATION.to_vec() }
    }

    /// Forgets the fields and keeps the memory.
    pub fn clear(&mut self) {
        self.bytes.truncate(ENCAPSULATION.len());
    }

    /// The message so far, its encapsulation header included.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn align(&mut self, size: usize) {
        let position = self.bytes.len() - ENCAPSULATION.len();
        self.bytes.resize(ENCAPSULATION.len() + position.next_multiple_of(size), 0);
    }

    write_number!(u8: u8, u16: u16, u32: u32, i32: i32, u64: u64, f32: f32, f64: f64);

    /// Writes a boolean as one byte.
    pub fn bool(&mut self, value: bool) {
        self.u8(u8::from(value));
    }

    /// Writes the number of elements of the sequence that follows. A sequence of more than 2^32 - 1 elements cannot be
    /// written in CDR; its count is cut there.
    pub fn count(&mut self, elements: usize) {
        self.u32(u32::try_from(elements).unwrap_or(u32::MAX));
    }

    /// Writes a string: length with the terminating zero, bytes, zero.
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

    /// Writes the elements of an array, which carries no count.
    pub fn f64_array(&mut self, values: &[f64]) {
        values.iter().for_each(|&v| self.f64(v));
    }

    /// Writes a sequence of numbers.
    pub fn f64_sequence(&mut self, values: &[f64]) {
        self.count(values.len());
        self.f64_array(values);
    }
}

/// Reads the fields of one message in order. Every length is checked against what is left before memory is set aside.
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
    /// Checks the encapsulation header and stands before the first field.
    pub fn new(bytes: &'a [u8]) -> Result<Self, CdrError> {
        let mut reader = Self { bytes, position: 0 };
        let header = reader.take(ENCAPSULATION.len())?;
        if header[..2] != ENCAPSULATION[..2] {
            return Err(CdrError::Encapsulation([header[0], header[1]]));
        }
        Ok(reader)
    }

    fn align(&mut self, size: usize) {
        let position = self.position - ENCAPSULATION.len();
        self.position = ENCAPSULATION.len() + position.next_multiple_of(size);
    }

    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.position)
    }

    fn take(&mut self, wanted: usize) -> Result<&'a [u8], CdrError> {
        let end = self.position.checked_add(wanted).filter(|&end| end <= self.bytes.len());
        let error = CdrError::UnexpectedEnd { at: self.position, wanted, len: self.bytes.len() };
        let taken = &self.bytes[self.position.min(self.bytes.len())..end.ok_or(error)?];
        self.position += wanted;
        Ok(taken)
    }

    read_number!(u8: u8, u16: u16, u32: u32, i32: i32, u64: u64, f32: f32, f64: f64);

    /// Reads a boolean; any byte but zero is true.
    pub fn bool(&mut self) -> Result<bool, CdrError> {
        Ok(self.u8()? != 0)
    }

    /// Reads the number of elements of a sequence whose elements take at least `smallest` bytes each.
    pub fn count(&mut self, smallest: usize) -> Result<usize, CdrError> {
        let at = self.position;
        let count = self.u32()?;
        let fits = u64::from(count) * smallest.max(1) as u64 <= self.left() as u64;
        if fits { Ok(count as usize) } else { Err(CdrError::SequenceTooLong { at, count }) }
    }

    /// Reads a string.
    pub fn string(&mut self) -> Result<String, CdrError> {
        let at = self.position;
        let len = self.count(1)?;
        let raw = self.take(len)?;
        let text = match raw {
            [] => Some(""), // some writers leave out the zero of an empty string
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

    /// Reads an array of numbers, which carries no count.
    pub fn f64_array<const N: usize>(&mut self) -> Result<[f64; N], CdrError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// Reads a sequence whose elements take at least `smallest` bytes each.
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
    fn strings_carry_their_zero() {
        let mut w = CdrWriter::new();
        w.string("map");
        assert_eq!(w.as_bytes(), [0, 1, 0, 0, 4, 0, 0, 0, b'm', b'a', b'p', 0]);
        assert_eq!(CdrReader::new(w.as_bytes()).unwrap().string().unwrap(), "map");
    }

    #[test]
    fn a_string_without_its_zero_is_refused() {
        let bytes = [0, 1, 0, 0, 3, 0, 0, 0, b'm', b'a', b'p'];
        assert_eq!(CdrReader::new(&bytes).unwrap().string(), Err(CdrError::String { at: 4 }));
    }

    #[test]
    fn hostile_counts_set_no_memory_aside() {
        let bytes = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 0, 0];
        let error = CdrReader::new(&bytes).unwrap().sequence(8, CdrReader::f64).unwrap_err();
        assert_eq!(error, CdrError::SequenceTooLong { at: 4, count: u32::MAX });
        assert!(CdrReader::new(&bytes).unwrap().octets().is_err());
    }

    #[test]
    fn big_endian_is_refused_by_name() {
        let error = CdrReader::new(&[0, 0, 0, 0]).unwrap_err();
        assert_eq!(error, CdrError::Encapsulation([0, 0]));
        assert!(matches!(CdrReader::new(&[0, 1]), Err(CdrError::UnexpectedEnd { .. })));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(a: u8, text in ".{0,12}", b: f64, c: Vec<u8>, d: Vec<f64>, e: i32) {
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
            prop_assert_eq!(r.left(), 0);
        }
    }
}
