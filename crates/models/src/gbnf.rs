//! A JSON Schema as a grammar in llama.cpp's GBNF, for answers that cannot be anything but JSON of that shape.
//!
//! Objects hold the properties that the schema requires, in its order, and any others before, between and after them: a small model that may not write the
//! key that it has in mind goes on with what it may write, which is one more stop that nobody asked for. Of the schema are read `type` (one or several),
//! `properties`, `required` and `items`; whatever it says beyond that is left to whoever reads the answer.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;

/// How many properties that are not asked for may stand at one place: some models would find another one for ever.
const OTHERS: usize = 3;
/// Of larger schemas the rest is left free.
const MOST_RULES: usize = 500;
/// How deep schemas are followed; below that anything is allowed.
const DEPTH: usize = 16;

/// Rules for JSON of any shape. Blanks are bounded, since some models would write nothing else.
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

/// The grammar, its first rule `root`, of JSON of this schema; of one JSON object where there is none.
pub(crate) fn grammar(schema: Option<&Value>) -> String {
    let mut rules = Rules::default();
    let root = schema.map_or_else(|| "object".to_owned(), |schema| rules.of(schema, 0));
    let made = rules.text;
    format!("root ::= {root}\n{made}{}", ANY_JSON.trim_start())
}

#[derive(Default)]
struct Rules {
    text: String,
    count: usize,
}

impl Rules {
    /// Makes a rule and returns its name.
    fn add(&mut self, body: &str) -> String {
        self.count += 1;
        let name = format!("r{}", self.count);
        let _ = writeln!(self.text, "{name} ::= {body}");
        name
    }

    /// What stands for JSON of this schema inside a rule.
    fn of(&mut self, schema: &Value, depth: usize) -> String {
        let mut kinds: Vec<&str> = match &schema["type"] {
            Value::String(one) => vec![one],
            Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
            _ => Vec::new(),
        };
        kinds.sort_unstable();
        kinds.dedup();
        if kinds.is_empty() || depth > DEPTH || self.count > MOST_RULES {
            return "value".to_owned();
        }
        let bodies: Vec<String> = kinds.iter().map(|kind| self.of_kind(kind, schema, depth)).collect();
        if let [one] = &bodies[..] { one.clone() } else { self.add(&bodies.join(" | ")) }
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
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        if required.is_empty() {
            return "object".to_owned();
        }
        let other = self.add(&format!(r#"{} ":" ws value"#, other_key(&required)));
        let mut body = String::from(r#""{" ws"#);
        for (i, key) in required.iter().enumerate() {
            let value = self.of(&schema["properties"][key], depth + 1);
            let comma = if i == 0 { "" } else { r#" "," ws"# };
            let quoted = literal(&Value::from(*key).to_string());
            let _ = write!(body, r#"{comma} ({other} "," ws){{0,{OTHERS}}} {quoted} ws ":" ws {value}"#);
        }
        let _ = write!(body, r#" ("," ws {other}){{0,{OTHERS}}} "}}" ws"#);
        self.add(&body)
    }
}

/// A key that is written like none of these, in its quotes. Keys that are written with escapes are not told from others.
fn other_key(keys: &[&str]) -> String {
    let mut trie = Trie::default();
    let is_plain = |key: &&&str| !key.contains(|c: char| c.is_control() || matches!(c, '"' | '\\'));
    keys.iter().filter(is_plain).for_each(|key| trie.insert(key));
    format!(r#""\"" {} "\"" ws"#, trie.others())
}

/// Keys letter by letter.
#[derive(Default)]
struct Trie {
    next: BTreeMap<char, Trie>,
    is_key: bool,
}

impl Trie {
    fn insert(&mut self, key: &str) {
        let end = key.chars().fold(self, |node, letter| node.next.entry(letter).or_default());
        end.is_key = true;
    }

    /// Whatever can follow here so that the whole is none of the keys.
    fn others(&self) -> String {
        let letters: String = self.next.keys().map(|letter| class_member(*letter)).collect();
        let mut ways = vec![format!(r#"([^"\\\x00-\x1F\x7F{letters}] | escape) char*"#)];
        ways.extend(
            self.next.iter().map(|(letter, rest)| format!("[{}] {}", class_member(*letter), rest.others())),
        );
        if !self.is_key {
            ways.push(r#""""#.to_owned());
        }
        format!("({})", ways.join(" | "))
    }
}

/// A letter inside a class of letters.
fn class_member(letter: char) -> String {
    match letter {
        ']' | '[' | '^' | '-' => format!("\\x{:02X}", u32::from(letter)),
        plain => plain.to_string(),
    }
}

/// A text as a literal.
fn literal(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn objects_hold_what_is_required_and_may_hold_more() {
        let schema =
            json!({ "type": "object", "properties": { "ab": { "type": "integer" } }, "required": ["ab"] });
        let made = grammar(Some(&schema));
        let mut lines = made.lines();
        assert_eq!(lines.next(), Some("root ::= r2"));
        let other = r#"r1 ::= "\"" (([^"\\\x00-\x1F\x7Fa] | escape) char* | [a] (([^"\\\x00-\x1F\x7Fb] | escape) char* | [b] (([^"\\\x00-\x1F\x7F] | escape) char*) | "") | "") "\"" ws ":" ws value"#;
        assert_eq!(lines.next(), Some(other));
        let object = r#"r2 ::= "{" ws (r1 "," ws){0,3} "\"ab\"" ws ":" ws integer ("," ws r1){0,3} "}" ws"#;
        assert_eq!(lines.next(), Some(object));
    }

    #[test]
    fn kinds_are_told_apart_and_what_is_unknown_is_free() {
        let made = grammar(Some(&json!({ "type": "array", "items": { "type": ["string", "null"] } })));
        assert!(made.starts_with("root ::= r2\nr1 ::= \"null\" ws | string\nr2 ::= \"[\" ws (r1"), "{made}");
        for free in [json!({}), json!(true), json!({ "type": 3 }), json!({ "type": "odd" })] {
            assert!(grammar(Some(&free)).starts_with("root ::= value\n"), "{free}");
        }
        assert!(grammar(None).starts_with("root ::= object\n"));
    }

    #[test]
    fn a_schema_without_end_is_cut_off() {
        let deep = (0..200).fold(json!({}), |inner, _| json!({ "type": "array", "items": inner }));
        assert!(grammar(Some(&deep)).len() < 4000);
        let both = |inner: Value| json!({ "type": ["array", "object"], "items": inner, "required": ["a"], "properties": { "a": inner } });
        let wide = (0..12).fold(json!({}), |inner, _| both(inner));
        assert!(grammar(Some(&wide)).len() < 200_000);
    }

    #[test]
    fn odd_keys_are_quoted() {
        let schema = json!({ "type": "object", "required": ["a\"]\\"] });
        let made = grammar(Some(&schema));
        assert!(made.contains(r#""\"a\\\"]\\\\\"""#), "{made}");
        assert!(made.contains(r#"r1 ::= "\"" (([^"\\\x00-\x1F\x7F] | escape) char* | "") "\"""#), "{made}");
    }
}
