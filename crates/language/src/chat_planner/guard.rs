//! What the chat planner checks of a model's list of doors: that nothing is invented and nothing is dropped.

use serde_json::Value;

use super::{Conversation, Entry, plain};
use crate::chat_json::find_json;
use crate::error::quote;
use crate::gazetteer::generic_label;
use crate::grammar::Evidence;
use crate::grammar::text::{Kind, Token, condensed, spelt, tokenize};
use crate::resolve::{Stop, Stops};
use crate::wish::Named;

impl Conversation<'_> {
    /// Refuses a list that invents or drops a door.
    pub(super) fn check_all(&self, entries: &[Entry], rejected: &[Entry]) -> Result<(), String> {
        entries.iter().try_for_each(|entry| self.check(entry))?;
        let Some(read) = &self.read else { return Ok(()) };
        self.check_named(entries, read)?;
        self.check_complete(entries, rejected, read)
    }

    /// Refuses what the instruction does not support.
    fn check(&self, entry: &Entry) -> Result<(), String> {
        if !self.supports_building(&self.building(&entry.building)) {
            return Err(format!("the instruction names no building `{}`", quote(&entry.building)));
        }
        match entry.unit.as_deref().map(|unit| (unit, self.unit(unit))) {
            // Which units `all of them` are the map says; whether these are meant, `check_named`.
            Some((unit, named)) if !self.supports_label(&named) && !self.evidence.all_units => {
                Err(format!("the instruction names no unit `{}`", quote(unit)))
            }
            _ => Ok(()),
        }
    }

    fn supports_building(&self, named: &Named) -> bool {
        let Named::Places { places, .. } = named else { return self.supports_label(named) };
        places.iter().any(|place| {
            let name = &self.gazetteer.places[*place].name;
            let label = generic_label(name, self.planner.grammar.words());
            let by_label = label.is_some_and(|label| self.evidence.labels.contains(&label));
            by_label
                || self.evidence.places.contains(place)
                || self.evidence.letters.contains(&condensed(name))
        })
    }

    fn supports_label(&self, named: &Named) -> bool {
        match named {
            Named::Label { label, .. } => self.evidence.labels.contains(label),
            Named::Words(words) => {
                let letters = condensed(words);
                !letters.is_empty() && self.evidence.letters.contains(&letters)
            }
            Named::Places { .. } | Named::All { .. } => false,
        }
    }

    /// Every door in the list must be one that the grammar reads, or be quoted: numbers of the instruction can be put together to doors that it does not name.
    fn check_named(&self, entries: &[Entry], read: &Stops) -> Result<(), String> {
        let is_among = |given: &Stops, stops: &Stops| {
            let is_same = |stop: &Stop| stops.stops.iter().any(|s| s.address.same_door(&stop.address));
            given.stops.iter().all(is_same)
        };
        let is_supported = |entry: &&Entry| {
            let given = self.stops(vec![(*entry).clone()]);
            is_among(&given, read) || self.is_quoted(entry)
        };
        match entries.iter().find(|entry| !is_supported(entry)) {
            Some(Entry { building, unit, .. }) => Err(format!(
                "the instruction does not seem to name `{}`; leave it out, or, if the sender wants it, add to that entry \"words\": the sender's own words, the whole clause that names it and no other door",
                quote(&unit.iter().chain([building]).map(String::as_str).collect::<Vec<_>>().join(", "))
            )),
            None => Ok(()),
        }
    }

    /// Whether an entry's words are a whole clause of the sender's, up to where they name the door, and name no other. Less than a clause may leave out
    /// the `not` before it.
    fn is_quoted(&self, entry: &Entry) -> bool {
        let words = entry.words.as_deref().unwrap_or_default();
        let evidence = self.planner.grammar.evidence(words, &self.gazetteer);
        let unit = entry.unit.as_ref().map(|unit| self.unit(unit));
        let named: Vec<Named> = std::iter::once(self.building(&entry.building)).chain(unit).collect();
        let is_named = |named: &Named| match named {
            Named::Label { label, .. } => evidence.labels.contains(label),
            Named::Places { places, .. } => places.iter().any(|place| self.is_named_by(*place, &evidence)),
            Named::Words(name) => spelt(words).contains(&spelt(name)),
            Named::All { .. } => false,
        };
        let is_own = |label: &String| {
            named.iter().any(|named| match named {
                Named::Label { label: own, .. } => own == label,
                Named::Places { places, .. } => places.iter().any(|place| self.bears(*place, label)),
                Named::Words(_) | Named::All { .. } => false,
            })
        };
        begins_a_clause(self.request.instruction, words)
            && named.iter().all(is_named)
            && evidence.labels.iter().all(is_own)
    }

    fn is_named_by(&self, place: usize, evidence: &Evidence) -> bool {
        evidence.places.contains(&place) || evidence.labels.iter().any(|label| self.bears(place, label))
    }

    /// Whether a place's name is a word for a building and this label.
    fn bears(&self, place: usize, label: &str) -> bool {
        let own = generic_label(&self.gazetteer.places[place].name, self.planner.grammar.words());
        own.as_deref() == Some(label)
    }

    /// Every door that the grammar reads must be in the list, or be rejected.
    fn check_complete(&self, entries: &[Entry], rejected: &[Entry], read: &Stops) -> Result<(), String> {
        let (given, rejected) = (self.stops(entries.to_vec()), self.stops(rejected.to_vec()));
        let known = given.stops.iter().chain(&rejected.stops);
        let is_known = |stop: &Stop| known.clone().any(|other| other.address.same_door(&stop.address));
        match read.stops.iter().find(|stop| !stop.is_doubtful() && !is_known(stop)) {
            Some(stop) => Err(format!(
                "the instruction also seems to name `{}`; add it, or, if the sender rejects it, put it under \"rejected\" with the sender's own words that do so",
                quote(&stop.address.to_string())
            )),
            None => Ok(()),
        }
    }

    /// The doors that the model says are rejected, with words that the instruction holds, and that name the building and say more than the address.
    pub(super) fn rejected(&self, reply: &str) -> Vec<Entry> {
        let Ok(Value::Object(mut object)) = find_json(reply) else { return Vec::new() };
        let Some(Value::Array(list)) = object.remove("rejected") else { return Vec::new() };
        let quoted = list.into_iter().filter(|value| {
            let words = value.get("words").and_then(Value::as_str).unwrap_or_default();
            let said = condensed(words);
            let building = value.get("building").and_then(Value::as_str).unwrap_or_default();
            let names_it = match self.building(building) {
                Named::Label { label, .. } => said.contains(&label),
                _ => !building.is_empty() && said.contains(&condensed(building)),
            };
            names_it && self.evidence.letters.contains(&said) && self.planner.grammar.may_deny(words)
        });
        quoted.filter_map(|value| serde_json::from_value(plain(value)).ok()).collect()
    }
}

/// Whether words stand in an instruction, and nothing but a mark or nothing before them.
fn begins_a_clause(instruction: &str, words: &str) -> bool {
    let is_mark = |token: &&Token| token.kind == Kind::Mark;
    let wanted: Vec<Token> = tokenize(words).into_iter().filter(|token| !is_mark(&token)).collect();
    let tokens = tokenize(instruction);
    let begins = |at: usize| {
        // `Don't` is one word.
        let parts = |mark: &Token| mark.kind == Kind::Mark && !matches!(mark.text.as_str(), "'" | "’" | "-");
        let is_clause = at == 0 || parts(&tokens[at - 1]);
        let mut rest = tokens[at..].iter().filter(|token| !is_mark(token));
        is_clause && wanted.iter().all(|word| rest.next().is_some_and(|token| token.text == word.text))
    };
    !wanted.is_empty() && (0..tokens.len()).any(begins)
}
