//! Words without weight: what stands on the other side of them still counts.

use crate::grammar::reading::Reading;
use crate::lexicon::class::Class;

/// The most words between a place and the word that says what it is to the robot: `not`, `sender`,
/// `pick up`, `if`.
pub(crate) const REACH: usize = 7;
/// The most words without weight between a place and what denies it: `was already cancelled`.
const TAIL: usize = 4;

/// Whether words of a class change nothing of what is denied.
pub(crate) fn is_light(class: Class) -> bool {
    matches!(
        class,
        Class::Article
            | Class::Link
            | Class::Toward
            | Class::TowardOrAfter
            | Class::Verb
            | Class::Filler
            | Class::Also
            | Class::Each
            | Class::All
            | Class::Same
            | Class::Determiner
    )
}

/// The class of the first word with weight from a place on; after [`TAIL`] words without weight any
/// word.
pub(crate) fn weighty_from(reading: &Reading<'_>, start: usize) -> Option<Class> {
    let mut at = start;
    loop {
        let class = reading.class(at)?;
        // An article begins something else: `building 3 the cancelled parcel`.
        let begins = matches!(class, Class::Article | Class::Determiner | Class::Link);
        // A word of no class ends the search by `?`: it begins something of its own.
        if !is_light(class) || begins || at == start + TAIL {
            return Some(class);
        }
        at += 1;
    }
}
