//! Arrays of NumPy in MessagePack: a map with the keys `__ndarray__`, `data` (bytes), `dtype` (as
//! `numpy.dtype.str`) and `shape`.
//!
//! openpi writes the keys as bytes, vla-eval as text. Both are read.

use openbench_core::Image;
use rmpv::Value;

use super::error::ServerError;
use super::limits::{MAX_COLUMNS, MAX_ROWS};

/// Depth of nested values of an answer.
const MAX_DEPTH: usize = 32;
/// Dimensions of an array, those of length one in front included.
const MAX_DIMENSIONS: usize = 4;

/// How the keys of an array are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keys {
    /// As bytes.
    Bytes,
    /// As text.
    Text,
}

impl Keys {
    fn key(self, name: &str) -> Value {
        match self {
            Self::Bytes => Value::Binary(name.as_bytes().to_vec()),
            Self::Text => Value::from(name),
        }
    }

    fn array(self, data: Vec<u8>, dtype: &str, shape: &[usize]) -> Value {
        let shape = shape.iter().map(|side| Value::from(*side as u64)).collect();
        Value::Map(vec![
            (self.key("__ndarray__"), Value::from(true)),
            (self.key("data"), Value::Binary(data)),
            (self.key("dtype"), Value::from(dtype)),
            (self.key("shape"), Value::Array(shape)),
        ])
    }

    /// An image as `uint8`, rows x columns x 3.
    pub fn image(self, image: &Image) -> Value {
        let shape = [image.height as usize, image.width as usize, 3];
        self.array(image.rgb.clone(), "|u1", &shape)
    }

    /// Numbers as `float32`.
    pub fn floats(self, numbers: &[f64]) -> Value {
        let bytes = numbers.iter().flat_map(|n| (*n as f32).to_le_bytes());
        self.array(bytes.collect(), "<f4", &[numbers.len()])
    }
}

/// A message as MessagePack.
pub fn to_bytes(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing to memory does not fail.
    let written = rmpv::encode::write_value(&mut bytes, value);
    debug_assert!(written.is_ok());
    bytes
}

/// A message from MessagePack, which has to be a map.
///
/// # Errors
/// [`ServerError::Unreadable`].
pub fn from_bytes(bytes: &[u8]) -> Result<Value, ServerError> {
    let mut left = bytes;
    let value = rmpv::decode::read_value_with_max_depth(&mut left, MAX_DEPTH)
        .map_err(|error| ServerError::unreadable(format!("it is no MessagePack: {error}")))?;
    if !left.is_empty() {
        let detail = format!("{} bytes follow the message", left.len());
        return Err(ServerError::unreadable(detail));
    }
    if !value.is_map() {
        return Err(ServerError::unreadable("it is no map"));
    }
    Ok(value)
}

/// The value of a key of a map, which may be written as text or as bytes.
pub fn entry<'a>(map: &'a Value, key: &str) -> Option<&'a Value> {
    let entries = map.as_map()?;
    let named = |(name, _): &&(Value, Value)| match name {
        Value::String(text) => text.as_bytes() == key.as_bytes(),
        Value::Binary(bytes) => bytes == key.as_bytes(),
        _ => false,
    };
    entries.iter().find(named).map(|(_, value)| value)
}

/// A text, which may be written as bytes.
pub fn text(value: &Value) -> Option<&str> {
    match value {
        Value::String(text) => text.as_str(),
        Value::Binary(bytes) => std::str::from_utf8(bytes).ok(),
        _ => None,
    }
}

/// Finite numbers in rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    columns: usize,
    numbers: Vec<f64>,
}

impl Rows {
    /// The rows of an array, or of nested lists: one row, or rows x columns; further dimensions in
    /// front have the length one.
    ///
    /// # Errors
    /// [`ServerError`] with what is wrong with it.
    pub fn read(value: &Value) -> Result<Self, ServerError> {
        let array = match entry(value, "__ndarray__") {
            Some(_) => Array::read(value)?,
            None => Array::of_lists(value)?,
        };
        Self::of(array)
    }

    /// Rows of numbers with this shape.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn of(array: Array) -> Result<Self, ServerError> {
        let Array { shape, numbers } = array;
        let extra = shape.len().saturating_sub(2);
        let is_row = |side: &usize| *side == 1;
        if shape.is_empty() || !shape[..extra].iter().all(is_row) {
            return Err(ServerError::unreadable(format!(
                "an array of the shape {shape:?} is no list of actions"
            )));
        }
        let columns = shape[shape.len() - 1];
        if columns > MAX_COLUMNS || numbers.len() > MAX_ROWS * columns {
            return Err(ServerError::TooLong);
        }
        if columns == 0 || numbers.is_empty() {
            return Err(ServerError::unreadable("it has no actions"));
        }
        match numbers.iter().position(|number| !number.is_finite()) {
            Some(index) => Err(ServerError::NotFinite {
                row: index / columns,
            }),
            None => Ok(Self { columns, numbers }),
        }
    }

    /// The rows, which have at least `least` columns.
    ///
    /// # Errors
    /// [`ServerError::Unreadable`] if they have fewer.
    pub fn with_columns(
        &self,
        least: usize,
        names: &str,
    ) -> Result<impl Iterator<Item = &[f64]>, ServerError> {
        if self.columns < least {
            let columns = self.columns;
            return Err(ServerError::unreadable(format!(
                "actions have {columns} columns and need {least}: {names}"
            )));
        }
        Ok(self.numbers.chunks_exact(self.columns))
    }
}

/// Numbers with a shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    shape: Vec<usize>,
    numbers: Vec<f64>,
}

impl Array {
    fn read(value: &Value) -> Result<Self, ServerError> {
        let missing = |key: &str| ServerError::unreadable(format!("an array lacks `{key}`"));
        let data = entry(value, "data").and_then(Value::as_slice);
        let data = data.ok_or_else(|| missing("data"))?;
        let dtype = entry(value, "dtype").and_then(text);
        let dtype = dtype.ok_or_else(|| missing("dtype"))?;
        let sides = entry(value, "shape").and_then(Value::as_array);
        let sides = sides.ok_or_else(|| missing("shape"))?;
        let sides = sides
            .iter()
            .map(|side| usize::try_from(side.as_u64()?).ok());
        let shape: Option<Vec<usize>> = sides.collect();
        let shape = shape.filter(|shape| shape.len() <= MAX_DIMENSIONS);
        let shape = shape.ok_or_else(|| ServerError::unreadable("an array has an odd shape"))?;
        let kind = Kind::read(dtype)?;
        let length = shape
            .iter()
            .try_fold(kind.bytes(), |product, side| product.checked_mul(*side));
        if length != Some(data.len()) {
            return Err(ServerError::unreadable(format!(
                "an array of the shape {shape:?} and the dtype {dtype} has {} bytes",
                data.len()
            )));
        }
        let numbers = data
            .chunks_exact(kind.bytes())
            .map(|bytes| kind.number(bytes));
        Ok(Self {
            shape,
            numbers: numbers.collect(),
        })
    }

    /// Numbers, or lists of numbers of one length, or those in a list.
    fn of_lists(value: &Value) -> Result<Self, ServerError> {
        let mut array = Self {
            shape: Vec::new(),
            numbers: Vec::new(),
        };
        array.gather(value, 0)?;
        Ok(array)
    }

    fn gather(&mut self, value: &Value, depth: usize) -> Result<(), ServerError> {
        let odd = || ServerError::unreadable("actions are no array and no lists of numbers");
        let Some(values) = value.as_array() else {
            // All numbers are as deep as the first one.
            if depth != self.shape.len() {
                return Err(odd());
            }
            self.numbers.push(number(value).ok_or_else(odd)?);
            return Ok(());
        };
        // The first list of a depth says how long those of this depth are.
        if depth == self.shape.len() && self.numbers.is_empty() && depth < MAX_DIMENSIONS {
            self.shape.push(values.len());
        }
        if self.shape.get(depth) != Some(&values.len()) {
            return Err(odd());
        }
        values
            .iter()
            .try_for_each(|value| self.gather(value, depth + 1))
    }

    /// Numbers of a shape that is known.
    pub fn new(shape: Vec<usize>, numbers: Vec<f64>) -> Self {
        Self { shape, numbers }
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Boolean(yes) => Some(f64::from(u8::from(*yes))),
        value => value.as_f64(),
    }
}

/// A kind of number, little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Float32,
    Float64,
    Int32,
    Int64,
    Byte,
}

impl Kind {
    fn read(dtype: &str) -> Result<Self, ServerError> {
        match dtype {
            "<f4" | "float32" => Ok(Self::Float32),
            "<f8" | "float64" => Ok(Self::Float64),
            "<i4" | "int32" => Ok(Self::Int32),
            "<i8" | "int64" => Ok(Self::Int64),
            "|u1" | "|b1" | "uint8" | "bool" => Ok(Self::Byte),
            _ => {
                let shown: String = dtype.chars().take(20).collect();
                Err(ServerError::unreadable(format!(
                    "an array has the dtype {shown}; send float32 or float64"
                )))
            }
        }
    }

    const fn bytes(self) -> usize {
        match self {
            Self::Float32 | Self::Int32 => 4,
            Self::Float64 | Self::Int64 => 8,
            Self::Byte => 1,
        }
    }

    /// The number of as many bytes as [`bytes`](Self::bytes) says.
    fn number(self, bytes: &[u8]) -> f64 {
        let mut whole = [0; 8];
        whole[..bytes.len()].copy_from_slice(bytes);
        let [a, b, c, d, ..] = whole;
        match self {
            Self::Float32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::Float64 => f64::from_le_bytes(whole),
            Self::Int32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::Int64 => i64::from_le_bytes(whole) as f64,
            Self::Byte => f64::from(a),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;

    fn rows(value: &Value) -> Result<Vec<Vec<f64>>, ServerError> {
        let rows = Rows::read(value)?;
        let rows = rows.with_columns(2, "x, y")?;
        Ok(rows.map(<[f64]>::to_vec).collect())
    }

    fn floats(shape: &[usize], numbers: &[f64]) -> Value {
        let bytes = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        Keys::Text.array(bytes, "<f8", shape)
    }

    #[test]
    fn arrays_of_both_notations_come_back() {
        for keys in [Keys::Bytes, Keys::Text] {
            let bytes = to_bytes(&Value::Map(vec![(
                keys.key("actions"),
                keys.floats(&[0.5, -0.25]),
            )]));
            let message = from_bytes(&bytes).unwrap();
            let actions = entry(&message, "actions").unwrap();
            assert_eq!(rows(actions).unwrap(), [[0.5, -0.25]]);
        }
    }

    #[test]
    fn rows_may_be_an_array_or_lists_with_a_batch_of_one() {
        let expected = [[1.0, 2.0], [3.0, 4.0]];
        let numbers = [1.0, 2.0, 3.0, 4.0];
        for shape in [&[2, 2][..], &[1, 2, 2]] {
            assert_eq!(rows(&floats(shape, &numbers)).unwrap(), expected);
        }
        let list =
            |numbers: &[f64]| Value::Array(numbers.iter().copied().map(Value::from).collect());
        let lists = Value::Array(vec![list(&[1.0, 2.0]), list(&[3.0, 4.0])]);
        assert_eq!(rows(&lists).unwrap(), expected);
        assert_eq!(rows(&Value::Array(vec![lists])).unwrap(), expected);
        assert_eq!(rows(&list(&[1.0, 2.0])).unwrap(), [[1.0, 2.0]]);
    }

    #[test]
    fn what_is_no_list_of_actions_is_refused() {
        let list =
            |numbers: &[f64]| Value::Array(numbers.iter().copied().map(Value::from).collect());
        for (value, expected) in [
            (floats(&[2, 2, 2], &[0.0; 8]), "[2, 2, 2]"),
            (floats(&[2, 3], &[0.0; 4]), "has 32 bytes"),
            (floats(&[usize::MAX, usize::MAX], &[]), "has 0 bytes"),
            (floats(&[0, 2], &[]), "no actions"),
            (floats(&[1, 1], &[0.0]), "1 columns and need 2: x, y"),
            (floats(&[2, 2], &[0.0, 0.0, 0.0, f64::NAN]), "in row 1"),
            (Keys::Text.array(vec![0; 2], "<f2", &[1]), "<f2"),
            (
                Value::Array(vec![list(&[1.0]), list(&[1.0, 2.0])]),
                "no lists",
            ),
            (Value::Array(vec![Value::from("a")]), "no lists"),
            (
                Value::Array(vec![list(&[1.0]), Value::from(1.0)]),
                "no lists",
            ),
            (Value::from(1.0), "[]"),
            (Value::Nil, "no lists"),
        ] {
            let error = rows(&value).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let many = floats(&[MAX_ROWS + 1, 2], &[0.0; 2 * (MAX_ROWS + 1)]);
        assert_eq!(rows(&many), Err(ServerError::TooLong));
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_message_or_an_error(bytes in vec(any::<u8>(), 0..200)) {
            if let Ok(message) = from_bytes(&bytes) {
                let _ = rows(&message);
            }
        }

        #[test]
        fn any_array_is_rows_or_an_error(
            data in vec(any::<u8>(), 0..64),
            shape in vec(0_usize..9, 0..6),
            dtype in "<f4|<f8|<i8|[|]u1|.*",
        ) {
            let _ = rows(&Keys::Bytes.array(data, &dtype, &shape));
        }
    }
}
