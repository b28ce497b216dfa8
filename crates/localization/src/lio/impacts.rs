//! IMU readings that a robot on wheels cannot cause by driving: an impact shook the IMU.
//!
//! Of such an instant only the wheels' velocity is known.

use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::{Pose3, SimTime};

use super::noise::{UNMEASURED_ACCEL, UNMEASURED_GYRO};
use super::propagation::Reading;
use super::speed::Speed;
use super::state::State;

/// Turn rates of gyroscope and wheels, which come a twentieth of a second late, differ by no more
/// than this whatever the motors do, and no robot on wheels tumbles faster, rad/s.
const MAX_DIFFERENCE_RAD_S: f64 = 2.0;
/// The same while the wheels are steady, rad/s.
const MAX_STEADY_DIFFERENCE_RAD_S: f64 = 0.6;
/// No robot on wheels accelerates or brakes harder, kerbs included, m/s².
const MAX_ACCELERATION_M_S2: f64 = 4.0;
/// How long an impact lasts, seconds.
const IMPACT_S: f64 = 0.03;
/// The wheels' velocity is a mean over some time, and comes after it.
const WHEEL_DELAY: Duration = Duration::from_millis(100);

/// An impact that changed the velocity.
#[derive(Debug, Clone, Copy)]
struct Impact {
    stamp: SimTime,
    /// Noise density of the specific force then, m/s²/√Hz.
    accel_noise: f64,
}

/// Replaces impossible readings, step by step along a prediction.
#[derive(Debug, Default)]
pub(super) struct ImpactFilter {
    last: Option<Impact>,
}

/// What the wheels report at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct WheelReport<'a> {
    pub(super) speed: &'a Speed,
    /// Whether the velocity after this one is nearly the same: then an impact moved nothing.
    pub(super) is_steady: bool,
}

impl ImpactFilter {
    /// Replaces what is impossible in a reading at `stamp`. `imu` is the IMU's pose on the robot.
    pub(super) fn apply(
        &mut self,
        reading: &mut Reading,
        stamp: SimTime,
        state: &State,
        wheels: WheelReport<'_>,
        imu: &Pose3,
    ) {
        replace_turn(reading, state, wheels, imu);
        replace_force(reading, state, wheels);
        // Wheels that an impact stopped report it a little later.
        if reading.noise.accel > UNMEASURED_ACCEL {
            self.last = Some(Impact {
                stamp,
                accel_noise: reading.noise.accel,
            });
        } else if let Some(impact) = self.last
            && stamp.since(impact.stamp) < WHEEL_DELAY
        {
            reading.noise.accel = impact.accel_noise;
        }
    }
}

/// Whether a turn rate, in the robot's frame, is one that the wheels did not cause.
pub(super) fn is_shaken(rate: &Vector3<f64>, wheels: WheelReport<'_>) -> bool {
    let most = if wheels.is_steady {
        MAX_STEADY_DIFFERENCE_RAD_S
    } else {
        MAX_DIFFERENCE_RAD_S
    };
    (rate.z - wheels.speed.turn).abs() > most || rate.xy().norm() > most
}

/// Takes the turn rate from the wheels where the gyroscope is shaken.
fn replace_turn(reading: &mut Reading, state: &State, wheels: WheelReport<'_>, imu: &Pose3) {
    let rate = imu.rotation * (reading.gyro - state.gyro_bias);
    if is_shaken(&rate, wheels) {
        let turn = imu.rotation.inverse() * (Vector3::z() * wheels.speed.turn);
        // With the bias, since the prediction subtracts it from every reading.
        reading.gyro = turn + state.gyro_bias;
        reading.noise.gyro = UNMEASURED_GYRO;
    }
}

/// Where the specific force is impossible: takes the one at rest if the wheels stay steady.
/// Otherwise the velocity may have changed by as much as the force says, or not at all.
fn replace_force(reading: &mut Reading, state: &State, wheels: WheelReport<'_>) {
    let excess = (reading.accel.norm() - state.gravity.norm()).abs();
    if excess > MAX_ACCELERATION_M_S2 {
        if wheels.is_steady {
            let at_rest = -(state.rotation.inverse() * state.gravity);
            reading.accel = at_rest + state.accel_bias;
            reading.noise.accel = UNMEASURED_ACCEL;
        } else {
            // Over an impact this density gives the velocity a deviation of excess * IMPACT_S. That
            // is all that the force can have changed.
            reading.noise.accel = UNMEASURED_ACCEL.max(excess * IMPACT_S.sqrt());
        }
    }
}
