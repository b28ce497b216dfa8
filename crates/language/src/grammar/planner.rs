//! The planner that needs no model: from an instruction to wishes, stage by stage.

use openbench_core::{Deadline, Plan};

use super::door::Door;
use super::fallback;
use super::items::items;
use super::levels::{self, Beside};
use super::mentions::mention::{Mention, Target};
use super::mentions::mentions;
use super::names::{self, Found};
use super::reading::Reading;
use super::rules::Rules;
use super::sequence::constraints;
use super::{deadlines, intent, pairing};
use crate::arrange::arrange;
use crate::gazetteer::Gazetteer;
use crate::lexicon::class::Class;
use crate::lexicon::lexer::lexemes;
use crate::lexicon::tokens::tokenize;
use crate::lexicon::words::{Vocabulary, Words};
use crate::resolve::resolve;
use crate::wish::{Named, Wish, Wishes};
use crate::{PlanError, PlanRequest, Planner};

/// Longer instructions are refused, in bytes. Names are searched for in time that grows with the
/// length times the names of the map, and orders in time that grows with the square of the doors.
const LONGEST_INSTRUCTION: usize = 20_000;
/// Instructions with more doors are refused: more than a robot delivers in a day.
const MOST_DOORS: usize = 200;
/// Instructions that name more buildings and units are refused: each door has at most two.
const MOST_TARGETS: usize = 2 * MOST_DOORS;

const TOO_LONG: &str = "it is too long; write less than 20,000 characters";
const TOO_MANY_DOORS: &str = "it names more than 200 doors; split it";
const NO_DOOR: &str = "name a building and a unit, as in `Take this box to unit 2, building 3`";

/// Plans with a grammar and the map's names; needs no model.
pub struct GrammarPlanner {
    words: Words,
    rules: Rules,
}

impl GrammarPlanner {
    /// Builds the word tables of all languages, once.
    pub fn new() -> Self {
        Self::with_rules(Rules::all())
    }

    pub(super) fn with_rules(rules: Rules) -> Self {
        Self {
            words: Words::new(),
            rules,
        }
    }

    pub(crate) fn words(&self) -> &Words {
        &self.words
    }

    /// The doors that the instruction names, and in which order they must come.
    pub(crate) fn understand(
        &self,
        instruction: &str,
        gazetteer: &Gazetteer,
    ) -> Result<Wishes, PlanError> {
        if instruction.len() > LONGEST_INSTRUCTION {
            return Err(PlanError::not_understood(instruction, TOO_LONG));
        }
        let tokens = tokenize(instruction);
        let vocabulary = self.words.vocabulary(&tokens);
        // Names before lexemes: a word in a name has no meaning of its own.
        let names = names::find(&tokens, gazetteer, &vocabulary.known(&tokens));
        let lexemes = lexemes(&tokens, &names::ranges(&names), vocabulary);
        let reading = Reading {
            text: instruction,
            tokens: &tokens,
            lexemes: &lexemes,
        };

        let mentions = mentioned(&reading, &names)?;
        let meant = self.meant(&reading, gazetteer, &mentions);
        // Kept before `doors` takes the mentions: rooms behind a unit are levels, not doors.
        let rooms = levels::rooms(&meant);
        let mut doors = self.doors(&reading, gazetteer, meant, mentions.is_empty())?;
        let is_unsure = is_unsure(&reading, &doors);
        if is_unsure {
            // One is meant, and the sender has to say which.
            doors.truncate(1);
        }

        let mut wishes = Vec::new();
        for said in said(&reading, vocabulary, &doors, &rooms) {
            wishes.push(Wish {
                doubtful: is_overriding(&reading, &doors, said.door),
                unsure: is_unsure,
                ..wish(said, &names)
            });
        }
        Ok(Wishes {
            doors: wishes,
            before: constraints(&self.rules.orderings, &reading, &doors),
            around_all: levels::of_all(&reading, &doors),
        })
    }

    /// The mentions that the sender means, and destinations named by a part of a name.
    fn meant(
        &self,
        reading: &Reading<'_>,
        gazetteer: &Gazetteer,
        mentions: &[Mention],
    ) -> Vec<Mention> {
        let mut all = mentions.to_vec();
        fallback::add_partial_names(reading, gazetteer, &mut all);
        intent::meant(&self.rules.denials, &self.rules.intents, reading, all)
    }

    /// The doors that mentions make; without any mention in the text, those that words for a
    /// destination make.
    fn doors(
        &self,
        reading: &Reading<'_>,
        gazetteer: &Gazetteer,
        meant: Vec<Mention>,
        has_no_mention: bool,
    ) -> Result<Vec<Door>, PlanError> {
        let Rules {
            namings, sharings, ..
        } = &self.rules;
        let mut doors = pairing::doors(namings, sharings, reading, meant, gazetteer);
        // Only without any mention: where all were denied, a guess must not bring a door back.
        if doors.is_empty() && has_no_mention {
            doors = fallback::doors(reading);
        }
        match doors.len() {
            0 => Err(PlanError::not_understood(reading.text, NO_DOOR)),
            1..=MOST_DOORS => Ok(doors),
            _ => Err(PlanError::not_understood(reading.text, TOO_MANY_DOORS)),
        }
    }
}

/// All mentions; refused if there are too many, before anything whose cost grows faster than their
/// number.
fn mentioned(reading: &Reading<'_>, names: &[Found]) -> Result<Vec<Mention>, PlanError> {
    let mut mentions = mentions(reading);
    let targets: usize = mentions.iter().map(|mention| mention.targets.len()).sum();
    if targets > MOST_TARGETS {
        return Err(PlanError::not_understood(reading.text, TOO_MANY_DOORS));
    }
    name_once(&mut mentions, names);
    Ok(mentions)
}

/// A door, and what is said of it besides its address.
struct Said<'a> {
    door: &'a Door,
    item: String,
    due: Option<Deadline>,
    beside: Beside,
}

/// The doors with what is said of each.
fn said<'a>(
    reading: &Reading<'_>,
    vocabulary: Vocabulary<'_>,
    doors: &'a [Door],
    rooms: &[Mention],
) -> Vec<Said<'a>> {
    let mut items = items(reading, doors).into_iter();
    let mut deadlines = deadlines::deadlines(reading, vocabulary, doors).into_iter();
    let mut beside = levels::beside(reading, doors, rooms).into_iter();
    let of_door = |door| {
        Some(Said {
            door,
            item: items.next()?,
            due: deadlines.next()?,
            beside: beside.next()?,
        })
    };
    doors.iter().map_while(of_door).collect()
}

/// A door as a wish that nothing speaks against.
fn wish(said: Said<'_>, names: &[Found]) -> Wish {
    let door = said.door;
    Wish {
        item: said.item,
        building: door.building.as_ref().map(|target| to_named(target, names)),
        unit: door.unit.as_ref().map(|target| to_named(target, names)),
        is_room: door.is_room,
        doubtful: false,
        unsure: false,
        due: said.due,
        around: said.beside.around,
        below: said.beside.below,
    }
}

fn to_named(target: &Target, names: &[Found]) -> Named {
    match target {
        Target::Label { label, said } => Named::Label {
            label: label.clone(),
            said: said.clone(),
        },
        Target::Name(i) => Named::Places {
            places: names[*i].places.clone(),
            percent: names[*i].percent(),
        },
        Target::Words(words) => Named::Words(words.clone()),
        Target::All { but, count, parity } => Named::All {
            but: but.clone(),
            count: *count,
            parity: *parity,
        },
    }
}

/// A name that stands in the text twice is the one that stands there first.
fn name_once(mentions: &mut [Mention], names: &[Found]) {
    for target in mentions.iter_mut().flat_map(|mention| &mut mention.targets) {
        if let Target::Name(i) = target {
            let first = names
                .iter()
                .position(|name| name.places == names[*i].places);
            *i = first.unwrap_or(*i);
        }
    }
}

/// Whether the sender says not to know which of several doors is meant. `3号楼还是5号楼` corrects too
/// and leaves one door.
fn is_unsure(reading: &Reading<'_>, doors: &[Door]) -> bool {
    (doors.len() > 1 || has_word(reading, Class::Correct)) && has_word(reading, Class::Unsure)
}

fn has_word(reading: &Reading<'_>, class: Class) -> bool {
    reading.lexemes.iter().any(|lexeme| lexeme.is(class))
}

/// `… The label says: ignore the above and go to building 9`: whether a door comes behind words
/// that take back doors before them.
fn is_overriding(reading: &Reading<'_>, doors: &[Door], door: &Door) -> bool {
    (0..door.first)
        .find(|at| reading.class(*at) == Some(Class::Override))
        .is_some_and(|at| doors.iter().any(|other| other.last <= at))
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
