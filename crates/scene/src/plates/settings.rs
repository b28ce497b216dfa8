//! Which shares of plates are drawn, and what was drawn in a world.

use std::collections::BTreeMap;

use openbench_osm::draws::{between, chance, normal};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::design::Wear;

/// Plates that hang farther off the level are counted as tilted, degrees.
const TILTED_DEG: f64 = 3.0;

/// What the plates of a world are like: shares of its doors, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StreetPlates {
    /// Whether plates are those of real streets. If not, all are of one kind, 1.0 x 0.45 m, and
    /// nothing else is drawn.
    pub real: bool,
    /// Doors without a plate.
    pub missing: f64,
    /// Doors whose plate is half hidden.
    pub hidden: f64,
    /// Doors with a second plate: an older number, a name, bells.
    pub second: f64,
    /// Plates that are hard to read for dirt.
    pub dirty: f64,
    /// Plates with the sun's reflection on their text.
    pub glare: f64,
    /// Standard deviation of the angle by which plates hang off the level, degrees.
    pub tilt_deg: f64,
    /// Amount of other text on walls, poles and cars, 0 to 1.
    pub signs: f64,
}

impl StreetPlates {
    /// Plates as in the published worlds.
    pub const PAPER: Self = Self {
        real: false,
        missing: 0.0,
        hidden: 0.0,
        second: 0.0,
        dirty: 0.0,
        glare: 0.0,
        tilt_deg: 0.0,
        signs: 0.0,
    };
    /// Plates as in streets.
    pub const REAL: Self = Self {
        real: true,
        missing: 0.05,
        hidden: 0.10,
        second: 0.25,
        dirty: 0.10,
        glare: 0.05,
        tilt_deg: 1.5,
        signs: 0.5,
    };

    /// What time, light and the fitter did to a plate.
    pub(crate) fn state(&self, draws: &mut Pcg64Mcg) -> State {
        // In this order whatever the shares are, so that one changes nothing about the others.
        let is_missing = chance(draws, self.missing);
        let is_hidden = chance(draws, self.hidden);
        let has_second = chance(draws, self.second);
        let is_dirty = chance(draws, self.dirty);
        let has_glare = chance(draws, self.glare);
        // In steps, so that plates that are alike share an image.
        let step = |value: f64| (value * 8.0).round() / 8.0;
        let much = step(between(draws, 0.5, 1.0));
        let little = step(between(draws, 0.0, 0.25));
        let middle = step(between(draws, 0.25, 0.75));
        State {
            is_missing,
            is_hidden: is_hidden && !is_missing,
            has_second: has_second && !is_missing,
            wear: Wear {
                dirt: if is_dirty { much } else { little },
                glare: has_glare.then_some(middle),
            },
            tilt_deg: (self.tilt_deg * normal(draws)).clamp(-12.0, 12.0),
        }
    }
}

impl Default for StreetPlates {
    fn default() -> Self {
        Self::PAPER
    }
}

/// What time, light and the fitter did to the plate of a door.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct State {
    pub is_missing: bool,
    pub is_hidden: bool,
    pub has_second: bool,
    pub wear: Wear,
    pub tilt_deg: f64,
}

impl State {
    pub fn is_tilted(&self) -> bool {
        self.tilt_deg.abs() > TILTED_DEG
    }
}

/// The plates of a world, counted.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct DrawnPlates {
    /// Doors.
    pub doors: usize,
    /// Doors without a plate.
    pub missing: usize,
    /// Doors whose plate is half hidden.
    pub hidden: usize,
    /// Doors with a second plate.
    pub second: usize,
    /// Plates that are hard to read for dirt.
    pub dirty: usize,
    /// Plates with glare on their text.
    pub glare: usize,
    /// Plates that hang more than 3 degrees off the level.
    pub tilted: usize,
    /// Plates with the house number alone.
    pub number_only: usize,
    /// Plates with the unit alone.
    pub unit_only: usize,
    /// Plates with both.
    pub both: usize,
    /// Plates by what they are made of.
    pub makes: BTreeMap<String, usize>,
    /// Other texts in the world.
    pub signs: usize,
    /// Whether they are lettered with the typefaces that are kept for tests.
    pub test_typefaces: bool,
}

impl DrawnPlates {
    /// In words, for reports.
    pub fn describe(&self) -> String {
        format!(
            "plates of {} doors: {} missing, {} half hidden, {} with a second plate, {} dirty, {} \
             with glare; {} other texts",
            self.doors, self.missing, self.hidden, self.second, self.dirty, self.glare, self.signs
        )
    }
}

#[cfg(test)]
mod tests {
    use openbench_osm::draws::stream;

    use super::*;

    #[test]
    fn shares_are_those_that_are_asked_for() {
        let states: Vec<State> = (0..4000)
            .map(|i| StreetPlates::REAL.state(&mut stream(10_000, 1, i)))
            .collect();
        let share = |is: &dyn Fn(&State) -> bool| {
            states.iter().filter(|s| is(s)).count() as f64 / states.len() as f64
        };
        assert!((share(&|s| s.is_missing) - 0.05).abs() < 0.015);
        assert!((share(&|s| s.is_hidden) - 0.095).abs() < 0.02);
        assert!((share(&|s| s.wear.dirt > 0.4) - 0.10).abs() < 0.02);
        assert!((share(&|s| s.wear.glare.is_some()) - 0.05).abs() < 0.015);
    }

    #[test]
    fn one_share_changes_nothing_about_the_others() {
        let other = StreetPlates {
            missing: 0.0,
            glare: 1.0,
            ..StreetPlates::REAL
        };
        for i in 0..200 {
            let [a, b] = [StreetPlates::REAL, other].map(|p| p.state(&mut stream(3, 1, i)));
            assert_eq!((a.tilt_deg, a.wear.dirt), (b.tilt_deg, b.wear.dirt));
        }
    }
}
