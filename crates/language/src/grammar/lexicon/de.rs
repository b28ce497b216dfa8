//! German, the most usual words.

use super::Class::*;
use super::{Lexicon, Script};

#[rustfmt::skip]
pub(super) const LEXICON: Lexicon = Lexicon {
    words: &[
        (Building, &["gebäude", "gebaeude", "haus", "häuser", "block", "turm", "wohnblock", "gebäuden", "hausnummer"]),
        (Unit, &[
            "hauseingänge", "hauseingängen", "aufgänge", "aufgängen", "pforte", "eingang", "eingänge", "eingängen",
            "einheit", "einheiten", "tür", "türen", "tuer", "aufgang", "treppenhaus", "hauseingang",
        ]),
        (Room, &["wohnung", "wohnungen", "zimmer", "raum", "büro", "apartment"]),
        (Floor, &["stock", "etage", "stockwerk"]),
        (Sign, &["nummer", "nr", "nr.", "#"]),
        (Link, &["in", "im", "von", "vom", "bei", "am", "des", "an"]),
        (Article, &["der", "die", "das", "den", "dem"]),
        (Toward, &["zu", "zum", "zur", "ins", "für", "zu den", "bis zu"]),
        (TowardOrAfter, &["nach"]),
        (And, &["nicht nur", "sondern auch", "und", "sowie", "oder"]),
        (Range, &["bis"]),
        (Then, &[
            "dann", "und dann", "danach", "anschließend", "und danach", "später", "als nächstes", "hierauf", "darauf",
            "im anschluss", "hinterher", "und anschließend", "von dort",
        ]),
        (Finally, &[
            "schließe mit", "hör auf bei", "als abschluss", "und ende bei", "letzter halt", "letzte station",
            "letzter stopp", "als letzter halt", "zuletzt", "zum schluss", "schließlich", "am ende", "am schluss",
            "als letztes", "zu guter letzt", "hör bei", "höre bei", "ende bei", "ende mit", "hör mit",
            "beende die tour bei", "abschließend", "und zuletzt",
        ]),
        (First, &[
            "starten bei", "beginnend mit", "los geht es bei", "angefangen bei", "erster halt", "erste station",
            "erster stopp", "zuerst", "erst", "als erstes", "zunächst", "fang bei", "fange bei", "fang mit",
            "fange mit", "beginne bei", "beginn bei", "beginne mit", "beginn mit", "starte bei", "starte mit",
            "anfangen mit", "am anfang", "vor allem anderen", "am dringendsten",
        ]),
        (Before, &["bevor", "ehe", "bevor du zu", "bevor sie zu"]),
        (After, &["nachdem", "erst nach", "gleich nach", "direkt nach", "im anschluss an", "sobald", "und zwar nach"]),
        (Not, &[
            "lösch", "lösche", "löschen sie", "entfern", "entferne", "ignorier", "ignoriere", "ignorieren sie",
            "mit ausnahme von", "abgesehen von", "bis auf", "anstelle von", "außer bei", "nicht bei", "nicht an",
            "nicht in", "nicht", "kein", "statt", "außer", "anstatt", "und nicht", "ohne", "nichts für", "vergiss",
            "vergessen sie", "überspring", "überspringe", "überspringen sie", "streich", "streiche", "streichen sie",
            "storniere", "nicht mehr", "auf keinen fall", "niemals", "nicht zu",
        ]),
        (Dropped, &[
            "heute aus", "diesmal aus", "vorerst aus", "morgen aus", "diese woche aus", "bitte aus", "erstmal aus",
            "gelöscht", "verschoben", "vertagt", "erledigt", "nichts mehr", "will nichts", "ausgefallen", "weglassen",
            "auslassen", "überspringen", "streichen", "stornieren", "vergessen", "hat storniert", "haben storniert",
            "braucht nichts mehr", "ausgesetzt", "zurückgestellt", "hat abgesagt", "haben abgesagt", "zurückgezogen",
            "will nichts mehr", "storniert", "abgesagt", "entfällt", "fällt aus", "fällt weg", "nichts", "nichts dabei",
            "gestrichen", "braucht nichts", "bekommt nichts", "hat sich erledigt", "abbestellt",
        ]),
        (Correct, &[
            "stimmt nicht", "falsch", "ich korrigiere", "wollte sagen", "ich wollte sagen", "oder besser",
            "oder besser gesagt", "oder vielmehr", "ach so", "das heißt", "hoppla", "mein fehler", "genauer",
            "ich meine", "ich meinte", "entschuldigung", "nein", "quatsch", "besser gesagt", "korrektur", "nein, warte",
            "nein, moment", "nein, warten sie", "moment", "ach nein", "doch lieber", "lieber", "sorry", "vielmehr",
            "genauer gesagt", "ach quatsch", "verzeihung", "doch nicht", "pardon", "ich sagte", "nein, doch", "sondern",
            "beziehungsweise nein", "nein, entschuldigung", "nein, ich meine",
        ]),
        (Elsewhere, &["aus", "neben", "nahe", "gegenüber von", "gegenüber", "hinter", "vor", "in der nähe von"]),
        (Same, &[
            "selben gebäude", "im selben gebäude", "selben haus", "im selben haus", "gleichen gebäude",
            "im gleichen gebäude", "gleichen haus", "im gleichen haus", "desselben gebäudes", "desselben hauses",
            "dasselbe haus", "dasselbe gebäude",
        ]),
        (Each, &["je", "jede", "jeder", "jedes"]),
        (Title, &["herr", "herrn", "frau", "dr", "dr.", "prof", "prof.", "familie"]),
        (Wait, &[
            "warten, bis", "warten bis", "warte, bis", "warte bis", "wartet, bis", "warten auf", "kommt nach",
            "erst wenn", "erst, wenn",
        ]),
        (Override, &[
            "ignoriere das obige", "ignoriere alles obige", "ignoriere alles davor", "ignoriere die obigen anweisungen",
            "ignoriere alle vorherigen anweisungen", "ignorieren sie das obige", "vergiss alles davor",
            "vergiss das obige",
        ]),
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
            "nicht nur das", "nichts anderes als", "nichts als", "diese woche", "heute früh", "heute nachmittag",
            "noch immer", "weiterhin", "vorerst", "vergiss nicht", "vergessen sie nicht", "nicht vergessen",
            "fürs erste", "diesmal", "im moment", "erstmal", "bitte", "sie", "es", "danke", "hallo", "können",
            "könnten", "kannst", "du", "auch", "mit", "ab", "mir", "uns", "heute", "morgen", "jetzt", "wurde", "wurden",
            "wird", "werden", "noch", "übrig", "nur", "dort", "hier", "schon", "er", "leider", "worden", "hat", "haben",
            "bekommt", "bekommen", "man",
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
    ones: &[],
    joints: &[],
    units_first: Some("und"),
    number_first: false,
    script: Script::Latin,
};
