//! Conditions by the name of a level, or by numbers that change one.

use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};

/// The key of a table that names the level whose numbers the others change.
const LEVEL: &str = "level";

/// One condition: numbers, of which some sets are levels with names.
pub trait Condition: Copy + PartialEq + Serialize + DeserializeOwned + 'static {
    /// Its key in suites.
    const KEY: &'static str;
    /// Its levels by name. The first one is off.
    const LEVELS: &'static [(&'static str, Self)];

    /// Checks that all numbers are in their ranges.
    ///
    /// # Errors
    /// What is wrong, in words.
    fn check(&self) -> Result<(), String>;

    /// Nothing out of the ordinary.
    fn off() -> Self {
        Self::LEVELS[0].1
    }

    /// Whether it changes nothing.
    fn is_off(&self) -> bool {
        *self == Self::off()
    }

    /// The name of the level with these numbers.
    fn level(&self) -> Option<&'static str> {
        let named = Self::LEVELS.iter().find(|(_, level)| level == self);
        named.map(|(name, _)| *name)
    }
}

/// Checks numbers, each with its name and the largest one allowed; the smallest is 0.
///
/// # Errors
/// The first number out of its range, in words.
pub(super) fn check_ranges(numbers: &[(&str, f64, f64)]) -> Result<(), String> {
    for (key, value, most) in numbers {
        // False for NaN as well.
        if !(0.0..=*most).contains(value) {
            return Err(format!("{key} = {value}: give a number from 0 to {most}"));
        }
    }
    Ok(())
}

/// A condition that cannot be set.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {problem}")]
pub struct ConditionError {
    /// The condition.
    pub key: String,
    /// What is wrong, and what to do.
    pub problem: String,
}

fn error<C: Condition>(problem: String) -> ConditionError {
    ConditionError {
        key: C::KEY.to_owned(),
        problem,
    }
}

/// The level of a name.
pub(super) fn named<C: Condition>(name: &str) -> Result<C, ConditionError> {
    let found = C::LEVELS.iter().find(|(known, _)| *known == name);
    found.map(|(_, level)| *level).ok_or_else(|| {
        let known: Vec<&str> = C::LEVELS.iter().map(|(name, _)| *name).collect();
        error::<C>(format!(
            "there is no level `{name}`; write one of {}",
            known.join(", ")
        ))
    })
}

/// `base` with some of its numbers changed.
pub(super) fn changed<C: Condition>(
    base: C,
    changes: &Map<String, Value>,
) -> Result<C, ConditionError> {
    // Plain structures of numbers: each has a JSON form, an object.
    let mut numbers = match serde_json::to_value(base) {
        Ok(Value::Object(numbers)) => numbers,
        _ => Map::new(),
    };
    for (key, value) in changes {
        if !numbers.contains_key(key) {
            let known: Vec<&str> = numbers.keys().map(String::as_str).collect();
            return Err(error::<C>(format!(
                "there is no `{key}`; there are level, {}",
                known.join(", ")
            )));
        }
        numbers.insert(key.clone(), value.clone());
    }
    let condition: C = serde_json::from_value(Value::Object(numbers))
        .map_err(|problem| error::<C>(problem.to_string()))?;
    condition.check().map_err(error::<C>)?;
    Ok(condition)
}

/// A condition as the command line takes it: the level that is most like it, and each number that
/// is not that level's; nothing if it is off.
pub(super) fn words<C: Condition>(condition: &C) -> Vec<String> {
    let key = C::KEY;
    let mut unlike = C::LEVELS
        .iter()
        .map(|(name, level)| (*name, differences(condition, level)));
    let Some(off) = unlike.next() else {
        return Vec::new();
    };
    // The first one of those that are equally like it; what is off needs no mention.
    let mut words = Vec::new();
    let mut numbers = off.1;
    for (name, others) in unlike {
        if others.len() < numbers.len() {
            words = vec![format!("{key}={name}")];
            numbers = others;
        }
    }
    words.extend(
        numbers
            .into_iter()
            .map(|(number, value)| format!("{key}.{number}={value}")),
    );
    words
}

/// The numbers in which a condition differs from another one.
fn differences<C: Condition>(condition: &C, other: &C) -> Vec<(String, Value)> {
    let [Ok(Value::Object(numbers)), Ok(Value::Object(usual))] =
        [*condition, *other].map(serde_json::to_value)
    else {
        return Vec::new();
    };
    let differs = |(name, value): &(String, Value)| usual.get(name) != Some(value);
    numbers.into_iter().filter(differs).collect()
}

/// As a suite has it: the name of a level, or a table.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Level(String),
    Table(Map<String, Value>),
}

/// For `#[serde(deserialize_with)]`.
pub(super) fn deserialize<'de, C, D>(deserializer: D) -> Result<C, D::Error>
where
    C: Condition,
    D: Deserializer<'de>,
{
    let written = Written::deserialize(deserializer).map_err(|_| {
        let expected = "write the name of a level, or a table of numbers".to_owned();
        D::Error::custom(error::<C>(expected))
    })?;
    let read = match written {
        Written::Level(name) => named(&name),
        Written::Table(mut table) => match table.remove(LEVEL) {
            None => changed(C::off(), &table),
            Some(Value::String(name)) => named(&name).and_then(|base| changed(base, &table)),
            Some(_) => Err(error::<C>("level: write its name in quotes".to_owned())),
        },
    };
    read.map_err(D::Error::custom)
}

/// For `#[serde(serialize_with)]`: the name of a level, or all numbers.
pub(super) fn serialize<C, S>(condition: &C, serializer: S) -> Result<S::Ok, S::Error>
where
    C: Condition,
    S: Serializer,
{
    match condition.level() {
        Some(name) => serializer.serialize_str(name),
        None => condition.serialize(serializer),
    }
}
