//! The words of deadlines, folded as instructions are.

use super::language::Times;
use super::tokens::tokenize;

/// An entry as the texts of its tokens.
pub(crate) type Phrase = Vec<String>;

/// A language's [`Times`] as tokens; the fields are those of [`Times`].
pub(crate) struct FoldedTimes {
    pub by: Vec<Phrase>,
    pub by_after: Vec<Phrase>,
    pub within: Vec<Phrase>,
    pub within_after: Vec<Phrase>,
    pub at: Vec<Phrase>,
    pub clock: Vec<Phrase>,
    pub half: Vec<Phrase>,
    pub am: Vec<Phrase>,
    pub pm: Vec<Phrase>,
    pub noon: Vec<Phrase>,
    pub minutes: Vec<Phrase>,
    pub hours: Vec<Phrase>,
    pub half_hour: Vec<Phrase>,
    pub one_hour: Vec<Phrase>,
    pub all: Vec<Phrase>,
    pub other_days: Vec<Phrase>,
    pub from: Vec<Phrase>,
    pub hour_articles: Vec<Phrase>,
    pub by_bare_hour: Vec<Phrase>,
    pub has_half_days: bool,
}

impl FoldedTimes {
    pub(super) fn new(times: &Times) -> Self {
        Self {
            by: folded(times.by),
            by_after: folded(times.by_after),
            within: folded(times.within),
            within_after: folded(times.within_after),
            at: folded(times.at),
            clock: folded(times.clock),
            half: folded(times.half),
            am: folded(times.am),
            pm: folded(times.pm),
            noon: folded(times.noon),
            minutes: folded(times.minutes),
            hours: folded(times.hours),
            half_hour: folded(times.half_hour),
            one_hour: folded(times.one_hour),
            all: folded(times.all),
            other_days: folded(times.other_days),
            from: folded(times.from),
            hour_articles: folded(times.hour_articles),
            by_bare_hour: folded(times.by_bare_hour),
            has_half_days: times.has_half_days,
        }
    }
}

fn folded(entries: &[&str]) -> Vec<Phrase> {
    entries.iter().map(|entry| texts(entry)).collect()
}

fn texts(entry: &str) -> Phrase {
    tokenize(entry)
        .into_iter()
        .map(|token| token.text)
        .collect()
}
