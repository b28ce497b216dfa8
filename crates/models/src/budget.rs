//! What a mission asks of models: counted, and bounded.
//!
//! One [`Meter`] belongs to a mission; every model that the mission asks is wrapped in a [`Metered`] with it.

use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

use openbench_core::ModelUse;

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, CountedReply};
use crate::error::BudgetError;

/// The most that a mission may ask of models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Requests.
    pub calls: u32,
    /// Tokens of requests and answers together, as the servers count them.
    pub tokens: u64,
    /// Seconds that it waits for answers.
    pub seconds: u32,
}

impl Default for Budget {
    /// Enough to read a plate at every place that a mission looks from; little enough that a loop costs no fortune.
    fn default() -> Self {
        Self { calls: 1000, tokens: 2_000_000, seconds: 1800 }
    }
}

impl Budget {
    /// Which bound is reached, in words.
    fn reached(&self, spent: &ModelUse) -> Option<String> {
        let tokens = spent.prompt_tokens.saturating_add(spent.completion_tokens);
        bound_reached(spent.calls.into(), self.calls.into(), "calls")
            .or_else(|| bound_reached(tokens, self.tokens, "tokens"))
            .or_else(|| bound_reached(spent.latency_ms / 1000, self.seconds.into(), "seconds"))
    }

    fn read(text: &str) -> Option<Self> {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let &[calls, tokens, seconds] = &parts[..] else { return None };
        Some(Self {
            calls: calls.parse().ok()?,
            tokens: tokens.parse().ok()?,
            seconds: seconds.parse().ok()?,
        })
    }
}

fn bound_reached(spent: u64, bound: u64, unit: &str) -> Option<String> {
    (spent >= bound).then(|| format!("{spent} of {bound} {unit} are spent"))
}

impl FromStr for Budget {
    type Err = BudgetError;

    /// Reads `CALLS,TOKENS,SECONDS`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::read(text).ok_or_else(|| BudgetError { text: text.to_owned() })
    }
}

/// Counts what a mission asks. Clones count together.
#[derive(Debug, Clone, Default)]
pub struct Meter {
    budget: Budget,
    spent: Arc<Mutex<ModelUse>>,
}

impl Meter {
    /// Nothing asked yet.
    pub fn new(budget: Budget) -> Self {
        Self { budget, spent: Arc::default() }
    }

    /// What was asked so far.
    pub fn spent(&self) -> ModelUse {
        *self.spent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn check(&self) -> Result<(), ChatError> {
        match self.budget.reached(&self.spent()) {
            Some(spent) => Err(ChatError::Budget { spent }),
            None => Ok(()),
        }
    }

    fn count(&self, used: ModelUse) {
        let mut spent = self.spent.lock().unwrap_or_else(PoisonError::into_inner);
        *spent = spent.plus(used);
    }
}

/// A model of which no more is asked than the meter's budget allows. A call that has begun is waited for, so seconds and tokens may
/// go beyond the bound by one call.
#[derive(Debug)]
pub struct Metered<M> {
    model: M,
    meter: Meter,
}

impl<M: ChatModel> Metered<M> {
    /// Counts what is asked of `model` by `meter`.
    pub fn new(model: M, meter: Meter) -> Self {
        Self { model, meter }
    }
}

impl<M: ChatModel> ChatModel for Metered<M> {
    fn name(&self) -> &str {
        self.model.name()
    }

    fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
        self.chat_counted(request).reply
    }

    fn chat_counted(&self, request: &ChatRequest) -> CountedReply {
        if let Err(error) = self.meter.check() {
            return CountedReply { reply: Err(error), used: ModelUse::default() };
        }
        let counted = self.model.chat_counted(request);
        self.meter.count(counted.used);
        counted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chat::Message;

    /// Costs 10 tokens and 2 s a call, or 60 s and no answer.
    struct Scripted {
        answers: bool,
    }

    impl ChatModel for Scripted {
        fn name(&self) -> &str {
            "scripted"
        }

        fn chat(&self, request: &ChatRequest) -> Result<ChatReply, ChatError> {
            self.chat_counted(request).reply
        }

        fn chat_counted(&self, _: &ChatRequest) -> CountedReply {
            let mut counted = CountedReply::of_one_call(if self.answers {
                Ok(ChatReply { text: "x".into(), prompt_tokens: 7, completion_tokens: 3 })
            } else {
                Err(ChatError::Timeout { endpoint: "e".into(), seconds: 60 })
            });
            counted.used.latency_ms = if self.answers { 2000 } else { 60_000 };
            counted
        }
    }

    /// How many calls go through before the budget is spent.
    fn calls_within(budget: Budget, answers: bool) -> usize {
        let model = Metered::new(Scripted { answers }, Meter::new(budget));
        let request = ChatRequest::new(vec![Message::user("x")]);
        (0..100)
            .map(|_| model.chat(&request))
            .take_while(|reply| !matches!(reply, Err(ChatError::Budget { .. })))
            .count()
    }

    #[test]
    fn budgets_are_read() {
        assert_eq!("1, 2,3".parse(), Ok(Budget { calls: 1, tokens: 2, seconds: 3 }));
        for bad in ["", "1,2", "1,2,3,4", "1,-2,3", "a,b,c", "99999999999,1,1"] {
            assert!(bad.parse::<Budget>().is_err(), "{bad}");
        }
    }

    #[test]
    fn each_bound_holds() {
        let wide = Budget { calls: 50, tokens: 10_000, seconds: 10_000 };
        assert_eq!(calls_within(wide, true), 50);
        assert_eq!(calls_within(Budget { tokens: 25, ..wide }, true), 3);
        assert_eq!(calls_within(Budget { seconds: 5, ..wide }, true), 3);
        assert_eq!(calls_within(Budget { seconds: 61, ..wide }, false), 2);
        assert_eq!(calls_within(Budget { calls: 0, ..wide }, true), 0);
    }

    #[test]
    fn models_of_one_mission_count_together() {
        let meter = Meter::new(Budget::default());
        let request = ChatRequest::new(vec![Message::user("x")]);
        for answers in [true, true, false] {
            let _ = Metered::new(Scripted { answers }, meter.clone()).chat(&request);
        }
        let wanted =
            ModelUse { calls: 3, failed: 1, prompt_tokens: 14, completion_tokens: 6, latency_ms: 64_000 };
        assert_eq!(meter.spent(), wanted);
    }
}
