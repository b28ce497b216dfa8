//! A drive through a scene as an SVG picture.

use std::fmt::Write as _;

use openbench_core::{MapPoint, Pose2, RobotDescription};
use openbench_motion::{Obstacle, Vector2};

use super::drive::Drive;
use super::scene::Scene;

/// Margin around the drive.
const MARGIN_M: f64 = 1.5;
/// The footprint is drawn once in so many decisions.
const FOOTPRINT_STRIDE: usize = 10;

/// Draws the scene at the start, the footprint along the drive (blue), at the start (green) and at
/// the goal (red).
pub fn picture(scene: &Scene, drive: &Drive, robot: &RobotDescription) -> String {
    let places = drive
        .track
        .iter()
        .map(|p| p.point())
        .chain([scene.start.point(), scene.goal.point()]);
    let (mut low, mut high) = (scene.start.point(), scene.start.point());
    for p in places {
        low = MapPoint::new(low.x.min(p.x), low.y.min(p.y));
        high = MapPoint::new(high.x.max(p.x), high.y.max(p.y));
    }
    // The group below turns y upwards, so the view box has the negative of the map's y.
    let (x, y) = (low.x - MARGIN_M, -high.y - MARGIN_M);
    let (width, height) = (
        high.x - low.x + 2.0 * MARGIN_M,
        high.y - low.y + 2.0 * MARGIN_M,
    );
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" \
         viewBox=\"{x:.3} {y:.3} {width:.3} {height:.3}\" width=\"800\">\n\
         <rect x=\"{x:.3}\" y=\"{y:.3}\" width=\"{width:.3}\" height=\"{height:.3}\" \
         fill=\"#fff\"/>\n\
         <g transform=\"scale(1,-1)\" stroke-width=\"0.02\" fill=\"none\">\n"
    );
    scene.obstacles.iter().for_each(|o| obstacle(&mut svg, o));
    for pose in drive.track.iter().step_by(FOOTPRINT_STRIDE) {
        outline(&mut svg, robot, *pose, "#2b6cb0");
    }
    outline(&mut svg, robot, scene.start, "#2f855a");
    outline(&mut svg, robot, scene.goal, "#c53030");
    // The outline alone does not show where the front is.
    let nose = scene.goal.transform(robot.length / 2.0, 0.0);
    let _ = writeln!(
        svg,
        "<circle cx=\"{:.3}\" cy=\"{:.3}\" r=\"0.04\" fill=\"#c53030\"/>",
        nose.x, nose.y
    );
    svg.push_str("</g>\n</svg>\n");
    svg
}

fn obstacle(svg: &mut String, obstacle: &Obstacle) {
    let (corners, rounding) = (obstacle.corners(), obstacle.rounding());
    let color = if obstacle.is_moving() {
        "#dd6b20"
    } else {
        "#a0aec0"
    };
    let corners: Vec<MapPoint> = corners.collect();
    // Half of a stroke's width lies outside the polygon: it widens the polygon by the rounding.
    let width = (2.0 * rounding).max(0.02);
    if let [middle] = corners[..] {
        let (x, y) = (middle.x, middle.y);
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{rounding:.3}\" fill=\"{color}\"/>"
        );
        // The line is the distance covered in a second.
        let Vector2 { x: vx, y: vy } = obstacle.velocity();
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.3} {y:.3}l{vx:.3} {vy:.3}\" stroke=\"{color}\"/>"
        );
    } else {
        polygon(
            svg,
            &corners,
            &format!("fill=\"{color}\" stroke=\"{color}\" stroke-width=\"{width:.3}\""),
        );
    }
}

fn outline(svg: &mut String, robot: &RobotDescription, pose: Pose2, color: &str) {
    let (x, y) = (robot.length / 2.0, robot.width / 2.0);
    let corners = [(x, -y), (x, y), (-x, y), (-x, -y)].map(|(x, y)| pose.transform(x, y));
    polygon(svg, &corners, &format!("stroke=\"{color}\""));
}

fn polygon(svg: &mut String, corners: &[MapPoint], style: &str) {
    let points: Vec<String> = corners
        .iter()
        .map(|c| format!("{:.3},{:.3}", c.x, c.y))
        .collect();
    let _ = writeln!(svg, "<polygon points=\"{}\" {style}/>", points.join(" "));
}
