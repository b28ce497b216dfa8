//! What a chat model answers: lists of deliveries and orders, read tolerantly.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::json::find_json;
use crate::error::AnswerError;

/// The most deliveries that an answer may have.
const MOST_ENTRIES: usize = 200;

/// A delivery as models write it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Entry {
    #[serde(default)]
    pub item: Option<String>,
    pub building: String,
    #[serde(default)]
    pub unit: Option<String>,
    /// The sender's words that name it, where there is a doubt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub words: Option<String>,
}

/// The list of deliveries in an answer: an object that holds it, the list itself, or a single
/// delivery.
pub(super) fn entries(reply: &str) -> Result<Vec<Entry>, AnswerError> {
    let list = match find_json(reply)? {
        Value::Array(list) => list,
        Value::Object(mut object) if object.contains_key("deliveries") => {
            match object.remove("deliveries") {
                Some(Value::Array(list)) => list,
                _ => return Err(AnswerError::Form("`deliveries` is not a list")),
            }
        }
        single => vec![single],
    };
    if list.len() > MOST_ENTRIES {
        return Err(AnswerError::TooManyDeliveries { most: MOST_ENTRIES });
    }
    list.into_iter().map(entry).collect()
}

/// The doors that an answer rejects, if `is_said` of their building and the sender's words. Those
/// that cannot be read are left out.
pub(super) fn rejected(reply: &str, is_said: impl Fn(&str, &str) -> bool) -> Vec<Entry> {
    let Ok(Value::Object(mut object)) = find_json(reply) else {
        return Vec::new();
    };
    let Some(Value::Array(list)) = object.remove("rejected") else {
        return Vec::new();
    };
    let text = |value: &Value, key: &str| -> String {
        value
            .get(key)
            .and_then(Value::as_str)
            .unwrap_or_default()
            .to_owned()
    };
    list.into_iter()
        .filter(|value| is_said(&text(value, "building"), &text(value, "words")))
        .filter_map(|value| entry(value).ok())
        .collect()
}

fn entry(value: Value) -> Result<Entry, AnswerError> {
    serde_json::from_value(plain(value)).map_err(|source| AnswerError::Delivery {
        source: Arc::new(source),
    })
}

/// Numbers as texts, since models write `"unit": 1`; empty texts as null.
fn plain(mut value: Value) -> Value {
    for field in value
        .as_object_mut()
        .into_iter()
        .flat_map(|object| object.values_mut())
    {
        if let Value::Number(number) = field {
            *field = Value::String(number.to_string());
        } else if field.as_str().is_some_and(|text| text.trim().is_empty()) {
            *field = Value::Null;
        }
    }
    value
}

/// The order in an answer, counted from 0: an object that holds it, or the list itself.
pub(super) fn permutation(reply: &str, count: usize) -> Result<Vec<usize>, AnswerError> {
    let list = match find_json(reply)? {
        Value::Array(list) => list,
        Value::Object(mut object) => match object.remove("order") {
            Some(Value::Array(list)) => list,
            _ => return Err(AnswerError::Form("the object has no list `order`")),
        },
        _ => return Err(AnswerError::Form("the answer is no list")),
    };
    let order: Vec<usize> = list.iter().filter_map(index).collect();
    let mut sorted = order.clone();
    sorted.sort_unstable();
    // Unreadable entries are dropped above, so the lengths are compared: none may be dropped
    // silently.
    let is_complete = order.len() == list.len() && sorted.iter().copied().eq(0..count);
    is_complete
        .then_some(order)
        .ok_or(AnswerError::NoPermutation { count })
}

/// A number of an answer, which counts from 1, as an index.
fn index(value: &Value) -> Option<usize> {
    let number = value
        .as_u64()
        .or_else(|| value.as_str()?.trim().parse().ok())?;
    usize::try_from(number).ok()?.checked_sub(1)
}
