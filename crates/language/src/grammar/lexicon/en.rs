//! English.

use super::Class::*;
use super::{Lexicon, Script};

#[rustfmt::skip]
pub(super) const LEXICON: Lexicon = Lexicon {
    words: &[
        (Building, &[
            "building", "buildings", "bldg", "bldg.", "bldgs", "bld", "bld.", "blg", "blg.", "blk.", "block",
            "blocks", "blk", "tower", "towers", "house", "houses", "villa", "villas", "dorm", "dormitory",
            "apartment building", "apartment block",
        ]),
        (Unit, &[
            "unit", "units", "entrance", "entrances", "door", "doors", "entry", "entryway", "stairwell", "staircase",
            "doorway", "gate",
        ]),
        (Room, &[
            "apartment", "apartments", "apt", "apt.", "apts", "rm", "rm.", "flat", "flats", "room", "rooms", "suite",
            "suites", "office", "door number",
        ]),
        (Floor, &["floor", "floors", "level", "storey"]),
        (BuildingLetter, &["b"]),
        (UnitLetter, &["u"]),
        (Sign, &["no.", "number", "num", "num.", "nr", "nr.", "#", "№", "n°", "nº", "numbered"]),
        (Link, &["of", "in", "inside", "within", "at", "on"]),
        (Article, &["the"]),
        (Toward, &["to", "into", "for", "towards", "addressed to", "over to"]),
        (And, &["and", "&", "plus", "as well as", "and also", "or"]),
        (Range, &["through", "until unit"]),
        (Then, &[
            "then", "and then", "after that", "afterwards", "afterward", "next", "finally", "lastly", "subsequently",
            "followed by", "at the end", "in the end", "later", "thereafter", "once that is done", "when done",
            "from there",
        ]),
        (First, &[
            "first of all", "firstly", "at first", "to begin with", "start with", "start at", "starting with",
            "begin with", "begin at",
        ]),
        (Last, &["last", "as the last stop"]),
        (Before, &["before", "prior to"]),
        (After, &["after", "once you have been to", "after visiting", "after you have been to"]),
        (Not, &[
            "not", "don't", "do not", "never", "skip", "avoid", "except", "except for", "instead of", "rather than",
            "ignore", "cancel", "leave out", "and not", "but not", "no longer", "isn't", "is not", "without",
        ]),
        (Correct, &[
            "no wait", "no, wait", "wait no", "wait, no", "wait", "i mean", "i meant", "sorry", "actually",
            "correction", "scratch that", "make that", "oops", "or rather", "rather", "no sorry", "no, sorry",
            "no, make that", "i should say",
        ]),
        (Elsewhere, &[
            "from", "next to", "near", "nearby", "beside", "behind", "opposite", "across from", "past",
            "in front of", "close to", "between", "via", "passing", "not far from", "adjacent to", "around",
        ]),
        (Respectively, &["respectively"]),
        (Item, &[
            "box", "boxes", "package", "packages", "parcel", "parcels", "item", "items", "delivery", "deliveries",
            "letter", "letters", "envelope", "envelopes", "bag", "bags", "groceries", "food", "pizza", "meal",
            "lunch", "dinner", "breakfast", "takeaway", "takeout", "book", "books", "medicine", "medication",
            "flowers", "bouquet", "carton", "cartons", "crate", "crates", "mail", "post", "documents", "document",
            "goods", "cargo", "laptop", "water", "milk", "gift", "present", "cake", "coffee", "toolbox", "keys",
            "thing", "things", "stuff", "shipment", "newspaper", "battery", "tools",
        ]),
        (Determiner, &[
            "this", "these", "that", "those", "a", "an", "my", "our", "your", "his", "her", "their", "another",
            "some", "one of the", "both", "all",
        ]),
        (Verb, &[
            "deliver", "take", "bring", "drop", "drop off", "send", "carry", "go", "goes", "leave", "put",
            "transport", "ship", "hand", "hand over", "get", "place", "move", "visit", "head", "drive", "proceed",
            "dispatch", "needs to go", "should go", "must go", "has to go", "belongs", "is", "are", "goes straight",
            "delivered", "going", "delivering", "being", "be", "off", "over", "run", "stop",
        ]),
        (Filler, &[
            "please", "hey", "hello", "hi", "kindly", "could", "would", "can", "will", "you", "i", "we", "need",
            "want", "it", "them", "thanks", "thank", "robot", "thank you", "so", "also", "but", "just", "only",
            "with", "there", "here", "me", "us", "like", "have", "has", "must", "should", "lives", "who", "which",
            "located", "by", "as", "soon", "possible", "stops", "door of", "delivery to", "deliveries to", "each",
            "way", "no",
        ]),
        (Measure, &[
            "kg", "kgs", "kilo", "kilos", "kilogram", "kilograms", "g", "gram", "grams", "lb", "lbs", "pound",
            "pounds", "oz", "ounces", "m", "meter", "meters", "metre", "metres", "cm", "km", "am", "pm", "a.m.",
            "p.m.", "o'clock", "min", "mins", "minute", "minutes", "hour", "hours", "h", "s", "sec", "seconds",
            "day", "days", "percent", "%", "dollars", "euros", "l", "liter", "liters", "litres", "times", "pieces",
            "people", "$", "times a day",
        ]),
        (Reference, &[
            "order", "order no.", "order number", "tracking", "tracking number", "phone", "phone number", "tel",
            "call", "code", "pin", "ref", "invoice", "ticket", "weighs", "weighing", "box no.", "parcel no.",
            "parcel number", "package number", "package no.", "order #", "package #", "parcel #", "box #",
            "within the next", "about", "robot number", "box number",
        ]),
    ],
    cardinals: &[
        ("zero", 0), ("one", 1), ("two", 2), ("three", 3), ("four", 4), ("five", 5), ("six", 6), ("seven", 7),
        ("eight", 8), ("nine", 9), ("ten", 10), ("eleven", 11), ("twelve", 12), ("thirteen", 13), ("fourteen", 14),
        ("fifteen", 15), ("sixteen", 16), ("seventeen", 17), ("eighteen", 18), ("nineteen", 19), ("twenty", 20),
        ("thirty", 30), ("forty", 40), ("fifty", 50), ("sixty", 60), ("seventy", 70), ("eighty", 80), ("ninety", 90),
        ("hundred", 100),
    ],
    ordinals: &[
        ("first", 1), ("second", 2), ("third", 3), ("fourth", 4), ("fifth", 5), ("sixth", 6), ("seventh", 7),
        ("eighth", 8), ("ninth", 9), ("tenth", 10), ("eleventh", 11), ("twelfth", 12), ("thirteenth", 13),
        ("fourteenth", 14), ("fifteenth", 15), ("sixteenth", 16), ("seventeenth", 17), ("eighteenth", 18),
        ("nineteenth", 19), ("twentieth", 20), ("thirtieth", 30), ("fortieth", 40),
    ],
    ordinal_endings: &["st", "nd", "rd", "th"],
    joints: &[],
    units_first: None,
    number_first: false,
    script: Script::Latin,
};
