//! Spanish, the most usual words.

use super::Class::*;
use super::{Lexicon, Script, Times};

#[rustfmt::skip]
pub(super) const LEXICON: Lexicon = Lexicon {
    words: &[
        (Building, &[
            "edificio", "edificios", "bloque", "bloques", "torre", "torres", "casa", "casas", "edif", "edif.",
        ]),
        (Unit, &[
            "unidad", "unidades", "entrada", "entradas", "puerta", "puertas", "portal", "portales", "escalera",
            "escaleras",
        ]),
        (Room, &["apartamento", "apartamentos", "piso", "departamento", "habitación", "oficina", "apto"]),
        (Floor, &["planta"]),
        (Sign, &["número", "núm", "n.º", "nº", "#"]),
        (Link, &["de", "del", "en", "dentro de"]),
        (Article, &["el", "la", "los", "las"]),
        (Toward, &["a", "al", "hasta", "para", "hacia", "a la", "para la", "es para"]),
        (And, &["no solo", "no sólo", "sino también", "y", "e", "así como", "o"]),
        (Then, &[
            "luego", "y luego", "después", "y después", "a continuación", "más tarde", "entonces", "seguidamente",
            "acto seguido", "posteriormente", "y a continuación", "de ahí",
        ]),
        (Finally, &[
            "finaliza en", "finalice en", "concluye en", "terminando en", "acabando en", "última parada", "finalmente",
            "por último", "y por último", "al final", "para terminar", "para acabar", "acaba en", "acaba por",
            "acaba con", "acabe en", "termina en", "termina con", "termina por", "termine en", "y al final",
            "en último lugar",
        ]),
        (First, &[
            "arranca en", "arranca por", "inicia en", "empezando por", "comenzando por", "primera parada",
            "primeramente", "en primer lugar", "empieza por", "comienza por", "empieza en", "comienza en",
            "empieza con", "comienza con", "empiece por", "comience por", "antes que nada", "antes de nada",
            "lo urgente primero", "lo primero", "ante todo",
        ]),
        (Before, &[
            "antes de", "antes de ir", "antes del", "antes de ir a", "antes de ir al", "hasta que", "hasta terminar",
            "hasta terminar con", "hasta acabar", "hasta acabar con", "hasta haber", "antes de pasar por",
            "hasta después de",
        ]),
        (After, &[
            "después de", "después del", "tras", "solo después de", "solo después del", "sólo después de",
            "sólo después del", "luego de", "después de pasar por", "una vez hecho", "al salir de",
        ]),
        (Not, &[
            "tacha", "tache", "elimina", "elimine", "quita", "quite", "borra", "borre", "suprime", "suprima",
            "descarta", "descarte", "prescinde de", "prescinde del", "anula", "anule", "no vayas a", "no vaya a",
            "exceptuando", "menos", "aparta", "no", "excepto", "en vez de", "en lugar de", "salvo", "sin", "y no",
            "en vez del", "en lugar del", "nada para", "no hay nada para", "olvida", "olvide", "olvida lo de",
            "olvida lo del", "olvide lo de", "olvide lo del", "olvídate de", "olvídate del", "olvídese de",
            "olvídese del", "sáltate", "sáltese", "salta", "omite", "omita", "cancela", "cancele", "deja fuera",
            "evita", "evite", "nunca", "ya no",
        ]),
        (Dropped, &[
            "ya no quiere nada", "ya no necesita nada", "suspendido", "suspendida", "retirado", "retirada", "aplazado",
            "aplazada", "no pidió nada", "no espera nada", "ya no quiere", "de baja", "se cancela", "se canceló",
            "queda cancelado", "fue cancelado", "fue cancelada", "se puede omitir", "se puede saltar", "ha cancelado",
            "lo ha cancelado", "ha anulado", "lo ha anulado", "cancelado", "cancelada", "cancelados", "canceladas",
            "anulado", "anulada", "anulados", "anuladas", "no necesita nada", "no recibe nada", "no quiere nada",
            "ya no hace falta", "no hace falta", "queda fuera",
        ]),
        (Correct, &[
            "o sea", "bueno no", "rectifico", "corrijo", "no no", "disculpa", "disculpe", "ay no", "en realidad",
            "no, en realidad", "quise decir", "quería decir", "me confundí", "perdón", "quiero decir", "mejor dicho",
            "digo", "no, perdón", "corrección", "no, espere", "no, espera", "espera", "espere", "no, mejor", "mejor",
            "perdona", "perdone", "me equivoqué", "o mejor", "o más bien", "más bien", "no, digo", "lo siento",
            "no, quiero decir", "sino", "me he equivocado",
        ]),
        (Elsewhere, &[
            "desde", "cerca de", "cerca del", "al lado de", "al lado del", "junto a", "junto al", "frente a",
            "frente al", "detrás de", "detrás del",
        ]),
        (Same, &[
            "mismo edificio", "del mismo edificio", "el mismo edificio", "en el mismo edificio", "mismo bloque",
            "del mismo bloque", "misma torre", "misma casa",
        ]),
        (Each, &["cada una", "cada uno", "cada"]),
        (Title, &["señor", "señora", "señorita", "sr", "sr.", "sra", "sra.", "don", "doña", "dr.", "dra."]),
        (Wait, &[
            "esperar hasta que", "esperar a que", "espera a que", "esperar a", "esperar al", "va después de",
            "va después del", "solo cuando", "sólo cuando",
        ]),
        (Override, &[
            "ignora lo anterior", "ignore lo anterior", "olvida lo anterior", "olvide lo anterior",
            "ignora las instrucciones anteriores", "ignore las instrucciones anteriores", "ignora todo lo anterior",
        ]),
        (Respectively, &["respectivamente"]),
        (Item, &[
            "caja", "cajas", "paquete", "paquetes", "comida", "carta", "cartas", "pedido", "envío", "bolsa", "libro",
            "libros", "compra", "medicina", "flores", "artículo", "cosa", "sobre", "pizza", "bulto", "mercancía",
        ]),
        (Determiner, &["este", "esta", "estos", "estas", "ese", "esa", "un", "una", "mi", "otro", "otra", "su"]),
        (Verb, &[
            "entregue", "entrega", "entregar", "lleva", "lleve", "llevar", "ve", "vaya", "ir", "trae", "traiga", "deja",
            "deje", "dejar", "envía", "manda", "es", "va", "pon",
        ]),
        (Filler, &[
            "no queda más que", "no quedan más que", "no hay más que", "esta semana", "esta tarde", "todavía", "aún",
            "por ahora", "no olvides", "no olvide", "no te olvides de", "de momento", "esta vez", "por favor",
            "gracias", "hola", "puede", "puedes", "que", "con", "se", "lo", "me", "favor", "por", "hoy", "mañana",
            "ahora", "ha", "han", "sido", "está", "están", "queda", "quedan", "solo", "sólo", "hay", "sí", "también",
            "ya", "robot",
        ]),
        (Measure, &[
            "kg", "kilos", "gramos", "g", "metros", "m", "minutos", "horas", "h", "euros", "pm", "am", "veces",
        ]),
        (Reference, &["teléfono", "número de pedido", "código", "pesa", "referencia", "llame al"]),
    ],
    cardinals: &[
        ("cero", 0), ("uno", 1), ("dos", 2), ("tres", 3), ("cuatro", 4), ("cinco", 5), ("seis", 6), ("siete", 7),
        ("ocho", 8), ("nueve", 9), ("diez", 10), ("once", 11), ("doce", 12), ("trece", 13), ("catorce", 14),
        ("quince", 15), ("dieciséis", 16), ("diecisiete", 17), ("dieciocho", 18), ("diecinueve", 19), ("veinte", 20),
        ("veintiuno", 21), ("veintidós", 22), ("veintitrés", 23), ("veinticuatro", 24), ("veinticinco", 25),
        ("treinta", 30), ("cuarenta", 40), ("cincuenta", 50), ("cien", 100),
    ],
    ordinals: &[
        ("primero", 1), ("primera", 1), ("primer", 1), ("segundo", 2), ("segunda", 2), ("tercero", 3),
        ("tercera", 3), ("tercer", 3), ("cuarto", 4), ("cuarta", 4), ("quinto", 5), ("quinta", 5), ("sexto", 6),
        ("sexta", 6), ("séptimo", 7), ("séptima", 7), ("octavo", 8), ("octava", 8), ("noveno", 9), ("novena", 9),
        ("décimo", 10), ("décima", 10),
    ],
    ordinal_endings: &["º", "ª", "er"],
    ones: &[],
    joints: &["y"],
    units_first: None,
    number_first: false,
    script: Script::Latin,
    times: Times {
        by: &["antes de las", "antes de la", "antes de", "a más tardar a las", "para las", "no más tarde de las"],
        by_after: &[],
        within: &["en menos de", "dentro de", "dentro de los próximos", "en los próximos", "en las próximas", "en un plazo de"],
        within_after: &["como máximo"],
        clock: &["h", "horas", "hrs"],
        half: &[],
        am: &["am", "a.m.", "de la mañana"],
        pm: &["pm", "p.m.", "de la tarde", "de la noche"],
        noon: &["mediodía", "el mediodía", "del mediodía"],
        minutes: &["minuto", "minutos", "min"],
        hours: &["hora", "horas"],
        half_hour: &["media hora"],
        one_hour: &["una hora"],
        all: &["ambos", "ambas", "todo", "todos", "todas"],
        other_days: &["mañana", "pasado mañana", "lunes", "martes", "miércoles", "jueves", "viernes", "sábado", "domingo"],
        from: &["de", "entre", "desde", "desde las", "de las"],
        has_half_days: true,
    },
};
