//! Words that order stops, rule by rule.

use std::ops::Range;

use super::part::Part;
use crate::grammar::negated_order::is_order_after_not;
use crate::grammar::reading::Reading;
use crate::grammar::rule::{Example, Rule};
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::wish::Precedes;

/// A rule of [`ORDERINGS`]: what the word at a place says of the doors.
pub(crate) type Ordering = Rule<fn(&Part<'_>, usize) -> Vec<Precedes>>;

/// What words that order stops say of doors. No two rules speak of one word, so their order in this
/// list has no effect.
pub(crate) const ORDERINGS: &[Ordering] = &[
    Ordering {
        name: "`first` puts the nearest door before all others",
        examples: &[Example("从9号楼开始送，2号楼也要", "building9 building2")],
        apply: first_word,
    },
    Ordering {
        name: "an ordinal one puts the nearest door before all others",
        examples: &[Example(
            "building 9 and building 2, but building 9 first",
            "building9 building2",
        )],
        apply: first_ordinal,
    },
    Ordering {
        name: "`last` puts the nearest door behind all others",
        examples: &[Example(
            "building 7 last, building 9 and building 3",
            "building3 building9 building7",
        )],
        apply: last_word,
    },
    Ordering {
        name: "`afterwards` puts its sentence behind those before it",
        examples: &[Example(
            "Get the ice cream to building 9 unit 1 right away; the dry goods for building 1 \
                 unit 1 can come afterwards.",
            "building9/unit1 building1/unit1",
        )],
        apply: afterwards,
    },
    Ordering {
        name: "`finally` puts the nearest door behind all others",
        examples: &[Example(
            "Last of all building 3; building 9 before it",
            "building9 building3",
        )],
        apply: finally,
    },
    Ordering {
        name: "`before` that opens a sentence is `before that`",
        examples: &[Example(
            "Building 9. Before, building 12.",
            "building12 building9",
        )],
        apply: before_that,
    },
    Ordering {
        name: "`before` puts the door before it before the one behind it",
        examples: &[Example(
            "Go to building 9 before building 2",
            "building9 building2",
        )],
        apply: before,
    },
    Ordering {
        name: "`after` puts the door before it behind the one behind it",
        examples: &[Example(
            "Go to building 2 after building 9",
            "building9 building2",
        )],
        apply: after,
    },
    Ordering {
        name: "`wait until` puts the door before it behind the one behind it",
        examples: &[Example(
            "Building 2 has to wait until building 9 has its letter",
            "building9 building2",
        )],
        apply: wait,
    },
    Ordering {
        name: "`before that` puts its door before the one named before",
        examples: &[Example(
            "Building 9. Before that, building 12.",
            "building12 building9",
        )],
        apply: earlier,
    },
    Ordering {
        name: "a preposition for to and after puts the door behind it before the next",
        examples: &[Example(
            "Nach Haus 9 geht es zu Haus 2",
            "building9 building2",
        )],
        apply: onward,
    },
];

/// `First building 9`
fn first_word(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let is_first = part.reading.class(at) == Some(Class::First) && !part.is_staged;
    if is_first {
        first(part, at)
    } else {
        Vec::new()
    }
}

/// `1. Haus 9`
fn first_ordinal(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let is_one = match part.reading.lex(at) {
        Some(Lex::Number {
            label,
            ordinal: true,
        }) => label == "1",
        _ => false,
    };
    if is_one && !part.is_staged && is_adverb(part, at) {
        first(part, at)
    } else {
        Vec::new()
    }
}

/// `building 7 last`
fn last_word(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let is_last = part.reading.class(at) == Some(Class::Last) && is_adverb(part, at);
    if is_last { last(part, at) } else { Vec::new() }
}

/// `A; B and C afterwards`: the doors of the sentence come behind all of the sentences before.
fn afterwards(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    if part.reading.class(at) != Some(Class::Then) || !part.is_behind(at) {
        return Vec::new();
    }
    let begin = part.sentence(at).start;
    let mut found = Vec::new();
    for (later, door) in part.doors.iter().enumerate() {
        if door.first < begin || door.last > at {
            continue;
        }
        let before = (0..part.doors.len()).filter(|i| part.doors[*i].last <= begin);
        found.extend(before.map(|earlier| Precedes { earlier, later }));
    }
    found
}

/// `Finish at building 2`
fn finally(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    // Elsewhere `finally` is a `then`, which the stages handle.
    let opens = part.doors.iter().all(|door| door.first > at);
    let is_last = part.reading.class(at) == Some(Class::Finally) && (opens || part.is_behind(at));
    if is_last { last(part, at) } else { Vec::new() }
}

/// `A. Before, B`
fn before_that(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    if opens_a_sentence(part.reading, at) {
        put_earlier(part, at)
    } else {
        Vec::new()
    }
}

/// Whether a `before` stands alone at the beginning of a sentence.
fn opens_a_sentence(reading: &Reading<'_>, at: usize) -> bool {
    reading.lex(at) == Some(&Lex::Word(Class::Before, false))
        && reading.lex(at + 1) == Some(&Lex::Comma)
        && at > 0
        && reading.is_stop(at - 1)
}

/// `A before B`, and `not A before B` the other way round
fn before(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let Some(Lex::Word(Class::Before, postfix)) = part.reading.lex(at) else {
        return Vec::new();
    };
    if opens_a_sentence(part.reading, at) {
        return Vec::new();
    }
    let found = around(part, at, *postfix);
    let is_turned = is_order_after_not(part.reading, at);
    found
        .map(|order| if is_turned { order.turned() } else { order })
        .into_iter()
        .collect()
}

/// `A after B`
fn after(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let Some(Lex::Word(Class::After, postfix)) = part.reading.lex(at) else {
        return Vec::new();
    };
    around(part, at, *postfix)
        .map(Precedes::turned)
        .into_iter()
        .collect()
}

/// `A has to wait until B is done`
fn wait(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    if part.reading.class(at) != Some(Class::Wait) || !is_for_a_door(part, at) {
        return Vec::new();
    }
    around(part, at, false)
        .map(Precedes::turned)
        .into_iter()
        .collect()
}

/// `wait until building 3 …`, not `wait for a signature`: whether a door follows, words without
/// weight between.
fn is_for_a_door(part: &Part<'_>, at: usize) -> bool {
    let Some(door) = part.door_behind(at) else {
        return false;
    };
    (at + 1..part.doors[door].first).all(|at| {
        use Class::{Article, Filler, First, Link, Toward, Verb};
        let class = part.reading.class(at);
        matches!(class, Some(Article | Link | Toward | Filler | Verb | First))
    })
}

/// `A. Before that, B`
fn earlier(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let is_earlier = part.reading.class(at) == Some(Class::Earlier);
    if is_earlier {
        put_earlier(part, at)
    } else {
        Vec::new()
    }
}

/// `nach A geht es zu B`: A, then B.
fn onward(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let reading = part.reading;
    if reading.class(at) != Some(Class::TowardOrAfter) {
        return Vec::new();
    }
    let Some(from) = part.door_behind(at) else {
        return Vec::new();
    };
    let Some(to) = part.doors.get(from + 1) else {
        return Vec::new();
    };
    let gap = part.doors[from].last..to.first;
    // Only with a verb and a second destination in the same clause; otherwise `nach` is a plain
    // `to`.
    let is_parted = part.has_stop(gap.clone()) || has_word(reading, &gap, Class::And);
    let has_verb = has_word(reading, &gap, Class::Verb);
    if has_verb && has_word(reading, &gap, Class::Toward) && !is_parted {
        vec![Precedes {
            earlier: from,
            later: from + 1,
        }]
    } else {
        Vec::new()
    }
}

fn has_word(reading: &Reading<'_>, range: &Range<usize>, class: Class) -> bool {
    range.clone().any(|at| reading.class(at) == Some(class))
}

/// `first`, not `the first box` and not the label of a door.
fn is_adverb(part: &Part<'_>, at: usize) -> bool {
    let reading = part.reading;
    let before = at.checked_sub(1).and_then(|before| reading.class(before));
    let is_described = matches!(
        before,
        Some(Class::Article | Class::Determiner | Class::Sign)
    );
    let is_label = part
        .doors
        .iter()
        .any(|door| door.first <= at && at < door.last);
    !is_described && !is_label && !is_thing_or_level(reading, at + 1)
}

/// Whether a word stands at a place that an adjective before it describes.
fn is_thing_or_level(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{Building, Floor, Item, Room, Unit};
    matches!(
        reading.lex(at),
        Some(Lex::Unknown | Lex::Word(Item | Building | Unit | Room | Floor, _))
    )
}

/// The door that a word for `first` at a place is of comes before all others.
fn first(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let reading = part.reading;
    let before = part.door_before(at);
    let after = part.door_behind(at);
    let is_of_before = before.is_some_and(|before| {
        let is_beside =
            (part.doors[before].last..at).all(|at| reading.class(at) == Some(Class::Filler));
        // `3号楼优先，5号楼…`
        let ends = matches!(reading.lex(at + 1), None | Some(Lex::Comma | Lex::Stop));
        // `building 6 has to get theirs first; building 1 …`
        let is_last_of_sentence =
            after.is_none_or(|after| part.has_stop(at..part.doors[after].first));
        let is_in_sentence = !part.has_stop(part.doors[before].last..at);
        is_beside || is_in_sentence && (ends || is_last_of_sentence)
    });
    let door = if is_of_before {
        before
    } else {
        after.or(before)
    };
    door.map_or_else(Vec::new, |door| part.first(door))
}

/// The door that a word for `last` at a place is of comes behind all others.
fn last(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let before = part.door_before(at);
    let after = part.door_behind(at);
    // `最后一站12栋`
    let begins = at == 0 || matches!(part.reading.lex(at - 1), Some(Lex::Comma | Lex::Stop));
    let door = if begins {
        after.or(before)
    } else {
        before.or(after)
    };
    door.map_or_else(Vec::new, |door| part.last(door))
}

/// `A. Before that, B`, `A, and B before that`: B, then A.
fn put_earlier(part: &Part<'_>, at: usize) -> Vec<Precedes> {
    let Some(before) = part.door_before(at) else {
        return Vec::new();
    };
    // At the beginning of a clause the word is of the doors behind it, else of the door before it:
    // `A, and B before that`.
    if begins_a_clause(part.reading, at) {
        let behind: Vec<usize> = part.doors_behind_in_sentence(at).collect();
        if !behind.is_empty() {
            return behind
                .into_iter()
                .map(|earlier| Precedes {
                    earlier,
                    later: before,
                })
                .collect();
        }
    }
    match before.checked_sub(1) {
        Some(later) => vec![Precedes {
            earlier: before,
            later,
        }],
        None => Vec::new(),
    }
}

/// Whether a place begins a clause, but for words without weight: `…, but before that …`.
fn begins_a_clause(reading: &Reading<'_>, at: usize) -> bool {
    let fillers = (0..at)
        .rev()
        .take_while(|at| reading.class(*at) == Some(Class::Filler))
        .count();
    let Some(before) = (at - fillers).checked_sub(1) else {
        return true;
    };
    matches!(
        reading.lex(before),
        Some(Lex::Stop | Lex::Comma | Lex::Mark | Lex::Word(Class::And, _))
    )
}

/// The doors that a `before` relates: `A before B`, `before B, A`; behind the place in some
/// languages: `B之前先去A`.
fn around(part: &Part<'_>, at: usize, postfix: bool) -> Option<Precedes> {
    if is_of_a_time(part, at, postfix) || is_of_something_else(part, at) {
        return None;
    }
    let before = part.door_before_in_sentence(at);
    let mut behind = part.doors_behind_in_sentence(at);
    let Some(next) = behind.next() else {
        return with_the_one_before(part, at, postfix, before?);
    };
    match (before, behind.next()) {
        (Some(before), _) if postfix => Some(Precedes {
            earlier: next,
            later: before,
        }),
        (Some(before), _) => Some(Precedes {
            earlier: before,
            later: next,
        }),
        // `before B, A`: nothing stands before the word, so the second door behind it comes first.
        (None, Some(second)) => Some(Precedes {
            earlier: second,
            later: next,
        }),
        (None, None) => None,
    }
}

/// `before 6 pm`, `9号楼6点之前`, but `前に12号棟`
fn is_of_a_time(part: &Part<'_>, at: usize, postfix: bool) -> bool {
    let reading = part.reading;
    let articles = (at + 1..reading.lexemes.len())
        .take_while(|at| reading.class(*at) == Some(Class::Article))
        .count();
    let behind = reading.lex(at + 1 + articles);
    let has_number = matches!(behind, Some(Lex::Number { .. } | Lex::Quantity));
    let before = at.checked_sub(1).and_then(|before| reading.lex(before));
    let has_time = matches!(before, Some(Lex::Quantity | Lex::Word(Class::Measure, _)));
    has_number && !is_before_a_door(part, at) || postfix && has_time
}

/// `before lunch, and …`, but `after leaving the box at building 3`
fn is_of_something_else(part: &Part<'_>, at: usize) -> bool {
    let reading = part.reading;
    let doors = part.doors.iter().map(|door| door.first);
    let next = doors
        .filter(|first| *first > at)
        .min()
        .unwrap_or(reading.lexemes.len());
    !is_before_a_door(part, at)
        && reading.lex(at + 1) == Some(&Lex::Unknown)
        && (at..next).any(|at| parts_a_clause(reading, at))
}

fn parts_a_clause(reading: &Reading<'_>, at: usize) -> bool {
    matches!(
        reading.lex(at),
        Some(Lex::Comma | Lex::Stop | Lex::Word(Class::And, _))
    )
}

/// Whether a door begins right behind a place.
fn is_before_a_door(part: &Part<'_>, at: usize) -> bool {
    part.doors.iter().any(|door| door.first == at + 1)
}

/// `B must come before, at 2 pm`, `AはBの後にして`: the order of the last two doors before a word
/// that no door follows.
fn with_the_one_before(
    part: &Part<'_>,
    at: usize,
    postfix: bool,
    before: usize,
) -> Option<Precedes> {
    let reading = part.reading;
    let other = before.checked_sub(1)?;
    let is_alone = !postfix && matches!(reading.lex(at + 1), None | Some(Lex::Comma | Lex::Stop));
    if is_alone && reading.class(at) == Some(Class::Before) {
        return Some(Precedes {
            earlier: before,
            later: other,
        });
    }
    let (a, b) = (&part.doors[other], &part.doors[before]);
    let are_together = !part.has_stop(a.last.min(b.first)..b.first);
    (postfix && are_together).then_some(Precedes {
        earlier: other,
        later: before,
    })
}
