//! House numbers, as countries have them: odd and even sides, or around the street, or per estate;
//! with gaps, letters and houses of two numbers here and there.

use openbench_osm::draws::{chance, whole};
use openbench_osm::houses::{GAPS, Inserted, number_street};
use rand_pcg::Pcg64Mcg;

use crate::plan::{Home, HomeKind, Side};
use crate::purpose::{Purpose, Seed};
use crate::style::Style;
use crate::words::Language;

/// Share of the houses with a name of their own.
const NAMED: f64 = 0.04;

/// Numbers all homes.
pub(crate) fn give(
    style: Style,
    language: Language,
    seed: Seed,
    streets: usize,
    homes: &mut [Home],
) {
    let mut of_all = seed.stream(Purpose::Numbers, 0);
    if style == Style::Slabs {
        let blocks = chance(&mut of_all, 0.65);
        estate(language, blocks, &mut of_all, homes);
        return;
    }
    for street in 0..streets {
        let mut draws = seed.stream(Purpose::Numbers, 1 + street as u64);
        along(street, language, &mut draws, homes);
    }
    name_some(language, seed, homes);
}

/// Counts the houses of an estate, by name or as numbers of one street.
fn estate(language: Language, blocks: bool, draws: &mut Pcg64Mcg, homes: &mut [Home]) {
    let mut order: Vec<usize> = (0..homes.len()).collect();
    order.sort_by(|a, b| homes[*a].along.total_cmp(&homes[*b].along));
    let mut number = whole(draws, 1, 9);
    for i in order {
        number += u32::from(chance(draws, GAPS));
        let home = &mut homes[i];
        home.number = number.to_string();
        home.name = blocks.then(|| format!("{} {number}", language.building_word()));
        number += 1;
    }
}

/// Numbers the houses of one street.
fn along(street: usize, language: Language, draws: &mut Pcg64Mcg, homes: &mut [Home]) {
    let of_side = |side: Side, homes: &[Home]| {
        let mut found: Vec<usize> = (0..homes.len())
            .filter(|i| homes[*i].street == street && homes[*i].side == side)
            .collect();
        found.sort_by(|a, b| homes[*a].along.total_cmp(&homes[*b].along));
        found
    };
    let (left, right) = (of_side(Side::Left, homes), of_side(Side::Right, homes));
    let inserted = match language {
        Language::French => Inserted::Bis,
        _ => Inserted::Letter,
    };
    for (home, number) in number_street(&left, &right, inserted, draws) {
        homes[home].number = number;
    }
}

/// Gives names to some houses, each name once.
fn name_some(language: Language, seed: Seed, homes: &mut [Home]) {
    let mut left = language.house_names().to_vec();
    for home in homes {
        let mut draws = seed.stream(Purpose::Numbers, (1 << 40) | home.stream);
        let may = matches!(
            home.kind,
            HomeKind::Detached | HomeKind::Farm | HomeKind::Tower
        );
        let wanted = chance(&mut draws, NAMED);
        let which = whole(&mut draws, 0, 99) as usize;
        if may && wanted && !left.is_empty() {
            let name = left.swap_remove(which % left.len());
            home.name = Some(name.to_owned());
        }
    }
}
