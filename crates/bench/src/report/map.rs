//! The map of an episode as SVG, north up: the world, paths, doors and declared deliveries.

use std::fmt::Write;

use openbench_core::MapPoint;

use super::html::escape;
use super::input::{Declaration, DoorMark, EpisodeReport, MapArea, WorldMap};

const WIDTH_PX: f64 = 960.0;
const MAX_HEIGHT_PX: f64 = 720.0;
const MIN_HEIGHT_PX: f64 = 320.0;
/// Margin around the extent of the episode.
const MARGIN_M: f64 = 8.0;
/// Minimum distance between two drawn points of a path.
const MIN_SPACING_PX: f64 = 0.7;

/// Writes the map of an episode; nothing if world and episode are empty.
pub fn render(out: &mut String, world: &WorldMap, episode: &EpisodeReport) {
    let Some(view) = View::around(world, episode) else {
        return;
    };
    let _ = write!(
        out,
        "<div class=\"map\">\n<svg viewBox=\"0 0 {WIDTH_PX:.0} {h:.0}\" role=\"img\" \
         aria-label=\"Map of episode {e}: buildings, roads, driven path and doors\">\n\
         <rect class=\"ground\" width=\"{WIDTH_PX:.0}\" height=\"{h:.0}\"/>\n",
        h = view.height,
        e = episode.episode,
    );
    // In the order of painting: names cover paths, and marks cover both.
    draw_world(out, &view, world);
    draw_paths(out, &view, episode);
    draw_names(out, &view, world);
    draw_marks(out, &view, episode);
    scale_bar(out, &view);
    north_arrow(out);
    out.push_str("</svg>\n</div>\n");
}

/// The visible part of the world and its scale.
pub(super) struct View {
    /// Map x of the left edge, metres.
    left: f64,
    /// Map y of the top edge, metres.
    top: f64,
    pixels_per_metre: f64,
    /// Width of the picture, pixels.
    width: f64,
    /// Height of the picture, pixels.
    height: f64,
}

impl View {
    /// A square picture of so many pixels a side, which shows so many metres to each side of a
    /// point.
    pub(super) fn square(middle: MapPoint, metres: f64, pixels: f64) -> Self {
        Self {
            left: middle.x - metres,
            top: middle.y + metres,
            pixels_per_metre: pixels / (2.0 * metres),
            width: pixels,
            height: pixels,
        }
    }

    /// The extent of the episode with a margin, or of the whole world if the robot never moved.
    fn around(world: &WorldMap, episode: &EpisodeReport) -> Option<Self> {
        let start = (!episode.driven.is_empty()).then(|| episode.start.point());
        let wanted = episode
            .true_doors
            .iter()
            .filter(|d| d.wanted)
            .map(|d| d.position);
        let declared = episode.declared.iter().map(|d| d.position);
        let done: Vec<MapPoint> = episode
            .driven
            .iter()
            .copied()
            .chain(start)
            .chain(wanted)
            .chain(declared)
            .collect();
        let outlines = world
            .buildings
            .iter()
            .flat_map(|b| b.outline.iter().copied());
        let Bounds { min, max } = bounds(done).or_else(|| bounds(outlines))?;
        let (width, height) = (
            max.x - min.x + 2.0 * MARGIN_M,
            max.y - min.y + 2.0 * MARGIN_M,
        );
        // The tighter of width and height decides, so the whole extent is visible. It is centred
        // below: the other direction shows more of the world around it.
        let scale = (WIDTH_PX / width).min(MAX_HEIGHT_PX / height);
        let pixels = (height * scale).max(MIN_HEIGHT_PX);
        Some(Self {
            left: (min.x + max.x) / 2.0 - WIDTH_PX / 2.0 / scale,
            top: (min.y + max.y) / 2.0 + pixels / 2.0 / scale,
            pixels_per_metre: scale,
            width: WIDTH_PX,
            height: pixels,
        })
    }

    pub(super) fn pixel(&self, point: MapPoint) -> [f64; 2] {
        // The y axis of SVG points down, that of the map to the north.
        [
            (point.x - self.left) * self.pixels_per_metre,
            (self.top - point.y) * self.pixels_per_metre,
        ]
    }

    /// Whether the bounding box of `points` overlaps the view.
    fn shows(&self, points: &[MapPoint]) -> bool {
        bounds(points.iter().copied()).is_some_and(|Bounds { min, max }| {
            // The lower corner of the map has the larger y in pixels.
            let ([left, bottom], [right, top]) = (self.pixel(min), self.pixel(max));
            right >= 0.0 && left <= self.width && bottom >= 0.0 && top <= self.height
        })
    }

    /// The commands of an SVG path through `points` without points too close to be distinguished;
    /// empty for fewer than two points.
    fn line(&self, points: &[MapPoint]) -> String {
        let mut commands = String::new();
        let mut last = [f64::INFINITY; 2];
        // Estimated paths of a lost agent may contain NaN, which SVG does not know.
        let finite = points.iter().filter(|p| p.x.is_finite() && p.y.is_finite());
        let pixels: Vec<[f64; 2]> = finite.map(|p| self.pixel(*p)).collect();
        for (i, [x, y]) in pixels.iter().copied().enumerate() {
            let moved = libm::hypot(x - last[0], y - last[1]) >= MIN_SPACING_PX;
            // The last point is always drawn: it is where the robot is in the end.
            if i == 0 || moved || i + 1 == pixels.len() {
                let _ = write!(commands, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
                last = [x, y];
            }
        }
        if pixels.len() < 2 {
            String::new()
        } else {
            commands
        }
    }

    fn area(&self, area: &MapArea) -> String {
        let rings = std::iter::once(&area.outline)
            .chain(&area.holes)
            .map(|ring| self.line(ring));
        rings
            .filter(|ring| !ring.is_empty())
            .map(|ring| ring + "Z")
            .collect()
    }
}

/// An axis-parallel bounding box.
struct Bounds {
    min: MapPoint,
    max: MapPoint,
}

/// The bounding box of the finite points; `None` without any.
fn bounds(points: impl IntoIterator<Item = MapPoint>) -> Option<Bounds> {
    let mut finite = points
        .into_iter()
        .filter(|p| p.x.is_finite() && p.y.is_finite());
    let first = finite.next()?;
    let around_first = Bounds {
        min: first,
        max: first,
    };
    Some(finite.fold(around_first, |Bounds { min, max }, p| Bounds {
        min: MapPoint::new(min.x.min(p.x), min.y.min(p.y)),
        max: MapPoint::new(max.x.max(p.x), max.y.max(p.y)),
    }))
}

fn path(out: &mut String, class: &str, commands: &str) {
    if !commands.is_empty() {
        let _ = writeln!(out, "<path class=\"{class}\" d=\"{commands}\"/>");
    }
}

pub(super) fn draw_world(out: &mut String, view: &View, world: &WorldMap) {
    // In the order of painting: SVG draws later elements over earlier ones.
    for area in world.areas.iter().filter(|a| view.shows(&a.outline)) {
        path(out, "area", &view.area(area));
    }
    let roads: Vec<String> = world
        .roads
        .iter()
        .filter(|r| view.shows(r))
        .map(|r| view.line(r))
        .collect();
    // The input has centre lines only, so all roads get the same width.
    let width = (3.5 * view.pixels_per_metre).clamp(3.0, 26.0);
    // All edges before all surfaces. Otherwise an edge would cross the other road at a junction.
    for (class, width) in [("road-edge", width + 2.0), ("road", width)] {
        let _ = writeln!(out, "<g stroke-width=\"{width:.1}\">");
        roads.iter().for_each(|r| path(out, class, r));
        out.push_str("</g>\n");
    }
    for building in world.buildings.iter().filter(|b| view.shows(&b.outline)) {
        path(out, "building", &view.area(building));
    }
    for barrier in world.barriers.iter().filter(|b| view.shows(b)) {
        path(out, "barrier", &view.line(barrier));
    }
}

/// A name is centred in the visible part of the bounding box of its building.
fn draw_names(out: &mut String, view: &View, world: &WorldMap) {
    for building in world.buildings.iter().filter(|b| view.shows(&b.outline)) {
        let (Some(name), Some(Bounds { min, max })) =
            (&building.name, bounds(building.outline.iter().copied()))
        else {
            continue;
        };
        let ([left, bottom], [right, top]) = (view.pixel(min), view.pixel(max));
        let (x0, x1) = (left.max(0.0), right.min(view.width));
        let (y0, y1) = (top.max(0.0), bottom.min(view.height));
        // A name that does not fit would cover the neighbours of its building.
        if x1 - x0 > text_width(name) && y1 - y0 > 14.0 {
            let _ = writeln!(
                out,
                "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                (x0 + x1) / 2.0,
                (y0 + y1) / 2.0 + 4.0,
                escape(name)
            );
        }
    }
}

fn draw_paths(out: &mut String, view: &View, episode: &EpisodeReport) {
    episode
        .routes
        .iter()
        .for_each(|route| path(out, "route", &view.line(route)));
    path(out, "driven", &view.line(&episode.driven));
    path(out, "estimated", &view.line(&episode.estimated));
}

fn draw_marks(out: &mut String, view: &View, episode: &EpisodeReport) {
    for point in &episode.collisions {
        mark(out, view, *point, "collision", COLLISION, "collision");
    }
    for door in episode
        .true_doors
        .iter()
        .filter(|d| view.shows(&[d.position]))
    {
        let (class, shape) = if door.wanted {
            ("door wanted", WANTED)
        } else {
            ("door", DOOR)
        };
        mark(
            out,
            view,
            door.position,
            class,
            shape,
            &format!("door: {}", door.address),
        );
    }
    for door in episode
        .found_doors
        .iter()
        .filter(|d| view.shows(&[d.position]))
    {
        mark(
            out,
            view,
            door.position,
            "found",
            FOUND,
            &format!("written by the agent: {}", door.address),
        );
    }
    if !episode.driven.is_empty() {
        mark(out, view, episode.start.point(), "start", START, "start");
    }
    episode
        .declared
        .iter()
        .for_each(|d| declaration(out, view, d));
    // Labels last, above all marks.
    let mut labels = Labels::default();
    episode
        .true_doors
        .iter()
        .filter(|d| d.wanted)
        .for_each(|d| labels.door(out, view, d));
}

const START: &str = "<circle r=\"7\"/><circle class=\"inner\" r=\"2.5\"/>";
const DOOR: &str = "<rect x=\"-3\" y=\"-3\" width=\"6\" height=\"6\"/>";
const WANTED: &str = "<rect x=\"-5\" y=\"-5\" width=\"10\" height=\"10\"/>";
const FOUND: &str = "<path d=\"M0 -9L9 0L0 9L-9 0Z\"/>";
const COLLISION: &str = "<path d=\"M-5 -5L5 5M-5 5L5 -5\"/>";
const DECLARED: &str = "<circle r=\"9\"/>";

fn mark(out: &mut String, view: &View, at: MapPoint, class: &str, shape: &str, title: &str) {
    let [x, y] = view.pixel(at);
    if x.is_finite() && y.is_finite() {
        let _ = writeln!(
            out,
            "<g class=\"{class}\" transform=\"translate({x:.1} {y:.1})\">\
             <title>{}</title>{shape}</g>",
            escape(title)
        );
    }
}

fn declaration(out: &mut String, view: &View, declared: &Declaration) {
    let class = if declared.success {
        "declared"
    } else {
        "declared missed"
    };
    let shape = format!("{DECLARED}<text y=\"4\">{}</text>", declared.task);
    let title = format!("delivery {} declared: {}", declared.task, declared.address);
    mark(out, view, declared.position, class, &shape, &title);
}

/// Labels of doors. Each is drawn at the first position beside its door where it overlaps no
/// earlier label, or not at all.
#[derive(Default)]
struct Labels {
    taken: Vec<LabelBox>,
}

/// The place of a label in the picture, pixels.
#[derive(Clone, Copy)]
struct LabelBox {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl LabelBox {
    fn is_inside(&self, view: &View) -> bool {
        let is_wide_enough = self.left >= 0.0 && self.right <= WIDTH_PX;
        is_wide_enough && self.top >= 0.0 && self.bottom <= view.height
    }

    fn overlaps(&self, other: &Self) -> bool {
        let in_x = self.left < other.right && other.left < self.right;
        in_x && self.top < other.bottom && other.top < self.bottom
    }
}

impl Labels {
    fn door(&mut self, out: &mut String, view: &View, door: &DoorMark) {
        let [x, y] = view.pixel(door.position);
        // The unit alone, since the building carries its name on the map.
        let text = door
            .address
            .unit
            .as_deref()
            .unwrap_or(&door.address.building);
        let width = text_width(text);
        // Right, left, above, below.
        let places = [
            (14.0, 4.0),
            (-14.0 - width, 4.0),
            (-width / 2.0, -16.0),
            (-width / 2.0, 24.0),
        ];
        // A line of text reaches about 12 px above its baseline and 4 px below it.
        let boxes = places.map(|(dx, dy)| LabelBox {
            left: x + dx,
            top: y + dy - 12.0,
            right: x + dx + width,
            bottom: y + dy + 4.0,
        });
        let free = boxes
            .iter()
            .filter(|label| label.is_inside(view))
            .find(|label| !self.taken.iter().any(|taken| taken.overlaps(label)));
        if let Some(b) = free {
            let (x, y) = (b.left, b.top + 12.0);
            let _ = writeln!(
                out,
                "<text class=\"label\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>",
                escape(text)
            );
            self.taken.push(*b);
        }
    }
}

/// Approximate width of a label in pixels; East Asian characters are about twice as wide.
fn text_width(text: &str) -> f64 {
    text.chars()
        .map(|c| if c < '\u{1100}' { 7.0 } else { 13.0 })
        .sum()
}

/// A scale bar of a round number of metres, at most a seventh of the width.
fn scale_bar(out: &mut String, view: &View) {
    let target = WIDTH_PX / 7.0 / view.pixels_per_metre;
    let round = [
        1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0,
    ];
    let metres = round.into_iter().rfind(|m| *m <= target).unwrap_or(1.0);
    let length = metres * view.pixels_per_metre;
    let (x, y) = (20.0, view.height - 18.0);
    let _ = writeln!(
        out,
        "<g class=\"scale-bar\"><rect class=\"back\" x=\"{bx:.1}\" y=\"{by:.1}\" \
         width=\"{bw:.1}\" height=\"32\" rx=\"3\"/>\
         <path d=\"M{x} {y0:.1}V{y:.1}H{x1:.1}V{y0:.1}\"/>\
         <text x=\"{xm:.1}\" y=\"{yt:.1}\">{metres:.0} m</text></g>",
        bx = x - 8.0,
        by = y - 22.0,
        bw = length + 16.0,
        y0 = y - 5.0,
        x1 = x + length,
        xm = x + length / 2.0,
        yt = y - 7.0,
    );
}

fn north_arrow(out: &mut String) {
    let x = WIDTH_PX - 28.0;
    let _ = writeln!(
        out,
        "<g class=\"north\" transform=\"translate({x:.0} 34)\"><circle r=\"18\"/>\
         <path d=\"M0 -13L5 4L0 1L-5 4Z\"/><text y=\"14\">N</text></g>"
    );
}

/// The line of a path in the legend.
fn line(class: &str) -> String {
    format!("<path class=\"{class}\" d=\"M1 10H27\"/>")
}

/// The sign of a mark in the legend.
fn sign(class: &str, shape: &str) -> String {
    format!("<g class=\"{class}\" transform=\"translate(14 10)\">{shape}</g>")
}

/// Explains what the maps of the episodes have, and nothing else.
pub fn legend(out: &mut String, episodes: &[EpisodeReport]) {
    let any = |has: fn(&EpisodeReport) -> bool| episodes.iter().any(has);
    let entries = [
        (any(|e| !e.driven.is_empty()), sign("start", START), "start"),
        (any(|e| !e.driven.is_empty()), line("driven"), "driven"),
        (
            any(|e| !e.estimated.is_empty()),
            line("estimated"),
            "estimated by the agent",
        ),
        (
            any(|e| !e.routes.is_empty()),
            line("route"),
            "planned route",
        ),
        (
            any(|e| e.true_doors.iter().any(|d| d.wanted)),
            sign("door wanted", WANTED),
            "door to deliver to",
        ),
        (
            any(|e| e.true_doors.iter().any(|d| !d.wanted)),
            sign("door", DOOR),
            "other door",
        ),
        (
            any(|e| !e.found_doors.is_empty()),
            sign("found", FOUND),
            "door written by the agent",
        ),
        (
            any(|e| e.declared.iter().any(|d| d.success)),
            sign("declared", DECLARED),
            "delivered",
        ),
        (
            any(|e| e.declared.iter().any(|d| !d.success)),
            sign("declared missed", DECLARED),
            "declared at the wrong place",
        ),
        (
            any(|e| !e.collisions.is_empty()),
            sign("collision", COLLISION),
            "collision",
        ),
    ];
    out.push_str("<ul class=\"legend\">\n");
    for (_, drawing, words) in entries.into_iter().filter(|(present, ..)| *present) {
        let _ = writeln!(
            out,
            "<li><svg viewBox=\"0 0 28 20\" aria-hidden=\"true\">{drawing}</svg>{words}</li>"
        );
    }
    out.push_str("</ul>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::Pose2;

    fn episode() -> EpisodeReport {
        EpisodeReport {
            start: Pose2::new(0.0, 0.0, 0.0),
            driven: (0..1000)
                .map(|i| MapPoint::new(f64::from(i) * 0.02, 0.0))
                .collect(),
            ..EpisodeReport::default()
        }
    }

    #[test]
    fn north_is_up_and_east_is_right() {
        let view = View::around(&WorldMap::default(), &episode()).unwrap();
        let [x, y] = view.pixel(MapPoint::new(10.0, 0.0));
        assert!(
            (x - WIDTH_PX / 2.0).abs() < 0.5 && (y - view.height / 2.0).abs() < 0.5,
            "{x} {y}"
        );
        assert!(
            view.pixel(MapPoint::new(10.0, 1.0))[1] < y
                && view.pixel(MapPoint::new(11.0, 0.0))[0] > x
        );
    }

    #[test]
    fn paths_are_downsampled_to_the_resolution_of_the_picture() {
        let view = View::around(&WorldMap::default(), &episode()).unwrap();
        let line = view.line(&episode().driven);
        assert!(
            line.matches('L').count() < 700,
            "{}",
            line.matches('L').count()
        );
        assert_eq!(view.line(&[MapPoint::default()]), "");
    }

    #[test]
    fn nan_and_infinity_are_left_out() {
        let mut broken = episode();
        broken.driven.push(MapPoint::new(f64::NAN, 1.0));
        broken.collisions.push(MapPoint::new(f64::INFINITY, 0.0));
        let mut out = String::new();
        render(&mut out, &WorldMap::default(), &broken);
        assert!(out.contains("class=\"driven\"") && !out.contains("NaN") && !out.contains("inf"));
    }

    #[test]
    fn buildings_outside_the_view_are_not_drawn() {
        let outline = [(5e3, 0.0), (5e3, 9.0), (5.1e3, 9.0)]
            .map(|(x, y)| MapPoint::new(x, y))
            .to_vec();
        let area = MapArea {
            name: Some("far".into()),
            outline,
            holes: vec![],
        };
        let mut out = String::new();
        render(
            &mut out,
            &WorldMap {
                buildings: vec![area],
                ..WorldMap::default()
            },
            &episode(),
        );
        assert!(!out.contains("class=\"building\"") && !out.contains("far"));
        out.clear();
        render(&mut out, &WorldMap::default(), &EpisodeReport::default());
        assert_eq!(out, "");
    }
}
