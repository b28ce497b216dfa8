//! The typefaces of plates and of other text: which there are, which are kept for tests, and how
//! they are read.
//!
//! Sources and licences are in the file `NOTICE`. Every style has a face in each set, so that a
//! test has new faces and no new styles.

use std::sync::OnceLock;

use fontdue::{Font, FontSettings};

/// The first seed whose worlds are lettered with the typefaces that are kept for tests.
pub const FIRST_TEST_SEED: u64 = 11_000;
/// The last such seed.
pub const LAST_TEST_SEED: u64 = 11_999;

/// What a typeface looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Style {
    /// Without serifs, of usual width: grotesques, geometric ones, those of road signs.
    Plain,
    /// Without serifs, narrow.
    Condensed,
    /// With round ends.
    Rounded,
    /// With serifs.
    Serif,
    /// With heavy serifs.
    Slab,
    /// Capitals as in stone.
    Engraved,
    /// With bridges, for stencils.
    Stencil,
    /// As of a typewriter.
    Typewriter,
    /// Written by hand.
    Hand,
    /// Of sign writers and markers: for names and words. Readers mistake their figures, so no plate
    /// with a number is lettered with them.
    Script,
    /// Of the 1920s.
    Deco,
    /// With Chinese characters.
    Chinese,
}

/// Worlds in which a typeface is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TypefaceSet {
    /// Those for training and tuning, and for validation.
    Training,
    /// Those for tests.
    Test,
}

impl TypefaceSet {
    /// The set of the worlds of a seed.
    ///
    /// ```
    /// use openbench_scene::plates::TypefaceSet;
    ///
    /// assert_eq!(TypefaceSet::of_seed(7), TypefaceSet::Training);
    /// assert_eq!(TypefaceSet::of_seed(10_500), TypefaceSet::Training);
    /// assert_eq!(TypefaceSet::of_seed(11_003), TypefaceSet::Test);
    /// ```
    pub fn of_seed(seed: u64) -> Self {
        if (FIRST_TEST_SEED..=LAST_TEST_SEED).contains(&seed) {
            Self::Test
        } else {
            Self::Training
        }
    }
}

/// A typeface of the crate.
#[derive(Debug)]
pub struct Typeface {
    /// Name of its file.
    pub name: &'static str,
    /// What it looks like.
    pub style: Style,
    /// Where it is used.
    pub set: TypefaceSet,
    bytes: &'static [u8],
    font: OnceLock<Font>,
}

impl Typeface {
    /// Its outlines.
    pub fn font(&self) -> &Font {
        self.font
            .get_or_init(|| read_font(self.bytes).expect("the embedded fonts are sound"))
    }

    /// Whether it has all characters of a text.
    pub fn has(&self, text: &str) -> bool {
        let font = self.font();
        text.chars().all(|c| c == ' ' || font.has_glyph(c))
    }
}

/// Bytes that are no font.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("this is no font that can be drawn ({problem}); give a TrueType or OpenType file")]
pub struct TypefaceError {
    /// What the reader says.
    pub problem: String,
}

/// Reads a TrueType or OpenType font.
///
/// # Errors
/// [`TypefaceError`] for bytes that are no font, or for one without glyphs.
pub fn read_font(bytes: &[u8]) -> Result<Font, TypefaceError> {
    let settings = FontSettings {
        load_substitutions: false,
        ..FontSettings::default()
    };
    let problem = |problem: &str| TypefaceError {
        problem: problem.to_owned(),
    };
    // Its reader may not expect everything that a broken file can say.
    let read = std::panic::catch_unwind(|| Font::from_bytes(bytes, settings));
    let font = read
        .map_err(|_| problem("broken tables"))?
        .map_err(problem)?;
    // The outlines of a file that was cut off are missing.
    if font.lookup_glyph_index('0') == 0 || font.metrics('0', 100.0).width == 0 {
        return Err(problem("it has no digits"));
    }
    Ok(font)
}

macro_rules! face {
    ($name:literal, $style:ident, $set:ident) => {
        Typeface {
            name: $name,
            style: Style::$style,
            set: TypefaceSet::$set,
            bytes: include_bytes!(concat!("../../assets/fonts/", $name, ".ttf")),
            font: OnceLock::new(),
        }
    };
}

static FACES: [Typeface; 44] = [
    face!("grotesque-1", Plain, Training),
    face!("grotesque-2", Plain, Training),
    face!("grotesque-3", Plain, Training),
    face!("grotesque-4", Plain, Test),
    face!("grotesque-5", Plain, Test),
    face!("highway-1", Plain, Training),
    face!("din-1", Plain, Training),
    face!("din-2", Plain, Test),
    face!("din-3", Plain, Training),
    face!("geometric-1", Plain, Training),
    face!("geometric-2", Plain, Test),
    face!("geometric-3", Plain, Training),
    face!("condensed-1", Condensed, Training),
    face!("condensed-2", Condensed, Training),
    face!("condensed-3", Condensed, Test),
    face!("condensed-4", Condensed, Training),
    face!("rounded-1", Rounded, Training),
    face!("rounded-2", Rounded, Training),
    face!("rounded-3", Rounded, Test),
    face!("serif-1", Serif, Training),
    face!("serif-2", Serif, Training),
    face!("serif-3", Serif, Test),
    face!("serif-4", Serif, Training),
    face!("serif-5", Serif, Test),
    face!("slab-1", Slab, Training),
    face!("slab-2", Slab, Training),
    face!("slab-3", Slab, Test),
    face!("engraved-1", Engraved, Training),
    face!("engraved-2", Engraved, Test),
    face!("engraved-3", Engraved, Training),
    face!("stencil-1", Stencil, Training),
    face!("stencil-2", Stencil, Test),
    face!("typewriter-1", Typewriter, Training),
    face!("typewriter-2", Typewriter, Test),
    face!("hand-1", Script, Training),
    face!("hand-2", Hand, Test),
    face!("hand-3", Hand, Training),
    face!("marker-1", Script, Training),
    face!("script-1", Script, Training),
    face!("script-2", Script, Test),
    face!("deco-1", Deco, Training),
    face!("deco-2", Deco, Test),
    face!("cjk-1", Chinese, Training),
    face!("cjk-2", Chinese, Test),
];

/// All typefaces.
pub fn typefaces() -> &'static [Typeface] {
    &FACES
}

/// The numbers of the typefaces of a set and of some styles.
pub(super) fn of(set: TypefaceSet, styles: &[Style]) -> Vec<usize> {
    (0..FACES.len())
        .filter(|i| FACES[*i].set == set && styles.contains(&FACES[*i].style))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_style_has_a_typeface_in_each_set() {
        for face in typefaces() {
            for set in [TypefaceSet::Training, TypefaceSet::Test] {
                assert!(!of(set, &[face.style]).is_empty(), "{}", face.name);
            }
        }
    }

    #[test]
    fn every_typeface_has_digits_and_capitals_that_differ() {
        for face in typefaces() {
            assert!(face.has("0123456789 ABC XYZ abc xyz -./"), "{}", face.name);
            let drawn = |c| face.font().rasterize(c, 40.0).1;
            assert_ne!(drawn('1'), drawn('2'), "{}", face.name);
            assert_eq!(face.style == Style::Chinese, face.has("号楼单元"));
        }
    }

    #[test]
    fn a_file_that_is_no_font_is_refused() {
        let whole = FACES[0].bytes;
        for bytes in [&b""[..], b"no font", &whole[..40], &whole[..2000]] {
            let error = read_font(bytes).unwrap_err();
            assert!(error.to_string().contains("no font"), "{error}");
        }
        assert!(read_font(whole).is_ok());
    }

    #[test]
    fn all_files_together_are_small() {
        let bytes: usize = FACES.iter().map(|face| face.bytes.len()).sum();
        assert!(bytes < 4 << 20, "{bytes}");
    }
}
