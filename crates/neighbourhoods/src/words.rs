//! Places and names of streets in five languages.

use openbench_core::Georeference;
use openbench_osm::draws::{pick, whole};
use rand_pcg::Pcg64Mcg;

/// Where a neighbourhood pretends to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Language {
    German,
    English,
    French,
    Portuguese,
    Chinese,
}

/// A UTM zone, and a point in it.
struct Place {
    zone: u8,
    easting_km: f64,
    northing_km: f64,
}

impl Language {
    const ALL: [Self; 5] = [
        Self::German,
        Self::English,
        Self::French,
        Self::Portuguese,
        Self::Chinese,
    ];

    pub fn draw(draws: &mut Pcg64Mcg) -> Self {
        pick(draws, &Self::ALL)
    }

    /// All places are near the middle of a UTM zone, where its metres are true.
    fn place(self) -> Place {
        let (zone, easting_km, northing_km) = match self {
            Self::German => (33, 544.0, 5_362.0),
            Self::English => (30, 528.0, 5_700.0),
            Self::French => (31, 506.0, 5_070.0),
            Self::Portuguese => (29, 488.0, 4_285.0),
            Self::Chinese => (50, 517.0, 4_328.0),
        };
        Place {
            zone,
            easting_km,
            northing_km,
        }
    }

    /// A georeference within a few kilometres of the place.
    pub fn georeference(self, draws: &mut Pcg64Mcg) -> Georeference {
        let Place {
            zone,
            easting_km,
            northing_km,
        } = self.place();
        let mut near = || f64::from(whole(draws, 0, 4_000)) - 2_000.0;
        Georeference::Utm {
            zone,
            north: true,
            offset_x: -(easting_km * 1e3 + near()),
            offset_y: -(northing_km * 1e3 + near()),
        }
    }

    /// The word for a house in an estate whose buildings are counted.
    pub fn building_word(self) -> &'static str {
        match self {
            Self::German => "Haus",
            Self::French => "Bloc",
            Self::Portuguese => "Bloco",
            Self::English | Self::Chinese => "Building",
        }
    }

    /// The names of houses that have one.
    pub fn house_names(self) -> &'static [&'static str] {
        match self {
            Self::German => &[
                "Villa Anna",
                "Haus Lindenhof",
                "Altes Pfarrhaus",
                "Mühlenhof",
            ],
            Self::English => &["Rose Cottage", "The Old Bakery", "Oak House", "Mill House"],
            Self::French => &[
                "Villa Marguerite",
                "Le Clos Fleuri",
                "La Roseraie",
                "Les Tilleuls",
            ],
            Self::Portuguese => &[
                "Casa das Flores",
                "Vila Aurora",
                "Quinta do Poço",
                "Casa Nova",
            ],
            Self::Chinese => &["和平楼", "桂花楼", "兰亭楼", "文心楼"],
        }
    }

    /// Names of streets, each another one; as many as there are at most.
    pub fn streets(self, count: usize, draws: &mut Pcg64Mcg) -> Vec<String> {
        let mut stock = self.stock();
        let mut names = Vec::new();
        while names.len() < count && !stock.is_empty() {
            let drawn = whole(draws, 0, stock.len() as u32 - 1);
            names.push(stock.swap_remove(drawn as usize));
        }
        names
    }

    fn stock(self) -> Vec<String> {
        let whole = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        match self {
            Self::German => joined(
                &[
                    "Linden", "Birken", "Garten", "Mühl", "Schul", "Berg", "Wiesen", "Kirch",
                    "Rosen", "Bach", "Feld", "Brunnen", "Ahorn", "Ziegel",
                ],
                "",
                &["straße", "weg", "gasse", "allee"],
            ),
            Self::English => joined(
                &[
                    "Church", "Mill", "Station", "Orchard", "Albert", "Manor", "Park", "Cherry",
                    "Meadow", "Chapel", "Grove", "Victoria", "Elm", "Priory",
                ],
                " ",
                &["Road", "Lane", "Street", "Close", "Avenue"],
            ),
            Self::French => whole(&[
                "Rue des Lilas",
                "Rue de la Gare",
                "Rue du Moulin",
                "Rue des Écoles",
                "Rue Pasteur",
                "Avenue des Tilleuls",
                "Rue du Château",
                "Rue de la Fontaine",
                "Allée des Acacias",
                "Rue Victor Hugo",
                "Impasse du Verger",
                "Rue des Vignes",
                "Chemin des Prés",
                "Rue de l'Église",
                "Rue Jean Jaurès",
                "Rue des Peupliers",
            ]),
            Self::Portuguese => whole(&[
                "Rua das Flores",
                "Rua do Sol",
                "Rua da Escola",
                "Rua de São João",
                "Travessa do Carmo",
                "Avenida da República",
                "Rua da Fonte",
                "Rua dos Moinhos",
                "Rua Nova",
                "Rua da Alegria",
                "Rua do Campo",
                "Rua das Oliveiras",
                "Rua da Boavista",
                "Largo da Igreja",
                "Rua de Camões",
                "Rua do Monte",
            ]),
            Self::Chinese => whole(&[
                "人民路",
                "解放路",
                "建设路",
                "和平路",
                "新华街",
                "中山路",
                "文化路",
                "东风路",
                "幸福里",
                "柳树巷",
                "桃园路",
                "学府路",
                "青年路",
                "胜利街",
                "光明路",
                "花园路",
            ]),
        }
    }
}

/// Each first part with one of the endings: a stem gives one street, so that no two are confused.
fn joined(stems: &[&str], between: &str, endings: &[&str]) -> Vec<String> {
    stems
        .iter()
        .enumerate()
        .map(|(i, stem)| {
            let ending = endings[i % endings.len()];
            format!("{stem}{between}{ending}")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;
    use crate::purpose::{Purpose, Seed};

    #[test]
    fn streets_have_different_names() {
        for language in Language::ALL {
            let mut draws = Seed::new(Kind::Large, 4).stream(Purpose::Place, 0);
            let mut names = language.streets(14, &mut draws);
            assert_eq!(names.len(), 14, "{language:?}");
            names.sort();
            names.dedup();
            assert_eq!(names.len(), 14, "{language:?}");
        }
    }
}
