//! Converts a JSON Schema to a grammar in llama.cpp's GBNF, which restricts answers to that schema.
//!
//! Objects contain the required properties in the order of the schema, and any other properties
//! before, between and after them. Without others, a small model that may not write the key it
//! prefers writes an allowed key instead, for example one more delivery.
//!
//! Of the schema, `type` (one or several), `properties`, `required` and `items` are used. The
//! reader of an answer must check the rest.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;

/// Maximum number of other properties at one place: some models would not stop adding properties.
const MAX_OTHERS: usize = 3;
/// Maximum number of rules. The rest of a larger schema is not restricted: llama.cpp checks tokens
/// against all rules that may apply, so large grammars make answers slow.
const MAX_RULES: usize = 500;
/// Maximum depth of a schema. Below it any JSON is allowed. Recursion must end for any input.
const MAX_DEPTH: usize = 16;

/// Rules for any JSON. White space is limited, since some models would write nothing else.
const ANY_JSON: &str = r#"
value ::= object | array | string | number | ("true" | "false" | "null") ws
object ::= "{" ws (string ":" ws value ("," ws string ":" ws value)*)? "}" ws
array ::= "[" ws (value ("," ws value)*)? "]" ws
string ::= "\"" char* "\"" ws
char ::= [^"\\\x00-\x1F\x7F] | escape
escape ::= "\\" (["\\/bfnrt] | "u" [0-9a-fA-F]{4})
number ::= integral ("." [0-9]{1,15})? ([eE] [-+]? [0-9]{1,3})? ws
integer ::= integral ws
integral ::= "-"? ("0" | [1-9] [0-9]{0,15})
ws ::= "" | " " | "\n" [ \t]{0,12}
"#;

/// The grammar of JSON with this schema, or of one JSON object without one. Its first rule is
/// `root`.
pub(crate) fn grammar(schema: Option<&Value>) -> String {
    let mut rules = Rules::default();
    let root = schema.map_or_else(|| "object".to_owned(), |schema| rules.of(schema, 0));
    let made = rules.text;
    // The rules for any JSON are always there: all others refer to them.
    format!("root ::= {root}\n{made}{}", ANY_JSON.trim_start())
}

#[derive(Default)]
struct Rules {
    text: String,
    count: usize,
}

impl Rules {
    /// Adds a rule and returns its name.
    fn add(&mut self, body: &str) -> String {
        self.count += 1;
        let name = format!("r{}", self.count);
        let _ = writeln!(self.text, "{name} ::= {body}");
        name
    }

    /// The expression for JSON with this schema inside a rule.
    fn of(&mut self, schema: &Value, depth: usize) -> String {
        let mut kinds: Vec<&str> = match &schema["type"] {
            Value::String(one) => vec![one],
            Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
            _ => Vec::new(),
        };
        // `dedup` removes only equal kinds side by side.
        kinds.sort_unstable();
        kinds.dedup();
        if kinds.is_empty() || depth > MAX_DEPTH || self.count > MAX_RULES {
            return "value".to_owned();
        }
        let bodies: Vec<String> = kinds
            .iter()
            .map(|kind| self.of_kind(kind, schema, depth))
            .collect();
        if let [one] = &bodies[..] {
            one.clone()
        } else {
            self.add(&bodies.join(" | "))
        }
    }

    fn of_kind(&mut self, kind: &str, schema: &Value, depth: usize) -> String {
        match kind {
            "object" => self.object(schema, depth),
            "array" => {
                let item = self.of(&schema["items"], depth + 1);
                self.add(&format!(r#""[" ws ({item} ("," ws {item})*)? "]" ws"#))
            }
            "null" => r#""null" ws"#.to_owned(),
            "boolean" => r#"("true" | "false") ws"#.to_owned(),
            "string" | "integer" | "number" => kind.to_owned(),
            _ => "value".to_owned(),
        }
    }

    fn object(&mut self, schema: &Value, depth: usize) -> String {
        let required: Vec<&str> = schema["required"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .collect();
        if required.is_empty() {
            return "object".to_owned();
        }
        // Other keys must differ from the required ones: a required key taken as another one would
        // be written twice, or without its schema.
        let other = self.add(&format!(r#"{} ":" ws value"#, other_key(&required)));
        let mut body = String::from(r#""{" ws"#);
        for (i, key) in required.iter().enumerate() {
            let value = self.of(&schema["properties"][key], depth + 1);
            let comma = if i == 0 { "" } else { r#" "," ws"# };
            let quoted = literal(&Value::from(*key).to_string());
            let _ = write!(
                body,
                r#"{comma} ({other} "," ws){{0,{MAX_OTHERS}}} {quoted} ws ":" ws {value}"#
            );
        }
        let _ = write!(body, r#" ("," ws {other}){{0,{MAX_OTHERS}}} "}}" ws"#);
        self.add(&body)
    }
}

/// The expression for a quoted key that differs from all of these. Keys with escape sequences are
/// not excluded.
fn other_key(keys: &[&str]) -> String {
    let mut trie = Trie::default();
    keys.iter()
        .filter(|key| is_plain(key))
        .for_each(|key| trie.insert(key));
    format!(r#""\"" {} "\"" ws"#, trie.others())
}

/// Whether JSON writes the key without escape sequences.
fn is_plain(key: &str) -> bool {
    !key.contains(|c: char| c.is_control() || matches!(c, '"' | '\\'))
}

/// A trie of keys.
#[derive(Default)]
struct Trie {
    next: BTreeMap<char, Trie>,
    is_key: bool,
}

impl Trie {
    fn insert(&mut self, key: &str) {
        let end = key
            .chars()
            .fold(self, |node, letter| node.next.entry(letter).or_default());
        end.is_key = true;
    }

    /// The expression for all continuations that do not complete a key.
    fn others(&self) -> String {
        let letters: String = self
            .next
            .keys()
            .map(|letter| class_member(*letter))
            .collect();
        // A letter with which no key goes on leaves the trie, and anything may follow. A letter of
        // the trie descends. The key may end here unless that completes one of the keys.
        let mut branches = vec![format!(r#"([^"\\\x00-\x1F\x7F{letters}] | escape) char*"#)];
        branches.extend(
            self.next
                .iter()
                .map(|(letter, rest)| format!("[{}] {}", class_member(*letter), rest.others())),
        );
        if !self.is_key {
            branches.push(r#""""#.to_owned());
        }
        format!("({})", branches.join(" | "))
    }
}

/// A character inside a character class.
fn class_member(letter: char) -> String {
    match letter {
        // These have a meaning inside a class. Backslashes and quotes cannot occur: `is_plain`
        // excludes them.
        ']' | '[' | '^' | '-' => format!("\\x{:02X}", u32::from(letter)),
        plain => plain.to_string(),
    }
}

/// A text as a literal of the grammar.
fn literal(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn objects_have_required_and_may_have_other_properties() {
        let schema = json!({
            "type": "object",
            "properties": { "ab": { "type": "integer" } },
            "required": ["ab"],
        });
        let made = grammar(Some(&schema));
        let mut lines = made.lines();
        assert_eq!(lines.next(), Some("root ::= r2"));
        let other = [
            r#"r1 ::= "\"" (([^"\\\x00-\x1F\x7Fa] | escape) char*"#,
            r#"[a] (([^"\\\x00-\x1F\x7Fb] | escape) char*"#,
            r#"[b] (([^"\\\x00-\x1F\x7F] | escape) char*)"#,
            r#""") | "") "\"" ws ":" ws value"#,
        ];
        assert_eq!(lines.next(), Some(other.join(" | ").as_str()));
        let object =
            r#"r2 ::= "{" ws (r1 "," ws){0,3} "\"ab\"" ws ":" ws integer ("," ws r1){0,3} "}" ws"#;
        assert_eq!(lines.next(), Some(object));
    }

    #[test]
    fn types_are_restricted_and_unknown_ones_are_not() {
        let made = grammar(Some(
            &json!({ "type": "array", "items": { "type": ["string", "null"] } }),
        ));
        assert!(
            made.starts_with("root ::= r2\nr1 ::= \"null\" ws | string\nr2 ::= \"[\" ws (r1"),
            "{made}"
        );
        for free in [
            json!({}),
            json!(true),
            json!({ "type": 3 }),
            json!({ "type": "odd" }),
        ] {
            assert!(
                grammar(Some(&free)).starts_with("root ::= value\n"),
                "{free}"
            );
        }
        assert!(grammar(None).starts_with("root ::= object\n"));
    }

    #[test]
    fn large_schemas_give_small_grammars() {
        let deep = (0..200).fold(
            json!({}),
            |inner, _| json!({ "type": "array", "items": inner }),
        );
        assert!(grammar(Some(&deep)).len() < 4000);
        let wide = (0..12).fold(json!({}), |inner, _| {
            json!({
                "type": ["array", "object"],
                "items": inner,
                "required": ["a"],
                "properties": { "a": inner },
            })
        });
        assert!(grammar(Some(&wide)).len() < 200_000);
    }

    #[test]
    fn special_characters_in_keys_are_quoted() {
        let schema = json!({ "type": "object", "required": ["a\"]\\"] });
        let made = grammar(Some(&schema));
        assert!(made.contains(r#""\"a\\\"]\\\\\"""#), "{made}");
        assert!(
            made.contains(r#"r1 ::= "\"" (([^"\\\x00-\x1F\x7F] | escape) char* | "") "\"""#),
            "{made}"
        );
    }
}
