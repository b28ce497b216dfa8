//! Homes along streets: which kind, how large, and where each stands.

use openbench_core::Pose2;
use openbench_osm::draws::{between, chance, pick, whole};
use rand_pcg::Pcg64Mcg;

use crate::ground::Ground;
use crate::outline::{Footprint, Shape};
use crate::plan::{Home, HomeKind, Lot, Side, Street};
use crate::purpose::{Purpose, Seed};
use crate::style::Style;

/// No home begins nearer to the end of a street, metres.
const FROM_END_M: f64 = 5.0;
/// Where nothing fits, the next try is so much further along the street, metres.
const STEP_M: f64 = 2.5;
/// Least distance between homes that do not touch, metres.
const GAP_M: f64 = 3.2;
/// Houses that touch are checked so much smaller, metres.
const SEAM_M: f64 = 0.01;
/// Sizes that are tried in one place, as shares of the drawn one.
const TRIES: [f64; 3] = [1.0, 0.85, 0.72];

/// What is drawn for one place at a street, before it is known whether it fits.
#[derive(Debug, Clone, Copy)]
struct Draft {
    kind: HomeKind,
    /// Houses in the row; 1 for a house that stands alone.
    count: usize,
    /// Of one house.
    place: Footprint,
    shape: Shape,
    levels: u32,
    roof: Option<&'static str>,
    /// Free ground before and after it along the street, metres.
    before: f64,
    after: f64,
    /// Depth of the garden behind it, metres.
    garden: f64,
    doors: usize,
}

/// What the houses on one side of a street have in common.
#[derive(Debug, Clone, Copy)]
struct Habit {
    /// Metres from the pavement.
    setback: f64,
    levels: u32,
    roof: Option<&'static str>,
}

/// Places homes along all streets, those of the first street first.
pub(crate) fn place(
    style: Style,
    seed: Seed,
    streets: &[Street],
    ground: &mut Ground,
) -> Vec<Home> {
    let mut homes = Vec::new();
    for (index, street) in streets.iter().enumerate() {
        for side in [Side::Left, Side::Right] {
            let row = Row {
                style,
                seed,
                street,
                index,
                side,
            };
            row.place(ground, &mut homes);
        }
    }
    homes
}

/// One side of a street.
struct Row<'a> {
    style: Style,
    seed: Seed,
    street: &'a Street,
    index: usize,
    side: Side,
}

impl Row<'_> {
    fn place(&self, ground: &mut Ground, homes: &mut Vec<Home>) {
        let end = self.street.length() - FROM_END_M;
        let side = 2 * self.index as u64 + self.side as u64;
        let mut of_side = self.seed.stream(Purpose::Streets, side);
        let habit = habit(self.style, &mut of_side);
        let mut along = FROM_END_M + between(&mut of_side, 0.0, 3.0);
        // Of a closed row the next house may touch the last one.
        let mut last: Option<usize> = None;
        let mut number = 0;
        while along < end && number < 200 {
            number += 1;
            let stream = (side << 16) | number;
            let mut draws = self.seed.stream(Purpose::Lot, stream);
            let draft = draft(self.style, habit, &mut draws);
            match self.fit(draft, along, last, ground) {
                Some((draft, middle, taken)) => {
                    self.build(draft, middle, stream, &mut draws, homes);
                    along = middle + draft.extent() / 2.0 + draft.after;
                    let closed = draft.kind == HomeKind::Perimeter && draft.after < 0.1;
                    last = closed.then_some(taken);
                }
                None => {
                    along += STEP_M;
                    last = None;
                }
            }
        }
    }

    /// The largest of the tried sizes that fits, the middle of its place along the street, and its
    /// number on the ground.
    fn fit(
        &self,
        draft: Draft,
        along: f64,
        last: Option<usize>,
        ground: &mut Ground,
    ) -> Option<(Draft, f64, usize)> {
        for scale in TRIES {
            let draft = draft.scaled(scale);
            // A house of a closed row begins where the last one ends.
            let before = if last.is_some() { 0.0 } else { draft.before };
            let middle = along + before + draft.extent() / 2.0;
            let pose = self.pose(middle);
            let whole = Footprint {
                width: draft.extent(),
                ..draft.place
            };
            let touching = last.unwrap_or(usize::MAX);
            let checked = whole.shrunk(SEAM_M).outer(Shape::Rectangle, pose);
            if ground.fits(&checked, GAP_M, touching) {
                let taken = ground.add(&whole.outer(draft.shape_of_all(), pose));
                return Some((draft, middle, taken));
            }
        }
        None
    }

    /// At the edge of the pavement: x along it, y away from the street.
    fn pose(&self, along: f64) -> Pose2 {
        let at = self.street.pose_at(along);
        let (turn, edge) = match self.side {
            Side::Left => (0.0, self.street.edge()),
            Side::Right => (std::f64::consts::PI, -self.street.edge()),
        };
        let point = at.transform(0.0, edge);
        Pose2::new(point.x, point.y, at.yaw + turn)
    }

    fn build(
        &self,
        draft: Draft,
        middle: f64,
        stream: u64,
        draws: &mut Pcg64Mcg,
        homes: &mut Vec<Home>,
    ) {
        let pose = self.pose(middle);
        let width = draft.place.width;
        for i in 0..draft.count {
            let aside = (i as f64 + 0.5 - draft.count as f64 / 2.0) * width;
            let at = pose.transform(aside, 0.0);
            let own = Pose2::new(at.x, at.y, pose.yaw);
            // On the right x runs against the street.
            let along = match self.side {
                Side::Left => middle + aside,
                Side::Right => middle - aside,
            };
            let lot = Lot {
                width: if draft.count == 1 {
                    width + 2.0 * draft.before.min(draft.after).max(1.7)
                } else {
                    width
                },
                depth: draft.place.setback + draft.place.depth + draft.garden,
            };
            let has_lot = draft.kind != HomeKind::Perimeter;
            homes.push(Home {
                kind: draft.kind,
                outer: draft.place.outer(draft.shape, own),
                court: draft.place.court(draft.shape, own),
                pose: own,
                street: self.index,
                side: self.side,
                along,
                lot: has_lot.then_some(lot),
                levels: draft.levels,
                roof: draft.roof,
                stream: (stream << 8) | i as u64,
                number: String::new(),
                name: None,
                wanted_doors: if draft.count == 1 {
                    draft.doors
                } else {
                    1 + usize::from(chance(draws, 0.18))
                },
                doors: Vec::new(),
            });
        }
    }
}

impl Draft {
    /// Length of the whole row along the street, metres.
    fn extent(self) -> f64 {
        self.place.width * self.count as f64
    }

    fn shape_of_all(self) -> Shape {
        if self.count == 1 {
            self.shape
        } else {
            Shape::Rectangle
        }
    }

    /// A smaller draft: rows lose houses, single houses become narrower.
    fn scaled(self, scale: f64) -> Self {
        let mut smaller = self;
        if self.count > 1 {
            smaller.count = ((self.count as f64 * scale) as usize).max(2);
        } else {
            smaller.place.width = (self.place.width * scale).max(7.0);
        }
        smaller
    }
}

fn habit(style: Style, draws: &mut Pcg64Mcg) -> Habit {
    let setback = match style {
        Style::Suburb => between(draws, 3.5, 6.5),
        Style::Blocks => pick(draws, &[0.25, 0.25, 0.25, 2.5]),
        Style::Terraces => between(draws, 2.0, 5.0),
        Style::Slabs | Style::Village => between(draws, 1.0, 5.0),
    };
    let levels = match style {
        Style::Suburb | Style::Terraces | Style::Village => 2,
        Style::Blocks => whole(draws, 3, 5),
        Style::Slabs => 4,
    };
    Habit {
        setback,
        levels,
        roof: pick(
            draws,
            &[Some("gabled"), Some("gabled"), Some("hipped"), None],
        ),
    }
}

fn draft(style: Style, habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    let share = between(draws, 0.0, 1.0);
    match style {
        Style::Suburb if share < 0.62 => detached(habit, draws),
        Style::Suburb if share < 0.86 => row(HomeKind::Semi, 2, habit, draws),
        Style::Suburb => flats(habit, draws),
        Style::Blocks if share < 0.94 => perimeter(habit, draws),
        Style::Blocks => around_a_court(habit, draws),
        Style::Terraces if share < 0.66 => {
            let count = whole(draws, 3, 8) as usize;
            row(HomeKind::Terraced, count, habit, draws)
        }
        Style::Terraces if share < 0.86 => undivided_row(habit, draws),
        Style::Terraces => row(HomeKind::Semi, 2, habit, draws),
        Style::Slabs => flats(habit, draws),
        Style::Village if share < 0.45 => {
            let apart = between(draws, -2.5, 9.0);
            let own = Habit {
                setback: (habit.setback + apart).max(0.5),
                ..habit
            };
            detached(own, draws)
        }
        Style::Village if share < 0.75 => farm(habit, draws),
        Style::Village if share < 0.9 => row(HomeKind::Semi, 2, habit, draws),
        Style::Village => flats(habit, draws),
    }
}

fn detached(habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    let (width, depth) = (between(draws, 8.5, 14.5), between(draws, 8.0, 12.0));
    // Some have room for a garage on both sides or on one.
    let beside = |draws: &mut Pcg64Mcg| {
        if chance(draws, 0.35) {
            between(draws, 4.4, 6.0)
        } else {
            between(draws, 1.8, 4.0)
        }
    };
    Draft {
        kind: HomeKind::Detached,
        count: 1,
        place: Footprint {
            width,
            depth,
            setback: (habit.setback + between(draws, -1.0, 1.8)).max(0.5),
            aside: 0.0,
        },
        shape: simple_shape(draws),
        levels: pick(draws, &[1, 2, 2, habit.levels]),
        roof: pick(
            draws,
            &[habit.roof, Some("gabled"), Some("hipped"), Some("flat")],
        ),
        before: beside(draws),
        after: beside(draws),
        garden: between(draws, 7.0, 14.0),
        doors: pick(draws, &[1, 1, 1, 2, 2, 3]),
    }
}

fn simple_shape(draws: &mut Pcg64Mcg) -> Shape {
    let share = between(draws, 0.0, 1.0);
    let right = chance(draws, 0.5);
    if share < 0.52 {
        Shape::Rectangle
    } else if share < 0.8 {
        Shape::Ell {
            main: between(draws, 0.5, 0.7),
            wing: between(draws, 0.4, 0.6),
            right,
        }
    } else {
        Shape::Notched {
            from: between(draws, 0.4, 0.7),
            depth: between(draws, 1.0, 2.5),
            right,
        }
    }
}

/// Houses that share their side walls, each with a number of its own.
fn row(kind: HomeKind, count: usize, habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    let width = match kind {
        HomeKind::Semi => between(draws, 7.0, 9.5),
        _ => between(draws, 5.2, 7.2),
    };
    Draft {
        kind,
        count,
        place: Footprint {
            width,
            depth: between(draws, 8.5, 11.5),
            setback: habit.setback,
            aside: 0.0,
        },
        shape: Shape::Rectangle,
        levels: habit.levels + u32::from(chance(draws, 0.25)),
        roof: habit.roof,
        before: between(draws, 2.0, 3.5),
        after: between(draws, 2.0, 3.5),
        garden: between(draws, 6.0, 11.0),
        doors: 1,
    }
}

/// A row that the map draws as one building.
fn undivided_row(habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    let count = whole(draws, 3, 7);
    let unit = between(draws, 5.4, 7.0);
    Draft {
        kind: HomeKind::Row,
        place: Footprint {
            width: unit * f64::from(count),
            depth: between(draws, 8.5, 11.0),
            setback: habit.setback,
            aside: 0.0,
        },
        count: 1,
        doors: count as usize,
        shape: Shape::Rectangle,
        ..row(HomeKind::Terraced, 2, habit, draws)
    }
}

/// A house of flats that stands alone.
fn flats(habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    let (width, depth) = (between(draws, 14.0, 24.0), between(draws, 11.0, 15.0));
    Draft {
        place: Footprint {
            width,
            depth,
            setback: habit.setback + between(draws, 0.0, 3.0),
            aside: 0.0,
        },
        kind: HomeKind::Tower,
        levels: whole(draws, 3, 4),
        roof: pick(draws, &[Some("flat"), Some("hipped"), None]),
        garden: between(draws, 5.0, 9.0),
        doors: whole(draws, 2, 5) as usize,
        ..detached(habit, draws)
    }
}

/// A large house around a court of its own.
fn around_a_court(habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    Draft {
        place: Footprint {
            width: between(draws, 26.0, 34.0),
            depth: between(draws, 25.0, 31.0),
            setback: habit.setback,
            aside: 0.0,
        },
        shape: Shape::Ring {
            depth: between(draws, 8.0, 9.5),
        },
        levels: habit.levels,
        doors: whole(draws, 3, 9) as usize,
        ..flats(habit, draws)
    }
}

/// A house of a closed row around a block.
fn perimeter(habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    let width = between(draws, 11.0, 24.0);
    let depth = between(draws, 11.0, 14.5);
    let right = chance(draws, 0.5);
    let (depth, shape) = match between(draws, 0.0, 1.0) {
        share if share < 0.55 => (depth, Shape::Rectangle),
        share if share < 0.85 => (
            depth + 7.0,
            Shape::Ell {
                main: depth / (depth + 7.0),
                wing: between(draws, 0.35, 0.5),
                right,
            },
        ),
        _ if width > 20.0 => (
            depth + 9.0,
            Shape::Horseshoe {
                wing: 6.5,
                main: depth,
            },
        ),
        _ => (depth, Shape::Rectangle),
    };
    let passage = chance(draws, 0.3);
    Draft {
        kind: HomeKind::Perimeter,
        count: 1,
        place: Footprint {
            width,
            depth,
            setback: habit.setback,
            aside: 0.0,
        },
        shape,
        levels: (habit.levels + whole(draws, 0, 2)).saturating_sub(1).max(2),
        roof: habit.roof,
        before: 0.0,
        after: if passage {
            between(draws, 3.4, 5.0)
        } else {
            0.0
        },
        garden: 0.0,
        doors: (width / between(draws, 5.0, 10.0)).round().clamp(1.0, 6.0) as usize,
    }
}

/// A farmhouse with a barn or two around its yard.
fn farm(habit: Habit, draws: &mut Pcg64Mcg) -> Draft {
    let width = between(draws, 16.0, 24.0);
    let right = chance(draws, 0.5);
    let shape = if chance(draws, 0.6) {
        Shape::Ell {
            main: between(draws, 0.38, 0.5),
            wing: between(draws, 0.35, 0.5),
            right,
        }
    } else {
        Shape::Horseshoe {
            wing: between(draws, 5.0, 6.5),
            main: between(draws, 7.5, 9.0),
        }
    };
    Draft {
        kind: HomeKind::Farm,
        place: Footprint {
            width,
            depth: between(draws, 16.0, 22.0),
            setback: (habit.setback + between(draws, -2.5, 4.0)).max(0.5),
            aside: 0.0,
        },
        shape,
        levels: pick(draws, &[1, 2, 2]),
        roof: None,
        before: between(draws, 2.0, 6.0),
        after: between(draws, 2.0, 6.0),
        doors: whole(draws, 1, 4) as usize,
        ..detached(habit, draws)
    }
}
