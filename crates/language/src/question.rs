//! The three questions that a chat model is asked: the paper's prompts, and what their answers look like.

use openbench_models::Schema;
use serde_json::{Value, json};

/// A question to the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Question {
    Addresses,
    Verification,
    Order,
}

impl Question {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Addresses => "address resolution",
            Self::Verification => "verification",
            Self::Order => "optimisation",
        }
    }

    /// The prompt with `{{gaps}}`.
    pub(crate) fn prompt(self) -> &'static str {
        match self {
            Self::Addresses => include_str!("prompts/address.txt"),
            Self::Verification => include_str!("prompts/verify.txt"),
            Self::Order => include_str!("prompts/order.txt"),
        }
    }

    /// What an answer looks like. Answers are read more tolerantly: few servers hold a model to it.
    pub(crate) fn schema(self) -> Schema {
        let text = || json!({ "type": "string" });
        let or_null = || json!({ "type": ["string", "null"] });
        let (name, parts) = match self {
            Self::Addresses => (
                "deliveries",
                vec![(
                    "deliveries",
                    list_of(&[("item", or_null()), ("building", text()), ("unit", or_null())]),
                )],
            ),
            Self::Verification => (
                "verified",
                vec![
                    (
                        "deliveries",
                        list_of(&[
                            ("item", or_null()),
                            ("building", text()),
                            ("unit", or_null()),
                            ("words?", or_null()),
                        ]),
                    ),
                    ("rejected", list_of(&[("building", text()), ("unit", or_null()), ("words", text())])),
                ],
            ),
            Self::Order => {
                ("order", vec![("order", json!({ "type": "array", "items": { "type": "integer" } }))])
            }
        };
        Schema { name: name.to_owned(), text: object_of(&parts).to_string() }
    }
}

fn list_of(fields: &[(&str, Value)]) -> Value {
    json!({ "type": "array", "items": object_of(fields) })
}

/// An object that has these, but for those with a question mark, and may have more: which strict providers take away.
fn object_of(fields: &[(&str, Value)]) -> Value {
    let names: Vec<&str> = fields.iter().map(|(name, _)| *name).filter(|name| !name.ends_with('?')).collect();
    let property = |(name, value): &(&str, Value)| (name.trim_end_matches('?').to_owned(), value.clone());
    let properties: serde_json::Map<String, Value> = fields.iter().map(property).collect();
    json!({ "type": "object", "properties": properties, "required": names })
}
