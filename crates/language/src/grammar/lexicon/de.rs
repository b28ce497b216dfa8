//! German, the most usual words.

use super::Class::*;
use super::{Lexicon, Script};

#[rustfmt::skip]
pub(super) const LEXICON: Lexicon = Lexicon {
    words: &[
        (Building, &["gebäude", "gebaeude", "haus", "häuser", "block", "turm", "wohnblock", "gebäuden", "hausnummer"]),
        (Unit, &[
            "eingang", "eingänge", "eingängen", "einheit", "einheiten", "tür", "türen", "tuer", "aufgang",
            "treppenhaus", "hauseingang",
        ]),
        (Room, &["wohnung", "wohnungen", "zimmer", "raum", "büro", "apartment"]),
        (Floor, &["stock", "etage", "stockwerk"]),
        (Sign, &["nummer", "nr", "nr.", "#"]),
        (Link, &["in", "im", "von", "vom", "bei", "am", "des", "an"]),
        (Article, &["der", "die", "das", "den", "dem"]),
        (Toward, &["zu", "zum", "zur", "nach", "ins", "für", "zu den", "bis zu"]),
        (And, &["und", "sowie", "oder"]),
        (Range, &["bis"]),
        (Then, &[
            "dann", "und dann", "danach", "anschließend", "und danach", "zuletzt", "zum schluss", "schließlich",
            "später", "als nächstes",
        ]),
        (First, &["zuerst", "erst", "als erstes", "zunächst"]),
        (Before, &["bevor", "vorher"]),
        (After, &["nachdem"]),
        (Not, &["nicht", "kein", "statt", "außer", "anstatt", "und nicht", "ohne"]),
        (Correct, &["ich meine", "entschuldigung", "nein", "quatsch", "besser gesagt", "korrektur"]),
        (Elsewhere, &["aus", "neben", "nahe", "gegenüber von", "gegenüber", "hinter", "vor", "in der nähe von"]),
        (Respectively, &["jeweils", "beziehungsweise"]),
        (Item, &[
            "paket", "pakete", "kiste", "kisten", "karton", "kartons", "päckchen", "brief", "briefe", "sendung",
            "essen", "tasche", "buch", "bücher", "medikamente", "blumen", "einkauf", "einkäufe", "lebensmittel",
            "lieferung", "schachtel", "ware", "pizza",
        ]),
        (Determiner, &[
            "dieses", "diese", "diesen", "dieser", "ein", "eine", "einen", "mein", "meine", "noch ein", "ihr",
        ]),
        (Verb, &[
            "liefern", "liefere", "liefern sie", "bringen", "bring", "bringe", "bringen sie", "fahre", "fahr", "geh",
            "gehe", "stellen", "stelle", "kommt", "geht", "soll", "ist", "abgeben", "gib",
        ]),
        (Filler, &[
            "bitte", "sie", "es", "danke", "hallo", "können", "könnten", "kannst", "du", "auch", "mit", "ab", "mir",
            "uns",
        ]),
        (Measure, &["kg", "kilo", "gramm", "g", "uhr", "minuten", "stunden", "meter", "m", "euro", "mal", "stück"]),
        (Reference, &["telefon", "bestellnummer", "bestellung", "auftrag", "code", "wiegt", "rufnummer", "tel"]),
    ],
    cardinals: &[
        ("null", 0), ("eins", 1), ("zwei", 2), ("zwo", 2), ("drei", 3), ("vier", 4), ("fünf", 5), ("sechs", 6),
        ("sieben", 7), ("acht", 8), ("neun", 9), ("zehn", 10), ("elf", 11), ("zwölf", 12), ("dreizehn", 13),
        ("vierzehn", 14), ("fünfzehn", 15), ("sechzehn", 16), ("siebzehn", 17), ("achtzehn", 18), ("neunzehn", 19),
        ("zwanzig", 20), ("dreißig", 30), ("vierzig", 40), ("fünfzig", 50), ("sechzig", 60), ("siebzig", 70),
        ("achtzig", 80), ("neunzig", 90), ("hundert", 100),
    ],
    ordinals: &[
        ("erste", 1), ("ersten", 1), ("erster", 1), ("erstes", 1), ("zweite", 2), ("zweiten", 2), ("zweiter", 2),
        ("zweites", 2), ("dritte", 3), ("dritten", 3), ("dritter", 3), ("drittes", 3), ("vierte", 4), ("vierten", 4),
        ("vierter", 4), ("viertes", 4), ("fünfte", 5), ("fünften", 5), ("sechste", 6), ("sechsten", 6),
        ("siebte", 7), ("siebten", 7), ("achte", 8), ("achten", 8), ("neunte", 9), ("neunten", 9), ("zehnte", 10),
        ("zehnten", 10),
    ],
    ordinal_endings: &["ten", "ter", "te"],
    joints: &[],
    units_first: Some("und"),
    number_first: false,
    script: Script::Latin,
};
