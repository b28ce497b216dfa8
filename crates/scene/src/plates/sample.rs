//! Plates without a world, drawn as those of worlds are: for a contact sheet, and for tests of
//! readers.

use openbench_core::Address;
use openbench_osm::draws::{chance, pick, stream};
use rand_pcg::Pcg64Mcg;

use super::design::{Design, Wear};
use super::face::{Face, draw_face};
use super::settings::StreetPlates;
use super::typefaces::TypefaceSet;
use super::wording::{Facts, Language, Wording};
use crate::material::Texture;

/// Stream of random numbers, distinct from those of worlds.
const PURPOSE: u64 = 110;
/// Width and height of a plate's place on the contact sheet, pixels.
const CELL: [usize; 2] = [104, 72];
/// Plates beside each other on it.
const COLUMNS: usize = 10;
/// Space around a plate, pixels.
const GAP: usize = 6;

/// A plate without a door.
#[derive(Debug, Clone)]
pub struct SampledPlate {
    /// Its image.
    pub face: Face,
    /// What it says, line by line.
    pub lines: Vec<String>,
    /// How it looks.
    pub design: Design,
    /// What time and light did to it.
    pub wear: Wear,
    /// Brightness of the wall behind it, 0 to 1.
    pub wall: f32,
}

impl SampledPlate {
    /// Whether it is lettered in Latin letters.
    pub fn is_latin(&self) -> bool {
        self.lines
            .iter()
            .flat_map(|line| line.chars())
            .all(|c| c < '\u{3000}')
    }
}

/// Plates of a seed, of all languages alike.
pub fn sampled_plates(seed: u64, count: usize) -> Vec<SampledPlate> {
    (0..count as u64)
        .map(|number| sampled(seed, number))
        .collect()
}

fn sampled(seed: u64, number: u64) -> SampledPlate {
    let draws = &mut stream(seed, PURPOSE, number);
    let language = pick(
        draws,
        &[
            Language::English,
            Language::German,
            Language::French,
            Language::Italian,
            Language::Spanish,
            Language::Portuguese,
            Language::Chinese,
        ],
    );
    let facts = sampled_facts(draws, language);
    let wall = pick(draws, &[0.25, 0.35, 0.6, 0.75]);
    let design = Design::draw(draws, TypefaceSet::of_seed(seed)).on_wall(wall);
    let wording = Wording::draw(draws, language, facts.is_only);
    let (_, lines) = wording
        .lines(&facts)
        .unwrap_or((super::Content::Unit, Vec::new()));
    let wear = StreetPlates::REAL.state(draws).wear;
    let names = [0; 4].map(|_| pick(draws, language.family_names()));
    SampledPlate {
        face: draw_face(&design, &lines, &names, wear),
        lines: lines.into_iter().map(|line| line.text).collect(),
        design,
        wear,
        wall,
    }
}

/// The facts of a door that there might be.
fn sampled_facts(draws: &mut Pcg64Mcg, language: Language) -> Facts {
    const STREETS: [(Language, &str); 7] = [
        (Language::English, "Mill Lane"),
        (Language::German, "Ringstraße"),
        (Language::French, "Rue Basse"),
        (Language::Italian, "Via Roma"),
        (Language::Spanish, "Calle Mayor"),
        (Language::Portuguese, "Rua do Sol"),
        (Language::Chinese, "building"),
    ];
    let street = STREETS.iter().find(|(of, _)| *of == language);
    let street = street.map_or("", |(_, name)| name);
    let number = pick(
        draws,
        &[
            1, 2, 3, 5, 7, 8, 12, 14, 21, 36, 49, 58, 67, 93, 104, 118, 230,
        ],
    );
    let after = pick(draws, &["", "", "", "", "", "", "a", "b", "A", "-2"]);
    let number = match after {
        "-2" => format!("{number}-{}", number + 4),
        after => format!("{number}{after}"),
    };
    let number = if language == Language::French && chance(draws, 0.15) {
        format!("{number} bis")
    } else {
        number
    };
    let unit = pick(
        draws,
        &[
            "unit1", "unit2", "unit3", "unit4", "unit6", "unit12", "unitb",
        ],
    );
    let is_only = chance(draws, 0.6);
    Facts::of(&Address::new(format!("{street} {number}"), unit), is_only)
}

/// A picture with plates of a seed, each on its wall: RGBA, opaque.
pub fn contact_sheet(seed: u64, count: usize) -> Texture {
    let plates = sampled_plates(seed, count);
    let rows = count.div_ceil(COLUMNS).max(1);
    let (width, height) = (COLUMNS * CELL[0], rows * CELL[1]);
    let mut rgba = vec![255_u8; 4 * width * height];
    for (i, plate) in plates.iter().enumerate() {
        let (left, top) = (i % COLUMNS * CELL[0], i / COLUMNS * CELL[1]);
        for y in 0..CELL[1] {
            for x in 0..CELL[0] {
                let [r, g, b] = cell_color(plate, x, y);
                let at = 4 * ((top + y) * width + left + x);
                // In steps of 4: the file is half as large, and nobody sees it.
                rgba[at..at + 3].copy_from_slice(&[r, g, b].map(|c| (c & 0xfc) | (c >> 6)));
            }
        }
    }
    Texture {
        width: width as u32,
        height: height as u32,
        rgba: rgba.into(),
    }
}

/// The colour of a pixel of a plate's place: the mean of the texels that it covers.
fn cell_color(plate: &SampledPlate, x: usize, y: usize) -> [u8; 3] {
    let wall = [1.0, 0.95, 0.88].map(|tint| (plate.wall * tint * 255.0) as u8);
    let image = &plate.face.texture;
    let (w, h) = (image.width as f64, image.height as f64);
    let room = [CELL[0] - 2 * GAP, CELL[1] - 2 * GAP].map(|side| side as f64);
    let step = (w / room[0]).max(h / room[1]);
    // From the middle of the place to that of the plate.
    let place =
        |at: usize, cell: usize, size: f64| (at as f64 - cell as f64 / 2.0) * step + size / 2.0;
    let (u, v) = (place(x, CELL[0], w), place(y, CELL[1], h));
    let mut sum = [0_u32; 3];
    let mut count = 0;
    let samples = (step.ceil() as usize).clamp(2, 8);
    for j in 0..samples {
        for i in 0..samples {
            let offset = |k: usize| (k as f64 + 0.5) / samples as f64 * step;
            let (u, v) = (u + offset(i), v + offset(j));
            let inside = u >= 0.0 && v >= 0.0 && u < w && v < h;
            let texel = inside.then(|| {
                let at = 4 * (v as usize * image.width as usize + u as usize);
                [0, 1, 2, 3].map(|c| image.rgba[at + c])
            });
            let color = match texel {
                Some([r, g, b, a]) if a >= 128 => [r, g, b],
                _ => wall,
            };
            (0..3).for_each(|c| sum[c] += u32::from(color[c]));
            count += 1;
        }
    }
    sum.map(|channel| (channel / count) as u8)
}

/// The makes that a sample has.
#[cfg(test)]
fn makes(plates: &[SampledPlate]) -> std::collections::BTreeSet<super::design::Make> {
    plates.iter().map(|plate| plate.design.make).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::design::Make;
    use super::super::typefaces::{Typeface, typefaces};
    use super::*;

    #[test]
    fn every_make_is_drawn_and_letters_are_6_to_25_cm_high() {
        let plates = sampled_plates(10_000, 300);
        assert_eq!(makes(&plates).len(), Make::ALL.len());
        for plate in &plates {
            let height = plate.face.text.height_m;
            assert!((0.06..=0.25).contains(&height), "{height}");
            assert!(
                plate.face.size.width_m < 1.2,
                "{:?} {:?}",
                plate.lines,
                plate.face.size
            );
            let texels = plate.face.texture.width * plate.face.texture.height;
            assert!(texels < 160_000, "{texels} for {:?}", plate.lines);
        }
        let texels = plates.iter().map(|p| p.face.texture.rgba.len());
        let mean = texels.sum::<usize>() / plates.len();
        assert!(mean < 180_000, "{mean} bytes for a plate on average");
    }

    #[test]
    fn tests_have_typefaces_of_their_own() {
        let used = |seed| -> BTreeSet<&'static str> {
            let plates = sampled_plates(seed, 200);
            plates.iter().map(|plate| plate.design.typeface()).collect()
        };
        let (training, test) = (used(10_000), used(11_000));
        assert!(training.is_disjoint(&test));
        let all = typefaces().iter().map(|face: &Typeface| face.name);
        let unused: Vec<&str> = all
            .filter(|n| !training.contains(n) && !test.contains(n))
            .collect();
        // Chinese ones are the second of plates, scripts are for signs.
        assert!(unused.len() <= 6, "{unused:?}");
    }

    #[test]
    fn one_seed_gives_one_sheet() {
        let sheet = contact_sheet(3, 12);
        assert_eq!(sheet, contact_sheet(3, 12));
        assert_ne!(sheet, contact_sheet(4, 12));
    }
}
