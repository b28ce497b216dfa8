//! What is checked of a model's list of doors: that nothing is invented and nothing is dropped.

use super::answers::Entry;
use super::instruction::Instruction;
use crate::error::{AnswerError, quote};
use crate::grammar::evidence::{Evidence, may_deny};
use crate::lexicon::marks;
use crate::lexicon::tokens::{Kind, Token, condensed, spelt, tokenize};
use crate::resolve::{Stop, Stops};
use crate::wish::Named;

/// Refuses a list that invents or drops a door.
pub(super) fn check_all(
    instruction: &Instruction<'_>,
    entries: &[Entry],
    rejected: &[Entry],
) -> Result<(), AnswerError> {
    entries
        .iter()
        .try_for_each(|entry| check(instruction, entry))?;
    // The grammar understands nothing here, so there is nothing to compare with; evidence is all.
    let Some(read) = &instruction.read else {
        return Ok(());
    };
    check_named(instruction, entries, read)?;
    check_complete(instruction, entries, rejected, read)
}

/// Refuses what the instruction does not support.
fn check(instruction: &Instruction<'_>, entry: &Entry) -> Result<(), AnswerError> {
    if !supports_building(instruction, &instruction.building(&entry.building)) {
        return Err(AnswerError::NoSuchBuilding {
            name: quote(&entry.building),
        });
    }
    let evidence = &instruction.evidence;
    match entry.unit.as_deref() {
        // Which units `all of them` are the map says; whether these are meant, `check_named`.
        Some(unit) if !evidence.all_units && !supports_label(evidence, &instruction.unit(unit)) => {
            Err(AnswerError::NoSuchUnit { name: quote(unit) })
        }
        _ => Ok(()),
    }
}

fn supports_building(instruction: &Instruction<'_>, named: &Named) -> bool {
    let evidence = &instruction.evidence;
    let Named::Places { places, .. } = named else {
        return supports_label(evidence, named);
    };
    places.iter().any(|place| {
        let label = instruction.label_of(*place);
        let name = condensed(&instruction.gazetteer.places[*place].name);
        label.is_some_and(|label| evidence.labels.contains(&label))
            || evidence.places.contains(place)
            || evidence.letters.contains(&name)
    })
}

fn supports_label(evidence: &Evidence, named: &Named) -> bool {
    match named {
        Named::Label { label, .. } => evidence.labels.contains(label),
        Named::Words(words) => {
            let letters = condensed(words);
            !letters.is_empty() && evidence.letters.contains(&letters)
        }
        Named::Places { .. } | Named::All { .. } => false,
    }
}

/// Every door in the list must be one that the grammar reads, or be quoted: numbers of the
/// instruction can be put together to doors that it does not name.
fn check_named(
    instruction: &Instruction<'_>,
    entries: &[Entry],
    read: &Stops,
) -> Result<(), AnswerError> {
    match entries
        .iter()
        .find(|entry| !is_supported(instruction, entry, read))
    {
        Some(Entry { building, unit, .. }) => {
            let levels: Vec<&str> = unit.iter().chain([building]).map(String::as_str).collect();
            Err(AnswerError::NotNamed {
                door: quote(&levels.join(", ")),
            })
        }
        None => Ok(()),
    }
}

fn is_supported(instruction: &Instruction<'_>, entry: &Entry, read: &Stops) -> bool {
    let given = instruction.stops(vec![entry.clone()]);
    given.stops.iter().all(|stop| has_door(read, stop)) || is_quoted(instruction, entry)
}

fn has_door(stops: &Stops, stop: &Stop) -> bool {
    stops
        .stops
        .iter()
        .any(|other| other.address.same_door(&stop.address))
}

/// Whether an entry's words are a whole clause of the sender's, up to where they name the door, and
/// name no other. Less than a clause may leave out the `not` before it.
fn is_quoted(instruction: &Instruction<'_>, entry: &Entry) -> bool {
    let words = entry.words.as_deref().unwrap_or_default();
    let evidence = Evidence::of(words, instruction.words, &instruction.gazetteer);
    let unit = entry.unit.as_deref().map(|unit| instruction.unit(unit));
    let building = instruction.building(&entry.building);
    let named: Vec<Named> = std::iter::once(building).chain(unit).collect();
    begins_a_clause(instruction.request.instruction, words)
        && named
            .iter()
            .all(|named| is_named_by(instruction, named, words, &evidence))
        // A quote that names another door as well could be that door's.
        && evidence
            .labels
            .iter()
            .all(|label| named.iter().any(|named| bears(instruction, named, label)))
}

/// Whether words, which hold `evidence`, name a building or unit.
fn is_named_by(
    instruction: &Instruction<'_>,
    named: &Named,
    words: &str,
    evidence: &Evidence,
) -> bool {
    match named {
        Named::Label { label, .. } => evidence.labels.contains(label),
        Named::Places { places, .. } => places.iter().any(|place| {
            let label = instruction.label_of(*place);
            evidence.places.contains(place)
                || label.is_some_and(|label| evidence.labels.contains(&label))
        }),
        Named::Words(name) => spelt(words).contains(&spelt(name)),
        Named::All { .. } => false,
    }
}

/// Whether a building or unit has a label.
fn bears(instruction: &Instruction<'_>, named: &Named, label: &str) -> bool {
    match named {
        Named::Label { label: own, .. } => own == label,
        Named::Places { places, .. } => places
            .iter()
            .any(|place| instruction.label_of(*place).as_deref() == Some(label)),
        Named::Words(_) | Named::All { .. } => false,
    }
}

/// Every door that the grammar reads must be in the list, or be rejected.
fn check_complete(
    instruction: &Instruction<'_>,
    entries: &[Entry],
    rejected: &[Entry],
    read: &Stops,
) -> Result<(), AnswerError> {
    let given = instruction.stops(entries.to_vec());
    let rejected = instruction.stops(rejected.to_vec());
    // What the grammar doubts may be missing: the model may know better.
    let dropped = read
        .stops
        .iter()
        .find(|stop| !stop.is_doubtful() && !has_door(&given, stop) && !has_door(&rejected, stop));
    match dropped {
        Some(stop) => Err(AnswerError::Dropped {
            door: quote(&stop.address.to_string()),
        }),
        None => Ok(()),
    }
}

/// Whether the instruction holds the words by which a building is rejected, and they name it and
/// say more than the address.
pub(super) fn is_rejection(instruction: &Instruction<'_>, building: &str, words: &str) -> bool {
    let said = condensed(words);
    let names_it = match instruction.building(building) {
        Named::Label { label, .. } => said.contains(&label),
        _ => !building.is_empty() && said.contains(&condensed(building)),
    };
    names_it && instruction.evidence.letters.contains(&said) && may_deny(words, instruction.words)
}

/// Whether words stand in an instruction, and nothing but a mark or nothing before them.
fn begins_a_clause(instruction: &str, words: &str) -> bool {
    let mut wanted = tokenize(words);
    wanted.retain(|token| token.kind != Kind::Mark);
    let tokens = tokenize(instruction);
    !wanted.is_empty() && (0..tokens.len()).any(|at| begins_clause_at(&tokens, at, &wanted))
}

fn begins_clause_at(tokens: &[Token], at: usize, wanted: &[Token]) -> bool {
    let is_clause = at == 0 || parts_clauses(&tokens[at - 1]);
    let mut rest = tokens[at..].iter().filter(|token| token.kind != Kind::Mark);
    is_clause
        && wanted
            .iter()
            .all(|word| rest.next().is_some_and(|token| token.text == word.text))
}

/// Whether a token is a mark that no word has inside: `Don't` is one word.
fn parts_clauses(token: &Token) -> bool {
    token.kind == Kind::Mark && !marks::is_inside_words(&token.text)
}
