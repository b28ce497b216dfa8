//! What chance achieves.

use std::time::Duration;

use openbench_core::{
    Action, Address, Agent, Briefing, Events, FailureCause, GiveUp, Observation, RobotDescription,
    SimTime, Velocity,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::errands::{Errands, give_up};
use crate::run::truth::Truth;

/// Shortest and longest time for which a velocity is kept, seconds.
const LEG_S: [f64; 2] = [1.0, 8.0];

/// Drives with random velocities and declares each delivery at a random time of the episode.
pub(super) struct Random {
    addresses: Vec<Address>,
    robot: RobotDescription,
    random: Pcg32,
    /// The judge's limit: who declares later does not declare at all.
    time_limit: Duration,
    /// What is declared when, the last one first.
    declarations: Vec<(SimTime, Address)>,
    velocity: Velocity,
    changes_at: SimTime,
}

impl Random {
    /// For an episode.
    pub(super) fn new(truth: &Truth<'_>, seed: u64) -> Self {
        Self {
            addresses: Errands::of(truth).addresses(),
            robot: truth.prepared.robot.clone(),
            random: Pcg32::seed_from_u64(seed),
            time_limit: truth.prepared.episodes[truth.episode].time_limit,
            declarations: Vec::new(),
            velocity: Velocity::ZERO,
            changes_at: SimTime::ZERO,
        }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.random.random::<f64>() * (high - low)
    }

    fn turn_elsewhere(&mut self, now: SimTime) {
        let linear = self.between(0.0, self.robot.max_forward);
        // Half of the time straight ahead, since one who keeps turning gets nowhere.
        let is_straight = self.random.next_u32().is_multiple_of(2);
        let turn = self.between(-self.robot.max_turn, self.robot.max_turn);
        self.velocity = Velocity::new(linear, if is_straight { 0.0 } else { turn });
        let kept = self.between(LEG_S[0], LEG_S[1]);
        self.changes_at = now + Duration::from_secs_f64(kept);
    }
}

impl Agent for Random {
    fn begin(&mut self, _: &Briefing, _: &mut dyn Events) -> Result<(), GiveUp> {
        let all = self.time_limit.as_secs_f64();
        for address in self.addresses.clone() {
            let at = SimTime::ZERO + Duration::from_secs_f64(self.between(0.0, all));
            self.declarations.push((at, address));
        }
        self.declarations
            .sort_by_key(|(at, _)| std::cmp::Reverse(*at));
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _: &mut dyn Events) -> Action {
        let now = observation.time;
        let Some((at, _)) = self.declarations.last() else {
            return give_up(None, FailureCause::NotDeclared, "no parcel is left");
        };
        if *at <= now
            && let Some((_, address)) = self.declarations.pop()
        {
            return Action::Delivered(address);
        }
        if self.changes_at <= now {
            self.turn_elsewhere(now);
        }
        Action::Drive(self.velocity)
    }
}
