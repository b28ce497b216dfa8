//! Other text of streets: shop signs, posters, street names, parking, notices, graffiti, number
//! plates of cars. None says where a door leads: readers must not take them for door plates.

use openbench_osm::draws::{between, pick};
use rand_pcg::Pcg64Mcg;

use super::design::{Color, Design, Make, Outline, Rim};
use super::typefaces::{self, Style, TypefaceSet};
use super::wording::{Language, Line};

const WHITE: Color = [244, 243, 238];
const BLACK: Color = [22, 22, 24];
const BLUE: Color = [22, 48, 122];

/// A kind of other text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum SignKind {
    /// Name of a shop, over its window.
    Shop,
    /// A bill on a wall.
    Poster,
    /// Paint on a wall.
    Graffiti,
    /// "No advertising" and the like, at doors.
    Notice,
    /// When one may park.
    Parking,
    /// Name of a street.
    Street,
    /// Number plate of a car.
    Car,
}

/// What a sign looks like and what it says.
pub(crate) struct Sign {
    pub design: Design,
    pub lines: Vec<Line>,
}

fn line(text: impl Into<String>, size: f64) -> Line {
    Line {
        text: text.into(),
        size,
    }
}

/// A sign of a kind; `street` is the name of the street there.
pub(crate) fn draw_sign(
    kind: SignKind,
    language: Language,
    street: &str,
    draws: &mut Pcg64Mcg,
    set: TypefaceSet,
) -> Sign {
    let lines = lines(kind, language, street, draws);
    let (make, capital_m, styles): (Make, f64, &[Style]) = match kind {
        SignKind::Shop => (
            Make::Acrylic,
            between(draws, 0.20, 0.32),
            &[
                Style::Plain,
                Style::Script,
                Style::Slab,
                Style::Deco,
                Style::Rounded,
            ],
        ),
        SignKind::Poster => (
            Make::Sticker,
            between(draws, 0.06, 0.11),
            &[Style::Plain, Style::Condensed, Style::Slab, Style::Deco],
        ),
        SignKind::Graffiti => (
            Make::Cast,
            between(draws, 0.25, 0.5),
            &[Style::Hand, Style::Script],
        ),
        SignKind::Notice => (Make::Sticker, 0.022, &[Style::Plain, Style::Rounded]),
        SignKind::Parking => (Make::Enamel, 0.16, &[Style::Plain]),
        SignKind::Street => (
            Make::Enamel,
            0.10,
            &[Style::Plain, Style::Condensed, Style::Serif],
        ),
        SignKind::Car => (Make::Enamel, 0.072, &[Style::Condensed]),
    };
    let design = Design::of(make, draws, set);
    let [paper, ink] = pick(draws, colors(kind));
    let has_rim = matches!(kind, SignKind::Street | SignKind::Parking | SignKind::Car);
    let sign = Design {
        capital_m,
        typeface: pick(draws, &typefaces::of(set, styles)),
        paper,
        ink,
        outline: Outline::Square,
        rim: if has_rim { Rim::Single } else { Rim::None },
        screws: false,
        widest_m: 2.6,
        lowest_m: 0.01,
        ..design
    };
    Sign {
        design: sign,
        lines,
    }
}

/// Colours of board and letters.
fn colors(kind: SignKind) -> &'static [[Color; 2]] {
    match kind {
        SignKind::Shop => &[
            [[150, 26, 30], WHITE],
            [[20, 70, 52], [236, 206, 120]],
            [BLACK, WHITE],
            [[236, 190, 40], BLACK],
            [WHITE, [30, 60, 130]],
        ],
        SignKind::Poster => &[
            [[230, 90, 40], WHITE],
            [[240, 206, 60], BLACK],
            [[60, 130, 170], WHITE],
            [[238, 234, 222], [150, 24, 28]],
            [[90, 40, 110], [244, 220, 120]],
        ],
        SignKind::Graffiti => &[
            [BLACK, [30, 30, 34]],
            [BLACK, [176, 36, 44]],
            [BLACK, [40, 90, 170]],
            [BLACK, [212, 214, 214]],
        ],
        SignKind::Notice => &[
            [WHITE, [170, 26, 30]],
            [WHITE, BLACK],
            [[240, 200, 40], BLACK],
        ],
        SignKind::Parking | SignKind::Street => &[[BLUE, WHITE], [WHITE, BLACK]],
        SignKind::Car => &[[WHITE, BLACK], [[238, 206, 70], BLACK]],
    }
}

fn lines(kind: SignKind, language: Language, street: &str, draws: &mut Pcg64Mcg) -> Vec<Line> {
    match kind {
        SignKind::Shop => vec![line(pick(draws, shops(language)), 1.0)],
        SignKind::Poster => {
            let title = pick(
                draws,
                &["FESTIVAL", "CIRCUS", "JAZZ", "FLOHMARKT", "YOGA", "THEATRE"],
            );
            let day = pick(
                draws,
                &["14. 6.", "22. 9.", "3. 10.", "SA 19:30", "SO 11:00"],
            );
            let place = pick(
                draws,
                &["Arena", "Stadtpark", "Town Hall", "Club 7", "Hall B"],
            );
            vec![line(title, 1.0), line(day, 0.8), line(place, 0.5)]
        }
        SignKind::Graffiti => {
            let tag = pick(
                draws,
                &[
                    "ZOK", "KREW", "nemo", "RASK", "Sone", "LOVE", "1UP", "2FAST",
                ],
            );
            vec![line(tag, 1.0)]
        }
        SignKind::Notice => notice(language)
            .iter()
            .map(|text| line(*text, 1.0))
            .collect(),
        SignKind::Parking => {
            let hours = pick(draws, &["8-18 h", "9-19 h", "7-22 h"]);
            let days = pick(draws, &["Mo-Fr", "Mo-Sa"]);
            vec![line("P", 1.0), line(days, 0.4), line(hours, 0.4)]
        }
        SignKind::Street => vec![line(street, 1.0)],
        SignKind::Car => {
            let town = pick(draws, &["KR", "BA", "HD", "MC", "W", "B", "KL", "AB"]);
            let number = between(draws, 100.0, 9_999.0) as u32;
            let end = pick(draws, &["AX", "CF", "DL", "HT", "KM", "PV"]);
            vec![line(format!("{town} {number} {end}"), 1.0)]
        }
    }
}

fn shops(language: Language) -> &'static [&'static str] {
    match language {
        Language::English => &[
            "Bakery",
            "Corner Café",
            "Barber",
            "Pharmacy",
            "Books",
            "Deli",
        ],
        Language::German => &[
            "Bäckerei",
            "Apotheke",
            "Friseur",
            "Café Central",
            "Blumen",
            "Optik",
        ],
        Language::French => &["Boulangerie", "Pharmacie", "Tabac", "Coiffure", "Épicerie"],
        Language::Italian => &[
            "Farmacia",
            "Panificio",
            "Bar Sport",
            "Tabacchi",
            "Gelateria",
        ],
        Language::Spanish => &["Farmacia", "Panadería", "Bar", "Peluquería", "Frutas"],
        Language::Portuguese => &["Farmácia", "Padaria", "Café", "Talho", "Mercearia"],
        Language::Chinese => &["便利店", "药房", "包子", "水果店", "理发", "书店"],
    }
}

fn notice(language: Language) -> &'static [&'static str] {
    match language {
        Language::English => &["NO ADVERTISING", "PLEASE"],
        Language::German => &["BITTE KEINE", "WERBUNG"],
        Language::French => &["PAS DE PUB", "S.V.P."],
        Language::Italian => &["NIENTE", "PUBBLICITÀ"],
        Language::Spanish => &["NO ADMITE", "PUBLICIDAD"],
        Language::Portuguese => &["PUBLICIDADE", "NÃO, OBRIGADO"],
        Language::Chinese => &["请勿张贴广告"],
    }
}

#[cfg(test)]
mod tests {
    use openbench_osm::draws::stream;

    use super::*;

    #[test]
    fn no_sign_reads_as_the_number_of_a_door() {
        let kinds = [
            SignKind::Shop,
            SignKind::Poster,
            SignKind::Graffiti,
            SignKind::Notice,
            SignKind::Parking,
            SignKind::Street,
            SignKind::Car,
        ];
        for (i, kind) in kinds.iter().cycle().take(700).enumerate() {
            let draws = &mut stream(1, 1, i as u64);
            let sign = draw_sign(
                *kind,
                Language::German,
                "Gasse",
                draws,
                TypefaceSet::Training,
            );
            for line in &sign.lines {
                let has_letters = line.text.chars().any(char::is_alphabetic);
                // Dates of posters alone have none.
                assert!(has_letters || line.text.contains(". "), "{}", line.text);
            }
        }
    }
}
