//! The three questions to a chat model: the paper's prompts, and the schemas of their answers.

use openbench_models::Schema;
use serde_json::{Value, json};

/// A question to the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Question {
    Addresses,
    Verification,
    Order,
}

impl Question {
    /// The step of the pipeline, as errors name it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Addresses => "address resolution",
            Self::Verification => "verification",
            Self::Order => "optimisation",
        }
    }

    /// The prompt with `{{gaps}}`.
    pub(super) fn prompt(self) -> &'static str {
        match self {
            Self::Addresses => include_str!("prompts/address.txt"),
            Self::Verification => include_str!("prompts/verify.txt"),
            Self::Order => include_str!("prompts/order.txt"),
        }
    }

    /// The schema of an answer. Answers are read more tolerantly, since few servers enforce it.
    pub(super) fn schema(self) -> Schema {
        let text = json!({ "type": "string" });
        let or_null = json!({ "type": ["string", "null"] });
        let delivery = [
            ("item", or_null.clone()),
            ("building", text.clone()),
            ("unit", or_null.clone()),
        ];
        let (name, fields) = match self {
            Self::Addresses => ("deliveries", vec![("deliveries", list_of(&delivery))]),
            Self::Verification => {
                let mut quoted = delivery.to_vec();
                // Optional: words are needed only for doors that the grammar does not read.
                quoted.push(("words?", or_null.clone()));
                let rejected = [
                    ("building", text.clone()),
                    ("unit", or_null),
                    ("words", text),
                ];
                let lists = vec![
                    ("deliveries", list_of(&quoted)),
                    ("rejected", list_of(&rejected)),
                ];
                ("verified", lists)
            }
            Self::Order => {
                let order = json!({ "type": "array", "items": { "type": "integer" } });
                ("order", vec![("order", order)])
            }
        };
        Schema {
            name: name.to_owned(),
            text: object_of(&fields).to_string(),
        }
    }
}

fn list_of(fields: &[(&str, Value)]) -> Value {
    json!({ "type": "array", "items": object_of(fields) })
}

/// An object with these fields; a name with a question mark is optional. It may have more fields,
/// unless a strict provider forbids them.
fn object_of(fields: &[(&str, Value)]) -> Value {
    let required: Vec<&str> = fields
        .iter()
        .map(|(name, _)| *name)
        .filter(|name| !name.ends_with('?'))
        .collect();
    let mut properties = serde_json::Map::new();
    for (name, value) in fields {
        properties.insert(name.trim_end_matches('?').to_owned(), value.clone());
    }
    json!({ "type": "object", "properties": properties, "required": required })
}
