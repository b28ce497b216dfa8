//! The offline planner: a grammar that knows the map. No model, no network, well under a millisecond.
//!
//! The instruction passes through `text` (tokens), `names` (the map's own names in it), `words` and `numbers` (lexemes, after the
//! tables in `lexicon`), `mentions` (buildings and units, lists of them, all of them), `intent` (those that are meant: not denied, not
//! taken back, not corrected), `pairing` (doors), `items` and `sequence`, `deadlines`. All of them read a `Reading`. It understands addresses, not stories: pronouns are passed over, and conditions where nothing is cancelled in them.

mod deadlines;
mod fallback;
mod intent;
mod items;
mod levels;
pub(crate) mod lexicon;
mod mentions;
mod names;
mod numbers;
mod pairing;
mod reading;
mod sequence;
pub(crate) mod text;
pub(crate) mod words;

use std::ops::Range;

use openbench_core::Plan;

use self::lexicon::Class;
use self::mentions::Target;
use self::names::Found;
use self::reading::Reading;
use self::text::{Token, tokenize};
use self::words::{Languages, Lex, Meaning, Words};
use crate::arrange::arrange;
use crate::gazetteer::Gazetteer;
use crate::resolve::resolve;
use crate::wish::{Named, Wish, Wishes};
use crate::{PlanError, PlanRequest, Planner};

/// Instructions longer than this, in bytes, are refused.
const LONGEST_INSTRUCTION: usize = 20_000;
/// Instructions with more doors than this are refused.
const MOST_DOORS: usize = 200;

/// Instructions that name more buildings and units than this are refused.
const MOST_TARGETS: usize = 2 * MOST_DOORS;

/// Plans with a grammar and the map's names; needs no model.
pub struct GrammarPlanner {
    words: Words,
}

impl GrammarPlanner {
    /// Builds the word tables of all languages, once.
    pub fn new() -> Self {
        Self { words: Words::new() }
    }

    pub(crate) fn words(&self) -> &Words {
        &self.words
    }

    /// The doors that the instruction names, and in which order they must come.
    pub(crate) fn understand(&self, instruction: &str, gazetteer: &Gazetteer) -> Result<Wishes, PlanError> {
        let refuse = |hint: &str| PlanError::not_understood(instruction, hint);
        if instruction.len() > LONGEST_INSTRUCTION {
            return Err(refuse("it is too long; write less than 20,000 characters"));
        }
        let tokens = tokenize(instruction);
        let languages = self.words.languages(&tokens);
        let names = names::find(&tokens, gazetteer, &self.known(&tokens, languages));
        let ranges: Vec<Range<usize>> = names.iter().map(|name| name.tokens.clone()).collect();
        let lexemes = self.words.lexemes(&tokens, &ranges, languages);
        let reading = Reading { text: instruction, tokens: &tokens, lexemes: &lexemes };
        let mut mentions = mentions::mentions(&reading);
        // Before anything whose cost grows faster than their number.
        if mentions.iter().map(|m| m.targets.len()).sum::<usize>() > MOST_TARGETS {
            return Err(refuse("it names more than 200 doors; split it"));
        }
        name_once(&mut mentions, &names);
        let silent = mentions.is_empty();
        mentions.extend(fallback::partial(&reading, gazetteer, &mentions));
        mentions.sort_by_key(|m| m.at.start);
        let meant = intent::meant(&reading, mentions);
        let rooms = levels::rooms(&meant);
        let mut doors = pairing::doors(&reading, meant, gazetteer);
        if doors.is_empty() && silent {
            doors = fallback::doors(&reading);
        }
        if doors.is_empty() {
            return Err(refuse("name a building and a unit, as in `Take this box to unit 2, building 3`"));
        }
        if doors.len() > MOST_DOORS {
            return Err(refuse("it names more than 200 doors; split it"));
        }
        // `3号楼还是5号楼`: which also corrects.
        let has_choice = doors.len() > 1 || lexemes.iter().any(|lexeme| lexeme.is(Class::Correct));
        let is_unsure = has_choice && lexemes.iter().any(|lexeme| lexeme.is(Class::Unsure));
        if is_unsure {
            // One is meant, and the sender has to say which.
            doors.truncate(1);
        }
        let items = items::items(&reading, &doors);
        let named = |target: &Option<Target>| target.as_ref().map(|t| to_named(t, &names));
        let wish = |(door, item): (&pairing::Door, String)| Wish {
            item,
            building: named(&door.building),
            unit: named(&door.unit),
            is_room: door.is_room,
            doubtful: is_overriding(&reading, &doors, door),
            unsure: is_unsure,
            due: None,
            around: String::new(),
            below: Vec::new(),
        };
        let before = sequence::constraints(&reading, &doors);
        let due = deadlines::deadlines(&reading, &self.words, languages, &doors);
        let beside = levels::beside(&reading, &doors, &rooms);
        let wishes = doors.iter().zip(items).map(wish).zip(due).zip(beside);
        let whole = |((wish, due), levels::Beside { around, below })| Wish { due, around, below, ..wish };
        let around_all = levels::of_all(&reading, &doors);
        Ok(Wishes { doors: wishes.map(whole).collect(), before, around_all })
    }

    /// The numbers and names that the instruction mentions at all, meant or not: what a plan may be built from.
    pub(crate) fn evidence(&self, instruction: &str, gazetteer: &Gazetteer) -> Evidence {
        let tokens = tokenize(instruction);
        let languages = self.words.languages(&tokens);
        let names = names::find(&tokens, gazetteer, &self.known(&tokens, languages));
        let ranges: Vec<Range<usize>> = names.iter().map(|name| name.tokens.clone()).collect();
        let labels = self.words.lexemes(&tokens, &[], languages).into_iter().filter_map(|l| match l.lex {
            Lex::Number { label, .. } => Some(label),
            _ => None,
        });
        let reading = self.words.lexemes(&tokens, &ranges, languages);
        let mentions = mentions::mentions(&Reading { text: instruction, tokens: &tokens, lexemes: &reading });
        let is_all = |mention: &mentions::Mention| matches!(mention.targets[..], [Target::All { .. }]);
        let all_units = mentions.iter().any(is_all);
        let said = mentions.into_iter().flat_map(|m| m.targets).filter_map(|t| match t {
            Target::Label { label, .. } => Some(label),
            _ => None,
        });
        Evidence {
            labels: labels.chain(said).collect(),
            places: names.into_iter().flat_map(|name| name.places).collect(),
            letters: text::condensed(instruction),
            all_units,
        }
    }

    /// Whether words may deny a place, known or not: whether they say more than an address and where to.
    pub(crate) fn may_deny(&self, words: &str) -> bool {
        let tokens = tokenize(words);
        let lexemes = self.words.lexemes(&tokens, &[], self.words.languages(&tokens));
        lexemes.iter().any(|lexeme| {
            use lexicon::Class::{
                Absent, Correct, Dropped, Elsewhere, Except, Instead, Not, NotBefore, Sender, Sends,
            };
            let denying =
                [Not, Except, NotBefore, Dropped, Absent, Correct, Instead, Elsewhere, Sender, Sends];
            lexeme.lex == Lex::Unknown || denying.iter().any(|class| lexeme.is(*class))
        })
    }

    /// The label of a unit that stands alone: `unit1`, `1`, `Entrance B`.
    pub(crate) fn unit_label(&self, said: &str) -> Option<String> {
        let tokens = tokenize(said);
        let lexemes = self.words.lexemes(&tokens, &[], self.words.languages(&tokens));
        let reading = Reading { text: said, tokens: &tokens, lexemes: &lexemes };
        let mention = mentions::mentions(&reading).into_iter().next();
        match (mention.and_then(|m| m.targets.into_iter().next()), lexemes.as_slice()) {
            (Some(Target::Label { label, .. }), _) => Some(label),
            (_, [words::Lexeme { lex: Lex::Number { label, .. }, .. }]) => Some(label.clone()),
            (_, [_]) if tokens[0].text.chars().count() == 1 => Some(tokens[0].text.clone()),
            _ => None,
        }
    }

    /// Which tokens are words of a lexicon.
    fn known(&self, tokens: &[Token], languages: Languages) -> Vec<bool> {
        let mut known = vec![false; tokens.len()];
        for at in 0..tokens.len() {
            if let Some((length, Meaning::Word(_), _)) = self.words.longest(&tokens[at..], languages) {
                known[at..at + length].fill(true);
            }
        }
        known
    }
}

/// `… The label says: ignore the above and go to building 9`: whether a door comes after words that take back doors before them.
fn is_overriding(reading: &Reading<'_>, doors: &[pairing::Door], door: &pairing::Door) -> bool {
    let overrides = |at: &usize| reading.class(*at) == Some(lexicon::Class::Override);
    (0..door.first).find(overrides).is_some_and(|at| doors.iter().any(|other| other.last <= at))
}

/// What an instruction holds that can support an address.
pub(crate) struct Evidence {
    /// Numbers and letters, folded.
    pub labels: Vec<String>,
    /// Places whose names stand in the text: indices into [`Gazetteer::places`].
    pub places: Vec<usize>,
    /// All its letters and digits, folded.
    pub letters: String,
    /// Whether it speaks of all units of a building.
    pub all_units: bool,
}

/// A name that stands in the text twice is the one that stands there first.
fn name_once(mentions: &mut [mentions::Mention], names: &[Found]) {
    for target in mentions.iter_mut().flat_map(|mention| &mut mention.targets) {
        if let Target::Name(i) = target {
            let first = names.iter().position(|name| name.places == names[*i].places);
            *i = first.unwrap_or(*i);
        }
    }
}

fn to_named(target: &Target, names: &[Found]) -> Named {
    match target {
        Target::Label { label, said } => Named::Label { label: label.clone(), said: said.clone() },
        Target::Name(i) => Named::Places { places: names[*i].places.clone(), percent: names[*i].percent() },
        Target::Words(words) => Named::Words(words.clone()),
        Target::All { but, count, parity } => Named::All { but: but.clone(), count: *count, parity: *parity },
    }
}

impl Default for GrammarPlanner {
    fn default() -> Self {
        Self::new()
    }
}

impl Planner for GrammarPlanner {
    fn name(&self) -> &str {
        "grammar"
    }

    fn plan(&self, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
        let gazetteer = Gazetteer::new(request.map, &self.words);
        let wishes = self.understand(request.instruction, &gazetteer)?;
        let stops = resolve(wishes, request.map, &gazetteer);
        Ok(Plan {
            planner: self.name().to_owned(),
            deliveries: arrange(request, stops),
            fallbacks: Vec::new(),
        })
    }
}
