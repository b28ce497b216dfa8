//! Bands around obstacles, one of each homotopy class, as a picture:
//!
//!     cargo run --release -p openbench-motion --example bands > docs/bands.svg
//!
//! The robot comes from the left. Each colour is a homotopy class. The thick band is the one that
//! is driven; footprints show the robot along it every half second.

#![expect(
    clippy::print_stdout,
    reason = "the picture is what the example is for"
)]

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::trajectory::Trajectory;
use openbench_motion::{LocalPlanner, Obstacle, Situation, Teb, TebSettings, Vector2};

/// Cycles of 50 ms, standing, until the bands of all classes are optimized.
const CYCLES: u64 = 20;
const COLORS: [&str; 5] = ["#2b6cb0", "#c05621", "#2f855a", "#6b46c1", "#b7791f"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = RobotDescription::sentry();
    let at = MapPoint::new;
    let block = [at(1.9, 0.35), at(2.5, 0.2), at(2.6, 0.7), at(2.1, 0.9)];
    let obstacles = [
        Obstacle::disc(at(1.2, -0.15), 0.25)?,
        Obstacle::new(&block, 0.0, Vector2::ZERO)?,
        Obstacle::disc(at(2.7, -0.6), 0.3)?,
        Obstacle::wall(at(1.5, -1.4), at(2.2, -1.2))?,
    ];
    let mut teb = Teb::new(&robot, TebSettings::default())?;
    let path = [at(0.0, 0.0), at(4.0, 0.0)];
    for cycle in 0..CYCLES {
        let situation = Situation {
            time: SimTime::ZERO + std::time::Duration::from_millis(50 * cycle),
            pose: Pose2::default(),
            velocity: Velocity::ZERO,
            path: &path,
            final_yaw: Some(0.0),
            obstacles: &obstacles,
        };
        teb.plan(&situation)?;
    }
    println!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-0.5 -1.7 5 3.4\" width=\"1000\">"
    );
    println!("<rect x=\"-0.5\" y=\"-1.7\" width=\"5\" height=\"3.4\" fill=\"#fff\"/>");
    println!(
        "<g transform=\"scale(1,-1)\" fill=\"none\" \
         stroke-linecap=\"round\" stroke-linejoin=\"round\">"
    );
    obstacles.iter().for_each(draw_obstacle);
    for (i, candidate) in teb.candidates().iter().enumerate().rev() {
        draw_band(
            &candidate.band,
            COLORS[i % COLORS.len()],
            if i == 0 { 0.05 } else { 0.02 },
        );
    }
    if let Some(driven) = teb.candidates().first() {
        let steps = (driven.band.duration() / 0.5) as usize;
        (0..=steps).for_each(|i| draw_robot(&robot, driven.band.pose_at(0.5 * i as f64)));
    }
    println!("</g>");
    for (i, candidate) in teb.candidates().iter().enumerate() {
        let (y, color) = (-1.5 + 0.14 * i as f64, COLORS[i % COLORS.len()]);
        let seconds = candidate.band.duration();
        let driven = if i == 0 { ", driven" } else { "" };
        println!(
            "<text x=\"-0.4\" y=\"{y:.2}\" font-family=\"sans-serif\" font-size=\"0.11\" \
             fill=\"{color}\">{seconds:.1} s{driven}</text>"
        );
    }
    println!("</svg>");
    Ok(())
}

fn draw_obstacle(obstacle: &Obstacle) {
    let (corners, rounding) = (obstacle.corners(), obstacle.rounding());
    let points: Vec<String> = corners.map(|c| format!("{:.3},{:.3}", c.x, c.y)).collect();
    let (points, width) = (points.join(" "), (2.0 * rounding).max(0.03));
    // A polyline of one point would not show.
    let first = points.split(' ').next().unwrap_or_default();
    println!(
        "<polygon points=\"{points} {first}\" fill=\"#a0aec0\" stroke=\"#a0aec0\" \
         stroke-width=\"{width:.3}\"/>"
    );
}

fn draw_band(band: &Trajectory, color: &str, width: f64) {
    let steps = (band.duration() / 0.05) as usize;
    let place = |i: usize| band.pose_at(0.05 * i as f64);
    let points: Vec<String> = (0..=steps)
        .map(place)
        .map(|p| format!("{:.3},{:.3}", p.x, p.y))
        .collect();
    println!(
        "<polyline points=\"{}\" stroke=\"{color}\" stroke-width=\"{width}\"/>",
        points.join(" ")
    );
}

fn draw_robot(robot: &RobotDescription, pose: Pose2) {
    let (x, y) = (robot.length / 2.0, robot.width / 2.0);
    let corners = [(x, -y), (x, y), (-x, y), (-x, -y)].map(|(x, y)| pose.transform(x, y));
    let points: Vec<String> = corners
        .iter()
        .map(|c| format!("{:.3},{:.3}", c.x, c.y))
        .collect();
    println!(
        "<polygon points=\"{}\" stroke=\"{}\" stroke-width=\"0.01\"/>",
        points.join(" "),
        COLORS[0]
    );
}
