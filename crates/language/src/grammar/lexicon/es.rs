//! Spanish, the most usual words.

use super::Class::*;
use super::{Lexicon, Script};

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
        (And, &["y", "e", "así como", "o"]),
        (Then, &[
            "luego", "y luego", "después", "y después", "finalmente", "por último", "y por último", "a continuación",
            "más tarde", "entonces",
        ]),
        (First, &["primeramente", "en primer lugar", "empieza por", "comienza por"]),
        (Before, &["antes de", "antes de ir"]),
        (After, &["después de", "tras"]),
        (Not, &["no", "excepto", "en vez de", "en lugar de", "salvo", "sin", "y no"]),
        (Correct, &["perdón", "quiero decir", "mejor dicho", "digo", "no, perdón", "corrección"]),
        (Elsewhere, &[
            "desde", "cerca de", "cerca del", "al lado de", "al lado del", "junto a", "junto al", "frente a",
            "frente al", "detrás de", "detrás del",
        ]),
        (Respectively, &["respectivamente"]),
        (Item, &[
            "caja", "cajas", "paquete", "paquetes", "comida", "carta", "cartas", "pedido", "envío", "bolsa", "libro",
            "libros", "compra", "medicina", "flores", "artículo", "cosa", "sobre", "pizza", "bulto", "mercancía",
        ]),
        (Determiner, &["este", "esta", "estos", "estas", "ese", "esa", "un", "una", "mi", "otro", "otra", "su"]),
        (Verb, &[
            "entregue", "entrega", "entregar", "lleva", "lleve", "llevar", "ve", "vaya", "ir", "trae", "traiga",
            "deja", "deje", "dejar", "envía", "manda", "es", "va", "pon",
        ]),
        (Filler, &["por favor", "gracias", "hola", "puede", "puedes", "que", "con", "se", "lo", "me", "favor", "por"]),
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
    joints: &["y"],
    units_first: None,
    number_first: false,
    script: Script::Latin,
};
