//! The three steps with a model: addresses, verification, order.

use openbench_core::with_causes;
use openbench_models::{ChatModel, ChatRequest, Message};

use super::adopt::adopt_rest;
use super::answers::{Entry, entries, permutation, rejected};
use super::guard::{check_all, is_rejection};
use super::instruction::Instruction;
use super::prompt;
use super::question::Question;
use crate::PlanError;
use crate::arrange::{precedence, shortest};
use crate::error::{AnswerError, quote};
use crate::resolve::Stops;

/// The longest answer wanted, in tokens.
const MAX_TOKENS: u32 = 4096;
const NOTHING: &str = "the model found no place to deliver to; name a building and a unit, as in \
                       `Take this box to unit 2, building 3`";

/// One instruction on its way through the steps.
pub(super) struct Conversation<'a> {
    pub model: &'a dyn ChatModel,
    pub instruction: Instruction<'a>,
    /// How often each prompt is asked.
    pub attempts: usize,
}

impl Conversation<'_> {
    /// The doors, by steps 1 and 2.
    pub(super) fn addresses(&self) -> Result<Stops, PlanError> {
        let found = self.resolve_addresses()?;
        let verified = match self.verify(&found) {
            // What the model cannot verify is still its own answer.
            Err(_) if self.stands_up(&found) => found,
            verified => verified?,
        };
        if verified.is_empty() {
            return Err(PlanError::not_understood(
                self.instruction.request.instruction,
                NOTHING,
            ));
        }
        let mut stops = self.instruction.stops(verified);
        if let Some(read) = &self.instruction.read {
            adopt_rest(&mut stops, read);
        }
        Ok(stops)
    }

    /// Whether a list passes the checks, the grammar's reading among them, as it is.
    fn stands_up(&self, found: &[Entry]) -> bool {
        let is_read = self.instruction.read.is_some();
        !found.is_empty() && is_read && check_all(&self.instruction, found, &[]).is_ok()
    }

    /// Step 1: the instruction's addresses.
    pub(super) fn resolve_addresses(&self) -> Result<Vec<Entry>, PlanError> {
        let prompt = self.fill(Question::Addresses, &[]);
        self.ask(Question::Addresses, prompt, entries)
    }

    /// Step 2: without what was invented.
    fn verify(&self, found: &[Entry]) -> Result<Vec<Entry>, PlanError> {
        let list = serde_json::json!({ "deliveries": found }).to_string();
        let prompt = self.fill(Question::Verification, &[("deliveries", &list)]);
        self.ask(Question::Verification, prompt, |reply| {
            let entries = entries(reply)?;
            let is_said =
                |building: &str, words: &str| is_rejection(&self.instruction, building, words);
            check_all(&self.instruction, &entries, &rejected(reply, is_said))?;
            Ok(entries)
        })
    }

    /// Step 3: the order; numbers in prompts and answers count from 1.
    pub(super) fn optimise(&self, stops: &Stops) -> Result<Vec<usize>, PlanError> {
        let request = self.instruction.request;
        let count = stops.stops.len();
        if count < 2 {
            return Ok((0..count).collect());
        }
        // The prompt lists no deadlines; the exact search keeps them.
        if stops.stops.iter().any(|stop| stop.due.is_some()) {
            return Ok(shortest(request, stops));
        }
        let list = prompt::stops(&stops.stops);
        let times = prompt::times(request, &stops.stops);
        let prompt = self.fill(Question::Order, &[("stops", &list), ("times", &times)]);
        let wanted = precedence(stops);
        self.ask(Question::Order, prompt, |reply| {
            let order = permutation(reply, count)?;
            if wanted.allows(&order) {
                Ok(order)
            } else {
                Err(AnswerError::WrongOrder)
            }
        })
    }

    /// Asks, and once more with the reason if the answer is of no use.
    fn ask<T>(
        &self,
        question: Question,
        prompt: String,
        read: impl Fn(&str) -> Result<T, AnswerError>,
    ) -> Result<T, PlanError> {
        let mut messages = vec![Message::user(prompt)];
        let mut attempt = 1;
        loop {
            // No second attempt where the model does not answer: it has retried by its own
            // contract.
            let reply = self.reply(question, &messages)?;
            let error = match read(&reply) {
                Ok(value) => return Ok(value),
                Err(error) => error,
            };
            if attempt >= self.attempts {
                return Err(PlanError::InvalidAnswer {
                    model: self.model.name().to_owned(),
                    stage: question.name().to_owned(),
                    source: error,
                    reply: quote(&reply),
                });
            }
            attempt += 1;
            // With its own answer before the reason, which refers to it.
            messages.push(Message::assistant(reply));
            messages.push(Message::user(format!(
                "That cannot be used: {}. Answer again with the JSON object only.",
                with_causes(&error)
            )));
        }
    }

    /// What the model answers.
    fn reply(&self, question: Question, messages: &[Message]) -> Result<String, PlanError> {
        let request = ChatRequest {
            max_tokens: MAX_TOKENS,
            ..ChatRequest::new(messages.to_vec())
        };
        let reply = self.model.chat(&request.as_schema(question.schema()));
        reply
            .map(|reply| reply.text)
            .map_err(|source| PlanError::ModelUnavailable {
                model: self.model.name().to_owned(),
                source,
            })
    }

    /// A prompt with its gaps filled: the instruction, the map's names, and what else the step
    /// needs.
    fn fill(&self, question: Question, rest: &[(&str, &str)]) -> String {
        let instruction = prompt::without_marks(self.instruction.request.instruction);
        let names = prompt::names(&self.instruction.gazetteer, &self.instruction.evidence);
        let mut values = vec![
            ("instruction", instruction.as_str()),
            ("names", names.as_str()),
        ];
        values.extend(rest);
        prompt::fill(question.prompt(), &values)
    }
}
