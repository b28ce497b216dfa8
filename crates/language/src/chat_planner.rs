//! The paper's pipeline against a chat model: address resolution, verification against invented places, optimisation of the order.
//!
//! The model is not trusted. Its answers are read tolerantly, but
//!
//! - nothing is invented: every building and unit must be supported by the instruction's numbers, words or names; where the grammar reads other doors, the model quotes the words that
//!   name its own;
//! - nothing is dropped: a door that the grammar reads is in the list, or the model quotes the words by which the sender rejects it;
//! - the order holds each stop once, and keeps to what the instruction asks for (as the grammar reads it); where something is due at a time, the model is not asked for one.
//!
//! Each prompt is asked again once with the reason. Then the grammar makes that part of the plan, which says so ([`Fallback`]), also where the model does not answer at
//! all; there is no plan only where the grammar understands nothing either. Names and problems are made as for every planner. The prompts are the files in `prompts/`.

mod guard;

use openbench_core::{Fallback, Plan, PlanPart};
use openbench_models::{ChatModel, ChatRequest, Message};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::arrange::{in_order, precedence, shortest, travel_times};
use crate::chat_json::find_json;
use crate::error::quote;
use crate::gazetteer::{Gazetteer, generic_label};
use crate::grammar::{Evidence, GrammarPlanner};
use crate::order::UNKNOWN;
use crate::question::Question;
use crate::resolve::{Stop, Stops, resolve};
use crate::wish::{Named, Wish, Wishes};
use crate::{PlanError, PlanRequest, Planner};

/// How many of the map's names a prompt holds, and how long each may be, in characters.
const NAMES: usize = 200;
const LONGEST_NAME: usize = 80;
/// The longest answer wanted, in tokens.
const MAX_TOKENS: u32 = 4096;
/// The most deliveries that an answer may have.
const MOST_ENTRIES: usize = 200;
/// How often each prompt is asked.
const ATTEMPTS: usize = 2;

/// Plans with a chat model in three steps.
pub struct ChatPlanner {
    model: Box<dyn ChatModel>,
    name: String,
    grammar: GrammarPlanner,
    is_bare: bool,
}

/// A delivery as models write it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Entry {
    #[serde(default)]
    item: Option<String>,
    building: String,
    #[serde(default)]
    unit: Option<String>,
    /// The sender's words that name it, where there is a doubt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    words: Option<String>,
}

/// One instruction on its way through the steps.
struct Conversation<'a> {
    planner: &'a ChatPlanner,
    request: &'a PlanRequest<'a>,
    gazetteer: Gazetteer,
    evidence: Evidence,
    /// What the grammar makes of the instruction.
    read: Option<Stops>,
    names: String,
}

impl ChatPlanner {
    /// A planner that asks `model`; its name is `chat:` and the model's.
    pub fn new(model: Box<dyn ChatModel>) -> Self {
        let name = format!("chat:{}", model.name());
        Self { model, name, grammar: GrammarPlanner::new(), is_bare: false }
    }

    /// A planner that takes the first answer to the first prompt as it is, in its order: unverified, unchecked, asked once. It is for comparison, to see what the rest is
    /// worth; its name is `bare:` and the model's.
    pub fn bare(model: Box<dyn ChatModel>) -> Self {
        let name = format!("bare:{}", model.name());
        Self { model, name, grammar: GrammarPlanner::new(), is_bare: true }
    }
}

impl Planner for ChatPlanner {
    fn name(&self) -> &str {
        &self.name
    }

    fn plan(&self, request: &PlanRequest<'_>) -> Result<Plan, PlanError> {
        let conversation = Conversation::new(self, request);
        if self.is_bare {
            let stops = conversation.stops(conversation.resolve_addresses()?).stops;
            let order: Vec<usize> = (0..stops.len()).collect();
            let deliveries = in_order(request, stops, &order);
            return Ok(Plan { planner: self.name.clone(), deliveries, fallbacks: Vec::new() });
        }
        let mut fallbacks = Vec::new();
        let mut instead = |part: PlanPart, error: &PlanError| {
            let from = self.grammar.name().to_owned();
            fallbacks.push(Fallback { part, from, because: error.to_string() });
        };
        let (stops, order) = match conversation.addresses() {
            Ok(stops) => {
                let order = conversation.optimise(&stops).unwrap_or_else(|error| {
                    instead(PlanPart::Order, &error);
                    shortest(request, &stops)
                });
                (stops, order)
            }
            Err(error) => {
                let stops = conversation.read.clone().ok_or_else(|| error.clone())?;
                instead(PlanPart::Addresses, &error);
                let order = shortest(request, &stops);
                (stops, order)
            }
        };
        let deliveries = in_order(request, stops.stops, &order);
        Ok(Plan { planner: self.name.clone(), deliveries, fallbacks })
    }
}

impl<'a> Conversation<'a> {
    fn new(planner: &'a ChatPlanner, request: &'a PlanRequest<'a>) -> Self {
        let gazetteer = Gazetteer::new(request.map, planner.grammar.words());
        let evidence = planner.grammar.evidence(request.instruction, &gazetteer);
        let names = names_for_prompt(&gazetteer, &evidence);
        let wishes = planner.grammar.understand(request.instruction, &gazetteer).ok();
        let read = wishes.map(|wishes| resolve(wishes, request.map, &gazetteer));
        Self { planner, request, gazetteer, evidence, read, names }
    }

    /// The doors, by steps 1 and 2.
    fn addresses(&self) -> Result<Stops, PlanError> {
        let found = self.resolve_addresses()?;
        // What the model cannot verify is still its own answer, if it stands up to the same checks, the grammar's reading among them.
        let is_checked = !found.is_empty() && self.read.is_some() && self.check_all(&found, &[]).is_ok();
        let verified = match self.verify(&found) {
            Err(_) if is_checked => found,
            verified => verified?,
        };
        if verified.is_empty() {
            let hint = "the model found no place to deliver to; name a building and a unit, as in `Take this box to unit 2, building 3`";
            return Err(PlanError::not_understood(self.request.instruction, hint));
        }
        let mut stops = self.stops(verified);
        if let Some(read) = &self.read {
            doubt(&mut stops, read);
            hasten(&mut stops, read);
            stops.before = orders(&stops, read);
        }
        Ok(stops)
    }

    /// Step 1: the instruction's addresses.
    fn resolve_addresses(&self) -> Result<Vec<Entry>, PlanError> {
        let prompt = self.fill(Question::Addresses, &[]);
        self.ask(Question::Addresses, prompt, entries)
    }

    /// Step 2: without what was invented.
    fn verify(&self, found: &[Entry]) -> Result<Vec<Entry>, PlanError> {
        let list = serde_json::json!({ "deliveries": found }).to_string();
        let prompt = self.fill(Question::Verification, &[("deliveries", &list)]);
        self.ask(Question::Verification, prompt, |reply| {
            let entries = entries(reply)?;
            self.check_all(&entries, &self.rejected(reply))?;
            Ok(entries)
        })
    }

    /// Step 3: the order; numbers in prompts and answers count from 1.
    fn optimise(&self, stops: &Stops) -> Result<Vec<usize>, PlanError> {
        let count = stops.stops.len();
        if count < 2 {
            return Ok((0..count).collect());
        }
        // Times are kept by what knows them.
        if stops.stops.iter().any(|stop| stop.due.is_some()) {
            return Ok(shortest(self.request, stops));
        }
        let list: Vec<String> = (1..)
            .zip(&stops.stops)
            .map(|(i, stop)| format!("{i}: {}", quoted(&stop.address.to_string())))
            .collect();
        let times = self.times(&stops.stops);
        let prompt = self.fill(Question::Order, &[("stops", &list.join("\n")), ("times", &times)]);
        let wanted = precedence(stops);
        self.ask(Question::Order, prompt, |reply| {
            let order = permutation(reply, count)?;
            let kept = wanted.allows(&order);
            kept.then_some(order)
                .ok_or_else(|| "it breaks the order that the instruction asks for".to_owned())
        })
    }

    /// Asks, and once more with the reason if the answer is of no use.
    fn ask<T>(
        &self,
        question: Question,
        prompt: String,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<T, PlanError> {
        let model = &self.planner.model;
        let mut messages = vec![Message::user(prompt)];
        let (mut reason, mut reply) = (String::new(), String::new());
        for _ in 0..if self.planner.is_bare { 1 } else { ATTEMPTS } {
            let request = ChatRequest { max_tokens: MAX_TOKENS, ..ChatRequest::new(messages.clone()) };
            let request = request.as_schema(question.schema());
            let unavailable = |source| PlanError::ModelUnavailable { model: model.name().to_owned(), source };
            reply = model.chat(&request).map_err(unavailable)?.text;
            match read(&reply) {
                Ok(value) => return Ok(value),
                Err(why) => reason = why,
            }
            messages.push(Message::assistant(reply.clone()));
            messages.push(Message::user(format!(
                "That cannot be used: {reason}. Answer again with the JSON object only."
            )));
        }
        Err(PlanError::ModelNonsense {
            model: model.name().to_owned(),
            stage: question.name().to_owned(),
            reason,
            reply: quote(&reply),
        })
    }

    /// A prompt with its gaps filled: the instruction, the map's names, and what else the step needs.
    fn fill(&self, question: Question, rest: &[(&str, &str)]) -> String {
        let instruction = self.request.instruction.replace("<<<", "<").replace(">>>", ">");
        let mut values = vec![("instruction", instruction.as_str()), ("names", self.names.as_str())];
        values.extend(rest);
        fill(question.prompt(), &values)
    }

    fn stops(&self, entries: Vec<Entry>) -> Stops {
        let wish = |entry: Entry| Wish {
            building: Some(self.building(&entry.building)),
            unit: entry.unit.as_deref().map(|unit| self.unit(unit)),
            item: entry.item.unwrap_or_default(),
            doubtful: false,
            unsure: false,
            is_room: false,
            due: None,
            around: String::new(),
            below: Vec::new(),
        };
        let doors = entries.into_iter().map(wish).collect();
        let wishes = Wishes { doors, ..Wishes::default() };
        let mut stops = resolve(wishes, self.request.map, &self.gazetteer);
        self.read.iter().filter(|_| !self.planner.is_bare).for_each(|read| place(&mut stops, read));
        stops
    }

    fn building(&self, said: &str) -> Named {
        let places = self.gazetteer.named(said);
        if !places.is_empty() {
            return Named::Places { places: places.to_vec(), percent: 100 };
        }
        match generic_label(said, self.planner.grammar.words()) {
            Some(label) => Named::Label { label, said: said.to_owned() },
            None => Named::Words(said.to_owned()),
        }
    }

    fn unit(&self, said: &str) -> Named {
        match self.planner.grammar.unit_label(said) {
            Some(label) => Named::Label { label, said: said.to_owned() },
            None => Named::Words(said.to_owned()),
        }
    }

    fn times(&self, stops: &[Stop]) -> String {
        let rows = travel_times(self.request, stops);
        let label = |i: usize| if i == 0 { "start".to_owned() } else { i.to_string() };
        let cell = |ms: &u64| if *ms >= UNKNOWN { "null".to_owned() } else { ms.div_ceil(1000).to_string() };
        let row = |(i, row): (usize, &Vec<u64>)| {
            format!("{}: [{}]", label(i), row.iter().skip(1).map(cell).collect::<Vec<_>>().join(", "))
        };
        rows.iter().enumerate().map(row).collect::<Vec<_>>().join("\n")
    }
}

/// Of several buildings of one name the one that the grammar reads, by the street or quarter that is said beside it.
fn place(stops: &mut Stops, read: &Stops) {
    let mut taken = vec![false; read.stops.len()];
    for stop in stops.stops.iter_mut().filter(|stop| stop.problem.is_some()) {
        let is_it = |read: &Stop| {
            let rest = read.address.building.strip_prefix(&stop.address.building);
            rest.is_some_and(|rest| rest.starts_with(", ")) && read.address.unit == stop.address.unit
        };
        let Some(at) = (0..taken.len()).find(|at| !taken[*at] && is_it(&read.stops[*at])) else { continue };
        taken[at] = true;
        stop.address = read.stops[at].address.clone();
        stop.problem.clone_from(&read.stops[at].problem);
        stop.confidence = read.stops[at].confidence;
    }
}

/// The orders among some stops that the grammar reads.
fn orders(stops: &Stops, read: &Stops) -> Vec<(usize, usize)> {
    let place = |i: usize| stops.stops.iter().position(|s| s.address.same_door(&read.stops[i].address));
    read.before.iter().filter_map(|(a, b)| Some((place(*a)?, place(*b)?))).collect()
}

/// Until when, on which floor and the like, and how surely that building, as the grammar reads it.
fn hasten(stops: &mut Stops, read: &Stops) {
    for stop in &mut stops.stops {
        let Some(same) = read.stops.iter().find(|r| r.address.same_door(&stop.address)) else { continue };
        stop.due = same.due;
        stop.levels.clone_from(&same.levels);
        stop.confidence = stop.confidence.min(same.confidence);
    }
}

/// What the grammar doubts that the sender said stays in doubt, however sure the model is.
fn doubt(stops: &mut Stops, read: &Stops) {
    for stop in &mut stops.stops {
        let same = |r: &&Stop| r.address.building == stop.address.building;
        let doubtful = read.stops.iter().filter(same).find(|r| r.is_doubtful());
        let is_sure = read.stops.iter().any(|r| !r.is_doubtful() && r.address.same_door(&stop.address));
        if let Some(doubtful) = doubtful.filter(|_| !is_sure) {
            stop.problem.clone_from(&doubtful.problem);
        }
    }
}

/// Fills each `{{gap}}` of the template once; what is filled in is not looked at again.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut pieces = template.split("{{");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (gap, rest) = piece.split_once("}}").unwrap_or(("", piece));
        text.push_str(values.iter().find(|(name, _)| *name == gap).map_or("", |(_, value)| value));
        text.push_str(rest);
    }
    text
}

/// The map's names as JSON strings, those that the instruction seems to hold first.
fn names_for_prompt(gazetteer: &Gazetteer, evidence: &Evidence) -> String {
    let mut places: Vec<usize> = evidence.places.clone();
    places.extend(0..gazetteer.places.len());
    let mut names: Vec<String> = Vec::new();
    for place in places {
        let name = quoted(&gazetteer.places[place].name);
        if !names.contains(&name) {
            names.push(name);
        }
        if names.len() >= NAMES {
            break;
        }
    }
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn quoted(name: &str) -> String {
    Value::String(name.chars().take(LONGEST_NAME).collect()).to_string()
}

/// The list of deliveries in an answer: an object that holds it, the list itself, or a single delivery.
fn entries(reply: &str) -> Result<Vec<Entry>, String> {
    let list = match find_json(reply)? {
        Value::Array(list) => list,
        Value::Object(mut object) if object.contains_key("deliveries") => match object.remove("deliveries") {
            Some(Value::Array(list)) => list,
            _ => return Err("`deliveries` is not a list".to_owned()),
        },
        single => vec![single],
    };
    if list.len() > MOST_ENTRIES {
        return Err(format!("it has more than {MOST_ENTRIES} deliveries"));
    }
    let read =
        |value| serde_json::from_value(plain(value)).map_err(|e| format!("a delivery cannot be read: {e}"));
    list.into_iter().map(read).collect()
}

/// Numbers as texts, since models write `"unit": 1`; empty texts as null.
fn plain(mut value: Value) -> Value {
    for field in value.as_object_mut().into_iter().flat_map(|object| object.values_mut()) {
        if let Value::Number(number) = field {
            *field = Value::String(number.to_string());
        } else if field.as_str().is_some_and(|text| text.trim().is_empty()) {
            *field = Value::Null;
        }
    }
    value
}

fn permutation(reply: &str, count: usize) -> Result<Vec<usize>, String> {
    let list = match find_json(reply)? {
        Value::Array(list) => list,
        Value::Object(object) => match object.get("order") {
            Some(Value::Array(list)) => list.clone(),
            _ => return Err("the object has no list `order`".to_owned()),
        },
        _ => return Err("the answer is no list".to_owned()),
    };
    let number = |value: &Value| value.as_u64().or_else(|| value.as_str()?.trim().parse().ok());
    let index = |value: &Value| number(value).and_then(|n| usize::try_from(n).ok()?.checked_sub(1));
    let order: Vec<usize> = list.iter().filter_map(index).collect();
    let mut sorted = order.clone();
    sorted.sort_unstable();
    let complete = order.len() == list.len() && sorted.iter().copied().eq(0..count);
    complete.then_some(order).ok_or_else(|| format!("the order must hold each of 1 to {count} once"))
}
