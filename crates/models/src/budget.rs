//! Counts and limits the calls of a mission to models.
//!
//! A mission has one [`Meter`]. Each model of the mission is wrapped in a [`Metered`] with it.

use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

use openbench_core::ModelUse;

use crate::chat::{ChatError, ChatModel, ChatReply, ChatRequest, CountedReply};
use crate::error::BudgetError;

/// Limits for the calls of a mission to models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Number of calls.
    pub calls: u32,
    /// Tokens of requests and answers together, as servers count them.
    pub tokens: u64,
    /// Time spent waiting for answers, seconds.
    pub seconds: u32,
}

/// As it is written in settings: `CALLS,TOKENS,SECONDS`.
impl std::fmt::Display for Budget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            calls,
            tokens,
            seconds,
        } = self;
        write!(f, "{calls},{tokens},{seconds}")
    }
}

impl Default for Budget {
    /// Enough to read a plate from each place of a mission, and few enough that an endless loop
    /// does not become expensive.
    fn default() -> Self {
        Self {
            calls: 1000,
            tokens: 2_000_000,
            seconds: 1800,
        }
    }
}

impl Budget {
    /// The limit that is reached, in words.
    fn reached(&self, spent: &ModelUse) -> Option<String> {
        let tokens = spent.prompt_tokens.saturating_add(spent.completion_tokens);
        bound_reached(spent.calls.into(), self.calls.into(), "calls")
            .or_else(|| bound_reached(tokens, self.tokens, "tokens"))
            .or_else(|| bound_reached(spent.latency_ms / 1000, self.seconds.into(), "seconds"))
    }

    fn read(text: &str) -> Option<Self> {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let &[calls, tokens, seconds] = &parts[..] else {
            return None;
        };
        Some(Self {
            calls: calls.parse().ok()?,
            tokens: tokens.parse().ok()?,
            seconds: seconds.parse().ok()?,
        })
    }
}

fn bound_reached(spent: u64, bound: u64, unit: &str) -> Option<String> {
    (spent >= bound).then(|| format!("{spent} of {bound} {unit} used"))
}

impl FromStr for Budget {
    type Err = BudgetError;

    /// Reads `CALLS,TOKENS,SECONDS`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::read(text).ok_or_else(|| BudgetError {
            text: text.to_owned(),
        })
    }
}

/// Counts the calls of a mission. Clones share their count.
///
/// ```
/// use openbench_models::{Budget, ChatModel, ChatRequest, Message, Meter, Metered, Replay};
///
/// let model = Replay::from_reader(&b""[..])?;
/// let meter = Meter::new(Budget { calls: 1, ..Budget::default() });
/// let metered = Metered::new(model, meter.clone());
///
/// let request = ChatRequest::new(vec![Message::user("To unit2, building1.")]);
/// assert!(metered.chat(&request).unwrap_err().to_string().contains("recording"));
/// assert!(metered.chat(&request).unwrap_err().to_string().contains("1 of 1 calls"));
/// assert_eq!(meter.spent().calls, 1);
/// # Ok::<(), openbench_models::ReplayError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Meter {
    budget: Budget,
    spent: Arc<Mutex<ModelUse>>,
}

impl Meter {
    /// A count of zero.
    pub fn new(budget: Budget) -> Self {
        Self {
            budget,
            spent: Arc::default(),
        }
    }

    /// The calls so far.
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

/// A model that refuses calls once the budget of its meter is used up.
///
/// A call that has begun is completed, so seconds and tokens may exceed their limits by one call.
#[derive(Debug)]
pub struct Metered<M> {
    model: M,
    meter: Meter,
}

impl<M: ChatModel> Metered<M> {
    /// Counts the calls to `model` with `meter`.
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
            return CountedReply {
                reply: Err(error),
                used: ModelUse::default(),
            };
        }
        // Without a lock: models may answer in several threads, each for minutes.
        let counted = self.model.chat_counted(request);
        self.meter.count(counted.used);
        counted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chat::Message;

    /// A model whose calls cost 10 tokens and 2 s, or fail after 60 s.
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
                Ok(ChatReply {
                    text: "x".into(),
                    prompt_tokens: 7,
                    completion_tokens: 3,
                })
            } else {
                Err(ChatError::Timeout {
                    endpoint: "e".into(),
                    seconds: 60,
                })
            });
            counted.used.latency_ms = if self.answers { 2000 } else { 60_000 };
            counted
        }
    }

    /// Number of calls before the budget is used up.
    fn calls_within(budget: Budget, answers: bool) -> usize {
        let model = Metered::new(Scripted { answers }, Meter::new(budget));
        let request = ChatRequest::new(vec![Message::user("x")]);
        (0..100)
            .map(|_| model.chat(&request))
            .take_while(|reply| !matches!(reply, Err(ChatError::Budget { .. })))
            .count()
    }

    #[test]
    fn budgets_are_parsed() {
        assert_eq!(
            "1, 2,3".parse(),
            Ok(Budget {
                calls: 1,
                tokens: 2,
                seconds: 3
            })
        );
        for bad in ["", "1,2", "1,2,3,4", "1,-2,3", "a,b,c", "99999999999,1,1"] {
            assert!(bad.parse::<Budget>().is_err(), "{bad}");
        }
    }

    #[test]
    fn each_limit_holds() {
        let wide = Budget {
            calls: 50,
            tokens: 10_000,
            seconds: 10_000,
        };
        assert_eq!(calls_within(wide, true), 50);
        assert_eq!(calls_within(Budget { tokens: 25, ..wide }, true), 3);
        assert_eq!(calls_within(Budget { seconds: 5, ..wide }, true), 3);
        assert_eq!(
            calls_within(
                Budget {
                    seconds: 61,
                    ..wide
                },
                false
            ),
            2
        );
        assert_eq!(calls_within(Budget { calls: 0, ..wide }, true), 0);
    }

    #[test]
    fn models_of_a_mission_share_its_meter() {
        let meter = Meter::new(Budget::default());
        let request = ChatRequest::new(vec![Message::user("x")]);
        for answers in [true, true, false] {
            let _ = Metered::new(Scripted { answers }, meter.clone()).chat(&request);
        }
        let wanted = ModelUse {
            calls: 3,
            failed: 1,
            prompt_tokens: 14,
            completion_tokens: 6,
            latency_ms: 64_000,
        };
        assert_eq!(meter.spent(), wanted);
    }
}
