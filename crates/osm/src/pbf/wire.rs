//! Protocol buffers: fields of messages and rows of numbers, read in place.
//!
//! After *Encoding*, protobuf.dev. Groups, which are deprecated, are refused.

/// What is wrong.
pub(super) type Problem = &'static str;

const CUT: Problem = "a number or a field exceeds its message; the file is damaged";

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Value<'a> {
    /// A number of variable length.
    Number(u64),
    /// Text, a message, or a row of numbers.
    Bytes(&'a [u8]),
    /// A number of fixed length, which OSM does not use.
    Fixed,
}

impl<'a> Value<'a> {
    /// The bytes of a field that must be bytes.
    pub(super) fn bytes(self) -> Result<&'a [u8], Problem> {
        match self {
            Self::Bytes(bytes) => Ok(bytes),
            _ => Err("found a number instead of text, a message or a row of numbers"),
        }
    }

    /// The number of a field that must be a number.
    pub(super) fn number(self) -> Result<u64, Problem> {
        match self {
            Self::Number(number) => Ok(number),
            _ => Err("found something else instead of a number"),
        }
    }
}

/// A field of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Field<'a> {
    /// Which field of the message it is.
    pub(super) number: u64,
    pub(super) value: Value<'a>,
}

/// The fields of a message, in order. Nothing follows an error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    fn field(&mut self) -> Result<Field<'a>, Problem> {
        let key = take_number(&mut self.0)?;
        if key >> 3 == 0 {
            return Err("a field with the invalid number 0");
        }
        // The lowest three bits are the kind of the value, the others the field's number.
        let value = match key & 7 {
            0 => Value::Number(take_number(&mut self.0)?),
            1 => take(&mut self.0, 8).map(|_| Value::Fixed)?,
            2 => {
                let length = take_number(&mut self.0)?;
                Value::Bytes(take(&mut self.0, length)?)
            }
            5 => take(&mut self.0, 4).map(|_| Value::Fixed)?,
            _ => return Err("a field of unknown kind"),
        };
        Ok(Field {
            number: key >> 3,
            value,
        })
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<Field<'a>, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let field = self.field();
        // The position after an error is unknown, so what follows would be nonsense.
        if field.is_err() {
            self.0 = &[];
        }
        Some(field)
    }
}

/// A row of numbers of variable length. Nothing follows an error.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Numbers<'a>(pub(super) &'a [u8]);

impl<'a> Numbers<'a> {
    /// The numbers as differences from one sum to the next, beginning with 0: delta coding.
    pub(super) fn sums(self) -> impl Iterator<Item = Result<i64, Problem>> + use<'a> {
        let mut sum = 0_i64;
        self.map(move |step| {
            sum = sum
                .checked_add(signed(step?))
                .ok_or("a number that is too large")?;
            Ok(sum)
        })
    }
}

impl Iterator for Numbers<'_> {
    type Item = Result<u64, Problem>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let number = take_number(&mut self.0);
        if number.is_err() {
            self.0 = &[];
        }
        Some(number)
    }
}

/// A number whose sign is its lowest bit: zigzag coding.
#[inline]
pub(super) fn signed(number: u64) -> i64 {
    (number >> 1) as i64 ^ -((number & 1) as i64)
}

#[inline]
fn take_number(bytes: &mut &[u8]) -> Result<u64, Problem> {
    let mut number = 0;
    // Ten groups of seven bits hold 64 bits. More bytes, or a message that ends first, are an
    // error.
    for (i, byte) in bytes.iter().take(10).enumerate() {
        number |= u64::from(byte & 127) << (7 * i);
        if *byte < 128 {
            *bytes = &bytes[i + 1..];
            return Ok(number);
        }
    }
    Err(CUT)
}

fn take<'a>(bytes: &mut &'a [u8], length: u64) -> Result<&'a [u8], Problem> {
    let (taken, rest) = usize::try_from(length)
        .ok()
        .and_then(|l| bytes.split_at_checked(l))
        .ok_or(CUT)?;
    *bytes = rest;
    Ok(taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_read_in_turn() {
        let bytes = [0x08, 0x96, 0x01, 0x12, 2, b'h', b'i', 0x1D, 0, 0, 0, 0];
        let fields: Vec<_> = Fields(&bytes).collect();
        let values = [Value::Number(150), Value::Bytes(b"hi"), Value::Fixed];
        let expected: Vec<_> = (1..)
            .zip(values)
            .map(|(number, value)| Ok(Field { number, value }))
            .collect();
        assert_eq!(fields, expected);
    }

    #[test]
    fn truncated_or_endless_fields_are_the_last_error() {
        for bytes in [
            &[0x08_u8][..],
            &[0x12, 3, 1, 2],
            &[0xFF; 12],
            &[0x1D, 0, 0],
            &[0x0B],
            &[0x12, 0xFF, 0xFF, 0x7F],
        ] {
            let found: Vec<_> = Fields(bytes).collect();
            assert!(found.len() == 1 && found[0].is_err(), "{bytes:?}");
        }
        assert!(Numbers(&[0x80]).next().unwrap().is_err());
    }

    #[test]
    fn signs_and_sums() {
        assert_eq!(
            [0, 1, 2, u64::MAX, u64::MAX - 1].map(signed),
            [0, -1, 1, i64::MIN, i64::MAX]
        );
        assert_eq!(
            Numbers(&[20, 1, 4]).sums().collect::<Vec<_>>(),
            [Ok(10), Ok(9), Ok(11)]
        );
        let largest = [0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 2];
        assert!(Numbers(&largest).sums().nth(1).unwrap().is_err());
    }
}
