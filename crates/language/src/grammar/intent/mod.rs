//! Which mentions are meant: not those after `not`, those that a correction replaces or that were
//! cancelled, origins and landmarks, floors.

mod addresses;
mod corrections;
pub(crate) mod denial;
mod exceptions;
mod hints;
mod orders;
pub(crate) mod selection;

use self::denial::{Denial, denial};
use self::selection::Selection;
use super::mentions::mention::Mention;
use super::reading::Reading;
use super::rule::{Example, Rule};

/// A rule of [`INTENTS`].
pub(crate) type Intent = Rule<fn(&Reading<'_>, &mut Selection)>;

/// What is left out or meant after all, given what the words beside each mention say. The rules
/// apply one after the other.
pub(crate) const INTENTS: &[Intent] = &[
    // First what words beside a place leave out by mistake, before anything follows from that.
    Intent {
        name: "where to begin is no origin",
        examples: &[Example("从9号楼开始送，2号楼也要", "building9 building2")],
        apply: orders::allow_where_to_begin,
    },
    Intent {
        name: "stops that a `not … before` puts in order are meant",
        examples: &[Example(
            "Don't go to building 2 until building 9 is done",
            "building9 building2",
        )],
        apply: orders::allow_what_is_put_in_order,
    },
    // Then what goes with a place that is left out.
    Intent {
        name: "what is tied to a place left out is left out",
        examples: &[Example(
            "Not building 5 unit 3, but building 8",
            "building8",
        )],
        apply: addresses::spread,
    },
    Intent {
        name: "what is listed with an exception is one",
        examples: &[Example(
            "In Block 4 haben alle außer Aufgang 1 und Aufgang 3 bestellt, fahr also nur zu \
                 den anderen beiden.",
            "building4/unit4 building4/unit2",
        )],
        apply: exceptions::except_lists,
    },
    Intent {
        name: "an ordinal behind a unit says how to find it",
        examples: &[Example(
            "The parcel goes to building 8, unit 2, first door on the left.",
            "building8/unit2",
        )],
        apply: hints::pass_hints,
    },
    Intent {
        name: "a building goes with its units",
        examples: &[Example(
            "Building 5 unit 2 and building 3 unit 1; skip building 5, unit 2",
            "building3/unit1",
        )],
        apply: addresses::together,
    },
    // Then earlier mentions of what is denied now.
    Intent {
        name: "what is denied is taken back where it was named before",
        examples: &[Example(
            "Building 7, unit 2 and building 8, unit 1. Building 8, unit 1, has cancelled.",
            "building7/unit2",
        )],
        apply: exceptions::take_back,
    },
    Intent {
        name: "a building goes with its units that were taken back",
        examples: &[Example(
            "Building 7, unit 2 and building 8, unit 1. Building 8, unit 1, has cancelled.",
            "building7/unit2",
        )],
        apply: addresses::together,
    },
    // Corrections replace only what is still meant. They deny places too, so what these take back
    // comes once more.
    Intent {
        name: "what is corrected replaces what was named before",
        examples: &[Example(
            "Building 6, no, wait, that was the old address, now building 8",
            "building8",
        )],
        apply: corrections::correct,
    },
    Intent {
        name: "a corrected number replaces the one before",
        examples: &[Example("Building 6 unit 1, sorry, 2", "building6/unit2")],
        apply: corrections::correct_numbers,
    },
    Intent {
        name: "what a correction denies is taken back where it was named before",
        examples: &[Example(
            "Building 3, building 5 and building 3, no wait, building 6",
            "building5 building6",
        )],
        apply: exceptions::take_back,
    },
    // Exceptions come once it is final which units are left out.
    Intent {
        name: "an exception alone means all other units",
        examples: &[Example(
            "Everyone in building 3 apart from units 1 and 4",
            "building3/unit2 building3/unit3",
        )],
        apply: exceptions::all_but,
    },
    Intent {
        name: "all units are those that are not excepted",
        examples: &[
            Example(
                "3号棟は2号室以外の全室に",
                "building3/unit1 building3/unit4 building3/unit3",
            ),
            Example(
                "8号楼1到3单元每个单元发一本新名册。",
                "building8/unit1 building8/unit2 building8/unit3",
            ),
        ],
        apply: exceptions::except,
    },
    // Last what is meant for want of anything else.
    Intent {
        name: "the building of a unit is meant if no other is",
        examples: &[Example(
            "Anula lo del edificio 3, unidad 1, que ya no están; lo de la unidad 4 sigue en \
                 pie.",
            "building3/unit4",
        )],
        apply: addresses::return_to_units,
    },
    Intent {
        name: "a landmark is the place if no other is",
        examples: &[Example("Leave it behind building 4", "building4")],
        apply: hints::return_to_landmarks,
    },
    Intent {
        name: "what may be a floor is no building beside one",
        examples: &[Example(
            "7号搂2单圆，上5楼502室，到了打我电话",
            "building7/unit2",
        )],
        apply: hints::drop_weak,
    },
];

/// The mentions that the robot shall go to.
pub(crate) fn meant(
    denials: &[Denial],
    intents: &[Intent],
    reading: &Reading<'_>,
    mentions: Vec<Mention>,
) -> Vec<Mention> {
    let left_out = mentions
        .iter()
        .map(|mention| denial(denials, reading, mention))
        .collect();
    let mut selection = Selection { mentions, left_out };
    for rule in intents {
        (rule.apply)(reading, &mut selection);
    }
    selection.into_meant()
}
