//! French, the most usual words.

use super::Class::*;
use super::{Lexicon, Script};

#[rustfmt::skip]
pub(super) const LEXICON: Lexicon = Lexicon {
    words: &[
        (Building, &[
            "bâtiment", "bâtiments", "immeuble", "immeubles", "bloc", "blocs", "tour", "tours", "maison", "maisons",
            "bât", "bât.", "résidence",
        ]),
        (Unit, &["unité", "unités", "entrée", "entrées", "porte", "portes", "cage d'escalier", "escalier"]),
        (Room, &["appartement", "appartements", "chambre", "bureau", "appt", "logement"]),
        (Floor, &["étage"]),
        (Sign, &["numéro", "n°", "nº", "no.", "#"]),
        (Link, &["de", "du", "des", "dans", "d'", "en", "sur"]),
        (Article, &["le", "la", "les", "l'"]),
        (Toward, &["à", "au", "aux", "vers", "pour", "jusqu'à", "jusqu'au", "chez", "à l'", "est pour"]),
        (And, &["et", "ainsi que", "ou"]),
        (Then, &[
            "puis", "et puis", "ensuite", "et ensuite", "enfin", "après ça", "après cela", "finalement",
            "pour finir", "plus tard",
        ]),
        (First, &["d'abord", "tout d'abord", "en premier", "commencez par", "commence par"]),
        (Before, &["avant", "avant d'aller", "avant de"]),
        (After, &["après"]),
        (Not, &["pas", "pas au", "ne", "sauf", "au lieu de", "au lieu du", "plutôt que", "sans", "et non"]),
        (Correct, &["pardon", "je veux dire", "non", "plutôt", "désolé", "enfin non"]),
        (Elsewhere, &[
            "depuis", "près de", "près du", "à côté de", "à côté du", "derrière", "devant", "en face de",
            "en face du",
        ]),
        (Respectively, &["respectivement"]),
        (Item, &[
            "colis", "boîte", "boîtes", "paquet", "paquets", "lettre", "lettres", "carton", "cartons", "courrier",
            "repas", "sac", "livre", "livres", "courses", "médicaments", "fleurs", "commande", "article",
            "livraison", "pizza",
        ]),
        (Determiner, &[
            "ce", "cet", "cette", "ces", "un", "une", "mon", "ma", "celui-ci", "celle-ci", "un autre", "une autre",
            "votre",
        ]),
        (Verb, &[
            "livrez", "livrer", "livre-le", "apportez", "apporte", "apporter", "allez", "va", "aller", "déposez",
            "dépose", "déposer", "portez", "est", "emmène", "mettez", "envoyez", "amenez",
        ]),
        (Filler, &[
            "s'il vous plaît", "s'il te plaît", "svp", "merci", "bonjour", "veuillez", "pouvez-vous", "vous", "avec",
            "que", "qui", "se",
        ]),
        (Measure, &["kg", "kilos", "grammes", "g", "h", "heures", "minutes", "mètres", "m", "euros", "fois"]),
        (Reference, &["téléphone", "numéro de commande", "code", "pèse", "tél"]),
    ],
    cardinals: &[
        ("zéro", 0), ("un seul", 1), ("deux", 2), ("trois", 3), ("quatre", 4), ("cinq", 5), ("six", 6), ("sept", 7),
        ("huit", 8), ("neuf", 9), ("dix", 10), ("onze", 11), ("douze", 12), ("treize", 13), ("quatorze", 14),
        ("quinze", 15), ("seize", 16), ("dix-sept", 17), ("dix-huit", 18), ("dix-neuf", 19), ("vingt", 20),
        ("trente", 30), ("quarante", 40), ("cinquante", 50), ("soixante", 60), ("quatre-vingt", 80),
        ("quatre-vingts", 80), ("cent", 100),
    ],
    ordinals: &[
        ("premier", 1), ("première", 1), ("deuxième", 2), ("second", 2), ("seconde", 2), ("troisième", 3),
        ("quatrième", 4), ("cinquième", 5), ("sixième", 6), ("septième", 7), ("huitième", 8), ("neuvième", 9),
        ("dixième", 10), ("onzième", 11), ("douzième", 12),
    ],
    ordinal_endings: &["er", "ère", "e", "ème", "eme", "re"],
    joints: &["et"],
    units_first: None,
    number_first: false,
    script: Script::Latin,
};
