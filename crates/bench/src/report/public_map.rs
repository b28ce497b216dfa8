//! A wrong public map over the world, as SVG, north up.

use std::fmt::Write;

use openbench_core::MapPoint;
use openbench_geometry::Polygon;
use openbench_osm::OsmMap;
use openbench_osm::disturb::MapState;

use super::html::escape;
use crate::worlds::Prepared;

/// Longer side of the drawing.
const SIDE_PX: f64 = 1200.0;
/// Height of the legend below it.
const LEGEND_PX: f64 = 40.0;
/// Margin around the buildings.
const MARGIN_M: f64 = 10.0;

const STYLE: &str = "\
.ground{fill:#f7f5f0}.road{fill:none;stroke:#dcd8cf;stroke-width:5}\
.true{fill:#c9c4ba}.missing{fill:#e8b4a8}.public{fill:none;stroke:#1f5fa8;stroke-width:1.6}\
.invented{fill:#f0dc9a;stroke:#b07d10;stroke-width:1.6}\
.public-road{fill:none;stroke:#1f5fa8;stroke-width:.8;stroke-dasharray:5 3}\
.door{fill:#222}text{font:11px sans-serif;text-anchor:middle;fill:#444}.wrong{fill:#b3261e}\
.legend{text-anchor:start;font-size:14px}";

/// The world in grey, and the public map of its suite in blue; `None` without buildings.
pub fn public_map_svg(prepared: &Prepared) -> Option<String> {
    // Both in the world's frame, in which the doors are.
    let truth = prepared.true_map();
    let public = &OsmMap::new(prepared.public_data(), prepared.world.georeference);
    let view = View::of(truth, public)?;
    let mut svg = String::new();
    let _ = write!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w:.0} {h:.0}\">\n\
         <style>{STYLE}</style>\n<rect class=\"ground\" width=\"{w:.0}\" height=\"{h:.0}\"/>\n",
        w = view.width,
        h = view.height + LEGEND_PX,
    );
    let on_map = prepared.on_map();
    for road in &truth.roads {
        view.line(&mut svg, "road", &road.points);
    }
    for building in &truth.buildings {
        let state = on_map.state(Some(building.element));
        let class = if state == MapState::Missing {
            "missing"
        } else {
            "true"
        };
        view.polygon(&mut svg, class, &building.polygon);
    }
    for outline in on_map.invented() {
        view.polygon(&mut svg, "invented", outline);
    }
    for road in &public.roads {
        view.line(&mut svg, "public-road", &road.points);
    }
    for building in &public.buildings {
        view.polygon(&mut svg, "public", &building.polygon);
    }
    for building in &truth.buildings {
        let name = building.name.as_deref().unwrap_or_default();
        let class = match on_map.state(Some(building.element)) {
            MapState::Right => "",
            _ => "wrong",
        };
        view.text(&mut svg, class, building.polygon.centroid(), name);
    }
    for door in &prepared.world.scene.doors {
        view.dot(&mut svg, "door", door.entrance().point());
    }
    legend(&mut svg, view.height);
    svg.push_str("</svg>\n");
    Some(svg)
}

fn legend(svg: &mut String, top: f64) {
    // Roads lead out of the picture, and would cross the words.
    let _ = writeln!(
        svg,
        "<rect class=\"ground\" y=\"{top:.0}\" width=\"100%\" height=\"{LEGEND_PX}\"/>"
    );
    let entries = [
        ("true", "the world"),
        ("missing", "missing in the map"),
        ("public", "public map"),
        ("invented", "only in the map"),
        ("door", "door"),
    ];
    let mut left = 10.0;
    for (class, words) in entries {
        let _ = writeln!(
            svg,
            "<rect class=\"{class}\" x=\"{left:.0}\" y=\"{:.0}\" width=\"16\" height=\"16\"/>\
             <text class=\"legend\" x=\"{:.0}\" y=\"{:.0}\">{words}</text>",
            top + 12.0,
            left + 22.0,
            top + 25.0,
        );
        left += 190.0;
    }
    let _ = writeln!(
        svg,
        "<text class=\"legend wrong\" x=\"{left:.0}\" y=\"{:.0}\">misnamed or missing</text>",
        top + 25.0
    );
}

/// What is drawn, and how large.
struct View {
    left: f64,
    top: f64,
    scale: f64,
    width: f64,
    height: f64,
}

impl View {
    fn of(truth: &OsmMap, public: &OsmMap) -> Option<Self> {
        let buildings = truth.buildings.iter().chain(&public.buildings);
        let bounds = buildings.map(|b| b.polygon.bounds());
        let bounds = bounds.reduce(|a, b| a.union(b))?.grown(MARGIN_M);
        let (width, height) = (bounds.high.x - bounds.low.x, bounds.high.y - bounds.low.y);
        let scale = SIDE_PX / width.max(height);
        Some(Self {
            left: bounds.low.x,
            top: bounds.high.y,
            scale,
            width: width * scale,
            height: height * scale,
        })
    }

    fn pixel(&self, at: MapPoint) -> [f64; 2] {
        // The y axis of SVG points down, that of the map to the north.
        [
            (at.x - self.left) * self.scale,
            (self.top - at.y) * self.scale,
        ]
    }

    fn commands(&self, points: &[MapPoint]) -> String {
        let pixels = points.iter().map(|at| self.pixel(*at));
        let words: Vec<String> = pixels.map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        format!("M{}", words.join("L"))
    }

    fn line(&self, svg: &mut String, class: &str, points: &[MapPoint]) {
        let _ = writeln!(
            svg,
            "<path class=\"{class}\" d=\"{}\"/>",
            self.commands(points)
        );
    }

    fn polygon(&self, svg: &mut String, class: &str, polygon: &Polygon) {
        let rings: String = polygon
            .rings()
            .map(|ring| self.commands(ring) + "Z")
            .collect();
        let _ = writeln!(
            svg,
            "<path class=\"{class}\" fill-rule=\"evenodd\" d=\"{rings}\"/>"
        );
    }

    fn text(&self, svg: &mut String, class: &str, at: MapPoint, words: &str) {
        let [x, y] = self.pixel(at);
        let words = escape(words);
        let _ = writeln!(
            svg,
            "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{words}</text>"
        );
    }

    fn dot(&self, svg: &mut String, class: &str, at: MapPoint) {
        let [x, y] = self.pixel(at);
        let _ = writeln!(
            svg,
            "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.2\"/>"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::builtin_suite;

    #[test]
    fn both_maps_are_drawn_and_what_is_missing_is_marked() {
        let mut suite = builtin_suite("medium").unwrap();
        suite.conditions.set("map", "poor").unwrap();
        let prepared = Prepared::new(suite.with_seed(3), None).unwrap();
        let drawn = prepared.on_map().drawn().unwrap();
        let svg = public_map_svg(&prepared).unwrap();
        let count = |class: &str| svg.matches(&format!("<path class=\"{class}\"")).count();
        assert_eq!(count("missing"), drawn.missing);
        assert_eq!(count("true"), drawn.buildings - drawn.missing);
        assert_eq!(count("invented"), drawn.invented);
        assert_eq!(count("public"), prepared.public_map().buildings.len());
        assert!(drawn.missing > 0 && svg.contains(">building1<"));
    }
}
