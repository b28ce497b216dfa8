//! What the kinds of work of OPEN cost on this machine: the table that `compute=charged` follows.
//!
//! ```text
//! cargo run --release -p openbench-trials --example work -- [SUITE] [EPISODES]
//! ```
//!
//! Each decision of an agent takes processor time and reports the work that was done for it. The
//! cost of each kind is the least squares solution over all decisions, without the time in which
//! images are rendered. Registration and mapping come with each scan and cannot be told apart, nor
//! can local planning and what else a decision costs, so each two share one figure.
#![expect(clippy::print_stdout, reason = "an example prints its output")]

use std::cell::Cell;
use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use cpu_time::ProcessTime;
use nalgebra::{Matrix5, Vector5};
use openbench_agents::Open;
use openbench_agents::open::{Catalogue, Models, Settings};
use openbench_bench::run::run_episode;
use openbench_bench::worlds::suite_named;
use openbench_bench::{Prepared, Rollout};
use openbench_core::{
    Action, Agent, Briefing, Camera, Event, Events, GiveUp, Image, Observation, Work,
};

/// What can be told apart.
const UNKNOWNS: [&str; 5] = [
    "scan: registration and mapping",
    "path search",
    "reading",
    "registration to the map",
    "decision: local plan and the rest",
];

/// The place of a kind of work among those; `None` for what every decision has.
fn place(work: Work) -> Option<usize> {
    match work {
        Work::Registration => Some(0),
        Work::PathSearch => Some(1),
        Work::Reading => Some(2),
        Work::MapRegistration | Work::MapSearch => Some(3),
        Work::Mapping | Work::LocalPlan => None,
    }
}

/// A camera that keeps the time for its images.
struct Stopwatch<'a> {
    camera: &'a dyn Camera,
    spent: Cell<Duration>,
}

impl Camera for Stopwatch<'_> {
    fn image(&self) -> Option<Arc<Image>> {
        let began = ProcessTime::now();
        let image = self.camera.image();
        self.spent.set(self.spent.get() + began.elapsed());
        image
    }
}

/// An agent whose decisions are timed.
struct Timed<'a> {
    agent: Open,
    sums: &'a mut Sums,
}

/// The normal equations of the least squares problem.
#[derive(Default)]
struct Sums {
    matrix: Matrix5<f64>,
    right: Vector5<f64>,
    counts: [u32; UNKNOWNS.len()],
    seconds: f64,
}

impl Sums {
    fn add(&mut self, events: &[Event], seconds: f64) {
        let mut row = Vector5::new(0.0, 0.0, 0.0, 0.0, 1.0);
        self.counts[UNKNOWNS.len() - 1] += 1;
        for event in events {
            if let Event::Work(work) = event
                && let Some(place) = place(*work)
            {
                row[place] += 1.0;
                self.counts[place] += 1;
            }
        }
        self.matrix += row * row.transpose();
        self.right += row * seconds;
        self.seconds += seconds;
    }
}

impl Agent for Timed<'_> {
    fn begin(&mut self, briefing: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp> {
        self.agent.begin(briefing, events)
    }

    fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action {
        let camera = Stopwatch {
            camera: observation.camera,
            spent: Cell::default(),
        };
        let mut reported = Vec::new();
        let began = ProcessTime::now();
        let seen = Observation {
            camera: &camera,
            ..*observation
        };
        let action = self.agent.act(&seen, &mut reported);
        let seconds = (began.elapsed() - camera.spent.get()).as_secs_f64();
        self.sums.add(&reported, seconds);
        reported.into_iter().for_each(|event| events.record(event));
        action
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let suite = words.first().map_or("medium", String::as_str);
    let episodes = words.get(1).map_or(Ok(4), |count| count.parse())?;
    let prepared = Prepared::new(suite_named(suite)?, None)?;
    let mut sums = Sums::default();
    for number in 0..prepared.episodes.len().min(episodes) {
        let settings = Settings::default();
        let mut models = Models::new(settings.budget, Default::default());
        let parts = Catalogue::default().assemble(&settings, &mut models, None)?;
        let mut agent = Timed {
            agent: Open::new(parts),
            sums: &mut sums,
        };
        run_episode(Rollout::new(&prepared, number, 1)?, &mut agent)?;
    }
    let solution = sums.matrix.pseudo_inverse(1e-9)? * sums.right;
    println!("{:<36} {:>6} {:>8}", "work", "times", "ms each");
    for (place, words) in UNKNOWNS.iter().enumerate() {
        let (times, ms) = (sums.counts[place], 1e3 * solution[place]);
        println!("{words:<36} {times:>6} {ms:>8.2}");
    }
    println!("{:.1} s of processor time in all", sums.seconds);
    Ok(())
}
