//! French, the most usual words.

use super::Class::*;
use super::{Lexicon, Script, Times};

#[rustfmt::skip]
pub(super) const LEXICON: Lexicon = Lexicon {
    words: &[
        (Building, &[
            "bâtiment", "bâtiments", "immeuble", "immeubles", "bloc", "blocs", "tour", "tours", "maison", "maisons",
            "bât", "bât.", "résidence",
        ]),
        (Unit, &[
            "unité", "unités", "entrée", "entrées", "porte", "portes", "cage d'escalier", "escalier", "hall", "halls",
            "cage", "allée",
        ]),
        (Room, &["appartement", "appartements", "chambre", "bureau", "appt", "logement"]),
        (Floor, &["étage"]),
        (Sign, &["numéro", "n°", "nº", "no.", "#"]),
        (Link, &["de", "du", "des", "dans", "d'", "en", "sur"]),
        (Article, &["le", "la", "les", "l'"]),
        (Toward, &["à", "au", "aux", "vers", "pour", "jusqu'à", "jusqu'au", "chez", "à l'", "est pour"]),
        (And, &["pas seulement", "mais aussi", "et", "ainsi que", "ou"]),
        (Then, &[
            "puis", "et puis", "ensuite", "et ensuite", "après ça", "après cela", "plus tard", "par la suite",
            "après quoi", "et après",
        ]),
        (Finally, &[
            "terminer par", "finir par", "conclus par", "en terminant par", "en finissant par", "dernier arrêt",
            "enfin", "finalement", "pour finir", "pour terminer", "finis par", "finissez par", "finis à", "termine par",
            "terminez par", "termine à", "en dernier", "en dernier lieu", "à la fin", "et enfin", "finis avec",
            "termine avec", "et pour finir",
        ]),
        (First, &[
            "débute par", "débutez par", "démarre par", "démarrez par", "en commençant par", "premier arrêt", "d'abord",
            "tout d'abord", "en premier", "commencez par", "commence par", "commencez à", "commence à",
            "en premier lieu", "avant tout", "en priorité", "l'urgent d'abord", "pour commencer",
        ]),
        (Before, &[
            "avant d'être allé", "avant d'être allé au", "avant d'être passé", "avant d'être passé au",
            "avant d'avoir livré", "avant d'avoir fini", "avant", "avant d'aller", "avant de", "avant d'aller à",
            "avant d'aller au", "tant que", "avant que", "avant d'avoir fait", "jusqu'à ce que", "avant le", "avant la",
        ]),
        (After, &[
            "après", "qu'après", "seulement après", "une fois passé à", "juste après", "une fois passé au",
            "uniquement après",
        ]),
        (Not, &[
            "raye", "rayez", "supprime", "supprimez", "enlève", "enlevez", "retire", "retirez", "barre", "barrez",
            "écarte", "écartez", "hormis", "excepté", "à part", "à l'exception de", "à l'exception du",
            "inutile d'aller", "pas", "pas au", "ne", "sauf", "au lieu de", "au lieu du", "plutôt que", "sans",
            "et non", "rien pour", "rien à", "rien au", "oublie", "oubliez", "saute", "sautez", "annule", "annulez",
            "ignore", "ignorez", "laisse tomber", "évite", "évitez", "jamais", "et pas", "mais pas", "ne plus",
        ]),
        (Dropped, &[
            "ne veut plus rien", "ne veut rien", "n'attend rien", "n'a rien", "reporté", "reportée", "retiré",
            "retirée", "rayé", "rayée", "n'a plus besoin", "ne veut plus", "peut être ignoré", "a été annulé",
            "a été annulée", "est annulé", "est annulée", "s'est désisté", "s'est désistée", "se désiste", "a annulé",
            "a décommandé", "annulé", "annulée", "annulés", "annulées", "supprimé", "supprimée", "décommandé",
            "décommandée", "n'a besoin de rien", "ne reçoit rien", "est retiré", "n'en veut plus",
        ]),
        (Correct, &[
            "ou mieux", "je corrige", "je rectifie", "erreur", "oups", "non en fait", "à vrai dire",
            "je me suis trompé", "je me suis trompée", "excuse", "plus exactement", "pardon", "je veux dire", "non",
            "plutôt", "désolé", "enfin non", "non, attendez", "non, attends", "attendez", "attends", "non, pardon",
            "ou plutôt", "je voulais dire", "excusez-moi", "excuse-moi", "correction", "non non", "en fait",
            "mais plutôt", "je me trompe", "non, plutôt", "c'est-à-dire",
        ]),
        (Elsewhere, &[
            "depuis", "près de", "près du", "à côté de", "à côté du", "derrière", "devant", "en face de", "en face du",
        ]),
        (Same, &[
            "même bâtiment", "du même bâtiment", "le même bâtiment", "dans le même bâtiment", "même immeuble",
            "du même immeuble", "même bloc", "du même bloc",
        ]),
        (Each, &["chacun", "chacune", "chaque"]),
        (Title, &["m.", "mme", "mlle", "monsieur", "madame", "mademoiselle", "dr", "famille"]),
        (Wait, &[
            "attendre que", "attend que", "attendre après", "vient après", "seulement quand", "seulement une fois",
        ]),
        (Override, &[
            "ignorez ce qui précède", "ignore ce qui précède", "oubliez ce qui précède", "oublie ce qui précède",
            "ignorez les instructions précédentes", "ignore les instructions précédentes",
        ]),
        (Respectively, &["respectivement"]),
        (Item, &[
            "colis", "boîte", "boîtes", "paquet", "paquets", "lettre", "lettres", "carton", "cartons", "courrier",
            "repas", "sac", "livre", "livres", "courses", "médicaments", "fleurs", "commande", "article", "livraison",
            "pizza",
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
            "ne reste que", "ne reste plus que", "il ne reste que", "il ne reste plus que", "n'y a que", "il n'y a que",
            "ne livrez que", "ne livre que", "n'allez que", "ne va que", "cette semaine", "ce matin", "cet après-midi",
            "encore", "toujours", "pour l'instant", "pour le moment", "n'oublie pas", "n'oubliez pas", "cette fois",
            "s'il vous plaît", "s'il te plaît", "svp", "merci", "bonjour", "veuillez", "pouvez-vous", "vous", "avec",
            "que", "qui", "se", "aujourd'hui", "demain", "maintenant", "a été", "ont été", "tu", "peux", "il", "reste",
            "y", "aussi", "déjà", "là", "c'est", "sont",
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
    ones: &["un", "une"],
    joints: &["et"],
    units_first: None,
    number_first: false,
    script: Script::Latin,
    times: Times {
        by: &["avant", "d'ici", "au plus tard à", ],
        by_after: &[],
        within: &["dans", "dans les", "dans les prochaines", "sous", "en moins de", "d'ici"],
        within_after: &["au plus tard", "maximum"],
        clock: &["h", "heures", "heure"],
        half: &[],
        am: &["du matin"],
        pm: &["de l'après-midi", "du soir"],
        noon: &["midi"],
        minutes: &["minute", "minutes", "min", "prochaines minutes"],
        hours: &["heure", "heures"],
        half_hour: &["une demi-heure", "la demi-heure", "une demi heure"],
        one_hour: &["une heure", "l'heure"],
        all: &["les deux", "tous", "toutes", "tout"],
        other_days: &["demain", "lundi", "mardi", "mercredi", "jeudi", "vendredi", "samedi", "dimanche"],
        from: &["de", "entre"],
        has_half_days: false,
    },
};
